// A speed is a way over the time that has passed, whether its ticks ran or were skipped.
#include <gtest/gtest.h>

#include <cmath>

#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/haptics/force_path.hpp"

namespace touchable::test {
namespace {

using glm::dvec3;

const double pi = std::acos(-1.0);

/// What a low pass of first order at 80 Hz lets through of a step after so many milliseconds.
double step_response(int milliseconds) {
    return 1 - std::exp(-2 * pi * 80 * 0.001 * milliseconds);
}

TEST(TickVelocity, IsALowPassOfFirstOrderAt80Hz) {
    double speed = 0;
    for (int tick = 1; tick <= 40; ++tick) {
        speed = filtered_velocity(speed, 0.002, 1);  // 2 m/s
        EXPECT_NEAR(speed, 2 * step_response(tick), 4e-4) << tick;
    }
}

TEST(TickVelocity, TicksThatWereSkippedCountLikeTicksThatMovedEvenly) {
    for (const int ticks : {1, 2, 3, 10, 33, 99, 100, 101, 5000}) {
        double one_by_one = 0.7;
        for (int tick = 0; tick < ticks; ++tick) one_by_one = filtered_velocity(one_by_one, -0.00013, 1);
        EXPECT_NEAR(filtered_velocity(0.7, -0.00013 * ticks, ticks), one_by_one, 1e-14) << ticks;
    }
    const dvec3 rested = filtered_velocity(dvec3(0.5, 0, -1), dvec3(0.0), longest_ticks);
    EXPECT_LT(length(rested), 1e-20);
}

TEST(SkippedTicks, ADamperFeelsTheSpeedOfTheHand) {
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    TouchSettings touch;
    touch.metres_per_scene_unit = 0.001;
    const TouchSolver solver = TouchSolver::create(wall.scene, touch).value();
    GuardSettings settings = without_ramp();
    settings.damping = 10;
    settings.max_force = 1000;
    for (const int every : {1, 2, 10, 50}) {
        TouchStep step(solver, settings, 1);
        double damper = 0;
        for (int tick = 7; tick <= 307; tick += every) {
            step.goals()[0] = {0, 0, -99 - 0.2 * (tick - 7)};  // 0.2 m/s
            const TouchTick done = step.run(tick, tick * 1'000'000LL, wall.scene, wall.pair());
            damper = done.forces[0].force.z - done.contacts[0].force.z;
            EXPECT_EQ(done.contacts[0].ticks, tick == 7 ? 1 : every);
            EXPECT_LT(damper, 10 * 0.2 * (1 + 1e-9));
        }
        EXPECT_NEAR(damper, 10 * 0.2, 1e-6) << every;
    }
}

TEST(SkippedTicks, ACountThatBeginsAnewHasNoTickBefore) {
    SmallField wall(33, 33, 100.0);
    const TouchSolver solver = TouchSolver::create(wall.scene, {}).value();
    TouchStep step(solver, {}, 1);
    step.goals()[0] = {0, 0, -99};
    const auto ticks = [&](std::int64_t tick) {
        return step.run(tick, 0, wall.scene, wall.pair()).contacts[0].ticks;
    };
    EXPECT_EQ(ticks(500), 1);
    EXPECT_EQ(ticks(503), 3);
    EXPECT_EQ(ticks(503), 1);
    EXPECT_EQ(ticks(0), 1);
    EXPECT_EQ(ticks(std::int64_t{1} << 60), longest_ticks);
}

/// A proxy that is dragged over a wall at 0.2 m/s; friction at that speed is the formula's.
class SkippedTicksSliding : public testing::Test {
protected:
    SkippedTicksSliding() : wall(129, 33, 100.0, DepthSemantics::planar) {
        wall.scene.default_properties = {1000, 0.5, 0.3};
        settings.stribeck_speed = 0.2;
        wall.touch(finger, {-10, 0.1, -99}, 0, settings);
    }
    /// How far the proxy lags behind its goal, 1 mm deep, at tick k; `ticks` after the one before.
    double lag(int k, int ticks) {
        const double x = -10 + 0.2 * k;
        return x - wall.touch(finger, {x, 0.1, -101}, 0, settings, ticks).proxy.x;
    }
    static constexpr double mu = 0.3 + (0.5 - 0.3) / (1 + 1);  // at v = v_s

    SmallField wall;
    TouchSettings settings;
    FingerState finger;
};

TEST_F(SkippedTicksSliding, FrictionIsThatOfTheSpeed) {
    double last = 0;
    for (int k = 0; k <= 100; k += 10) last = lag(k, 10);
    EXPECT_NEAR(last, mu, 1e-3);
    EXPECT_NEAR(finger.slip_speed, 0.2, 1e-3);
}

TEST_F(SkippedTicksSliding, AGoalThatIsHeldForAWhileIsNoHaste) {
    for (int k = 0; k <= 50; ++k) lag(k, 1);
    const double speed = finger.slip_speed;
    ASSERT_NEAR(speed, 0.2, 1e-6);
    for (int k = 51; k < 60; ++k) wall.touch(finger, {NAN, 0, 0}, 0, settings);
    EXPECT_EQ(finger.slip_speed, speed);
    EXPECT_NEAR(lag(60, 1), mu, 1e-6);
    EXPECT_NEAR(finger.slip_speed, 0.2, 1e-6);
}

}  // namespace
}  // namespace touchable::test
