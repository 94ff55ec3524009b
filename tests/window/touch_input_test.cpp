// Fingers on a touch screen, by the times that their events have.
#include <cmath>
#include <limits>
#include <string>

#include "tests/window/fingers_over_globe.hpp"

namespace touchable::test {
namespace {

using Kind = InputEvent::Kind;
using Ground = TouchInput::Ground;

class Touches : public FingersOverGlobe {
protected:
    Touches() : FingersOverGlobe({160, 120}, {640, 480}) {}
    std::vector<InputEvent> take(Kind kind, int touch, double x, double y, double seconds,
                                 Ground ground = Ground::surface) {
        return touches_.take({.kind = kind, .x = x, .y = y, .touch = touch, .seconds = seconds}, ground,
                             {&*fingers_, &view_}, width_, height_);
    }
    auto begin(int touch, double x, double y, double s, Ground ground = Ground::surface) {
        return take(Kind::touch_began, touch, x, y, s, ground);
    }
    auto move(int touch, double x, double y, double s) { return take(Kind::touch_moved, touch, x, y, s); }
    auto end(int touch, double s) { return take(Kind::touch_ended, touch, 0, 0, s); }

    /// How deep fingers are under the surface after so many ticks, device metres; nothing: away.
    std::vector<std::optional<double>> depths(int ticks = 400) {
        fingers_->intend(field(), camera());
        std::vector<std::optional<double>> deep;
        for (const glm::dvec3& place : after(ticks)) {
            const glm::dvec3 world = workspace_.to_scene(place);
            const auto seen = glm::length(world) > 1e-6 ? camera().project(world) : std::nullopt;
            const auto met = seen ? pick(field(), camera(), seen->x, seen->y) : std::nullopt;
            deep.push_back(met ? std::optional(depth_in(*met, world)) : std::nullopt);
        }
        return deep;
    }
    int pressing(int ticks = 400) {
        int count = 0;
        for (const auto& deep : depths(ticks)) count += deep && *deep > 0.003;
        return count;
    }
    bool is_turned() const { return !view_.own(); }

