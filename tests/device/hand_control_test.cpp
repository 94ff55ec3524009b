// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <array>
#include <cmath>
#include <limits>

#include "device/hand.hpp"
#include "device/haptic_device.hpp"
#include "device/point_motion.hpp"
#include "tests/device/fake_driver.hpp"
#include "tests/limits.hpp"

namespace touchable::test {
namespace {

constexpr double nowhere = std::numeric_limits<double>::quiet_NaN();

class Control : public testing::Test {
protected:
    glm::dvec3 goal(const glm::dvec3& place, std::uint32_t buttons = 0) {
        glm::dvec3 out = place;
        control.to_goals(std::span(&out, 1), buttons);
        return out;
    }
    glm::dvec3 felt(const glm::dvec3& guarded, int ticks = 1) {
        glm::dvec3 out;
        control.to_device(std::span(&guarded, 1), ticks, std::span(&out, 1));
        return out;
    }
    /// Asks for forces, and ticks until they have risen.
    void ask() {
        control.ask_force(true);
        felt({0, 0, 0});
        for (int tick = 0; tick < HandControl::rise_ticks; ++tick) felt({0, 0, 1});
        ASSERT_EQ(felt({0, 0, 1}), glm::dvec3(0, 0, 1));
    }

    // 1 mm of the device is 10 units of the scene.
    HandControl control{1, {Workspace{1e-4, {0, 0, -500}}, glm::dmat3(1)}};
};

TEST_F(Control, MapsPositionsBySimilarity) {
    const glm::dvec3 at = goal({0.001, -0.002, 0.003});
    EXPECT_NEAR(at.x, 10, 1e-9);
    EXPECT_NEAR(at.y, -20, 1e-9);
    EXPECT_NEAR(at.z, -470, 1e-9);
    EXPECT_TRUE(std::isnan(goal({0, nowhere, 0}).y));
}

TEST_F(Control, RotatesForcesIntoDeviceAxes) {
    // The device's x is the person's y, its y is the person's -x.
    control.set_mapping({Workspace{1, {0, 0, 0}}, glm::dmat3(0, 1, 0, -1, 0, 0, 0, 0, 1)});
    EXPECT_EQ(goal({0.1, 0, 0}), glm::dvec3(0, 0.1, 0));
    ask();
    EXPECT_EQ(felt({0, 3, 0}), glm::dvec3(3, 0, 0));
}

TEST_F(Control, ForcesAreOffUntilRequested) {
    goal({0, 0, 0});
    for (int tick = 0; tick < 1000; ++tick) EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0));
    EXPECT_FALSE(control.exerts());
}

TEST_F(Control, ForceWaitsForFreeFinger) {
    control.ask_force(true);
    for (int tick = 0; tick < 1000; ++tick) EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0));
    felt({0, 0, 0});
    double before = 0;
    for (int tick = 0; tick < HandControl::rise_ticks; ++tick) {
        const double now = felt({0, 0, 5}).z;
        EXPECT_LE(now - before, 5.0 / HandControl::rise_ticks + 1e-12);
        before = now;
    }
    EXPECT_EQ(before, 5);
}

TEST_F(Control, SkippedTicksDoNotSteepenRamp) {
    control.ask_force(true);
    felt({0, 0, 0});
    for (int called = 1; called <= HandControl::rise_ticks; ++called)
        ASSERT_NEAR(felt({0, 0, 1}, 1 + called % 50).z, called / double{HandControl::rise_ticks}, 1e-12);
}

TEST_F(Control, SwitchingOffIsImmediate) {
    ask();
    control.ask_force(false);
    EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0));
    control.ask_force(true);
    EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0)) << "it begins anew";
}

TEST_F(Control, IgnoresFreeFingerBeforeRequest) {
    goal({0, 0, 0});
    for (int tick = 0; tick < 10; ++tick) felt({0, 0, 0});
    control.ask_force(true);
    for (int tick = 0; tick < 1000; ++tick) EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0));
}

