// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string_view>

#include "engine/authoring/materials.hpp"
#include "engine/base/result.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/overlays.hpp"
#include "player/draw/pictures.hpp"
#include "player/session/watched_session.hpp"
#include "player/window/screen.hpp"

namespace touchable {

/// The frames that a picture shows.
struct ShownFrames {
    std::uint64_t epoch = 0;
    std::int64_t prev = -1, next = -1;
    double blend = 0;
    const void* colour = nullptr;
    bool operator==(const ShownFrames&) const = default;
};

/// Makes the window's pictures, one after another, and shows them. For each: `begin`, `show` if the surface
/// has changed, `draw`, ImGui calls, `finish`. Defaults are those of a drawing in the CPU's memory. Main
/// thread only.
class WindowGraphics {
public:
    virtual ~WindowGraphics() = default;
    virtual std::string_view painter() const = 0;   ///< cpu, raster or mesh
    virtual std::string gpu() const { return {}; }  ///< the drawing GPU; empty: none
    /// Whether that GPU or its surface is lost: these graphics can draw no more.
    virtual bool is_lost() const { return false; }
    virtual bool can_stretch() const { return false; }
    /// Whether a GPU draws, for which four samples a pixel are few.
    virtual bool is_quick() const { return false; }

    /// Reloads the font; call after ImGuiLayer::set_scale.
    virtual Result<void> take_letters() { return {}; }
    virtual Result<void> begin() { return {}; }
    /// As SurfaceDrawing::show.
    virtual Result<void> show(const HeightField& field, const FramePair& pair, const PlaneView& colour,
                              Lighting lighting, int step) = 0;
    /// As SurfaceDrawing::draw, stretched over a picture of width x height. A camera two or four times as
    /// large gives each pixel the mean of its samples; that needs no `can_stretch`.
    virtual Result<void> draw(const ViewCamera& camera, std::span<const FingerMark> fingers,
                              const MarkSizes& sizes, int width, int height) = 0;
    /// Keeps what was drawn, for `draw_again`.
    virtual void keep_drawn() {}
    /// Draws what was last kept, if nothing was drawn since; false: that is not there.
    virtual bool draw_again() { return false; }
    /// Draws ImGui's draw data on top, and shows the picture. Its inputs are not read afterwards.
    virtual Result<void> finish() { return {}; }
    /// The last finished picture, RGB; ErrorKind::usage before the first.
    virtual Result<Image> picture() const = 0;
};

/// Draws on a GPU to which `screen` is attached. `painter` as in SurfaceDrawing. An ImGuiLayer must exist and
/// outlive it.
Result<std::unique_ptr<WindowGraphics>> make_gpu_graphics(std::shared_ptr<GpuDevice> device,
                                                          std::string_view painter, Screen& screen);

/// Draws in the CPU's memory, without Vulkan, and without ImGui's panel, which needs a GPU.
std::unique_ptr<WindowGraphics> make_cpu_graphics();

/// A picture of a frame's segments: each in its material's colour, with the clip's brightness, separated by
/// dark lines. Holes are dark.
class SegmentTint {
public:
    /// RGB, of the depth plane's size; valid until the next call. `colour`: the clip's, of any size, or
    /// empty. Frames beyond the segments' last use that one. The last result is reused for the same segments,
    /// frame and address of the colour.
    PlaneView paint(const std::shared_ptr<const PaintedSegments>& painted, std::int64_t frame,
                    const PlaneView& colour);

private:
    void paint_anew(const PlaneView& colour);

    std::shared_ptr<const PaintedSegments> painted_;  // painted in `rgb_`
    std::int64_t frame_ = -1;
    const void* colour_ = nullptr;
    std::vector<std::uint16_t> labels_;
    std::vector<std::uint8_t> rgb_;
};

/// The picture at the haptic moment: surface and fingers.
class ClipPicture {
public:
    /// Call between `begin` and `finish` of the graphics. Draws at the camera's size, stretched over a canvas
    /// of width x height, with every `step`th vertex, as in SurfaceDrawing::show. Remakes the surface only if
    /// frames, blend or overlay have changed; the moment must stay unchanged until the picture is finished.
    Result<void> draw(const WatchedMoment& moment, const HeightField& field, const ViewCamera& camera,
                      std::span<const FingerMark> fingers, const MarkSizes& sizes, int width, int height,
                      int step = 1);
    /// Sets the graphics; null: none until others are set. The previous ones are destroyed first.
    void use(std::unique_ptr<WindowGraphics> graphics) {
        graphics_ = std::move(graphics);
        shown_.reset();
    }
    WindowGraphics& graphics() { return *graphics_; }
    const WindowGraphics& graphics() const { return *graphics_; }
    /// Size of the last camera.
    int drawn_width() const { return drawn_width_; }
    int drawn_height() const { return drawn_height_; }
    int drawn_step() const { return shown_ ? shown_->step : 1; }  ///< from vertex to vertex
    Overlay overlay() const { return overlay_; }
    void set_overlay(Overlay overlay);
    Lighting light() const { return light_; }
    /// Of the clip's own colours.
    void set_light(Lighting light);
    /// Paints segments instead of the clip's colours; null: the clip's.
    void set_tint(std::shared_ptr<const PaintedSegments> painted) { tinted_ = std::move(painted); }
    /// The scale of the overlay's colours; null for the clip's own.
    const Overlays::Scale* scale() const { return overlay_ == Overlay::colour ? nullptr : &scale_; }
    /// Drops everything of the last clip.
    void forget() {
        shown_.reset();
        overlays_ = std::make_unique<Overlays>();
    }

private:
    Result<void> show(const WatchedMoment& moment, const HeightField& field, int step);

