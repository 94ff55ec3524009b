// SPDX-License-Identifier: Apache-2.0
#pragma once

// Surfaces and fingers painted by a GPU: from a pair of frames to a lattice in its memory (GpuLattices), the
// lattice's colours (SurfaceLighting), its triangles by compute (SurfaceRaster) or by the triangle hardware
// (MeshPipeline), and dents and fingers on that picture. All classes record commands; the caller submits them
// in the order of recording.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "engine/gpu/gpu_commands.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/gpu_image.hpp"
#include "player/draw/graphics_program.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/view.hpp"
#include "shaders/unproject.h"

namespace touchable {

/// A lattice in GPU memory, as the GPU painters read it.
struct GpuLattice {
    int width = 0, height = 0;
    int pitch = 0;            ///< vertices from one row of q and colours to the next
    float focal_length = 0;   ///< of the lattice's camera, vertices
    bool fills_gaps = false;  ///< ViewSurface's
    GpuBuffer q;        ///< floats, row-major
    GpuBuffer colours;  ///< PackedColour, row-major
    // What a view draws (GpuLattices::record_view):
    GpuBuffer drawn_q;  ///< as q, negative where it is eroded (shaders/edge_rule.h)
    GpuBuffer tiles;    ///< non-empty tiles: shaders/tile_lists.h
    GpuBuffer classes;  ///< of each tile, passed from cut_tiles to list_tiles
    GpuBuffer edges;    ///< drawn positions of vertices at edges: shaders/edges.h; for turned views
};

/// Inputs of shaders/unproject.h for a pair of frames with codes. `field` was made from `pair`.
struct UnprojectTerms {
    UnprojectPush push;
    UnprojectConstants constants;
};
UnprojectTerms unproject_terms(const HeightField& field, const FramePair& pair);

/// Uploads planes from the CPU's memory for kernels. The last ones stay in GPU memory: a plane known to be
/// there (PlaneView::content) is not uploaded again.
class PlaneUploads {
public:
    /// `kept`: how many planes stay.
    PlaneUploads(std::shared_ptr<GpuDevice> device, std::string name, std::size_t kept)
        : device_(device), name_(std::move(name)), uploads_(std::move(device)), kept_(kept) {}

    /// The plane's rows, `pitch` bytes apart, for kernels recorded from here on, until `kept` other planes
    /// have been uploaded. Samples are read at once.
    Result<GpuBuffer> upload(GpuCommands& commands, const PlaneView& plane, std::size_t pitch);

private:
    struct Kept {
        PlaneView plane;  // its samples may be gone
        std::size_t pitch = 0;
        GpuBuffer buffer;
        GpuCommands::Made made;
    };
    Result<void> fill(GpuCommands& commands, Kept& kept);

    std::shared_ptr<GpuDevice> device_;
    std::string name_;
    UploadPool uploads_;
    std::vector<Kept> kept_;  // most recently used first
};

/// The kernel unproject: from codes of a pair of frames and a blend to q, for display. The twin of `q_of`:
/// the same pixels are 0, the others agree to 8 units in the last place of a float (1e-6), relative to the
/// depth before height is subtracted.
class SurfaceUnproject {
public:
    explicit SurfaceUnproject(std::shared_ptr<GpuDevice> device)
        : device_(device),
          codes_(device, "view codes", 2),
          validity_(device, "view validity", 2),
          heights_(device, "view heights", 2) {}

    /// Whether the frames behind a field have codes; lazy and exact frames do not.
    static bool has_codes(const HeightField& field, const FramePair& pair);

    /// Records the kernel. `field` was made from `pair`. Frames that the Vulkan builder made on this device
    /// are read in place, others are uploaded, like heights. All must stay unchanged until it has run. `q`
    /// gets rows of `pitch` floats, 0 beyond the width.
    Result<void> record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                        const GpuBuffer& q);
    /// Makes `record` compile the programs for one frame and for two together: a playing clip needs the other
    /// one for its second picture.
    void make_programs_in_pairs() { makes_pairs_ = true; }
    static int pitch(int width);
    static std::size_t q_bytes(int width, int height);

private:
    using Constants = std::array<std::uint32_t, 6>;
    struct Planes {
        GpuBuffer codes, validity, heights;  // heights: any buffer if the frame has none
    };
    Result<Planes> planes_of(GpuCommands& commands, const SurfaceFrame& frame);
    Result<GpuProgram> program_for(const UnprojectConstants& constants);