TEST_F(Control, ReportsWaitAndForceTime) {
    goal({0, 0, 0});
    felt({0, 0, 5});
    EXPECT_FALSE(control.waits_to_be_free()) << "no request yet";
    EXPECT_EQ(control.figures().exerting, 0);
    control.ask_force(true);
    felt({0, 0, 5});
    EXPECT_TRUE(control.waits_to_be_free());
    goal({nowhere, nowhere, nowhere});
    felt({0, 0, 5});
    EXPECT_FALSE(control.waits_to_be_free()) << "there is none";
    goal({0, 0, 0});
    felt({0, 0, 0});
    EXPECT_FALSE(control.waits_to_be_free());
    EXPECT_EQ(control.share(0), 0);
    for (int tick = 0; tick < HandControl::rise_ticks / 2; ++tick) felt({0, 0, 5});
    EXPECT_EQ(control.share(0), 0.5);
    EXPECT_EQ(control.figures().exerting, 3 + HandControl::rise_ticks / 2);
    EXPECT_EQ(control.figures().ticks, 3);
    EXPECT_EQ(control.figures().placeless, 1);
}

TEST_F(Control, StopButtonOverridesFirstButton) {
    goal({0, 0, 0}, 0);
    goal({0, 0, 0}, 3);
    EXPECT_FALSE(control.force_is_asked());
    goal({0, 0, 0}, 2);
    goal({0, 0, 0}, 3);
    EXPECT_FALSE(control.force_is_asked());
}

TEST_F(Control, ButtonsRequestHoldAndStop) {
    goal({0, 0, 0}, 1);
    EXPECT_FALSE(control.force_is_asked()) << "pressed before it was heard: no request";
    goal({0, 0, 0}, 0);
    goal({0, 0, 0}, 1);
    EXPECT_TRUE(control.force_is_asked());
    goal({0.001, 0, 0}, 1);
    EXPECT_NEAR(goal({0.001, 0, 0}, 1).x, 10, 1e-9) << "it moves on: the press was for the force";
    goal({0.001, 0, 0}, 0);
    ask();
    const glm::dvec3 held = goal({0.001, 0, 0}, 1);
    EXPECT_EQ(goal({0.009, 0.002, 0}, 1), held) << "the clutch";
    EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0)) << "nothing is felt meanwhile";
    EXPECT_NEAR(glm::length(goal({0.009, 0.002, 0}, 0) - held), 0, 1e-9) << "it goes on where it was";
    EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0)) << "and begins anew";
    EXPECT_NEAR(goal({0.008, 0.002, 0}, 0).x, held.x - 10, 1e-9);
    goal({0, 0, 0}, 2);
    EXPECT_FALSE(control.force_is_asked());
}

TEST_F(Control, IgnoresPressDuringGap) {
    goal({0, 0, 0}, 0);
    goal({0, 0, nowhere}, 0);
    goal({0, 0, 0}, 1);
    EXPECT_FALSE(control.force_is_asked());
}

TEST_F(Control, StopButtonWorksWithoutPosition) {
    ask();
    goal({0, nowhere, 0}, 2);
    EXPECT_FALSE(control.force_is_asked());
}

// After a second, unless forces are insisted on.
TEST_F(Control, MissingHandSwitchesForcesOff) {
    ask();
    for (int tick = 0; tick < 1000; ++tick) goal({0, nowhere, 0});
    EXPECT_TRUE(control.force_is_asked());
    goal({0, nowhere, 0});
    EXPECT_FALSE(control.force_is_asked());
    control.insist_on_force();
    ask();
    for (int tick = 0; tick < 3000; ++tick) goal({0, nowhere, 0});
    EXPECT_TRUE(control.force_is_asked());
}

TEST_F(Control, ReturningHandMustBeFree) {
    ask();
    goal({0, 0, 0});
    control.come_back(101);
    for (int tick = 0; tick < 1000; ++tick) EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0));
    felt({0, 0, 0});
    EXPECT_NEAR(felt({0, 0, 3}).z, 3.0 / HandControl::rise_ticks, 1e-12) << "and then it rises";
    EXPECT_TRUE(control.force_is_asked());
}

// After a second, unless forces are insisted on.
TEST_F(Control, LongAbsenceSwitchesForcesOff) {
    ask();
    control.come_back(HandControl::longest_away_ticks);
    EXPECT_TRUE(control.force_is_asked());
    control.come_back(HandControl::longest_away_ticks + 1);
    EXPECT_FALSE(control.force_is_asked());
    control.insist_on_force();
    ask();
    control.come_back(10'000);
    EXPECT_TRUE(control.force_is_asked());
}

TEST_F(Control, LostFingerMustBeFree) {
    for (const int skipped : {1, 5}) {
        for (const int placeless : {HandControl::away_ticks - skipped, int{HandControl::away_ticks}}) {
            goal({0, 0, 0});
            ask();
            for (int ticks = 0; ticks < placeless; ticks += skipped) {
                goal({0, nowhere, 0});
                felt({0, 0, 5}, skipped);
            }
            goal({0, 0, 0});
            const bool is_short = placeless < HandControl::away_ticks;
            EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0, 0, is_short ? 5 : 0)) << placeless;
            EXPECT_EQ(control.waits_to_be_free(), !is_short) << placeless;
            for (int tick = 0; tick < 1000; ++tick) {
                goal({0, 0, 0});
                ASSERT_EQ(felt({0, 0, 5}), glm::dvec3(0, 0, is_short ? 5 : 0)) << placeless;
            }
            felt({0, 0, 0});
            EXPECT_GT(felt({0, 0, 5}).z, 0) << placeless;
        }
    }
}

