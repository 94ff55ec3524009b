// SPDX-License-Identifier: Apache-2.0
// The brush of the window: what it does for a clip, and what becomes of that when the clip goes.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include "engine/authoring/materials.hpp"
#include "engine/authoring/segments.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/clip_picture.hpp"
#include "player/window/window_brush.hpp"
#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

class WindowBrushTest : public OpenedClipTest {
protected:
    void SetUp() override {
        options_.brush_history = folder_ / "state";
        first_ = open("first.mkv", 30);
        second_ = open("second.mkv", 4);
        ASSERT_TRUE(first_ && second_);
        brush_.go_to(*first_);
    }
    std::unique_ptr<OpenedClip> open(const char* name, int frames) {
        ClipChoice choice;
        choice.file = folder_ / name;
        write_two_surfaces(choice.file, frames);
        auto clip = opened(choice);
        return clip && clip->begin() ? std::move(clip) : nullptr;
    }
    void ask(const std::string& words) {
        auto command = parse_window_command(words);
        ASSERT_TRUE(command) << command.error().message;
        brush_.take(*command);
    }
    std::string said() {
        std::string words;
        const auto news = brush_.take_news();
        for (const auto& remark : news.remarks) words += remark.words + '\n';
        has_begun_ = has_begun_ || news.has_begun;
        return words;
    }
    /// Turns of a window; all that the brush says, a line each.
    std::string until_done() {
        std::string all;
        EXPECT_TRUE(comes_true([&] {
            brush_.go_on({});
            all += said();
            return !brush_.is_at_work();
        })) << brush_.words();
        return all;
    }
    std::string material_at(int x) const {
        const auto felt = brush_.felt();
        return felt ? felt->by_label.at(felt->segments->label_at(0, x, 32)).material : "as the clip says";
    }

    std::unique_ptr<OpenedClip> first_, second_;
    WindowBrush brush_{options_};
    bool has_begun_ = false;
};

TEST_F(WindowBrushTest, RunsCommandsInOrder) {
    EXPECT_FALSE(brush_.is_at_work());
    ASSERT_NO_FATAL_FAILURE(ask("material foam"));
    EXPECT_TRUE(brush_.is_at_work());
    EXPECT_FALSE(brush_.is_changing()) << "it reads";
    until_done();
    EXPECT_TRUE(has_begun_);
    for (const char* words : {"paint 20,32", "material glass", "paint 70,32,29", "paint 20,32,30", "undo"})
        ASSERT_NO_FATAL_FAILURE(ask(words));
    EXPECT_TRUE(brush_.is_changing());
    const std::string all = until_done();
    EXPECT_FALSE(brush_.is_changing());
    EXPECT_TRUE(contains(all, "is foam"));
    EXPECT_TRUE(contains(all, "beyond the clip"));
    EXPECT_TRUE(contains(all, "undone"));
    EXPECT_EQ(material_at(20), "foam");
    EXPECT_TRUE(brush_.facts().can_redo);
    ASSERT_NO_FATAL_FAILURE(ask("tool touch"));
    EXPECT_EQ(material_at(20), "foam") << "a person painted it";
}

TEST_F(WindowBrushTest, RestoresChangesOfEarlierClip) {
    ASSERT_NO_FATAL_FAILURE(ask("material foam"));
    until_done();
    ASSERT_NO_FATAL_FAILURE(ask("paint 20,32"));
    until_done();
    ASSERT_NO_FATAL_FAILURE(ask("cut 46,20 95,20"));
    brush_.go_on({});
    EXPECT_TRUE(brush_.is_changing());
    brush_.go_to(*second_);  // without waiting for it
    EXPECT_FALSE(brush_.is_at_work());
    EXPECT_FALSE(brush_.is_held());
    EXPECT_EQ(brush_.felt(), nullptr);
    EXPECT_FALSE(brush_.facts().is_there);
    ASSERT_NO_FATAL_FAILURE(ask("tool paint"));
    EXPECT_FALSE(contains(until_done(), "of last time")) << "that is another clip's";
    brush_.go_to(*first_);
    ASSERT_NO_FATAL_FAILURE(ask("tool paint"));
    const std::string all = until_done();
    EXPECT_TRUE(contains(all, "1 change of last time is here again"));
    EXPECT_EQ(material_at(20), "foam");
}

