// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "haptics_cpu/world_space.hpp"

namespace touchable {

/// Cells to each side of the given one in which a nearest place is searched.
inline constexpr int nearest_window = 8;

/// The place to which a sudden surface pushes a proxy aside (docs/solver.md, A surface that moves): the
/// surface's place nearest to a world point, among those nearer than `within` (scene units) and at most
/// `nearest_window` cells from the cell of `around`. Searches cells ring by ring and stops if no farther one
/// can be nearer. Of equally near places the first in that order.
std::optional<Place> nearest_place(const WorldSpace& space, const Place& around, const glm::dvec3& point,
                                   double within);

/// Carries a proxy with a surface that moved since its last tick, so that it is on or in front of it again
/// (docs/solver.md, A surface that moves); sets proxy.point. A proxy on the surface stays on its pixel's ray;
/// a free proxy that the surface rose past is carried on its own.
///
/// A way on the ray longer than `sudden` (lengths of the space) is tested. A proxy that was buried goes to
/// the nearest place of the surface instead, if one in the window is less than half as far: an object that
/// arrived from the side pushes it aside, and does not pop it to its front. A proxy whose surface sank away
/// is free where it was. Only in the world's metric; the paper's knows only the ray. False if the proxy did
/// not stay on its ray.
template <class Space>
bool carry(const Space& space, Proxy& proxy, double sudden);

}  // namespace touchable