TEST(ControlOfTwo, OnlyLostFingerWaits) {
    HandControl control(2, {Workspace{1e-4, {0, 0, -500}}, glm::dmat3(1)});
    control.ask_force(true);
    const auto felt = [&](double one_place, double force) {
        std::array<glm::dvec3, 2> places{glm::dvec3(one_place), glm::dvec3(0)}, newtons{};
        control.to_goals(places, 0);
        const std::array<glm::dvec3, 2> guarded{glm::dvec3(0, 0, force), glm::dvec3(0, 0, force)};
        control.to_device(guarded, 1, newtons);
        return newtons;
    };
    felt(0, 0);
    for (int tick = 0; tick < HandControl::rise_ticks; ++tick) felt(0, 1);
    for (int tick = 0; tick < HandControl::away_ticks; ++tick) felt(nowhere, 1);
    const auto newtons = felt(0, 1);
    EXPECT_EQ(newtons[0].z, 0);
    EXPECT_EQ(newtons[1].z, 1);
}

TEST_F(Control, IgnoresPressDuringAbsence) {
    goal({0, 0, 0}, 0);
    control.come_back(HandControl::longest_away_ticks + 1);
    goal({0, 0, 0}, 1);
    EXPECT_FALSE(control.force_is_asked());
    goal({0, 0, 0}, 0);
    goal({0, 0, 0}, 1);
    EXPECT_TRUE(control.force_is_asked()) << "pressed anew";
}

TEST_F(Control, ClutchHoldsThroughGap) {
    goal({0, 0, 0}, 0);
    ask();
    const glm::dvec3 held = goal({0.001, 0, 0}, 1);
    goal({0.001, nowhere, 0}, 0);
    EXPECT_EQ(goal({0.005, 0, 0}, 1), held);
}

TEST_F(Control, ReleaseDuringAbsenceKeepsFinger) {
    control.hold(true);
    const glm::dvec3 held = goal({0.001, 0, 0});
    goal({0.002, 0, 0});
    control.hold(false);
    goal({nowhere, nowhere, nowhere});
    EXPECT_NEAR(glm::length(goal({0.009, 0, 0}) - held), 0, 1e-9);
    EXPECT_NEAR(goal({0.008, 0, 0}).x, held.x - 10, 1e-9);
}

TEST(ControlOfTwo, ClutchIgnoresLostFingers) {
    HandControl control(2, {Workspace{1e-4, {0, 0, -500}}, glm::dmat3(1)});
    const auto goals = [&](const glm::dvec3& one, const glm::dvec3& other) {
        std::array<glm::dvec3, 2> places{one, other};
        control.to_goals(places, 0);
        return places;
    };
    const glm::dvec3 lost(nowhere);
    const auto before = goals({0, 0, 0}, {0.04, 0, 0});
    control.hold(true);
    EXPECT_EQ(goals({0, 0, 0}, {0.04, 0, 0}), before);
    EXPECT_EQ(goals({0.01, 0, 0}, {0.05, 0, 0}), before);
    EXPECT_EQ(goals({0.02, 0, 0}, lost)[0], before[0]);
    control.hold(false);
    EXPECT_NEAR(glm::length(goals({0.02, 0, 0}, lost)[0] - before[0]), 0, 1e-9) << "it was not moved by half";
    control.hold(true);
    goals({0.02, 0, 0}, lost);
    EXPECT_NEAR(glm::length(goals({0.03, 0, 0}, {0.07, 0, 0})[1] - before[1]), 0, 1e-9)
        << "where it would be";
    control.hold(false);
    const auto after = goals({0.03, 0, 0}, {0.07, 0, 0});
    EXPECT_NEAR(glm::length(after[0] - before[0]), 0, 1e-9);
    EXPECT_NEAR(glm::length(after[1] - before[1]), 0, 1e-9);
}

