// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/draw/finger_marks.hpp"
#include "player/draw/pictures.hpp"
#include "player/run/touch_session.hpp"
#include "player/view/pointer.hpp"
#include "player/view/view.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/sweep.hpp"
#include "tests/temporary_files.hpp"

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

/// Results of a dragged finger, in ticks.
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
    PointerFingers& fingers() { return fingers_; }

    using Take = std::function<void(const TouchTick&)>;
    void go_on(int ticks, const Take& take) {
        for (int k = 0; k < ticks; ++k, ++tick_) {
            const FramePair pair = clip_.pair(tick_ * 1'000'000);
            if (tick_ * 60 / 1000 != (tick_ - 1) * 60 / 1000)
                fingers_.intend(HeightField(clip_.scene, pair), camera(), met_);
            EXPECT_TRUE(port_->read_goals(tick_, HeightField(clip_.scene, pair), step_.goals()));
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
    std::unique_ptr<HapticPort> port_ = make_port(device_, workspace_);
    PointerFingers fingers_;
    glm::dvec3 middle_;
    WindowView view_;
    TouchSolver solver_;
    TouchStep step_;
    std::vector<Contact> met_;
    std::int64_t tick_ = 0;
};

}  // namespace touchable::test

namespace touchable::test {
namespace {

// A finger that is pressed and dragged goes on to what is under the pointer, whatever is in its way; and
// feels what is on its way as before.

constexpr int rows = 20;
constexpr double pixels_per_s = 400;

/// Nowhere caught: seldom at the greatest force, never far from where the pointer means it.
void expect_free(const Dragged& dragged) {
    EXPECT_LE(dragged.limit_share(), 0.05);
    EXPECT_LT(dragged.quantile(0.95), 0.02);
    EXPECT_EQ(dragged.behind, 0) << "it went through the surface";
    EXPECT_EQ(dragged.beyond_camera, 0);
    EXPECT_GT(dragged.touching, dragged.ticks / 8) << "it only went over it";
}

struct DraggedClip {
    const char *name, *file, *scene;  ///< below the test data; of tests/scenes, empty: the clip's own
};

class DraggedOverRecording : public ::testing::TestWithParam<DraggedClip> {};

TEST_P(DraggedOverRecording, IsNotCaught) {
    const auto file = real_data(GetParam().file);
    TOUCHABLE_NEEDS_DATA(file);
    const auto clip = built_recording(file, GetParam().scene);
    expect_free(DraggedFinger(*clip).sweep(rows, pixels_per_s));
}

INSTANTIATE_TEST_SUITE_P(, DraggedOverRecording,
                         ::testing::Values(DraggedClip{"castel_sr300", "castel_sr300", "castel_sr300"},
                                           DraggedClip{"cube", "visp_cube_realsense", "visp_cube_realsense"},
                                           DraggedClip{"redwood5", "stills/redwood5", "redwood5"},
                                           DraggedClip{"icl_nuim5", "stills/icl_nuim5", "icl_nuim5"},
                                           DraggedClip{"depthkit", "depthkit_typing/Test.mov", ""}),
                         [](const auto& run) { return std::string(run.param.name); });

class DraggedOverScene : public ::testing::TestWithParam<const char*> {};

TEST_P(DraggedOverScene, IsNotCaught) {
    const auto clip = built_scene(GetParam(), 720, 480);
    expect_free(DraggedFinger(*clip).sweep(rows, pixels_per_s));
}

/// Walls are not drawn there, and in the way of sight.
TEST_P(DraggedOverScene, IsNotCaughtFromAside) {
    const auto clip = built_scene(GetParam(), 720, 480);
    DraggedFinger finger(*clip);
    finger.view().turn(35, 15);
    expect_free(finger.sweep(rows, pixels_per_s));
}

TEST_P(DraggedOverScene, IsNotCaughtByFlick) {
    const auto clip = built_scene(GetParam(), 720, 480);
    const Dragged dragged = DraggedFinger(*clip).sweep(rows, 5 * pixels_per_s);
    EXPECT_LE(dragged.limit_share(), 0.05);
    EXPECT_EQ(dragged.behind, 0);
}

INSTANTIATE_TEST_SUITE_P(, DraggedOverScene, ::testing::Values("globe", "spheres", "step"),
                         [](const auto& run) { return std::string(run.param); });

class Hovering : public ::testing::TestWithParam<StandIn> {
protected:
    /// A random mouse, view and panel, for 5 s, with presses or without.
    void run(const BuiltClip& clip, std::uint64_t seed, int count, bool presses) {
        constexpr glm::dvec2 size(DraggedFinger::width, DraggedFinger::height);
        DraggedFinger finger(clip);
        finger.fingers().set_count(count);
        Random random(seed);
        const auto happens = [&](double share) { return random.between(0, 1) < share; };
        const auto speed = [&](double most) {
            return happens(0.5) ? glm::dvec2(0)
                                : glm::dvec2(random.within(-most, most), random.within(-most, most));
        };
        glm::dvec2 at = size / 2.0, moves(0), turns(0);
        bool is_held = false;
        for (int picture = 0; picture < 300; ++picture) {
            if (happens(0.1)) moves = speed(60);
            if (happens(0.05)) turns = speed(3);
            at = happens(0.02) ? size / 2.0 + speed(400) : glm::clamp(at + moves, glm::dvec2(0), size);
            if (turns.x != 0) finger.view().turn(turns.x, turns.y);
            if (happens(0.01)) finger.view().turn(random.within(-60, 60), random.within(-30, 30));
            if (happens(0.01)) finger.view().near_by(random.within(0.5, 2));
            if (happens(0.01)) finger.view().go_home();
            if (happens(0.02)) finger.view().leave_free({happens(0.5) ? 0 : 0.35, 0});
            finger.fingers().set_pointer(happens(0.02) ? std::nullopt : std::optional(at));
            if (presses && happens(0.05)) finger.fingers().press(is_held = !is_held);
            finger.go_on(16, [&](const TouchTick& tick) { note(tick, is_held); });
        }
    }

