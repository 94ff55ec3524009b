#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string_view>

#include "engine/gpu/gpu_made.hpp"
#include "player/draw/cpu_lattice.hpp"
#include "player/draw/decimation.hpp"
#include "player/draw/dent_drawing.hpp"
#include "player/draw/dent_patches.hpp"
#include "player/draw/finger_drawing.hpp"
#include "player/draw/gpu_lattice.hpp"
#include "player/draw/lattice_raster.hpp"
#include "player/draw/mesh_pipeline.hpp"
#include "player/draw/own_view_picture.hpp"
#include "player/draw/surface_lighting.hpp"
#include "player/draw/surface_raster.hpp"
#include "player/draw/upload_pool.hpp"

namespace touchable {

/// Draws a surface and the fingers on it picture after picture, on the device from codes to colours, into
/// memory that stays: what a window shows. The same picture as `make_picture`'s of one sample a pixel, but
/// that fingers have smooth edges.
///
/// Recorded calls are to be submitted in the order in which they were recorded; what is forgotten instead is
/// made again when it is needed. Not for two threads at once.
class SurfaceDrawing {
public:
    /// painter: "raster", "mesh" or "auto", as in make_painter. Fails (ErrorKind::gpu) where the device can
    /// do neither, or not what is asked for by name; ErrorKind::usage for another name.
    static Result<std::unique_ptr<SurfaceDrawing>> create(std::shared_ptr<GpuDevice> device,
                                                          std::string_view painter);

    /// "raster" or "mesh".
    std::string_view painter() const { return raster_ ? "raster" : "mesh"; }

    /// Whether `show` heeds its step: the CPU draws.
    bool thins_vertices() const { return by_cpu_.has_value(); }

    /// From now on this surface is drawn: records what makes q and colours of the pair that `field` is of.
    /// For the raster of a software device the CPU makes them at once, and there no more than every `step`th
    /// vertex across and down, a power of two: a level of detail (Decimation). `colour`: RGB of 8 bits, of
    /// the field's size, or empty for light and depth alone. It is read at once; the pair's frames stay until
    /// what is recorded has completed. Fails (ErrorKind::gpu) where the surface is larger than a kernel may
    /// read.
    Result<void> show(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                      const PlaneView& colour, Lighting lighting, int step = 1);
    /// The same where the CPU draws, which needs no commands.
    Result<void> show_by_cpu(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                             Lighting lighting, int step);

    /// The CPU of a software device draws the surface at once, from what `show` left. Records the drawing of
    /// surface, background and fingers (without a `show` that was submitted, of these two) into `target`
    /// (VK_FORMAT_R8G8B8A8_UNORM, of the camera's size), all of which is written, and which is left in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL. Whatever comes after it is to wait for that, as
    /// record_transition does. Fails (ErrorKind::gpu) where the picture is too large for the painter on this
    /// device.
    Result<void> draw(GpuCommands& commands, const ViewCamera& camera, std::span<const FingerMark> fingers,
                      const MarkSizes& sizes, const GpuImage& target);

private:
    SurfaceDrawing(std::shared_ptr<GpuDevice> device, FingerDrawing fingers);

    Result<void> begin_surface(const HeightField& field, const PlaneView& colour, Lighting lighting);
    Result<void> make_by_cpu(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                             Lighting lighting, int step);
    Result<void> reserve(const ViewCamera& camera);
    Result<void> reserve_pixels(const ViewCamera& camera);
    Result<void> draw_by_cpu(const GpuCommands& commands, const ViewCamera& camera);
    bool is_drawn(const GpuCommands& commands, const ViewCamera& camera) const;
    const SurfaceEdges& edges_of(const GpuCommands& commands, const ViewCamera& camera);
    Result<void> record_edges(GpuCommands& commands, const ViewCamera& camera);
    Result<void> list_tiles(GpuCommands& commands);
    Result<void> draw_surface(GpuCommands& commands, const ViewCamera& camera);
    Result<void> record_raster(GpuCommands& commands, const ViewCamera& camera);
    void record_copies(GpuCommands& commands, const ViewCamera& camera, const GpuImage& target) const;
    Result<void> record_dents(GpuCommands& commands, const ViewCamera& camera,
                              std::span<const FingerMark> fingers, const MarkSizes& sizes,
                              const GpuImage& target);
    Result<void> record_mesh(GpuCommands& commands, const ViewCamera& camera, const GpuImage& target);

    std::shared_ptr<GpuDevice> device_;
    std::optional<SurfaceRaster> raster_;
    std::optional<MeshPipeline> mesh_;          // one of the two
    OwnViewPicture own_view_;                   // in the raster's place there, where it can
    std::optional<LatticeRaster> turned_view_;  // and from elsewhere, on a software device
    std::optional<SurfaceEdges> edges_;         // for that
    GpuLattices lattices_;
    SurfaceLighting lighting_;
    std::optional<CpuLattices> by_cpu_;     // makes what is shown in their place, on a software device
    std::optional<Decimation> decimation_;  // of that
    std::optional<DentDrawing> dents_;
    DentPatches dent_patches_;  // in their place where the CPU draws the surface
    FingerDrawing fingers_;
    GraphicsProgram background_;

    GpuLattice lattice_;
    GpuMade shown_;                 // the surface
    GpuMade listed_;                // its tiles
    GpuMade edged_;                 // its edges
    bool are_values_ = false;       // its colours, of a scale
    GpuBuffer pixels_, large_;      // of the raster
    GpuBuffer colours_, z_values_;  // the surface and its background, as they are copied into images
    UploadPool pictures_;           // of these, where the CPU writes them
    GpuMade drawn_;                 // these
    glm::dmat4 drawn_from_{};       // clip_from_lattice that they are of
    int drawn_width_ = 0, drawn_height_ = 0;
    GpuBuffer rows_;  // colours of the background
    int rows_height_ = 0;
    GpuImage z_;
};

}  // namespace touchable