TEST_F(WindowBrushTest, NamesSavedAndUnsavedClips) {
    options_.names.saved = [](const std::string& clip, const std::string& file) {
        return "SAVED " + clip + " " + file;
    };
    ASSERT_NO_FATAL_FAILURE(ask("material foam"));
    ASSERT_NO_FATAL_FAILURE(ask("save-materials"));
    std::string all = until_done();
    brush_.go_to(*second_);
    comes_true([&] {
        brush_.go_on({});
        all += said();
        return bool(contains(all, "SAVED"));
    });
    EXPECT_TRUE(brush_.finish());
    all += said();
    const std::string first = (folder_ / "first.mkv").string();
    EXPECT_TRUE(contains(all, "SAVED " + first + " " + first + ".materials.json"));
    // Its segments were not read yet.
    ASSERT_NO_FATAL_FAILURE(ask("save-materials"));
    brush_.go_on({});
    const auto unsaved = brush_.finish();
    ASSERT_FALSE(unsaved);
    EXPECT_TRUE(contains(unsaved.error().message, "not saved"));
}

/// A click at a clip that ended before it was shown keeps no script waiting.
TEST_F(WindowBrushTest, IsIdleForEndedClip) {
    auto third = open("third.mkv", 4);
    ASSERT_TRUE(third && third->finish());
    brush_.go_to(*third);
    ASSERT_NO_FATAL_FAILURE(ask("material foam"));
    until_done();
    InputEvent click{.kind = InputEvent::Kind::pressed};
    click.word = "left";
    EXPECT_TRUE(brush_.take(click, {10, 10}, false, {.width = 96, .height = 64}));
    until_done();
    brush_.go_to(*first_);
}

// A clip in the window whose segments are painted: felt without the clip being opened again.

class PaintedClip : public OpenedClipTest {
protected:
    void SetUp() override {
        choice_.file = folder_ / "wall.mkv";
        ASSERT_NO_FATAL_FAILURE(write_two_surfaces(choice_.file, 30));
        auto segments = read_chosen_segments(choice_, [this](std::int64_t) { ++frames_read_; });
        ASSERT_TRUE(segments) << segments.error().message;
        auto brush = MaterialBrush::begin(std::move(*segments));
        ASSERT_TRUE(brush) << brush.error().message;
        brush_.emplace(std::move(*brush));
    }
    void open() {
        ASSERT_NO_FATAL_FAILURE(begin());
        ASSERT_TRUE(clip_->session().ask(PlaybackVerb::pause));
        std::filesystem::remove(choice_.file);  // it is not opened again
    }
    void edit(const MaterialBrush::Edit& edit) {
        const auto done = brush_->edit(edit);
        ASSERT_TRUE(done) << done.error().message;
    }
    void change(const SessionSettings& settings = {}) {
        const auto changed = change_to(settings, brush_->painted());
        ASSERT_TRUE(changed) << changed.error().message;
    }
    /// Newtons for a metre of the hand, of a finger that presses.
    double felt_stiffness() {
        const WatchedTick::Finger finger = felt();
        const double depth = glm::distance(finger.contact.goal, finger.contact.proxy) *
                             clip_->session().setup().options.touch.metres_per_scene_unit;
        return depth > 0.0005 ? glm::length(finger.force.force) / depth : 0;
    }
    bool feels_like(double newtons_a_mm) {
        return comes_true([&] { return std::abs(felt_stiffness() / 1000 / newtons_a_mm - 1) < 0.05; });
    }
    static double stiffness_of(const char* material) { return find_material(material)->stiffness; }

    std::optional<MaterialBrush> brush_;
    int frames_read_ = 0;
};

constexpr PixelOfFrame on_the_left{20, 32, 0}, on_the_right{70, 32, 0};

TEST_F(PaintedClip, ReadsSegmentsPerFrame) {
    EXPECT_EQ(frames_read_, 30);
    const SegmentStore& segments = *brush_->painted()->segments;
    EXPECT_EQ(segments.frames(), 30);
    EXPECT_NE(segments.label_at(29, 20, 32), segments.label_at(29, 70, 32));
    std::stop_source given_up;
    const auto stopped = work_until(given_up.get_token(), [&] {
        return read_chosen_segments(choice_, [&](std::int64_t) { given_up.request_stop(); });
    });
    ASSERT_FALSE(stopped);
    EXPECT_EQ(stopped.error().kind, ErrorKind::interrupted);
    ClipChoice camera;
    camera.as_camera.emplace();
    EXPECT_EQ(read_chosen_segments(camera, {}).error().kind, ErrorKind::usage);
}

