// SPDX-License-Identifier: Apache-2.0
// The cancellation between a surface that jumps and a hand.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <utility>
#include <vector>

#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

GuardSettings device() {
    return {.max_force = 8, .rise = at_once};
}

/// The goal rests: what it meets now is what the last tick's goal meets on this surface.
Contact jumping(const dvec3& force, double stiffness = 1000) {
    Contact contact = pressing(force, stiffness);
    contact.jumped = true;
    contact.jumped_force = force;
    return contact;
}

/// The same contact for some ticks; what came of the last one.
BlendedForce repeat(JumpCancellation& calm, int ticks, const Contact& contact) {
    BlendedForce out;
    for (int tick = 0; tick < ticks; ++tick) out = calm.calm(contact);
    return out;
}

/// A goal `depth` mm deep, where the stiffness is `stiffness` N/m, `hole_share` of it a hole's.
Contact near_hole(double depth, double stiffness, double hole_share, bool jumped) {
    const dvec3 force{0, 0, 0.001 * stiffness * depth};
    Contact contact = jumped ? jumping(force, stiffness) : pressing(force, stiffness);
    contact.carried_stiffness = stiffness;
    contact.hole_share = hole_share;
    return contact;
}

TEST(JumpCancellation, PassesCalmForcesUnchanged) {
    JumpCancellation calm(device());
    Random random(3);
    for (int tick = 0; tick < 1000; ++tick) {
        const dvec3 force(random.below(1000) * 0.007, random.below(1000) * -0.003, random.below(1000) * 1e-9);
        Contact contact = pressing(force);
        contact.touching = random.below(10) > 0;
        if (!contact.touching) contact.force = dvec3(0.0);
        const BlendedForce out = calm.calm(contact);
        ASSERT_EQ(out.force, contact.force);
        ASSERT_EQ(out.difference, dvec3(0.0));
        ASSERT_FALSE(out.active);
    }
}

TEST(JumpCancellation, FadesJumpInOver100Ms) {
    JumpCancellation calm(device());
    calm.calm(pressing({0, 0, 1}));
    BlendedForce out = calm.calm(jumping({0, 2, 5}));
    EXPECT_NEAR(length(out.force - dvec3(0, 0, 1)), 0, 1e-15);
    EXPECT_TRUE(out.active);
    EXPECT_NEAR(length(out.difference - dvec3(0, -2, -4)), 0, 1e-15);
    const double largest = 1.5 / JumpCancellation::fade_ticks * length(dvec3(0, 2, 4));
    dvec3 last = out.force;
    for (int tick = 1; tick < JumpCancellation::fade_ticks; ++tick) {
        out = calm.calm(pressing({0, 2, 5}));
        EXPECT_TRUE(out.active) << tick;
        EXPECT_GT(out.force.z, last.z);
        EXPECT_LE(length(out.force - last), largest * (1 + 1e-9));
        EXPECT_EQ(out.difference, out.force - dvec3(0, 2, 5));
        last = out.force;
    }
    out = calm.calm(pressing({0, 2, 5}));
    EXPECT_FALSE(out.active);
    EXPECT_EQ(out.force, dvec3(0, 2, 5));
}

/// docs/solver.md: F - w J with w = 1 - p^2 (3 - 2p), p from 0 to 1 in 100 ms.
TEST(JumpCancellation, FadeFollowsDocumentedCubic) {
    JumpCancellation calm(device());
    calm.calm(pressing({0, 0, 1}));
    std::vector<double> came{calm.calm(jumping({0, 0, 5})).force.z};
    while (came.size() <= 100) came.push_back(calm.calm(pressing({0, 0, 5})).force.z);
    const std::pair<std::size_t, double> shares[] = {{0, 0},        {1, 0.000298},  {10, 0.028},
                                                     {25, 0.15625}, {50, 0.5},      {75, 0.84375},
                                                     {90, 0.972},   {99, 0.999702}, {100, 1}};
    for (const auto& [ticks, share] : shares) EXPECT_NEAR(came[ticks], 1 + 4 * share, 1e-12) << ticks;
}

