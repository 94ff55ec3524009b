// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "haptics_cpu/world_space.hpp"

/// A second touch solver, written from docs/conventions.md and docs/solver.md alone: long double, nothing
/// skipped, nothing cached, no arithmetic shared with haptics_cpu. Tests and benchmarks measure the fast one
/// against it.
namespace touchable::reference {

using Real = long double;
using Vec = glm::vec<3, Real>;

inline Real length(const Vec& v) {
    return std::sqrt(glm::dot(v, v));
}

/// A vertex of the lattice: pixels, the ring around them, and all whole numbers beyond.
struct Corner {
    std::int64_t i = 0, j = 0;
    bool operator==(const Corner&) const = default;
};

struct Vertex {
    Vec point;   ///< world, scene units
    Real q = 0;  ///< 1 / planar depth
    bool valid = false;
};

/// A position in the picture, and 1 / planar depth there.
struct ImagePoint {
    Real x = 0, y = 0, q = 0;
};

struct Properties {
    Real stiffness = 0, static_friction = 0, dynamic_friction = 0;  ///< stiffness in N/m
};

/// The surface between two frames: codes, validity and heights through the coding, the camera and the blend.
class Surface {
public:
    /// Refers to both. A frame without codes (exact depths) is read by its vertices.
    Surface(const Scene& scene, const FramePair& pair);

    const Scene& scene() const { return scene_; }
    Vertex vertex(Corner corner) const;
    /// 1 / planar depth of the surface at a position of the picture.
    Real q(Real x, Real y) const;
    /// At (cell.i + a, cell.j + b): each frame's, bilinear, and linear in time, the stiffness then mixed with
    /// that of holes; of both frictions the dynamic is at most the static.
    Properties properties(Corner cell, Real a, Real b) const;

    /// (u, v, -1).
    Vec ray(Real x, Real y) const;
    /// Where a point in front of the camera is seen.
    ImagePoint image(const Vec& point) const;
    /// Where any point is seen; nothing for one that no pixel worth the name sees: behind the camera, or so
    /// close to its plane that pixels could not be counted.
    std::optional<ImagePoint> seen(const Vec& point) const;
    /// No vertex has a smaller planar depth.
    Real least_planar_depth() const;

private:
    struct Pixel {
        Real depth = 0;
        bool valid = false;
    };
    Pixel pixel(const SurfaceFrame& frame, int x, int y) const;
    Pixel pixel(Corner corner) const;
    Real missing(Corner corner) const;
    Real most_missing_around(Corner corner) const;
    Properties felt_at(const SurfaceFrame& frame, int x, int y) const;

    const Scene& scene_;
    const SurfaceFrame& earlier_;
    const SurfaceFrame& later_;
    Real blend_;
};

/// A point of the surface as its corners weigh it in the world: one corner, two of an edge, or three of a
/// triangle. Weights add up to 1.
struct Place {
    struct Part {
        Corner corner;
        Real weight = 0;
    };
    std::vector<Part> parts;

    bool has(Corner corner) const;
};

/// The place of a proxy that is on the surface: the same pixel position on the same feature.
Place place_of(const Surface& surface, const Proxy& proxy);
/// The place seen at a position of the picture, on the triangle around (inside_x, inside_y).
Place place_at(const Surface& surface, Real x, Real y, Real inside_x, Real inside_y);
/// Without the corners of no weight: on a triangle's rim, the edge's.
Place reduced(const Place& place);

Vec point_of(const Surface& surface, const Place& place);
ImagePoint image_of(const Surface& surface, const Place& place);
Properties properties_at(const Surface& surface, const Place& place);

using Triangle = std::array<Corner, 3>;
/// Every triangle that has all the corners of the place: one, two or six.
std::vector<Triangle> triangles_around(const Place& place);

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