TEST_F(PaintedClip, FeelsPaintAndUndo) {
    ASSERT_NO_FATAL_FAILURE(open());
    ASSERT_NO_FATAL_FAILURE(press(20, 32));
    EXPECT_TRUE(feels_like(0.6)) << "as the clip says: " << felt_stiffness();
    ASSERT_NO_FATAL_FAILURE(edit(MaterialBrush::Paint{on_the_left, "foam"}));
    ASSERT_NO_FATAL_FAILURE(change());
    EXPECT_EQ(clip_->in_effect().at("materials"), "on");
    EXPECT_TRUE(feels_like(stiffness_of("foam"))) << felt_stiffness();
    ASSERT_NO_FATAL_FAILURE(edit(MaterialBrush::Paint{on_the_left, "cardboard"}));
    ASSERT_NO_FATAL_FAILURE(change());
    EXPECT_TRUE(feels_like(stiffness_of("cardboard"))) << felt_stiffness();
    ASSERT_TRUE(brush_->undo());
    ASSERT_NO_FATAL_FAILURE(change());
    EXPECT_TRUE(feels_like(stiffness_of("foam"))) << felt_stiffness();
    // And A against B.
    SessionSettings before;
    ASSERT_TRUE(before.set("materials", "off"));
    ASSERT_NO_FATAL_FAILURE(change(before));
    EXPECT_EQ(clip_->in_effect().at("materials"), "off");
    EXPECT_TRUE(feels_like(0.6)) << felt_stiffness();
    EXPECT_FALSE(clip_->failure());
}

TEST_F(PaintedClip, FeelsJoinsAndCuts) {
    ASSERT_NO_FATAL_FAILURE(open());
    ASSERT_NO_FATAL_FAILURE(edit(MaterialBrush::Paint{on_the_left, "foam"}));
    ASSERT_NO_FATAL_FAILURE(edit(MaterialBrush::Join{on_the_left, on_the_right}));
    ASSERT_NO_FATAL_FAILURE(change());
    ASSERT_NO_FATAL_FAILURE(press(70, 32));
    EXPECT_TRUE(feels_like(stiffness_of("foam"))) << felt_stiffness();
    SegmentCut cut{.frame = 0};
    for (int x = 46; x < 96; ++x) cut.stroke.push_back({x, 20});
    ASSERT_NO_FATAL_FAILURE(edit(cut));
    ASSERT_NO_FATAL_FAILURE(edit(MaterialBrush::Paint{{70, 8, 0}, "paper"}));
    ASSERT_NO_FATAL_FAILURE(change());
    EXPECT_TRUE(feels_like(stiffness_of("foam"))) << felt_stiffness();
    ASSERT_NO_FATAL_FAILURE(press(70, 8));
    EXPECT_TRUE(feels_like(stiffness_of("paper"))) << felt_stiffness();
}

TEST_F(PaintedClip, IsNotRecorded) {
    options_.record = folder_ / "hand.touch";
    choice_.painted = brush_->painted();
    const auto refused = OpenedClip::open(options_, choice_, {}, *sound_);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(contains(refused.error().message, "touchable materials"));
}

TEST_F(PaintedClip, IsTintedByItsMaterials) {
    ASSERT_NO_FATAL_FAILURE(edit(MaterialBrush::Paint{on_the_left, "grass"}));
    ASSERT_NO_FATAL_FAILURE(edit(MaterialBrush::Paint{on_the_right, "water"}));
    SegmentTint tint;
    std::vector<std::uint8_t> white(96 * 64 * 3, 255);
    const std::vector<std::uint8_t> black(96 * 64 * 3, 0);
    const PlaneView bright{white.data(), 96 * 3, 96, 64, 1, 3}, dark{black.data(), 96 * 3, 96, 64, 1, 3};
    const auto sum = [](const PlaneView& picture, int x, int y) {
        return picture.sample(x, y, 0) + picture.sample(x, y, 1) + picture.sample(x, y, 2);
    };
    const PlaneView lit = tint.paint(brush_->painted(), 0, bright);
    ASSERT_EQ(lit.width, 96);
    EXPECT_GT(lit.sample(20, 32, 1), lit.sample(20, 32, 2) + 60) << "green";
    EXPECT_GT(lit.sample(70, 32, 2), lit.sample(70, 32, 1) + 60) << "blue";
    int borders = 0;
    for (int x = 0; x < 96; ++x) borders += sum(lit, x, 32) < 60 ? 1 : 0;
    EXPECT_GE(borders, 1);
    EXPECT_LE(borders, 4) << "narrow ones at the border have segments of their own";
    const int of_light = sum(lit, 20, 32);
    // While frames are blended the same one is shown in many pictures.
    white.assign(white.size(), 0);
    EXPECT_EQ(sum(tint.paint(brush_->painted(), 0, bright), 20, 32), of_light) << "it is not painted again";
    EXPECT_LT(sum(tint.paint(brush_->painted(), 99, dark), 20, 32), of_light / 2);
    EXPECT_GT(sum(tint.paint(brush_->painted(), 0, {}), 20, 32), of_light / 2) << "a clip without colour";
}

}  // namespace
}  // namespace touchable::test
