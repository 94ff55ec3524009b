// SPDX-License-Identifier: Apache-2.0
#include <cmath>
#include <limits>
#include <string>

#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

class Pointer : public FingersOverGlobe {
protected:
    Pointer() : FingersOverGlobe({160, 120}, {320, 240}) {}
    void take(const InputEvent& event, PointerInput::Leads leads = PointerInput::Leads::fingers) {
        input_.take(event, leads, *fingers_, view_, width_, height_);
    }
    void put(double x, double y) { take({.x = x, .y = y}); }
    void press(const char* button = "left") { take({.kind = InputEvent::Kind::pressed, .word = button}); }
    void let_go(const char* button = "left") { take({.kind = InputEvent::Kind::released, .word = button}); }
    /// World.
    Places after_a_second() {
        fingers_->intend(field(), camera());
        Places places = after(1000);
        for (auto& place : places) place = workspace_.to_scene(place);
        return places;
    }

    PointerInput input_;
};

TEST_F(Pointer, FingerHoversBeforeSurface) {
    put(160, 120);
    const auto met = pick(field(), camera(), 160, 120);
    ASSERT_TRUE(met && met->drawn);
    const glm::dvec3 wanted = place_in(*met, PointerFingers::hover_m);
    EXPECT_LT(glm::length(after_a_second()[0] - wanted) * workspace_.metres_per_scene_unit, 1e-5);
}

/// However far the clip's camera is; and from wherever it looks.
TEST_F(Pointer, FingersArriveWithinTenthSecond) {
    const auto led = [&](int ticks) {
        Places places{};
        for (int tick = 0; tick < ticks; ++tick) {
            if (tick % 16 == 0) fingers_->intend(field(), camera());
            places = after(1);
        }
        return places;
    };
    const double away_m = glm::length(workspace_.to_device({0, 0, -80}) - workspace_.to_device({0, 0, 0}));
    ASSERT_GT(away_m, 0.1 * PointerSettings().approach_speed);
    fingers_->set_count(3);
    for (const double turned : {0.0, 20.0}) {
        view_.turn(turned, 0);
        put(160, 120);
        const auto soon = led(100), there = led(1000);
        for (std::size_t k = 0; k < 3; ++k)
            EXPECT_LT(glm::length(soon[k] - there[k]), 0.003) << k << ", turned by " << turned;
        input_.leave(*fingers_);
        led(1000);
    }
    put(-200, 120);  // beside the clip, and then over it
    led(10);
    put(160, 120);
    const auto soon = led(150), there = led(1000);
    EXPECT_LT(glm::length(soon[0] - there[0]), 0.003) << "from beside it";
}

TEST_F(Pointer, ButtonPressesAndLifts) {
    put(160, 120);
    press();
    EXPECT_EQ(fingers_->depth_m(), PointerFingers::press_m);
    const auto met = pick(field(), camera(), 160, 120);
    EXPECT_NEAR(depth_in(*met, after_a_second()[0]), PointerFingers::press_m, 1e-5);
    let_go();
    EXPECT_EQ(fingers_->depth_m(), PointerFingers::hover_m);
}

TEST_F(Pointer, WheelDeepensWithinLimits) {
    for (int notch = 0; notch < 100; ++notch) take({.kind = InputEvent::Kind::wheel, .y = 1});
    EXPECT_EQ(fingers_->depth_m(), PointerFingers::deepest_m);
    for (int notch = 0; notch < 100; ++notch) take({.kind = InputEvent::Kind::wheel, .y = -1});
    EXPECT_EQ(fingers_->depth_m(), PointerFingers::highest_m);
}

TEST_F(Pointer, SeveralFingersSurroundPointer) {
    put(160, 120);
    fingers_->set_count(3);
    after_a_second();  // from the first look on it is known how far away they are
    const auto places = after_a_second();
    for (int k = 0; k < 3; ++k) {
        const auto seen = camera().project(places[static_cast<std::size_t>(k)]);
        ASSERT_TRUE(seen);
        const double from_pointer = std::hypot(seen->x - 160, seen->y - 120);
        EXPECT_GT(from_pointer, 5);
        EXPECT_LT(from_pointer, 60);
    }
    EXPECT_LT(glm::length(places[3]), 1e-6) << "a finger that is not there is at the clip's camera";
}

