// SPDX-License-Identifier: Apache-2.0
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/reference/solver.hpp"

namespace touchable::reference {
namespace {

/// docs/scene_file.md: what a code stands for.
Real depth_of(const DepthCoding& coding, std::uint16_t code) {
    if (coding.kind == DepthCodingKind::metric) return Real(coding.scale) * code;
    const Real share = Real(code) / coding.code_max;
    const Real n = coding.near_is_high ? share : 1 - share;
    const Real near = coding.near, far = coding.far;
    if (coding.kind == DepthCodingKind::inverse) {
        const Real shift = coding.shift, deep = 1 / (far + shift);
        return 1 / (deep + (1 / (near + shift) - deep) * n) - shift;
    }
    if (coding.kind == DepthCodingKind::log) {
        const Real shift = coding.shift;
        return (near + shift) * std::exp((1 - n) * std::log((far + shift) / (near + shift))) - shift;
    }
    return far + (near - far) * n;
}

Real tallest(const Scene& scene) {
    const Real level = (Real(scene.depth.far) - scene.depth.near) / 255;
    const Real most = scene.height_coding.max_height;
    return scene.height_coding.units == HeightUnits::levels ? most * level : most;
}

bool is_between(const Scene& scene, const FramePair& pair) {
    return scene.interpolation == FrameInterpolation::linear && pair.blend > 0 &&
           pair.next.frame != pair.prev.frame;
}

}  // namespace

Surface::Surface(const Scene& scene, const FramePair& pair)
    : scene_(scene),
      earlier_(*pair.prev.frame),
      later_(is_between(scene, pair) ? *pair.next.frame : *pair.prev.frame),
      blend_(is_between(scene, pair) ? pair.blend : 0) {}

Surface::Pixel Surface::pixel(const SurfaceFrame& frame, int x, int y) const {
    Pixel pixel;
    if (frame.codes.empty()) {
        const DepthSample sample = frame.vertices->at(x, y);
        pixel = {sample.depth, sample.valid};
    } else if (frame.is_valid(x, y)) {
        pixel = {depth_of(frame.coding, frame.codes[frame.index(x, y)]), true};
    }
    if (pixel.valid && !frame.heights.empty())
        pixel.depth -= tallest(scene_) * frame.heights[frame.index(x, y)] / scene_.height_coding.code_max;
    return pixel;
}

Surface::Pixel Surface::pixel(Corner corner) const {
    if (corner.i < 0 || corner.j < 0 || corner.i >= scene_.width || corner.j >= scene_.height) return {};
    const int x = static_cast<int>(corner.i), y = static_cast<int>(corner.j);
    const Pixel a = pixel(earlier_, x, y), b = pixel(later_, x, y);
    if (a.valid && b.valid) return {a.depth + (b.depth - a.depth) * blend_, true};
    return blend_ < Real(0.5) ? a : b;
}

Vertex Surface::vertex(Corner corner) const {
    const Pixel p = pixel(corner);
    Real planar = p.valid ? p.depth : Real(scene_.depth.far);
    if (scene_.depth.semantics == DepthSemantics::range) {
        // Beyond the ring q is the ring's.
        const Vec r = ray(std::clamp<std::int64_t>(corner.i, -1, scene_.width),
                          std::clamp<std::int64_t>(corner.j, -1, scene_.height));
        planar /= length(r);
    }
    return {planar * ray(corner.i, corner.j), 1 / planar, p.valid};
}

Real Surface::q(Real x, Real y) const {
    const Real i = std::floor(x), j = std::floor(y), a = x - i, b = y - j;
    const Corner c{static_cast<std::int64_t>(i), static_cast<std::int64_t>(j)};
    const Real q00 = vertex(c).q, q11 = vertex({c.i + 1, c.j + 1}).q;
    if (a >= b) return (1 - a) * q00 + (a - b) * vertex({c.i + 1, c.j}).q + b * q11;
    return (1 - b) * q00 + (b - a) * vertex({c.i, c.j + 1}).q + a * q11;
}

Properties Surface::felt_at(const SurfaceFrame& frame, int x, int y) const {
    const HapticProperties& usual = scene_.default_properties;
    if (frame.haptic.empty()) return {usual.stiffness, usual.static_friction, usual.dynamic_friction};
    const std::uint8_t* byte = &frame.haptic[3 * frame.index(x, y)];
    auto at = [](const PropertyRange& r, std::uint8_t v) { return r.min + (Real(r.max) - r.min) * v / 255; };
    return {1000 * at(scene_.haptic.stiffness, byte[0]), at(scene_.haptic.static_friction, byte[1]),
            at(scene_.haptic.dynamic_friction, byte[2])};
}

/// 1 where there is no depth; before it is lost, as much of the way to that moment as is past.
Real Surface::missing(Corner corner) const {
    if (corner.i < 0 || corner.j < 0 || corner.i >= scene_.width || corner.j >= scene_.height) return 1;
    const int x = static_cast<int>(corner.i), y = static_cast<int>(corner.j);
    if (!pixel(corner).valid) return 1;
    return pixel(earlier_, x, y).valid && !pixel(later_, x, y).valid ? blend_ / Real(0.5) : 0;
}

Real Surface::most_missing_around(Corner corner) const {
    Real most = 0;
    for (const int di : {-1, 0, 1})
        for (const int dj : {-1, 0, 1}) most = std::max(most, missing({corner.i + di, corner.j + dj}));
    return most;
}

Properties Surface::properties(Corner cell, Real a, Real b) const {
    Properties sum;
    Real hole = 0;
    for (const int di : {0, 1})
        for (const int dj : {0, 1}) {
            const Real weight = (di ? a : 1 - a) * (dj ? b : 1 - b);
            if (weight == 0) continue;
            const Corner corner{cell.i + di, cell.j + dj};
            const auto x = static_cast<int>(std::clamp<std::int64_t>(corner.i, 0, scene_.width - 1));
            const auto y = static_cast<int>(std::clamp<std::int64_t>(corner.j, 0, scene_.height - 1));
            if (scene_.hole_stiffness) hole += weight * most_missing_around(corner);
            const bool solid = vertex(corner).valid;  // no friction at holes and at the ring
            for (const auto& [frame, share] : {std::pair{&earlier_, 1 - blend_}, {&later_, blend_}}) {
                const Properties p = felt_at(*frame, x, y);
                sum.stiffness += weight * share * p.stiffness;
                if (!solid) continue;
                sum.static_friction += weight * share * p.static_friction;
                sum.dynamic_friction += weight * share * p.dynamic_friction;
            }
        }
    if (scene_.hole_stiffness) sum.stiffness += hole * (1000 * Real(*scene_.hole_stiffness) - sum.stiffness);
    sum.dynamic_friction = std::min(sum.dynamic_friction, sum.static_friction);
    return sum;
}

Vec Surface::ray(Real x, Real y) const {
    const Camera& c = scene_.camera;
    return {(x - c.cx) / c.fx, -(y - c.cy) / c.fy, -1};
}

ImagePoint Surface::image(const Vec& point) const {
    const Camera& c = scene_.camera;
    return {c.cx + c.fx * point.x / -point.z, c.cy - c.fy * point.y / -point.z, -1 / point.z};
}

std::optional<ImagePoint> Surface::seen(const Vec& point) const {
    constexpr Real countable = 1e15L;
    if (!(point.z < 0)) return std::nullopt;
    const ImagePoint at = image(point);
    if (!(std::fabs(at.x) < countable) || !(std::fabs(at.y) < countable)) return std::nullopt;
    return at;
}

Real Surface::least_planar_depth() const {
    const DepthCoding& coding = scene_.depth;
    const Real depth =
        std::min(depth_of(coding, coding.valid_min), depth_of(coding, coding.valid_max)) - tallest(scene_);
    Real longest = 1;
    if (coding.semantics == DepthSemantics::range)
        for (const int x : {-1, scene_.width})
            for (const int y : {-1, scene_.height}) longest = std::max(longest, length(ray(x, y)));
    return depth / longest;
}

}  // namespace touchable::reference
namespace touchable::reference {
namespace {

/// From weights in the picture: on a flat triangle a corner weighs in proportion to its q as well.
Place weighed(const Surface& surface, std::vector<Place::Part> parts) {
    Real sum = 0;
    for (Place::Part& part : parts) {
        part.weight = std::max(part.weight, Real(0)) * surface.vertex(part.corner).q;
        sum += part.weight;
    }
    for (Place::Part& part : parts) part.weight /= sum;
    return {std::move(parts)};
}

std::vector<Place::Part> lower_face(Corner c, Real a, Real b) {
    return {{c, 1 - a}, {{c.i + 1, c.j}, a - b}, {{c.i + 1, c.j + 1}, b}};
}
std::vector<Place::Part> upper_face(Corner c, Real a, Real b) {
    return {{c, 1 - b}, {{c.i, c.j + 1}, b - a}, {{c.i + 1, c.j + 1}, a}};
}

}  // namespace

bool Place::has(Corner corner) const {
    return std::any_of(parts.begin(), parts.end(), [&](const Part& part) { return part.corner == corner; });
}

Place place_of(const Surface& surface, const Proxy& proxy) {
    const Corner c{proxy.i, proxy.j};
    const Real a = proxy.a, b = proxy.b;
    switch (proxy.feature) {
        case Feature::free:
            return {};
        case Feature::vertex:
            return weighed(surface, {{c, 1}});
        case Feature::edge_h:
            return weighed(surface, {{c, 1 - a}, {{c.i + 1, c.j}, a}});
        case Feature::edge_v:
            return weighed(surface, {{c, 1 - b}, {{c.i, c.j + 1}, b}});
        case Feature::edge_d:
            return weighed(surface, {{c, 1 - a}, {{c.i + 1, c.j + 1}, a}});
        case Feature::face_lower:
            return weighed(surface, lower_face(c, a, b));
        case Feature::face_upper:
            return weighed(surface, upper_face(c, a, b));
    }
    return {};
}

Place place_at(const Surface& surface, Real x, Real y, Real inside_x, Real inside_y) {
    const Real i = std::floor(inside_x), j = std::floor(inside_y);
    const Corner c{static_cast<std::int64_t>(i), static_cast<std::int64_t>(j)};
    const bool lower = inside_x - i >= inside_y - j;
    return weighed(surface, lower ? lower_face(c, x - i, y - j) : upper_face(c, x - i, y - j));
}

Place reduced(const Place& place) {
    Place out;
    for (const Place::Part& part : place.parts)
        if (part.weight > 0) out.parts.push_back(part);
    return out;
}

Vec point_of(const Surface& surface, const Place& place) {
    Vec sum(0);
    for (const Place::Part& part : place.parts) sum += part.weight * surface.vertex(part.corner).point;
    return sum;
}

ImagePoint image_of(const Surface& surface, const Place& place) {
    // The other way round: in the picture a corner weighs in proportion to weight / q.
    ImagePoint image;
    Real sum = 0;
    for (const Place::Part& part : place.parts) {
        const Real weight = part.weight / surface.vertex(part.corner).q;
        image.x += weight * part.corner.i;
        image.y += weight * part.corner.j;
        sum += weight;
    }
    return {image.x / sum, image.y / sum, 1 / sum};  // sum is the planar depth
}

Properties properties_at(const Surface& surface, const Place& place) {
    const ImagePoint at = image_of(surface, place);
    Corner cell = place.parts.front().corner;
    for (const Place::Part& part : place.parts)
        cell = {std::min(cell.i, part.corner.i), std::min(cell.j, part.corner.j)};
    auto within = [](Real f) { return std::clamp(f, Real(0), Real(1)); };
    return surface.properties(cell, within(at.x - cell.i), within(at.y - cell.j));
}

std::vector<Triangle> triangles_around(const Place& place) {
    const Corner at = place.parts.front().corner;
    std::vector<Triangle> found;
    for (const std::int64_t i : {at.i - 1, at.i})
        for (const std::int64_t j : {at.j - 1, at.j}) {
            const Corner first{i, j}, last{i + 1, j + 1};
            for (const Corner third : {Corner{i + 1, j}, Corner{i, j + 1}}) {
                const Triangle triangle{first, third, last};
                const bool all =
                    std::all_of(place.parts.begin(), place.parts.end(), [&](const Place::Part& part) {
                        return std::find(triangle.begin(), triangle.end(), part.corner) != triangle.end();
                    });
                if (all) found.push_back(triangle);
            }
        }
    return found;
}

}  // namespace touchable::reference
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
namespace touchable::reference {
namespace {

using glm::dot;

constexpr int event_limit = 100000;
constexpr int stall_limit = 8;

/// The part of a way that can meet the surface: what is nearer to the camera than half of anything there is
/// cut off.
struct Part {
    Vec from, to;
    bool from_the_start;
};

std::optional<Part> part_in_front(const Surface& surface, const Vec& from, const Vec& to) {
    const Real margin = surface.least_planar_depth() / 2;
    const Real d0 = -from.z - margin, d1 = -to.z - margin;
    if (d0 < 0 && d1 < 0) return std::nullopt;
    auto crossing = [&] { return from + (to - from) * (d0 / (d0 - d1)); };
    return Part{d0 < 0 ? crossing() : from, d1 < 0 ? crossing() : to, d0 >= 0};
}

/// Parameters at which a way crosses the lines on which `line_of` is whole, from `first` to `last`: beyond
/// them the surface does not bend. A line that the start lies on is not crossed.
template <class LineOf>
void add_crossings(std::vector<Real>& crossings, LineOf line_of, const ImagePoint& from, const ImagePoint& to,
                   const Place* start, Real first, Real last) {
    const Real h0 = line_of(from.x, from.y), h1 = line_of(to.x, to.y);
    if (h0 == h1) return;
    const Real low = std::max(std::ceil(std::min(h0, h1)), first), high = std::min(std::max(h0, h1), last);
    for (Real line = low; line <= high; line += 1) {
        const bool on_it =
            start && std::all_of(start->parts.begin(), start->parts.end(), [&](const Place::Part& p) {
                return line_of(p.corner.i, p.corner.j) == line;
            });
        const Real s = (line - h0) / (h1 - h0);
        if (!on_it && s > 0 && s < 1) crossings.push_back(s);
    }
}

/// The friction that holds a finger.
Real resting_mu(const Finger& finger, const Properties& p) {
    return finger.sliding ? p.dynamic_friction : p.static_friction;
}

/// Goes the share (0 to 1) of a way, or as far as the triangle (edge) reaches. True where it went all of it.
bool advance(const Surface& surface, const Place& from, const Way& way, Real share, Place& to) {
    const std::vector<Real> change = weight_changes(surface, way.corners, way.step);
    std::vector<Real> weight(way.corners.size(), 0);
    for (std::size_t k = 0; k < weight.size(); ++k)
        for (const Place::Part& part : from.parts)
            if (part.corner == way.corners[k]) weight[k] = part.weight;
    std::size_t out = weight.size();  // the corner that loses all its weight first
    Real most = share;
    for (std::size_t k = 0; k < weight.size(); ++k) {
        if (!(change[k] < 0) || weight[k] / -change[k] > most) continue;
        most = weight[k] / -change[k];
        out = k;
    }
    to.parts.clear();
    Real sum = 0;
    for (std::size_t k = 0; k < weight.size(); ++k) {
        const Real left = k == out ? 0 : weight[k] + most * change[k];
        if (!(left > 0)) continue;
        to.parts.push_back({way.corners[k], left});
        sum += left;
    }
    for (Place::Part& part : to.parts) part.weight /= sum;
    return out == weight.size();
}

/// Friction at the corners of the cells that a way goes through is the same.
bool is_level(const Surface& surface, const Way& way) {
    const auto friction = [&](std::int64_t i, std::int64_t j) {
        const Properties p = surface.properties({i, j}, 0, 0);
        return std::array{p.static_friction, p.dynamic_friction};
    };
    const auto& c = way.corners;
    const auto [low_i, high_i] =
        std::minmax_element(c.begin(), c.end(), [](Corner a, Corner b) { return a.i < b.i; });
    const auto [low_j, high_j] =
        std::minmax_element(c.begin(), c.end(), [](Corner a, Corner b) { return a.j < b.j; });
    const auto first = friction(low_i->i, low_j->j);
    return friction(high_i->i, low_j->j) == first && friction(low_i->i, high_j->j) == first &&
           friction(high_i->i, high_j->j) == first;
}

/// The least share of a way, found by looking, after which the rest is at most mu dynamic times the load. A
/// place that holds for less than a look's distance may be missed.
Real stopping_share(const Surface& surface, const Place& from, const Way& way) {
    const Real whole = length(way.step);
    const auto beyond = [&](Real share, Place& there) {
        const bool inside = advance(surface, from, way, share, there);
        const Real left = (1 - share) * whole;
        return inside ? left - properties_at(surface, there).dynamic_friction * way.load : left;
    };
    Place place;
    if (is_level(surface, way)) {
        const Real mu = properties_at(surface, from).dynamic_friction;
        return mu > 0 ? std::max(Real(0), 1 - mu * way.load / whole) : 1;
    }
    // Up to where the way ends or leaves the triangle.
    Real end = 1;
    if (!advance(surface, from, way, 1, place)) {
        Real inside = 0;
        for (int k = 0; k < 80; ++k) {
            const Real middle = (inside + end) / 2;
            (advance(surface, from, way, middle, place) ? inside : end) = middle;
        }
        end = inside;
    }
    constexpr int looks = 64;
    for (int k = 1; k <= looks; ++k) {
        Real low = end * (k - 1) / looks, high = end * k / looks;
        if (beyond(high, place) > 0) continue;
        for (int n = 0; n < 80; ++n) {
            const Real middle = (low + high) / 2;
            (beyond(middle, place) > 0 ? low : high) = middle;
        }
        return high;
    }
    return 1;
}

/// The flow towards one goal.
class Flow {
public:
    Flow(const Surface& surface, Solution& solution, const Vec& goal)
        : surface_(surface), solution_(solution), finger_(solution.finger), goal_(goal) {}

