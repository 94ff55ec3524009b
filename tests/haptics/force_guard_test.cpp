// The guard between a solver and a hand.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>

#include "engine/base/same_bits.hpp"
#include "engine/content/seeded_noise.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/haptics/touch_rig.hpp"

namespace touchable::test {
namespace {

TEST(ForceGuard, LeavesSmallForceAlone) {
    ForceGuard guard(without_ramp(), 0.001);
    const GuardedForce out = guard.guard(pressing({0, 0, 3.25}));
    EXPECT_EQ(out.force, dvec3(0, 0, 3.25));
    EXPECT_EQ(out.reasons, guard_none);
}

TEST(ForceGuard, LimitsForceKeepingDirection) {
    ForceGuard guard(without_ramp(), 0.001);
    const GuardedForce out = guard.guard(pressing({30, 0, 40}));
    EXPECT_NEAR(out.force.x, 6, 1e-12);
    EXPECT_NEAR(out.force.z, 8, 1e-12);
    EXPECT_EQ(out.reasons, guard_force);
}

TEST(ForceGuard, LimitSurvivesRounding) {
    SplitMix64 random(5);
    int limited = 0;
    for (int k = 0; k < 100'000; ++k) {
        GuardSettings settings{.max_force = random.within(0.1, 20),
                               .max_stiffness = random.within(500, 1500),
                               .ramp_in_ticks = 0,
                               .rise = {}};
        ForceGuard guard(settings, 0.001);
        Contact contact = pressing(dvec3(0.0), random.within(500, 1500));
        const double most = k % 2 == 0 ? 40 : settings.max_force;  // far above the limit, and about it
        for (int axis = 0; axis < 3; ++axis) contact.force[axis] = random.within(-most, most);
        const GuardedForce out = guard.guard(contact);
        const dvec3& f = out.force;
        ASSERT_LE(std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z), settings.max_force);
        if ((out.reasons & guard_force) == 0) continue;
        ++limited;
        ASSERT_LE(std::hypot(f.x, f.y, f.z), settings.max_force) << "however it is measured";
    }
    EXPECT_GT(limited, 10'000);
}

TEST(ForceGuard, LimitsStiffnessToTheDevices) {
    ForceGuard guard(without_ramp(), 0.001);
    const GuardedForce out = guard.guard(pressing({0, 0, 4}, 40000));
    EXPECT_DOUBLE_EQ(out.force.z, 1.0);
    EXPECT_EQ(out.reasons, guard_stiffness);
}

Contact five_newtons() {
    return pressing({0, 0, 5});
}

TEST(ForceGuard, RampsInFromZero) {
    ForceGuard guard(GuardSettings{}, 0.001);
    double last = -1;
    for (int k = 0; k < 100; ++k) {
        const GuardedForce out = guard.guard(five_newtons());
        EXPECT_EQ(out.reasons, guard_ramp);
        EXPECT_GT(out.force.z, last);
        if (k == 0) {
            EXPECT_EQ(out.force.z, 0);
        }
        last = out.force.z;
    }
    EXPECT_EQ(guard.guard(five_newtons()).force.z, 5);
}

TEST(ForceGuard, RampsOutAtInvalidGoal) {
    SmallField wall(33, 33, 100.0);
    FingerState finger;
    ForceGuard guard({.ramp_in_ticks = 10, .ramp_out_ticks = 10, .rise = {}}, 0.001);
    wall.touch(finger, {0, 0, -99});
    for (int k = 0; k < 20; ++k) guard.guard(wall.touch(finger, {0, 0, -102}));
    const double before = guard.guard(wall.touch(finger, {0, 0, -102})).force.z;
    ASSERT_NEAR(before, 2, 1e-3);

    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    double last = before;
    for (int k = 0; k < 10; ++k) {
        const GuardedForce out = guard.guard(wall.touch(finger, {k % 2 ? nan : inf, 0, -102}));
        ASSERT_TRUE(std::isfinite(out.force.z));
        EXPECT_EQ(out.reasons, guard_fault);
        EXPECT_NEAR(out.force.z, last - before / 10, 1e-9);
        last = out.force.z;
    }
    EXPECT_EQ(guard.guard(wall.touch(finger, {nan, 0, -102})).force, dvec3(0.0));
    EXPECT_EQ(guard.guard(wall.touch(finger, {0, 0, -102})).force.z, 0);
    EXPECT_LT(guard.guard(wall.touch(finger, {0, 0, -102})).force.z, before / 5);
}

Contact without_goal() {
    Contact contact = five_newtons();
    contact.goal_held = true;
    return contact;
}

TEST(ForceGuard, BadSampleCostsOneStep) {
    ForceGuard guard(GuardSettings{}, 0.001);
    for (int k = 0; k < 150; ++k) guard.guard(five_newtons());
    EXPECT_DOUBLE_EQ(guard.guard(without_goal()).force.z, 5 * 0.99);
    EXPECT_DOUBLE_EQ(guard.guard(five_newtons()).force.z, 5 * 0.99);
    EXPECT_DOUBLE_EQ(guard.guard(five_newtons()).force.z, 5);
    EXPECT_EQ(guard.guard(five_newtons()).reasons, guard_none);
}

TEST(ForceGuard, FaultsNeverExceedRampStep) {
    SplitMix64 random(8);
    for (const int in : {1, 7, 100})
        for (const int out : {1, 10, 100}) {
            ForceGuard guard({.ramp_in_ticks = in, .ramp_out_ticks = out, .rise = {}}, 0.001);
            double last = 0, least = 5, most = 0;
            for (int k = 0; k < 5000; ++k) {
                const unsigned one_in = std::array{20U, 2U, 5U, 1U}[static_cast<std::size_t>(k / 500 % 4)];
                const bool fails = random.next() % one_in == 0 && k > 200;
                const double force = guard.guard(fails ? without_goal() : five_newtons()).force.z;
                ASSERT_LE(force - last, 5.0 / in + 1e-9) << in << ' ' << out << ' ' << k;
                ASSERT_LE(last - force, 5.0 / out + 1e-9) << in << ' ' << out << ' ' << k;
                last = force;
                if (k > 200) least = std::min(least, force);
                most = std::max(most, force);
            }
            EXPECT_LT(least, 0.5);
            EXPECT_EQ(most, 5);
        }
}

TEST(ForceGuard, ZeroTickRampIsImmediate) {
    ForceGuard guard({.ramp_in_ticks = 0, .ramp_out_ticks = 0, .rise = {}}, 0.001);
    EXPECT_EQ(guard.guard(five_newtons()).force.z, 5);
    EXPECT_EQ(guard.guard(without_goal()).force, dvec3(0.0));
    EXPECT_TRUE(guard.has_let_go());
    EXPECT_FALSE(guard.has_begun_anew());
    EXPECT_EQ(guard.guard(five_newtons()).force.z, 5);
}

TEST(ForceGuard, BadSampleKeepsPaidContact) {
    const GuardSettings settings{.ramp_in_ticks = 0, .rise = {.paid = true}};
    ForceGuard guard(settings, 0.001);
    const auto resting = [](double stiffness) {  // 2 mm deep
        Contact contact = pressing({0, 0, 0.002 * stiffness}, stiffness);
        contact.goal.z = -2;
        contact.carried_stiffness = stiffness;
        return contact;
    };
    guard.guard(resting(100));
    ASSERT_NEAR(guard.guard(resting(4000)).force.z, 0.2, 1e-12);
    Contact bad = resting(4000);
    bad.goal_held = true;
    guard.guard(bad);
    EXPECT_NEAR(guard.guard(resting(4000)).force.z, 0.2, 1e-12);
    for (int k = 0; k < settings.ramp_out_ticks; ++k) guard.guard(bad);
    EXPECT_NEAR(guard.guard(resting(4000)).force.z, 8, 1e-12) << "after a while it is one";
}

TEST(ForceGuard, LimitsHoldWithEverythingOn) {
    SmallField ground(65, 65, 0, DepthSemantics::planar);
    SplitMix64 random(3);
    ground.shape(ground.prev, [&](int, int) { return random.within(97, 103); });
    ground.shape(ground.next, [&](int, int) { return random.within(97, 103); });
    for (SurfaceFrame* frame : {&ground.prev, &ground.next})
        for (int k = 0; k < 3 * 65 * 65; ++k)
            frame->haptic.push_back(static_cast<std::uint8_t>(random.next() >> 56));
    GuardSettings settings{
        .max_force = 3, .max_stiffness = 4000, .rise = {.per_tick = 200}, .damping = 10, .passivity = 50};
    TouchSettings touch{.stribeck_speed = 0.1};
    ForceGuard guard(settings, 0.001);
    FingerState finger;
    std::uint32_t all_reasons = 0;
    dvec3 goal{0, 0, -99};
    for (int k = 0; k < 20'000; ++k) {
        const bool jumps = random.next() % 200 == 0, fails = random.next() % 300 == 0;
        for (int axis = 0; axis < 2; ++axis)
            goal[axis] = jumps ? random.within(-6, 6) : goal[axis] + random.within(-0.1, 0.1);
        goal.z = -100 + 3 * sine(0.01 * k);
        const dvec3 given = fails ? dvec3(NAN, 0, 0) : goal;
        const GuardedForce out = guard.guard(ground.touch(finger, given, random.unit(), touch));
        const dvec3& f = out.force;
        ASSERT_LE(std::sqrt(f.x * f.x + f.y * f.y + f.z * f.z), settings.max_force) << k;
        ASSERT_TRUE(std::isfinite(out.energy.balance())) << k;
        all_reasons |= out.reasons;
    }
    EXPECT_EQ(all_reasons, 127U) << "each had something to do";
}

TEST(TouchSolver, InvalidFirstGoalExertsNothing) {
    SmallField wall(9, 9, 100.0);
    FingerState finger;
    const Contact contact = wall.touch(finger, {NAN, 0, 0});
    EXPECT_TRUE(contact.goal_held);
    EXPECT_EQ(contact.force, dvec3(0.0));
    EXPECT_FALSE(finger.started);
}

TEST(TouchSolver, RejectsUnmeasurableScene) {
    TouchSettings settings;
    for (const TouchMetric metric : {TouchMetric::pixel, TouchMetric::scaled}) {
        SmallField wall(9, 9, 100.0);
        settings.metric = metric;
        EXPECT_TRUE(TouchSolver::create(wall.scene, settings));
        wall.scene.camera.fy = 401;
        EXPECT_NE(TouchSolver::create(wall.scene, settings).error().message.find("401"), std::string::npos);
        wall.scene.camera.fy = 400;
        wall.scene.depth.kind = DepthCodingKind::metric;
        EXPECT_FALSE(TouchSolver::create(wall.scene, settings));
    }
    SmallField wall(9, 9, 100.0);
    settings = {};
    settings.metres_per_scene_unit = 0;
    EXPECT_FALSE(TouchSolver::create(wall.scene, settings));
}

TEST(ForceHash, IsXxh64WithOneZero) {
    ForceHash empty;
    EXPECT_EQ(empty.hex(), "ef46db3751d8e999");  // XXH64 of nothing, seed 0
    ForceHash plus, minus, other;
    plus.add({0.0, 1.5, -2.0});
    minus.add({-0.0, 1.5, -2.0});
    other.add({0.0, 1.5, 2.0});
    EXPECT_EQ(plus.value(), minus.value());
    EXPECT_NE(plus.value(), other.value());
}

}  // namespace
}  // namespace touchable::test
