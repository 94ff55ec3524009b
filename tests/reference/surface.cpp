#include "tests/reference/surface.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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