    void run() {
        if (!finger_.place) {
            auto hit = first_hit(surface_, finger_.point, nullptr, goal_);
            if (!hit) return fly();
            land(std::move(*hit));
        }
        finger_.place = reduced(*finger_.place);
        finger_.point = point_of(surface_, *finger_.place);
        bool may_leave = true;
        int stalls = 0;
        while (++solution_.events <= event_limit) {
            const Real before = distance2();
            Finger next;
            bool arrived = false;
            if (may_leave && height_of_departure(surface_, *finger_.place, goal_) > 0) {
                auto hit = first_hit(surface_, finger_.point, &*finger_.place, goal_);
                if (!hit) return fly();
                next.place = reduced(*hit);
            } else if (!step(next, arrived)) {
                return;
            }
            next.point = point_of(surface_, *next.place);
            const Real after = dot(goal_ - next.point, goal_ - next.point);
            if (after < before) {
                finger_ = next;
                may_leave = true;
                if (arrived) return;
                continue;
            }
            // Rounding made a step or a flight end where it began.
            const bool same = after <= before * (1 + Real(1e-16));
            if (same) finger_ = next;
            if (arrived || ++stalls > stall_limit || (!same && !may_leave)) return;
            may_leave = false;
        }
        solution_.capped = true;
    }

private:
    Real distance2() const { return dot(goal_ - finger_.point, goal_ - finger_.point); }

