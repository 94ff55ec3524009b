#pragma once

#include <optional>

#include "tests/reference/way.hpp"

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

}  // namespace touchable::reference
