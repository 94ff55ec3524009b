#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/vertex_cache.hpp"

namespace touchable {

/// A point as the image sees it: pixel coordinates and w. Straight lines and flat triangles of the space are
/// straight and flat in (x, y, w).
struct ChartPoint {
    double x, y, w;
};
/// How a straight move p + s d runs over the picture: by (dx, dy) times s / (1 + s stretch).
struct ImageStep {
    double dx, dy;
    double stretch;
    /// Infinite where the move reaches the camera's plane before s.
    double length_at(double s) const {
        const double denominator = 1.0 + s * stretch;
        return denominator > 0 ? s / denominator : std::numeric_limits<double>::infinity();
    }
};
/// The part of a straight way that can meet the surface, as the image sees it.
struct ChartWay {
    ChartPoint begin, end;
    bool from_the_start;  ///< nothing was cut off before `begin`
};

/// Farther from the picture than any lattice place that means something, and well inside what integers can
/// count.
inline constexpr double farthest_pixel = 1e15;

/// The solver's metric as it should be: world space, scene units. w = q = 1 / planar depth makes (x, y, q) a
/// projective chart of it: incidence is decided in the chart, distance in the world (docs/solver.md, Why not
/// in pixel space). PixelSpace has the same members.
class WorldSpace {
public:
    /// One tick's; not for two threads at once.
    explicit WorldSpace(const HeightField& field);

    std::optional<glm::dvec3> from_world(const glm::dvec3& point) const { return point; }
    glm::dvec3 to_world(const glm::dvec3& point) const { return point; }

    const HeightField& field() const { return field_; }
    /// Stays as it is until a vertex more than three away in i or j is asked for.
    const SpaceVertex& vertex(std::int64_t i, std::int64_t j) const {
        return cache_.at(i, j, [=, this] { return compute_vertex(i, j); });
    }
    /// Of a vertex whose place is not asked for, and is not computed for this.
    bool is_valid(std::int64_t i, std::int64_t j) const {
        const SpaceVertex* known = cache_.find(i, j);
        return known ? known->valid : field_.is_valid(i, j);
    }
    glm::dvec3 position(const ChartPoint& at) const;
    /// Where a point is seen. This is the one way from the world to the lattice: nothing for a point that no
    /// pixel worth the name sees (behind the camera, in its plane, or so near to that that it lies farther
    /// than `farthest_pixel` from the picture) and for what is no number. Such a point counts as in front of
    /// the surface.
    std::optional<ChartPoint> chart(const glm::dvec3& point) const;
    ImageStep image_step(const glm::dvec3& point, const glm::dvec3& direction) const;
    /// Cuts away what is nearer to the camera than half the nearest possible surface, and what no pixel sees.
    std::optional<ChartWay> way(const glm::dvec3& from, const glm::dvec3& to) const;
    /// No surface point of the tile has a larger w.
    double largest_w(int tile_x, int tile_y) const;

private:
    SpaceVertex compute_vertex(std::int64_t i, std::int64_t j) const;
    glm::dvec3 at_depth(double x, double y, double planar_depth) const;
    double nearest_planar_depth() const;
    std::optional<ChartWay> countable(const glm::dvec3& from, const glm::dvec3& to,
                                      bool from_the_start) const;

    const HeightField& field_;
    double per_fx_, per_fy_;  // 1 / focal length
    bool range_;
    mutable VertexCache cache_;
};

}  // namespace touchable
