#pragma once

#include "tests/reference/place.hpp"

namespace touchable::reference {

/// One way in which a place can go nearer to the goal: over a triangle, or along an edge.
struct Way {
    std::vector<Corner> corners;  ///< the triangle's three, or the edge's two
    Vec step;       ///< to the point of the triangle's plane (the edge's line) nearest to the goal
    Real load = 0;  ///< how hard the goal presses on what is gone along
};

/// The ways that stay on the surface: the projections of the pull on the triangles and edges around the place
/// that lead into them. The longest is the projection on the tangent cone of free space.
std::vector<Way> ways_along(const Surface& surface, const Place& place, const Vec& goal);

/// How far in front of the surface the goal stands, seen from the place; 0 where the straight way to it leads
/// below.
Real height_of_departure(const Surface& surface, const Place& place, const Vec& goal);

/// How the weight of each corner of a triangle or an edge changes along a step in its plane (or line).
std::vector<Real> weight_changes(const Surface& surface, const std::vector<Corner>& corners, const Vec& step);

}  // namespace touchable::reference
