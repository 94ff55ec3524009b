#include "engine/surface/depth_quantile.hpp"

#include <algorithm>

#include "engine/base/stop_request.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

std::vector<double> valid_depths(const Scene& scene, const SurfaceFrame& given) {
    // Every pixel is asked for: one by one, a lazy frame would take longer than all frames whole.
    SurfaceFrame whole;
    const bool is_lazy = given.codes.empty() && make_cpu_builder(scene)->build(given.raw, whole).ok();
    const SurfaceFrame& frame = is_lazy ? whole : given;
    const auto width = static_cast<std::size_t>(scene.width);
    const std::size_t pixels = width * static_cast<std::size_t>(scene.height);
    constexpr std::size_t enough = std::size_t{4096} * 4096;
    const std::size_t step = pixels > enough ? pixels / enough | 1U : 1;  // no even width divides it
    std::vector<double> depths;
    depths.reserve(pixels / step);
    until_stopped(pixels / step, [&](std::size_t first, std::size_t last) {
        for (std::size_t k = first * step; k < last * step; k += step)
            if (const DepthSample sample =
                    frame.vertices->at(static_cast<int>(k % width), static_cast<int>(k / width));
                sample.valid)
                depths.push_back(sample.depth);
    });
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
