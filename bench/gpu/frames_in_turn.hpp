// SPDX-License-Identifier: Apache-2.0
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

/// A builder's cost per frame, ms. A round is all frames of a ring.
struct FrameCost {
    double ms = HUGE_VAL;          ///< wall time of the fastest round / its frames
    double median_ms = 0;          ///< the same for the median round
    double cpu_ms = HUGE_VAL;      ///< CPU time of the process, least over the rounds
    double latency_ms = 0;         ///< from `begin` to the end of `finish`, median over all frames
    double kernels_ms = HUGE_VAL;  ///< least device time of kernels; infinite without a device
};

/// Builds the frames of a ring in turn, with `in_flight` frames begun before the first is finished.
class FramesInTurn {
public:
    /// `builder` and `ring` must outlive this.
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
    std::array<SurfaceFrame, 4> slots_;  // as in a timeline
    std::int64_t begun_ = 0, finished_ = 0;
    std::deque<std::int64_t> begun_ns_;  // of the frames in flight
    bool warm_ = false;
    double cpu_ms_ = HUGE_VAL, kernels_ms_ = HUGE_VAL;
    std::vector<double> round_ms_, latency_ms_;
};

/// Lets all racers make rounds in turn: at least 2 counted rounds, and more until the seconds have passed.
Result<void> race_in_turn(std::span<FramesInTurn* const> racers, double seconds);

/// An error of kind check if one of the first `frames` frames of the Vulkan builder, with its maximum in
/// flight, differs in a bit from the CPU builder's.
Result<void> check_alike(const Scene& scene, const FrameRing& ring, int frames,
                         const std::shared_ptr<SurfaceKernels>& kernels);

/// Measures frames with this filter by the Vulkan builder, with one and its maximum in flight, and by the CPU
/// builder.
Result<void> measure_in_turn(const FrameRing& ring, const TimedFilter& filter, bool quick,
                             const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);

}  // namespace touchable
