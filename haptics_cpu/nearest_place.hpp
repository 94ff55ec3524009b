#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "haptics_cpu/proxy.hpp"
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

}  // namespace touchable
