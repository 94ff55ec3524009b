#include "tests/reference/way.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace touchable::reference {

namespace {

using glm::cross;
using glm::dot;

/// Unit, towards the camera.
Vec normal_of(const Surface& surface, const Triangle& t) {
    std::array<Vertex, 3> at{surface.vertex(t[0]), surface.vertex(t[1]), surface.vertex(t[2])};
    // From the corner nearest to the camera: sides that meet far away are parallel to all the digits there
    // are.
    std::rotate(
        at.begin(),
        std::max_element(at.begin(), at.end(), [](const Vertex& s, const Vertex& u) { return s.q < u.q; }),
        at.end());
    const Vec a = at[0].point, b = at[1].point, c = at[2].point;
    const Vec n = cross(b - a, c - a);
    const Vec unit = n / length(n);
    return dot(unit, a) > 0 ? -unit : unit;
}

/// A step within the triangle's plane leads into the triangle: no corner that has no weight loses any.
bool leads_into(const Surface& surface, const Place& place, const Triangle& triangle, const Vec& step) {
    const std::vector<Corner> corners(triangle.begin(), triangle.end());
    const std::vector<Real> changes = weight_changes(surface, corners, step);
    for (std::size_t k = 0; k < 3; ++k)
        if (!place.has(corners[k]) && changes[k] < 0) return false;
    return true;
}

/// Along an edge the goal presses on both triangles: v - step = -(l0 n0 + l1 n1), and the load is l0 + l1.
Real load_of_edge(const Surface& surface, const std::vector<Triangle>& beside, const Vec& v) {
    const Vec n0 = normal_of(surface, beside[0]), n1 = normal_of(surface, beside[1]);
    const Real pressed = -(dot(v, n0) + dot(v, n1)), opening = 1 + dot(n0, n1);
    if (!(pressed > 0)) return 0;
    return opening > 0 ? pressed / opening : std::numeric_limits<Real>::infinity();
}

/// The edges that the place is on or at the end of.
std::vector<std::array<Corner, 2>> edges_around(const Place& place) {
    if (place.parts.size() == 3) return {};
    if (place.parts.size() == 2) return {{place.parts[0].corner, place.parts[1].corner}};
    const Corner at = place.parts[0].corner;
    std::vector<std::array<Corner, 2>> edges;
    for (const auto& [di, dj] : {std::array{1, 0}, {1, 1}, {0, 1}, {-1, 0}, {-1, -1}, {0, -1}})
        edges.push_back({at, {at.i + di, at.j + dj}});
    return edges;
}

}  // namespace

std::vector<Real> weight_changes(const Surface& surface, const std::vector<Corner>& corners,
                                 const Vec& step) {
    std::vector<Real> changes;
    for (std::size_t k = 0; k < corners.size(); ++k) {
        // A corner's weight grows with the distance from the opposite side (or end).
        const Vec to = surface.vertex(corners[k]).point;
        const Vec from = surface.vertex(corners[(k + 1) % corners.size()]).point;
        Vec rise = to - from;
        if (corners.size() == 3) {
            const Vec side = surface.vertex(corners[(k + 2) % 3]).point - from;
            rise -= side * (dot(rise, side) / dot(side, side));
        }
        changes.push_back(dot(step, rise) / dot(rise, rise));
    }
    return changes;
}

std::vector<Way> ways_along(const Surface& surface, const Place& place, const Vec& goal) {
    const Vec v = goal - point_of(surface, place);
    std::vector<Way> ways;
    for (const Triangle& t : triangles_around(place)) {
        const Vec n = normal_of(surface, t);
        const Vec step = v - dot(v, n) * n;
        if (!leads_into(surface, place, t, step)) continue;
        ways.push_back({{t.begin(), t.end()}, step, std::fabs(dot(v, n))});
    }
    for (const auto& [from, to] : edges_around(place)) {
        const Vec e = surface.vertex(to).point - surface.vertex(from).point;
        const Real along = dot(v, e);
        // From a vertex only forward; on the edge either way.
        if (along == 0 || (place.parts.size() == 1 && along < 0)) continue;
        const std::vector<Triangle> beside = triangles_around({{{from, 0}, {to, 0}}});
        ways.push_back({{from, to}, e * (along / dot(e, e)), load_of_edge(surface, beside, v)});
    }
    return ways;
}

Real height_of_departure(const Surface& surface, const Place& place, const Vec& goal) {
    const Vec sight = point_of(surface, place), v = goal - sight;
    Real highest = 0;
    for (const Triangle& t : triangles_around(place)) {
        const Vec n = normal_of(surface, t);
        const Vec seen = v - (dot(v, n) / dot(sight, n)) * sight;  // v in the triangle's plane, along the ray
        if (leads_into(surface, place, t, seen)) highest = std::max(highest, dot(v, n));
    }
    return highest;
}

}  // namespace touchable::reference
