#pragma once

// Surfaces and fingers painted by a GPU: from a pair of frames to a lattice in its memory (GpuLattices), the
// lattice's colours (SurfaceLighting), its triangles by compute (SurfaceRaster) or by the triangle hardware
// (MeshPipeline), and over such a picture dents and fingers. All of it records commands, which the caller
// submits in the order in which they were recorded.

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
#include "player/draw/drawn_surface.hpp"
#include "player/draw/gpu_image.hpp"
#include "player/draw/graphics_program.hpp"
#include "player/draw/light_picture.hpp"
#include "player/draw/pictures.hpp"
#include "player/draw/view.hpp"
#include "shaders/unproject.h"

namespace touchable {

/// A lattice in a GPU's memory, as painters there read it.
struct GpuLattice {
    std::shared_ptr<VulkanDevice> vulkan;  ///< whose memory it is
    int width = 0, height = 0;
    int pitch = 0;      ///< vertices from one row of q and colours to the next
    int step = 1;       ///< of the clip's pixels, from vertex to vertex (Decimation)
    GpuBuffer q;        ///< floats, row-major
    GpuBuffer colours;  ///< PackedColour, row-major
    GpuBuffer tiles;    ///< which ones to draw: shaders/tile_lists.h
    GpuBuffer classes;  ///< of each tile, between the kernels that find them
    GpuBuffer edges;    ///< where vertices at edges are drawn: shaders/edges.h; for turned views
};

/// What the arithmetic of shaders/unproject.h needs of a pair of frames that have codes; how lanes share rows
/// is left open. `pair` is what `field` was made of.
struct UnprojectTerms {
    UnprojectPush push;
    UnprojectConstants constants;
};
UnprojectTerms unproject_terms(const HeightField& field, const FramePair& pair);

/// Planes in the CPU's memory, uploaded for kernels. The last ones stay in the GPU's memory: a plane that is
/// known to be there (PlaneView::content) is not uploaded again.
class PlaneUploads {
public:
    /// `kept`: how many planes stay.
    PlaneUploads(std::shared_ptr<GpuDevice> device, std::string name, std::size_t kept)
        : device_(device), name_(std::move(name)), uploads_(std::move(device)), kept_(kept) {}

    /// The plane's rows, `pitch` bytes apart, for kernels that these commands run from here on, until `kept`
    /// others have been asked for. Samples are read at once.
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
    std::vector<Kept> kept_;  // the one that was used last comes first
};

/// The kernel unproject: codes of a pair of frames at a blend to q, for the eye. The twin of `q_of`: the same
/// pixels are 0, the others agree to 8 units in the last place of a float (1e-6), of the depth before height
/// is taken off.
class SurfaceUnproject {
public:
    explicit SurfaceUnproject(std::shared_ptr<GpuDevice> device)
        : device_(device),
          codes_(device, "view codes", 2),
          validity_(device, "view validity", 2),
          heights_(device, "view heights", 2) {}

    /// Whether the frames behind a field have codes to begin with; lazy and exact ones have not.
    static bool has_codes(const HeightField& field, const FramePair& pair);

    /// Records the kernel. `pair` is what `field` was made of; frames that the Vulkan builder made on this
    /// device are read where they are, others are uploaded, as heights are. They stay as they are until it
    /// has run. `q` gets rows of `pitch` floats, 0 beyond the width.
    Result<void> record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                        const GpuBuffer& q);
    /// From now on `record` makes the programs for one frame and for two together: when a clip plays, the
    /// second picture already needs the other one.
    void make_programs_in_pairs() { makes_pairs_ = true; }
    static int pitch(int width);
    static std::size_t q_bytes(int width, int height);

private:
    using Constants = std::array<std::uint32_t, 7>;
    struct Planes {
        GpuBuffer codes, validity, heights;  // heights: any buffer where the frame has none
    };
    Result<Planes> planes_of(GpuCommands& commands, const SurfaceFrame& frame);
    Result<GpuProgram> program_for(const UnprojectConstants& constants);

    std::shared_ptr<GpuDevice> device_;
    PlaneUploads codes_, validity_, heights_;   // of two frames
    std::map<Constants, GpuProgram> programs_;  // made when first needed
    bool makes_pairs_ = false;
};

/// The tiles of lists in mapped memory, as kernels and indirect commands read them (shaders/tile_lists.h).
ViewSurface::Tiles read_tiles(const GpuBuffer& buffer);

/// q of a field without codes, in rows of the lattice's pitch, into a mapped buffer as large as its q.
void put_q(const HeightField& field, const GpuLattice& lattice, const GpuBuffer& to);

