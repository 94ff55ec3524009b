// SPDX-License-Identifier: Apache-2.0
#pragma once

// Pictures of a surface and of the fingers on it: the module's main interface.
//
// For a single picture, make a painter and the surface, and compose the picture:
//
//     TRY_ASSIGN(const auto painter, make_painter("auto", open_gpu));
//     const ViewSurface surface = surface_of(field, pair, colour, Lighting::off);
//     TRY_ASSIGN(auto image,
//                make_picture({viewpoint}, scene, surface, subject_of(field), {}, {}, *painter));
//
// The painters are `cpu` (vectors and threads), `raster` (compute shaders) and `mesh` (the GPU's triangles).
// They draw the same pixels but for roundings of z.
//
// For a sequence of pictures, as in a window, use `SurfaceDrawing` on a GPU or `CpuDrawing` without one:
// `show` a surface whenever it changes, `draw` it from any camera. Nothing is read back from the GPU.
// `SurfaceDrawing::step_for` says how far a surface's vertices may be decimated if a window has fewer pixels
// than the clip.
//
// `colour` is RGB of 8 bits a channel, of the field's size, or empty for lit clay.
// Threads: a painter or a drawing belongs to one at a time; different ones are independent.

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
#include "player/draw/overlays.hpp"
#include "player/view/drawn_surface.hpp"
#include "player/view/view.hpp"

namespace touchable {

class GpuCommands;
class GpuDevice;
struct GpuFacts;
class GpuImage;

/// The surface of `field`, which was made from `pair`, by the CPU.
ViewSurface surface_of(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                       Lighting lighting);

/// Draws the triangles of a surface that shaders/cut_rule.h keeps, at full resolution, both sides, nearest
/// first. Painters differ only in the hardware used: pixels agree except for rounding of z.
class SurfacePainter {
public:
    /// The requested picture.
    struct Settings {
        Viewpoint viewpoint;
        int width = 1280, height = 720;  ///< pixels, 1 to 8192
    };

    virtual ~SurfacePainter() = default;
    virtual std::string_view name() const = 0;
    /// The GPU that draws; empty for the CPU.
    virtual std::string gpu_name() const { return {}; }
    virtual Result<PicturePlanes> paint(const ViewSurface& surface, const ViewCamera& camera) = 0;
};

/// Uses the CPU's vectors and threads, without a GPU.
std::unique_ptr<SurfacePainter> make_cpu_painter();

/// Measures the time of either painter for a picture on a GPU (facts.measured), unless it is known: some tens
/// of milliseconds, plus compiling programs that the faster painter needs anyway. The measurement may lose
/// the device; facts.measured then records that. One thread at a time.
void measure_painters(const std::shared_ptr<GpuDevice>& device);
/// What "auto" means on this device: cpu if Vulkan runs on the CPU; otherwise mesh or raster, by measurement,
/// without one mesh.
std::string_view usual_painter(const GpuFacts& facts);

/// "cpu", "raster" or "mesh" on the GPU that `open_gpu` returns (cpu does not call it), or "auto": that of
/// `usual_painter`, cpu without Vulkan. Fails (ErrorKind::gpu) if a painter requested by name is not
/// available.
Result<std::unique_ptr<SurfacePainter>> make_painter(
    std::string_view name, const std::function<Result<std::shared_ptr<GpuDevice>>()>& open_gpu);

/// The surface and the fingers on it, from any viewpoint, with smooth edges: supersampled two or three times
/// a side (as memory allows) and averaged as light. An orbit goes round the middle of `subject`, and shows
/// all of it unless the viewpoint has a zoom. If there are fingers and the picture is large enough, a legend
/// explains them.
Result<Image> make_picture(const SurfacePainter::Settings& settings, const Scene& scene,
                           const ViewSurface& surface, const Viewpoint::Subject& subject,
                           std::span<const FingerMark> fingers, const MarkSizes& sizes,
                           SurfacePainter& painter);

/// Draws a surface and the fingers on it, picture after picture, into reused memory, for a window: on the
/// device from codes to colours, or the surface by the CPU. The same picture as `make_picture` with one
/// sample a pixel, except that fingers have smooth edges, and the CPU's turned views smooth silhouettes.
///
/// Submit recorded commands in the order of recording; results of commands that are dropped instead are
/// recomputed when needed. Not thread-safe.
class SurfaceDrawing {
public:
    virtual ~SurfaceDrawing() = default;

