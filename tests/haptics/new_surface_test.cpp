// A finger that is inside a surface when the surface is new to it: at the start, in another clip, after an
// outage.
#include <gtest/gtest.h>

#include <cmath>

#include "haptics_cpu/touch_step.hpp"
#include "tests/haptics/force_path.hpp"

namespace touchable::test {
namespace {

/// A finger over a wall at 100 mm, 1 N/mm; `depth` mm under it, above it where that is below 0.
class NewSurface : public testing::Test {
protected:
    NewSurface() : wall(33, 33, 100.0, DepthSemantics::planar) {
        settings.metres_per_scene_unit = 0.001;
        guard.waits_to_be_free = true;
        guard.ramp_in_ticks = 0;
    }
    void begin() {
        solver.emplace(TouchSolver::create(wall.scene, settings).value());
        step.emplace(*solver, guard, 1);
    }
    double press(double depth, double x = 0) { return give({x, 0, -100 - depth}); }
    double without_goal() { return give({0, 0, NAN}); }
    /// The largest change of force from tick to tick while a finger rests there, and the force in the end.
    std::pair<double, double> rest(double depth, int ticks, double last) {
        double most = 0;
        for (int k = 0; k < ticks; ++k) {
            const double force = press(depth);
            most = std::max(most, std::abs(force - last));
            last = force;
        }
        return {most, last};
    }

