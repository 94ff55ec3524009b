// SPDX-License-Identifier: Apache-2.0
// Labels of places of a clip: read, found, and shown where a finger rests.

#include <gtest/gtest.h>
#include <imgui.h>

#include <algorithm>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "player/draw/light_picture.hpp"
#include "player/window/finger_halos.hpp"
#include "player/window/imgui_layer.hpp"
#include "player/window/kiosk.hpp"
#include "player/window/opened_clip.hpp"
#include "player/window/window_panel.hpp"
#include "tests/view/shown.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

Result<TouchLabels> read(const std::string& labels) {
    return parse_touch_labels("{\"touchable_labels\": 1, \"labels\": [" + labels + "]}", "l.json",
                              "/exhibit");
}

std::string refusal(const std::string& labels) {
    const auto parsed = read(labels);
    return parsed ? "" : parsed.error().message;
}

TEST(TouchLabels, FirstMatchWins) {
    const auto labels = read(R"(
        {"caption": "early", "rectangle": [10, 20, 30, 40], "frames": [0, 9]},
        {"caption": "late", "rectangle": [10, 20, 30, 40], "frames": [10, 19]},
        {"caption": "triangle", "polygon": [[0, 0], [50, 0], [0, 50]]},
        {"caption": "bell", "segment": "bell"})");
    ASSERT_TRUE(labels) << labels.error().message;
    const auto at = [&](double x, double y, std::int64_t frame, const char* segment = "") {
        return static_cast<int>(labels->at({x, y}, frame, segment).value_or(99));
    };
    EXPECT_EQ(at(20, 30, 9), 0);
    EXPECT_EQ(at(20, 30, 10), 1);
    EXPECT_EQ(at(20, 29, 20), 2) << "later than both, and in the triangle";
    EXPECT_EQ(at(10, 20, 0), 0) << "the corner is inside";
    EXPECT_EQ(at(30.4, 30, 0), 0) << "and half a pixel around it";
    EXPECT_EQ(at(30, 40.6, 0), 99);
    EXPECT_EQ(at(26, 26, 20), 99) << "beyond the triangle's long side";
    EXPECT_EQ(at(100, 100, 0, "bell"), 3);
    EXPECT_EQ(at(100, 100, 0, "bel"), 99);
    EXPECT_EQ(at(5, 5, 0, "bell"), 2);
}

TEST(TouchLabels, FallBackToAvailableLanguage) {
    const auto labels = read(R"(
        {"caption": {"de": "Afrika", "en": "Africa"}, "sound": {"de": "afrika.wav"}, "segment": "a"},
        {"caption": "Etna", "sound": "/sounds/etna.wav", "segment": "b"},
        {"caption": {"fr": "cloche"}, "segment": "c"})");
    ASSERT_TRUE(labels) << labels.error().message;
    const auto caption = [&](std::size_t k, const char* language) {
        return *said_in(labels->labels[k].captions, language);
    };
    EXPECT_EQ(caption(0, "de"), "Afrika");
    EXPECT_EQ(caption(0, "fr"), "Africa");
    EXPECT_EQ(caption(1, "de"), "Etna");
    EXPECT_EQ(caption(2, "de"), "cloche");
    EXPECT_EQ(*said_in(labels->labels[0].sounds, "en"), "/exhibit/afrika.wav") << "beside the file of labels";
    EXPECT_EQ(*said_in(labels->labels[1].sounds, "en"), "/sounds/etna.wav");
    EXPECT_EQ(said_in(labels->labels[2].sounds, "en"), nullptr);
}

