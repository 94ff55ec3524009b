#pragma once

#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/proxy.hpp"

namespace touchable::test {

/// By how much of |P - G| a proxy on the surface misses the closest point to the goal on the triangles it
/// touches: 0 (to rounding) exactly for a local minimum, because each triangle is convex. In long double,
/// with an unprojection of its own; scene units.
long double excess_over_minimum(const HeightField& field, const Proxy& proxy, const glm::dvec3& goal);

/// 1/planar depth of the surface at a place, from its three vertices, and of a point; long double.
long double surface_q(const HeightField& field, double x, double y);

}  // namespace touchable::test
