// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "bench/gpu/frame_ring.hpp"
#include "bench/suite.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// Settings of a thread that ticks every millisecond of the wall clock, and of a thread that builds the
/// frames it touches.
struct LiveTouch {
    const Scene& scene;  ///< the builder's scene
    const FrameRing& ring;
    const std::vector<glm::dvec3>& goals;  ///< all fingers of tick 0, of tick 1, ...; repeated after the last
    int fingers = 1;
    double rate = 0;  ///< frames per second; 0: as fast as the builder
    double seconds = 1;
};

/// The times of a live touch.
struct LiveTimes {
    std::vector<double> late_us;  ///< delay of every tick's begin; ascending
    double cpu_ms_per_s = 0;      ///< CPU time of the process
    double frames_per_s = 0;
    double latency_ms = 0;  ///< from due (or begun) to published, mean
    bool fifo = false;      ///< the ticks had SCHED_FIFO

    double late_us_at(double share) const;
};

/// Runs ticks and frames in parallel. If `builder` is null, the ticks run alone and touch nothing.
Result<LiveTimes> touch_live(const LiveTouch& set_up, SurfaceBuilder* builder);

/// Measures the delay of ticks of five fingers: alone, beside the CPU builder, and beside the Vulkan builder;
/// the builders build frames without a pause.
Result<void> measure_jitter(int width, int height, const TimedFilter& filter, double seconds,
                            const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);

}  // namespace touchable
