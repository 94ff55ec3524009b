#pragma once

#include <memory>
#include <string>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// Frames by kernels: one submission each, which `build` waits for. The codes, validity and bounds of a frame
/// stay in the GPU's mapped memory where that is the CPU's too, and are read back to mapped memory elsewhere;
/// only rows that are no multiple of 8 codes are copied. A recycled slot keeps its memory.
///
/// Fails with ErrorKind::gpu where the device is lost, has too little memory or does not answer; `out` then
/// holds no frame.
class VulkanSurfaceBuilder : public SurfaceBuilder {
public:
    /// Milliseconds of the last frame on the device, by stage: "read in" and "read back" where its memory is
    /// its own; "hue" and "fill" where there are such; "median" (or "decode"); with filters after it
    /// "temporal", "terraces" and another "decode"; "bounds". None where nothing had changed.
    virtual const std::vector<GpuTime>& stages() const = 0;
};

/// `kernels` may serve many builders, one thread at a time. Refused (ErrorKind::gpu) where the scene's frames
/// are larger than the device's buffers may be, or with a temporal filter where depth.invalid names some of
/// 65536 codes, but neither 0 nor 65535.
Result<std::unique_ptr<VulkanSurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                                  std::shared_ptr<SurfaceKernels> kernels,
                                                                  const SurfacePlan& plan);
Result<std::unique_ptr<VulkanSurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                                  std::shared_ptr<GpuDevice> device);

}  // namespace touchable
