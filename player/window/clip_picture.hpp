#pragma once

#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/result.hpp"
#include "player/draw/overlays.hpp"
#include "player/session/watched_session.hpp"
#include "player/window/segment_tint.hpp"
#include "player/window/window_graphics.hpp"

namespace touchable {

/// The picture of what a hand is at: surface and fingers.
class ClipPicture {
public:
    /// Between `begin` and `finish` of the graphics: of the camera's size, stretched over a canvas of width x
    /// height; of the surface every `step`th vertex, as SurfaceDrawing::show. The
    /// surface is made anew only where frames, blend or overlay are others than before; the moment stays as
    /// it is until the picture is finished.
    Result<void> draw(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera,
                      std::span<const FingerMark> fingers, const MarkSizes& sizes, int width, int height,
                      int step = 1);
    /// Other graphics from now on; none: nothing is drawn until there are others. Those before end first.
    void use(std::unique_ptr<WindowGraphics> graphics) {
        graphics_ = std::move(graphics);
        shown_.reset();
    }
    WindowGraphics& graphics() { return *graphics_; }
    const WindowGraphics& graphics() const { return *graphics_; }
    /// Of the last camera.
    int drawn_width() const { return drawn_width_; }
    int drawn_height() const { return drawn_height_; }
    int drawn_step() const { return shown_ ? shown_->step : 1; }  ///< from vertex to vertex
    Overlay overlay() const { return overlay_; }
    void set_overlay(Overlay overlay);
    /// Segments in place of the clip's own colours; null: those.
    void set_tint(std::shared_ptr<const PaintedSegments> painted) { tinted_ = std::move(painted); }
    /// What the overlay's colours mean; null where they are the clip's.
    const OverlayScale* scale() const { return overlay_ == Overlay::colour ? nullptr : &scale_; }
    /// Another clip: nothing of the last one serves.
    void forget();

private:
    Result<void> show(const WatchedMoment& moment, const HeightField& field, int step);

    struct Shown {
        std::uint64_t epoch = 0;
        std::int64_t prev = -1, next = -1;
        double blend = 0;
        const void* colour = nullptr;
        std::shared_ptr<const PaintedSegments> tinted;
        int step = 1;
        bool operator==(const Shown&) const = default;
    };
    std::unique_ptr<WindowGraphics> graphics_;
    std::shared_ptr<const PaintedSegments> tinted_;
    SegmentTint tint_;
    std::unique_ptr<Overlays> overlays_ = std::make_unique<Overlays>();
    int drawn_width_ = 0, drawn_height_ = 0;
    Overlay overlay_ = Overlay::colour;
    OverlayScale scale_;
    std::optional<Shown> shown_;
};

/// What the last picture showed: a picture that would show the same need not be drawn again.
class DrawnState {
public:
    /// Whether the moment is at another frame than the last picture; whatever its blend with the next.
    bool is_other_frame(const WatchedMoment& moment) const;
    /// Whether frames, blend, colour or a finger are others. `count`: fingers that are shown; `small`: by how
    /// much they may move unseen, scene units.
    bool differs(const WatchedMoment& moment, int count, double small) const;
    void remember(const WatchedMoment& moment, int count);

private:
    struct Finger {
        glm::dvec3 goal{0.0}, proxy{0.0}, force{0.0};
    };
    std::uint64_t epoch_ = 0;
    std::int64_t prev_ = -1, next_ = -1;
    double blend_ = 0;
    const void* colour_ = nullptr;
    std::vector<Finger> fingers_;
};

}  // namespace touchable
