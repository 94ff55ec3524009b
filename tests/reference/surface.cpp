#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "tests/reference/surface.hpp"

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
