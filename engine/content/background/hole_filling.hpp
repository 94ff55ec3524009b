#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/content/background/background_model.hpp"
#include "engine/frame/raw_frame.hpp"

namespace touchable {

/// Gives holes of a frame the depth that is behind, where what is seen there is what is behind:
/// - its colour is that which the pixel had with that depth, and so is that of most pixels beside it; where
///   there is no colour or it cannot tell, the hole is narrow in its row or column and has what is behind at
///   an end of that;
/// - and of the depths around such pixels, as far as they touch, no more than four times as many are nearer
///   than what is behind as are what is behind: a hole inside a hand is the hand's.
class HoleFilling {
public:
    explicit HoleFilling(const CodedDepth& depth) : depth_(depth) {}
    /// Replaces the frame's depth plane and says in `filled` which pixels; the frame as it was where there
    /// are none.
    void fill(RawFrame& frame, const Background& background);
    /// Of the last frame.
    std::int64_t holes() const { return static_cast<std::int64_t>(holes_.size()); }
    std::int64_t filled() const { return filled_; }

private:
    enum class Place : std::uint8_t {
        other,      // depth that is neither, or is not known
        behind,     // depth of what is behind
        nearer,     // of something before it
        hole,       // which stays one
        candidate,  // hole to be filled, unless what is around says no
        looked_at   // candidate whose surroundings are known
    };
    void find_places(const PlaneView& codes, const Background& background);
    bool is_coloured_as_behind(const PlaneView& colour, const Background& background,
                               std::size_t pixel) const;
    void find_candidates(const PlaneView& colour, const Background& background);
    bool is_beside_what_is_behind(std::size_t pixel) const;
    bool has_end_behind(std::size_t pixel, std::ptrdiff_t step, int place, int places) const;
    void leave_those_of_nearer_things();
    void write(RawFrame& frame, const Background& background);

    const CodedDepth& depth_;
    int width_ = 0, height_ = 0;
    std::vector<Place> places_;
    std::vector<std::size_t> holes_, fills_, group_;
    std::vector<std::uint16_t> hue_codes_;
    std::int64_t filled_ = 0;
};

}  // namespace touchable