TEST_F(Pointer, HoversOverObstacles) {
    put(20, 20);  // the background, far behind the globe
    auto places = after_a_second();
    ASSERT_GT(-places[0].z, 100);
    put(160, 120);
    for (int tick = 0; tick < 1000; ++tick) {
        if (tick % 16 == 0) {
            Contact met;
            met.proxy = met.goal = places[0];
            fingers_->intend(field(), camera(), std::array{met});
        }
        places[0] = workspace_.to_scene(after(1)[0]);
        const auto seen = camera().project(places[0]);
        ASSERT_TRUE(seen);
        const auto surface = pick(field(), camera(), seen->x, seen->y);
        ASSERT_TRUE(surface);
        ASSERT_LT(-places[0].z, -surface->point.z + 1e-6) << "it is inside at tick " << tick;
    }
    EXPECT_LT(-places[0].z, 80) << "it never came";
}

/// Aside, or along its ray as in a turned view; but friction holds it back by more where it presses deeper.
TEST_F(Pointer, StuckFingerIsLifted) {
    put(160, 120);
    press();
    const glm::dvec3 pressed = after_a_second()[0], ground = pick(field(), camera(), 160, 120)->point,
                     ray = glm::normalize(ground),
                     aside = glm::normalize(glm::cross(ray, glm::dvec3(0, 1, 0)));
    const auto is_lifted = [&](const glm::dvec3& goal_m, double friction) {
        fingers_.emplace(device_, workspace_);
        put(160, 120);
        fingers_->press(true);
        Contact met;
        met.touching = true;
        met.proxy = ground;
        met.goal = ground + goal_m / workspace_.metres_per_scene_unit;
        met.properties.static_friction = friction;
        fingers_->intend(field(), camera(), std::array{met});
        return workspace_.to_scene(after(1000)[0]).z > pressed.z + 1;
    };
    EXPECT_FALSE(is_lifted(0.004 * ray, 0.4)) << "as it is pressed";
    EXPECT_FALSE(is_lifted(0.004 * ray + 0.007 * aside, 0.4)) << "friction";
    EXPECT_TRUE(is_lifted(0.004 * ray + 0.009 * aside, 0.4));
    EXPECT_FALSE(is_lifted(0.004 * ray + 0.009 * aside, 0.8)) << "friction";
    EXPECT_FALSE(is_lifted(0.011 * ray, 0.4)) << "a slope";
    EXPECT_TRUE(is_lifted(0.013 * ray, 0.4));
}

/// It slips off a narrow rim again and again.
TEST_F(Pointer, SlippingFingerIsLiftedOnce) {
    double limb = 160;
    while (-pick(field(), camera(), limb, 120)->point.z < 100) ++limb;
    put(limb - 3, 120);
    press();
    const glm::dvec3 pressed = after_a_second()[0];
    const auto lifted_m = [&](const glm::dvec3& proxy, bool touching) {
        Contact met;
        met.proxy = met.goal = proxy;
        met.touching = touching;
        fingers_->intend(field(), camera(), std::array{met});
        return glm::length(after(1000)[0] - workspace_.to_device(pressed));
    };
    const glm::dvec3 slipped = pick(field(), camera(), limb + 8, 120)->point,
                     above = 0.9 * pick(field(), camera(), limb - 3, 120)->point;
    EXPECT_GT(lifted_m(slipped, true), 0.01);
    EXPECT_LT(lifted_m(above, false), 1e-5) << "it is not pressed again";
    EXPECT_LT(lifted_m(slipped, true), 1e-5) << "it hops for ever";
    put(limb - 9, 120);
    EXPECT_GT(lifted_m(slipped, true), 0.01) << "it stays where the pointer no longer is";
}

