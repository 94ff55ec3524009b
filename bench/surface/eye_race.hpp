#pragma once

#include "bench/suite.hpp"
#include "bench/surface/opencv_pipeline.hpp"
#include "bench/surface/surface_case.hpp"
#include "engine/gpu/surface_kernels.hpp"

namespace touchable {

/// What the eye needs of one picture, with the scene's median: codes and q, and codes, q and the tiles to
/// draw; by kernels, by the CPU on one thread and on two, and, of a picture without invalid pixels, by
/// OpenCV's pipeline; all against each other. An error where q differ by more than 1e-6 or tiles at all.
Result<void> race_for_the_eye(const SurfaceCase& c, const Picture& picture, VulkanSurfaceBuilder& vulkan,
                              const std::shared_ptr<GpuDevice>& device, OpenCvPipeline& opencv, int rounds,
                              Figures& figures);

}  // namespace touchable