    /// painter: "cpu" (which draws the fingers on the device), "raster", "mesh" or "auto", as in
    /// make_painter. Fails (ErrorKind::gpu) if the device does not support it; ErrorKind::usage for another
    /// name.
    static Result<std::unique_ptr<SurfaceDrawing>> create(std::shared_ptr<GpuDevice> device,
                                                          std::string_view painter);

    /// The greatest power of two, at most 8, whose decimated vertices lie at most 1.5 pixels apart; 1 if
    /// `pixels_per_vertex` > 0.75.
    static int step_for(double pixels_per_vertex);

    /// "cpu", "raster" or "mesh".
    virtual std::string_view painter() const = 0;

    /// Whether `show` uses its `step`, and `draw` stretches: only if the CPU draws.
    virtual bool thins_vertices() const = 0;

    /// Sets the surface to draw: records the commands that make q and colours from the pair behind `field`.
    /// The CPU makes them at once, keeping only every `step`th vertex across and down, a power of two: a
    /// level of detail (`step_for`). `colour`: RGB of 8 bits, of the field's size, or empty for light and
    /// depth alone. It is read at once; the pair's frames must live until the recorded commands have
    /// completed. Planes still in GPU memory (PlaneView::content, SurfaceFrame::content) are not uploaded
    /// again. Fails (ErrorKind::gpu) if the surface is larger than a kernel may read.
    virtual Result<void> show(GpuCommands& commands, const HeightField& field, const FramePair& pair,
                              const PlaneView& colour, Lighting lighting, int step = 1) = 0;

    /// Records drawing surface, background and fingers (without a submitted `show`: the latter two) into
    /// `target` (VK_FORMAT_R8G8B8A8_UNORM, of the camera's size; if the CPU draws, also two or four times as
    /// wide and high: it stretches the surface, the fingers have the target's pixels). All of it is written
    /// and left in VK_IMAGE_LAYOUT_COLOR_ATTACHMENT_OPTIMAL; later commands must wait for that, as
    /// record_transition does. The CPU draws the surface at once, from the last `show`. Fails
    /// (ErrorKind::gpu) if the picture is too large for the painter on this device.
    virtual Result<void> draw(GpuCommands& commands, const ViewCamera& camera,
                              std::span<const FingerMark> fingers, const MarkSizes& sizes,
                              const GpuImage& target) = 0;
};

/// SurfaceDrawing's counterpart with the `cpu` painter: a surface and the fingers on it, picture after
/// picture, in the CPU's memory. One sample a pixel: edges are not smooth. Not thread-safe.
class CpuDrawing {
public:
    CpuDrawing();
    ~CpuDrawing();

    /// Sets the surface to draw. `field` was made from `pair`; both, and `colour` (RGB of 8 bits, of the
    /// field's size, or empty for light and depth alone), are read at once.
    void show(const HeightField& field, const FramePair& pair, const PlaneView& colour, Lighting lighting);

    /// Surface, background and fingers; before the first `show`, without the surface. Of the camera's size,
    /// or with several samples along a pixel's side, averaged as light; RGB; valid until the next call.
    Result<const Image*> draw(const ViewCamera& camera, std::span<const FingerMark> fingers,
                              const MarkSizes& sizes, int samples = 1);

private:
    struct Parts;
    std::unique_ptr<Parts> parts_;
};

}  // namespace touchable
