#pragma once

#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>

#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

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

}  // namespace touchable::reference
