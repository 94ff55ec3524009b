#include "engine/scene/camera.hpp"

namespace touchable {

Camera camera_from_focal_length(double focal_length, double pixel_width, int width, int height) {
    const double focal_pixels = focal_length / pixel_width;
    return {focal_pixels, focal_pixels, width / 2.0, height / 2.0 - 1.0};
}

double planar_depth(const Camera& camera, DepthSemantics semantics, double x, double y, double depth) {
    return semantics == DepthSemantics::range ? depth / camera.ray_length(x, y) : depth;
}

glm::dvec3 unproject(const Camera& camera, double x, double y, double planar_depth) {
    return {planar_depth * camera.u(x), planar_depth * camera.v(y), -planar_depth};
}

std::optional<ImagePoint> project(const Camera& camera, const glm::dvec3& point) {
    if (!(point.z < 0.0)) return std::nullopt;
    const double planar_depth = -point.z;
    return ImagePoint{camera.cx + camera.fx * (point.x / planar_depth),
                      camera.cy - camera.fy * (point.y / planar_depth), planar_depth};
}

}  // namespace touchable
