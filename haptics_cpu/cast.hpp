#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "haptics_cpu/proxy.hpp"

namespace touchable {

/// What a straight way meets.
struct Cast {
    /// Where it first goes from above the surface (or on it) to below it; nothing if it stays above.
    std::optional<Place> hit;
    /// Set where the work ran out: as far as this point of the way it is known to stay above.
    std::optional<glm::dvec3> cut;
};

/// Follows the straight way from `from` to `to`. Watertight: at each lattice line the way crosses, its w is
/// compared with that of the edge's two vertices alone, so both faces of an edge see the same number and no
/// crossing can be lost (docs/solver.md, Cast). `from_surface`: `from` is the surface's point at that place,
/// so its height above the surface is 0 by definition. `cells` counts the lattice lines looked at, up to
/// `cell_limit`.
template <class Space>
Cast cast(const Space& space, const glm::dvec3& from, const Place* from_surface, const glm::dvec3& to,
          int& cells, int cell_limit);

/// True where one bound tells that the straight way between two free points stays in front of the surface,
/// both ends included: what a finger far from everything costs. False says nothing.
template <class Space>
bool is_clear(const Space& space, const glm::dvec3& from, const glm::dvec3& to);

}  // namespace touchable
