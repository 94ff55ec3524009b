// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <sstream>

#include "tests/verify/certificate.hpp"

namespace touchable::verify {
namespace {

/// A straight slide within a facet towards the point closest to the goal.
struct Slide {
    Vec3 from, to_closest;
    real pressure = 0;

    /// How much longer the rest of the way is than friction holds, after a share (0 to 1) of it.
    real lacking(const Surface& surface, real share) const {
        const Touch touch = surface.touch_at(surface.project(from + share * to_closest));
        return (1 - share) * length(to_closest) - touch.mu_dynamic * pressure;
    }
    /// How far a place is from being the first at which friction holds: from the way, or by what friction
    /// holds too little there, or too much before.
    real off_by(const Surface& surface, const Vec3& place) const {
        const real share = dot(place - from, to_closest) / dot(to_closest, to_closest);
        if (!(share >= 0 && share <= 1 + 1e-12L)) return length(to_closest);
        real off = std::fmax(length(place - from - share * to_closest), std::fabs(lacking(surface, share)));
        constexpr int looks = 32;
        for (int k = 0; k < looks; ++k) off = std::fmax(off, -lacking(surface, share * k / looks));
        return off;
    }
};

}  // namespace

Step judge_step(const Before& before, const ForceRow& row, const Facet& facet, const Surface& surface,
                std::string& why) {
    const real pressure = dot(row.proxy - row.goal, facet.normal);
    const real slack = position_slack(row.proxy, row.goal);
    if (before.tick + 1 != row.tick || !(before.facet == facet) || pressure <= slack) return Step::unknown;
    const Vec3 closest = row.goal + pressure * facet.normal;
    const Slide slide{before.proxy, closest - before.proxy, pressure};
    const Touch touch = surface.touch_at(surface.project(before.proxy));
    const real away = length(slide.to_closest), tolerance = 1e-9L * away + slack;
    const real stuck = touch.mu_static * pressure, sliding = touch.mu_dynamic * pressure;
    const auto on_the_cone = [&](real held) { return std::fabs(away - held) <= 1e-9L * held + slack; };
    if (on_the_cone(stuck) || on_the_cone(sliding)) return Step::unknown;
    const bool may_stay = away < (before.motion == Motion::slid ? sliding : stuck);
    const bool may_slide = away > (before.motion == Motion::none ? stuck : sliding);
    const real from_staying = length(row.proxy - before.proxy);
    if (may_stay && from_staying <= tolerance) return Step::right;
    const real from_sliding = slide.off_by(surface, row.proxy);
    if (may_slide && from_sliding <= tolerance) return Step::right;
    std::ostringstream text;
    text << (before.motion == Motion::none ? "at rest " : "moving ") << away
         << " from the closest point, held up to " << stuck << ", sliding " << sliding << ": moved "
         << from_staying << ", and is " << from_sliding << " from where the dynamic cone first holds it";
    why = text.str();
    return Step::wrong;
}

}  // namespace touchable::verify
namespace touchable::verify {
namespace {

constexpr real relative_slack = 1e-9L;

/// The lattice's directions in turn about a vertex (clockwise as the picture is seen).
constexpr std::array<std::array<int, 2>, 6> directions = {
    {{1, 0}, {1, 1}, {0, 1}, {-1, 0}, {-1, -1}, {0, -1}}};

bool on_line(real x) {
    return std::fabs(x - std::round(x)) <= lattice_tolerance;
}

ImagePosition snapped(const Meaning& m, ImagePosition at) {
    auto lined = [](real x, int size) { return on_line(x) && x > -1.5L && x < size + 0.5L; };
    if (lined(at.x, m.width)) at.x = std::round(at.x);
    if (lined(at.y, m.height)) at.y = std::round(at.y);
    const bool inside = at.x > -1 && at.x < m.width && at.y > -1 && at.y < m.height;
    const real fx = at.x - std::floor(at.x), fy = at.y - std::floor(at.y);
    if (inside && std::fabs(fx - fy) <= lattice_tolerance) at.y = std::floor(at.y) + fx;
    return at;
}

/// Unit vector in the facet's plane whose image direction is (dx, dy). On the plane n.P = c a ray R has the
/// point P = R c/(n.R); this is its derivative.
Vec3 in_plane(const Surface& surface, const Facet& facet, ImagePosition at, int dx, int dy) {
    const Vec3 ray = surface.ray(at.x, at.y);
    const Vec3 step = surface.ray(at.x + dx, at.y + dy) - ray;
    return unit(step - (dot(facet.normal, step) / dot(facet.normal, ray)) * ray);
}

/// Whether a displacement in the plane of facet k points into the facet, give or take `rounding`.
bool contains(const Star& star, std::size_t k, const Vec3& direction, real rounding) {
    if (star.edges.empty()) return true;
    const Vec3& n = star.facets[k].normal;
    const Vec3& from = star.edges[k];
    const Vec3& to = star.edges[(k + 1) % star.edges.size()];
    return dot(cross(direction, from), n) >= -rounding && dot(cross(to, direction), n) >= -rounding;
}

/// A displacement along the surface, and what presses the proxy on while it goes that way.
struct Way {
    Vec3 along;
    real pressure = 0;
};

Way along_edge(const Star& star, std::size_t k, const Vec3& v) {
    const std::size_t before = (k + star.facets.size() - 1) % star.facets.size();
    const Vec3 &n1 = star.facets[before].normal, &n2 = star.facets[k].normal;
    const real forward = dot(v, star.edges[k]);
    if (forward <= 0) return {};
    const Vec3 along = forward * star.edges[k];
    // v - along = -(l1 n1 + l2 n2); the part along the bisector m is -(l1 + l2) n1.m
    const Vec3 bisector = unit(n1 + n2);
    return {along, -dot(v, bisector) / dot(n1, bisector)};
}

/// From the proxy to the point of facet k that is closest to the goal.
Way to_closest(const Star& star, std::size_t k, const Vec3& v) {
    const Vec3& n = star.facets[k].normal;
    const Vec3 tangential = v - dot(v, n) * n;
    if (contains(star, k, tangential, 1e-12L * length(v))) return {tangential, -dot(v, n)};
    const Way a = along_edge(star, k, v), b = along_edge(star, (k + 1) % star.edges.size(), v);
    return length(a.along) >= length(b.along) ? a : b;
}

/// Whether the goal stands in front of the facet towards which it is seen.
bool leaves(const Star& star, const Vec3& v, real slack) {
    for (std::size_t k = 0; k < star.facets.size(); ++k) {
        const Vec3& n = star.facets[k].normal;
        const Vec3 seen = v - (dot(v, n) / dot(star.sight, n)) * star.sight;
        if (dot(v, n) > slack && contains(star, k, seen, 1e-12L * length(v))) return true;
    }
    return false;
}

Judgement judge_star(const Star& star, const Vec3& v, real mu, real slack) {
    if (leaves(star, v, slack)) return {Verdict::leaves, length(v), 0};
    std::vector<Way> ways;
    real steepest = 0;
    for (std::size_t k = 0; k < star.facets.size(); ++k) {
        ways.push_back(to_closest(star, k, v));
        steepest = std::max(steepest, length(ways.back().along));
    }
    if (steepest <= slack) return {Verdict::minimum, steepest, 0};
    Judgement best{Verdict::slides, steepest, 0};
    for (const Way& way : ways) {
        if (length(way.along) < steepest * (1 - 1e-7L)) continue;  // equally steep ways: any may be taken
        best.allowed = std::max(best.allowed, mu * way.pressure);
    }
    if (steepest <= best.allowed * (1 + relative_slack) + slack) best.verdict = Verdict::stuck;
    return best;
}

/// The stars of which the point may be part, were it moved by less than the lattice tolerance: each edge, as
/// if it went on beyond the vertex, and each facet, as if it went on beyond its edges.
std::vector<Star> neighbours(const Star& star) {
    std::vector<Star> stars;
    const std::size_t count = star.facets.size();
    for (std::size_t k = 0; k < count && count > 2; ++k)
        stars.push_back({{star.facets[(k + count - 1) % count], star.facets[k]},
                         {-1 * star.edges[k], star.edges[k]},
                         star.sight});
    for (std::size_t k = 0; k < count && count > 1; ++k) stars.push_back({{star.facets[k]}, {}, star.sight});
    return stars;
}

}  // namespace

Star star_at(const Surface& surface, ImagePosition exact) {
    const ImagePosition at = snapped(surface.meaning(), exact);
    constexpr real step = lattice_tolerance / 8;  // crosses no line that the position was not put on
    std::array<Facet, 6> around;
    for (std::size_t k = 0; k < 6; ++k) {
        const auto &a = directions[k], &b = directions[(k + 1) % 6];
        around[k] = surface.facet_at({at.x + step * (a[0] + b[0]), at.y + step * (a[1] + b[1])});
    }
    Star star;
    star.sight = surface.ray(at.x, at.y);
    for (std::size_t k = 0; k < 6; ++k) {
        if (around[k].id == around[(k + 5) % 6].id) continue;
        star.facets.push_back(around[k]);
        star.edges.push_back(in_plane(surface, around[k], at, directions[k][0], directions[k][1]));
    }
    if (star.facets.empty()) star.facets.push_back(around[0]);
    return star;
}

real position_slack(const Vec3& proxy, const Vec3& goal) {
    return relative_slack * length(goal - proxy) + 1e-12L * length(proxy);
}

Judgement judge(const Star& star, const Vec3& proxy, const Vec3& goal, real mu) {
    const Vec3 v = goal - proxy;
    const real slack = position_slack(proxy, goal);
    const Judgement whole = judge_star(star, v, mu, slack);
    if (whole.holds()) return whole;
    for (const Star& other : neighbours(star)) {
        const Judgement j = judge_star(other, v, 0, slack);
        if (j.verdict == Verdict::minimum) return j;
    }
    // A proxy that came along a facet's very rim is still that facet's, while its way does not cross the rim.
    for (std::size_t k = 0; k < star.facets.size(); ++k) {
        const Vec3& n = star.facets[k].normal;
        if (!contains(star, k, v - dot(v, n) * n, slack)) continue;
        const Judgement j = judge_star({{star.facets[k]}, {}, star.sight}, v, mu, slack);
        if (j.holds()) return j;
    }
    return whole;
}

}  // namespace touchable::verify
