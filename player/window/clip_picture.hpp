#pragma once

#include <memory>
#include <optional>
#include <span>
#include <string>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/result.hpp"
#include "player/session/watched_session.hpp"
#include "player/view/gpu_image.hpp"
#include "player/view/overlays.hpp"
#include "player/view/surface_drawing.hpp"

namespace touchable {

/// The picture of what a hand is at: surface and fingers, on a canvas that stays on the GPU.
class ClipPicture {
public:
    /// `painter` as in SurfaceDrawing.
    static Result<ClipPicture> create(std::shared_ptr<GpuDevice> device, const std::string& painter);

    /// Records it all, of the camera's size, stretched over a canvas of width x height. The surface is made
    /// anew only where frames, blend or overlay are others than before; the moment stays as it is until the
    /// commands have completed. Leaves the canvas ready to be drawn over.
    Result<void> draw(GpuCommands& commands, const WatchedMoment& moment, const HeightField& field,
                      const ViewCamera& camera, std::span<const FingerMark> fingers, const MarkSizes& sizes,
                      int width, int height);
    /// VK_FORMAT_R8G8B8A8_UNORM.
    const GpuImage& canvas() const { return canvas_; }
    /// Of the last camera.
    int drawn_width() const { return drawn_width_; }
    int drawn_height() const { return drawn_height_; }
    std::string_view painter() const { return drawing_->painter(); }
    Overlay overlay() const { return overlay_; }
    void set_overlay(Overlay overlay);
    /// What the overlay's colours mean; null where they are the clip's.
    const OverlayScale* scale() const { return overlay_ == Overlay::colour ? nullptr : &scale_; }
    /// Another clip: nothing of the last one serves.
    void forget();

private:
    ClipPicture(std::shared_ptr<GpuDevice> device, std::unique_ptr<SurfaceDrawing> drawing)
        : device_(std::move(device)), drawing_(std::move(drawing)) {}
    Result<void> show(GpuCommands& commands, const WatchedMoment& moment, const HeightField& field);
    Result<void> reserve(GpuImage& image, const char* name, int width, int height) const;

    struct Shown {
        std::uint64_t epoch = 0;
        std::int64_t prev = -1, next = -1;
        double blend = 0;
        const void* colour = nullptr;
        bool operator==(const Shown&) const = default;
    };
    std::shared_ptr<GpuDevice> device_;
    std::unique_ptr<SurfaceDrawing> drawing_;
    std::unique_ptr<Overlays> overlays_ = std::make_unique<Overlays>();
    GpuImage canvas_;
    int drawn_width_ = 0, drawn_height_ = 0;
    GpuImage small_;  // what is stretched over it, if anything is
    Overlay overlay_ = Overlay::colour;
    OverlayScale scale_;
    std::optional<Shown> shown_;
};

}  // namespace touchable
