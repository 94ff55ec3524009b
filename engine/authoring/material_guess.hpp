#pragma once

#include <array>
#include <cstdint>

#include "engine/authoring/palette.hpp"

namespace touchable {

/// What is seen of a segment.
struct SegmentLook {
    std::array<std::uint8_t, 3> colour{};  ///< mean, RGB
    std::int32_t contrast = 0;  ///< mean absolute deviation of brightness from its blur, 1/16 levels
    std::int32_t pixels = 0, of_pixels = 1;  ///< its own, and the picture's
};

/// A material that such a segment may be of, by a few rules of thumb. Colour tells little: a painted wall is
/// as white as paper. Whole numbers, the same on every machine.
const PaletteMaterial& guess_material(const SegmentLook& look);

}  // namespace touchable
