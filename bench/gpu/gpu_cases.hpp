// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "bench/gpu/frame_ring.hpp"
#include "bench/suite.hpp"
#include "engine/content/scenes.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Measures the bandwidth of the device's memory (bandwidth.hpp) and the time of an empty submission.
Result<void> measure_device_memory(const std::shared_ptr<GpuDevice>& device, Figures& figures);

/// Measures copies of frames of 3840x2160 and 16 bits from each kind of host memory to the device and back.
/// The frames take turns and are together larger than any cache. An error of kind check if one comes back
/// changed.
Result<void> measure_bus(const std::shared_ptr<GpuDevice>& device, Figures& figures);

/// Error of forces on frames of a moving surface, because a frame shows the surface at its exposure and
/// because it is filtered.
///
/// The scene is `moving`, which rises and falls by 20 mm in half a second. A hand follows it 3 mm under the
/// true surface. The true force is k (P - G) with P the nearest point of the true surface of the moment; the
/// felt force is the solver's on the newest frame built by then. Only the pixels around the hand are made, at
/// the pixel pitch of the whole picture: filters give them the same bits.
class MovingForce {
public:
    static Result<MovingForce> make(int width, int height);

    /// Timing of the frames.
    struct Frames {
        double rate = 0;         ///< frames taken per second; a divisor of 120
        double latency_ms = 0;   ///< from a frame's exposure until it is built
        double interval_ms = 0;  ///< least time between two frames of the builder
    };
    /// Force error over all ticks that have a frame; none if no frame is built within the second.
    struct Off {
        double n = 0;       ///< length of felt less true force, N, RMS
        double pct = 0;     ///< relative to the RMS of the true force
        double age_ms = 0;  ///< mean age of the frame felt
    };
    Result<std::optional<Off>> off(const TimedFilter& filter, const Frames& frames) const;
    /// The same on frames without age: each felt at its exposure.
    Result<double> off_by_filter(const TimedFilter& filter) const;
    /// RMS of the true force, N.
    double true_n() const { return true_n_; }

private:
    struct Moment {
        glm::dvec3 goal, force;  ///< world; N
    };
    MovingForce() = default;
    void crop(const Scene& whole);
    Result<void> take_moments();
    void take_frames();
    Result<std::vector<std::unique_ptr<SurfaceFrame>>> built(const TimedFilter& filter, int stride) const;

    std::unique_ptr<AnalyticScene> content_;
    Scene scene_;             // only the pixels around the hand
    int left_ = 0, top_ = 0;  // their offset in the whole picture
    std::vector<Moment> ticks_;
    std::vector<std::vector<std::uint16_t>> planes_;  // at 120 frames a second
    double true_n_ = 0;
};

/// Cases that compare three ways from stored frames to forces: lazy (the paper's: pixels are filtered where
/// and when they are touched), whole frames by the CPU builder, whole frames by the Vulkan builder. A case
/// per size and filter measures the cost of a frame and the force error; a case per number of fingers the
/// cost of a tick and of a second; a case per size runs the cell nearest to a crossover.
std::vector<BenchCase> ways_cases(bool quick,
                                  const std::function<Result<std::shared_ptr<SurfaceKernels>>()>& kernels);

}  // namespace touchable