TEST(JumpCancellation, TheSpringItselfIsUntouched) {
    JumpCancellation one(device()), other(device());
    one.calm(pressing({0, 0, 1}));
    other.calm(pressing({0, 0, 1}));
    one.calm(jumping({0, 0, 5}));
    other.calm(jumping({0, 0, 5}));
    for (int tick = 0; tick < 50; ++tick) {
        const BlendedForce a = one.calm(pressing({0, 0, 5})), b = other.calm(pressing({0, 0.25, 5.5}));
        EXPECT_NEAR(length(b.force - a.force - dvec3(0, 0.25, 0.5)), 0, 1e-14) << "dF/dG lags";
    }
}

TEST(JumpCancellation, NeverLengthensOrReversesForce) {
    Random random(17);
    const auto any = [&] { return 0.01 * (random.below(2000) - 1000); };
    int active = 0;
    for (int run = 0; run < 200; ++run) {
        JumpCancellation calm(device());
        for (int tick = 0; tick < 300; ++tick) {
            const dvec3 force(any(), any(), any());
            Contact contact = random.below(20) == 0 ? jumping(force) : pressing(force);
            if (contact.jumped) contact.jumped_force = {any(), any(), any()};
            const BlendedForce out = calm.calm(contact);
            ASSERT_LE(length(out.force), length(force) * (1 + 1e-12));
            ASSERT_GE(glm::dot(out.force, force), -1e-9);
            active += out.active;
        }
    }
    EXPECT_GT(active, 10000);
}

TEST(JumpCancellation, OverlappingCutsContinueSmoothly) {
    JumpCancellation calm(device());
    dvec3 last = calm.calm(pressing({0, 0, 0.5})).force;
    const double fading = 1.5 / JumpCancellation::fade_ticks * 10;  // newtons a tick
    Random random(9);
    for (int cut = 0; cut < 100; ++cut) {
        const dvec3 level(0.1 * random.below(20), 0.1 * random.below(20), 3 + 0.1 * random.below(20));
        BlendedForce out = calm.calm(jumping(level));
        // Shorter than the surface now gives is all there may be.
        EXPECT_LE(length(out.force - last), std::max(0.0, length(last) - length(level)) + fading)
            << "cut " << cut;
        for (int tick = 0; tick < random.below(60); ++tick) out = calm.calm(pressing(level));
        last = out.force;
    }
}

TEST(JumpCancellation, FollowsRowOfSmallJumps) {
    JumpCancellation calm(GuardSettings{});
    calm.calm(pressing({0, 0, 0.001}));
    double behind = 0;
    for (int tick = 1; tick <= 70; ++tick) {  // a surface that comes at 0.12 m/s, 1 N/mm
        const BlendedForce out = calm.calm(jumping({0, 0, 0.12 * tick}));
        behind = 0.12 * tick - out.force.z;
        EXPECT_GT(behind, -1e-12);
        EXPECT_LT(behind, 6.0) << "50 ms behind";
    }
    EXPECT_EQ(repeat(calm, 101, pressing({0, 0, 8.4})).force.z, 8.4);
}

TEST(JumpCancellation, EndsWithContact) {
    JumpCancellation calm(device());
    calm.calm(pressing({0, 0, 1}));
    calm.calm(jumping({0, 0, 5}));
    const BlendedForce free = calm.calm(Contact{});
    EXPECT_EQ(free.force, dvec3(0.0));
    EXPECT_FALSE(free.active);
    const BlendedForce again = calm.calm(pressing({0, 0, 2}));
    EXPECT_EQ(again.force, dvec3(0, 0, 2));
    EXPECT_FALSE(again.active);
}

// A device gives 500 N/m of either: the hand feels 1 N before and after.
TEST(JumpCancellation, IgnoresStiffnessBeyondDevice) {
    JumpCancellation calm({.max_force = 8, .max_stiffness = 500, .rise = at_once});
    calm.calm(pressing({0, 0, 2}));
    EXPECT_EQ(calm.calm(near_hole(2, 2000, 0, true)).force, dvec3(0, 0, 4));
    // One that the device gives whole is a jump, of what the hand feels.
    EXPECT_EQ(calm.calm(near_hole(4, 100, 0, true)).force, dvec3(0, 0, 0.4)) << "longer than the force";
    EXPECT_NEAR(calm.calm(near_hole(2, 4000, 0, true)).force.z, 8 * 0.4, 1e-12)
        << "1 N as the device gives it, less a jump of 0.6";
}