    std::shared_ptr<GpuDevice> device_;
    PlaneUploads codes_, validity_, heights_;   // of two frames
    std::map<Constants, GpuProgram> programs_;  // made when first needed
    bool makes_pairs_ = false;
};

/// Makes lattices on a device: from codes by kernels, or from the CPU's data.
class GpuLattices {
public:
    explicit GpuLattices(std::shared_ptr<GpuDevice> device)
        : device_(std::move(device)), unproject_(device_), uploads_(device_) {}

    /// Compiles the programs of `record_view` now, and those of `record` in pairs
    /// (SurfaceUnproject). Some GPUs take half a second for one, which would stall a window later.
    Result<void> make_programs();

    /// Records commands that make q of a pair of frames; the CPU makes it if they have no codes
    /// (SurfaceUnproject::has_codes). Large enough buffers of `lattice` are reused: commands that read them
    /// must have been recorded before, followed by a barrier.
    Result<void> record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                        GpuLattice& lattice);
    /// Records what the painters need for the clip's own view or a turned one, after q is written: drawn q
    /// and edges, the twin of SurfaceEdges with the same bits, and the tile lists (cut_tiles, list_tiles),
    /// the twin of `CpuLattices::tiles_of`.
    Result<void> record_view(GpuCommands& commands, bool is_turned, GpuLattice& lattice);
    static std::size_t tile_list_bytes(int width, int height);

    /// A surface for this device's painters. Reuses the same buffers: the caller must have waited for the
    /// commands that read the last one.
    Result<GpuLattice> lattice_of(const ViewSurface& surface);

    /// Provides a buffer for a lattice's colours, unless it has a large enough one.
    Result<void> reserve_colours(GpuLattice& lattice);

private:
    Result<void> make_view_programs();
    Result<void> record_tiles(GpuCommands& commands, GpuLattice& lattice);
    Result<void> record_q(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                          const GpuLattice& lattice);
    Result<void> check_size(const char* name, std::size_t bytes) const;
    Result<void> reserve(GpuBuffer& buffer, const char* name, std::size_t bytes, GpuMemory memory);

    std::shared_ptr<GpuDevice> device_;
    SurfaceUnproject unproject_;
    UploadPool uploads_;
    GpuProgram erode_, edges_, cut_tiles_, list_tiles_;  // made when first needed
    GpuLattice uploaded_;
};

/// Fails (ErrorKind::internal) unless colours are RGB of 8 bits and of that size, or empty.
Result<void> check_colour(const PlaneView& colour, int width, int height);

/// The kernel light: from q and colours to lit colours. The twin of `lit_colours`, to 2 of 255.
class SurfaceLighting {
public:
    explicit SurfaceLighting(std::shared_ptr<GpuDevice> device)
        : device_(device), rgb_(device, "view colours", 1) {}

    /// Compiles the program for lit colours now (GpuLattices::make_programs); the others on first use.
    Result<void> make_program();

    /// Records the kernel, from the lattice's q (after it is written and a barrier recorded) to its colours.
    /// q belongs to `field`. `colour`: RGB of 8 bits, of the field's size, which is uploaded; or empty for
    /// clay, which is always lit.
    Result<void> record(GpuCommands& commands, const HeightField& field, const GpuLattice& lattice,
                        const PlaneView& colour, Lighting lighting);

private:
    Result<GpuProgram> program_for(bool has_colour, bool is_lit);

    std::shared_ptr<GpuDevice> device_;
    PlaneUploads rgb_;
    std::map<std::pair<bool, bool>, GpuProgram> programs_;  // made when first needed
};

/// The shaders view_mesh.vert and view_mesh.frag: tiles of triangles as instances, for the triangle hardware.
class MeshPipeline {
public:
    /// Fails (ErrorKind::gpu) on a device whose queue cannot draw.
    static Result<MeshPipeline> create(const GpuDevice& device);

    /// Records the drawing of a lattice between begin_drawing and end_drawing, into images of the camera's
    /// size: VK_FORMAT_R8G8B8A8_UNORM, and z of GraphicsLook's format.
    void draw(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera) const;

private:
    GraphicsProgram whole_, mixed_, gaps_;
    GpuBuffer pattern_;  // indices of a full tile's triangles
};

