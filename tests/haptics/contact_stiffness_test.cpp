// A map of stiffness under a finger: what it creates where it may rise freely, and how a rise that must be
// paid for, or takes its time, behaves.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/content/seeded_noise.hpp"
#include "tests/haptics/force_path.hpp"

namespace touchable::test {
namespace {

using glm::dvec3;

constexpr double soft = 100, stiff = 10000;  // N/m
constexpr double depth = 0.8;                // mm
const double step_energy = 0.5 * (stiff - soft) * depth * depth * 1e-6;
constexpr double rounding = 1e-13;

GuardSettings strong(bool paid) {
    GuardSettings settings = without_ramp();
    settings.max_force = 100;
    settings.rise.paid = paid;
    return settings;
}

/// A flat wall at 100, soft on the left of the axis and stiff on the right, without friction.
class TwoStiffnesses : public testing::Test {
protected:
    TwoStiffnesses() : wall(65, 33, 100.0, DepthSemantics::planar) {
        wall.scene.haptic.static_friction = wall.scene.haptic.dynamic_friction = {0, 1};
        paint(wall.prev, 0);
    }
    /// `friction`: 0 to 255.
    void paint(SurfaceFrame& frame, std::uint8_t friction) {
        frame.haptic.clear();
        for (int y = 0; y < frame.height; ++y)
            for (int x = 0; x < frame.width; ++x)
                for (const int value : {x <= frame.width / 2 ? 0 : 255, int(friction), int(friction)})
                    frame.haptic.push_back(static_cast<std::uint8_t>(value));
    }
    static std::vector<dvec3> press_slide_release(double from, double to, double step) {
        return path_along({{from, 0, -99}, {from, 0, -100 - depth}, {to, 0, -100 - depth}, {to, 0, -99}},
                          step);
    }
    PathResult run(double from, double to, double step, bool paid) {
        return run_path(press_slide_release(from, to, step), strong(paid), wall);
    }

