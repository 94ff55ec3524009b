#pragma once

#include <cstdint>
#include <vector>

#include "engine/authoring/pixel_features.hpp"

namespace touchable {

/// A region of a frame, which is to have a label.
struct RegionLook {
    std::int64_t pixels = 0;
    std::int32_t x = 0, y = 0;                                               ///< mean place
    std::int32_t brightness = 0, red_green = 0, yellow_blue = 0, depth = 0;  ///< means
};

/// Gives regions their labels from frame to frame: that of which a region has most pixels, else that of one
/// like it that was seen a while ago about there, else a new one.
class LabelMemory {
public:
    LabelMemory(int width, int height) : width_(width), height_(height) {}

    /// Labels of regions 0 to size - 1. `regions`: of each pixel, beyond the last: none. `labels`: of the
    /// last frame. `follows`: this frame follows it; else a label has to be of one that looks alike.
    std::vector<std::uint16_t> name(const std::vector<RegionLook>& looks,
                                    const std::vector<std::uint16_t>& regions,
                                    const std::vector<std::uint16_t>& labels, bool follows);

private:
    struct Known {
        std::uint16_t label;
        RegionLook look;
        std::int64_t seen;  ///< number of the frame
        bool is_taken;
    };
    void take_by_overlap(const std::vector<RegionLook>& looks, const std::vector<std::uint16_t>& regions,
                         const std::vector<std::uint16_t>& labels, bool follows,
                         std::vector<std::uint16_t>& names);
    void take_by_look(const std::vector<RegionLook>& looks, std::vector<std::uint16_t>& names);
    bool are_alike(const RegionLook& a, const RegionLook& b) const;
    void remember(const std::vector<RegionLook>& looks, const std::vector<std::uint16_t>& names);

    const int width_, height_;
    std::vector<Known> known_;  ///< by label, ascending
    std::uint16_t newest_ = 0;
    std::int64_t frame_ = 0;
};

}  // namespace touchable
