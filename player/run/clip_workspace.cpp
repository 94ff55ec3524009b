#include "player/run/clip_workspace.hpp"

#include <algorithm>
#include <vector>

#include "engine/surface/depth_quantile.hpp"

namespace touchable {

namespace {

// Of a clip's depths, the nearest and the deepest that count: what lies beyond may be noise.
constexpr double nearest_share = 0.02, deepest_share = 0.98;
constexpr double clearance = 0.02;  // device metres

double scale_of(const Scene& scene, double otherwise) {
    return scene.device_metres_per_unit.value_or(otherwise);
}

/// What is seen between the nearest and the deepest that count, and a fifth of it in front.
Workspace fitted(const Scene& scene, std::vector<double>& depths, double median, const glm::dvec3& reach) {
    const double near = quantile(depths, nearest_share), far = quantile(depths, deepest_share);
    const double wide = scene.width / scene.camera.fx * median,
                 high = scene.height / scene.camera.fy * median;
    const double least_room = 0.05 * wide, room = std::max(0.2 * (far - near), least_room);
    const double deep = far - near + 2 * room;
    const double scale = std::min({2 * reach.x / wide, 2 * reach.y / high, 2 * reach.z / deep});
    return {scale, {0, 0, -(near + far) / 2}};
}

}  // namespace

Workspace clip_workspace(const Scene& scene, const SurfaceFrame& first) {
    std::vector<double> depths = valid_depths(scene, first);
    Workspace workspace = default_workspace(scene.width, scene.camera.fx, quantile(depths, 0.5));
    workspace.metres_per_scene_unit = scale_of(scene, workspace.metres_per_scene_unit);
    return workspace;
}

Workspace held_workspace(const Scene& scene, const SurfaceFrame& first, const glm::dvec3& reach) {
    std::vector<double> depths = valid_depths(scene, first);
    const double median = quantile(depths, 0.5);
    const bool has_reach = reach.x > 0 && reach.y > 0 && reach.z > 0;
    Workspace workspace = has_reach ? fitted(scene, depths, median, reach)
                                    : default_workspace(scene.width, scene.camera.fx, median);
    workspace.metres_per_scene_unit = scale_of(scene, workspace.metres_per_scene_unit);
    if (!has_reach)
        workspace.origin.z = clearance / workspace.metres_per_scene_unit - quantile(depths, nearest_share);
    return workspace;
}

}  // namespace touchable
