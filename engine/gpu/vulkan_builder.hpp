#pragma once

// The builder of surfaces by compute shaders: the same bits as on the CPU
// (engine/surface/surface_builder.hpp).
//
// make_vulkan_builder gives the builder of a scene on a device. It records the plan of the scene's filters as
// kernels (surface_recording.hpp), uploads planes as they are stored, and hands out frames whose codes lie in
// memory that both reach. VulkanVertices are a frame's vertices that stay on the GPU: what is drawn on the
// same device reads them there.
//
// One thread at a time, like any builder. An error of kind gpu means that the fallback builder should go on.

#include <cstddef>
#include <memory>
#include <string>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/frame_changes.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

/// What a slot of the Vulkan builder keeps: the memory of its frame, which its vertices read.
class VulkanVertices final : public FilteredVertices {
public:
    /// An array that kernels write and the CPU reads: one buffer, or one that is copied to another.
    struct Plane {
        GpuBuffer gpu, host;

        static Result<Plane> create(const GpuDevice& device, const std::string& name, std::size_t bytes,
                                    bool copied);
        bool is_copied() const { return gpu.handle() != host.handle(); }
    };

    /// Codes with rows of whole texels; validity and bounds as in a SurfaceFrame.
    static Result<std::unique_ptr<VulkanVertices>> create(const GpuDevice& device, const SurfaceFrame& frame,
                                                          int width, int height, bool copied);
    bool is_on(const GpuDevice& device) const { return vulkan_ == device.vulkan(); }
    /// Whether its memory serves frames of this size on this device.
    bool serves(const GpuDevice& device, int width, int height, bool copied) const;

    Plane codes, validity, tiles;
    BuildNumber build;  ///< that the memory holds

private:
    VulkanVertices(const GpuDevice& device, const SurfaceFrame& frame, int width, int height)
        : FilteredVertices(frame), vulkan_(device.vulkan()), width_(width), height_(height) {}

    std::shared_ptr<VulkanDevice> vulkan_;
    int width_, height_;
};

/// Frames by kernels: one submission each, which `build` waits for. The codes, validity and bounds of a frame
/// stay in the GPU's mapped memory where that is the CPU's too, and are read back to mapped memory elsewhere;
/// only rows that are no multiple of 8 codes are copied. A recycled slot keeps its memory. `build` fails with
/// ErrorKind::gpu where the device is lost, has too little memory or does not answer; `out` then holds no
/// frame.
///
/// Refused (ErrorKind::gpu) where the scene's frames are larger than the device's buffers may be, or with a
/// temporal filter where depth.invalid names some of 65536 codes, but neither 0 nor 65535.
Result<std::unique_ptr<SurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                            std::shared_ptr<GpuDevice> device);

}  // namespace touchable
