// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Races frames with and without the temporal filter, by median: the CPU builder on one thread and on two,
/// and the Vulkan builder.
Result<void> race_with_temporal(const SurfaceCase& c, const Picture& picture, int frames,
                                const std::shared_ptr<SurfaceKernels>& kernels, Figures& figures);

}  // namespace touchable