    /// One step along the surface; false where the proxy rests.
    bool step(Finger& next, bool& arrived) const {
        const std::vector<Way> ways = ways_along(surface_, *finger_.place, goal_);
        if (ways.empty()) return false;
        const Way& way = *std::max_element(ways.begin(), ways.end(), [](const Way& a, const Way& b) {
            return dot(a.step, a.step) < dot(b.step, b.step);
        });
        const Real whole = length(way.step);
        if (whole == 0) return false;
        const Properties here = properties_at(surface_, *finger_.place);
        const Real holds = resting_mu(finger_, here) * way.load;
        // A proxy that was stopped on the cone in double may lie beyond it by a rounding.
        if (holds > 0 && whole <= holds * (1 + Real(1e-9))) return false;
        const Real share = stopping_share(surface_, *finger_.place, way);
        next.place.emplace();
        const bool inside = advance(surface_, *finger_.place, way, share, *next.place);
        arrived = inside && here.dynamic_friction == 0 && led_to(way, *next.place);
        next.sliding = true;
        return true;
    }

    /// A long way over a triangle that is seen edge-on ends beside its foot: weights of 1e-5 that its far
    /// corner has are known to few digits. Then it is gone once more from there.
    bool led_to(const Way& way, const Place& place) const {
        const Vec end = point_of(surface_, place);
        return length(end - finger_.point - way.step) <= Real(1e-12) * length(goal_ - end);
    }