// Force returns only to a finger that has been free, and one that is let go of inside would stay there.
TEST_F(Control, ReleasingClutchInsideRaisesFinger) {
    const FakeProbe wall = flat_view(520);  // 20 units, or 2 mm, behind the device's middle
    const auto put = [&](const glm::dvec3& place) {
        glm::dvec3 out = place;
        control.to_goals(std::span(&out, 1), 0, &wall);
        return out;
    };
    put({0.001, 0, 0});
    ask();
    EXPECT_NEAR(put({0.001, 0, -0.006}).z, -560, 1e-9) << "it presses";
    control.hold(true);
    const glm::dvec3 held = put({0.001, 0, -0.006});
    EXPECT_EQ(put({0.001, 0, 0.03}), held) << "it stays while the hand goes back";
    control.hold(false);
    const glm::dvec3 out = put({0.001, 0, 0.03});
    EXPECT_NEAR(out.z, -510, 1e-9) << "a millimetre before the surface";
    const glm::dvec3 pixel = wall.project(out), pixel_before = wall.project(held);
    EXPECT_NEAR(pixel.x, pixel_before.x, 1e-9) << "where it was seen";
    EXPECT_NEAR(put({0.001, 0, 0.028}).z, -530, 1e-9) << "and what it presses now is felt";
    felt({0, 0, 0});
    for (int tick = 0; tick < HandControl::rise_ticks; ++tick) felt({0, 0, 2});
    EXPECT_EQ(felt({0, 0, 2}), glm::dvec3(0, 0, 2));
}

TEST_F(Control, ReleasingClutchOutsideMovesNothing) {
    const FakeProbe wall = flat_view(520), holes = camera_view([](double, double) { return std::nullopt; });
    for (const FakeProbe* surface : {&wall, &holes}) {
        const auto put = [&](const glm::dvec3& place) {
            glm::dvec3 out = place;
            control.to_goals(std::span(&out, 1), 0, surface);
            return out;
        };
        control.hold(true);
        const glm::dvec3 held = put({0, 0, -0.0019});
        put({0, 0, 0.01});
        control.hold(false);
        EXPECT_NEAR(glm::length(put({0, 0, 0.01}) - held), 0, 1e-9);
        put({0, 0, -0.0019});
    }
}

// There is no pixel there to come out along, however near the surface is to the camera.
TEST_F(Control, StaysBehindTheCamera) {
    const FakeProbe wall = flat_view(0.5);
    const auto put = [&] {
        glm::dvec3 out(0, 0, 0.06);
        control.to_goals(std::span(&out, 1), 0, &wall);
        return out;
    };
    control.hold(true);
    const glm::dvec3 held = put();
    ASSERT_GT(held.z, 0);
    control.hold(false);
    EXPECT_EQ(put(), held);
}

TEST(ControlOfTwo, BothFingersRiseTogether) {
    HandControl control(2, {Workspace{1e-4, {0, 0, -500}}, glm::dmat3(1)});
    const FakeProbe step =
        camera_view([](double x, double) { return std::optional(x < 320 ? 560.0 : 530.0); });
    std::array<glm::dvec3, 2> places{};
    const auto put = [&](double x0, double z0, double x1, double z1) {
        places = {glm::dvec3(x0, 0, z0), glm::dvec3(x1, 0, z1)};
        control.to_goals(places, 0, &step);
    };
    control.hold(true);
    put(-0.02, -0.008, 0.02, -0.008);  // 20 mm to each side; 2 mm inside, and 5
    put(-0.02, 0.01, 0.02, 0.01);
    control.hold(false);
    put(-0.02, 0.01, 0.02, 0.01);
    for (const glm::dvec3& place : places) {
        const glm::dvec3 at = step.project(place);
        EXPECT_LT(at.z, *step.depth_under(at.x, at.y));
    }
    EXPECT_NEAR(glm::length(places[1] - places[0]), 400, 1e-9) << "as far apart as the hand holds them";
}

// Each finger that comes out pushes the other into the wall, a little less each time: all rounds are needed.
TEST(ControlOfTwo, BothLeaveFunnel) {
    HandControl control(2, {Workspace{1e-3, {0, 0, -500}}, glm::dmat3(1)});
    const FakeProbe funnel =
        camera_view([](double x, double) { return std::optional(827.5 - 3.4 * std::abs(x - 320)); });
    std::array<glm::dvec3, 2> places{};
    for (const bool is_held : {true, false}) {
        control.hold(is_held);
        places = {glm::dvec3(-0.1, 0, 0), glm::dvec3(0.1, 0, 0)};
        control.to_goals(places, 0, &funnel);
    }
    for (const glm::dvec3& place : places) {
        const glm::dvec3 at = funnel.project(place);
        EXPECT_LT(at.z, *funnel.depth_under(at.x, at.y));
    }
}