TEST(TouchLabels, RejectInvalidWithHint) {
    EXPECT_TRUE(contains(refusal(""), "1 to 1000 labels"));
    EXPECT_TRUE(contains(refusal(R"({"caption": "a"})"), "rectangle, polygon or segment"));
    EXPECT_TRUE(
        contains(refusal(R"({"caption": "a", "segment": "a", "rectangle": [0, 0, 1, 1]})"), "one place"));
    EXPECT_TRUE(contains(refusal(R"({"segment": "a"})"), "labels[0].caption is missing"));
    EXPECT_TRUE(contains(refusal(R"({"caption": "", "segment": "a"})"), "labels[0].caption"));
    EXPECT_TRUE(contains(refusal(R"({"caption": {"Deutsch": "a"}, "segment": "a"})"), "\"de\""));
    EXPECT_TRUE(contains(refusal(R"({"caption": "a", "rectangle": [5, 0, 4, 1]})"), "left"));
    EXPECT_TRUE(contains(refusal(R"({"caption": "a", "rectangle": [-1, 0, 4, 1]})"), "rectangle[0]"));
    EXPECT_TRUE(contains(refusal(R"({"caption": "a", "polygon": [[0, 0], [1, 1]]})"), "3 to 1000"));
    EXPECT_TRUE(
        contains(refusal(R"({"caption": "a", "segment": "a", "frames": [3, 2]})"), "labels[0].frames"));
    EXPECT_TRUE(contains(refusal(R"({"caption": "a", "segment": "a", "colour": 1})"), "colour"));
    EXPECT_EQ(refusal("[").find("l.json: "), 0U);
}

TEST(TouchLabels, MustFitClipAndSegments) {
    const auto labels = read(R"({"caption": "a", "rectangle": [0, 0, 63, 47], "frames": [9, 20]},
                                {"caption": "b", "segment": "bell"})");
    ASSERT_TRUE(labels);
    EXPECT_TRUE(labels->fits(64, 48, 10));
    EXPECT_TRUE(labels->fits(64, 48, 0)) << "a stream";
    EXPECT_FALSE(labels->fits(63, 48, 10));
    EXPECT_TRUE(contains(labels->fits(64, 47, 10).error().message, "l.json: labels[0]"));
    EXPECT_TRUE(contains(labels->fits(64, 48, 9).error().message, "frame 9"));
    EXPECT_TRUE(labels->has_segments({"wall", "bell"}));
    EXPECT_TRUE(contains(labels->has_segments({"wall"}).error().message, "labels[1]"));
}

/// Fingers at their times.
class RestingFinger : public ::testing::Test {
protected:
    std::optional<std::size_t> look(double now_s, std::optional<std::size_t> label, double x = 10) {
        const LabelledFinger finger{{x, 10}, label};
        return fingers_.take(std::span(&finger, 1), now_s);
    }
    RestingFingers fingers_{3};
};

TEST_F(RestingFinger, SpeaksOnceAfterHalfSecond) {
    EXPECT_FALSE(look(1.0, 4));
    EXPECT_FALSE(look(1.4, 4));
    EXPECT_FALSE(fingers_.shown());
    EXPECT_EQ(look(1.6, 4), 4U);
    EXPECT_EQ(fingers_.shown(), 4U);
    for (double at = 1.7; at < 9; at += 0.1) EXPECT_FALSE(look(at, 4)) << "it is said already";
    EXPECT_EQ(fingers_.shown(), 4U) << "as long as the finger is there";
    EXPECT_FALSE(look(9.5, {}));
    EXPECT_FALSE(look(12, {}));
    EXPECT_FALSE(fingers_.shown());
    EXPECT_FALSE(look(13, 4));
    EXPECT_EQ(look(13.6, 4), 4U) << "it was left, and is met again";
}

TEST_F(RestingFinger, MovingFingerDoesNotRest) {
    for (double at = 1; at < 4; at += 0.1) EXPECT_FALSE(look(at, 4, 10 * at)) << at;
    EXPECT_FALSE(look(4.2, 4, 40));
    EXPECT_EQ(look(4.8, 4, 41), 4U);
}

TEST_F(RestingFinger, SurvivesShortLift) {
    EXPECT_FALSE(look(1.0, 4));
    EXPECT_FALSE(look(1.3, 4));
    EXPECT_FALSE(look(1.4, {}));
    EXPECT_EQ(look(1.5, 4), 4U);
    EXPECT_FALSE(look(1.9, 4));
    EXPECT_FALSE(look(2.0, {}));
    EXPECT_FALSE(look(2.1, 4));
    EXPECT_FALSE(look(2.7, 4)) << "it never left";
}