    void land(Place place) {
        finger_ = {};
        finger_.place = std::move(place);
    }
    void fly() {
        finger_ = {};
        finger_.point = goal_;
    }

    const Surface& surface_;
    Solution& solution_;
    Finger& finger_;
    const Vec& goal_;
};

}  // namespace

std::optional<Place> first_hit(const Surface& surface, const Vec& from, const Place* start, const Vec& goal) {
    const auto part = part_in_front(surface, from, goal);
    if (!part) return std::nullopt;
    const bool on_surface = start && part->from_the_start;
    const ImagePoint a = on_surface ? image_of(surface, *start) : surface.image(part->from);
    const ImagePoint b = surface.image(part->to);
    const Real w = surface.scene().width, h = surface.scene().height;

    std::vector<Real> stops{1};
    const Place* origin = on_surface ? start : nullptr;
    add_crossings(
        stops, [](Real x, Real) { return x; }, a, b, origin, -1, w);
    add_crossings(
        stops, [](Real, Real y) { return y; }, a, b, origin, -1, h);
    add_crossings(
        stops, [](Real x, Real y) { return x - y; }, a, b, origin, -1 - h, w + 1);
    std::sort(stops.begin(), stops.end());

    auto x = [&](Real s) { return s == 1 ? b.x : a.x + s * (b.x - a.x); };
    auto y = [&](Real s) { return s == 1 ? b.y : a.y + s * (b.y - a.y); };
    auto above = [&](Real s) {
        const Real q = s == 1 ? b.q : a.q + s * (b.q - a.q);
        return q - surface.q(x(s), y(s));
    };
    // Between two stops the height above the surface, in q, is linear.
    Real s0 = 0, above0 = on_surface ? 0 : std::max(Real(0), above(0));
    for (const Real s1 : stops) {
        const Real above1 = above(s1);
        if (above1 < 0) {
            const Real s = s0 + (s1 - s0) * (above0 / (above0 - above1)), middle = (s0 + s1) / 2;
            return place_at(surface, x(s), y(s), x(middle), y(middle));
        }
        s0 = s1;
        above0 = above1;
    }
    return std::nullopt;
}

Finger finger_of(const Surface& surface, const Proxy& proxy) {
    Finger finger;
    finger.point = Vec(proxy.point);
    finger.sliding = proxy.sliding;
    if (proxy.on_surface()) {
        finger.place = place_of(surface, proxy);
        finger.point = point_of(surface, *finger.place);
    } else if (const auto at = surface.seen(finger.point); at && at->q < surface.q(at->x, at->y)) {
        finger.place = place_at(surface, at->x, at->y, at->x, at->y);
        finger.point = point_of(surface, *finger.place);
    }
    return finger;
}

Solution solve(const Surface& surface, Finger finger, const Vec& last_goal, const Vec& goal, int substeps) {
    Solution solution;
    solution.finger = std::move(finger);
    for (int k = 1; k <= substeps; ++k) {
        const Vec aim = k == substeps ? goal : last_goal + (goal - last_goal) * (Real(k) / substeps);
        Flow(surface, solution, aim).run();
    }
    return solution;
}

}  // namespace touchable::reference
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
namespace touchable::reference {
namespace {

bool all_in(const Place& some, const Place& others) {
    return std::all_of(some.parts.begin(), some.parts.end(),
                       [&](const Place::Part& part) { return others.has(part.corner); });
}

}  // namespace

Comparison compare(const Surface& surface, const Proxy& before, const Proxy& after, const Contact& contact) {
    const Vec goal(contact.goal), proxy(contact.proxy);
    const Finger start = finger_of(surface, before);
    const Solution truth = solve(surface, start, goal, goal);
    const Vec& p = truth.finger.point;
    Comparison result;
    result.capped = truth.capped;

    const bool touching = truth.finger.place.has_value();
    result.same_basin = touching == after.on_surface();
    if (touching && result.same_basin) {
        const Place here = reduced(place_of(surface, after)), there = reduced(*truth.finger.place);
        result.same_basin = all_in(here, there) || all_in(there, here);
    }

    Real rounding = 1e-13L * (length(p) + length(goal));
    // With friction the place where the slide began tells in the end.
    if (touching && contact.touching) rounding += rounding_at(surface, contact.proxy);
    if (start.place) rounding += rounding_at(surface, before.point);
    const Real have = length(proxy - goal), least = length(p - goal);
    const Real had = length(start.point - goal);
    result.farther = (have - rounding - had) / (1 + had);
    if (have > rounding) result.distance_ratio = have / std::max(least, rounding);
    if (touching && result.same_basin && least > rounding) {
        const Vec cross = glm::cross(proxy - goal, p - goal);
        const Real radians = std::max(Real(0), length(cross) / have - rounding) / least;
        result.angle_degrees = radians * 180 / 3.14159265358979323846L;
    }
    return result;
}

}  // namespace touchable::reference