// The share that the device gives of a jump is that of the stiffness under the jump, not of where the finger
// has moved to since.
TEST(JumpCancellation, MeasuresJumpWhereItHappened) {
    JumpCancellation calm({.max_force = 8, .max_stiffness = 500, .rise = at_once});
    calm.calm(pressing({0, 0, 2}));  // of 1000 N/m: the hand feels 1 N
    Contact moved = jumping({0, 0, 1});
    moved.jumped_force = {0, 0, 4};  // of 2000 N/m: 1 N as well
    moved.carried_stiffness = 2000;
    moved.properties.stiffness = 500;
    EXPECT_EQ(calm.calm(moved).force, dvec3(0, 0, 1)) << "nothing jumped";
}

TEST(JumpCancellation, BuriesAboveDeviceForce) {
    for (const double newtons : {7.999, 8.001}) {
        JumpCancellation calm(device());  // of 8 N
        calm.calm(pressing({0, 0, 4}));
        calm.calm(jumping({0, 0, newtons}));
        EXPECT_EQ(repeat(calm, 101, pressing({0, 0, newtons})).force.z, newtons < 8 ? newtons : 0.0);
    }
}

// As where every frame is another picture.
TEST(JumpCancellation, RepeatedBuryingHoldsNoForce) {
    JumpCancellation calm(device());
    double last = calm.calm(pressing({0, 0, 4})).force.z;
    for (int tick = 0; tick <= 100; ++tick) {
        const double force = calm.calm(jumping({0, 0, 60.0 + tick % 7})).force.z;
        EXPECT_LE(force, last + 1e-12);
        last = force;
    }
    EXPECT_EQ(last, 0);
}

TEST(JumpCancellation, CutBackContinuesFromFade) {
    JumpCancellation calm(device());
    calm.calm(pressing({0, 0, 4}));
    calm.calm(jumping({0, 0, 60}));
    EXPECT_NEAR(repeat(calm, 50, pressing({0, 0, 60})).force.z, 2, 1e-12);
    EXPECT_NEAR(calm.calm(jumping({0, 0, 3})).force.z, 2, 1e-12);
    EXPECT_NEAR(repeat(calm, 50, pressing({0, 0, 3})).force.z, 2.5, 1e-12);
}

/// A finger that is inside a new surface.
JumpCancellation waiting() {
    return JumpCancellation({.max_force = 8, .rise = at_once, .waits_to_be_free = true});
}

TEST(JumpCancellation, WaitingFingerGetsNoJump) {
    JumpCancellation calm = waiting();
    const BlendedForce first = calm.calm(pressing({0, 0, 3}));
    EXPECT_EQ(first.force, dvec3(0.0));
    EXPECT_EQ(first.presence, 0) << "nor of what is added to the spring";
    Contact turned = jumping({0, 0, 3});
    turned.jumped_force = {0, 1, -3};  // at the goal before, the new surface would push the other way
    EXPECT_EQ(calm.calm(turned).force, dvec3(0.0));
    for (int tick = 0; tick < 50; ++tick) EXPECT_EQ(calm.calm(pressing({0, 0, 3})).force, dvec3(0.0));
}

// No contact is known of, but that it is free is not known either.
TEST(JumpCancellation, MissingGoalKeepsFingerWaiting) {
    JumpCancellation calm = waiting();
    Contact missing;
    missing.goal_held = true;
    for (int tick = 0; tick < 3; ++tick) EXPECT_FALSE(calm.calm(missing).waiting);
    EXPECT_TRUE(calm.calm(pressing({0, 0, 3})).waiting);
    EXPECT_FALSE(calm.calm(missing).waiting) << "there is nothing to wait for";
    const BlendedForce again = calm.calm(pressing({0, 0, 3}));
    EXPECT_TRUE(again.waiting);
    EXPECT_EQ(again.force, dvec3(0.0));
    calm.calm(Contact{});
    EXPECT_EQ(calm.calm(pressing({0, 0, 3})).force, dvec3(0, 0, 3));
}

TEST(JumpCancellation, ResetRestoresInitialState) {
    for (const bool waits : {false, true}) {
        const GuardSettings settings{.max_force = 8, .rise = at_once, .waits_to_be_free = waits};
        Random random(41);
        for (int run = 0; run < 50; ++run) {
            JumpCancellation used(settings), made(settings);
            for (int tick = 0; tick < 60; ++tick)
                used.calm(near_hole(1 + random.below(20), 100 + random.below(900), random.below(2),
                                    random.below(4) == 0));
            used.reset();
            for (int tick = 0; tick < 30; ++tick) {
                const Contact contact = near_hole(1 + random.below(6), 100 + random.below(900),
                                                  random.below(2), tick > 0 && random.below(4) == 0);
                const BlendedForce a = used.calm(contact), b = made.calm(contact);
                ASSERT_EQ(a.force, b.force) << run << ' ' << tick;
                ASSERT_EQ(a.presence, b.presence);
                ASSERT_EQ(a.waiting, b.waiting);
            }
        }
    }
}

