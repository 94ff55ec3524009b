// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/world_space.hpp"

#include <glm/geometric.hpp>

namespace touchable {

namespace {

double clamp_to_ring(std::int64_t index, int size) {
    return static_cast<double>(std::clamp<std::int64_t>(index, -1, size));
}

// A bound is rounded outward by far more than the few roundings that lead to the values it bounds.
constexpr double outward = 1.0 + 1e-12;

}  // namespace

WorldSpace::WorldSpace(const HeightField& field)
    : field_(field),
      per_fx_(1.0 / field.scene().camera.fx),
      per_fy_(1.0 / field.scene().camera.fy),
      range_(field.scene().depth.semantics == DepthSemantics::range) {}

SpaceVertex WorldSpace::compute_vertex(std::int64_t i, std::int64_t j) const {
    const FieldVertex vertex = field_.vertex(i, j);
    double planar = vertex.depth;
    if (range_) {
        // Beyond the ring the surface continues flat: with the ring's depth (clamped), on the vertex's own
        // ray.
        planar /= field_.scene().camera.ray_length(clamp_to_ring(i, field_.width()),
                                                   clamp_to_ring(j, field_.height()));
    }
    return {at_depth(static_cast<double>(i), static_cast<double>(j), planar), 1.0 / planar, vertex.valid};
}

glm::dvec3 WorldSpace::at_depth(double x, double y, double planar_depth) const {
    const Camera& camera = field_.scene().camera;
    return {(x - camera.cx) * per_fx_ * planar_depth, -((y - camera.cy) * per_fy_) * planar_depth,
            -planar_depth};
}

glm::dvec3 WorldSpace::position(const ChartPoint& at) const {
    return at_depth(at.x, at.y, 1.0 / at.w);
}

std::optional<ChartPoint> WorldSpace::chart(const glm::dvec3& point) const {
    if (!(point.z < 0)) return std::nullopt;
    const Camera& camera = field_.scene().camera;
    const double q = -1.0 / point.z;
    const ChartPoint at{camera.cx + camera.fx * (point.x * q), camera.cy - camera.fy * (point.y * q), q};
    // Written so that NaN fails.
    const bool counted = std::abs(at.x) < farthest_pixel && std::abs(at.y) < farthest_pixel &&
                         q <= std::numeric_limits<double>::max();
    return counted ? std::optional(at) : std::nullopt;
}

ImageStep WorldSpace::image_step(const glm::dvec3& p, const glm::dvec3& d) const {
    // With zeta = -z: x = cx + fx X / zeta, so the pixel moves by fx (dX zeta - X dzeta) / zeta^2 at first,
    // and by that times s zeta / (zeta + s dzeta) in the end.
    const Camera& camera = field_.scene().camera;
    const double per_z = 1.0 / p.z, per_z2 = per_z * per_z;
    return {camera.fx * ((d.z * p.x - d.x * p.z) * per_z2), -camera.fy * ((d.z * p.y - d.y * p.z) * per_z2),
            d.z * per_z};
}

double WorldSpace::nearest_planar_depth() const {
    const double nearest = field_.nearest_depth_anywhere();
    if (!range_) return nearest;
    const Camera& camera = field_.scene().camera;
    const double w = field_.width(), h = field_.height();
    return nearest / std::max({camera.ray_length(-1, -1), camera.ray_length(w, -1), camera.ray_length(-1, h),
                               camera.ray_length(w, h)});
}

std::optional<ChartWay> WorldSpace::way(const glm::dvec3& from, const glm::dvec3& to) const {
    const double margin = 0.5 * nearest_planar_depth();
    const double d0 = -from.z - margin, d1 = -to.z - margin;
    if (d0 < 0 && d1 < 0) return std::nullopt;
    glm::dvec3 first = from, last = to;
    if (d0 < 0 || d1 < 0) {
        // The depth there is known, whatever rounding says: a way of 10^9 units through the camera's plane
        // would otherwise end in that plane.
        glm::dvec3 cut = from + (to - from) * (d0 / (d0 - d1));
        cut.z = -margin;
        (d0 < 0 ? first : last) = cut;
    }
    const auto begin = chart(first), end = chart(last);
    if (begin && end) return ChartWay{*begin, *end, d0 >= 0};
    return countable(first, last, d0 >= 0);
}

/// Both points are in front of the camera, but not both are seen: cuts the way at the planes through the
/// camera beyond which pixels are not counted.
std::optional<ChartWay> WorldSpace::countable(const glm::dvec3& from, const glm::dvec3& to,
                                              bool from_the_start) const {
    const Camera& camera = field_.scene().camera;
    constexpr double most = 0.5 * farthest_pixel;  // from the axis; the picture is nearer to it
    double begin = 0, end = 1;
    for (const glm::dvec3& plane : {glm::dvec3(camera.fx, 0, -most), glm::dvec3(-camera.fx, 0, -most),
                                    glm::dvec3(0, camera.fy, -most), glm::dvec3(0, -camera.fy, -most)}) {
        const double inside0 = glm::dot(plane, from), inside1 = glm::dot(plane, to);
        if (inside0 < 0 && inside1 < 0) return std::nullopt;
        if (inside0 < 0) begin = std::max(begin, inside0 / (inside0 - inside1));
        if (inside1 < 0) end = std::min(end, inside0 / (inside0 - inside1));
    }
    if (!(begin < end)) return std::nullopt;
    const auto first = chart(begin > 0 ? from + (to - from) * begin : from);
    const auto last = chart(end < 1 ? from + (to - from) * end : to);
    if (!first || !last) return std::nullopt;
    return ChartWay{*first, *last, from_the_start && begin == 0};
}

double WorldSpace::largest_w(int tile_x, int tile_y) const {
    const double nearest = field_.nearest_depth(tile_x, tile_y);
    double bound = outward / nearest;
    if (range_) {
        // |(u, v, -1)| is convex: largest at a corner of the tile, which reaches to the ring at the picture's
        // edge.
        const Camera& camera = field_.scene().camera;
        const TileGrid tiles = field_.tiles();
        const int n = TileGrid::cells;
        const double x0 = tile_x == 0 ? -1 : tile_x * n;
        const double x1 = tile_x == tiles.tiles_x - 1 ? field_.width() : (tile_x + 1) * n;
        const double y0 = tile_y == 0 ? -1 : tile_y * n;
        const double y1 = tile_y == tiles.tiles_y - 1 ? field_.height() : (tile_y + 1) * n;
        bound *= std::max({camera.ray_length(x0, y0), camera.ray_length(x1, y0), camera.ray_length(x0, y1),
                           camera.ray_length(x1, y1)});
    }
    return bound;
}

glm::dvec3 point_under(const HeightField& field, double x, double y) {
    return surface_point(WorldSpace(field), face_under(x, y));
}

double surface_depth(const HeightField& field, const Place& at) {
    return 1.0 / surface_w(WorldSpace(field), at);
}

}  // namespace touchable
