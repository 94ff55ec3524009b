// The books of energy: a finger pressed in, along and out gets back no more than it gave, but for what
// holding a force for a tick creates.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/content/height_fields.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "tests/haptics/force_path.hpp"

namespace touchable::test {
namespace {

using glm::dvec3;

// Sums of thousands of terms of millijoules.
constexpr double energy_rounding = 1e-13;

class Globe : public GlobeFlank {};

TEST_F(Globe, PressSlideRetractCreatesNoMoreThanHoldingForcesDoes) {
    for (int flank = 0; flank < 6; ++flank)
        for (const bool limbward : {false, true}) {
            const PathResult result = loop(0.2 + flank, 0.02, limbward);
            EXPECT_GT(result.touching(), 200);
            EXPECT_GT(result.energy.bound, 1e-5);
            EXPECT_LE(result.energy.created, result.energy.bound + energy_rounding);
            EXPECT_EQ(result.energy.stored, 0) << "it ends in the air";
            EXPECT_NEAR(result.energy.surface, 0, energy_rounding) << "nothing but the hand moves";
        }
}

TEST_F(Globe, WhatIsCreatedGoesToZeroWithTheSpeed) {
    for (const bool limbward : {false, true}) {
        double last_bound = 1, last_created = 1;
        for (const double step : {0.04, 0.02, 0.01, 0.005}) {
            const PathResult result = loop(0.2, step, limbward);
            EXPECT_NEAR(result.energy.bound / last_bound, 0.5, last_bound == 1 ? 1 : 0.05);
            EXPECT_LT(result.energy.created, 0.6 * last_created);
            last_bound = result.energy.bound;
            last_created = result.energy.created;
        }
        EXPECT_LT(last_created, 2e-5);
    }
}

TEST_F(Globe, ThePapersMetricCreatesMillijoulesAtAnySpeed) {
    rig.settings.metric = TouchMetric::pixel;
    for (const double step : {0.02, 0.005}) {
        const PathResult in = loop(0.2, step, false), out = loop(0.2, step, true);
        const double created = std::max(in.energy.created, out.energy.created);
        EXPECT_GT(created, 5e-3);
        EXPECT_GT(created, 10 * in.energy.bound);
    }
}

TEST_F(Globe, ForcesCutOffByTheDeviceCreateNothingEither) {
    GuardSettings settings = without_ramp();
    settings.max_force = 0.7;
    settings.max_stiffness = 600;
    const PathResult result = loop(1.2, 0.02, true, settings);
    EXPECT_GT(result.ticks_with(guard_force), 100);
    EXPECT_GT(result.ticks_with(guard_stiffness), 200);
    EXPECT_LE(result.energy.created, result.energy.bound + energy_rounding);
    EXPECT_LT(result.energy.bound, loop(1.2, 0.02, true).energy.bound);
}

TEST_F(Globe, AGuardThatRampsInPutsEnergyIntoTheSpring) {
    // The hand goes in while there is no force, and is pushed out by all of it.
    std::vector<dvec3> going = path(0.2, 0.02, true);
    going.erase(going.begin(), going.begin() + 145);  // begins all but 2 mm deep
    const PathResult result = run_path(going, GuardSettings{}, rig);
    EXPECT_EQ(result.ticks_with(guard_ramp), 100);
    EXPECT_GT(result.energy.surface, 1.5e-3);
    EXPECT_GT(result.energy.work, 1.5e-3);
    EXPECT_LE(result.energy.created, result.energy.bound + energy_rounding);
}

TEST(Energy, PressingIntoAWallLeaksExactlyHalfKStepSquaredATick) {
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    const double step = 0.01;  // mm
    const auto path = path_along({{0, 0, -99.5}, {0, 0, -102}, {0, 0, -99.5}}, step);
    const PathResult result = run_path(path, without_ramp(), wall);
    const int moves = 2 * 200;
    EXPECT_NEAR(result.energy.created, moves * 0.5 * 1000 * 1e-10, 1e-11);
    // The bound counts the tick in which it touches at no depth as well.
    EXPECT_NEAR(result.energy.bound, (moves + 1) * 0.5 * 1000 * 1e-10, 1e-11);
}

TEST(Energy, FrictionOnlyTakes) {
    SmallField wall(65, 65, 100.0, DepthSemantics::planar);
    wall.scene.default_properties = {1000, 0.5, 0.3};
    const auto path = path_along({{-3, 0, -99}, {-3, 0, -101}, {3, 0, -101}, {3, 0, -99}}, 0.01);
    const PathResult result = run_path(path, without_ramp(), wall);
    EXPECT_LE(result.energy.created, result.energy.bound + energy_rounding);
    // 0.3 N over about 5.7 mm.
    EXPECT_NEAR(result.energy.balance(), -0.3 * 5.7e-3, 2e-4);
}

TEST(Energy, ASurfaceThatLiftsTheHandGivesWhatItGives) {
    // A wall comes 4 mm nearer to a hand that gives way at the end: its work is the wall's, nothing is
    // created.
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    wall.fill(wall.next, 96.0);
    FingerState finger;
    ForceGuard guard(without_ramp(), 0.001);
    EnergyFigures energy;
    for (int k = 0; k <= 4000; ++k) {
        const double risen = std::min(1.0, k / 2000.0), back = std::max(0.0, k / 1000.0 - 2) * 5;
        energy = guard.guard(wall.touch(finger, {0.3, 0.2, -99.5 + std::min(back, 5.0)}, risen)).energy;
    }
    EXPECT_NEAR(energy.surface, 0.5 * 1000 * 3.5e-3 * 3.5e-3, 1e-4);
    EXPECT_NEAR(energy.work, energy.surface, 1e-4);
    EXPECT_LE(energy.created, energy.bound + energy_rounding);
    EXPECT_LT(energy.bound, 1e-4);
}

TEST(Energy, AMovingReliefCreatesNoMoreThanHoldingForcesDoes) {
    SceneOptions options;
    options.width = 320;
    options.height = 240;
    TouchRig rig("moving", options, TouchRig::Depth::codes);
    SurfaceFrame later;
    rig.load(3, TouchRig::Depth::codes, later);
    rig.pair.next = {3, 100'000'000, &later};
    for (const double friction : {0.0, 0.4}) {
        rig.scene().default_properties = {600, friction, friction};
        rig.lift_fingers();
        ReliefStroke stroke(Relief::bumps, options.width, options.height, 0.1);
        ForceGuard guard(without_ramp(), 0.001);
        EnergyFigures energy;
        int touching = 0;
        for (int tick = 0; tick < 1000; ++tick) {
            rig.pair.blend = 0.5 + 0.5 * sine(0.01 * tick);
            const Contact& contact = rig.tick(stroke.next().goal);
            energy = guard.guard(contact).energy;
            touching += contact.touching;
            ASSERT_LE(energy.created, energy.bound + energy_rounding) << tick;
        }
        EXPECT_GT(touching, 500);
        EXPECT_GT(std::abs(energy.surface), 1e-4);
    }
}

// Where the hand was meanwhile nobody knows: neither the force that it had nor a jump's share of it works on
// the way to where it is found again.
TEST(Energy, TheWayOfAHandThatWasLostIsNotBooked) {
    EnergyAccount account({1000, 10}, 0.001);
    Contact pressed;
    pressed.touching = true;
    pressed.goal = pressed.carried = {0, 0, -2};
    account.move(pressed, 1000.0, 1);
    account.store(1000);
    account.hold({0, 0, 2}, {0, 0, 0.5});
    const EnergyFigures before = account.figures();
    ASSERT_NEAR(before.stored, 0.002, 1e-12);

    account.lose_goal();
    EXPECT_EQ(account.figures().stored, 0) << "the spring is let go";
    EXPECT_NEAR(account.figures().balance(), before.balance(), energy_rounding);
    const double surface = account.figures().surface;
    Contact found;
    found.goal = found.proxy = found.carried = {0, 0, 8};
    account.move(found, std::nullopt, 1);
    account.store(0);
    EXPECT_EQ(account.figures().work, before.work);
    EXPECT_EQ(account.figures().surface, surface);
    EXPECT_EQ(account.figures().bound, before.bound);
}

/// A goal `depth` mm deep in ground of 1000 N/m, 0 or less: free; the finger was there before.
Contact resting_at(double depth) {
    Contact contact;
    contact.goal = contact.proxy = contact.carried = {0, 0, -depth};
    if (depth <= 0) return contact;
    contact.touching = true;
    contact.proxy.z = contact.carried.z = 0;
    contact.properties.stiffness = 1000;
    contact.carried_stiffness = 1000;
    contact.force = contact.proxy - contact.goal;
    return contact;
}

TEST(Energy, AGuardThatMissesAGoalDoesNotBookTheWayEither) {
    ForceGuard guard(without_ramp(), 0.001);
    guard.guard(resting_at(0));
    const EnergyFigures before = guard.guard(resting_at(2)).energy;
    Contact missing = resting_at(2);
    missing.goal_held = true;
    guard.guard(missing);
    EXPECT_EQ(guard.guard(resting_at(-10)).energy.work, before.work);
}

// All that the spring holds in the end came from the ramp; nothing was created.
TEST(Energy, UnderAFingerAtRestTheRampPutsInWhatIsStored) {
    ForceGuard guard(GuardSettings{}, 0.001);
    EnergyFigures energy;
    for (int tick = 0; tick < 150; ++tick) {
        energy = guard.guard(resting_at(2)).energy;
        ASSERT_NEAR(energy.stored, std::min(0.01 * tick, 1.0) * 0.002, energy_rounding) << tick;
    }
    EXPECT_EQ(energy.work, 0);
    EXPECT_NEAR(energy.surface, 0.002, energy_rounding);
    EXPECT_NEAR(energy.created, 0, energy_rounding);
}

// The jump's part of the force is the surface's, whatever moves against it: as the device gives it, beyond
// its limit and in the ramp.
TEST(Energy, WhatAJumpsCancellationTakesFromTheHandIsTheSurfaces) {
    const auto surface_of_a_step = [](double depth, double newtons, int ramp_ticks) {
        GuardSettings settings;
        settings.ramp_in_ticks = ramp_ticks;
        ForceGuard guard(settings, 0.001);
        guard.guard(resting_at(depth));
        const EnergyFigures before =
            guard.guard_blended(resting_at(depth), {glm::dvec3(0, 0, newtons)}).energy;
        Contact up = resting_at(depth - 1);  // the surface rests, the hand goes up by a millimetre
        up.carried = {0, 0, 0};
        return guard.guard(up).energy.surface - before.surface;
    };
    EXPECT_NEAR(surface_of_a_step(4, 1, 0), -0.003, energy_rounding) << "3 of 4 N are held back";
    EXPECT_NEAR(surface_of_a_step(20, 15, 0), 0, energy_rounding) << "the limit is 10 N with or without";
    // In the second of two ticks of a ramp half of that; the third lets all of the spring through: from half
    // of 0.5 k x^2 to all of it at the old goal.
    EXPECT_NEAR(surface_of_a_step(4, 1, 2), -0.0015 + 0.004, energy_rounding);
}

TEST(Energy, AGoalThatIsLostForAWhileLeavesTheBooksFinite) {
    SmallField wall(33, 33, 100.0);
    FingerState finger;
    ForceGuard guard(without_ramp(), 0.001);
    EnergyFigures energy;
    for (int k = 0; k < 60; ++k) {
        const double z = k > 20 && k < 30 ? NAN : (k < 10 ? -99 : -102 + 0.02 * k);
        energy = guard.guard(wall.touch(finger, {0, 0, z})).energy;
        ASSERT_TRUE(std::isfinite(energy.balance())) << k;
    }
    EXPECT_LE(energy.created, energy.bound + energy_rounding);
}

}  // namespace
}  // namespace touchable::test