    TouchInput touches_;
};

TEST_F(Touches, EachFingerPressesWhereItIs) {
    const std::array<glm::dvec2, 3> at{{{320, 240}, {260, 200}, {380, 300}}};
    for (int k = 0; k < 3; ++k) begin(k + 1, at[k].x, at[k].y, k);
    EXPECT_EQ(fingers_->present(), 3);
    fingers_->intend(field(), camera());
    const Places places = after(1000);
    for (int k = 0; k < 3; ++k) {
        const auto met = pick(field(), camera(), at[k].x, at[k].y);
        ASSERT_TRUE(met && met->drawn);
        const glm::dvec3 wanted = place_in(*met, PointerFingers::press_m);
        EXPECT_LT(glm::length(places[k] - workspace_.to_device(wanted)), 1e-5) << k;
    }
    EXPECT_FALSE(is_turned());
    EXPECT_EQ(fingers_->shown(), 3);
}

/// A mouse's finger comes from the clip's camera, here 5 cm of the hand's away.
TEST_F(Touches, FingerIsFeltWithinATenthOfASecondAndSoIsTheMouses) {
    begin(1, 320, 240, 0);
    const double deep = depths(100)[0].value_or(-1);
    EXPECT_GT(deep, 0.0005) << "half a newton in 1 N/mm";
    fingers_->lift(0);
    fingers_->set_pointer(glm::dvec2(320, 240));
    fingers_->press(true);
    depths(2000);
    fingers_->set_pointer(std::nullopt);
    depths(2000);
    fingers_->set_pointer(glm::dvec2(320, 240));
    EXPECT_GT(depths(100)[0].value_or(-1), 0.0005);
}

TEST_F(Touches, FingerComesFromBeforeTheSurfaceAndNeverLeapsOnIt) {
    begin(1, 320, 240, 0);
    fingers_->intend(field(), camera());
    const auto met = pick(field(), camera(), 320, 240);
    double before = depth_in(*met, workspace_.to_scene(after(1)[0]));
    EXPECT_LT(before, -0.006);
    for (int tick = 0; tick < 500; ++tick) {
        const double deep = depth_in(*met, workspace_.to_scene(after(1)[0]));
        EXPECT_LT(deep - before, 0.0004 + 1e-9) << "0.4 m/s";
        before = deep;
    }
}

TEST_F(Touches, LiftedFingerLeavesAtOnceAndTheOthersStay) {
    begin(1, 320, 240, 0);
    begin(2, 260, 200, 1);
    begin(3, 380, 300, 2);
    ASSERT_EQ(pressing(), 3);
    end(2, 3);
    after(60);  // before any picture
    EXPECT_EQ(pressing(0 + 1), 2);
    const auto deep = depths(1000);
    EXPECT_FALSE(deep[1] && *deep[1] > -0.05);
    begin(4, 300, 260, 5);
    EXPECT_EQ(fingers_->present(), 3) << "the place of the one that left";
    EXPECT_EQ(pressing(), 3);
}

TEST_F(Touches, NoMoreFingersTouchThanThereAre) {
    for (int k = 0; k < 8; ++k) begin(k + 1, 250 + 20 * k, 240, k);
    EXPECT_EQ(fingers_->present(), PointerFingers::most);
    move(8, 10, 10, 9);
    end(8, 9);
    EXPECT_EQ(pressing(), PointerFingers::most);
    EXPECT_FALSE(is_turned());
}

TEST_F(Touches, TwoThatArePutDownTogetherAndMoveAtOnceTurnTheView) {
    begin(1, 300, 240, 10);
    begin(2, 340, 240, 10.1);
    for (int k = 1; k <= 30; ++k) {
        move(1, 300 + 2 * k, 240, 10.1 + 0.01 * k);
        move(2, 340 + 2 * k, 240, 10.1 + 0.01 * k);
    }
    ASSERT_TRUE(is_turned());
    // 60 pixels of 480, less what shows that it moves: 216 degrees a height.
    EXPECT_NEAR(view_.orbit().azimuth, -27, 7);
    EXPECT_NEAR(view_.orbit().elevation, 0, 1e-9);
    EXPECT_NEAR(view_.orbit().zoom.value_or(0), 1, 0.25);
    EXPECT_EQ(pressing(), 0);
    EXPECT_EQ(fingers_->present(), 1) << "as many as the mouse has";
}

TEST_F(Touches, TwoThatGoApartBringTheViewNearerByAsMuch) {
    begin(1, 300, 240, 10);
    begin(2, 340, 240, 10.1);
    move(1, 280, 240, 10.2);  // from here on they do
    move(2, 360, 240, 10.2);
    const double zoom = view_.orbit().zoom.value_or(0), azimuth = view_.orbit().azimuth;
    for (int k = 1; k <= 40; ++k) {
        move(1, 280 - k, 240, 10.3);
        move(2, 360 + k, 240, 10.3);
    }
    EXPECT_NEAR(view_.orbit().zoom.value_or(0) / zoom, 2, 1e-9);
    EXPECT_NEAR(view_.orbit().azimuth, azimuth, 1e-9) << "their middle stays";
    for (int k = 40; k > 0; --k) {
        move(1, 280 - k, 240, 10.4);
        move(2, 360 + k, 240, 10.4);
    }
    EXPECT_NEAR(view_.orbit().zoom.value_or(0) / zoom, 82.0 / 80, 1e-9);
    EXPECT_EQ(pressing(), 0);
}

TEST_F(Touches, GestureGoesOnUntilBothAreLifted) {
    begin(1, 300, 240, 10);
    begin(2, 340, 240, 10.1);
    move(1, 260, 240, 10.2);
    ASSERT_TRUE(is_turned());
    end(1, 10.4);
    const double azimuth = view_.orbit().azimuth;
    move(2, 390, 240, 10.5);
    EXPECT_NEAR(view_.orbit().azimuth, azimuth - 22.5, 1e-9) << "one turns on, from where it was";
    begin(3, 300, 240, 12);
    EXPECT_EQ(pressing(), 0) << "fingers that are put down again go on";
    end(2, 13);
    end(3, 13);
    begin(4, 300, 240, 14);
    EXPECT_EQ(pressing(), 1);
}

TEST_F(Touches, TwoThatRestOrComeOneAfterTheOtherTouch) {
    begin(1, 300, 240, 10);
    begin(2, 340, 240, 10.1);
    move(1, 300, 246, 10.3);  // a finger trembles
    EXPECT_EQ(pressing(), 2);
    move(1, 300, 300, 10.1 + TouchInput::rest_s + 0.01);
    move(2, 340, 300, 10.7);
    EXPECT_EQ(pressing(), 2);
    EXPECT_FALSE(is_turned()) << "who rests touches";
    end(1, 11);
    end(2, 11);
    begin(1, 300, 240, 20);
    begin(2, 340, 240, 20 + TouchInput::together_s + 0.01);
    move(2, 340, 300, 20.4);
    move(1, 300, 300, 20.4);
    EXPECT_EQ(pressing(), 2);
    EXPECT_FALSE(is_turned()) << "one after the other";
    end(1, 21);
    end(2, 21);
    begin(1, 300, 240, 30);
    move(1, 330, 240, 30.1);
    begin(2, 350, 280, 30.2);
    move(2, 350, 320, 30.3);
    EXPECT_EQ(pressing(), 2);
    EXPECT_FALSE(is_turned()) << "the first one strokes already";
}

TEST_F(Touches, ThreeAndMoreTouch) {
    for (int k = 0; k < 5; ++k) begin(k + 1, 260 + 30 * k, 240, 10 + 0.02 * k);
    for (int k = 0; k < 5; ++k) move(k + 1, 260 + 30 * k, 290, 10.2);
    EXPECT_FALSE(is_turned());
    EXPECT_EQ(pressing(), 5);
}

TEST_F(Touches, OneWhereNothingIsTurnsTheViewWhileAnotherTouches) {
    begin(1, 20, 20, 10, Ground::nothing);
    begin(2, 320, 240, 12);
    move(1, 60, 20, 13);
    EXPECT_NEAR(view_.orbit().azimuth, -18, 1e-9);
    EXPECT_EQ(pressing(), 1);
    move(2, 330, 250, 13);
    EXPECT_NEAR(view_.orbit().azimuth, -18, 1e-9);
}

TEST_F(Touches, OneOnAPanelIsThePointerAndTouchesNothing) {
    const auto pressed = begin(1, 30, 40, 10, Ground::pointers);
    ASSERT_EQ(pressed.size(), 2U);
    EXPECT_EQ(pressed[0].kind, Kind::moved);
    EXPECT_EQ(pressed[1].kind, Kind::pressed);
    EXPECT_EQ(pressed[1].word, "left");
    EXPECT_TRUE(begin(2, 50, 40, 10, Ground::pointers).empty()) << "there is one pointer";
    begin(3, 320, 240, 10.1);
    const auto moved = move(1, 60, 45, 10.2);
    ASSERT_EQ(moved.size(), 1U);
    EXPECT_EQ(moved[0].x, 60);
    EXPECT_TRUE(move(3, 330, 280, 10.2).empty());
    EXPECT_FALSE(is_turned());
    EXPECT_EQ(pressing(), 1);
    const auto let_go = end(1, 10.3);
    ASSERT_EQ(let_go.size(), 2U);
    EXPECT_EQ(let_go[0].kind, Kind::released);
    EXPECT_EQ(let_go[0].x, 60);
    EXPECT_EQ(let_go[1].kind, Kind::left_window);
    EXPECT_EQ(pressing(), 1);
}

/// Of a panel it clicks nothing.
TEST_F(Touches, CancelledFingersAreLiftedAndWhatComesOfThemIsNobodys) {
    begin(1, 320, 240, 10);
    begin(2, 260, 200, 11);
    begin(3, 30, 40, 11, Ground::pointers);
    ASSERT_EQ(pressing(), 2);
    const auto events = touches_.cancel(&*fingers_);
    ASSERT_EQ(events.size(), 2U);
    EXPECT_EQ(events[0].kind, Kind::left_window);
    EXPECT_EQ(events[1].kind, Kind::released);
    after(60);
    EXPECT_EQ(pressing(1), 0);
    move(1, 330, 250, 12);
    end(2, 12);
    EXPECT_TRUE(move(3, 40, 40, 12).empty());
    EXPECT_EQ(pressing(), 0);
    begin(1, 320, 240, 13);
    EXPECT_EQ(pressing(), 1);
}

TEST_F(Touches, PointerLeadsNoFingerMeanwhile) {
    fingers_->set_pointer(glm::dvec2(320, 240));
    fingers_->set_count(3);
    fingers_->press(true);
    ASSERT_EQ(pressing(2000), 3);
    begin(1, 300, 200, 0);
    EXPECT_EQ(pressing(), 1);
    end(1, 0.5);
    EXPECT_EQ(fingers_->shown(), 0) << "the mouse's come back when it is moved";
    EXPECT_EQ(pressing(), 0);
    begin(1, 300, 200, 1);
    fingers_->set_pointer(glm::dvec2(330, 240));
    fingers_->set_pointer(std::nullopt);
    EXPECT_EQ(pressing(), 1) << "a mouse that leaves lifts the mouse's fingers";
    EXPECT_EQ(fingers_->looked_at(), std::optional(glm::dvec2(300, 200)));
    end(1, 1);
    EXPECT_EQ(pressing(), 0);
}

TEST_F(Touches, WhatIsNoPlaceOrNobodysIsIgnored) {
    constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    begin(1, nan, 240, 0);
    move(2, 300, 240, 0);
    end(3, 0);
    EXPECT_EQ(fingers_->shown(), 0);
    begin(1, 320, 240, 1);
    begin(1, 300, 200, 1);
    move(1, 300, nan, 1);
    EXPECT_EQ(fingers_->looked_at(), std::optional(glm::dvec2(320, 240)));
    for (int k = 10; k < 1000; ++k) begin(k, 300, 240, 2, Ground::nothing);
    EXPECT_EQ(pressing(), 1);
}

TEST_F(Touches, FingerOverAHoleIsNotPressed) {
    begin(1, 320, 240, 0);
    ASSERT_EQ(pressing(), 1);
    move(1, -300, 240, 1);
    EXPECT_EQ(pressing(), 0);
}

}  // namespace
}  // namespace touchable::test
