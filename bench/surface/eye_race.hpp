// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"
#include "bench/surface/opencv_pipeline.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// Races for the drawing data of one picture, with the scene's median: codes and q; and codes, q and the
/// tiles to draw. By kernels, by the CPU on one thread and on two, and, if no pixel is invalid, by OpenCV's
/// pipeline. An error if q differ by more than 1e-6 or tiles differ at all.
Result<void> race_for_the_eye(const SurfaceCase& c, const Picture& picture, VulkanSurfaceBuilder& vulkan,
                              const std::shared_ptr<GpuDevice>& device, OpenCvPipeline& opencv, int rounds,
                              Figures& figures);

}  // namespace touchable
