#include "player/run/clip_workspace.hpp"

#include <algorithm>
#include <vector>

#include "engine/surface/surface_builder.hpp"

namespace touchable {

namespace {

/// Of frame 0's valid depths, in order; the far plane where none is valid.
std::vector<double> depths_of(const Scene& scene, const SurfaceFrame& first) {
    // Every pixel is asked for: one by one, a lazy frame would take longer than all frames whole.
    SurfaceFrame whole;
    const bool is_lazy = first.codes.empty() && make_cpu_builder(scene)->build(first.raw, whole).ok();
    const SurfaceFrame& frame = is_lazy ? whole : first;
    std::vector<double> depths;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x)
            if (const DepthSample sample = frame.vertices->at(x, y); sample.valid)
                depths.push_back(sample.depth);
    if (depths.empty()) depths.push_back(scene.depth.far);
    return depths;
}

/// So many of them, of all, are not above it.
double quantile(std::vector<double>& depths, double share) {
    const auto at =
        depths.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(depths.size() - 1));
    std::nth_element(depths.begin(), at, depths.end());
    return *at;
}

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
    std::vector<double> depths = depths_of(scene, first);
    Workspace workspace = default_workspace(scene.width, scene.camera.fx, quantile(depths, 0.5));
    workspace.metres_per_scene_unit = scale_of(scene, workspace.metres_per_scene_unit);
    return workspace;
}

Workspace held_workspace(const Scene& scene, const SurfaceFrame& first, const glm::dvec3& reach) {
    std::vector<double> depths = depths_of(scene, first);
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
