#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <vector>

#include "bench/gpu/frame_ring.hpp"
#include "bench/suite.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// A thread that ticks every millisecond of the wall clock, beside one that builds the frames which it feels.
struct LiveTouch {
    const Scene& scene;  ///< that the builder was made for
    const FrameRing& ring;
    const std::vector<glm::dvec3>& goals;  ///< tick by tick, in each the fingers'; begin anew after the last
    int fingers = 1;
    double rate = 0;  ///< frames a second; 0: as many as the builder makes
    double seconds = 1;
};

/// The times of a live touch.
struct LiveTimes {
    std::vector<double> late_us;  ///< of every tick, from when it was due until it began; ascending
    double cpu_ms_per_s = 0;      ///< CPU time of the process
    double frames_per_s = 0;
    double latency_ms =
        0;              ///< from when a frame was due (begun, without a rate) until it was published, mean
    bool fifo = false;  ///< SCHED_FIFO was granted to the ticks

    double late_us_at(double share) const;
};

/// Runs ticks and frames side by side. If `builder` is null, the ticks run alone and touch nothing.
Result<LiveTimes> touch_live(const LiveTouch& set_up, SurfaceBuilder* builder);

/// How late ticks of five fingers begin: alone, beside the CPU builder, and beside the Vulkan builder, each
/// of which builds frames in turn without a pause.
Result<void> measure_jitter(int width, int height, const TimedFilter& filter, double seconds,
                            const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);

}  // namespace touchable
