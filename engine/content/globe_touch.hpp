#pragma once

#include <cmath>
#include <cstdint>

#include "engine/scene/scene.hpp"

namespace touchable {

/// What a globe feels like: land is stiffer and rougher than the sea; a coast leads from one to the other.
inline constexpr HapticProperties sea_feel{400, 0.15, 0.10}, land_feel{1200, 0.60, 0.45},
    beyond_feel{800, 0.30, 0.20};
inline constexpr HapticRanges globe_ranges{{0.1, 2}, {0, 1}, {0, 1}};

/// `dry`: 0 at sea, 1 on land.
inline HapticProperties globe_feel(double dry) {
    return {sea_feel.stiffness + dry * (land_feel.stiffness - sea_feel.stiffness),
            sea_feel.static_friction + dry * (land_feel.static_friction - sea_feel.static_friction),
            sea_feel.dynamic_friction + dry * (land_feel.dynamic_friction - sea_feel.dynamic_friction)};
}

/// Code of a property value in its range (Eq. 1 turned round).
inline std::uint8_t property_code(const PropertyRange& range, double value) {
    return static_cast<std::uint8_t>(std::floor(255 * (value - range.min) / (range.max - range.min) + 0.5));
}

/// The three codes of a haptic pixel of `globe_ranges`.
inline void put_feel(const HapticProperties& felt, std::uint8_t* pixel) {
    pixel[0] = property_code(globe_ranges.stiffness, felt.stiffness / 1000);
    pixel[1] = property_code(globe_ranges.static_friction, felt.static_friction);
    pixel[2] = property_code(globe_ranges.dynamic_friction, felt.dynamic_friction);
}

}  // namespace touchable
