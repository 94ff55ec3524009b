#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "bench/suite.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Cases that compare three ways from stored frames to forces: lazy (the paper's: pixels are filtered where
/// and when they are touched), whole frames by the CPU builder, whole frames by the Vulkan builder. A case
/// for each size and filter has what a frame costs and the force error; one for each number of fingers what a
/// tick and a second cost; one for each size runs the way of each cell that is nearest to a crossover.
std::vector<BenchCase> ways_cases(bool quick,
                                  const std::function<Result<std::shared_ptr<SurfaceKernels>>()>& kernels);

}  // namespace touchable
