// SPDX-License-Identifier: Apache-2.0
#include "bench/real/built_frames.hpp"

#include <algorithm>
#include <limits>

#include "bench/clocks.hpp"
#include "bench/surface/opencv_pipeline.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

Result<std::vector<SurfaceFrame>> built(const Filtering& filtering, const std::vector<RawFrame>& stored,
                                        bool barred) {
    const std::vector<RawFrame> raws = filtering.before ? filtering.before(stored) : stored;
    const Scene& scene = filtering.scene;
    std::vector<SurfaceFrame> frames(raws.size());
    auto builder = make_cpu_builder(scene);
    if (barred) builder = with_error_bars(std::move(builder), scene);
    for (std::size_t n = 0; n < raws.size(); ++n)
        if (auto done = builder->build(raws[n], frames[n]); !done) return done.error();
    return frames;
}

Result<void> measure_cost(const Scene& scene, const std::vector<RawFrame>& raws, int rounds,
                          Figures& figures) {
    const auto builder = make_cpu_builder(scene);
    Scene with_median = scene;
    with_median.filter.median = 5;
    OpenCvPipeline opencv(with_median, raws.front());
    SurfaceFrame slot;
    double cpu_ms = std::numeric_limits<double>::infinity(), wall_ms = cpu_ms, median_ms = cpu_ms;
    for (int n = 0; n < rounds; ++n) {
        RawFrame raw = raws[static_cast<std::size_t>(n) % raws.size()];
        raw.number = n;  // consecutive, as required by the temporal filter
        const std::int64_t cpu_begin = process_cpu_ns(), begin = monotonic_ns();
        if (auto done = builder->build(raw, slot); !done) return done;
        wall_ms = std::min(wall_ms, static_cast<double>(monotonic_ns() - begin) * 1e-6);
        const std::int64_t cpu_end = process_cpu_ns();
        cpu_ms = std::min(cpu_ms, static_cast<double>(cpu_end - cpu_begin) * 1e-6);
        opencv.median();
        median_ms = std::min(median_ms, static_cast<double>(process_cpu_ns() - cpu_end) * 1e-6);
    }
    figures.push_back({"frame_cpu_ms", cpu_ms, "ms"});
    figures.push_back({"frame_ms", wall_ms, "ms"});
    if (has_opencv()) figures.push_back({"frame_cpu_vs_opencv", cpu_ms / median_ms, ""});
    return {};
}

}  // namespace touchable
