// SPDX-License-Identifier: Apache-2.0
#pragma once

// Generated scenes as tests and benchmarks touch them (docs/content.md): frames with unquantised depth, the
// surface's closest points, and goal paths, of one goal per tick of 1 ms, world, scene units.

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/content/families.hpp"

namespace touchable {

namespace goal_paths {

inline constexpr double tick_seconds = 0.001;

/// Outward normal at T seconds into the stroke.
inline glm::dvec3 stroke_normal(double seconds) {
    const double widest = 50 * pi / 180, limit = 0.72;
    double nx = sine(widest * sine(2 * pi * 0.37 * seconds));
    double ny = sine(widest * sine(2 * pi * 0.29 * seconds + 1));
    const double lateral = nx * nx + ny * ny;
    if (lateral > limit) {
        const double shrink = std::sqrt(limit / lateral);
        nx *= shrink;
        ny *= shrink;
    }
    return {nx, ny, std::sqrt(1 - nx * nx - ny * ny)};
}

/// Folds a position beyond +-limit back; returns true if it did.
inline bool reflect(double& position, double limit) {
    if (std::fabs(position) <= limit) return false;
    position = position > 0 ? 2 * limit - position : -2 * limit - position;
    return true;
}

/// A position folded back between two walls that it has passed by less than their distance.
inline double fold(double position, double low, double high) {
    if (position < low) return 2 * low - position;
    return position > high ? 2 * high - position : position;
}

}  // namespace goal_paths

/// Frame n of a scene with unquantised depth, for the solver: `vertices` is an ExactVertices; codes and tiles
/// are empty.
inline void exact_frame(const AnalyticScene& content, std::int64_t n, SurfaceFrame& out) {
    const Scene& scene = content.scene();
    const double t = content.time_of(n);
    out.width = scene.width;
    out.height = scene.height;
    out.coding = scene.depth;
    out.codes.clear();
    out.tiles.clear();
    out.validity.assign(
        static_cast<std::size_t>(out.validity_words_per_row()) * static_cast<std::size_t>(out.height), 0);
    for (int y = 0; y < out.height; ++y)
        for (int x = 0; x < out.width; ++x) out.validity_row(y)[x >> 5] |= std::uint32_t{1} << (x & 31);
    std::vector<double> depths(pixel_count(out.width, out.height));
    RowBands rows(threads_for_pixels(0, std::int64_t{out.width} * out.height));
    rows.for_each_band(out.height, 1, [&](const RowBand& band) {
        for (int y = band.first; y < band.last; ++y)
            content.row_depths(y, t, &depths[pixel_place(0, y, out.width)]);
    });
    copy_touch_planes(content.frame(n), out);
    out.raw = {};
    out.vertices = std::make_unique<ExactVertices>(out.width, out.height, std::move(depths));
}

/// A height field's surface: Z, and its derivatives.
inline ReliefPoint surface_at(Relief relief, double x, double y, double t) {
    return relief_at(relief, x, y, lift(relief, t) - tabletop_distance);
}

/// The closest points of a scene's surface, in closed form or by descent.
class ExactSurface {
public:
    /// The nearest point to a goal under the surface, and the outward unit normal there.
    struct Truth {
        glm::dvec3 point, normal;
    };

    explicit ExactSurface(std::string_view name, const SceneOptions& options = {})
        : name_(name), options_(options), scene_(make_scene(name, options).value()->scene()) {}

    /// Nearest surface point to `goal`; if the surface has several, searched by descent from `start` (a point
    /// on or near the surface). nullopt for scenes without a truth: noise, cliffs, grain, the planet's
    /// relief, and a globe of maps, whose facets between pixels have no tangent.
    std::optional<Truth> closest(const glm::dvec3& goal, const glm::dvec3& start, double t) const {
        if (name_ == "globe" && !options_.properties) return closest_on_globe(goal, start);
        if (name_ == "plane") return closest_on_plane(goal);
        if (name_ == "spheres") return closest_of_spheres(goal, start);
        if (name_ == "step") return closest_of_steps(goal);
        if (name_ == "bumps") return closest_on_relief(Relief::bumps, goal, start, t);
        if (name_ == "rough") return closest_on_relief(Relief::rough, goal, start, t);
        if (name_ == "moving") return closest_on_relief(Relief::moving, goal, start, t);
        return std::nullopt;
    }

private:
    /// A point of the steps' section at one Y: X and planar depth.
    struct Corner {
        double x, d;
    };
    struct Step {
        double x, y;
    };