TEST_F(Control, RecentringMovesHandWithoutForce) {
    ask();
    goal({0.03, 0.01, -0.02});
    control.recentre();
    EXPECT_NEAR(glm::length(goal({0.03, 0.01, -0.02}) - glm::dvec3(0, 0, -500)), 0, 1e-9);
    EXPECT_EQ(felt({0, 0, 5}), glm::dvec3(0));
}

TEST_F(Control, ResetRestoresInitialState) {
    const glm::dvec3 there(0.05, 0.01, 0), before = goal(there);
    control.recentre();
    EXPECT_NE(goal(there), before);
    control.ask_force(true);
    control.hold(true);
    EXPECT_EQ(goal(there), goal({0.02, 0, 0})) << "the clutch is held";
    goal({0.02, 0, 0});
    control.begin_anew();
    EXPECT_EQ(goal(there), before);
    EXPECT_EQ(goal({0.02, 0, 0}), glm::dvec3(200, 0, -500)) << "the clutch is let go of";
    EXPECT_FALSE(control.force_is_asked());
    EXPECT_EQ(felt({0, 0, 1}), glm::dvec3(0));
}

TEST_F(Control, RecentringAwaitsHandAndClutch) {
    const glm::dvec3 middle(0, 0, -500);
    control.recentre();
    goal({nowhere, nowhere, nowhere});
    EXPECT_NEAR(glm::length(goal({0.03, 0.01, -0.02}) - middle), 0, 1e-9) << "once it came";
    control.hold(true);
    const glm::dvec3 held = goal({0.04, 0.01, -0.02});
    control.recentre();
    EXPECT_EQ(goal({0.06, 0.01, 0}), held);
    control.hold(false);
    EXPECT_NEAR(glm::length(goal({0.06, 0.01, 0}) - middle), 0, 1e-9) << "once it was released";
}

TEST_F(Control, KeyActsAsClutch) {
    control.hold(true);
    const glm::dvec3 held = goal({0.005, 0, 0});
    EXPECT_EQ(goal({0.009, 0, 0}), held);
    control.hold(false);
    EXPECT_NEAR(goal({0.009, 0, 0}).x, held.x, 1e-9);
    EXPECT_NEAR(goal({0.010, 0, 0}).x, held.x + 10, 1e-9);
}

TEST_F(Control, ScaleChangeKeepsFingerPosition) {
    ask();
    goal({0.002, 0, 0});
    control.recentre();
    goal({0.002, 0, 0});
    const glm::dvec3 before = goal({0.005, 0, 0});  // 3 mm from the middle: 30 units
    EXPECT_NEAR(before.x, 30, 1e-9);
    HandControl finer(1, {Workspace{2e-4, {0, 0, -500}}, glm::dmat3(1)});
    finer.go_on_from(control);
    EXPECT_TRUE(finer.force_is_asked());
    glm::dvec3 place(0.005, 0, 0);
    finer.to_goals(std::span(&place, 1), 0);
    EXPECT_NEAR(glm::length(place - before), 0, 1e-9);
    place = {0.006, 0, 0};
    finer.to_goals(std::span(&place, 1), 0);
    EXPECT_NEAR(place.x, 35, 1e-9) << "half as far for a millimetre";
    glm::dvec3 newtons(0, 0, 5);
    finer.to_device(std::span(&newtons, 1), 1, std::span(&newtons, 1));
    EXPECT_EQ(newtons, glm::dvec3(0)) << "it was not free yet";
}

TEST_F(Control, HandoverKeepsAbsentHand) {
    control.recentre();
    EXPECT_NEAR(goal({0.002, 0, 0}).x, 0, 1e-9);
    EXPECT_NEAR(goal({0, 0, 0}).x, -20, 1e-9);
    goal({nowhere, nowhere, nowhere});
    HandControl finer(1, {Workspace{2e-4, {0, 0, -500}}, glm::dmat3(1)});
    finer.go_on_from(control);
    glm::dvec3 place(0, 0, 0);
    finer.to_goals(std::span(&place, 1), 0);
    EXPECT_NEAR(glm::length(place - glm::dvec3(-20, 0, -500)), 0, 1e-9) << "where the device's middle was";
    control.recentre();  // not done before it comes
    HandControl next(1, control.mapping());
    next.go_on_from(control);
    place = {0.07, 0, 0};
    next.to_goals(std::span(&place, 1), 0);
    EXPECT_NEAR(glm::length(place - glm::dvec3(0, 0, -500)), 0, 1e-9);
}

