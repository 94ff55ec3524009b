#pragma once

#include <optional>

#include "haptics_cpu/touch_solver.hpp"
#include "tests/reference/surface.hpp"

namespace touchable::reference {

/// A finger between ticks: a place on the surface, or a point in front of it.
struct Finger {
    std::optional<Place> place;
    Vec point{0};  ///< of the place, if there is one
    bool sliding = false;
};

struct Solution {
    Finger finger;
    int events = 0;
    bool capped = false;  ///< ended by the event limit, on the surface but not at rest
};

/// Where a straight way first goes below the surface. `start`: the place where it begins, if it begins on the
/// surface.
std::optional<Place> first_hit(const Surface& surface, const Vec& from, const Place* start, const Vec& goal);

/// The proxy's state at the beginning of a tick: carried along its ray where the surface has risen past it.
Finger finger_of(const Surface& surface, const Proxy& proxy);

/// One tick as docs/solver.md has it: cast, then slide until the proxy rests. With `substeps` > 1 the goal
/// goes there from `last_goal` in so many straight steps.
Solution solve(const Surface& surface, Finger finger, const Vec& last_goal, const Vec& goal,
               int substeps = 1);

/// Certificates of a proxy that need no solving: that it is not behind the surface, and that no way
/// leads nearer to the goal than friction lets it go.

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

/// The fast solver's proxy beside the slow one's, from the same state, over the same surface, to the same
/// goal.
struct Comparison {
    bool same_basin = false;  ///< both free, or on the same triangle, on an edge or a corner of it
    Real distance_ratio = 1;  ///< |P - G| over the reference's; 1 where both are nought
    Real angle_degrees = 0;   ///< between both forces, less what the rounding of coordinates explains
    Real farther = 0;         ///< growth of |P - G| in the tick, over 1 + |P - G|; 0 or less
    bool capped = false;      ///< the reference did not come to rest
};

/// `before`, `after`: the proxy before and after the tick that gave `contact`.
Comparison compare(const Surface& surface, const Proxy& before, const Proxy& after, const Contact& contact);

}  // namespace touchable::reference