TEST_F(RestingFinger, SwitchesToOtherLabel) {
    EXPECT_FALSE(look(1.0, 4));
    EXPECT_EQ(look(1.5, 4), 4U);
    EXPECT_FALSE(look(1.8, 5));
    EXPECT_FALSE(look(2.2, 5));
    EXPECT_EQ(look(2.4, 5), 5U);
    EXPECT_EQ(fingers_.shown(), 5U);
}

TEST_F(RestingFinger, TracksEachFinger) {
    RestingFingers resting(3);
    const LabelledFinger both[] = {{{10, 10}, 0U}, {{50, 10}, 1U}};
    EXPECT_FALSE(resting.take(std::span(both, 1), 1.0));
    EXPECT_FALSE(resting.take(both, 1.3));
    EXPECT_EQ(resting.take(both, 1.6), 0U);
    EXPECT_EQ(resting.take(both, 1.9), 1U);
}

// How forces are told beside fingers, and on the bar.

/// The figures of docs/play.md.
TEST(Ring, TightensWithForceAndDistance) {
    EXPECT_DOUBLE_EQ(ring_radii(0, 0, 10), 1.55);
    EXPECT_DOUBLE_EQ(ring_radii(0, 1, 10), 1.46);
    EXPECT_DOUBLE_EQ(ring_radii(0, 3, 10), 1.28);
    EXPECT_DOUBLE_EQ(ring_radii(0, 5, 10), 1.1);
    EXPECT_DOUBLE_EQ(ring_radii(0, 9, 10), 1.1) << "the ball stays in it";
    EXPECT_DOUBLE_EQ(ring_radii(0, 1, 2), 1.325) << "a device that has 2 N";
    EXPECT_DOUBLE_EQ(ring_radii(0.5 / 3.2, 0, 10), 1.6125);
    EXPECT_DOUBLE_EQ(ring_radii(4 / 3.2, 0, 10), 2.05);
    EXPECT_DOUBLE_EQ(ring_radii(50, 0, 10), 2.35);
}

TEST(Shadow, ClosesInAndDarkens) {
    FingerMark finger;
    const auto at = [&](double radii) {
        finger.proxy = {0, 0, 2 * radii - 100};
        finger.under = FingerMark::Under{{0, 0, -100}, {0, 0, 1}, 2 * radii};
        return shadow_of(finger, 2);
    };
    const BallShadow far = at(4 / 3.2), near = at(0.5 / 3.2);
    EXPECT_DOUBLE_EQ(far.reach, 2 * 2.75);
    EXPECT_DOUBLE_EQ(near.reach, 2 * 1.65625);
    EXPECT_NEAR(far.darkness, 0.3, 1e-6);
    EXPECT_NEAR(near.darkness, 0.6316, 1e-4);
    // To the lower right, as the light comes from the upper left; on the surface.
    EXPECT_DOUBLE_EQ(far.centre.x, 0.78 * 2.5);
    EXPECT_DOUBLE_EQ(far.centre.y, -0.92 * 2.5);
    EXPECT_DOUBLE_EQ(far.centre.z, -100);
    finger.touching = true;
    const BallShadow met = at(0);
    EXPECT_EQ(met.centre, finger.under->foot);
    EXPECT_DOUBLE_EQ(met.reach, 3);
    EXPECT_NEAR(met.darkness, 0.75, 1e-6);
}

/// A finger before the middle of a plane, seen by the clip's own camera.
class WindowFingerMarks : public ::testing::Test {
protected:
    FingerHalo halo_of(const glm::dvec3& newtons, double error_degrees = std::nan("")) const {
        FingerMark mark;
        mark.error_degrees = error_degrees;
        mark.goal = mark.proxy = {0, 0, -0.5 * shown_->scene.depth.near};
        mark.force = newtons;
        mark.touching = true;
        const auto halos = finger_halos({&mark, 1}, {2, 6}, shown_->field(), camera_);
        EXPECT_EQ(halos.size(), 1U);
        return halos.empty() ? FingerHalo() : halos[0];
    }
    const std::unique_ptr<Shown> shown_ = shown_scene("plane", 96, 64);
    const ViewCamera camera_ = own_view(shown_->scene, 192, 128, 1e-3 * shown_->scene.depth.near);
};

