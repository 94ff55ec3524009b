#pragma once

// The builder of surfaces by compute shaders: the same bits as on the CPU
// (engine/surface/surface_builder.hpp).
//
// make_vulkan_builder records the plan of a scene's filters as kernels, uploads planes as they are stored,
// and hands out frames whose codes lie in memory that both reach. VulkanVertices are a frame's vertices that
// stay on the GPU, for drawing.
//
// One thread at a time, like any builder. An error of kind gpu means that the fallback builder should go on.

#include <array>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "engine/surface/frame_changes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "shaders/surface_codes.h"

namespace touchable {

/// The kernels that march along strips (shaders/strip.h). The first three take it from stored
/// values to codes, validity and parts of bounds, which are final where no filter comes after them.
enum class StripKernel { decode, median3, median5, fill_holes };

/// How rows are shared among lanes, and planes between GPU and CPU. The same bits come of any.
struct SurfacePlan {
    std::uint32_t group_size = 8;      ///< lanes of a workgroup
    std::uint32_t segment_texels = 0;  ///< of a row for one lane, a multiple of 4; 0: the whole row
    bool along_x = false;              ///< neighbouring lanes take neighbouring segments, not rows
    bool copies = false;  ///< to and from memory of the GPU's own, instead of working on the CPU's
    /// Of a frame that has changed in part only that is built, up to this share of its blocks. 0: always all.
    double break_even = 0.6;
};
/// What a device likes: few long marches on a CPU, many short ones with coalesced loads elsewhere.
SurfacePlan plan_for(const GpuFacts& facts);

/// `coding`, as kernels test it. Codes at the ends of the range that are marked invalid narrow it.
ValidCodes valid_codes_of(const DepthCoding& coding);

/// The programs of the surface on one device, each made when it is first asked for. One thread at a time.
class SurfaceKernels {
public:
    explicit SurfaceKernels(std::shared_ptr<GpuDevice> device) : device_(std::move(device)) {}
    const std::shared_ptr<GpuDevice>& device() const { return device_; }

    Result<GpuProgram> strip(StripKernel kernel, const StripConstants& constants);
    /// One pass of terrace removal, its taps `step` pixels away; `has_levels`: gates differ from code to
    /// code.
    Result<GpuProgram> terraces(std::uint32_t group_size, int step, bool is_last, bool has_levels);
    /// `sample_bytes`: of a stored value, 1 or 2.
    Result<GpuProgram> flying_pixels(std::uint32_t sample_bytes);
    Result<GpuProgram> temporal();
    Result<GpuProgram> tile_bounds();
    Result<GpuProgram> hue_codes();

private:
    using Constants = std::array<std::uint32_t, 7>;

    Result<GpuProgram> made(GpuProgram& kept, const char* name, std::span<const std::uint32_t> spirv,
                            GpuLayout layout, std::span<const std::uint32_t> constants = {});

    std::shared_ptr<GpuDevice> device_;
    std::map<std::pair<StripKernel, Constants>, GpuProgram> strips_;
    std::map<std::array<std::uint32_t, 4>, GpuProgram> terraces_;
    GpuProgram flying_pixels_[2];
    GpuProgram temporal_, tile_bounds_, hue_codes_;
};

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
