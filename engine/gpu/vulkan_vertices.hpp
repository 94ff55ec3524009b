#pragma once

#include "engine/gpu/gpu_commands.hpp"
#include "engine/scene/surface_frame.hpp"
#include "engine/surface/frame_changes.hpp"

namespace touchable {

/// An array that kernels write and the CPU reads: one buffer, or one that is copied to another.
struct SharedPlane {
    GpuBuffer gpu, host;

    static Result<SharedPlane> create(const GpuDevice& device, const std::string& name, std::size_t bytes,
                                      bool copied);
    bool is_copied() const { return gpu.handle() != host.handle(); }
};

/// What a slot of the Vulkan builder keeps: the memory of its frame, which its vertices read.
class VulkanVertices final : public FilteredVertices {
public:
    /// Codes with rows of whole texels; validity and bounds as in a SurfaceFrame.
    static Result<std::unique_ptr<VulkanVertices>> create(const GpuDevice& device, const SurfaceFrame& frame,
                                                          int width, int height, bool copied);
    bool is_on(const GpuDevice& device) const { return vulkan_ == device.vulkan(); }
    /// Whether its memory serves frames of this size on this device.
    bool serves(const GpuDevice& device, int width, int height, bool copied) const;

    SharedPlane codes, validity, tiles;
    BuildNumber build;  ///< that the memory holds

private:
    VulkanVertices(const GpuDevice& device, const SurfaceFrame& frame, int width, int height)
        : FilteredVertices(frame), vulkan_(device.vulkan()), width_(width), height_(height) {}

    std::shared_ptr<VulkanDevice> vulkan_;
    int width_, height_;
};

}  // namespace touchable