TEST(JumpCancellation, BuryingCutFadesToNothing) {
    JumpCancellation calm(device());
    double last = calm.calm(pressing({0, 0, 4})).force.z;
    BlendedForce out = calm.calm(jumping({0, 0, 60}));
    EXPECT_DOUBLE_EQ(out.force.z, 4);
    for (int tick = 0; tick < 99; ++tick) {
        out = calm.calm(pressing({0, 0, 60}));
        EXPECT_LT(out.force.z, last + 1e-12);
        last = out.force.z;
    }
    out = calm.calm(pressing({0, 0, 60}));
    EXPECT_EQ(out.force, dvec3(0.0));
    // The hand retreats; still inside, still nothing.
    EXPECT_EQ(calm.calm(pressing({0, 0, 5})).force, dvec3(0.0));
    // The next cut brings a surface that it merely touches.
    EXPECT_EQ(calm.calm(jumping({0, 0, 3})).force, dvec3(0.0));
    EXPECT_EQ(repeat(calm, 100, pressing({0, 0, 3})).force, dvec3(0, 0, 3));
}

// docs/solver.md: a jump that fades when k changes near a hole fades in proportion to k. So how deep a hand
// feels itself does not depend on what holes do to the stiffness.
TEST(JumpCancellation, HoleJumpScalesWithStiffness) {
    for (const auto& [max_force, max_stiffness] :
         {std::pair{8.0, 1e4}, {1e6, 1e4}, {1e6, 300.0}}) {  // with jumps that bury, without; a soft device
        const GuardSettings settings{.max_force = max_force, .max_stiffness = max_stiffness, .rise = at_once};
        JumpCancellation even(settings), uneven(settings);
        Random random(23);
        double depth = 4;
        int active = 0;
        bool was_at_hole = false;
        double stiffness = 600;
        for (int tick = 0; tick < 3000; ++tick) {
            const bool jumps = random.below(40) == 0;
            if (jumps) depth = random.below(5) == 0 ? 200 : 1 + random.below(8);
            // It changes while the finger comes to a hole, is at it, and leaves it.
            const bool at_hole = random.below(3) > 0;
            if (at_hole || was_at_hole) stiffness = 100 + random.below(500);
            was_at_hole = at_hole;
            const BlendedForce one = even.calm(near_hole(depth, 600, 0, jumps)),
                               other = uneven.calm(near_hole(depth, stiffness, at_hole ? 0.5 : 0, jumps));
            ASSERT_NEAR(length(other.force) / stiffness, length(one.force) / 600, 1e-9) << tick;
            active += one.active;
        }
        EXPECT_GT(active, 1500);
    }
}

TEST(JumpCancellation, OpeningHoleLimitsBuriedForce) {
    JumpCancellation calm(device());
    ASSERT_EQ(calm.calm(near_hole(4, 600, 0, false)).force.z, 0.001 * 600 * 4);
    EXPECT_NEAR(calm.calm(near_hole(200, 100, 1, true)).force.z, 0.4, 1e-12) << "4 mm at 100 N/m";
    EXPECT_NEAR(repeat(calm, 50, near_hole(200, 100, 1, false)).force.z, 0.2, 1e-12);
}

// Half-way 4.2 of 6 N are given, and so of what softer ground takes.
TEST(JumpCancellation, GivesShareOfOtherStiffness) {
    JumpCancellation calm(device());
    calm.calm(near_hole(4, 600, 0, false));
    calm.calm(near_hole(10, 600, 0, true));
    repeat(calm, 49, near_hole(10, 600, 0, false));
    EXPECT_NEAR(calm.calm(near_hole(10, 500, 0, false)).force.z, 4.2 * 5 / 6, 0.01);
}

