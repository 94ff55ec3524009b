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

}  // namespace touchable::reference
