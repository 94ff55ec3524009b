#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/picture/image_file.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/surface_lighting.hpp"
#include "player/window/screen.hpp"

namespace touchable {

/// Makes the window's pictures, one after the other, and shows them. Each is: `begin`, `show` where its
/// surface is another than the last one's, `draw`, ImGui's calls, `finish`. By the main thread.
class WindowGraphics {
public:
    virtual ~WindowGraphics() = default;
    virtual std::string_view painter() const = 0;  ///< cpu, raster or mesh
    virtual std::string gpu() const = 0;           ///< that it draws on; empty: none
    /// That GPU, or what it shows by, is lost: nothing more can be drawn by these graphics.
    virtual bool is_lost() const = 0;
    virtual bool can_stretch() const = 0;
    /// Whether `show` heeds its step.
    virtual bool thins_vertices() const = 0;

    /// After ImGuiLayer::set_scale.
    virtual Result<void> take_letters() = 0;
    virtual Result<void> begin() = 0;
    /// As SurfaceDrawing::show.
    virtual Result<void> show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                              Lighting lighting, int step) = 0;
    /// As SurfaceDrawing::draw, stretched over a picture of width x height.
    virtual Result<void> draw(const ViewCamera& camera, std::span<const FingerMark> fingers,
                              const MarkSizes& sizes, int width, int height) = 0;
    /// Draws over it what ImGui has laid out, and shows it. Nothing that it was made of is read after that.
    virtual Result<void> finish() = 0;
    /// What was finished last, RGB; ErrorKind::usage before the first.
    virtual Result<Image> picture() const = 0;
};

/// On a GPU that `screen` is attached to, by `painter`: auto, raster and mesh as SurfaceDrawing has them;
/// cpu draws surface and fingers on the CPU, the panel on the GPU. There is an ImGuiLayer, which outlives it.
Result<std::unique_ptr<WindowGraphics>> make_gpu_graphics(std::shared_ptr<GpuDevice> device,
                                                          std::string_view painter, Screen& screen);

/// In the CPU's memory, without Vulkan, and without what ImGui has laid out, which only a GPU draws.
std::unique_ptr<WindowGraphics> make_cpu_graphics();

}  // namespace touchable
