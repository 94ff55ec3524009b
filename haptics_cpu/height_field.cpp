// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/height_field.hpp"

namespace touchable {

namespace {

bool is_valid_in(const SurfaceFrame& frame, const SurfaceFrame* codes, int x, int y) {
    return codes ? codes->is_valid(x, y) : frame.vertices->at(x, y).valid;
}

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
    return next_ ? between(prev, x, y) : prev;
}

FieldVertex HeightField::between(const FieldVertex& prev, int x, int y) const {
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

/// How far a pixel is on its way to having no depth: 1 as long as it has none, and always in the ring. A
/// pixel that loses it half-way to the next frame is on its way from the frame before. When a hole closes,
/// the guard spreads the rise of stiffness.
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
    // Per corner, the most that is missing at it and its eight neighbours: so a cell with an invalid corner
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
        // Stiffness of the ring is that of the picture's edge: the wall there is of the same material.
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

}  // namespace touchable
