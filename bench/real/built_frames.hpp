// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// A scene with its filters, and, if others filter, what they make of all frames before.
struct Filtering {
    Filtering(Scene with) : scene(std::move(with)) {}
    Scene scene;
    std::function<std::vector<RawFrame>(const std::vector<RawFrame>&)> before{};
};

/// Builds all frames in order with the CPU builder; `barred`: with_error_bars.
Result<std::vector<SurfaceFrame>> built(const Filtering& filtering, const std::vector<RawFrame>& raws,
                                        bool barred = false);

/// Appends frame_cpu_ms and frame_ms: the CPU builder's least CPU time of all threads and least wall time for
/// one of `rounds` frames, each new, into a slot used before.
Result<void> measure_cost(const Scene& scene, const std::vector<RawFrame>& raws, int rounds,
                          Figures& figures);

}  // namespace touchable