TEST_F(WindowFingerMarks, RingTellsForceDirection) {
    EXPECT_TRUE(halo_of({0, 0, 2}).towards_eye);
    EXPECT_FALSE(halo_of({0, 0, -2}).towards_eye);
    EXPECT_EQ(halo_of({0, 0, -2}).newtons, 2);
}

TEST_F(WindowFingerMarks, FullRingIsLargestForce) {
    const FingerHalo one = halo_of({0, 0, 1}), three = halo_of({0, 0, 3}), most = halo_of({0, 0, 11});
    EXPECT_DOUBLE_EQ(one.share, 0.1);
    EXPECT_DOUBLE_EQ(three.share, 0.3);
    EXPECT_EQ(most.share, 1);
    EXPECT_DOUBLE_EQ(one.ring, 1.46 * one.radius);
    EXPECT_DOUBLE_EQ(three.ring, 1.28 * three.radius);
}

TEST_F(WindowFingerMarks, RingTellsDoubtOfDirection) {
    EXPECT_EQ(halo_of({0, 0, 1}).doubt, 0) << "not known";
    EXPECT_DOUBLE_EQ(halo_of({0, 0, 1}, 4.6).doubt, 0.25);
    EXPECT_EQ(halo_of({0, 0, 1}, 90).doubt, 1);
}

TEST_F(WindowFingerMarks, ArrowPointsAlongForce) {
    const FingerHalo right = halo_of({1, 0, 0}), up = halo_of({0, 1, 0});
    EXPECT_GT(right.arrow.x, 1);
    EXPECT_NEAR(right.arrow.y, 0, 1e-9);
    EXPECT_LT(up.arrow.y, -1) << "pixels count downward";
    EXPECT_NEAR(up.arrow.x, 0, 1e-9);
}

TEST_F(WindowFingerMarks, ForceIsCommandedForce) {
    WatchedTick tick;
    tick.tick = 1;
    tick.fingers.resize(1);
    tick.fingers[0].contact.touching = true;
    tick.fingers[0].contact.proxy = tick.fingers[0].contact.goal = {0, 0, -1};
    tick.fingers[0].force.force = {1, -2, 3};
    const auto marks = FingerTrails().marks(tick, 1, shown_->field());
    ASSERT_EQ(marks.size(), 1U);
    EXPECT_EQ(marks[0].force, glm::dvec3(1, -2, 3));
}

TEST_F(WindowFingerMarks, FingerNearCameraIsHidden) {
    const HeightField field = shown_->field();
    const FieldProbe probe(field);
    const double depth = probe.depth_under(90, 20).value();
    WatchedTick tick;
    tick.fingers.resize(2);
    for (std::size_t k = 0; k < 2; ++k)
        tick.fingers[k].goal = tick.fingers[k].contact.goal =
            probe.unproject(90, 20, (k == 0 ? 0.45 : 0.55) * depth);
    const auto marks = FingerTrails().marks(tick, 2, field);
    EXPECT_FALSE(marks[0].shown);
    EXPECT_TRUE(marks[1].shown);
}

TEST(FingerHalos, LabelsNeverOverlap) {
    std::vector<LabelBox> taken{{{90, 90}, {110, 110}}, {{115, 90}, {135, 110}}};  // two rings
    const glm::dvec2 size(40, 16);
    const auto place = [&](const glm::dvec2& at) {
        const auto free = place_label(at, 15, size, taken);
        if (free) taken.push_back({*free, *free + size});
        return free;
    };
    EXPECT_EQ(place({100, 100}), glm::dvec2(45, 92)) << "to the left: the other finger is to the right";
    EXPECT_EQ(place({125, 100}), glm::dvec2(140, 92));
    EXPECT_EQ(place({100, 100}), glm::dvec2(80, 69)) << "above";
    EXPECT_EQ(place({100, 100}), glm::dvec2(80, 115)) << "below";
    EXPECT_FALSE(place({100, 100}));
}