    int ticks_ = 0, felt_ = 0;  // of fingers that hover; with a force
    double most_ = 0;           // N, of them

private:
    /// A finger that was pressed has time to come off.
    void note(const TouchTick& tick, bool is_held) {
        constexpr int longest = 250;  // ticks
        for (std::size_t k = 0; k < tick.contacts.size(); ++k) {
            const double newtons = glm::length(tick.forces[k].force);
            const bool touches = tick.contacts[k].touching || newtons > 0;
            int& left = left_[k];
            left = is_held ? longest : std::max(left - 1, 0);
            if (is_held) continue;
            ++ticks_;
            felt_ += touches && left == 0;
            if (left == 0) most_ = std::max(most_, newtons);
        }
    }
    std::array<int, PointerFingers::most> left_{};  // until a finger that was pressed has to be off
};

TEST_P(Hovering, NeverTouches) {
    const TemporaryFolder folder;
    StandIn what = GetParam();
    what.frames = 60;
    const auto clip = built_recording(write_stand_in(folder.path(), what), "");
    for (std::size_t seed = 0; seed < 28; seed += sweep_step()) {
        clip->scene.interpolation = seed % 2 == 0 ? FrameInterpolation::linear : FrameInterpolation::hold;
        run(*clip, seed, 1 + static_cast<int>(seed % PointerFingers::most), seed % 4 == 3);
    }
    EXPECT_GT(ticks_, 10'000);
    EXPECT_EQ(felt_, 0) << "up to " << most_ << " N";
}

INSTANTIATE_TEST_SUITE_P(, Hovering, ::testing::ValuesIn(stand_ins()),
                         [](const auto& run) { return std::string(run.param.name); });

/// Forces on a finger that the pointer leads by these settings.
std::vector<glm::dvec3> forces_of_stroke(const BuiltClip& clip, const PointerSettings& settings,
                                         bool goes_over, double row, double speed) {
    DraggedFinger finger(clip, settings, goes_over);
    std::vector<glm::dvec3> forces;
    const glm::dvec2 from(480, row), to(800, row);
    const auto keep = [&](const TouchTick& tick) { forces.push_back(tick.forces[0].force); };
    finger.drag(from, to, speed, keep, 2000);
    return forces;
}

/// On land and sea, strokes of 5 to 67 mm/s: friction that sticks, and relief.
TEST(DraggedFinger, FeelsFrictionAndReliefUnchanged) {
    const auto globe = built_scene("globe", 720, 480);
    for (const double speed : {30.0, 120.0, 400.0})
        for (const double row : {250.0, 360.0, 470.0}) {
            const auto felt = forces_of_stroke(*globe, {}, true, row, speed);
            const auto plain = forces_of_stroke(*globe, {.leash = 1}, false, row, speed);
            ASSERT_EQ(felt.size(), plain.size());
            double difference = 0, newtons = 0, change = 0;
            for (std::size_t k = 1; k < felt.size(); ++k) {
                difference += glm::dot(felt[k] - plain[k], felt[k] - plain[k]);
                newtons += glm::dot(plain[k], plain[k]);
                change += glm::length(plain[k] - plain[k - 1]);
            }
            EXPECT_GT(change, 0.1) << "nothing was felt there";
            EXPECT_LT(std::sqrt(difference / newtons), 0.01) << speed << " pixels/s, row " << row;
        }
}

/// A ledge that is no step is felt before it is gone over.
TEST(DraggedFinger, FeelsLedge) {
    const auto ledges = built_scene("step", 720, 480);
    DraggedFinger finger(*ledges);
    double most = 0;
    finger.drag({200, 360}, {1000, 360}, 100,
                [&](const TouchTick& tick) { most = std::max(most, glm::length(tick.forces[0].force)); });
    EXPECT_GT(most, 4);
    EXPECT_LT(most, 0.9 * DraggedFinger::max_newtons);
}

// A surface that gives way in the picture is felt, and pointed at, as one that does not.

/// All that came of a drag.
struct Felt {
    std::string forces;  // their hash
    std::vector<glm::dvec3> goals, picks;
    std::vector<std::uint8_t> last_picture;
};

/// Over the globe, with friction, while it is drawn 60 times a second.
Felt felt_where(bool is_dented) {
    const auto clip = built_scene("globe", 180, 120);
    DraggedFinger finger(*clip);
    CpuDrawing drawing;
    Felt felt;
    ForceHash forces;
    const Viewpoint::Subject subject = subject_of(HeightField(clip->scene, clip->pair(0)));
    const MarkSizes sizes = mark_sizes(clip->scene, subject.middle);
    const ViewCamera camera = finger.camera();
    finger.drag({560, 330}, {760, 390}, 600, [&](const TouchTick& tick) {
        for (const GuardedForce& force : tick.forces) forces.add(force.force);
        felt.goals.insert(felt.goals.end(), tick.goals.begin(), tick.goals.end());
        if (tick.tick % 100 != 0) return;
        const HeightField field(clip->scene, tick.pair);
        FingerMark mark{tick.contacts[0].goal, tick.contacts[0].proxy, tick.forces[0].force,
                        tick.contacts[0].touching};
        mark.under = under_finger(field, mark.proxy, sizes.finger_radius);
        if (is_dented)
            mark.given_way =
                given_way(mark.force, tick.contacts[0].properties.stiffness, tick.metres_per_scene_unit);
        drawing.show(field, tick.pair, {}, Lighting::full);
        const auto picture = drawing.draw(camera, std::span(&mark, 1), sizes);
        ASSERT_TRUE(picture);
        felt.last_picture = (*picture)->samples;
        if (const auto at = camera.project(mark.proxy))
            if (const auto met = pick(field, camera, at->x, at->y)) felt.picks.push_back(met->point);
    });
    felt.forces = forces.hex();
    return felt;
}

TEST(Dents, KeepForcesAndPicks) {
    const Felt flat = felt_where(false), dented = felt_where(true);
    EXPECT_EQ(dented.forces, flat.forces);
    EXPECT_EQ(dented.goals, flat.goals);
    EXPECT_EQ(dented.picks, flat.picks);
    EXPECT_GE(flat.picks.size(), 3U);
    EXPECT_NE(dented.last_picture, flat.last_picture) << "there was no dent";
}

}  // namespace
}  // namespace touchable::test