/// Makes lattices on a device: from codes by kernels, or from what the CPU made.
class GpuLattices {
public:
    explicit GpuLattices(std::shared_ptr<GpuDevice> device)
        : device_(std::move(device)), unproject_(device_), uploads_(device_) {}

    /// Makes the programs of `record_tiles` and `record_edges` now, and those of `record` in pairs
    /// (SurfaceUnproject). Some GPUs take half a second for one, during which a window would stand still.
    Result<void> make_programs();

    /// Records what makes q of a pair of frames; by the CPU where they have no codes
    /// (SurfaceUnproject::has_codes). Buffers of `lattice` that are large enough serve again: commands that
    /// read them have been recorded before, and a barrier after them.
    Result<void> record(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                        GpuLattice& lattice);
    /// Records what makes the tiles worth drawing, once q is written: the kernels cut_tiles and list_tiles,
    /// the twin of `CpuLattices::tiles_of`. From the same q, the same lists.
    Result<void> record_tiles(GpuCommands& commands, GpuLattice& lattice);
    static std::size_t tile_list_bytes(int width, int height);

    /// Records what finds where vertices at edges are drawn, once q is written: the twin of SurfaceEdges, the
    /// same bits. For the clip's own view nothing. `are_values`: as there.
    Result<void> record_edges(GpuCommands& commands, const ViewCamera& camera, bool are_values,
                              GpuLattice& lattice);

    /// `make_view_surface`, with q and tiles by `record`, which stay on the GPU beside; where the frames have
    /// no codes, that of CpuLattices.
    Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair, const PlaneView& colour);

    /// A surface where painters on this device read it: only colours are uploaded where the rest is there.
    /// One at a time into the same buffers: the caller has waited for what reads the last one.
    Result<GpuLattice> lattice_of(const ViewSurface& surface);

    /// A buffer for the colours of a lattice, if it has none that is large enough.
    Result<void> reserve_colours(GpuLattice& lattice);

    /// q and colours for a field that the CPU writes; the last ones stay for commands that still read them.
    Result<void> renew(const HeightField& field, GpuLattice& lattice);

private:
    Result<void> make_tile_programs();
    Result<void> make_edge_program();
    Result<void> record_q(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                          const GpuLattice& lattice);
    Result<void> check_size(const char* name, std::size_t bytes) const;
    void set_size(int width, int height, GpuLattice& lattice) const;
    Result<void> reserve(GpuBuffer& buffer, const char* name, std::size_t bytes, GpuMemory memory);
    Result<GpuLattice> read_back(const HeightField& field, const FramePair& pair, GpuLattice& lattice);

    std::shared_ptr<GpuDevice> device_;
    SurfaceUnproject unproject_;
    UploadPool uploads_;
    GpuProgram cut_tiles_, list_tiles_, edges_;  // made when first needed
    GpuLattice uploaded_;
};

/// Refused (ErrorKind::internal): colours that are not RGB of 8 bits and of that size, nor empty.
Result<void> check_colour(const PlaneView& colour, int width, int height);

/// The kernel light: q and colours to lit colours. The twin of `lit_colours`, to 2 of 255.
class SurfaceLighting {
public:
    explicit SurfaceLighting(std::shared_ptr<GpuDevice> device)
        : device_(device), rgb_(device, "view colours", 1) {}

    /// Makes the program for lit colours now (GpuLattices::make_programs); the others when first needed.
    Result<void> make_program();

    /// Records the kernel, from the lattice's q, once that is written and a barrier recorded after, to its
    /// colours. `field` is what q is of. `colour`: RGB of 8 bits, of the field's size, uploaded; or empty for
    /// clay, which is always lit.
    Result<void> record(GpuCommands& commands, const HeightField& field, const GpuLattice& lattice,
                        const PlaneView& colour, Lighting lighting);

private:
    Result<GpuProgram> program_for(bool has_colour, bool is_lit);

    std::shared_ptr<GpuDevice> device_;
    PlaneUploads rgb_;
    std::map<std::pair<bool, bool>, GpuProgram> programs_;  // made when first needed
};

/// The shaders view_mesh.vert and view_mesh.frag: tiles of triangles by instances, for the triangle hardware.
class MeshPipeline {
public:
    /// Fails (ErrorKind::gpu) on a device whose queue does not draw.
    static Result<MeshPipeline> create(const GpuDevice& device);

    /// Records the drawing of a lattice between begin_drawing and end_drawing, into images of the camera's
    /// size: VK_FORMAT_R8G8B8A8_UNORM, and z of GraphicsLook's format.
    void draw(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera) const;

private:
    GraphicsProgram whole_, mixed_;
    GpuBuffer pattern_;  // indices of a whole tile's triangles
};

