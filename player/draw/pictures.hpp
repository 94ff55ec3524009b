#pragma once

// Pictures of a surface and of the fingers on it: the module's front door.
//
// For one picture, make a painter, let it make the surface of a moment, and put the picture together:
//
//     TRY_ASSIGN(const auto painter, make_painter("auto", open_gpu));
//     TRY_ASSIGN(const auto surface, painter->surface_of(field, pair, colour));
//     TRY_ASSIGN(auto image,
//                make_picture({viewpoint}, scene, surface, subject_of(field), {}, {}, *painter));
//
// The painters are `cpu` (vectors and threads), `raster` (compute shaders) and `mesh` (the GPU's triangles).
// They draw the same pixels but for roundings of z.
//
// For pictures one after the other, as a window shows them, there are `SurfaceDrawing` on a GPU and
// `CpuDrawing` without one: `show` a surface whenever it changes, `draw` it from any camera. Nothing is read
// back from the GPU. `SurfaceDrawing::step_for` says how far a surface's vertices may be thinned where a
// window has fewer pixels than the clip.
//
// `colour` is RGB of 8 bits a channel, of the field's size, or empty: clay in light. A painter and a
// drawing each belong to one thread at a time; different ones are independent.

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "haptics_cpu/height_field.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/view.hpp"

namespace touchable {

class GpuCommands;
class GpuDevice;
struct GpuFacts;
class GpuImage;
struct GpuLattice;
struct PicturePlanes;

/// What becomes of a colour at a vertex.
enum class Lighting {
    lit,    ///< in a gentle light that shows relief
    plain,  ///< as it is: of maps, whose colours say something
};

/// What a painter draws: the lattice at one moment, with a colour at every vertex.
struct ViewSurface {
    /// Tiles of TileGrid worth drawing, as row * tiles_x + column, ascending.
    struct Tiles {
        std::vector<std::uint32_t> whole;  ///< no triangle in them is cut (shaders/cut_rule.h)
        /// Some are; there is one without a hole, which the clip's own view shows.
        std::vector<std::uint32_t> mixed;
        bool operator==(const Tiles&) const = default;
    };

    int width = 0, height = 0;
    std::vector<float> q;               ///< 1 / planar depth, height taken off; 0: invalid. Row-major
    std::vector<PackedColour> colours;  ///< row-major
    bool colours_are_values = false;    ///< of a scale: nothing may darken them
    Tiles tiles;
    std::shared_ptr<const GpuLattice> on_gpu;  ///< q and tiles once more, where they were made on a GPU

    std::size_t index(int x, int y) const { return pixel_place(x, y, width); }
};

/// Draws the triangles of a surface that shaders/cut_rule.h keeps, at full resolution, both sides, nearest
/// first. Painters differ in where they do it, not in what: pixels agree but for the roundings of z.
class SurfacePainter {
public:
    /// A picture as asked for.
    struct Settings {
        Viewpoint viewpoint;
        int width = 1280, height = 720;  ///< pixels, 1 to 8192
    };

    virtual ~SurfacePainter() = default;
    virtual std::string_view name() const = 0;
    /// The GPU that draws; empty: none does.
    virtual std::string gpu_name() const { return {}; }
    /// `make_view_surface` of `field`, which `pair` is behind, made where this painter draws: q agree to
    /// 1e-6.
    virtual Result<ViewSurface> surface_of(const HeightField& field, const FramePair& pair,
                                           const PlaneView& colour) = 0;
    virtual Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) = 0;
};

/// By the CPU's vectors and threads, without a GPU. Does not read a surface's tiles.
std::unique_ptr<SurfacePainter> make_cpu_painter();

/// Measures on a GPU what a picture takes either painter (facts.measured), unless that is known: some tens of
/// milliseconds, and the making of programs that the faster one needs anyway. The device may be lost by that,
/// which then is known too. One thread at a time.
void measure_painters(const std::shared_ptr<GpuDevice>& device);
/// Whether "auto" is mesh there, not raster: as was measured; otherwise mesh on a GPU, raster where Vulkan
/// computes on the CPU.
bool draws_by_mesh(const GpuFacts& facts);

/// "cpu", "raster" or "mesh" on the GPU that `open_gpu` gives, which cpu does not ask for, or "auto": mesh or
/// raster (draws_by_mesh), cpu where there is no Vulkan. Refused (ErrorKind::gpu) where
/// what is asked for by name is not to be had.
Result<std::unique_ptr<SurfacePainter>> make_painter(
    std::string_view name, const std::function<Result<std::shared_ptr<GpuDevice>>()>& open_gpu);

