#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "engine/authoring/background_model.hpp"
#include "engine/scene/raw_frame.hpp"

namespace touchable {

/// Gives holes of a frame the depth that is behind, where what is seen there is what is behind:
/// - its colour is that which the pixel had with that depth, and so is that of most pixels beside it; where
///   there is no colour or it cannot tell, the hole is narrow in its row or column and has what is behind at
///   an end of that;
/// - and of the depths around such pixels, as far as they touch, no more than four times as many are nearer
///   than what is behind as are what is behind: a hole inside a hand is the hand's;
/// - and, without colour, what is narrow is hardly ever a part of a hole that is not.
class HoleFilling {
public:
    explicit HoleFilling(const CodedDepth& depth) : depth_(depth) {}
    /// Replaces the frame's depth plane and says in `filled` which pixels; the frame as it was where there
    /// are none.
    void fill(RawFrame& frame, const Background& background, bool uses_colour);
    /// Of all frames so far: whether colour misleads. Where depth says that something nearer is seen, colour
    /// often says that it is what is behind: it does not lie on depth's pixels, or both look alike.
    bool is_misled_by_colour() const;
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
    void find_places(const PlaneView& codes, const PlaneView& colour, const Background& background);
    bool is_coloured_as_behind(const PlaneView& colour, const Background& background,
                               std::size_t pixel) const;
    void find_candidates(const PlaneView& colour, const Background& background);
    bool is_beside_what_is_behind(std::size_t pixel) const;
    bool has_end_behind(std::size_t pixel, std::ptrdiff_t step, int place, int places) const;
    void leave_those_of_nearer_things(bool colour_tells);
    void write(RawFrame& frame, const Background& background);

    const CodedDepth& depth_;
    int width_ = 0, height_ = 0;
    std::vector<Place> places_;
    std::vector<std::size_t> holes_, fills_, group_;
    std::vector<std::uint16_t> hue_codes_;
    std::int64_t filled_ = 0;
    std::int64_t nearer_ = 0, nearer_but_alike_ = 0;  // pixels whose colour can tell
};

}  // namespace touchable