/// The kernels raster and raster_large: triangles by compute, for devices that have 64-bit atomics.
class SurfaceRaster {
public:
    /// Fails (ErrorKind::gpu) on a device without 64-bit atomics.
    static Result<SurfaceRaster> create(const GpuDevice& device);

    /// Records drawing a lattice into `pixels`, which it clears first: 64 bits for each pixel of the camera,
    /// row-major, rows of `pitch`, as in shaders/raster.h. `large` has at least `large_bytes`. A view other
    /// than the clip's own needs the lattice's edges.
    void record(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera,
                const GpuBuffer& pixels, int pitch, const GpuBuffer& large) const;
    static std::size_t large_bytes(int width, int height);

    /// Records the next step, after another barrier: from pixels with rows of `resolve_pitch` to their
    /// colours (PackedColour) and z, in rows of the same length. `background`: a colour per row.
    void record_resolve(GpuCommands& commands, const ViewCamera& camera, const GpuBuffer& pixels,
                        const GpuBuffer& background, const GpuBuffer& colours, const GpuBuffer& z) const;
    static int resolve_pitch(int width);

private:
    GpuProgram raster_, large_, resolve_;
};

/// The painter `raster` (shaders/raster.comp).
/// Fails (ErrorKind::gpu) on a device without 64-bit atomics.
Result<std::unique_ptr<SurfacePainter>> make_raster_painter(std::shared_ptr<GpuDevice> device);

/// The painter `mesh` (shaders/view_mesh.vert). Fails (ErrorKind::gpu) on a device whose queue cannot draw.
Result<std::unique_ptr<SurfacePainter>> make_mesh_painter(std::shared_ptr<GpuDevice> device);

/// The counterpart of `draw_dents` on the triangle hardware, for a surface picture of any painter: only
/// pixels that a dent may reach cost time.
class DentDrawing {
public:
    static Result<DentDrawing> create(const std::shared_ptr<GpuDevice>& device);

    /// Records the fingers' dents (`shape_dents`; nothing without dents) into a picture of the camera's size
    /// (VK_FORMAT_R8G8B8A8_UNORM) and its z, which are and stay in VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL
    /// and VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL. z is unchanged.
    Result<void> record(GpuCommands& commands, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                        const ViewCamera& camera, const GpuImage& colour, const GpuImage& z);

private:
    explicit DentDrawing(const std::shared_ptr<GpuDevice>& device) : device_(device), uploads_(device) {}
    Result<GpuBuffer> upload(const ViewCamera& camera);
    Result<void> copy_flat(GpuCommands& commands, const ViewCamera& camera, const GpuImage& colour);

    std::shared_ptr<GpuDevice> device_;
    UploadPool uploads_;
    GraphicsProgram program_;
    std::vector<SurfaceDent> dents_;
    GpuImage flat_;  // the picture without dents; empty until the first dent
};

/// The counterpart of `draw_fingers` on the triangle hardware (shaders/view_marks.h): the same shapes in the
/// same light. Threads are ribbons, and edges are smooth.
class FingerDrawing {
public:
    static Result<FingerDrawing> create(const std::shared_ptr<GpuDevice>& device);

    /// Records drawing over a picture of the camera's size and its z, which are and stay in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL and VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL. z then includes
    /// the fingers.
    Result<void> record(GpuCommands& commands, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                        const ViewCamera& camera, const GpuImage& colour, const GpuImage& z);

private:
    explicit FingerDrawing(const std::shared_ptr<GpuDevice>& device) : uploads_(device) {}

    struct Part {
        std::size_t offset = 0, bytes = 0;
    };
    struct Parts {
        Part solids, threads, shadows;
    };
    Result<GpuBuffer> upload(const ViewCamera& camera, Parts& parts);
    void draw_solids(GpuCommands& commands, const ViewCamera& camera, const GpuBuffer& records,
                     const Parts& parts) const;

    UploadPool uploads_;
    struct SolidPrograms {
        GraphicsProgram ball, frustum;
    };
    GraphicsProgram shadow_, thread_;
    SolidPrograms solid_, veil_, hidden_veil_;
    GpuBuffer pattern_;  // indices of a frustum's triangles
    FingerShapes shapes_;
};

}  // namespace touchable