    Truth closest_on_globe(const glm::dvec3& goal, const glm::dvec3& start) const;
    Truth closest_on_plane(const glm::dvec3& goal) const;
    static Truth closest_of_spheres(const glm::dvec3& goal, const glm::dvec3& start);
    Truth closest_of_steps(const glm::dvec3& goal) const;
    static Truth closest_on_relief(Relief relief, const glm::dvec3& goal, const glm::dvec3& start, double t);
    static void consider(Corner a, Corner b, const glm::dvec3& goal, double& least, Truth& best);
    static Step descent_step(const ReliefPoint& s, double dx, double dy, double dz);

    std::string name_;
    SceneOptions options_;
    Scene scene_;
};

/// The accuracy stroke: a straight approach along the first normal, then 1 mm of device space under the
/// globe.
class GlobeStroke {
public:
    static constexpr int approach_ticks = 200, stroke_ticks = 20000;

    /// For the globe without properties at this size.
    GlobeStroke(CameraPreset preset, int width, int height)
        : sphere_(globe_sphere(preset, width, height)),
          units_per_metre_(sphere_.radius / globe_device_radius) {}

    struct Goal {
        glm::dvec3 goal;
        glm::dvec3 normal;   ///< of the sphere under which the goal lies: the true direction of the force
        double polar_angle;  ///< of that normal from the axis to the camera, radians, at most 58.1 degrees
    };
    /// 0 <= tick < approach_ticks + stroke_ticks.
    Goal at(int tick) const;

private:
    GlobeSphere sphere_;
    double units_per_metre_;  // scene units per metre of device space
};

/// The stroke over a height field: constant lateral speed on a winding path, reflected 12 mm from the
/// picture's edges (at depth 1000), under the surface by 3.5 mm + 1.5 sin(2 pi 0.9 t) once the first 0.25 s
/// have brought it down from 50 mm above.
class ReliefStroke {
public:
    /// Speed in m/s (device and scene are one to one); the picture's height must leave more than 24 mm of
    /// surface.
    ReliefStroke(Relief relief, int width, int height, double speed);

    struct Goal {
        glm::dvec3 goal;
        double under;  ///< depth under the surface along Z, scene units; negative: above it
    };
    /// Returns the goals of ticks 0, 1, 2, ... in turn.
    Goal next();

private:
    void advance();

    Relief relief_;
    double limit_x_, limit_y_;  // the path stays within +-limit
    double step_;               // scene units per tick
    std::int64_t tick_ = 0;
    double x_ = 0, y_ = 0, heading_ = 0.3;
};

/// A goal path for the stress scenes: each tick moves by up to 1 pixel in x and y and 3 units of planar
/// depth, and every 50th tick on average jumps anywhere. It leaves the picture by up to 2 pixels, and the
/// depths of the scene a little.
class RandomWalk {
public:
    RandomWalk(const Scene& scene, std::uint64_t seed);
    glm::dvec3 next();

private:
    void jump() {
        for (int axis = 0; axis < 3; ++axis) at_[axis] = random_.within(low_[axis], high_[axis]);
    }