    SmallField wall;
};

TEST_F(TwoStiffnesses, AMapThatMayRiseFreelyCreatesTheDifferenceOfTheSprings) {
    const PathResult result = run(-2, 2, 0.002, false);
    EXPECT_NEAR(result.energy.created, step_energy, 0.02 * step_energy);  // 3.2 mJ
    EXPECT_GT(result.energy.created, 10 * result.energy.bound);
}

TEST_F(TwoStiffnesses, ARiseThatMustBePaidForCreatesNothing) {
    double last = 1;
    for (const double step : {0.02, 0.01, 0.005, 0.0025}) {
        const PathResult result = run(-2, 2, step, true);
        EXPECT_LE(result.energy.created, result.energy.bound + rounding);
        EXPECT_LT(result.energy.created, 0.6 * last);
        EXPECT_GT(result.ticks_with(guard_rise), 50);
        last = result.energy.created;
    }
    EXPECT_LT(last, 1e-3 * step_energy);
}

TEST_F(TwoStiffnesses, FromStiffToSoftItFallsAtOnceAndLosesTheDifference) {
    const PathResult free = run(2, -2, 0.002, false), paid = run(2, -2, 0.002, true);
    EXPECT_NEAR(paid.energy.balance(), -step_energy, 0.05 * step_energy);
    ASSERT_EQ(free.forces.size(), paid.forces.size());
    for (std::size_t k = 0; k < free.forces.size(); ++k)
        ASSERT_EQ(free.forces[k].force, paid.forces[k].force) << k;
}

TEST_F(TwoStiffnesses, WhatAFallLostPaysForTheRiseAfterIt) {
    const std::vector<dvec3> path = path_along({{2, 0, -99},
                                                {2, 0, -100 - depth},
                                                {-2, 0, -100 - depth},
                                                {2, 0, -100 - depth},
                                                {2, 0, -100 - depth / 2}},
                                               0.002);
    const PathResult result = run_path(path, strong(true), wall);
    EXPECT_NEAR(result.forces.back().force.z, stiff * depth / 2 * 1e-3, 0.01);
    EXPECT_LE(result.energy.created, result.energy.bound + rounding);
}

TEST_F(TwoStiffnesses, ANewContactBeginsWithTheMapsStiffness) {
    std::vector<dvec3> path = press_slide_release(-2, 2, 0.01);
    const auto again = path_along({{2, 0, -99}, {2, 0, -100 - depth}}, 0.01);
    path.insert(path.end(), again.begin(), again.end());
    const PathResult result = run_path(path, strong(true), wall);
    EXPECT_NEAR(result.forces.back().force.z, stiff * depth * 1e-3, 1e-6);
    EXPECT_EQ(result.forces.back().reasons, guard_none);
}

TEST_F(TwoStiffnesses, WhatOneContactLostPaysForNoOther) {
    std::vector<dvec3> path = press_slide_release(2, -2, 0.01);  // a fall that loses 3.2 mJ
    const auto again = path_along({{-2, 0, -99}, {-2, 0, -100 - depth}, {2, 0, -100 - depth}}, 0.01);
    path.insert(path.end(), again.begin(), again.end());
    const PathResult result = run_path(path, strong(true), wall);
    EXPECT_NEAR(result.forces.back().force.z, soft * depth * 1e-3, 0.01);
    EXPECT_EQ(result.forces.back().reasons, guard_rise);
}

TEST_F(TwoStiffnesses, FrictionPaysForStiffness) {
    paint(wall.prev, 255);  // mu 1
    const PathResult result = run(-2.2, 4, 0.002, true);
    EXPECT_LE(result.energy.created, result.energy.bound + rounding);
    const auto at = [](double goal_x) { return static_cast<std::size_t>((0.9 + 1.1 + goal_x / 2) * 1000); };
    // Losses of 0.08 N over 1.4 mm of soft ground have paid for a part once the proxy is on hard ground;
    // there friction is larger the stiffer it has become.
    const double on_arrival = result.forces[at(1.2)].force.z / depth * 1e3;
    EXPECT_GT(on_arrival, 4 * soft);
    EXPECT_LT(on_arrival, 0.5 * stiff);
    EXPECT_NE(result.forces[at(1.2)].reasons & guard_rise, 0U);
    EXPECT_NEAR(result.forces[at(4)].force.z, stiff * depth * 1e-3, 1e-6);
    EXPECT_EQ(result.forces[at(4)].reasons, guard_none);
}

TEST_F(TwoStiffnesses, AnyPathCreatesNoMoreThanHoldingForcesDoes) {
    wall.scene.default_properties = {600, 0, 0};
    SplitMix64 random(11);
    for (int run = 0; run < 40; ++run) {
        paint(wall.prev, run % 2 == 0 ? 0 : 30);
        std::vector<dvec3> corners;
        for (int k = 0; k < 12; ++k)
            corners.push_back({random.within(-2, 2), random.within(-2, 2), random.within(-101.5, -99.8)});
        GuardSettings settings = strong(true);
        if (run % 4 > 1) settings.max_force = 1.5;
        if (run % 8 > 3) settings.max_stiffness = 3000;
        const PathResult result = run_path(path_along(corners, 0.01), settings, wall);
        EXPECT_LE(result.energy.created, result.energy.bound + rounding) << run;
        EXPECT_GT(result.touching(), 100) << run;
    }
}

TEST_F(TwoStiffnesses, AConstantStiffnessIsLeftAlone) {
    wall.prev.haptic.clear();
    wall.scene.default_properties = {600, 0.4, 0.3};
    const auto path = press_slide_release(-2, 2, 0.01);
    const PathResult free = run_path(path, without_ramp(), wall), paid = run_path(path, strong(true), wall);
    for (std::size_t k = 0; k < path.size(); ++k) {
        ASSERT_EQ(free.forces[k].force, paid.forces[k].force);
        ASSERT_EQ(paid.forces[k].reasons, guard_none);
    }
}

TEST_F(TwoStiffnesses, ARiseTakesItsTimeWhereItIsSlewed) {
    // The map changes under a finger at rest, from one tick to the next.
    auto stiff_everywhere = wall.prev.haptic;
    for (auto& value : stiff_everywhere) value = 255;
    GuardSettings settings = strong(false);
    settings.rise.per_tick = 100;
    ForceGuard guard(settings, 0.001);
    FingerState finger;
    const dvec3 goal{-2, 0, -100 - depth};
    guard.guard(wall.touch(finger, {-2, 0, -99}));
    const double before = guard.guard(wall.touch(finger, goal)).force.z;
    EXPECT_NEAR(before, soft * depth * 1e-3, 1e-9);
    double last = before;
    wall.prev.haptic.swap(stiff_everywhere);
    for (int k = 1; k <= 98; ++k) {
        const GuardedForce out = guard.guard(wall.touch(finger, goal));
        ASSERT_EQ(out.reasons, guard_rise);
        ASSERT_NEAR(out.force.z - last, 100 * depth * 1e-3, 1e-9);
        last = out.force.z;
    }
    EXPECT_EQ(guard.guard(wall.touch(finger, goal)).reasons, guard_none);
    // Down again at once.
    wall.prev.haptic.swap(stiff_everywhere);
    EXPECT_NEAR(guard.guard(wall.touch(finger, goal)).force.z, before, 1e-9);
}

/// A finger at rest, 2 mm deep, on ground of that stiffness.
Contact resting_on(double stiffness) {
    Contact contact;
    contact.touching = true;
    contact.goal = {0, 0, -2};
    contact.properties.stiffness = stiffness;
    contact.carried_stiffness = stiffness;
    contact.force = {0, 0, stiffness * 0.002};
    return contact;
}

/// The same at a hole, whose stiffness has that share.
Contact resting_at_a_hole(double stiffness, double share) {
    Contact contact = resting_on(stiffness);
    contact.hole_share = share;
    return contact;
}

// docs/solver.md: 0.04 N a tick over 2 mm is 20 N/m; and no rise is faster than a slew that is asked for.
TEST(ContactStiffness, OutOfAHoleTheSlowerOfTwoRisesCounts) {
    for (const double slew : {5.0, 15.0, 30.0, 1000.0}) {
        GuardSettings settings = without_ramp();
        settings.rise.per_tick = slew;
        ForceGuard guard(settings, 0.001);
        guard.guard(resting_at_a_hole(100, 1));
        double last = 0.2;
        for (int tick = 0; tick < 20; ++tick) {
            const double force = guard.guard(resting_on(600)).force.z;
            EXPECT_NEAR(force - last, 0.002 * std::min(slew, 20.0), 1e-12) << slew;
            last = force;
        }
    }
}

TEST(ContactStiffness, RisesElsewhereAreNotLimitedOnceItHasArrived) {
    ForceGuard guard(without_ramp(), 0.001);
    guard.guard(resting_at_a_hole(100, 1));
    for (int tick = 0; tick < 24; ++tick) EXPECT_EQ(guard.guard(resting_on(600)).reasons, guard_rise);
    EXPECT_NEAR(guard.guard(resting_on(600)).force.z, 1.2, 1e-9);
    Contact stiffer = resting_on(2000);
    EXPECT_EQ(guard.guard(stiffer).force.z, 4);
    EXPECT_EQ(guard.guard(stiffer).reasons, guard_none);
}

TEST(ContactStiffness, GroundWithoutStiffnessIsContactToo) {
    Contact arriving = resting_on(1000);
    arriving.carried_stiffness = 0;
    ForceGuard paid(strong(true), 0.001);
    paid.guard(resting_on(0));
    for (const Contact& contact : {arriving, resting_on(1000), resting_on(1000)}) {
        const GuardedForce out = paid.guard(contact);
        EXPECT_EQ(out.force, glm::dvec3(0.0)) << "nothing was lost that could pay for it";
        EXPECT_EQ(out.reasons, guard_rise);
    }
    GuardSettings settings = without_ramp();
    settings.damping = 5;
    ForceGuard damped(settings, 0.001);
    damped.guard(resting_on(0));
    EXPECT_EQ(damped.guard(arriving).force, glm::dvec3(0, 0, 2)) << "a hand at rest is not damped";
}

TEST(DeviceSpring, StiffnessIsTheInverseOfEnergy) {
    const DeviceSpring spring{5000, 4};
    for (const double k : {10.0, 700.0, 3000.0, 4999.0})
        for (const double x : {1e-5, 1e-3, 5e-3})
            EXPECT_NEAR(spring.stiffness(spring.energy(k, x * x), x * x), k, 1e-9 * k) << k << ' ' << x;
    EXPECT_EQ(spring.energy(9000, 1e-6), spring.energy(5000, 1e-6));
    EXPECT_TRUE(std::isinf(spring.stiffness(1.0, 1e-6)));
    // Its force is the gradient of its energy, on both sides of the cut.
    for (const double x : {5e-4, 2e-3}) {
        const double h = 1e-8, slope = (spring.energy(4000, (x + h) * (x + h)) -
                                        spring.energy(4000, (x - h) * (x - h))) /
                                       (2 * h);
        EXPECT_NEAR(slope, spring.pull(4000, x * x) * x, 1e-5);
    }
}

}  // namespace
}  // namespace touchable::test
