#include "player/session/clip_workspace.hpp"

#include <algorithm>
#include <vector>

#include "engine/surface/surface_builder.hpp"

namespace touchable {

namespace {

/// Lower median of frame 0's valid depths; the far plane where none is valid.
double median_depth(const Scene& scene, const SurfaceFrame& first) {
    // Every pixel is asked for: one by one, a lazy frame would take longer than all frames whole.
    SurfaceFrame whole;
    const bool is_lazy = first.codes.empty() && make_cpu_builder(scene)->build(first.raw, whole).ok();
    const SurfaceFrame& frame = is_lazy ? whole : first;
    std::vector<double> depths;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x)
            if (const DepthSample sample = frame.vertices->at(x, y); sample.valid)
                depths.push_back(sample.depth);
    if (depths.empty()) return scene.depth.far;
    const auto middle = depths.begin() + static_cast<std::ptrdiff_t>((depths.size() - 1) / 2);
    std::nth_element(depths.begin(), middle, depths.end());
    return *middle;
}

}  // namespace

Workspace clip_workspace(const Scene& scene, const SurfaceFrame& first) {
    Workspace workspace = default_workspace(scene.width, scene.camera.fx, median_depth(scene, first));
    if (scene.device_metres_per_unit) workspace.metres_per_scene_unit = *scene.device_metres_per_unit;
    return workspace;
}

}  // namespace touchable
