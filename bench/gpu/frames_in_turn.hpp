#pragma once

#include <array>
#include <cmath>
#include <deque>
#include <memory>
#include <vector>

#include "bench/gpu/frame_ring.hpp"
#include "bench/suite.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// The cost of a frame for a builder, milliseconds. A round is all frames of a ring.
struct FrameCost {
    double ms = HUGE_VAL;          ///< wall time of the fastest round, over its frames
    double median_ms = 0;          ///< the same of the median round
    double cpu_ms = HUGE_VAL;      ///< CPU time of the process, of the round with the least
    double latency_ms = 0;         ///< from `begin` to the end of `finish`, median over all frames
    double kernels_ms = HUGE_VAL;  ///< time of kernels on the device, the least; infinite without a device
};

/// A builder that makes the frames of a ring in turn, so many of them begun before the first is finished.
class FramesInTurn {
public:
    /// `builder` and `ring` outlive this.
    FramesInTurn(SurfaceBuilder& builder, const FrameRing& ring, int in_flight)
        : builder_(builder), ring_(ring), in_flight_(in_flight) {}

    Result<void> round();
    /// The cost over all rounds but the first, which pays for memory and pages.
    FrameCost cost() const;

private:
    Result<void> finish();

    SurfaceBuilder& builder_;
    const FrameRing& ring_;
    const int in_flight_;
    std::array<SurfaceFrame, 4> slots_;  // as a timeline has them
    std::int64_t begun_ = 0, finished_ = 0;
    std::deque<std::int64_t> begun_ns_;  // of the frames in flight
    bool warm_ = false;
    double cpu_ms_ = HUGE_VAL, kernels_ms_ = HUGE_VAL;
    std::vector<double> round_ms_, latency_ms_;
};

/// Has all of them make rounds in turn: at least 2 that count, and more until the seconds have passed.
Result<void> race_in_turn(std::span<FramesInTurn* const> racers, double seconds);

/// An error of kind check where one of the first `frames` frames of the Vulkan builder, with as many in
/// flight as it takes, is not the CPU builder's to the bit.
Result<void> check_alike(const Scene& scene, const FrameRing& ring, int frames,
                         const std::shared_ptr<SurfaceKernels>& kernels);

/// Frames of this filter by the Vulkan builder, one in flight and as many as it takes, and by the CPU
/// builder.
Result<void> measure_in_turn(const FrameRing& ring, const TimedFilter& filter, bool quick,
                             const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);

}  // namespace touchable
