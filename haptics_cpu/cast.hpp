// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "haptics_cpu/world_space.hpp"

namespace touchable {

/// The paper's metric (sections 3.3.2 and 3.3.3): pixels sideways and grey levels in depth, z_p = 255 (far -
/// depth)/(far - near) by Eq. 3, as if they were one unit. Kept because its error is worth publishing
/// (docs/solver.md, Why not in pixel space): forces point tens of degrees wrong and create energy. For linear
/// coding and square pixels. Positions are (x, -y, kappa z_p), so that axes are right-handed; kappa is 1 for
/// the paper's metric. With the kappa of a point (`kappa_at`), the space has there, near the axis, the
/// world's metric but for a factor: shear and the change of range are left out.
class PixelSpace {
public:
    explicit PixelSpace(const HeightField& field, double kappa = 1.0) : field_(field), kappa_(kappa) {}

    /// Position of a world point in this space; nothing for a point that no pixel sees (WorldSpace::chart).
    std::optional<glm::dvec3> from_world(const glm::dvec3& point) const;
    glm::dvec3 to_world(const glm::dvec3& point) const;

    const HeightField& field() const { return field_; }
    /// The reference is valid until a vertex more than three away in i or j is requested.
    const SpaceVertex& vertex(std::int64_t i, std::int64_t j) const {
        return cache_.at(i, j, [=, this] { return compute_vertex(i, j); });
    }
    /// Validity of a vertex, without computing its position.
    bool is_valid(std::int64_t i, std::int64_t j) const {
        const SpaceVertex* known = cache_.find(i, j);
        return known ? known->valid : field_.is_valid(i, j);
    }
    glm::dvec3 position(const ChartPoint& at) const { return {at.x, -at.y, at.w}; }
    /// Every point that `from_world` returns is on the lattice.
    std::optional<ChartPoint> chart(const glm::dvec3& point) const {
        return ChartPoint{point.x, -point.y, point.z};
    }
    ImageStep image_step(const glm::dvec3&, const glm::dvec3& d) const { return {d.x, -d.y, 0.0}; }
    std::optional<ChartWay> way(const glm::dvec3& from, const glm::dvec3& to) const {
        return ChartWay{*chart(from), *chart(to), true};
    }
    double largest_w(int tile_x, int tile_y) const;

private:
    SpaceVertex compute_vertex(std::int64_t i, std::int64_t j) const;
    double level_of(double depth) const;
    const HeightField& field_;
    double kappa_;  // of one level; times 1 is exact, so the paper's metric is unchanged
    mutable VertexCache cache_;
};

/// Length of one level over the width of a pixel at a world point before the camera: the kappa with which a
/// level has its true length there. Finite, however near to the camera the point is.
double kappa_at(const Scene& scene, const glm::dvec3& point);

/// Result of a cast.
struct Cast {
    /// The first point at which the way goes from above (or on) the surface to below it; nothing: none.
    std::optional<Place> hit;
    /// Set if the work ran out: up to this point of the way it is known to stay above.
    std::optional<glm::dvec3> cut;
};

/// Follows the straight way from `from` to `to`. Watertight: at each lattice line that the way crosses, its w
/// is compared with that of the edge's two vertices alone, so both faces of an edge see the same number and
/// no crossing can be lost (docs/solver.md, Cast). `from_surface`: `from` is the surface's point at that
/// place, so its height above the surface is 0 by definition. `cells` counts the tested lattice lines, up to
/// `cell_limit`.
template <class Space>
Cast cast(const Space& space, const glm::dvec3& from, const Place* from_surface, const glm::dvec3& to,
          int& cells, int cell_limit);

/// True if one bound shows that the straight way between two free points stays in front of the surface, both
/// ends included: the cheap test for a finger far from everything. False: unknown.
bool is_clear(const auto& space, const glm::dvec3& from, const glm::dvec3& to);

}  // namespace touchable