/// The surface and the fingers on it, from anywhere, smooth at edges: painted two or three times as large (as
/// memory allows) and averaged in light. An orbit goes round the middle of `subject`, and shows all of it
/// unless the viewpoint has a zoom. Where there are fingers, and the picture is large enough, a legend
/// explains them.
Result<Image> make_picture(const SurfacePainter::Settings& settings, const Scene& scene,
                           const ViewSurface& surface, const Viewpoint::Subject& subject,
                           std::span<const FingerMark> fingers, const MarkSizes& sizes,
                           SurfacePainter& painter);

/// Draws a surface and the fingers on it picture after picture, on the device from codes to colours, into
/// memory that stays: what a window shows. The same picture as `make_picture`'s of one sample a pixel, but
/// that fingers have smooth edges.
///
/// Recorded calls are to be submitted in the order in which they were recorded; what is forgotten instead is
/// made again when it is needed. Not for two threads at once.
class SurfaceDrawing {
public:
    virtual ~SurfaceDrawing() = default;

    /// painter: "raster", "mesh" or "auto", as in make_painter. Fails (ErrorKind::gpu) where the device can
    /// do neither, or not what is asked for by name; ErrorKind::usage for another name.
    static Result<std::unique_ptr<SurfaceDrawing>> create(std::shared_ptr<GpuDevice> device,
                                                          std::string_view painter);

    /// The greatest power of two for a `step` whose vertices lie at most 1.5 pixels apart; 1 where neighbours
    /// lie `pixels_per_vertex` > 0.75 apart already.
    static int step_for(double pixels_per_vertex);

    /// "raster" or "mesh".
    virtual std::string_view painter() const = 0;

    /// Whether `show` heeds its step: the CPU draws.
    virtual bool thins_vertices() const = 0;

    /// From now on this surface is drawn: records what makes q and colours of the pair that `field` is of.
    /// For the raster of a software device the CPU makes them at once, and there no more than every `step`th
    /// vertex across and down, a power of two: a level of detail (`step_for`). `colour`: RGB of 8 bits, of
    /// the field's size, or empty for light and depth alone. It is read at once; the pair's frames stay until
    /// what is recorded has completed. Planes that the GPU still has (PlaneView::content,
    /// SurfaceFrame::content) are not uploaded again. Fails (ErrorKind::gpu) where the surface is larger than
    /// a kernel may read.
    virtual Result<void> show(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                              const PlaneView& colour, Lighting lighting, int step = 1) = 0;
    /// The same where the CPU draws, which needs no commands.
    virtual Result<void> show_by_cpu(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                                     Lighting lighting, int step) = 0;

    /// The CPU of a software device draws the surface at once, from what `show` left. Records the drawing of
    /// surface, background and fingers (without a `show` that was submitted, of these two) into `target`
    /// (VK_FORMAT_R8G8B8A8_UNORM, of the camera's size), all of which is written, and which is left in
    /// VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL. Whatever comes after it is to wait for that, as
    /// record_transition does. Fails (ErrorKind::gpu) where the picture is too large for the painter on this
    /// device.
    virtual Result<void> draw(GpuCommands& commands, const ViewCamera& camera,
                              std::span<const FingerMark> fingers, const MarkSizes& sizes,
                              const GpuImage& target) = 0;
};

/// The twin of SurfaceDrawing by the `cpu` painter: a surface and the fingers on it, picture after picture,
/// in the CPU's memory. One sample a pixel: edges are not smooth. Not for two threads at once.
class CpuDrawing {
public:
    CpuDrawing();
    ~CpuDrawing();

    /// From now on this surface is drawn. `pair` is what `field` was made of; both, and `colour` (RGB of 8
    /// bits, of the field's size, or empty for light and depth alone), are read at once.
    void show(const HeightField& field, const FramePair& pair, const PlaneView& colour, Lighting lighting);

    /// Surface, background and fingers; background and fingers alone before the first `show`. Of the camera's
    /// size, RGB; stays readable until the next call.
    Result<const Image*> draw(const ViewCamera& camera, std::span<const FingerMark> fingers,
                              const MarkSizes& sizes);

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace touchable
