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
#include "player/session/touch_setup.hpp"
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

/// A picture of a frame's segments: each in the colour of its material over the brightness that the clip has
/// there, with dark lines between them. Holes are dark.
class SegmentTint {
public:
    /// RGB, of the depth plane's size; stays as it is until the next call. `colour`: the clip's, of any size,
    /// or empty. Of a frame beyond the segments' last: that one's. What was painted last is not painted again
    /// for the same segments, frame and place of colour in memory.
    PlaneView paint(const std::shared_ptr<const PaintedSegments>& painted, std::int64_t frame,
                    const PlaneView& colour);

private:
    void paint_anew(const PlaneView& colour);

    std::shared_ptr<const PaintedSegments> painted_;  // what `rgb_` is of
    std::int64_t frame_ = -1;
    const void* colour_ = nullptr;
    std::vector<std::uint16_t> labels_;
    std::vector<std::uint8_t> rgb_;
};

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
    const Overlays::Scale* scale() const { return overlay_ == Overlay::colour ? nullptr : &scale_; }
    /// Another clip: nothing of the last one serves.
    void forget() {
        shown_.reset();
        overlays_ = std::make_unique<Overlays>();
    }

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
    Overlays::Scale scale_;
    std::optional<Shown> shown_;
};

/// What the last picture showed: a picture that would show the same need not be drawn again.
class DrawnState {
public:
    /// Whether the moment is at another frame than the last picture; whatever its blend with the next.
    bool is_other_frame(const WatchedMoment& moment) const {
        const FramePair& pair = moment.held.pair;
        return pair.epoch != epoch_ || pair.prev.number != prev_;
    }
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

/// Of what pictures have less where they come late. Where the CPU draws (SurfaceDrawing::thins_vertices) the
/// surface's vertices cost the most, and stretching a picture would cost what a smaller one saves.
enum class LessOf { vertices, pixels };

/// In how much detail the surface is drawn, so that pictures come in time: with all of its vertices or no
/// more than the window's pixels tell apart (`coarse`); then with still fewer vertices, or smaller and
/// stretched. It begins coarse, goes down at once and up slowly; what saves too little is taken back, once it
/// has been judged (`judge`).
class PictureGovernor {
public:
    explicit PictureGovernor(LessOf less = LessOf::pixels)
        : levels_(less == LessOf::pixels ? std::span<const Level>(by_pixels) : by_vertices) {}

    /// Of the shown width and height.
    double share() const { return levels_[level_].share; }
    bool coarse() const { return levels_[level_].coarse; }
    /// From vertex to vertex, times what `coarse` asks for.
    int step() const { return levels_[level_].step; }
    /// Share of the width in pixels, or in vertices that differ by a pixel: 0 to 1.
    double detail() const { return share() / step(); }

    /// After a picture at `now_s`: of the frames that have been due since the picture before, how many were
    /// shown in time; and what part of a frame's time the drawing took. `coarse_saves`: there are more
    /// vertices than the window tells apart.
    void add(double now_s, std::int64_t due, std::int64_t in_time, double drawing, bool coarse_saves);

private:
    struct Level {
        double share;
        bool coarse;
        int step;
        double dearer;  ///< times the drawing of the next one
    };
    static constexpr std::array<Level, 4> by_pixels{
        {{1, false, 1, 3}, {1, true, 1, 1.78}, {0.75, true, 1, 2.25}, {0.5, true, 1, 1}}};
    static constexpr std::array<Level, 3> by_vertices{{{1, false, 1, 3}, {1, true, 1, 1.5}, {1, true, 2, 1}}};
    static constexpr std::int64_t few = 15;   // frames that are judged together
    static constexpr double tolerated = 0.9;  // of them in time
    static constexpr double cause = 0.5;      // of a frame's time: what takes less makes nothing late
    static constexpr double room = 0.8;       // of a frame's time, for a larger picture
    static constexpr double worth = 0.9;      // of the time before, for a smaller one
    static constexpr int judgements = 3;      // that late pictures save too little, before less is taken back
    static constexpr double least_s = 3, most_s = 60;  // until it is tried

    void go_to(std::size_t level, double now_s);
    void judge(double drawing_each, bool is_late, double now_s);

    std::span<const Level> levels_;
    std::size_t level_ = 1;
    std::int64_t due_ = 0, in_time_ = 0, pictures_ = 0;
    double drawing_ = 0;  // sum over those pictures
    double changed_s_ = 0, wait_s_ = least_s;
    double before_ = 0;  // drawing_ of a picture before it went down from there, until that was judged
    std::size_t from_ = 0;
    int judged_ = 0;           // since it came from there
    double not_before_s_ = 0;  // it goes down
    bool rose_ = false;        // at the last change
};

/// How many of a clip's frames were seen while they were the clip's.
class FramesShown {
public:
    /// A picture of `pair` is on the screen at `now_ns` of the clip's clock, whose frames are `period_ns`
    /// apart. Frames of the same epoch since the last picture's were not seen. The first of an epoch does not
    /// count: it is waited for.
    void add(const FramePair& pair, std::int64_t now_ns, std::int64_t period_ns);

    /// Another session comes, whose epochs say nothing of those before.
    void forget() { number_ = -1; }

    std::int64_t due() const { return due_; }
    /// Those that were on the screen before the next one was due there.
    std::int64_t in_time() const { return in_time_; }

private:
    std::int64_t due_ = 0, in_time_ = 0;
    std::uint64_t epoch_ = 0;
    std::int64_t number_ = -1;
};

/// How long a picture takes in which the clip's frame is the one before, and only fingers or words have
/// changed: the window draws one between two frames where so much time is left. It is the median of the last
/// few, as one of them may have waited for decoding; with every frame that passes without one it becomes a
/// little less, so that a few slow ones are not the last; and one that takes less than half makes those
/// before it count no more, as when a clip plays on after a rest, in which more is drawn.
class RedrawEstimator {
public:
    /// Such a picture took so many ms.
    void add(double ms) {
        if (ms < ms_ / 2) next_ = 0;
        newest_[next_++ % newest_.size()] = ms;
        auto sorted = newest_;
        const std::size_t count = std::min(next_, sorted.size());
        std::sort(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(count));
        ms_ = sorted[(count - 1) / 2];
    }
    /// A picture of another frame was drawn.
    void add_frame() { ms_ *= 0.99; }

    /// 0: there was none yet.
    double ms() const { return ms_; }

private:
    std::array<double, 8> newest_{};
    std::size_t next_ = 0;
    double ms_ = 0;
};

/// Whether frames of a clip come late because reading them takes so long.
class SlowReading {
public:
    /// How the clip is doing; asked for again and again. `period_ms`: from one of its frames to the next.
    void add(const WatchedFigures& figures, double period_ms);

    /// From when on 16 frames and a quarter of all were late or left out, while reading one took longer on
    /// average than building one, and half of its time or more.
    bool is_why() const { return is_why_; }
    /// Of a frame, on average.
    double read_ms() const { return looks_ > 0 ? read_ms_ / static_cast<double>(looks_) : 0; }

private:
    std::int64_t frames_ = 0, looks_ = 0;
    double read_ms_ = 0, build_ms_ = 0;  // sums
    bool is_why_ = false;
};

}  // namespace touchable
