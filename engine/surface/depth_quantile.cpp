#include "engine/surface/depth_quantile.hpp"

#include <algorithm>

#include "engine/surface/surface_builder.hpp"

namespace touchable {

std::vector<double> valid_depths(const Scene& scene, const SurfaceFrame& given) {
    // Every pixel is asked for: one by one, a lazy frame would take longer than all frames whole.
    SurfaceFrame whole;
    const bool is_lazy = given.codes.empty() && make_cpu_builder(scene)->build(given.raw, whole).ok();
    const SurfaceFrame& frame = is_lazy ? whole : given;
    std::vector<double> depths;
    for (int y = 0; y < scene.height; ++y)
        for (int x = 0; x < scene.width; ++x)
            if (const DepthSample sample = frame.vertices->at(x, y); sample.valid)
                depths.push_back(sample.depth);
    if (depths.empty()) depths.push_back(scene.depth.far);
    return depths;
}

double quantile(std::vector<double>& depths, double share) {
    const auto at =
        depths.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(depths.size() - 1));
    std::nth_element(depths.begin(), at, depths.end());
    return *at;
}

}  // namespace touchable
