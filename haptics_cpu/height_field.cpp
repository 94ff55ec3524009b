#include "haptics_cpu/height_field.hpp"

#include <glm/geometric.hpp>

namespace touchable {

namespace {

bool is_valid_in(const SurfaceFrame& frame, const SurfaceFrame* codes, int x, int y) {
    return codes ? codes->is_valid(x, y) : frame.vertices->at(x, y).valid;
}

double clamp_to_ring(std::int64_t index, int size) {
    return static_cast<double>(std::clamp<std::int64_t>(index, -1, size));
}

// A bound is rounded outward by far more than the few roundings that lead to the values it bounds.
constexpr double outward = 1.0 + 1e-12;

}  // namespace

HeightField::HeightField(const Scene& scene, const FramePair& pair)
    : scene_(scene),
      prev_(pair.prev.frame),
      prev_codes_(prev_->vertices->read_from()),
      nearer_(prev_),
      moment_ns_(static_cast<double>(pair.prev.time_ns)),
      epoch_(pair.epoch),
      interval_ns_(pair.next.time_ns - pair.prev.time_ns) {
    if (scene.interpolation == FrameInterpolation::linear && pair.blend > 0) {
        blend_ = pair.blend;
        moment_ns_ += blend_ * static_cast<double>(pair.next.time_ns - pair.prev.time_ns);
        if (pair.next.frame != prev_) {
            next_ = pair.next.frame;
            next_codes_ = next_->vertices->read_from();
            if (blend_ >= 0.5) nearer_ = next_;
        }
    }
    has_haptic_image_ = !prev_->haptic.empty() || (next_ && !next_->haptic.empty());
    tiles_ = TileGrid::of(scene.width, scene.height);
    const bool has_heights = !prev_->heights.empty() || (next_ && !next_->heights.empty());
    if (has_heights) {
        largest_height_ = largest_height(scene.height_coding, scene.depth);
        height_per_code_ = largest_height_ / scene.height_coding.code_max;
    }
    default_properties_ = scene.default_properties;
    default_properties_.dynamic_friction =
        std::min(default_properties_.dynamic_friction, default_properties_.static_friction);
    has_friction_ = has_haptic_image_ || scene.default_properties.static_friction > 0;
}

FieldVertex HeightField::frame_vertex(const SurfaceFrame& frame, const SurfaceFrame* codes, int x,
                                      int y) const {
    const DepthSample sample = codes ? sample_of(*codes, x, y) : frame.vertices->at(x, y);
    if (!sample.valid) return {scene_.depth.far, false};
    if (frame.heights.empty()) return {sample.depth, true};
    // The paper's Eq. 2, as a length: height is taken off the depth.
    return {sample.depth - height_per_code_ * frame.heights[frame.index(x, y)], true};
}

FieldVertex HeightField::vertex(std::int64_t i, std::int64_t j) const {
    if (!is_pixel(i, j)) return {scene_.depth.far, false};
    const int x = static_cast<int>(i), y = static_cast<int>(j);
    const FieldVertex prev = frame_vertex(*prev_, prev_codes_, x, y);
    if (!next_) return prev;
    const FieldVertex next = frame_vertex(*next_, next_codes_, x, y);
    if (prev.valid != next.valid) return nearer_ == prev_ ? prev : next;
    return {prev.depth + (next.depth - prev.depth) * blend_, prev.valid};
}

std::array<FieldVertex, 2> HeightField::vertices_of_frames(std::int64_t i, std::int64_t j) const {
    if (!is_pixel(i, j)) return {FieldVertex{scene_.depth.far, false}, FieldVertex{scene_.depth.far, false}};
    const int x = static_cast<int>(i), y = static_cast<int>(j);
    const FieldVertex prev = frame_vertex(*prev_, prev_codes_, x, y);
    return {prev, next_ ? frame_vertex(*next_, next_codes_, x, y) : prev};
}

bool HeightField::is_valid(std::int64_t i, std::int64_t j) const {
    const SurfaceFrame* codes = nearer_ == prev_ ? prev_codes_ : next_codes_;
    return is_pixel(i, j) && is_valid_in(*nearer_, codes, static_cast<int>(i), static_cast<int>(j));
}

double HeightField::nearest_depth(int tile_x, int tile_y) const {
    auto nearest_of = [&](const SurfaceFrame& frame) {
        const TileDepths depths = frame.vertices->tile(tile_x, tile_y);
        return depths.nearest <= depths.farthest ? std::min(depths.nearest, scene_.depth.far)
                                                 : scene_.depth.far;
    };
    double nearest = nearest_of(*prev_);
    if (next_) nearest = std::min(nearest, nearest_of(*next_));
    return nearest - largest_height_;
}

/// How far a pixel is on its way to having no depth: 1 as long as it has none, and the ring never has any.
/// One that loses it half-way to the next frame is on its way from the frame before. When a hole closes the
/// rise of stiffness is the guard's to spread.
double HeightField::missing(std::int64_t i, std::int64_t j) const {
    if (!is_pixel(i, j)) return 1;
    const int x = static_cast<int>(i), y = static_cast<int>(j);
    const bool before = is_valid_in(*prev_, prev_codes_, x, y);
    if (!next_) return before ? 0 : 1;
    const bool after = is_valid_in(*next_, next_codes_, x, y);
    if (!(nearer_ == prev_ ? before : after)) return 1;
    return before && !after ? 2 * blend_ : 0;
}

double HeightField::missing_around(std::int64_t i, std::int64_t j, double a, double b) const {
    // Of a corner the most that is missing at it and its eight neighbours: so a cell with an invalid corner
    // is all hole, down to the rim of the wall.
    std::array<double, 4> share{};
    for (int dj = -1; dj <= 2; ++dj)
        for (int di = -1; di <= 2; ++di) {
            const double missing_here = missing(i + di, j + dj);
            if (missing_here == 0) continue;
            for (int corner = 0; corner < 4; ++corner) {
                const int across = di - (corner & 1), down = dj - (corner >> 1);
                double& most = share[static_cast<std::size_t>(corner)];
                if (across * across <= 1 && down * down <= 1) most = std::max(most, missing_here);
            }
        }
    return bilinear(a, b, share[0], share[1], share[2], share[3]);
}

double HeightField::with_holes(double stiffness, std::int64_t i, std::int64_t j, double a, double b) const {
    if (!scene_.hole_stiffness) return stiffness;
    const double share = hole_share(i, j, a, b);
    return (1.0 - share) * stiffness + share * (*scene_.hole_stiffness * 1000.0);
}

HapticProperties HeightField::properties_in(const SurfaceFrame& frame, int x, int y) const {
    if (frame.haptic.empty()) return scene_.default_properties;
    const std::uint8_t* p = &frame.haptic[3 * frame.index(x, y)];
    return scene_.haptic.at(p[0], p[1], p[2]);
}

HapticProperties HeightField::vertex_properties(std::int64_t i, std::int64_t j, bool valid) const {
    HapticProperties properties = default_properties_;
    if (has_haptic_image_) {
        // Stiffness of the ring is the picture's edge's: what one feels there is a wall of the same stuff.
        const int x = static_cast<int>(std::clamp<std::int64_t>(i, 0, scene_.width - 1));
        const int y = static_cast<int>(std::clamp<std::int64_t>(j, 0, scene_.height - 1));
        properties = properties_in(*prev_, x, y);
        if (next_) {
            const HapticProperties next = properties_in(*next_, x, y);
            const auto go_on = [this](double& from, double to) { from += (to - from) * blend_; };
            go_on(properties.stiffness, next.stiffness);
            go_on(properties.static_friction, next.static_friction);
            go_on(properties.dynamic_friction, next.dynamic_friction);
        }
    }
    if (!valid) {
        properties.static_friction = 0;
        properties.dynamic_friction = 0;
    }
    return properties;
}

CornerProperties HeightField::corner_properties(std::int64_t i, std::int64_t j,
                                                const std::array<bool, 4>& valid) const {
    return {vertex_properties(i, j, valid[0]), vertex_properties(i + 1, j, valid[1]),
            vertex_properties(i, j + 1, valid[2]), vertex_properties(i + 1, j + 1, valid[3])};
}

HapticProperties HeightField::properties(std::int64_t i, std::int64_t j, double a, double b) const {
    return properties(
        i, j, a, b,
        {vertex(i, j).valid, vertex(i + 1, j).valid, vertex(i, j + 1).valid, vertex(i + 1, j + 1).valid});
}

HapticProperties HeightField::mixed_properties(std::int64_t i, std::int64_t j, double a, double b,
                                               const std::array<bool, 4>& valid) const {
    const CornerProperties p = corner_properties(i, j, valid);
    HapticProperties out;
    const auto mean = [&](double HapticProperties::*property) {
        return bilinear(a, b, p[0].*property, p[1].*property, p[2].*property, p[3].*property);
    };
    out.stiffness = with_holes(mean(&HapticProperties::stiffness), i, j, a, b);
    out.static_friction = mean(&HapticProperties::static_friction);
    out.dynamic_friction = mean(&HapticProperties::dynamic_friction);
    out.dynamic_friction = std::min(out.dynamic_friction, out.static_friction);
    return out;
}

double HeightField::mixed_stiffness(std::int64_t i, std::int64_t j, double a, double b) const {
    if (!has_haptic_image()) return with_holes(default_properties_.stiffness, i, j, a, b);
    const auto at = [&](int di, int dj) { return vertex_properties(i + di, j + dj, true).stiffness; };
    return with_holes(bilinear(a, b, at(0, 0), at(1, 0), at(0, 1), at(1, 1)), i, j, a, b);
}

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
        // The depth there is known, whatever rounding says of it: a way of 10^9 units through the camera's
        // plane would end in it.
        glm::dvec3 cut = from + (to - from) * (d0 / (d0 - d1));
        cut.z = -margin;
        (d0 < 0 ? first : last) = cut;
    }
    const auto begin = chart(first), end = chart(last);
    if (begin && end) return ChartWay{*begin, *end, d0 >= 0};
    return countable(first, last, d0 >= 0);
}

/// Both points are in front of the camera, not both are seen: the way is cut at the planes through the camera
/// beyond which pixels are not counted.
std::optional<ChartWay> WorldSpace::countable(const glm::dvec3& from, const glm::dvec3& to,
                                              bool from_the_start) const {
    const Camera& camera = field_.scene().camera;
    constexpr double most = 0.5 * farthest_pixel;  // from the axis; the picture is not as far from it
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

}  // namespace touchable
