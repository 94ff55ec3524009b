#pragma once

#include "tests/reference/place.hpp"

/// What can be said of a proxy without solving anything: that it is not behind the surface, and that no way
/// leads nearer to the goal than friction lets it go.
namespace touchable::reference {

/// By how much of |P - G| a proxy on the surface misses the closest point to the goal on the triangles it
/// touches: 0 (to rounding) exactly for a local minimum, because each triangle is convex. Scene units.
Real excess_over_minimum(const Surface& surface, const Proxy& proxy, const glm::dvec3& goal);

/// How far the proxy on the surface could still go towards the goal beyond what friction holds: 0 (to
/// rounding) where it rests. In front of the surface: how high the goal stands above it. Scene units.
Real way_left(const Surface& surface, const Proxy& proxy, const glm::dvec3& goal);

/// By how much, relative, the point's 1 / planar depth is less than the surface's under its pixel; negative
/// in front.
Real depth_behind(const Surface& surface, const glm::dvec3& point);

/// How far doubles may misplace a point of the surface: by a rounding of the depths, and by one of its pixel
/// coordinates where a cell beside it reaches from close to the camera to far away. Scene units.
Real rounding_at(const Surface& surface, const glm::dvec3& point);

}  // namespace touchable::reference
