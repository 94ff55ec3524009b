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

struct SurfacePlan;  // surface_kernels.hpp

/// The memory of a built frame.
struct VulkanPlanes {
    /// An array that kernels write and the CPU reads: one buffer, or one that is copied to another.
    struct Plane {
        GpuBuffer gpu, host;

        static Result<Plane> create(const GpuDevice& device, const std::string& name, std::size_t bytes,
                                    std::optional<std::size_t> copied_bytes);
        bool is_copied() const { return gpu.handle() != host.handle(); }
    };

    /// Codes with rows of whole texels, in what is copied without gaps where the plan packs rows; validity
    /// and bounds as in a SurfaceFrame.
    static Result<VulkanPlanes> create(const GpuDevice& device, int width, int height,
                                       const SurfacePlan& plan);
    /// Whether it serves frames of this size on this device.
    bool serves(const GpuDevice& device, int width, int height, const SurfacePlan& plan) const;
    bool is_on(const GpuDevice& device) const { return vulkan == device.vulkan(); }

    std::shared_ptr<VulkanDevice> vulkan;
    int width = 0, height = 0;
    bool packed = false;
    Plane codes{}, validity{}, tiles{};
    BuildNumber build{};  ///< that it holds
};

/// What a slot of the Vulkan builder keeps: the memory of its frame, which its vertices read.
class VulkanVertices final : public FilteredVertices {
public:
    VulkanVertices(const SurfaceFrame& frame, VulkanPlanes memory)
        : FilteredVertices(frame), planes(std::move(memory)) {}

    VulkanPlanes planes;
    BuildNumber touch_planes;  ///< of the frame whose haptic and height planes the slot has
};

/// Frames by kernels: one submission each. On a GPU with memory of its own three may be begun before the
/// first is finished. The codes, validity and bounds of a frame stay in the GPU's mapped memory where that is
/// the CPU's too, and are read back to mapped memory elsewhere. There the CPU copies nothing; where memory is
/// shared, rows that are no multiple of 8 codes. `build` keeps the memory of a recycled slot; `finish` gives
/// it the frame's own, and a frame to come the slot's. They fail with ErrorKind::gpu where the device is
/// lost, has too little memory or does not answer; `out` then holds no frame.
///
/// Refused (ErrorKind::gpu) where the scene's frames are larger than the device's buffers may be, or with a
/// temporal filter where depth.invalid names some of 65536 codes, but neither 0 nor 65535.
Result<std::unique_ptr<SurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                            std::shared_ptr<GpuDevice> device);

/// Measures on a GPU what a frame takes the CPU builder and this one, by copies and over the bus
/// (facts.measured), unless that is known: some tens of milliseconds and the making of a program. The device
/// may be lost by that, which then is known too. One thread at a time.
void measure_builders(const std::shared_ptr<GpuDevice>& device);

}  // namespace touchable
