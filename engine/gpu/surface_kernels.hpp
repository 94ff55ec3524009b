// SPDX-License-Identifier: Apache-2.0
#pragma once

// The kernels of the surface, and its Vulkan builder with a choice of plan (tests, benchmarks).

#include <cstdint>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/surface_builder.hpp"
#include "shaders/surface_codes.h"

namespace touchable {

/// The kernels of shaders/. The first four march along strips (shaders/strip.h); three of these turn stored
/// values into codes, validity and parts of bounds, which are final if no filter follows.
enum class SurfaceKernel {
    decode,
    median3,
    median5,
    fill_holes,
    block,
    terraces,
    flying_pixels,
    temporal,
    tile_bounds,
    hue_codes,
    pack_rows
};

/// How rows are shared among lanes, and planes between GPU and CPU. Every plan gives the same bits.
struct SurfacePlan {
    std::uint32_t group_size = 8;      ///< lanes of a workgroup
    std::uint32_t segment_texels = 0;  ///< of a row for one lane, a multiple of 4; 0: the whole row
    bool along_x = false;              ///< neighbouring lanes take neighbouring segments, not rows
    bool copies = false;               ///< to and from the GPU's own memory, instead of working on the CPU's
    /// Decoding, medians and bounds by the one kernel for GPUs (shaders/block.comp), not along strips.
    bool blocks = false;

    /// Whether rows that are not whole texels lose their gaps before they are copied to the CPU.
    bool packs_rows(int width) const { return blocks && copies && width % 8 != 0; }
};
/// The plan that suits a device: few long marches on a CPU; elsewhere blocks, and many short marches with
/// coalesced loads for kernels along strips. TOUCHABLE_GPU_PLAN=discrete in the environment forces a GPU's
/// plan on any device.
SurfacePlan plan_for(const GpuFacts& facts);

/// The valid codes of `coding` as kernels test them: a range, which invalid codes at its ends have narrowed,
/// and the invalid codes within it.
ValidCodes valid_codes_of(const DepthCoding& coding);

/// The programs of the surface on one device, each made at its first use. One thread at a time.
class SurfaceKernels {
public:
    explicit SurfaceKernels(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}
    const std::shared_ptr<GpuDevice>& device() const { return device_; }

    /// `constants`: the kernel's specialisation constants 0, 1, ...
    Result<GpuProgram> program(SurfaceKernel kernel, std::vector<std::uint32_t> constants = {});

private:
    std::shared_ptr<GpuDevice> device_;
    std::map<std::pair<SurfaceKernel, std::vector<std::uint32_t>>, GpuProgram> programs_;
};

/// The builder of make_vulkan_builder (vulkan_builder.hpp), and what its stages took.
class VulkanSurfaceBuilder : public SurfaceBuilder {
public:
    /// Milliseconds of the last frame on the device, by stage: "read in" and "read back" if its memory is its
    /// own; "hue", "flying pixels" and "fill" if used; "median" (or "decode"); with filters after it
    /// "temporal", "terraces" and another "decode"; "bounds".
    virtual const std::vector<GpuDevice::Time>& stages() const = 0;
};

/// Refused like the builder of a device. `kernels` may serve many builders, one thread at a time.
Result<std::unique_ptr<VulkanSurfaceBuilder>> make_vulkan_builder(const Scene& scene,
                                                                  std::shared_ptr<SurfaceKernels> kernels,
                                                                  const SurfacePlan& plan);

}  // namespace touchable
