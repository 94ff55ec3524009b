#pragma once

#include <array>
#include <cstdint>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "device/woodenhaptics_parameters.hpp"

namespace touchable {

/// Angles of the three joints, rad: the base's turn about the vertical, then both links', each measured on
/// its own and not from the link before (both motors stand in the base's body). The second link points up at
/// 0, the third down; both towards the person at a quarter turn.
glm::dvec3 wooden_angles(const WoodenParameters& build, const std::array<std::int16_t, 3>& counts);

/// Of the handle, device metres: axes and workspace as HapticDevice has them.
glm::dvec3 wooden_place(const WoodenParameters& build, const glm::dvec3& angles);
/// d place / d angles: one column for each joint, m/rad.
glm::dmat3 wooden_jacobian(const WoodenParameters& build, const glm::dvec3& angles);

/// Currents by which the handle pushes with a finite force, mA. Where a motor would need more than it bears
/// all three get less, by the same share: the force is shorter, and points where it should.
std::array<std::int16_t, 3> wooden_currents(const WoodenParameters& build, const glm::dvec3& angles,
                                            const glm::dvec3& newtons);

}  // namespace touchable