/// Within their box, which begins at (50, 50) with a soft edge.
TEST(CurvesPanel, ShowsLateTicksAndLostFramesAtOnce) {
    ImGuiLayer layer(1);
    CurvesPanel curves;
    PanelFacts facts;
    const auto drawn = [&] {
        curves.remember(facts, 0, 0);
        layer.begin(640, 480, 0.02, {});
        ImGui::SetNextWindowPos(ImVec2(50, 50));
        ImGui::SetNextWindowSize(ImVec2(500, 400));
        ImGui::Begin("curves");
        curves.draw(10, 1);
        ImGui::End();
        layer.end();
        const ImDrawData& data = *ImGui::GetDrawData();
        for (int k = 0; k < data.CmdListsCount; ++k)
            for (const ImDrawVert& corner : data.CmdLists[k]->VtxBuffer)
                EXPECT_GT(std::min(corner.pos.x, corner.pos.y), 48);
        return data.TotalVtxCount;
    };
    drawn();
    const int without = drawn();
    for (std::int64_t* const count : {&facts.late_ticks, &facts.dropped_frames}) {
        ++*count;
        EXPECT_GT(drawn(), without);
        for (std::size_t k = 1; k < Curve::most; ++k) EXPECT_GT(drawn(), without) << k;
        EXPECT_EQ(drawn(), without);
    }
}

TEST(PlaybackBar, LiveSourceHasNoPlayButton) {
    ImGuiLayer layer(1);
    WindowPanel panel(1);
    PanelFacts facts;
    for (const bool is_live : {false, true}) {
        facts.is_live = is_live;
        std::vector<WindowCommand> asked;
        InputEvent event{.word = "left"};
        for (event.y = 430; event.y < 480; event.y += 6)
            for (event.x = 6; event.x < 120; event.x += 6)
                for (const auto kind :
                     {InputEvent::Kind::moved, InputEvent::Kind::pressed, InputEvent::Kind::released}) {
                    event.kind = kind;
                    layer.begin(640, 480, 0.02, {&event, 1});
                    panel.draw(facts, 640, 480, asked);
                    layer.end();
                }
        const auto plays = [](const WindowCommand& c) { return c.verb == WindowVerb::play_pause; };
        EXPECT_EQ(std::ranges::any_of(asked, plays), !is_live);
    }
}

TEST(StudyPage, FittingAnswersAreSideBySide) {
    ImGuiLayer layer(1);
    WindowPanel panel(1);
    PanelFacts facts;
    facts.study.emplace();
    std::string words;
    const auto answers_on_the_right = [&] {
        facts.study->answers.assign(3, words);
        std::vector<WindowCommand> asked;
        InputEvent event{.x = 250, .word = "left"};
        for (event.y = 0; event.y < 400; event.y += 10)
            for (const auto kind :
                 {InputEvent::Kind::moved, InputEvent::Kind::pressed, InputEvent::Kind::released}) {
                event.kind = kind;
                layer.begin(300, 400, 0.02, {&event, 1});
                panel.draw(facts, 300, 400, asked);
                layer.end();
            }
        std::set<double> answers;
        for (const WindowCommand& command : asked) answers.insert(command.number);
        return answers;
    };
    // With two thirds of its share of the page an answer fits into its button, undiminished.
    const ImFont& usual = *ImGui::GetIO().Fonts->Fonts[0];
    while (usual.CalcTextSizeA(13, 1000, 0, words.c_str()).x < 56) words += 'i';
    EXPECT_EQ(answers_on_the_right(), std::set<double>{3});
    words += std::string(60, 'i');
    EXPECT_EQ(answers_on_the_right(), (std::set<double>{1, 2, 3})) << "one below the other";
}

}  // namespace
}  // namespace touchable::test
