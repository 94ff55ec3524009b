#include "tests/reference/certificate.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "tests/reference/way.hpp"

namespace touchable::reference {

namespace {

using glm::cross;
using glm::dot;

Vec closest_on_segment(const Vec& p, const Vec& s, const Vec& e) {
    const Vec d = e - s;
    return s + d * std::clamp(dot(p - s, d) / dot(d, d), Real(0), Real(1));
}

/// Nearest point of a triangle: its plane's where that lies inside, else the nearest of its sides'.
Vec closest_on_triangle(const Vec& p, const Vec& a, const Vec& b, const Vec& c) {
    const Vec n = cross(b - a, c - a);
    const Vec foot = p - n * (dot(p - a, n) / dot(n, n));
    const bool inside = dot(cross(b - a, foot - a), n) >= 0 && dot(cross(c - b, foot - b), n) >= 0 &&
                        dot(cross(a - c, foot - c), n) >= 0;
    if (inside) return foot;
    const std::array<Vec, 3> sides{closest_on_segment(p, a, b), closest_on_segment(p, b, c),
                                   closest_on_segment(p, c, a)};
    return *std::min_element(sides.begin(), sides.end(),
                             [&p](const Vec& s, const Vec& t) { return length(s - p) < length(t - p); });
}

/// How much longer a way is than friction `mu` holds; of ways that are equally steep, any may be the one.
Real beyond_friction(const Surface& surface, const Place& place, const Vec& goal, Real mu) {
    const std::vector<Way> ways = ways_along(surface, place, goal);
    Real steepest = 0, held = 0;
    for (const Way& way : ways) steepest = std::max(steepest, length(way.step));
    for (const Way& way : ways)
        if (mu > 0 && length(way.step) >= steepest * (1 - Real(1e-7))) held = std::max(held, mu * way.load);
    return std::max(Real(0), steepest - held * (1 + Real(1e-8)));
}

}  // namespace

Real excess_over_minimum(const Surface& surface, const Proxy& proxy, const glm::dvec3& goal) {
    const Place place = reduced(place_of(surface, proxy));
    const Vec g(goal);
    const Real have = length(Vec(proxy.point) - g);
    Real least = have;
    for (const Triangle& t : triangles_around(place)) {
        // Measured from the corner nearest to the goal: from one a million units away even long doubles are
        // some 1e-8 off.
        std::array<Vec, 3> corners{surface.vertex(t[0]).point, surface.vertex(t[1]).point,
                                   surface.vertex(t[2]).point};
        std::rotate(
            corners.begin(),
            std::min_element(corners.begin(), corners.end(),
                             [&g](const Vec& s, const Vec& u) { return length(s - g) < length(u - g); }),
            corners.end());
        const Vec nearest = closest_on_triangle(g, corners[0], corners[1], corners[2]);
        least = std::min(least, length(nearest - g));
    }
    return have - least;
}

Real way_left(const Surface& surface, const Proxy& proxy, const glm::dvec3& goal) {
    const Place tagged = place_of(surface, proxy);
    const Properties here = properties_at(surface, tagged);
    const Real mu = proxy.sliding ? here.dynamic_friction : here.static_friction;
    const Vec g(goal);
    // Held by friction, a proxy on a triangle's rim is still that triangle's; a minimum is one for all around
    // it.
    const Place place = mu > 0 ? tagged : reduced(tagged);
    return std::max(height_of_departure(surface, place, g), beyond_friction(surface, place, g, mu));
}

Real depth_behind(const Surface& surface, const glm::dvec3& point) {
    const auto at = surface.seen(Vec(point));
    return at ? 1 - at->q / surface.q(at->x, at->y) : -1;
}

Real rounding_at(const Surface& surface, const glm::dvec3& point) {
    const Scene& scene = surface.scene();
    const ImagePoint at = surface.image(Vec(point));
    Real steepest = 0;  // change of q over a pixel, at most
    for (const int di : {-1, 0, 1, 2})
        for (const int dj : {-1, 0, 1, 2})
            steepest = std::max(steepest, surface
                                              .vertex({static_cast<std::int64_t>(std::floor(at.x)) + di,
                                                       static_cast<std::int64_t>(std::floor(at.y)) + dj})
                                              .q);
    const Real depth = 1 / at.q;
    const Real pixel = 2e-15L * (scene.width + scene.height + std::fabs(at.x) + std::fabs(at.y));
    return 1e-15L * scene.depth.far + pixel * steepest * depth * depth;
}

}  // namespace touchable::reference
