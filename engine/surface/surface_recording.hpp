#pragma once

#include <optional>

#include "engine/scene/temporal.hpp"
#include "engine/scene/terraces.hpp"
#include "engine/surface/stored_plane.hpp"
#include "engine/surface/surface_kernels.hpp"
#include "engine/surface/vulkan_vertices.hpp"

namespace touchable {

/// A scene's kernels, one stage after the other, from stored values to codes, validity and bounds in a slot's
/// memory, and what lies between the stages.
class SurfaceRecording {
public:
    /// Refused (ErrorKind::gpu) where the scene's frames are more than the device can do.
    static Result<SurfaceRecording> create(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels,
                                           const SurfacePlan& plan);

    /// How far away a pixel may be that another one depends on; nothing where stages leave something between
    /// them that is of one frame alone, or of all before.
    std::optional<int> reach() const;
    /// Of the codes in the end.
    const DepthCoding& coding() const;

    /// Records a frame, or of one the listed blocks. `begins`: it is not the successor of the last one that
    /// was recorded, and done.
    Result<void> record(GpuCommands& commands, const StoredRows& stored, const BlockList& list, bool begins,
                        const VulkanVertices& slot);

private:
    SurfaceRecording(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels, const SurfacePlan& plan);

    const GpuDevice& device() const { return *kernels_->device(); }
    bool is_hue() const { return scene_.depth.kind == DepthCodingKind::hue; }
    /// Otherwise 0 stands for what is invalid, as in the end: that is free then, and codes are not
    /// multiplied.
    bool has_room_above() const;
    Result<void> check_limits() const;
    Result<void> make_buffers();

    StripPush push_for(const StoredRows& rows, std::uint32_t listed) const;
    TerracesPush terraces_push() const;
    Result<GpuProgram> program_for(StripKernel kernel, const StoredRows& rows, bool before_terraces = false);
    Result<StoredRows> record_hue(GpuCommands& commands, const StoredRows& rows);
    Result<StoredRows> record_filling(GpuCommands& commands, StoredRows rows);
    Result<void> record_codes(GpuCommands& commands, int median, const StoredRows& rows, bool before_terraces,
                              const GpuBuffer& to, const BlockList& list, const VulkanVertices& slot);
    Result<StoredRows> record_temporal(GpuCommands& commands, bool begins);
    Result<StoredRows> record_terraces(GpuCommands& commands, const GpuBuffer& finer);
    Result<void> record_bounds(GpuCommands& commands, const BlockList& list, const VulkanVertices& slot);

    Scene scene_;
    std::shared_ptr<SurfaceKernels> kernels_;
    SurfacePlan plan_;
    std::optional<TemporalFilter> temporal_;
    std::optional<TerraceFilter> terraces_;
    ValidCodes valid_;
    std::uint32_t width_, height_, pitch_, strips_;  // pitch in texels, of codes
    TileGrid grid_;
    GpuBuffer between_[2];     // codes between stages
    GpuBuffer finer_;          // codes before they are filtered in time, or terraces are removed
    GpuBuffer remembered_[2];  // codes filtered in time, of the last frame and of the one before
    GpuBuffer held_;           // for how many frames codes have only been held
    GpuBuffer fill_passes_;    // which passes of hole filling have something to do
    GpuBuffer parts_;          // of tile bounds
};

}  // namespace touchable
