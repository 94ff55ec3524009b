#pragma once

#include <string>

#include "engine/gpu/surface_kernels.hpp"

namespace touchable::test {

/// The kernels on the GPU that is here, which the validation layer watches; one for all tests of a program.
/// Where there is none, or the layer has something to say in the end, the tests fail.
std::shared_ptr<SurfaceKernels> test_kernels();

/// On that GPU; throws where that cannot be.
std::unique_ptr<VulkanSurfaceBuilder> test_vulkan_builder(const Scene& scene);

/// Few lanes that march whole rows, as on a CPU; many that march segments side by side in memory of
/// their own; and blocks, as on a GPU, by copies and over the bus.
inline constexpr SurfacePlan all_plans[] = {{8, 0, false, false},
                                            {8, 4, true, true},
                                            {64, 4, true, true, 0, true},
                                            {64, 4, true, true, 0, true, true}};
std::string plan_text(const SurfacePlan& plan);

}  // namespace touchable::test
