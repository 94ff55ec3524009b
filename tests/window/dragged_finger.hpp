#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <functional>
#include <glm/geometric.hpp>
#include <memory>
#include <string>
#include <vector>

#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/draw/view.hpp"
#include "player/run/touch_session.hpp"
#include "player/window/pointer.hpp"
#include "tests/real_data.hpp"

namespace touchable::test {

/// A clip whose first frames are all built. After the last its surface stands still.
struct BuiltClip {
    Scene scene;
    std::deque<SurfaceFrame> frames;

    void build(const std::vector<RawFrame>& raw) {
        const auto builder = make_cpu_builder(scene);
        for (const RawFrame& frame : raw) {
            frames.emplace_back();
            ASSERT_TRUE(builder->build(frame, frames.back()));
        }
    }
    FramePair pair(std::int64_t time_ns) const {
        FramePair pair;
        const auto at = [&](std::int64_t n) {
            return TimedFrame{n, scene.rate.time_ns(n), &frames[static_cast<std::size_t>(n)]};
        };
        const auto last = static_cast<std::int64_t>(frames.size()) - 1;
        std::int64_t n = 0;
        while (n < last && scene.rate.time_ns(n + 1) <= time_ns) ++n;
        pair.prev = at(n);
        pair.next = at(std::min(n + 1, last));
        if (n < last)
            pair.blend = static_cast<double>(time_ns - pair.prev.time_ns) /
                         static_cast<double>(pair.next.time_ns - pair.prev.time_ns);
        return pair;
    }
};

inline std::unique_ptr<BuiltClip> built_scene(const char* name, int width, int height) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    options.properties = std::string(name) == "globe";
    auto made = make_scene(name, options);
    EXPECT_TRUE(made) << made.error().message;
    auto clip = std::make_unique<BuiltClip>();
    clip->scene = (*made)->scene();
    clip->build({(*made)->frame(0)});
    return clip;
}

/// `scene`: the name of a file of tests/scenes; empty: the clip says itself.
inline std::unique_ptr<BuiltClip> built_recording(const std::filesystem::path& file,
                                                  const std::string& scene) {
    const auto scene_file = std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes" / (scene + ".json");
    auto reader = scene.empty() ? open_clip(file) : open_clip(file, scene_file);
    EXPECT_TRUE(reader) << reader.error().message;
    auto clip = std::make_unique<BuiltClip>();
    clip->scene = (*reader)->scene();
    std::vector<RawFrame> raw;
    for (auto frame = (*reader)->next(); frame && *frame && raw.size() < 30; frame = (*reader)->next())
        raw.push_back(**frame);
    clip->build(raw);
    return clip;
}

/// What came of a finger that was dragged, in ticks.
struct Dragged {
    int ticks = 0, touching = 0, at_limit = 0, behind = 0;
    int beyond_camera = 0;       ///< it went through the clip's camera
    std::vector<double> astray;  ///< where it touches from what is under the pointer, across sight, device m

    double limit_share() const { return touching > 0 ? static_cast<double>(at_limit) / touching : 0; }
    double quantile(double share) const {
        std::vector<double> sorted = astray;
        if (sorted.empty()) return 0;
        std::sort(sorted.begin(), sorted.end());
        return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
    }
};

/// The pointer over a window, and its fingers in a time of their own: pictures at 60/s, ticks at 1 kHz.
class DraggedFinger {
public:
    static constexpr int width = 1280, height = 720;
    static constexpr double max_newtons = 10;

    /// `goes_over`: it is known what fingers met, so that they go over what is in their way.
    explicit DraggedFinger(const BuiltClip& clip, const PointerSettings& settings = {}, bool goes_over = true)
        : clip_(clip),
          goes_over_(goes_over),
          workspace_(clip_workspace(clip.scene, clip.frames.front())),
          device_(PointerFingers::most, workspace_.to_device({0, 0, 0}), settings),
          fingers_(device_, workspace_),
          middle_(subject_of(HeightField(clip.scene, clip.pair(0))).middle),
          view_(clip.scene, middle_),
          solver_(
              *TouchSolver::create(clip.scene, {.metres_per_scene_unit = workspace_.metres_per_scene_unit})),
          step_(solver_, GuardSettings{}, PointerFingers::most) {
        EXPECT_TRUE(device_.open());
    }