TEST(JumpCancellation, LeavingHoleStaysWithinSpring) {
    JumpCancellation calm(device());
    calm.calm(near_hole(4, 600, 0, false));
    calm.calm(near_hole(8, 600, 0, true));
    EXPECT_EQ(calm.calm(near_hole(8, 0, 1, false)).force, dvec3(0.0));
    for (const double hole_share : {0.5, 0.0}) {
        const double newtons = calm.calm(near_hole(8, 600, hole_share, false)).force.z;
        EXPECT_GE(newtons, 0);
        EXPECT_LE(newtons, 4.8);
    }
}

TEST(JumpCancellation, NanForceLeavesNoTrace) {
    JumpCancellation calm(device()), other(device());
    for (JumpCancellation* one : {&calm, &other}) {
        one->calm(pressing({0, 0, 1}));
        one->calm(jumping({0, 0, 5}));
    }
    for (const double bad : {std::nan(""), HUGE_VAL, 1e200}) {
        EXPECT_FALSE(calm.calm(pressing({0, 0, bad})).active);
        Contact contact = jumping({0, 0, 4});
        contact.jumped_force.x = bad;
        EXPECT_EQ(calm.calm(contact).force, contact.force);
    }
    for (int tick = 0; tick < 110; ++tick)
        ASSERT_EQ(calm.calm(pressing({0, 0, 5})).force, other.calm(pressing({0, 0, 5})).force) << tick;
}

TEST(JumpCancellation, PassesNanToGuard) {
    JumpCancellation calm(device());
    calm.calm(pressing({0, 0, 1}));
    calm.calm(jumping({0, 0, 5}));
    EXPECT_TRUE(std::isnan(calm.calm(pressing({0, 0, std::nan("")})).force.z));
}

// A speed is a way over the time that has passed, whether its ticks ran or were skipped.

/// The response of a first-order low pass at 80 Hz to a step after so many milliseconds.
double step_response(int milliseconds) {
    return 1 - std::exp(-2 * pi * 80 * 0.001 * milliseconds);
}

TEST(TickVelocity, IsFirstOrderLowPass) {
    double speed = 0;
    for (int tick = 1; tick <= 40; ++tick) {
        speed = filtered_velocity(speed, 0.002, 1);  // 2 m/s
        EXPECT_NEAR(speed, 2 * step_response(tick), 4e-4) << tick;
    }
}

TEST(TickVelocity, SkippedTicksAreEvenMotion) {
    for (const int ticks : {1, 2, 3, 10, 33, 99, 100, 101, 5000}) {
        double one_by_one = 0.7;
        for (int tick = 0; tick < ticks; ++tick) one_by_one = filtered_velocity(one_by_one, -0.00013, 1);
        EXPECT_NEAR(filtered_velocity(0.7, -0.00013 * ticks, ticks), one_by_one, 1e-14) << ticks;
    }
    const dvec3 rested = filtered_velocity(dvec3(0.5, 0, -1), dvec3(0.0), longest_ticks);
    EXPECT_LT(length(rested), 1e-20);
}

TEST(SkippedTicks, DamperFeelsHandSpeed) {
    StepRig rig;
    rig.guard = {.max_force = 1000, .ramp_in_ticks = 0, .rise = at_once, .damping = 10};
    for (const int every : {1, 2, 10, 50}) {
        rig.begin();
        double damper = 0;
        for (int tick = 7; tick <= 307; tick += every) {
            // 0.2 m/s
            const TouchTick done = rig.run(tick, rig.field.pair(), {0, 0, -99 - 0.2 * (tick - 7)});
            damper = done.forces[0].force.z - done.contacts[0].force.z;
            EXPECT_EQ(done.contacts[0].ticks, tick == 7 ? 1 : every);
            EXPECT_LT(damper, 10 * 0.2 * (1 + 1e-9));
        }
        EXPECT_NEAR(damper, 10 * 0.2, 1e-6) << every;
    }
}

TEST(SkippedTicks, RestartedCountHasNoGap) {
    StepRig rig;
    rig.begin();
    rig.step->goals()[0] = {0, 0, -99};
    const auto ticks = [&](std::int64_t tick) {
        return rig.step->run(tick, 0, rig.field.scene, rig.field.pair()).contacts[0].ticks;
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

TEST_F(SkippedTicksSliding, FrictionFollowsSpeed) {
    double last = 0;
    for (int k = 0; k <= 100; k += 10) last = lag(k, 10);
    EXPECT_NEAR(last, mu, 1e-3);
    EXPECT_NEAR(finger.slip_speed, 0.2, 1e-3);
}

TEST_F(SkippedTicksSliding, HeldGoalKeepsSlipSpeed) {
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
