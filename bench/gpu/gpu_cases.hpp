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

/// Between the host and the device: frames of 3840x2160 and 16 bits from each kind of host memory, and back.
/// They take turns and are together larger than any cache. An error of kind check where one does not come
/// back as it was.
Result<void> measure_bus(const std::shared_ptr<GpuDevice>& device, Figures& figures);

/// How far a force is off that is felt on frames of a surface that moves, because a frame shows the surface
/// as it was when it was taken, and because it is filtered.
///
/// The scene is `moving`, which rises and falls by 20 mm in half a second. A hand follows it 3 mm under the
/// true surface. The true force is k (P - G) with P the nearest point of the true surface of the moment; the
/// felt force is the solver's on the newest frame that is built by then. Only the pixels around the hand are
/// made, at the pixel pitch of the whole picture: filters give them the same bits.
class MovingForce {
public:
    static Result<MovingForce> make(int width, int height);

    /// How frames come.
    struct Frames {
        double rate = 0;         ///< taken so many times a second; at most 120, which it divides
        double latency_ms = 0;   ///< from when a frame is taken until it is built
        double interval_ms = 0;  ///< from one frame that the builder makes to the next one, at least
    };
    /// The force error over all ticks that have a frame. Nothing is felt if no frame is built within the
    /// second.
    struct Off {
        double n = 0;       ///< length of felt less true force, N, RMS
        double pct = 0;     ///< over the RMS of the true force
        double age_ms = 0;  ///< of the frame that is felt, mean
    };
    Result<std::optional<Off>> off(const TimedFilter& filter, const Frames& frames) const;
    /// The same on frames without age: each at the moment that it was taken.
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
    Scene scene_;             // of the pixels around the hand
    int left_ = 0, top_ = 0;  // of these in the whole picture
    std::vector<Moment> ticks_;
    std::vector<std::vector<std::uint16_t>> planes_;  // of 120 frames a second
    double true_n_ = 0;
};

/// Cases that compare three ways from stored frames to forces: lazy (the paper's: pixels are filtered where
/// and when they are touched), whole frames by the CPU builder, whole frames by the Vulkan builder. A case
/// for each size and filter has what a frame costs and the force error; one for each number of fingers what a
/// tick and a second cost; one for each size runs the way of each cell that is nearest to a crossover.
std::vector<BenchCase> ways_cases(bool quick,
                                  const std::function<Result<std::shared_ptr<SurfaceKernels>>()>& kernels);

}  // namespace touchable