/// However far below what it goes over it is.
TEST_F(Pointer, LiftStopsAtCamera) {
    put(160, 120);
    Contact met;
    met.touching = true;
    met.proxy = met.goal = unproject(shown_->scene.camera, 80, 60, 1000);
    double z = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        if (tick % 16 == 0) fingers_->intend(field(), camera(), std::array{met});
        z = workspace_.to_scene(after(1)[0]).z;
        ASSERT_LT(z, 1e-6) << "tick " << tick;
    }
    EXPECT_LT(z, -1) << "it never came";
}

TEST_F(Pointer, EmptyPlaceIsNotPressed) {
    put(160, 120);
    after_a_second();
    put(-200, 120);  // beside the picture of the clip
    press();
    const auto met = pick(field(), camera(), -200, 120);
    ASSERT_FALSE(met && met->drawn);
    EXPECT_LT(glm::length(after_a_second()[0]), 120) << "it went to where nothing is";
}

TEST_F(Pointer, LeavesWithTheWindow) {
    put(160, 120);
    press();
    after_a_second();
    take({.kind = InputEvent::Kind::left_window});
    EXPECT_LT(glm::length(after_a_second()[0]), 1e-6);
    EXPECT_EQ(fingers_->depth_m(), PointerFingers::hover_m) << "nothing is held any more";
}

/// By a drag of the same share of the picture as much, however large that is.
TEST_F(Pointer, MiddleButtonTurnsView) {
    put(160, 120);
    press("middle");
    put(190, 120);
    EXPECT_FALSE(view_.own());
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
    let_go("middle");
    put(160, 120);
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
    view_.go_home();
    width_ = 1280;
    height_ = 960;
    press("middle");
    put(280, 120);
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
}

/// The globe neither swings aside nor grows, however far the view is turned; and follows the pointer from
/// there.
TEST_F(Pointer, TurnedThingStaysInPlace) {
    view_.note_middle(field());
    std::vector<glm::dvec3> globe;
    const double nearest = pick(field(), camera(), 160, 120)->depth;
    for (int y = 0; y < height_; y += 4)
        for (int x = 0; x < width_; x += 4)
            if (const auto met = pick(field(), camera(), x, y);
                met && met->drawn && met->depth < 1.3 * nearest)
                globe.push_back(met->point);
    const auto covered = [&](int axis) {
        double least = 1e9, greatest = -1e9;
        for (const glm::dvec3& point : globe) {
            const auto at = camera().project(point);
            if (!at) return glm::dvec2(0.0);
            least = std::min(least, (*at)[axis]);
            greatest = std::max(greatest, (*at)[axis]);
        }
        return glm::dvec2((least + greatest) / 2, greatest - least);
    };
    const glm::dvec2 across = covered(0), down = covered(1);
    ASSERT_GT(across.y, 100);
    for (const double turned : {20.0, 30.0, 20.0, -140.0}) {  // to 70 and to -70
        view_.turn(turned, 0);
        EXPECT_NEAR(covered(0).x, across.x, 0.05 * width_) << view_.orbit().azimuth;
        EXPECT_NEAR(covered(1).x, down.x, 0.05 * height_) << view_.orbit().azimuth;
        EXPECT_LT(covered(0).y, 1.1 * across.y) << view_.orbit().azimuth;
        EXPECT_LT(covered(1).y, 1.1 * down.y) << view_.orbit().azimuth;
    }
    const double before = covered(0).x;
    view_.pan(40, 0, width_, height_);
    EXPECT_GT(covered(0).x, before + 30) << "it was moved";
}

/// A touchpad has no middle button.
TEST_F(Pointer, ControlLeftActsAsMiddle) {
    const auto press_with_control = [this](bool shift) {
        take({.kind = InputEvent::Kind::pressed, .word = "left", .control = true, .shift = shift});
    };
    put(160, 120);
    press_with_control(false);
    EXPECT_EQ(fingers_->depth_m(), PointerFingers::hover_m) << "it presses";
    put(190, 120);
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
    let_go();
    EXPECT_FALSE(input_.holds());
    press_with_control(true);
    const glm::dvec3 before = camera().eye;
    put(220, 120);
    let_go();
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
    EXPECT_GT(glm::length(camera().eye - before), 0.1) << "it did not move along";
    EXPECT_FALSE(fingers_->was_pressed());
}

