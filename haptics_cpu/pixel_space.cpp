#include "haptics_cpu/pixel_space.hpp"

#include <algorithm>
#include <cmath>

namespace touchable {

double PixelSpace::level_of(double depth) const {
    const DepthCoding& coding = field_.scene().depth;
    return kappa_ * (255.0 * (coding.far - depth) / (coding.far - coding.near));
}

std::optional<glm::dvec3> PixelSpace::from_world(const glm::dvec3& point) const {
    if (!(point.z < 0)) return std::nullopt;
    const Scene& scene = field_.scene();
    const auto image = project(scene.camera, point);
    if (!image || !(std::abs(image->x) < farthest_pixel) || !(std::abs(image->y) < farthest_pixel))
        return std::nullopt;
    double depth = image->planar_depth;
    if (scene.depth.semantics == DepthSemantics::range) depth *= scene.camera.ray_length(image->x, image->y);
    const double level = level_of(depth);
    if (!std::isfinite(level)) return std::nullopt;
    return glm::dvec3{image->x, -image->y, level};
}

glm::dvec3 PixelSpace::to_world(const glm::dvec3& point) const {
    const Scene& scene = field_.scene();
    const double x = point.x, y = -point.y;
    const double depth = scene.depth.far - point.z / kappa_ * scene.depth.level();
    return unproject(scene.camera, x, y, planar_depth(scene.camera, scene.depth.semantics, x, y, depth));
}

SpaceVertex PixelSpace::compute_vertex(std::int64_t i, std::int64_t j) const {
    const FieldVertex vertex = field_.vertex(i, j);
    const double level = level_of(vertex.depth);
    return {{static_cast<double>(i), -static_cast<double>(j), level}, level, vertex.valid};
}

double PixelSpace::largest_w(int tile_x, int tile_y) const {
    const double level = level_of(field_.nearest_depth(tile_x, tile_y));
    return level + 1e-12 * std::abs(level);
}

double kappa_at(const Scene& scene, const glm::dvec3& point) {
    constexpr double nearest = 1e-15;  // than the surface of any scene
    return scene.depth.level() * scene.camera.fx / std::max(-point.z, nearest);
}

}  // namespace touchable