    struct Shown {
        ShownFrames frames;
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
    Lighting light_ = Lighting::off;
    Overlays::Scale scale_;
    std::optional<Shown> shown_;
};

/// The state shown by the last picture, to skip identical ones.
class DrawnState {
public:
    /// Whether the moment's frame differs from the last picture's, ignoring the blend.
    bool is_other_frame(const WatchedMoment& moment) const {
        const FramePair& pair = moment.held.pair;
        return pair.epoch != frames_.epoch || pair.prev.number != frames_.prev;
    }
    /// Whether frames, blend, colour or a finger have changed. `count`: shown fingers; `small`: movement that
    /// is not visible, scene units.
    bool differs(const WatchedMoment& moment, int count, double small) const;
    void remember(const WatchedMoment& moment, int count);

private:
    ShownFrames frames_;
    std::vector<WatchedTick::Finger> fingers_;
};

/// Chooses the surface's level of detail so that pictures come in time: all vertices, or no more than the
/// window's pixels resolve (`coarse`); then a smaller, stretched picture. It begins coarse, goes down at
/// once, to where drawing should take less than a frame's duration, and up slowly; a reduction with which
/// pictures still come late, and which saves too little, is reverted, once it has been judged (`judge`).
class PictureGovernor {
public:
    /// Share of the shown width and height.
    double share() const { return levels[level_].share; }
    /// The decimation of vertices over what the window's pixels resolve; 0: there is none.
    int coarse() const { return levels[level_].coarse; }

    /// Call after a picture at `now_s`, with the frames due since the previous picture, those shown in time,
    /// and drawing's share of a frame's duration. `coarse_saves`: there are more vertices than the window
    /// resolves.
    void add(double now_s, std::int64_t due, std::int64_t in_time, double drawing, bool coarse_saves);

private:
    struct Level {
        double share;
        int coarse;
        double dearer;  ///< drawing time relative to the next one, between the CPU's and a GPU's
    };
    static constexpr Level levels[] = {{1, 0, 3},     {1, 1, 1.5},    {0.75, 1, 2},
                                       {0.5, 1, 1.5}, {0.25, 1, 1.1}, {0.25, 2, 1}};
    static constexpr std::int64_t few = 15;   // frames judged together
    static constexpr double tolerated = 0.9;  // share of them in time
    static constexpr double cause = 0.5;      // of a frame's duration: faster drawing delays nothing
    static constexpr double room = 0.8;       // of a frame's duration, for a larger picture
    static constexpr double worth = 0.9;      // of the previous time, for a smaller one
    static constexpr int judgements = 3;      // late judgements of too little saving before a reversal
    static constexpr double least_s = 3, most_s = 60;  // waits before a rise

    void go_to(std::size_t level, double now_s);
    void judge(double drawing_each, bool is_late, double now_s);

    std::size_t level_ = 1;
    std::int64_t due_ = 0, in_time_ = 0, pictures_ = 0;
    double drawing_ = 0;  // sum over those pictures
    double changed_s_ = 0, wait_s_ = least_s;
    double before_ = 0;  // drawing_ per picture before going down, until judged; 0: not judging
    std::size_t from_ = 0;
    int judged_ = 0;           // judgements since then
    double not_before_s_ = 0;  // next time it may go down
    bool rose_ = false;        // at the last change
};

/// Counts the clip's frames that were shown in time.
class FramesShown {
public:
    /// Call when a picture of `pair` is on the screen at `now_ns` of the clip's clock; frames are `period_ns`
    /// apart. Frames of the same epoch skipped since the last picture count as missed. An epoch's first frame
    /// does not count, as it is waited for.
    void add(const FramePair& pair, std::int64_t now_ns, std::int64_t period_ns);

    /// A new session begins, with unrelated epochs.
    void forget() { number_ = -1; }

    std::int64_t due() const { return due_; }
    /// Frames shown before the next one was due.
    std::int64_t in_time() const { return in_time_; }

private:
    std::int64_t due_ = 0, in_time_ = 0;
    std::uint64_t epoch_ = 0;
    std::int64_t number_ = -1;
};

/// Estimates the time of a redraw, a picture of the same frame with changed fingers or texts: the window
/// draws one between two frames if there is time. The estimate is the median of the last few, as one may have
/// waited for decoding; it decreases a little with every frame without a redraw, so that slow ones are not
/// final; a value below half of it discards the previous ones, as when a clip plays on after a pause, in
/// which more is drawn.
class RedrawEstimator {
public:
    /// Adds a redraw's time.
    void add(double ms) {
        if (ms < ms_ / 2) next_ = 0;
        newest_[next_++ % newest_.size()] = ms;
        auto sorted = newest_;
        const std::size_t count = std::min(next_, sorted.size());
        std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
        ms_ = sorted[(count - 1) / 2];
    }
    /// A picture of a new frame was drawn.
    void add_frame() { ms_ *= 0.99; }

    /// 0: no redraw yet.
    double ms() const { return ms_; }

private:
    std::array<double, 8> newest_{};
    std::size_t next_ = 0;
    double ms_ = 0;
};

/// Detects that frames of a clip come late because reading is slow.
class SlowReading {
public:
    /// Adds the clip's figures; call repeatedly. `period_ms`: a frame's duration.
    void add(const WatchedFigures& figures, double period_ms);

    /// True once 16 frames and a quarter of all were late or dropped, while reading a frame took longer on
    /// average than building it, and at least half of its duration.
    bool is_why() const { return is_why_; }
    /// Average per frame.
    double read_ms() const { return looks_ > 0 ? read_ms_ / static_cast<double>(looks_) : 0; }

private:
    std::int64_t frames_ = 0, looks_ = 0;
    double read_ms_ = 0, build_ms_ = 0;  // sums
    bool is_why_ = false;
};

}  // namespace touchable