TEST_F(Pointer, DeviceLeavesOnlyTheView) {
    const auto lead = [this](const InputEvent& event) { take(event, PointerInput::Leads::view); };
    lead({.x = 160, .y = 120});
    lead({.kind = InputEvent::Kind::pressed, .word = "left"});
    lead({.x = 190, .y = 120});
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
    lead({.kind = InputEvent::Kind::released, .word = "left"});
    lead({.x = 160, .y = 120});
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
    const glm::dvec3 before = view_.camera(320, 240).eye;
    lead({.kind = InputEvent::Kind::wheel, .y = 3});
    const glm::dvec3 nearer = view_.camera(320, 240).eye;
    EXPECT_GT(glm::length(nearer - before), 1);
    lead({.kind = InputEvent::Kind::pressed, .word = "right"});
    lead({.x = 190, .y = 120});
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
    EXPECT_GT(glm::length(view_.camera(320, 240).eye - nearer), 0.1) << "it moved along";
    EXPECT_EQ(fingers_->depth_m(), PointerFingers::hover_m);
    EXPECT_FALSE(fingers_->was_pressed());
}

// Fingers on a touch screen, by the times that their events have.

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

TEST_F(Touches, EachFingerPressesInPlace) {
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
TEST_F(Touches, FingerArrivesWithinTenthSecond) {
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

TEST_F(Touches, FingerApproachesWithoutLeap) {
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

TEST_F(Touches, LiftedFingerLeavesAlone) {
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

TEST_F(Touches, ExtraFingersAreIgnored) {
    for (int k = 0; k < 8; ++k) begin(k + 1, 250 + 20 * k, 240, k);
    EXPECT_EQ(fingers_->present(), PointerFingers::most);
    move(8, 10, 10, 9);
    end(8, 9);
    EXPECT_EQ(pressing(), PointerFingers::most);
    EXPECT_FALSE(is_turned());
}

TEST_F(Touches, TwoMovingFingersTurnView) {
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

TEST_F(Touches, PinchZooms) {
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

TEST_F(Touches, GestureLastsUntilBothLift) {
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

TEST_F(Touches, RestingOrSuccessiveFingersTouch) {
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

TEST_F(Touches, ThreeOrMoreTouch) {
    for (int k = 0; k < 5; ++k) begin(k + 1, 260 + 30 * k, 240, 10 + 0.02 * k);
    for (int k = 0; k < 5; ++k) move(k + 1, 260 + 30 * k, 290, 10.2);
    EXPECT_FALSE(is_turned());
    EXPECT_EQ(pressing(), 5);
}

TEST_F(Touches, FingerOnBackgroundTurnsView) {
    begin(1, 20, 20, 10, Ground::nothing);
    begin(2, 320, 240, 12);
    move(1, 60, 20, 13);
    EXPECT_NEAR(view_.orbit().azimuth, -18, 1e-9);
    EXPECT_EQ(pressing(), 1);
    move(2, 330, 250, 13);
    EXPECT_NEAR(view_.orbit().azimuth, -18, 1e-9);
}

TEST_F(Touches, FingerOnPanelIsPointer) {
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

/// A cancelled finger on a panel clicks nothing.
TEST_F(Touches, CancelledFingersAreIgnored) {
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

TEST_F(Touches, PointerYieldsToFingers) {
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

TEST_F(Touches, InvalidEventsAreIgnored) {
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

TEST_F(Touches, FingerOverHoleIsLifted) {
    begin(1, 320, 240, 0);
    ASSERT_EQ(pressing(), 1);
    move(1, -300, 240, 1);
    EXPECT_EQ(pressing(), 0);
}

}  // namespace
}  // namespace touchable::test
