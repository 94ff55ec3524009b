// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>

#include "engine/gpu/surface_kernels.hpp"
#include "engine/gpu/vulkan_builder.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/surface_builder.hpp"
#include "shaders/surface_codes.h"

namespace touchable {

/// A kernel's input: stored values or codes, in rows of whole texels.
struct StoredRows {
    GpuBuffer buffer;
    std::uint32_t sample_bytes = 2, pitch = 0;  ///< texels from row to row
    ValidCodes valid;

    bool may_be_invalid() const {
        return valid.valid_min > 0 || valid.valid_span < (sample_bytes == 1 ? 255U : 65535U) ||
               valid.excluded[0] != no_such_code;
    }
};

/// Depth planes of a builder's frames, as its kernels read them. The GPU copies planes in blocks of plane
/// memory from there; others the CPU copies first.
class StoredPlane {
public:
    /// `valid`: valid values. `turns`: frames that may be taken before the first is finished.
    StoredPlane(std::shared_ptr<GpuDevice> device, const ValidCodes& valid, const SurfacePlan& plan,
                int turns)
        : device_(std::move(device)),
          valid_(valid),
          copies_(plan.copies),
          uploads_(static_cast<std::size_t>(turns)),
          imports_(plan.copies && device_->facts().import_alignment > 0) {}

    /// Takes a frame's depth.
    Result<StoredRows> take(const RawFrame& raw);
    /// Records what `take` leaves to the GPU.
    void record_reading_in(GpuCommands& commands);

private:
    /// Bytes that the GPU copies.
    struct Source {
        GpuBuffer buffer;
        std::size_t from = 0, bytes = 0;
        std::shared_ptr<const void> storage;      // of a frame that is read in place
    };
    struct Imported {
        std::shared_ptr<const PlaneBlock> block;
        GpuBuffer buffer;
    };
    bool find_block(const RawFrame& raw, std::size_t least_pitch);
    Result<void> upload(const PlaneView& depth, std::size_t pitch);
    Result<void> make_own(std::size_t bytes);

    /// More than the frames of 4K that a reader, a timeline and a window hold.
    static constexpr std::size_t most_imported_bytes = std::size_t{768} << 20;

    std::shared_ptr<GpuDevice> device_;
    const ValidCodes valid_;
    const bool copies_;
    std::vector<GpuBuffer> uploads_;  // written by the CPU, in turn
    std::size_t turn_ = 0;
    GpuBuffer own_;                  // the GPU's copy, if separate
    Source source_;                  // of the last `take`
    std::deque<Imported> imported_;  // the last used first
    bool imports_;
};

/// A scene's kernels, stage after stage, from stored values to codes, validity and bounds in a slot's memory,
/// and the buffers between stages.
class SurfaceRecording {
public:
    /// Refused (ErrorKind::gpu) if the scene's frames are beyond the device's limits.
    static Result<SurfaceRecording> create(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels,
                                           const SurfacePlan& plan);

    const FilterPlan& filters() const { return filters_; }
    /// The buffer to read codes back from: these planes', or the packed one.
    const GpuBuffer& codes_of(const VulkanPlanes& planes) const {
        return packed_ ? packed_ : planes.codes.gpu;
    }

    /// Records a frame. `begins`: it does not follow the last frame that was recorded and done.
    Result<void> record(GpuCommands& commands, const StoredRows& stored, bool begins,
                        const VulkanPlanes& planes);

private:
    SurfaceRecording(const Scene& scene, std::shared_ptr<SurfaceKernels> kernels, const SurfacePlan& plan);

    const GpuDevice& device() const { return *kernels_->device(); }
    bool is_hue() const { return scene_.depth.kind == DepthCodingKind::hue; }
    /// Whether no_finer_code can mark invalid codes. Otherwise 0 does, as in the end: it is free then, and
    /// codes are the stored ones.
    bool has_room_above() const;
    bool packs_rows() const { return plan_.packs_rows(scene_.width); }
    Result<void> check_limits() const;
    Result<void> make_buffers();
    Result<void> make_table();

    /// A frame whose stages are recorded one after the other. A stage reads `rows`, whose `valid` says what
    /// marks invalid codes: stored ones up to a median, which is recorded with the first stage that needs
    /// codes (record_codes); from then on no_finer_code or, without has_room_above, 0. It writes into a
    /// buffer other than theirs, one of `between_` unless it remembers.
    struct Frame {
        GpuCommands& commands;
        const bool begins;
        const VulkanPlanes& planes;
        StoredRows rows;                           // what the next stage reads
        SurfaceKernel kernel = SurfaceKernel::decode;  // that is to make codes; a median waits for it
        bool is_finer = false;                     // the rows are working codes
    };

    StripPush push_for(const StoredRows& rows) const;
    /// `working`: of codes for filters that need finer ones; null: the codes are final.
    Result<GpuProgram> program_for(SurfaceKernel kernel, const StoredRows& rows,
                                   const WorkingCodes* working = nullptr);
    Result<void> record_hue(Frame& frame);
    Result<void> record(const FlyingPixels& filter, Frame& frame);
    Result<void> record(const FilterPlan::HoleFilling& filling, Frame& frame);
    Result<void> record(const FilterPlan::MedianWindow& window, Frame& frame);
    Result<void> record(const TemporalFilter& filter, Frame& frame);
    Result<void> record(const TerraceFilter& filter, Frame& frame);
    Result<void> record_finer(const WorkingCodes& working, Frame& frame);
    Result<void> record_codes(Frame& frame, const WorkingCodes* working, const GpuBuffer& to);
    Result<void> record_block(Frame& frame, const WorkingCodes* working, const GpuBuffer& to);
    Result<void> record_strips(Frame& frame, const WorkingCodes* working, const GpuBuffer& to);
    Result<void> record_packing(const Frame& frame);
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
    GpuBuffer packed_;         // codes, for the CPU
    GpuBuffer held_;           // for how many frames codes have only been held
    GpuBuffer fill_passes_;    // which passes of hole filling have something to do
    GpuBuffer parts_;          // of tile bounds
    GpuBuffer table_;          // of working codes, if these are looked up
};

}  // namespace touchable