/// The kernels raster and raster_large: triangles by compute, for devices that have 64-bit atomics.
class SurfaceRaster {
public:
    /// Fails (ErrorKind::gpu) on a device without 64-bit atomics.
    static Result<SurfaceRaster> create(const GpuDevice& device);

    /// Records the drawing of a lattice into `pixels`, which are cleared first: 64 bits for each pixel of the
    /// camera, row-major, `pitch` from one row to the next, as shaders/raster.h says. `large` has
    /// `large_bytes` at least. A view that is not the clip's own needs the lattice's edges.
    void record(GpuCommands& commands, const GpuLattice& lattice, const ViewCamera& camera,
                const GpuBuffer& pixels, int pitch, const GpuBuffer& large) const;
    static std::size_t large_bytes(int width, int height);

    /// Records what comes next, once a barrier is recorded after that: from pixels with rows of
    /// `resolve_pitch` to their colours (PackedColour) and z, rows as long. `background`: a colour for each
    /// row.
    void record_resolve(GpuCommands& commands, const ViewCamera& camera, const GpuBuffer& pixels,
                        const GpuBuffer& background, const GpuBuffer& colours, const GpuBuffer& z) const;
    static int resolve_pitch(int width);

private:
    bool on_cpu_ = false;
    GpuProgram raster_, large_, resolve_;
};

/// By compute (shaders/raster.comp): several times cheaper than triangles where the GPU is a CPU. Fails
/// (ErrorKind::gpu) on a device without 64-bit atomics.
Result<std::unique_ptr<SurfacePainter>> make_raster_painter(std::shared_ptr<GpuDevice> device);

/// By the triangle hardware (shaders/mesh.vert). Fails (ErrorKind::gpu) on a device whose queue does not
/// draw.
Result<std::unique_ptr<SurfacePainter>> make_mesh_painter(std::shared_ptr<GpuDevice> device);

/// What `draw_dents` draws, by triangle hardware, over the picture of a surface that any painter drew: only
/// pixels that a dent may reach cost anything.
class DentDrawing {
public:
    static Result<DentDrawing> create(const std::shared_ptr<GpuDevice>& device);

    /// Records the dents that fingers make (`shape_dents`; nothing where they make none) into a picture of
    /// the camera's size (VK_FORMAT_R8G8B8A8_UNORM) and its z, which are and stay in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL and VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL. z stays as it
    /// is.
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
    GpuImage flat_;  // where there are dents: what the picture is without them
};

/// A picture of a surface as painters leave it in memory, rows of `pitch`.
struct FlatPicture {
    std::span<const PackedColour> colours;
    std::span<const float> z;  ///< ViewCamera's; 0: background
    int width = 0, height = 0, pitch = 0;
};

/// What `draw_dents` draws, by the CPU for devices that compute on it: a shader took ten times as long there.
/// How far a pixel's place has come, and its light, are found at some places and straight in between; a
/// channel differs from `draw_dents` by a few of 255.
class DentPatches {
public:
    explicit DentPatches(std::shared_ptr<GpuDevice> device) : uploads_(std::move(device)) {}

    /// Records the dents that fingers make over `target`, which shows `flat`, and is and stays in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL. `flat` is read at once.
    Result<void> record(GpuCommands& commands, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                        const ViewCamera& camera, const FlatPicture& flat, const GpuImage& target);

private:
    struct Node {
        float right = 0, down = 0;  // from a pixel to what it shows, pixels
        float light = 1, gloss = 0;
    };
    struct Sight;
    void find_nodes(const Sight& sight, const FlatPicture& flat, const PixelBounds& bounds);
    void draw(const FlatPicture& flat, const PixelBounds& bounds, PackedColour* to) const;

    UploadPool uploads_;
    std::vector<SurfaceDent> dents_;
    std::vector<Node> nodes_;
    int step_ = 1, across_ = 0;  // pixels from one node to the next; nodes in a row
};

/// What `draw_fingers` draws, by triangle hardware (shaders/view_marks.h): the same shapes in the same light.
/// Threads are ribbons, and edges are smooth.
class FingerDrawing {
public:
    static Result<FingerDrawing> create(const std::shared_ptr<GpuDevice>& device);

    /// Records the drawing over a picture of the camera's size and its z, which are and stay in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL and VK_IMAGE_LAYOUT_DEPTH_ATTACHMENT_OPTIMAL. z is then of
    /// the fingers too.
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