TEST_F(Control, HandoverKeepsHeldClutch) {
    control.hold(true);
    const glm::dvec3 held = goal({0.005, 0, 0});
    goal({0.009, 0, 0});
    EXPECT_TRUE(control.is_repositioned());
    HandControl next(1, control.mapping());
    next.go_on_from(control);
    glm::dvec3 place(0.009, 0, 0);
    next.to_goals(std::span(&place, 1), 0);
    EXPECT_NEAR(glm::length(place - held), 0, 1e-9);
    place = {0.020, 0, 0};
    next.to_goals(std::span(&place, 1), 0);
    EXPECT_NEAR(glm::length(place - held), 0, 1e-9) << "the key is still down";
    next.hold(false);
    place = {0.020, 0, 0};
    next.to_goals(std::span(&place, 1), 0);
    EXPECT_NEAR(glm::length(place - held), 0, 1e-9);
    EXPECT_FALSE(next.is_repositioned());
}

TEST_F(Control, PassesNonFiniteForceOn) {
    ask();
    EXPECT_TRUE(std::isnan(felt({0, nowhere, 0}).y)) << "so that the device leaves itself unpowered";
}

const glm::dvec3 camera(0.01, 0, 0.14);
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

class Pointer : public ::testing::Test {
protected:
    using Places = std::array<glm::dvec3, 3>;

    void SetUp() override { ASSERT_TRUE(device.open()); }
    Places read() {
        Places places;
        EXPECT_TRUE(device.read_positions(places));
        return places;
    }
    Places read_for(int ticks) {
        for (int k = 1; k < ticks; ++k) read();
        return read();
    }
    bool push(double newtons = 2) {
        const Places forces{glm::dvec3(0, 0, newtons), glm::dvec3(1, 2, 0), glm::dvec3(0)};
        return device.write_forces(forces);
    }
    void intend(const std::vector<glm::dvec3>& places) { device.intend(places, camera); }

    PointerSettings settings{.limits = {.max_force = 8, .max_stiffness = 2000}};
    PointerDevice device{3, camera, settings};
};

TEST_F(Pointer, RefusesCallsWhileClosed) {
    ASSERT_TRUE(push());
    device.close();
    EXPECT_FALSE(push());
    Places places;
    EXPECT_FALSE(device.read_positions(places));
    ASSERT_TRUE(device.open());
    EXPECT_TRUE(push());
}

TEST_F(Pointer, RefusesCallsBeforeOpening) {
    PointerDevice closed(1, camera);
    const std::array force{glm::dvec3(1)};
    std::array<glm::dvec3, 1> place;
    EXPECT_FALSE(closed.write_forces(force));
    EXPECT_FALSE(closed.read_positions(place));
}

TEST_F(Pointer, InvalidForceStopsUntilReopened) {
    for (const double bad : {nan, std::numeric_limits<double>::infinity(), 1e300}) {
        ASSERT_TRUE(push());
        EXPECT_FALSE(push(bad));
        EXPECT_FALSE(push());
        Places places;
        EXPECT_FALSE(device.read_positions(places));
        ASSERT_FALSE(device.health());
        EXPECT_EQ(device.health().error().kind, ErrorKind::device);
        EXPECT_EQ(device.health().error().message,
                  "pointer was given a force that is not finite; open it again");
        ASSERT_TRUE(device.open());
        EXPECT_TRUE(device.health());
    }
}

TEST_F(Pointer, FingersStayAwayWithoutTarget) {
    EXPECT_EQ(read_for(3), (Places{camera, camera, camera}));
    const glm::dvec3 first(0.02, 0.01, -0.002), second(-0.03, 0, 0.01);
    intend({first, second});
    const Places there = read_for(2000);
    EXPECT_LT(glm::length(there[0] - first), 1e-6);
    EXPECT_LT(glm::length(there[1] - second), 1e-6);
    EXPECT_EQ(there[2], camera);
    intend({first});
    EXPECT_LT(glm::length(read_for(2000)[1] - camera), 1e-9);
    intend({});
    EXPECT_LT(glm::length(read_for(2000)[0] - camera), 1e-9);
}

