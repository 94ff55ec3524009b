// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"
#include "bench/surface/opencv_pipeline.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Races for the codes of one picture, with the scene's median: the Vulkan builder, the CPU builder on
/// threads of its choice, on one and on two, and, if every pixel is valid, OpenCV's median. An error if any
/// codes differ from the CPU builder's.
Result<void> race_for_codes(const Scene& scene, const RawFrame& raw, VulkanSurfaceBuilder& vulkan,
                            OpenCvPipeline& opencv, int rounds, Figures& figures);

/// Device time of the builder's last frame, ms, without copies from and to host memory.
double kernels_ms(const VulkanSurfaceBuilder& vulkan);

}  // namespace touchable
