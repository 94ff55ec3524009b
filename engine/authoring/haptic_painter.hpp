#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "engine/authoring/nearest_label.hpp"
#include "engine/authoring/palette.hpp"
#include "engine/picture/image_file.hpp"
#include "engine/scene/plane_view.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Ranges that hold the whole palette, the scene's defaults and these: the same for all choices of
/// materials, and one for both frictions, so that rounding never puts the dynamic one above the static one.
HapticRanges ranges_of_palette(const Scene& scene, const std::vector<Feel>& others);

/// The haptic pixel nearest to that.
std::array<std::uint8_t, 3> haptic_code(const HapticProperties& properties, const HapticRanges& ranges);

/// Paints each pixel as its segment feels. Pixels of no segment, which are holes, get what is nearest: a
/// hole's rim is as hard as what it is in, and so is what filters put there.
class HapticPainter {
public:
    explicit HapticPainter(const HapticRanges& ranges) : ranges_(ranges), codes_(65536), reliefs_(65536) {}

    /// What segments of this label feel like, 0: a picture without any.
    void set(std::uint16_t label, const Feel& feel);
    /// Of labels that were set, row by row; 0: no segment.
    Image haptic(const std::vector<std::uint16_t>& labels, int width, int height);
    /// Of the picture that was painted last: its heights, 8 bits, around level (128) scaled by relief.
    Image scaled(const PlaneView& height) const;

private:
    HapticRanges ranges_;
    std::vector<std::array<std::uint8_t, 3>> codes_;  // by label
    std::vector<int> reliefs_;
    std::vector<std::uint16_t> labels_;  // of all pixels
    NearestLabel nearest_;
};

}  // namespace touchable