    SmallField wall;
    TouchSettings settings;
    GuardSettings guard;
    std::uint32_t reasons = 0;
    Contact contact;
    bool behind = false;
    std::optional<TouchSolver> solver;
    std::optional<TouchStep> step;

private:
    double give(const glm::dvec3& goal) {
        step->goals()[0] = goal;
        const TouchTick done = step->run(tick_, tick_ * 1'000'000, wall.scene, wall.pair());
        ++tick_;
        reasons = done.forces[0].reasons;
        contact = done.contacts[0];
        behind = done.behind;
        return done.forces[0].force.z;
    }
    std::int64_t tick_ = 0;
};

constexpr double steepest = 1.5 / JumpCancellation::fade_ticks;  // of a fade, per tick

TEST_F(NewSurface, GivesNoForceToAFingerInsideUntilItHasBeenFree) {
    begin();
    for (int k = 0; k < 300; ++k) {
        ASSERT_EQ(press(5 - 0.01 * k), 0) << k;
        ASSERT_EQ(reasons, std::uint32_t{guard_jump | guard_waiting});
    }
    // Goals that are none set nobody free.
    for (int k = 0; k < 10; ++k) without_goal();
    EXPECT_EQ(press(2), 0);
    EXPECT_EQ(press(-0.5), 0);
    EXPECT_NEAR(press(2), 2, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(NewSurface, IsFeltAtOnceByAFingerThatWasFree) {
    begin();
    press(-1);
    EXPECT_NEAR(press(3), 3, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(NewSurface, IsFeltFromTheStartByWhoWantsThat) {
    guard.waits_to_be_free = false;
    begin();
    EXPECT_NEAR(press(5), 5, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(NewSurface, ANewSurfaceFadesTheForceOfAFingerInside) {
    begin();
    press(-1);
    const double before = press(4);
    step->meet_new_surface();
    wall.fill(wall.prev, 98.0);
    const auto [most, force] = rest(4, 150, before);  // 6 mm deep now
    EXPECT_LE(most, before * steepest * (1 + 1e-9));
    EXPECT_EQ(force, 0);
    EXPECT_EQ(press(0), 0) << "2 mm deep still";
    press(-2.5);
    EXPECT_NEAR(press(4), 6, 1e-9);
}

TEST_F(NewSurface, ANewSurfaceComesOnAsAfterAJumpWhereNothingWaits) {
    guard.waits_to_be_free = false;
    begin();
    press(-1);
    const double before = press(4);
    step->meet_new_surface();
    wall.fill(wall.prev, 98.0);
    const auto [most, force] = rest(4, 150, before);
    EXPECT_LE(most, 2 * steepest * (1 + 1e-9));
    EXPECT_NEAR(force, 6, 1e-9);
}

TEST_F(NewSurface, ANewSurfaceIsNothingToAFreeFinger) {
    begin();
    press(-1);
    step->meet_new_surface();
    press(-1);
    EXPECT_NEAR(press(2), 2, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(NewSurface, WhoComesBackAfterAnOutageWaitsAndAfterABadSampleDoesNot) {
    guard.ramp_out_ticks = 20;
    begin();
    press(-1);
    press(4);
    without_goal();
    EXPECT_NEAR(press(4), 4, 1e-9);
    EXPECT_NEAR(rest(4, 150, 4).second, 4, 1e-9) << "for good";
    for (int k = 0; k < 20; ++k) without_goal();
    for (int k = 0; k < 50; ++k) ASSERT_EQ(press(4), 0);
    EXPECT_NE(reasons & guard_waiting, 0U);
    press(-0.1);
    EXPECT_NEAR(press(4), 4, 1e-9);
}

// Where it was is not forgotten; but nobody is there whom a surface could come by.
TEST_F(NewSurface, AHandThatHasLetGoIsWhereItWasLastAndNotBehindASurfaceThatPasses) {
    guard.ramp_out_ticks = 20;
    begin();
    press(-1);
    for (int k = 0; k < 30; ++k) without_goal();
    wall.fill(wall.prev, 90.0);
    without_goal();
    EXPECT_EQ(contact.goal, glm::dvec3(0, 0, -99));
    EXPECT_FALSE(contact.touching);
    EXPECT_FALSE(behind);
}

// Friction holds the proxy at 0 while the goal goes to 3 mm beside it.
TEST_F(NewSurface, BeginsWhereTheGoalIsAndAnOutageWhereNobodyWaitsIsNoBeginning) {
    wall.scene.default_properties = {1000, 5, 5};
    guard.waits_to_be_free = false;
    guard.ramp_out_ticks = 20;
    begin();
    press(-1);
    press(2);
    press(2, 3);
    ASSERT_NEAR(contact.proxy.x, 0, 1e-9);
    for (int k = 0; k < 30; ++k) without_goal();
    press(2, 3);
    EXPECT_NEAR(contact.proxy.x, 0, 1e-9) << "it is where it was left";
    step->meet_new_surface();
    press(2, 3);
    EXPECT_NEAR(contact.proxy.x, 3, 0.1) << "on the goal's ray";
}

TEST_F(NewSurface, WhoComesBackAfterAnOutageInTheAirIsFree) {
    guard.ramp_out_ticks = 20;
    begin();
    press(4);
    for (int k = 0; k < 30; ++k) without_goal();
    EXPECT_EQ(press(-1), 0);
    EXPECT_NEAR(press(4), 4, 1e-9);
}

TEST_F(NewSurface, AHandThatWasLeftAloneInsideHasNoForceUntilItHasBeenFree) {
    begin();
    press(-1);
    press(4);
    step->come_back();
    EXPECT_EQ(press(7), 0) << "at once, and not after a fade: nobody knows whose hand it is";
    EXPECT_EQ(reasons, std::uint32_t{guard_jump | guard_waiting | guard_gap});
    for (int k = 0; k < 300; ++k) {
        ASSERT_EQ(press(7 - 0.02 * k), 0) << k;
        ASSERT_EQ(reasons & (guard_waiting | guard_gap), std::uint32_t{guard_waiting}) << k;
    }
    press(-0.1);
    EXPECT_NEAR(press(4), 4, 1e-9);
}

TEST_F(NewSurface, AHandThatWentInsideWhileItWasLeftAloneHasNoForceEither) {
    begin();
    press(-20);
    step->come_back();
    for (int k = 0; k < 300; ++k) ASSERT_EQ(press(5), 0) << k;
    press(-0.1);
    EXPECT_NEAR(press(4), 4, 1e-9);
}

TEST_F(NewSurface, AHandThatWasLeftAloneInTheAirIsFree) {
    begin();
    press(4);
    step->come_back();
    EXPECT_EQ(press(-3), 0);
    EXPECT_NEAR(press(4), 4, 1e-9);
}

TEST_F(NewSurface, AHandWithoutAPlaceAfterItWasLeftAloneIsNotFree) {
    begin();
    press(-1);
    press(4);
    step->come_back();
    for (int k = 0; k < 5; ++k) EXPECT_EQ(without_goal(), 0) << "nothing is left to ramp out";
    for (int k = 0; k < 300; ++k) ASSERT_EQ(press(4), 0) << k;
}

TEST_F(NewSurface, AHandThatWasLeftAloneFeelsItRampInWhereNothingWaits) {
    guard.waits_to_be_free = false;
    guard.ramp_in_ticks = 100;
    begin();
    press(-1);
    rest(4, 200, 0);
    step->come_back();
    EXPECT_EQ(press(4), 0);
    const auto [most, force] = rest(4, 150, 0);
    EXPECT_LE(most, 4 * 0.01 * (1 + 1e-9));
    EXPECT_NEAR(force, 4, 1e-9);
}

TEST_F(NewSurface, ADamperTakesAHandThatWasLeftAloneForNoHaste) {
    guard.waits_to_be_free = false;
    guard.damping = 10;
    begin();
    press(-1);
    press(1);
    step->come_back();
    // 3 mm farther: in one tick that would be 3 m/s, and 12 N.
    EXPECT_NEAR(press(4), 4, 10 * 0.04);
}

}  // namespace
}  // namespace touchable::test
