#pragma once

#include <vector>

#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// All of them, in order, by the CPU builder.
Result<std::vector<SurfaceFrame>> built(const Scene& scene, const std::vector<RawFrame>& raws);

/// Appends frame_cpu_ms and frame_ms: the least CPU time of all threads and the least wall time in which the
/// CPU builder makes one of these frames, each of them new, into a slot it has used before; of `rounds`
/// frames.
Result<void> measure_cost(const Scene& scene, const std::vector<RawFrame>& raws, int rounds,
                          Figures& figures);

}  // namespace touchable
