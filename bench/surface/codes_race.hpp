#pragma once

#include "bench/suite.hpp"
#include "bench/surface/opencv_pipeline.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Codes of one picture, with the scene's median, by the Vulkan builder, by the CPU builder on threads of its
/// choice, on one and on two, and, where every pixel is valid, by OpenCV's median, against each other. An
/// error where any of them gives other codes than the CPU builder.
Result<void> race_for_codes(const Scene& scene, const RawFrame& raw, VulkanSurfaceBuilder& vulkan,
                            OpenCvPipeline& opencv, int rounds, Figures& figures);

/// Milliseconds of the builder's last frame on the device, without copies from and to the host's memory.
double kernels_ms(const VulkanSurfaceBuilder& vulkan);

}  // namespace touchable