    Camera camera_;
    glm::dvec3 low_, high_;  // of column, row, planar depth
    SplitMix64 random_;
    glm::dvec3 at_;
};

inline ExactSurface::Truth ExactSurface::closest_on_globe(const glm::dvec3& goal,
                                                          const glm::dvec3& start) const {
    const GlobeSphere sphere = globe_sphere(options_.preset, options_.width, options_.height);
    glm::dvec3 outward = goal - sphere.centre;
    if (glm::dot(outward, outward) == 0) outward = start - sphere.centre;
    if (glm::dot(outward, outward) == 0) outward = {0, 0, 1};
    outward /= std::sqrt(glm::dot(outward, outward));
    return {sphere.centre + sphere.radius * outward, outward};
}

inline ExactSurface::Truth ExactSurface::closest_on_plane(const glm::dvec3& goal) const {
    const double tilt = options_.tilt_degrees * pi / 180,
                 direction = options_.tilt_direction_degrees * pi / 180;
    const glm::dvec3 normal{sine(tilt) * cosine(direction), sine(tilt) * sine(direction), cosine(tilt)};
    const double above = glm::dot(normal, goal - glm::dvec3(0, 0, -tabletop_distance));
    return {goal - above * normal, normal};
}

/// The nearest of the nearest points of each ball and of the wall, whether or not the camera sees it.
inline ExactSurface::Truth ExactSurface::closest_of_spheres(const glm::dvec3& goal, const glm::dvec3& start) {
    struct Ball {
        glm::dvec3 centre;
        double radius;
    };
    const double wall = 1080;
    const Ball balls[] = {{{-22, 4, -1020}, 45}, {{35, -10, -960}, 30}};
    Truth best{{goal.x, goal.y, -wall}, {0, 0, 1}};
    double least = std::fabs(goal.z + wall);
    for (const Ball& ball : balls) {
        const glm::dvec3 outward = goal == ball.centre ? start - ball.centre : goal - ball.centre;
        const double length = std::sqrt(glm::dot(outward, outward));
        const glm::dvec3 normal = length > 0 ? outward / length : glm::dvec3(0, 0, 1);
        const glm::dvec3 point = ball.centre + ball.radius * normal, way = point - goal;
        const double distance = std::sqrt(glm::dot(way, way));
        if (distance < least) {
            least = distance;
            best = {point, normal};
        }
    }
    return best;
}

/// Across the picture the surface is a polyline in (X, planar depth), the same at every Y.
inline ExactSurface::Truth ExactSurface::closest_of_steps(const glm::dvec3& goal) const {
    const int bands = 11, lowest_level = 100;
    const auto depth_of = [&](int band) {
        return scene_.depth.far - scene_.depth.level() * (lowest_level + band * (band + 1) / 2);
    };
    // Left edge of a band as X / planar depth.
    const auto edge_of = [&](int band) {
        return scene_.camera.u(static_cast<double>(band) * scene_.width / bands - 0.5);
    };
    Truth best{};
    double least = -1;
    for (int band = 0; band < bands; ++band) {
        const double d = depth_of(band);
        // The outermost bands go on far beyond the picture.
        const double left = band == 0 ? -1e6 : d * edge_of(band),
                     right = band == bands - 1 ? 1e6 : d * edge_of(band + 1);
        consider({left, d}, {right, d}, goal, least, best);
        if (band + 1 < bands)
            consider({right, d}, {depth_of(band + 1) * edge_of(band + 1), depth_of(band + 1)}, goal, least,
                     best);
    }
    return best;
}

/// Updates `best` from one straight piece, given from its left end to its right as the camera sees it.
inline void ExactSurface::consider(Corner a, Corner b, const glm::dvec3& goal, double& least, Truth& best) {
    const double dx = b.x - a.x, dd = b.d - a.d, squared = dx * dx + dd * dd;
    const double along = std::clamp(((goal.x - a.x) * dx + (-goal.z - a.d) * dd) / squared, 0.0, 1.0);
    const Corner point{a.x + along * dx, a.d + along * dd};
    const double off_x = point.x - goal.x, off_d = point.d + goal.z, distance = off_x * off_x + off_d * off_d;
    if (least >= 0 && distance >= least) return;
    least = distance;
    const double length = std::sqrt(squared);
    best = {{point.x, goal.y, -point.d}, {dd / length, 0, dx / length}};
}

/// Newton's step for half the squared distance to the goal if its Hessian is positive definite, else straight
/// down the gradient; never longer than 0.1 mm, so that the descent stays in the basin it began in.
inline ExactSurface::Step ExactSurface::descent_step(const ReliefPoint& s, double dx, double dy, double dz) {
    const double gx = dx + dz * s.zx, gy = dy + dz * s.zy;
    const double hxx = 1 + s.zx * s.zx + dz * s.zxx, hyy = 1 + s.zy * s.zy + dz * s.zyy;
    const double hxy = s.zx * s.zy + dz * s.zxy, det = hxx * hyy - hxy * hxy;
    Step step{-gx, -gy};
    if (hxx > 0 && det > 0) step = {(-gx * hyy + gy * hxy) / det, (-gy * hxx + gx * hxy) / det};
    const double length = std::sqrt(step.x * step.x + step.y * step.y), longest = 0.1;
    return length <= longest ? step : Step{step.x / length * longest, step.y / length * longest};
}

inline ExactSurface::Truth ExactSurface::closest_on_relief(Relief relief, const glm::dvec3& goal,
                                                           const glm::dvec3& start, double t) {
    const auto half_square = [&](double x, double y, double z) {
        const double dx = x - goal.x, dy = y - goal.y, dz = z - goal.z;
        return 0.5 * (dx * dx + dy * dy + dz * dz);
    };
    double x = start.x, y = start.y;
    ReliefPoint s = surface_at(relief, x, y, t);
    double value = half_square(x, y, s.z);
    for (int round = 0; round < 20000; ++round) {
        Step step = descent_step(s, x - goal.x, y - goal.y, s.z - goal.z);
        double length = std::sqrt(step.x * step.x + step.y * step.y);
        bool taken = false;
        for (int halving = 0; halving < 40 && !taken; ++halving) {
            const ReliefPoint next = surface_at(relief, x + step.x, y + step.y, t);
            const double next_value = half_square(x + step.x, y + step.y, next.z);
            // The last, quadratic steps lower the distance by less than its own rounding.
            taken = next_value < value || length < 1e-6;
            if (taken) {
                x += step.x;
                y += step.y;
                s = next;
                value = next_value;
            } else {
                step = {0.5 * step.x, 0.5 * step.y};
                length *= 0.5;
            }
        }
        if (length < 1e-12) break;
    }
    const double length = std::sqrt(s.zx * s.zx + s.zy * s.zy + 1);
    return {{x, y, s.z}, {-s.zx / length, -s.zy / length, 1 / length}};
}

inline GlobeStroke::Goal GlobeStroke::at(int tick) const {
    assert(tick >= 0 && tick < approach_ticks + stroke_ticks);
    const int stroke_tick = std::max(0, tick - approach_ticks);
    const glm::dvec3 normal = goal_paths::stroke_normal(stroke_tick * goal_paths::tick_seconds);
    const double approach = static_cast<double>(std::min(tick, approach_ticks)) / approach_ticks;
    const double outside = 0.010 + (-0.001 - 0.010) * approach;  // metres of device space
    const double lateral = std::sqrt(normal.x * normal.x + normal.y * normal.y);
    return {sphere_.centre + (sphere_.radius + outside * units_per_metre_) * normal, normal,
            arcsine(lateral)};
}

inline ReliefStroke::ReliefStroke(Relief relief, int width, int height, double speed) : relief_(relief) {
    const double margin = 12;
    limit_x_ = 0.5 * tabletop_width - margin;
    limit_y_ = 0.5 * tabletop_width * (height - 1) / (width - 1) - margin;
    step_ = speed * 1000 * goal_paths::tick_seconds;
    assert(limit_y_ > step_);
}

inline ReliefStroke::Goal ReliefStroke::next() {
    const double t = static_cast<double>(tick_) * goal_paths::tick_seconds, entry = 0.25, above = 50;
    double under = 3.5 + 1.5 * sine(2 * pi * 0.9 * t);
    if (t < entry) under = -above + (under + above) * (t / entry);
    const Goal goal{{x_, y_, surface_at(relief_, x_, y_, t).z - under}, under};
    advance();
    return goal;
}

inline void ReliefStroke::advance() {
    const double t = static_cast<double>(tick_) * goal_paths::tick_seconds;
    x_ += step_ * cosine(heading_);
    y_ += step_ * sine(heading_);
    if (goal_paths::reflect(x_, limit_x_)) heading_ = pi - heading_;
    if (goal_paths::reflect(y_, limit_y_)) heading_ = -heading_;
    heading_ += (0.9 * sine(2 * pi * 0.37 * t) + 0.4) * goal_paths::tick_seconds;
    ++tick_;
}

inline RandomWalk::RandomWalk(const Scene& scene, std::uint64_t seed)
    : camera_(scene.camera),
      low_(-2, -2, 0.9 * scene.depth.near),
      high_(scene.width + 1, scene.height + 1, 1.05 * scene.depth.far),
      random_(seed),
      at_(0) {
    jump();
}

inline glm::dvec3 RandomWalk::next() {
    if (random_.next() % 50 == 0) {
        jump();
    } else {
        const glm::dvec3 reach{1, 1, 3};
        for (int axis = 0; axis < 3; ++axis)
            at_[axis] = goal_paths::fold(at_[axis] + random_.within(-reach[axis], reach[axis]), low_[axis],
                                         high_[axis]);
    }
    return unproject(camera_, at_.x, at_.y, at_.z);
}

}  // namespace touchable
