#pragma once

#include <glm/vec2.hpp>

#include "engine/base/trigonometry.hpp"

namespace touchable {

/// Where finger `finger` of `fingers` sits about the hand's centre (x right, y up): evenly on a circle of
/// radius `spread`, the first one to the right; a single finger at the centre. In the unit of `spread`.
inline glm::dvec2 finger_offset(int finger, int fingers, double spread) {
    if (fingers == 1) return {0, 0};
    const double angle = 2 * pi * finger / fingers;
    return {spread * cosine(angle), spread * sine(angle)};
}

}  // namespace touchable
