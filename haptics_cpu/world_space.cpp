#include "haptics_cpu/world_space.hpp"

#include <algorithm>
#include <cmath>

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
        // Beyond the ring the surface continues flat: its depth is the ring's (clamped), the ray is the
        // vertex's own.
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

ChartPoint WorldSpace::chart(const glm::dvec3& point) const {
    const Camera& camera = field_.scene().camera;
    const double q = -1.0 / point.z;
    return {camera.cx + camera.fx * (point.x * q), camera.cy - camera.fy * (point.y * q), q};
}

ImageStep WorldSpace::image_step(const glm::dvec3& p, const glm::dvec3& d) const {
    // With zeta = -z: x = cx + fx X / zeta, so the pixel moves by fx (dX zeta - X dzeta) / zeta^2 at first,
    // and by that times s zeta / (zeta + s dzeta) in the end.
    const Camera& camera = field_.scene().camera;
    const double per_z = 1.0 / p.z, per_z2 = per_z * per_z;
    return {camera.fx * ((d.z * p.x - d.x * p.z) * per_z2), -camera.fy * ((d.z * p.y - d.y * p.z) * per_z2),
            d.z * per_z};
}

std::optional<SegmentRange> WorldSpace::clip(const glm::dvec3& from, const glm::dvec3& to) const {
    double margin = 0.5 * field_.nearest_depth_anywhere();
    if (range_) {
        const Camera& camera = field_.scene().camera;
        const double w = field_.width(), h = field_.height();
        margin /= std::max({camera.ray_length(-1, -1), camera.ray_length(w, -1), camera.ray_length(-1, h),
                            camera.ray_length(w, h)});
    }
    const double d0 = -from.z - margin, d1 = -to.z - margin;
    if (d0 < 0 && d1 < 0) return std::nullopt;
    SegmentRange range{0, 1};
    if (d0 < 0) range.begin = d0 / (d0 - d1);
    if (d1 < 0) range.end = d0 / (d0 - d1);
    return range;
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

}  // namespace touchable
