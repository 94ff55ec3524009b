#pragma once

#include <memory>

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Frames with the temporal filter and without, by median: of the CPU builder on one thread and on two, and
/// of the Vulkan builder.
Result<void> race_with_temporal(const SurfaceCase& c, const Picture& picture, int frames,
                                const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);

}  // namespace touchable
