#include "tests/window/fingers_over_globe.hpp"

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

TEST_F(Pointer, FingerHoversBeforeWhatIsSeenThere) {
    put(160, 120);
    const auto met = pick(field(), camera(), 160, 120);
    ASSERT_TRUE(met && met->drawn);
    const glm::dvec3 wanted = place_in(*met, PointerFingers::hover_m);
    EXPECT_LT(glm::length(after_a_second()[0] - wanted) * workspace_.metres_per_scene_unit, 1e-5);
}

/// However far the clip's camera is; and from wherever it looks.
TEST_F(Pointer, FingersThatComeAreThereWithinATenthOfASecond) {
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

TEST_F(Pointer, ButtonPressesAndLettingGoLiftsAgain) {
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

TEST_F(Pointer, SeveralFingersStandRoundIt) {
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

TEST_F(Pointer, HoversOverWhatIsInItsWay) {
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
TEST_F(Pointer, IsLiftedWhereItStaysFarFromItsGoal) {
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
TEST_F(Pointer, IsLiftedOnceToWhereItDoesNotStay) {
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
TEST_F(Pointer, IsNotLiftedThroughTheClipsCamera) {
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

TEST_F(Pointer, WhatIsNotThereIsNotPressed) {
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
TEST_F(Pointer, MiddleButtonTurnsTheViewAndLeavesTheFinger) {
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

/// A touchpad has no middle button.
TEST_F(Pointer, ControlAndLeftButtonAreTheMiddleOne) {
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
    EXPECT_TRUE(input_.take_double_click());
    const glm::dvec3 before = camera().eye;
    put(220, 120);
    let_go();
    EXPECT_NEAR(view_.orbit().azimuth, -27, 1e-9);
    EXPECT_GT(glm::length(camera().eye - before), 0.1) << "it did not move along";
    EXPECT_FALSE(fingers_->was_pressed());
}

TEST_F(Pointer, WhereADeviceIsHeldItOnlyMovesTheView) {
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

}  // namespace
}  // namespace touchable::test
