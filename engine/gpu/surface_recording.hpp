#pragma once

#include <optional>

#include "engine/gpu/stored_plane.hpp"
#include "engine/gpu/surface_kernels.hpp"
#include "engine/gpu/vulkan_vertices.hpp"
#include "engine/surface/filter_plan.hpp"

namespace touchable {

/// A scene's kernels, one stage after the other, from stored values to codes, validity and bounds in a slot's
/// memory, and what lies between the stages.
class SurfaceRecording {
public:
    /// Refused (ErrorKind::gpu) where the scene's frames are more than the device can do.
    static Result<SurfaceRecording> create(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels,
                                           const SurfacePlan& plan);

    const FilterPlan& filters() const { return filters_; }
    /// Its reach; nothing too where stages leave something between them that is of one frame alone.
    std::optional<int> reach() const;

    /// Records a frame, or of one the listed blocks. `begins`: it is not the successor of the last one that
    /// was recorded, and done.
    Result<void> record(GpuCommands& commands, const StoredRows& stored, const BlockList& list, bool begins,
                        const VulkanVertices& slot);

private:
    SurfaceRecording(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels, const SurfacePlan& plan);

    const GpuDevice& device() const { return *kernels_->device(); }
    bool is_hue() const { return scene_.depth.kind == DepthCodingKind::hue; }
    /// Otherwise 0 stands for what is invalid, as in the end: that is free then, and codes are the stored
    /// ones.
    bool has_room_above() const;
    Result<void> check_limits() const;
    Result<void> make_buffers();
    Result<void> make_table();

    /// A frame whose stages are recorded one after the other.
    struct Frame {
        GpuCommands& commands;
        const BlockList& list;
        const bool begins;
        const VulkanVertices& slot;
        StoredRows rows;                           // what the next stage reads
        StripKernel kernel = StripKernel::decode;  // which is to end in codes; a median waits for that
        bool is_finer = false;                     // the rows are working codes
    };

    StripPush push_for(const StoredRows& rows, std::uint32_t listed) const;
    /// `working`: of codes for filters that need finer ones; null: the codes are final.
    Result<GpuProgram> program_for(StripKernel kernel, const StoredRows& rows,
                                   const WorkingCodes* working = nullptr);
    Result<void> record_hue(Frame& frame);
    Result<void> record(const FlyingPixels& filter, Frame& frame);
    Result<void> record(const HoleFilling& filling, Frame& frame);
    Result<void> record(const MedianWindow& window, Frame& frame);
    Result<void> record(const TemporalFilter& filter, Frame& frame);
    Result<void> record(const TerraceFilter& filter, Frame& frame);
    Result<void> record_finer(const WorkingCodes& working, Frame& frame);
    Result<void> record_codes(Frame& frame, const WorkingCodes* working, const GpuBuffer& to);
    Result<void> record_bounds(const Frame& frame);

    Scene scene_;
    std::shared_ptr<SurfaceKernels> kernels_;
    SurfacePlan plan_;
    FilterPlan filters_;
    ValidCodes valid_;
    std::uint32_t width_, height_, pitch_, strips_;  // pitch in texels, of codes
    std::uint32_t segment_texels_, segments_;        // of a row
    TileGrid grid_;
    GpuBuffer between_[2];     // codes between stages
    GpuBuffer finer_;          // codes before they are filtered in time, or terraces are removed
    GpuBuffer remembered_[2];  // codes filtered in time, of the last frame and of the one before
    GpuBuffer held_;           // for how many frames codes have only been held
    GpuBuffer fill_passes_;    // which passes of hole filling have something to do
    GpuBuffer parts_;          // of tile bounds
    GpuBuffer table_;          // of working codes, where these are looked up
};

}  // namespace touchable