    ViewCamera camera() const { return view_.camera(width, height); }
    WindowView& view() { return view_; }

    using Take = std::function<void(const TouchTick&)>;
    void go_on(int ticks, const Take& take) {
        for (int k = 0; k < ticks; ++k, ++tick_) {
            const FramePair pair = clip_.pair(tick_ * 1'000'000);
            if (tick_ * 60 / 1000 != (tick_ - 1) * 60 / 1000)
                fingers_.intend(HeightField(clip_.scene, pair), camera(), met_);
            EXPECT_TRUE(device_.read_positions(step_.goals()));
            for (glm::dvec3& goal : step_.goals()) goal = workspace_.to_scene(goal);
            const TouchTick done = step_.run(tick_, tick_ * 1'000'000, clip_.scene, pair);
            if (goes_over_) met_.assign(done.contacts.begin(), done.contacts.end());
            take(done);
        }
    }

    void go_on(int ticks) {
        go_on(ticks, [](const TouchTick&) {});
    }

    /// From one place of the window to another with the button held, pixels a second, after it was pressed
    /// for so many ticks. Of each tick on the way `take` is to know.
    Dragged drag(const glm::dvec2& from, const glm::dvec2& to, double speed, const Take& take = {},
                 int pressed = 400) {
        Dragged dragged;
        fingers_.set_pointer(from);
        go_on(400);
        fingers_.press(true);
        go_on(pressed);
        const double length = glm::length(to - from);
        const int ticks = static_cast<int>(1000 * length / speed);
        for (int k = 0; k < ticks; ++k) {
            const glm::dvec2 at = from + (to - from) * (k / static_cast<double>(ticks));
            fingers_.set_pointer(at);
            go_on(1, [&](const TouchTick& tick) {
                note(tick, at, dragged);
                if (take) take(tick);
            });
        }
        fingers_.press(false);
        go_on(300);
        return dragged;
    }

    /// `rows` sweeps over what the clip's own view shows, from left to right.
    Dragged sweep(int rows, double speed) {
        Dragged all;
        const Scene& scene = clip_.scene;
        const ViewCamera own = WindowView(scene, middle_).camera(width, height);
        const auto seen = [&](double x, double y) {
            return glm::dvec2(*own.project(unproject(scene.camera, x, y, -middle_.z)));
        };
        const glm::dvec2 first = glm::max(seen(0, 0), glm::dvec2(0)),
                         last = glm::min(seen(scene.width - 1, scene.height - 1), glm::dvec2(width, height));
        for (int row = 0; row < rows; ++row) {
            const double y = first.y + (last.y - first.y) * (row + 0.5) / rows;
            const Dragged one = drag({first.x, y}, {last.x, y}, speed);
            all.ticks += one.ticks;
            all.touching += one.touching;
            all.at_limit += one.at_limit;
            all.behind += one.behind;
            all.beyond_camera += one.beyond_camera;
            all.astray.insert(all.astray.end(), one.astray.begin(), one.astray.end());
        }
        return all;
    }

private:
    void note(const TouchTick& tick, const glm::dvec2& at, Dragged& dragged) {
        ++dragged.ticks;
        dragged.behind += tick.behind;
        dragged.beyond_camera += tick.goals[0].z > 1e-6;
        const Contact& contact = tick.contacts[0];
        if (!contact.touching) return;
        ++dragged.touching;
        dragged.at_limit += glm::length(tick.forces[0].force) >= 0.99 * max_newtons;
        if (tick.tick % 16 != 0) return;
        const auto met = pick(HeightField(clip_.scene, tick.pair), camera(), at.x, at.y);
        if (!met || !met->drawn) return;
        const glm::dvec3 off = contact.proxy - met->point;
        const glm::dvec3 across = off - met->direction * glm::dot(off, met->direction);
        dragged.astray.push_back(glm::length(across) * workspace_.metres_per_scene_unit);
    }

    const BuiltClip& clip_;
    bool goes_over_;
    Workspace workspace_;
    PointerDevice device_;
    PointerFingers fingers_;
    glm::dvec3 middle_;
    WindowView view_;
    TouchSolver solver_;
    TouchStep step_;
    std::vector<Contact> met_;
    std::int64_t tick_ = 0;
};

}  // namespace touchable::test
