// A live surface that nobody renews: it goes soft, lets go, and comes back without a step of force.
#include <gtest/gtest.h>

#include <cmath>

#include "haptics_cpu/touch_step.hpp"
#include "tests/haptics/force_path.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t stale_ticks = 250;
constexpr double for_rounding = 1 + 1e-9;

/// A finger that rests 4 mm under a wall at 100 mm, 1 N/mm. The newest frame is of `newest_tick`.
class OldSurface : public testing::Test {
protected:
    OldSurface() : wall(33, 33, 100.0, DepthSemantics::planar) {
        settings.metres_per_scene_unit = 0.001;
        guard.ramp_in_ticks = guard.ramp_out_ticks = 100;
        guard.stale_after_ns = stale_ticks * 1'000'000;
    }
    /// Past the first ramp.
    void begin() {
        solver.emplace(TouchSolver::create(wall.scene, settings).value());
        step.emplace(*solver, guard, 1);
        for (int k = 0; k < 200; ++k) fresh(-1);
        for (int k = 0; k < 200; ++k) fresh(4);
    }
    double fresh(double depth) {
        newest_tick = tick;
        return press(depth);
    }
    double press(double depth, int ticks = 1) {
        tick += ticks - 1;
        step->goals()[0] = {0, 0, -100 - depth};
        FramePair pair = wall.pair();
        pair.prev.time_ns = pair.next.time_ns = newest_tick * 1'000'000;
        const TouchTick done = step->run(tick, tick * 1'000'000, wall.scene, pair);
        ++tick;
        reasons = done.forces[0].reasons;
        change = std::abs(done.forces[0].force.z - force);
        force = done.forces[0].force.z;
        return force;
    }
    void become_stale() {
        while (tick - newest_tick <= stale_ticks) ASSERT_NEAR(press(4), 4, 1e-9) << tick - newest_tick;
    }
    void let_go() {
        become_stale();
        for (int k = 0; k < 100; ++k) press(4);
        ASSERT_EQ(force, 0);
    }

    SmallField wall;
    TouchSettings settings;
    GuardSettings guard;
    std::int64_t tick = 0, newest_tick = 0;
    std::uint32_t reasons = 0;
    double force = 0, change = 0;
    std::optional<TouchSolver> solver;
    std::optional<TouchStep> step;
};

TEST_F(OldSurface, LetsGoByTheRamp) {
    begin();
    become_stale();
    for (int k = 1; k <= 100; ++k) {
        ASSERT_NEAR(press(4), 4 - 0.04 * k, 1e-9) << k;
        ASSERT_EQ(reasons, std::uint32_t{guard_stale});
    }
    for (int k = 0; k < 1000; ++k) ASSERT_EQ(press(4 + 0.01 * k), 0) << k;
}

TEST_F(OldSurface, ComesBackByTheRamp) {
    begin();
    let_go();
    for (int k = 0; k < 300; ++k) {
        fresh(4);
        ASSERT_LE(change, 2 * 0.04 * for_rounding) << k;  // two ramps at once
    }
    EXPECT_NEAR(force, 4, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(OldSurface, TurnsBackWhereItIs) {
    begin();
    become_stale();
    for (int k = 0; k < 40; ++k) press(4);
    EXPECT_NEAR(force, 2.4, 1e-9);
    EXPECT_NEAR(fresh(4), 2.44, 1e-9);
    for (int k = 0; k < 39; ++k) fresh(4);
    EXPECT_NEAR(force, 4, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(OldSurface, ThatCameNearerComesOnWithoutAStep) {
    begin();
    let_go();
    wall.fill(wall.prev, 94.0);  // 10 mm deep now
    wall.fill(wall.next, 94.0);
    const double steepest = (1.5 / JumpCancellation::fade_ticks + 2 * 0.01) * 10;
    for (int k = 0; k < 400; ++k) {
        fresh(4);
        ASSERT_LE(change, steepest * for_rounding) << k;
    }
    EXPECT_NEAR(force, 10, 1e-9);
}

TEST_F(OldSurface, WaitsForAHandOnADeviceToBeFree) {
    guard.waits_to_be_free = true;
    begin();
    let_go();
    for (int k = 0; k < 300; ++k) ASSERT_EQ(fresh(4), 0) << k;
    EXPECT_NE(reasons & guard_waiting, 0U);
    fresh(-1);
    EXPECT_NEAR(fresh(4), 4, 1e-9);
}

TEST_F(OldSurface, GoesByTheTimeThatHasPassed) {
    begin();
    become_stale();
    press(4, 30);
    EXPECT_NEAR(force, 4 * 0.7, 1e-9);
}

TEST_F(OldSurface, GoalsThatAreMissingMeanwhileMakeNoStep) {
    for (const int held : {1, 2, 50}) {
        for (const bool rising : {false, true}) {
            tick = newest_tick = 0;
            begin();
            become_stale();
            for (int k = 0; k < 50; ++k) press(4);
            EXPECT_NEAR(force, 2, 1e-9);
            const auto go_on = [&](double depth) {
                if (rising) newest_tick = tick;
                press(depth);
                EXPECT_LE(change, 2 * 0.04 * for_rounding) << held << rising;
            };
            for (int k = 0; k < held; ++k) go_on(NAN);
            for (int k = 0; k < 200; ++k) go_on(4);
            EXPECT_NEAR(force, rising ? 4 : 0, 1e-9);
        }
    }
}

TEST_F(OldSurface, StaysWhereNobodyMindsItsAge) {
    guard.stale_after_ns = 0;
    begin();
    for (int k = 0; k < 2000; ++k) press(4);
    EXPECT_NEAR(force, 4, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

}  // namespace
}  // namespace touchable::test