TEST_F(Pointer, SingleFingerStartsWhereRequested) {
    const glm::dvec3 first(0.02, 0.01, -0.002), second(-0.03, 0, 0.01), near(0.02, 0.01, 0.006);
    intend({second, second});
    read_for(2000);
    device.withdraw(0);
    const Places gone = read_for(2000);
    EXPECT_LT(glm::length(gone[0] - camera), 1e-9);
    EXPECT_LT(glm::length(gone[1] - second), 1e-6) << "the other stays";
    device.intend(0, first, near, camera);
    glm::dvec3 before = read()[0];
    EXPECT_LT(glm::length(before - near), 0.001);
    for (int k = 0; k < 500; ++k) {
        device.intend(0, first, near, camera);  // with each picture
        const glm::dvec3 now = read()[0];
        EXPECT_LE(glm::length(now - before), settings.approach_speed * 1e-3 * (1 + 1e-12));
        before = now;
    }
    EXPECT_LT(glm::length(before - first), 1e-4);
    device.intend(0, {nan, 0, 0}, near, camera);
    device.intend(0, {1e9, 0, 0}, near, camera);
    EXPECT_LT(glm::length(read_for(100)[0] - first), 1e-4) << "an invalid place changes nothing";
    device.intend(2, first, glm::dvec3(nan), camera);
    EXPECT_LT(glm::length(read()[2] - camera), 0.001) << "it comes from where it is away";
    EXPECT_LT(glm::length(read_for(2000)[2] - first), 1e-6);
    device.set_force(false);
    EXPECT_EQ(read_for(100), (Places{camera, camera, camera}));
}

TEST_F(Pointer, ApproachesSlowlyAndLeavesQuickly) {
    const glm::dvec3 deep(0.04, -0.02, -0.01);
    intend({deep});
    glm::dvec3 before = read()[0];
    for (int k = 0; k < 2000; ++k) {
        const glm::dvec3 now = read()[0];
        EXPECT_LE(glm::length(now - before), settings.approach_speed * 1e-3 * (1 + 1e-12));
        before = now;
    }
    intend({});
    for (int k = 0; k < 60; ++k) {
        const glm::dvec3 now = read()[0];
        EXPECT_LT(glm::length(glm::cross(now - camera, glm::normalize(deep - camera))), 1e-7) << "its ray";
        EXPECT_LE(glm::length(now - before), settings.max_speed * 1e-3 * (1 + 1e-12));
        before = now;
    }
    EXPECT_GT(glm::length(before - deep), 0.02);
}

TEST_F(Pointer, ReturnsWithoutDetour) {
    const glm::dvec3 deep(0.04, -0.02, -0.01);
    intend({deep});
    read_for(2000);
    intend({});
    const glm::dvec3 left = read_for(60)[0];
    const double apart = glm::length(left - deep);
    ASSERT_GT(apart, 0.02);
    intend({left});
    for (int k = 0; k < 300; ++k) EXPECT_GT(glm::length(read()[0] - deep), apart - 0.001) << k;
}

TEST_F(Pointer, LimitsSpeedOfJump) {
    intend({{-0.08, 0, 0}});
    glm::dvec3 before = read_for(3000)[0];
    intend({{0.08, 0, -0.01}});
    double fastest = 0;
    for (int k = 0; k < 1000; ++k) {
        const glm::dvec3 now = read()[0];
        fastest = std::max(fastest, glm::length(now - before));
        before = now;
    }
    EXPECT_NEAR(fastest, settings.max_speed * 1e-3, 1e-12);
    EXPECT_LT(glm::length(before - glm::dvec3(0.08, 0, -0.01)), 1e-4);
}

TEST_F(Pointer, MovesSlowerAlongView) {
    const glm::dvec3 eye(0.3, 0, 0);  // it looks along -X
    device.intend(std::array{glm::dvec3(0)}, eye);
    read_for(3000);
    device.intend(std::array{glm::dvec3(0, 0.001, 0)}, eye);
    const double across = read_for(50)[0].y / 0.001;
    device.intend(std::array{glm::dvec3(0)}, eye);
    read_for(3000);
    device.intend(std::array{glm::dvec3(-0.001, 0, 0)}, eye);
    const double along = read_for(50)[0].x / -0.001;
    EXPECT_NEAR(across, 1 - (1 + 2.0) * std::exp(-2.0), 1e-5);
    EXPECT_NEAR(along, 1 - (1 + 50.0 / 90) * std::exp(-50.0 / 90), 1e-5);
}

