// SPDX-License-Identifier: Apache-2.0
// The damper beside the spring, and the controller that takes created energy back.

#include <gtest/gtest.h>

#include <cmath>

#include "haptics_cpu/force_guard.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/haptics/touch_rig.hpp"

namespace touchable::test {
namespace {

GuardSettings damped(double b, double max_force = 10) {
    return {.max_force = max_force, .ramp_in_ticks = 0, .rise = at_once, .damping = b};
}

class DampedWall : public testing::Test {
protected:
    DampedWall() : wall(33, 33, 100.0, DepthSemantics::planar) {}
    SmallField wall;
};

TEST_F(DampedWall, PressingAddsDampingTimesSpeed) {
    // 0.02 mm a tick is 0.02 m/s.
    const PathResult result = run_path(path_along({{0, 0, -99}, {0, 0, -102}}, 0.02), damped(5), wall);
    EXPECT_NEAR(result.forces.back().force.z, 1000 * 0.002 + 5 * 0.02, 1e-6);
    EXPECT_EQ(result.forces.back().reasons, guard_damping);
}

// A soft device gives 100 of the 1000 N/m: the damper may only take that back.
TEST_F(DampedWall, DoesNotHoldFingerBack) {
    for (const auto& [max_stiffness, share] :
         {std::pair{GuardSettings{}.max_stiffness, 0.5}, {100.0, 0.05}}) {
        GuardSettings settings = damped(20);
        settings.max_stiffness = max_stiffness;
        const PathResult result =
            run_path(path_along({{0, 0, -99}, {0, 0, -102}, {0, 0, -99}}, 0.05), settings, wall);
        int weakened = 0;
        for (std::size_t k = 0; k < result.forces.size(); ++k) {
            ASSERT_GE(result.forces[k].force.z, -1e-12) << k;
            weakened += result.forces[k].force.z < share * result.contacts[k].force.z;
        }
        EXPECT_GT(weakened, 10);
    }
}

TEST_F(DampedWall, LandingForgetsEarlierMotion) {
    ForceGuard used(damped(20), 0.001), fresh(damped(20), 0.001);
    FingerState before, landing;
    for (const dvec3& goal : path_along({{0, 0, -99}, {0, 0, -101}, {0, 0, -99}}, 0.2))
        used.guard(wall.touch(before, goal));
    for (const dvec3& goal : path_along({{0, 0, -99}, {0, 0, -101}}, 0.01)) {
        const Contact contact = wall.touch(landing, goal);
        ASSERT_NEAR(length(used.guard(contact).force - fresh.guard(contact).force), 0, 1e-12) << goal.z;
    }
}

TEST_F(DampedWall, FrictionlessSlideIsNotDamped) {
    const auto path = path_along({{-2, 0, -99}, {-2, 0, -101}, {2, 0, -101}}, 0.02);
    const PathResult with = run_path(path, damped(20), wall), without = run_path(path, damped(0), wall);
    for (std::size_t k = path.size() - 100; k < path.size(); ++k)
        EXPECT_NEAR(length(with.forces[k].force - without.forces[k].force), 0, 1e-6) << k;
}

TEST_F(DampedWall, DampingOnlyDissipates) {
    wall.shape(wall.prev, [](int x, int y) { return 100 + 1.5 * sine(0.4 * x) + sine(0.5 * y + 1); });
    for (const double friction : {0.0, 0.3}) {
        wall.scene.default_properties = {1000, friction, friction};
        Path path;
        for (int k = 0; k < 6000; ++k)
            path.push_back({3 * sine(0.004 * k), 2 * sine(0.0031 * k + 1), -100.5 + 2.5 * sine(0.0173 * k)});
        const PathResult with = run_path(path, damped(10), wall), without = run_path(path, damped(0), wall);
        EXPECT_GT(with.ticks_with(guard_damping), 1500);
        double work = 0;
        for (std::size_t k = 1; k < path.size(); ++k) {
            const dvec3 damper = with.forces[k].force - without.forces[k].force;
            work += glm::dot(damper, path[k] - path[k - 1]);
        }
        EXPECT_LT(work, 0);
        EXPECT_LT(with.energy.balance(), without.energy.balance());
        EXPECT_LE(with.energy.created, with.energy.bound);
    }
}

TEST_F(DampedWall, DeviceForceLimitsDamper) {
    const auto path = path_along({{0, 0, -99}, {0, 0, -102}}, 0.1);
    const PathResult result = run_path(path, damped(100, 1.5), wall);
    for (const GuardedForce& out : result.forces) ASSERT_LE(length(out.force), 1.5);
    EXPECT_GT(result.ticks_with(guard_force), 5);
}

TEST_F(DampedWall, SurfaceMotionIsNotDamped) {
    wall.fill(wall.next, 96.0);
    FingerState finger;
    ForceGuard guard(damped(20), 0.001);
    for (int k = 0; k < 200; ++k) {
        const Contact contact = wall.touch(finger, {0, 0, -99.5}, k * 0.004);
        ASSERT_EQ(guard.guard(contact).force, contact.force) << k;
    }
}

/// Contacts made by hand: the goal goes along x at 0.2 m/s, `depth` mm under its proxy.
class DraggedContact : public testing::Test {
protected:
    static Contact at(int tick, double depth, double stiffness = 1000) {
        Contact contact = pressing({0, 0, stiffness * 0.001 * depth}, stiffness);
        contact.proxy = {0.2 * tick, 0, 0};
        contact.goal = {0.2 * tick, 0, -depth};
        contact.carried = {0.2 * (tick - 1), 0, 0};
        contact.carried_stiffness = stiffness;
        return contact;
    }
    /// From soft to hard ground: energy from nowhere.
    static Contact arriving(int tick) {
        Contact contact = at(tick, 10, 10000);
        contact.carried_stiffness = 100;
        return contact;
    }
    static GuardSettings braked(double max_force = 1000) {
        return {.max_force = max_force, .ramp_in_ticks = 0, .rise = at_once, .passivity = 20};
    }
    /// On soft ground for some ticks.
    static ForceGuard drag(const GuardSettings& settings, int ticks) {
        ForceGuard guard(settings, 0.001);
        for (int tick = 0; tick < ticks; ++tick) guard.guard(at(tick, 10, 100));
        return guard;
    }
};

TEST_F(DraggedContact, DropsPushingDamper) {
    ForceGuard guard(damped(10), 0.001);
    for (int tick = 0; tick < 20; ++tick) {
        // Over an edge, say: the proxy runs ahead of the goal, and stretches the spring the way the hand
        // goes.
        Contact ahead = at(tick, 1);
        ahead.proxy.x += 0.1 * tick;
        ahead.carried.x = tick == 0 ? 0 : ahead.proxy.x - 0.3;
        ahead.force = ahead.proxy - ahead.goal;
        const GuardedForce out = guard.guard(ahead);
        EXPECT_EQ(out.force, ahead.force) << tick;
        EXPECT_EQ(out.reasons, guard_none) << tick;
        // The other way round it brakes.
        if (tick < 19) continue;
        Contact behind = at(tick + 1, 1);
        behind.carried = ahead.proxy;
        behind.proxy.x = ahead.proxy.x - 5;
        behind.force = behind.proxy - behind.goal;
        EXPECT_LT(guard.guard(behind).force.x, behind.force.x);
    }
}

TEST_F(DraggedContact, DamperBridgesOutage) {
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    ForceGuard guard({.max_force = 1000, .rise = at_once, .damping = 10}, 0.001);
    FingerState finger;
    const auto press = [&](int tick) {
        const Contact contact = wall.touch(finger, {0, 0, -99 - 0.2 * tick});  // 0.2 m/s
        return std::pair(contact.force.z, guard.guard(contact).force.z);
    };
    for (int tick = 0; tick < 150; ++tick) press(tick);
    for (int tick = 150; tick < 159; ++tick) guard.guard(wall.touch(finger, {NAN, 0, 0}));
    const auto [spring, force] = press(159);
    EXPECT_NEAR(force, 0.91 * (spring + 10 * 0.2), 1e-6) << "nine steps of the ramp down";
}

TEST_F(DraggedContact, BrakeBridgesOutage) {
    ForceGuard guard = drag(braked(), 60);
    EXPECT_NEAR(guard.guard(arriving(60)).force.x, -20 * 0.2, 1e-6) << "the most there may be";
    int tick = 61;
    for (; tick < 70; ++tick) EXPECT_NEAR(guard.guard(at(tick, 10, 10000)).force.x, -20 * 0.2, 1e-6);
    for (; tick < 79; ++tick) {
        Contact held = at(tick, 10, 10000);
        held.goal_held = true;
        guard.guard(held);
    }
    EXPECT_NEAR(guard.guard(at(tick, 10, 10000)).force.x, -20 * 0.2, 1e-6);
}

// Where the force of a jump is still to come, so is the brake. From 100 to 10000 N/m at 0.2 m/s, as above.
TEST_F(DraggedContact, BrakeScalesWithPresence) {
    for (const double presence : {0.0, 0.25, 1.0}) {
        ForceGuard guard = drag(braked(), 60);
        BlendedForce blended{arriving(60).force};
        blended.presence = presence;
        const GuardedForce out = guard.guard_blended(arriving(60), blended);
        EXPECT_NEAR(out.force.x, -20 * 0.2 * presence, 1e-6);
        EXPECT_EQ(out.reasons & guard_passivity, presence > 0 ? std::uint32_t{guard_passivity} : 0U);
    }
}

TEST_F(DraggedContact, BrakeEndsWithContact) {
    // The finger comes out, or the ground sinks below it, so that the energy from nowhere is still owed.
    for (const double sinks : {0.0, 10.0}) {
        ForceGuard guard = drag(braked(GuardSettings{}.max_force), 60);
        const GuardedForce out = guard.guard(arriving(60));
        EXPECT_NEAR(length(out.force), 10, 1e-9) << "100 N of spring and 4 N across";
        EXPECT_LT(out.force.x, -1);
        EXPECT_EQ(out.reasons, std::uint32_t{guard_passivity | guard_force});
        Contact leaving = at(61, sinks, 10000);
        leaving.proxy = leaving.goal;
        leaving.carried.z = -sinks;
        leaving.touching = false;
        leaving.properties.stiffness = 0;
        leaving.force = dvec3(0.0);
        const GuardedForce free = guard.guard(leaving);
        EXPECT_EQ(free.force, dvec3(0.0)) << sinks;
        EXPECT_EQ(free.reasons, guard_none) << sinks;
    }
}

TEST_F(DraggedContact, DamperScalesWithPresence) {
    for (const double presence : {0.0, 0.25, 1.0}) {
        ForceGuard guard(damped(10), 0.001);
        GuardedForce out;
        Contact deeper;
        for (int tick = 0; tick < 100; ++tick) {  // 0.02 m/s into 1000 N/m
            deeper = at(0, 1 + 0.02 * tick);
            deeper.carried.x = 0;
            BlendedForce blended{deeper.force};
            blended.presence = presence;
            out = guard.guard_blended(deeper, blended);
        }
        EXPECT_NEAR(out.force.z, deeper.force.z + presence * 10 * 0.02, 1e-6);
    }
}

TEST_F(DraggedContact, BrakeRampsWithSpring) {
    ForceGuard guard = drag({.max_force = 1000, .rise = at_once, .passivity = 20}, 50);
    for (int tick = 50; tick < 60; ++tick) {
        const GuardedForce out = guard.guard(tick == 50 ? arriving(50) : at(tick, 10, 10000));
        const double ramp = 0.01 * tick;
        EXPECT_NEAR(out.force.x, -ramp * 20 * 0.2, 1e-6) << tick;
        EXPECT_NEAR(out.force.z, ramp * 100, 1e-9) << tick;
        EXPECT_EQ(out.reasons, std::uint32_t{guard_ramp | guard_passivity});
    }
}

TEST_F(DraggedContact, BuriedForceGetsNothingAdded) {
    FingerGuard guard({.ramp_in_ticks = 0, .rise = at_once, .damping = 10, .passivity = 20}, 0.001);
    // Into the ground at 0.05 m/s, 0.5 N of damper; then a cut raises the ground by 60 mm, and the hand goes
    // on, and back.
    double last = 0;
    const auto press = [&](double depth, double risen, bool cut) {
        Contact contact = at(0, depth);
        contact.proxy.z = risen;
        contact.carried = contact.proxy;
        contact.force = contact.proxy - contact.goal;
        contact.jumped = cut;
        contact.jumped_force = contact.force;
        const double force = guard.guard(contact).force.z, step = force - last;
        last = force;
        return step;
    };
    double depth = 0.05;
    for (int k = 0; k < 110; ++k, depth += k < 80 ? 0.05 : 0) press(depth, 0, false);
    EXPECT_NEAR(last, 4, 1e-6);
    for (int k = 0; k < 30; ++k, depth += 0.05) press(depth, 0, false);
    EXPECT_NEAR(last, 5.45 + 0.5, 1e-6);
    for (int k = 0; k <= 100; ++k, depth += 0.05)
        EXPECT_LE(std::abs(press(depth, 60, k == 0)), 1.5 / 100 * 6 + 0.5 / 100 + 1e-3) << k;
    for (int k = 0; k < 200; ++k, depth += k < 100 ? 0.05 : -0.3) {
        press(depth, 60, false);
        ASSERT_EQ(last, 0) << k;
    }
}

TEST_F(DraggedContact, DamperWaitsForFadingForce) {
    FingerGuard guard(damped(50), 0.001);
    // A free finger; a surface comes through it at once, 5 mm; it withdraws at 0.05 m/s.
    guard.guard(Contact{});
    for (int k = 0; k < 60; ++k) {
        Contact contact = at(0, 5 - 0.05 * k);
        contact.carried.x = 0;
        contact.jumped = k == 0;
        contact.jumped_force = {0, 0, 5};
        ASSERT_GE(guard.guard(contact).force.z, -1e-12) << k;
    }
}

class Passivity : public GlobeFlank {
protected:
    PathResult loop(double azimuth, bool limbward, double most) {
        return GlobeFlank::loop(azimuth, 0.02, limbward,
                                {.ramp_in_ticks = 0, .rise = at_once, .passivity = most});
    }
};

TEST_F(Passivity, IdlesAtConstantStiffness) {
    for (const double friction : {0.0, 0.4}) {
        rig.scene().default_properties = {1000, friction, friction};
        for (int flank = 0; flank < 6; ++flank)
            for (const bool limbward : {false, true}) {
                const PathResult with = loop(0.2 + flank, limbward, 50),
                                 without = loop(0.2 + flank, limbward, 0);
                EXPECT_EQ(with.ticks_with(guard_passivity), 0);
                for (std::size_t k = 0; k < with.forces.size(); ++k)
                    ASSERT_EQ(with.forces[k].force, without.forces[k].force);
            }
    }
}

TEST_F(Passivity, DissipatesPixelMetricEnergy) {
    rig.settings.metric = TouchMetric::pixel;
    for (const double azimuth : {0.2, 2.2, 4.2}) {
        const bool limbward = loop(azimuth, true, 0).energy.created > loop(azimuth, false, 0).energy.created;
        const PathResult without = loop(azimuth, limbward, 0), with = loop(azimuth, limbward, 50);
        EXPECT_GT(with.ticks_with(guard_passivity), 20);
        EXPECT_LT(with.energy.created, 0.3 * without.energy.created);
        for (const GuardedForce& out : with.forces) ASSERT_LE(length(out.force), GuardSettings{}.max_force);
    }
}

TEST(PassivityController, BrakesWithinItsLimit) {
    const PassivityController controller(20);
    const dvec3 slow{0, 0, 0.01}, fast{0.3, 0, 0.4};
    EXPECT_EQ(controller.force(0, fast), dvec3(0.0));
    EXPECT_EQ(controller.force(-1, fast), dvec3(0.0));
    EXPECT_EQ(controller.force(1, dvec3(0.0)), dvec3(0.0));
    // 1e-3 J in 1 ms at 0.5 m/s: 4 N s/m; at 0.01 m/s the limit.
    EXPECT_NEAR(length(controller.force(1e-3, fast) + 4.0 * fast), 0, 1e-12);
    EXPECT_NEAR(length(controller.force(1e-3, slow) + 20.0 * slow), 0, 1e-12);
}

// The books of energy: a finger pressed in, along and out gets back no more than it gave, but for what
// holding a force for a tick creates.

// Sums of thousands of terms of millijoules.
constexpr double energy_rounding = 1e-13;

class Globe : public GlobeFlank {};

TEST_F(Globe, StrokeStaysWithinBound) {
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

TEST_F(Globe, CreatedEnergyVanishesWithSpeed) {
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

TEST_F(Globe, PixelMetricCreatesMillijoules) {
    rig.settings.metric = TouchMetric::pixel;
    for (const double step : {0.02, 0.005}) {
        const PathResult in = loop(0.2, step, false), out = loop(0.2, step, true);
        const double created = std::max(in.energy.created, out.energy.created);
        EXPECT_GT(created, 5e-3);
        EXPECT_GT(created, 10 * in.energy.bound);
    }
}

TEST_F(Globe, LimitedForcesStayWithinBound) {
    GuardSettings settings{.max_force = 0.7, .max_stiffness = 600, .ramp_in_ticks = 0, .rise = at_once};
    const PathResult result = loop(1.2, 0.02, true, settings);
    EXPECT_GT(result.ticks_with(guard_force), 100);
    EXPECT_GT(result.ticks_with(guard_stiffness), 200);
    EXPECT_LE(result.energy.created, result.energy.bound + energy_rounding);
    EXPECT_LT(result.energy.bound, loop(1.2, 0.02, true).energy.bound);
}

TEST_F(Globe, RampInLoadsSpring) {
    // The hand goes in while there is no force, and is pushed out by all of it.
    Path going = path(0.2, 0.02, true);
    going.erase(going.begin(), going.begin() + 145);  // begins all but 2 mm deep
    const PathResult result = run_path(going, GuardSettings{}, rig);
    EXPECT_EQ(result.ticks_with(guard_ramp), 100);
    EXPECT_GT(result.energy.surface, 1.5e-3);
    EXPECT_GT(result.energy.work, 1.5e-3);
    EXPECT_LE(result.energy.created, result.energy.bound + energy_rounding);
}

TEST(Energy, PressingLeaksHoldEnergy) {
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

TEST(Energy, RisingSurfaceDoesTheWork) {
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

TEST(Energy, MovingReliefStaysWithinBound) {
    TouchRig rig("moving", sized(320, 240), TouchRig::Depth::codes);
    SurfaceFrame later;
    rig.load(3, TouchRig::Depth::codes, later);
    rig.pair.next = {3, 100'000'000, &later};
    for (const double friction : {0.0, 0.4}) {
        rig.scene().default_properties = {600, friction, friction};
        rig.lift_fingers();
        ReliefStroke stroke(Relief::bumps, 320, 240, 0.1);
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

// The hand's path meanwhile is unknown: neither the force that it had nor a jump's share of it works on the
// way to where it is found again.
TEST(Energy, AccountSkipsLostGoals) {
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
    Contact contact = depth > 0 ? pressing({0, 0, depth}) : Contact{};
    contact.goal = {0, 0, -depth};
    if (depth > 0)
        contact.carried_stiffness = 1000;
    else
        contact.proxy = contact.carried = contact.goal;
    return contact;
}

TEST(Energy, GuardSkipsLostGoals) {
    ForceGuard guard(without_ramp(), 0.001);
    guard.guard(resting_at(0));
    const EnergyFigures before = guard.guard(resting_at(2)).energy;
    Contact missing = resting_at(2);
    missing.goal_held = true;
    guard.guard(missing);
    EXPECT_EQ(guard.guard(resting_at(-10)).energy.work, before.work);
}

// All that the spring holds in the end came from the ramp; nothing was created.
TEST(Energy, RampLoadsSpringAtRest) {
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
TEST(Energy, CancelledJumpCountsForSurface) {
    const auto surface_of_a_step = [](double depth, double newtons, int ramp_ticks) {
        ForceGuard guard({.ramp_in_ticks = ramp_ticks, .rise = at_once}, 0.001);
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

TEST(Energy, StaysFiniteThroughLostGoals) {
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
