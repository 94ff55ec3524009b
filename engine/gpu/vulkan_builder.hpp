// SPDX-License-Identifier: Apache-2.0
#pragma once

// The builder of surfaces by compute shaders: the same bits as on the CPU
// (engine/surface/surface_builder.hpp).
//
// make_vulkan_builder gives the builder of a scene on a device. It records the plan of the scene's filters as
// kernels (surface_recording.hpp), uploads planes as they are stored, and hands out frames whose codes lie in
// memory that CPU and GPU reach. VulkanVertices are a frame's vertices that stay on the GPU: what is drawn on
// the same device reads them there.
//
// Threads: one at a time, like any builder. An error of kind gpu means that the fallback builder should go
// on.

#include <cstddef>
#include <memory>
#include <string>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {

struct SurfacePlan;  // surface_kernels.hpp

/// The memory of a built frame.
struct VulkanPlanes {
    /// An array that kernels write and the CPU reads: one buffer, or one that is copied to another.
    struct Plane {
        GpuBuffer gpu, host;

        bool is_copied() const { return gpu.handle() != host.handle(); }
    };

    /// Codes have rows of whole texels; their copy has no gaps if the plan packs rows. Validity and bounds
    /// are as in a SurfaceFrame.
    static Result<VulkanPlanes> create(const GpuDevice& device, int width, int height,
                                       const SurfacePlan& plan);
    /// Whether it serves frames of this size on this device.
    bool serves(const GpuDevice& device, int width, int height, const SurfacePlan& plan) const;
    bool is_on(const GpuDevice& device) const { return vulkan == device.vulkan(); }

    std::shared_ptr<VulkanDevice> vulkan;
    int width = 0, height = 0;
    bool packed = false;
    Plane codes{}, validity{}, tiles{};
};

/// A slot's content in the Vulkan builder: the memory of its frame, which its vertices read.
class VulkanVertices final : public FilteredVertices {
public:
    VulkanVertices(const SurfaceFrame& frame, VulkanPlanes memory)
        : FilteredVertices(frame), planes(std::move(memory)) {}

    VulkanPlanes planes;
    std::uint64_t touch_planes = 0;  ///< names the haptic and height planes that the slot has
};

/// Builds each frame by kernels in one submission. Three frames may be begun before the first is finished.
/// Codes, validity and bounds of a frame stay in the GPU's mapped memory if the CPU shares it, and are
/// otherwise read back to mapped memory. Then the CPU copies nothing; with shared memory it copies rows that
/// are no multiple of 8 codes. `build` reuses the memory of a recycled slot; `finish` gives the slot the
/// frame's memory, and keeps the slot's for a later frame. They fail with ErrorKind::gpu if the device is
/// lost, has too little memory or does not answer; `out` then holds no frame.
///
/// Refused (ErrorKind::gpu) if the scene's frames are larger than the device's buffers may be, or with a
/// temporal filter if depth.invalid names some of 65536 codes, but neither 0 nor 65535.
Result<std::unique_ptr<SurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                            std::shared_ptr<GpuDevice> device);

/// Measures a frame's time on a GPU with the CPU builder and this one (facts.measured),
/// unless known: takes some tens of milliseconds and the making of a program. If that loses
/// the device, this is recorded, too. One thread at a time.
void measure_builders(const std::shared_ptr<GpuDevice>& device);

}  // namespace touchable