/// Slopes and steps, which are higher than relief, are followed as quickly along the view as across.
TEST_F(Pointer, LeashLimitsLagAlongView) {
    const glm::dvec3 eye(0, 0, 0.3);
    for (const double way : {-0.02, 0.02}) {
        device.intend(std::array{glm::dvec3(0)}, eye);
        read_for(3000);
        device.intend(std::array{glm::dvec3(0, 0, way)}, eye);
        LedPoint quick({settings.across_s, settings.across_s}, 0.001);
        bool led = false;
        for (int k = 0; k < 400; ++k) {
            quick.follow({0, 0, way}, {0, 0, -1}, settings.max_speed);
            const double behind = std::abs(quick.place().z - read()[0].z);
            EXPECT_LE(behind, settings.leash + 1e-12) << k;
            led = led || behind > 0.99 * settings.leash;
        }
        EXPECT_TRUE(led) << "it is as quick itself";
    }
}

/// A moving goal is never reached exactly; the finger has arrived all the same, and is quick from then on.
TEST_F(Pointer, ArrivesAtRequestedDepth) {
    const glm::dvec3 eye(0, 0, 0.3);
    double x = -0.1;
    for (int k = 0; k < 1000; ++k, x += 1e-4) {  // 0.1 m/s
        if (k % 16 == 0) device.intend(std::array{glm::dvec3(x, 0, 0)}, eye);
        read();
    }
    device.intend(std::array{glm::dvec3(x, 0.1, 0)}, eye);
    glm::dvec3 before = read()[0];
    double fastest = 0;
    for (int k = 0; k < 200; ++k) {
        const glm::dvec3 now = read()[0];
        fastest = std::max(fastest, glm::length(now - before) / 1e-3);
        before = now;
    }
    EXPECT_GT(fastest, 2 * settings.approach_speed);
}

TEST_F(Pointer, StopsAtOnceReturnsSlowly) {
    const glm::dvec3 deep(0.02, 0, -0.005);
    intend({deep, deep, deep});
    read_for(2000);
    ASSERT_TRUE(push());
    device.set_force(false);
    EXPECT_FALSE(device.force_is_on());
    EXPECT_TRUE(push());
    for (int k = 0; k < 5; ++k) EXPECT_EQ(read(), (Places{camera, camera, camera}));
    intend({deep});
    EXPECT_EQ(read()[0], camera);
    device.set_force(true);
    glm::dvec3 before = camera;
    for (int k = 0; k < 3000; ++k) {
        const glm::dvec3 now = read()[0];
        EXPECT_LE(glm::length(now - before), settings.approach_speed * 1e-3 * (1 + 1e-12));
        before = now;
    }
    EXPECT_LT(glm::length(before - deep), 1e-6);
    EXPECT_TRUE(push());
}

TEST_F(Pointer, KeepsStopBetweenReadings) {
    intend({{0.02, 0, -0.005}});
    read_for(2000);
    ASSERT_TRUE(push());
    device.set_force(false);
    device.set_force(true);
    EXPECT_TRUE(push()) << "an answer to where the finger was";
    EXPECT_LT(glm::length(read()[0] - camera), 1e-3);
    device.set_force(true);
    EXPECT_TRUE(push());
}

TEST_F(Pointer, ReopeningStartsAway) {
    intend({{0.02, 0, -0.005}});
    read_for(2000);
    device.close();
    ASSERT_TRUE(device.open());
    EXPECT_LT(glm::length(read()[0] - camera), 1e-3);
}

TEST_F(Pointer, IgnoresInvalidTargets) {
    const glm::dvec3 place(0.02, 0, 0);
    intend({place, place});
    for (const double bad : {nan, std::numeric_limits<double>::infinity(), 1e200, 1001.0})
        intend({{0, bad, 0}, place, {bad, 0, 0}});
    device.intend(std::array{glm::dvec3(nan), place, glm::dvec3(nan)}, glm::dvec3(nan));
    const Places there = read_for(3000);
    EXPECT_LT(glm::length(there[0] - place), 1e-9);
    EXPECT_LT(glm::length(there[1] - place), 1e-9);
    EXPECT_EQ(there[2], camera);
    device.intend(std::array{camera}, camera);  // looked at from where it is
    EXPECT_LT(glm::length(read_for(3000)[0] - camera), 1e-9);
}

TEST_F(Pointer, TicksNeverAllocate) {
    intend({{0.02, 0, 0}});
    const Places forces{};
    Places places;
    const std::size_t before = allocations();
    for (int k = 0; k < 100; ++k) {
        device.read_positions(places);
        device.write_forces(forces);
        device.intend(places, camera);
    }
    EXPECT_EQ(allocations(), before);
}

}  // namespace
}  // namespace touchable::test
