#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "haptics_cpu/world_space.hpp"

namespace touchable {

/// Cells to each side of the one around which a nearest place is searched.
inline constexpr int nearest_window = 8;

/// Where a sudden surface pushes a proxy aside (docs/solver.md, A surface that moves): the place of it
/// nearest to a world point, among those nearer than `within` (scene units) and at most `nearest_window`
/// cells from the cell of `around`. Looks at cells ring by ring and stops where no farther one can be nearer.
/// Of equally near places the first in that order.
std::optional<Place> nearest_place(const WorldSpace& space, const Place& around, const glm::dvec3& point,
                                   double within);

/// Takes a proxy along with a surface that moved since its last tick, so that it is on or in front of it
/// again (docs/solver.md, A surface that moves); sets proxy.point. A proxy on the surface stays on its
/// pixel's ray; a free one that the surface rose past is taken along on its own.
///
/// A ray's way farther than `sudden` (lengths of the space) is asked about. A proxy that was buried goes to
/// the nearest place of the surface instead, where one in the window is less than half as far: an object that
/// arrived from the side pushes it aside, and does not pop it to its front. One whose surface sank away is
/// free where it was. Only of the world's metric; the paper's knows only the ray. False where the proxy did
/// not stay on its ray.
template <class Space>
bool carry(const Space& space, Proxy& proxy, double sudden);

}  // namespace touchable
