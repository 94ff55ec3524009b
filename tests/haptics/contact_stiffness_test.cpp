// SPDX-License-Identifier: Apache-2.0
// A map of stiffness under a finger: what it creates where it may rise freely, and how a rise that must be
// paid for, or takes its time, behaves.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "engine/base/same_bits.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "haptics_cpu/world_space.hpp"
#include "tests/haptics/touch_rig.hpp"

namespace touchable::test {
namespace {

constexpr double soft = 100, stiff = 10000;  // N/m
constexpr double depth = 0.8;                // mm
const double step_energy = 0.5 * (stiff - soft) * depth * depth * 1e-6;
constexpr double rounding = 1e-13;

GuardSettings strong(bool paid) {
    return {.max_force = 100, .ramp_in_ticks = 0, .rise = {paid, at_once.per_tick}};
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
    static Path press_slide_release(double from, double to, double step) {
        const double z = -100 - depth;
        return path_along({{from, 0, -99}, {from, 0, z}, {to, 0, z}, {to, 0, -99}}, step);
    }
    PathResult run(double from, double to, double step, bool paid) {
        return run_path(press_slide_release(from, to, step), strong(paid), wall);
    }

    SmallField wall;
};

TEST_F(TwoStiffnesses, FreeRiseCreatesSpringDifference) {
    const PathResult result = run(-2, 2, 0.002, false);
    EXPECT_NEAR(result.energy.created, step_energy, 0.02 * step_energy);  // 3.2 mJ
    EXPECT_GT(result.energy.created, 10 * result.energy.bound);
}

TEST_F(TwoStiffnesses, PaidRiseCreatesNothing) {
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

TEST_F(TwoStiffnesses, FallLosesSpringDifference) {
    const PathResult free = run(2, -2, 0.002, false), paid = run(2, -2, 0.002, true);
    EXPECT_NEAR(paid.energy.balance(), -step_energy, 0.05 * step_energy);
    ASSERT_EQ(free.forces.size(), paid.forces.size());
    for (std::size_t k = 0; k < free.forces.size(); ++k)
        ASSERT_EQ(free.forces[k].force, paid.forces[k].force) << k;
}

TEST_F(TwoStiffnesses, FallPaysForNextRise) {
    const double z = -100 - depth;
    const auto path =
        path_along({{2, 0, -99}, {2, 0, z}, {-2, 0, z}, {2, 0, z}, {2, 0, z + depth / 2}}, 0.002);
    const PathResult result = run_path(path, strong(true), wall);
    EXPECT_NEAR(result.forces.back().force.z, stiff * depth / 2 * 1e-3, 0.01);
    EXPECT_LE(result.energy.created, result.energy.bound + rounding);
}

TEST_F(TwoStiffnesses, NewContactTakesMapStiffness) {
    Path path = press_slide_release(-2, 2, 0.01);
    append(path, path_along({{2, 0, -99}, {2, 0, -100 - depth}}, 0.01));
    const PathResult result = run_path(path, strong(true), wall);
    EXPECT_NEAR(result.forces.back().force.z, stiff * depth * 1e-3, 1e-6);
    EXPECT_EQ(result.forces.back().reasons, guard_none);
}

TEST_F(TwoStiffnesses, LossStaysWithItsContact) {
    Path path = press_slide_release(2, -2, 0.01);  // a fall that loses 3.2 mJ
    append(path, path_along({{-2, 0, -99}, {-2, 0, -100 - depth}, {2, 0, -100 - depth}}, 0.01));
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

TEST_F(TwoStiffnesses, RandomPathsStayWithinBound) {
    wall.scene.default_properties = {600, 0, 0};
    SplitMix64 random(11);
    for (int run = 0; run < 40; ++run) {
        paint(wall.prev, run % 2 == 0 ? 0 : 30);
        Path corners;
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

TEST_F(TwoStiffnesses, LeavesConstantStiffnessAlone) {
    wall.prev.haptic.clear();
    wall.scene.default_properties = {600, 0.4, 0.3};
    const auto path = press_slide_release(-2, 2, 0.01);
    const PathResult free = run_path(path, without_ramp(), wall), paid = run_path(path, strong(true), wall);
    for (std::size_t k = 0; k < path.size(); ++k) {
        ASSERT_EQ(free.forces[k].force, paid.forces[k].force);
        ASSERT_EQ(paid.forces[k].reasons, guard_none);
    }
}

TEST_F(TwoStiffnesses, SlewsRisesOnly) {
    // The map changes under a finger at rest, from one tick to the next, and is taken for what it slips onto.
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
        Contact slipped = wall.touch(finger, goal);
        slipped.jumped = false;
        const GuardedForce out = guard.guard(slipped);
        ASSERT_EQ(out.reasons, guard_rise);
        ASSERT_NEAR(out.force.z - last, 100 * depth * 1e-3, 1e-9);
        last = out.force.z;
    }
    EXPECT_EQ(guard.guard(wall.touch(finger, goal)).reasons, guard_none);
    // Down again at once.
    wall.prev.haptic.swap(stiff_everywhere);
    EXPECT_NEAR(guard.guard(wall.touch(finger, goal)).force.z, before, 1e-9);
}

// From 600 to 900 N/m, under a goal that moves by 0.01 mm.
TEST(ContactStiffness, SlipOntoStifferGroundDoesNotKick) {
    FingerGuard guard({.ramp_in_ticks = 0, .rise = {}}, 0.001);
    const auto on = [](double stiffness, double carried, double depth) {
        Contact contact = pressing({0, 0, 0.001 * stiffness * depth}, stiffness);
        contact.carried_stiffness = carried;
        return contact;
    };
    double last = guard.guard(on(600, 600, 10)).force.z;
    for (int tick = 0; tick < 75; ++tick) {
        const double force = guard.guard(on(900, tick == 0 ? 600 : 900, 10.01)).force.z;
        EXPECT_LE(force - last, 0.6 * 0.01 + 0.01001 * 4 + 1e-9) << tick;
        last = force;
    }
    EXPECT_NEAR(last, 9.009, 1e-9);
}

/// A finger at rest, 2 mm deep, on ground of that stiffness.
Contact resting_on(double stiffness) {
    Contact contact = pressing({0, 0, stiffness * 0.002}, stiffness);
    contact.goal = {0, 0, -2};
    contact.carried_stiffness = stiffness;
    return contact;
}

/// The same in a hole of 100 N/m.
Contact resting_in_hole() {
    Contact contact = resting_on(100);
    contact.hole_share = 1;
    return contact;
}

// docs/solver.md: 0.04 N a tick over 2 mm is 20 N/m; and no rise is faster than a slew that is asked for.
TEST(ContactStiffness, SlowerRiseCountsLeavingHole) {
    for (const double slew : {5.0, 15.0, 30.0, 1000.0}) {
        ForceGuard guard({.ramp_in_ticks = 0, .rise = {.per_tick = slew}}, 0.001);
        guard.guard(resting_in_hole());
        double last = 0.2;
        for (int tick = 0; tick < 20; ++tick) {
            const double force = guard.guard(resting_on(600)).force.z;
            EXPECT_NEAR(force - last, 0.002 * std::min(slew, 20.0), 1e-12) << slew;
            last = force;
        }
    }
}

TEST(ContactStiffness, RiseLimitEndsOnArrival) {
    ForceGuard guard(without_ramp(), 0.001);
    guard.guard(resting_in_hole());
    for (int tick = 0; tick < 24; ++tick) EXPECT_EQ(guard.guard(resting_on(600)).reasons, guard_rise);
    EXPECT_NEAR(guard.guard(resting_on(600)).force.z, 1.2, 1e-9);
    EXPECT_EQ(guard.guard(resting_on(2000)).force.z, 4);
    EXPECT_EQ(guard.guard(resting_on(2000)).reasons, guard_none);
}

TEST(ContactStiffness, GroundWithoutStiffnessIsContact) {
    Contact arriving = resting_on(1000);
    arriving.carried_stiffness = 0;
    ForceGuard paid(strong(true), 0.001);
    paid.guard(resting_on(0));
    for (const Contact& contact : {arriving, resting_on(1000), resting_on(1000)}) {
        const GuardedForce out = paid.guard(contact);
        EXPECT_EQ(out.force, glm::dvec3(0.0)) << "nothing was lost that could pay for it";
        EXPECT_EQ(out.reasons, guard_rise);
    }
    ForceGuard damped({.ramp_in_ticks = 0, .rise = at_once, .damping = 5}, 0.001);
    damped.guard(resting_on(0));
    EXPECT_EQ(damped.guard(arriving).force, glm::dvec3(0, 0, 2)) << "a hand at rest is not damped";
}

TEST(DeviceSpring, StiffnessInvertsEnergy) {
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

// Stiffness and friction that change in time under a finger at rest: what the hand feels of it, tick by tick,
// through the whole tick.

/// Figures of a rest of some ticks.
struct Rest {
    double first = 0, last = 0;  ///< N
    double steepest_rise = 0;    ///< of |F|, N in a tick
    double farthest = 0;         ///< that the proxy went in a tick, scene units
    int jumps = 0, cancelled = 0;
};

/// One finger that rests at a goal under the surface, from tick 1 on.
template <class FrameOf>
Rest rest_at(const dvec3& goal, int ticks, const Scene& scene, FrameOf frame_of) {
    const TouchSolver solver =
        TouchSolver::create(scene, {.metres_per_scene_unit = scene.device_metres_per_unit.value_or(0.001)})
            .value();
    TouchStep step(solver, without_ramp(), 1);
    Rest rest;
    dvec3 proxy(0.0);
    for (int tick = 0; tick < ticks; ++tick) {
        step.goals()[0] = tick == 0 ? goal * 0.5 : goal;
        const std::int64_t time_ns = tick * 1'000'000LL;
        const TouchTick done = step.run(tick, time_ns, scene, pair_around(time_ns, scene.rate, frame_of));
        const double force = glm::length(done.forces[0].force);
        if (tick == 1) rest.first = force;
        if (tick > 1) {
            rest.steepest_rise = std::max(rest.steepest_rise, force - rest.last);
            rest.farthest = std::max(rest.farthest, glm::distance(done.contacts[0].proxy, proxy));
        }
        proxy = done.contacts[0].proxy;
        rest.last = force;
        rest.jumps += done.contacts[0].jumped;
        rest.cancelled += (done.forces[0].reasons & guard_jump) != 0;
    }
    return rest;
}

/// A wall whose haptic image is another from frame 2 on.
class ChangingWall {
public:
    ChangingWall(FrameInterpolation interpolation, std::array<std::uint8_t, 3> before,
                 std::array<std::uint8_t, 3> after)
        : field(33, 33, 100.0, DepthSemantics::planar) {
        field.scene.interpolation = interpolation;
        field.scene.device_metres_per_unit = 0.001;
        field.scene.haptic = {{0.1, 10.0}, {0.0, 1.0}, {0.0, 1.0}};
        for (int k = 0; k < 33 * 33; ++k) {
            field.prev.haptic.insert(field.prev.haptic.end(), before.begin(), before.end());
            field.next.haptic.insert(field.next.haptic.end(), after.begin(), after.end());
        }
    }
    const SurfaceFrame* frame(std::int64_t n) const { return n < 2 ? &field.prev : &field.next; }
    Rest rest(const dvec3& goal, int ticks = 300) const {
        return rest_at(goal, ticks, field.scene, [this](std::int64_t n) { return frame(n); });
    }

    SmallField field;
};

/// The steepest of a fade.
double steepest_fade(double newtons) {
    return newtons * 1.5 / JumpCancellation::fade_ticks;
}

class ChangingProperties : public testing::TestWithParam<FrameInterpolation> {};

TEST_P(ChangingProperties, StiffeningMakesNoStep) {
    const Rest rest = ChangingWall(GetParam(), {0, 0, 0}, {255, 0, 0}).rest({0.1, 0.1, -100.8});
    EXPECT_NEAR(rest.first, 0.08, 1e-9);
    EXPECT_NEAR(rest.last, 8.0, 1e-9);
    // Unblended and uncancelled it would be 7.92 in a tick; blended alone, 0.24.
    // A fifth for fades that overlap, where it comes in many small jumps.
    const double overlap = GetParam() == FrameInterpolation::linear ? 1.2 : 1.001;
    EXPECT_LE(rest.steepest_rise, overlap * steepest_fade(7.92));
    EXPECT_GT(rest.jumps, 0);
    EXPECT_GT(rest.cancelled, 90);
}

TEST_P(ChangingProperties, CoastMakesNoStep) {
    const Rest rest = ChangingWall(GetParam(), {8, 0, 0}, {28, 0, 0}).rest({0.1, 0.1, -101.2});
    EXPECT_GT(rest.last - rest.first, 0.9);
    EXPECT_LE(rest.steepest_rise, 0.1);
    // Held, it is a jump; interpolated, the ground turns stiff in its own time.
    EXPECT_EQ(rest.jumps > 0, GetParam() == FrameInterpolation::hold);
}

TEST_P(ChangingProperties, SmallChangeIsNoJump) {
    const Rest rest = ChangingWall(GetParam(), {100, 0, 0}, {102, 0, 0}).rest({0.1, 0.1, -101.2});
    EXPECT_GT(rest.last - rest.first, 0.09);
    EXPECT_EQ(rest.jumps, 0);
    EXPECT_EQ(rest.cancelled, 0);
}

TEST_P(ChangingProperties, ForceDropsAtOnce) {
    const Rest rest = ChangingWall(GetParam(), {255, 0, 0}, {0, 0, 0}).rest({0.1, 0.1, -100.8}, 80);
    EXPECT_NEAR(rest.first, 8.0, 1e-9);
    EXPECT_NEAR(rest.last, 0.08, 1e-9);
    EXPECT_LE(rest.steepest_rise, 1e-12);
}

TEST_P(ChangingProperties, VanishingFrictionIsNoJump) {
    // Held at mu_s 1 where it would slide 0.7 away; the ground turns slippery.
    const ChangingWall wall(GetParam(), {100, 255, 255}, {100, 0, 0});
    const Scene& scene = wall.field.scene;
    FingerState finger;
    wall.field.touch(finger, {0.1, 0.1, -99});
    wall.field.touch(finger, {0.1, 0.1, -101});
    const TouchSolver solver = TouchSolver::create(scene, {}).value();
    Contact contact;
    for (int tick = 0; tick < 100; ++tick) {
        const FramePair pair =
            pair_around(tick * 1'000'000, scene.rate, [&](std::int64_t n) { return wall.frame(n); });
        contact = tick_one(solver, {scene, pair}, finger, {0.8, 0.1, -101});
        EXPECT_FALSE(contact.jumped) << tick;
        if (tick == 0) {
            EXPECT_NEAR(contact.proxy.x, 0.1, 1e-12);
        }
    }
    EXPECT_NEAR(contact.proxy.x, 0.8, 1e-9);
}

TEST_P(ChangingProperties, CancelsCutsInEveryMetric) {
    for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled}) {
        const ChangingWall wall(GetParam(), {0, 0, 0}, {255, 0, 0});
        const TouchSolver solver = TouchSolver::create(wall.field.scene, {.metric = metric}).value();
        FingerState finger;
        const auto tick_on = [&](const SurfaceFrame& frame, std::int64_t number, double z = -100.8) {
            const FramePair pair = still(frame, number, number * 33'000'000);
            return tick_one(solver, {wall.field.scene, pair}, finger, {0.1, 0.1, z});
        };
        tick_on(wall.field.prev, 0, -50);
        const Contact before = tick_on(wall.field.prev, 0), cut = tick_on(wall.field.next, 1);
        ASSERT_TRUE(before.touching);
        EXPECT_FALSE(before.jumped);
        EXPECT_TRUE(cut.jumped) << name_of(metric);
        EXPECT_NEAR(glm::distance(cut.jumped_force, cut.force), 0, 1e-9);
        EXPECT_NEAR(cut.force.z, 8.0, 1e-2);
        EXPECT_FALSE(tick_on(wall.field.next, 1).jumped);
    }
}

TEST_P(ChangingProperties, MovingCoastMakesNoClick) {
    SceneOptions options = sized(96, 64);
    options.properties = true;
    TouchRig rig("globe", options, TouchRig::Depth::codes);
    rig.scene().interpolation = GetParam();
    constexpr int made = 6;
    std::array<SurfaceFrame, made> frames;
    for (int n = 0; n < made; ++n) rig.load(n, TouchRig::Depth::codes, frames[static_cast<std::size_t>(n)]);
    const auto frame_of = [&](std::int64_t n) {
        return &frames[static_cast<std::size_t>(std::min<std::int64_t>(n, made - 1))];
    };
    const double metres = rig.scene().device_metres_per_unit.value_or(0.001);
    double most = 0;
    int changing = 0, cancelled = 0;
    for (int y = 14; y < 52; y += 3)
        for (int x = 30; x < 68; x += 2) {
            // 1.2 mm of the device under the ground of frame 0, along the ray.
            const Camera& camera = rig.scene().camera;
            const double range = rig.field().vertex(x, y).depth;
            const double deep = range + 0.0012 / metres;
            const dvec3 goal = deep / camera.ray_length(x, y) * dvec3(camera.u(x), camera.v(y), -1.0);
            // Heights travel with the planet, and move the surface as well.
            const Rest rest = rest_at(goal, made * 33, rig.scene(), frame_of);
            const double moved = 1.3 * metres * rest.farthest * 1000;
            most = std::max(most, rest.steepest_rise - moved);
            changing += std::abs(rest.last - rest.first) > 0.2;
            cancelled += rest.cancelled > 0;
        }
    // A change below the threshold of a jump, beside the fade of an earlier jump.
    EXPECT_LE(most, GetParam() == FrameInterpolation::hold ? 0.1 + steepest_fade(1.0) : 0.1);
    EXPECT_GT(changing, 5);
    std::cout << "largest rise " << most << " N, " << changing << " fingers on ground that changes, "
              << cancelled << " of them cancelled\n";
}

INSTANTIATE_TEST_SUITE_P(Frames, ChangingProperties,
                         testing::Values(FrameInterpolation::hold, FrameInterpolation::linear), name_of_run);

// Holes in the depth whose walls are as stiff as the scene says: where that stiffness is felt, when, and how
// a finger gets out of it again.

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();
constexpr double scene_k = 600, hole_k = 100;  // N/m

/// Flat ground at 100 of 600 N/m without friction.
class HoleyField : public SmallField {
public:
    HoleyField(int width, int height, std::optional<double> hole_stiffness = hole_k / 1000)
        : SmallField(width, height, 100.0, DepthSemantics::planar) {
        scene.default_properties = {scene_k, 0, 0};
        scene.hole_stiffness = hole_stiffness;
    }
};

TEST(HoleStiffness, FadesOverNeighbouringCells) {
    HoleyField small(20, 20);
    small.set(small.prev, 10, 10, nothing);
    const HeightField field = small.field();
    const auto k = [&](double x, double y) {
        const auto i = static_cast<int>(x), j = static_cast<int>(y);
        const double stiffness = field.properties(i, j, x - i, y - j).stiffness;
        EXPECT_EQ(stiffness, field.stiffness(i, j, x - i, y - j));
        return stiffness;
    };
    for (const auto& [x, y] : {std::pair{10.0, 10.0}, {9.0, 9.0}, {9.25, 10.5}, {10.75, 9.5}, {10.5, 9.125}})
        EXPECT_EQ(k(x, y), hole_k) << x << ' ' << y;
    EXPECT_EQ(k(8.5, 10), (scene_k + hole_k) / 2);
    EXPECT_EQ(k(10, 11.75), 0.25 * hole_k + 0.75 * scene_k);
    EXPECT_EQ(k(8.5, 8.5), 0.25 * hole_k + 0.75 * scene_k);
    for (const auto& [x, y] : {std::pair{8.0, 10.0}, {7.5, 9.5}, {12.0, 12.5}, {10.0, 12.0}})
        EXPECT_EQ(k(x, y), scene_k) << x << ' ' << y;
}

TEST(HoleStiffness, AppliesBeyondPicture) {
    const HoleyField small(20, 20);
    EXPECT_EQ(small.field().stiffness(-1, 5, 0.5, 0), hole_k);
    EXPECT_EQ(small.field().stiffness(900, -7, 0.5, 0.5), hole_k);
    EXPECT_EQ(small.field().stiffness(18, 5, 0.5, 0), (scene_k + hole_k) / 2);
    EXPECT_EQ(small.field().stiffness(17, 5, 0.5, 0), scene_k);
}

TEST(HoleStiffness, OverridesHapticImage) {
    HoleyField small(20, 20);
    small.scene.haptic = {{2, 2}, {0, 0}, {0, 0}};
    small.prev.haptic.assign(3 * 400, 0);
    small.set(small.prev, 10, 10, nothing);
    EXPECT_EQ(small.field().stiffness(9, 9, 0.5, 0.5), hole_k);
    EXPECT_EQ(small.field().stiffness(5, 5, 0.5, 0.5), 2000);
    EXPECT_EQ(small.field().properties(8, 10, 0.5, 0).stiffness, 1050);
}

TEST(HoleStiffness, RampsBeforeHoleOpens) {
    HoleyField small(20, 20);
    small.set(small.next, 10, 10, nothing);
    EXPECT_EQ(small.field(0).stiffness(10, 10, 0, 0), scene_k);
    EXPECT_EQ(small.field(0.25).stiffness(10, 10, 0, 0), (scene_k + hole_k) / 2);
    EXPECT_EQ(small.field(0.5).stiffness(10, 10, 0, 0), hole_k);
    EXPECT_EQ(small.field(0.75).stiffness(9, 9, 0.5, 0.5), hole_k);
    std::swap(small.prev.vertices, small.next.vertices);
    EXPECT_EQ(small.field(0).stiffness(10, 10, 0, 0), hole_k);
    EXPECT_EQ(small.field(0.4375).stiffness(10, 10, 0, 0), hole_k);
    EXPECT_EQ(small.field(0.5).stiffness(10, 10, 0, 0), scene_k);
    small.scene.interpolation = FrameInterpolation::hold;
    EXPECT_EQ(small.field(0.75).stiffness(10, 10, 0, 0), hole_k);
}

TEST(HoleStiffness, DefaultsToPixelStiffness) {
    HoleyField small(20, 20, std::nullopt);
    small.set(small.prev, 10, 10, nothing);
    EXPECT_EQ(small.field().stiffness(9, 9, 0.5, 0.5), scene_k);
    EXPECT_EQ(small.field().hole_share(9, 9, 0.5, 0.5), 0);
}

/// Ground at 100 on the left, and right of pixel 32 nothing down to 400: above row 32 because there is no
/// depth, below it because that is the depth. One wall, half of it a hole's.
class CliffAndHole : public HoleyField {
public:
    explicit CliffAndHole(std::optional<double> hole_stiffness, bool has_hole = true)
        : HoleyField(65, 65, hole_stiffness) {
        shape(prev, [=](int x, int y) { return x < 32 ? 100.0 : (has_hole && y < 32 ? nothing : 400.0); });
    }
};

class HoleWall : public testing::Test {
protected:
    /// 10 mm below the ground's level, 30 mm behind the wall, then along the wall: from its half at rows
    /// above 32 to the other, or back; then at rest.
    static Path along(double from_y, double to_y) {
        auto path = path_along({{2, from_y, -50}, {2, from_y, -110}, {-30, from_y, -110}}, 0.1);
        append(path, path_along({path.back(), {-30, to_y, -110}}, 0.02));
        path.insert(path.end(), 800, path.back());
        return path;
    }
    static double newtons(const GuardedForce& force) { return length(force.force); }
    /// How far a proxy is from its goal, metres.
    static double stretch(const Contact& contact) { return 0.001 * length(contact.proxy - contact.goal); }
};

TEST_F(HoleWall, IsSoftBehindHole) {
    const auto path = path_along({{2, 3.3, -50}, {2, 3.3, -101}, {-30, 3.3, -101}, {-30, 3.3, -180}}, 0.1);
    const CliffAndHole softer(hole_k / 1000), hard(std::nullopt);
    const PathResult felt = run_path(path, without_ramp(), softer),
                     was = run_path(path, without_ramp(), hard);
    int caught = 0;
    for (std::size_t k = 0; k < path.size(); ++k) {
        const Contact& contact = felt.contacts[k];
        EXPECT_EQ(contact.proxy, was.contacts[k].proxy);
        EXPECT_EQ(contact.in_hole, was.contacts[k].in_hole);
        if (!contact.touching) continue;
        ++caught;
        ASSERT_TRUE(contact.in_hole);
        ASSERT_EQ(contact.properties.stiffness, hole_k);
        ASSERT_EQ(was.contacts[k].properties.stiffness, scene_k);
    }
    EXPECT_GT(caught, 300);
    EXPECT_NEAR(newtons(felt.forces.back()), hole_k * stretch(felt.contacts.back()), 1e-9);
    EXPECT_GT(stretch(felt.contacts.back()), 0.025);
    EXPECT_EQ(was.forces.back().reasons, guard_force);
}

TEST_F(HoleWall, LimitsRiseLeavingHole) {
    const CliffAndHole field(hole_k / 1000);
    for (const double deep : {30.0, 5.0}) {
        auto path = along(3.3, -3.6);
        for (dvec3& goal : path) goal.x = std::max(goal.x, -deep);
        const PathResult result = run_path(path, without_ramp(), field);
        const std::size_t at_wall = 1000;
        EXPECT_NEAR(stretch(result.contacts[at_wall]), deep / 1000, 5e-4);
        EXPECT_NEAR(newtons(result.forces[at_wall]), hole_k * stretch(result.contacts[at_wall]), 1e-9);
        double fastest = 0;
        for (std::size_t k = at_wall; k < path.size(); ++k)
            fastest = std::max(fastest, length(result.forces[k].force - result.forces[k - 10].force));
        EXPECT_LE(fastest, 0.5) << deep;
        EXPECT_GT(fastest, 0.3) << deep;
        EXPECT_GT(result.ticks_with(guard_rise), 50);
        // In the end it is the wall that it always was.
        const double whole = scene_k * stretch(result.contacts.back());
        EXPECT_NEAR(newtons(result.forces.back()), std::min(10.0, whole), 1e-9);
        EXPECT_EQ(result.forces.back().reasons & guard_rise, 0U);
    }
}

TEST_F(HoleWall, FallsAtOnceEnteringHole) {
    const PathResult result = run_path(along(-3.6, 3.3), without_ramp(), CliffAndHole(hole_k / 1000));
    EXPECT_EQ(result.ticks_with(guard_rise), 0);
    EXPECT_NEAR(newtons(result.forces.back()), hole_k * stretch(result.contacts.back()), 1e-9);
}

TEST_F(HoleWall, NewContactOutsideIsStiff) {
    auto path = path_along({{2, 3.3, -50}, {2, 3.3, -110}, {-20, 3.3, -110}, {-2, 3.3, -110}}, 0.1);
    append(path, path_along({{2, 3.3, -110}, {2, 3.3, -90}, {-2, 3.3, -90}, {-2, 3.3, -102}}, 0.1));
    const PathResult result = run_path(path, without_ramp(), CliffAndHole(hole_k / 1000));
    EXPECT_FALSE(result.contacts.back().in_hole);
    EXPECT_EQ(result.forces.back().reasons, guard_none);
    EXPECT_NEAR(newtons(result.forces.back()), scene_k * 0.002, 1e-9);
}

TEST_F(HoleWall, HoleStiffnessIgnoresValidCliffs) {
    for (const bool has_haptic_image : {false, true}) {
        CliffAndHole with(hole_k / 1000, false), without(std::nullopt, false);
        for (CliffAndHole* field : {&with, &without})
            for (int y = 0; y < 65 && has_haptic_image; ++y)
                for (int x = 0; x < 65; ++x)
                    field->prev.haptic.insert(field->prev.haptic.end(),
                                              {static_cast<std::uint8_t>(y < 32 ? 5 : 200), 40, 20});
        const PathResult a = run_path(along(3.3, -3.6), without_ramp(), with),
                         b = run_path(along(3.3, -3.6), without_ramp(), without);
        EXPECT_GT(b.touching(), 1000);
        for (std::size_t k = 0; k < a.forces.size(); ++k) {
            ASSERT_EQ(a.forces[k].force, b.forces[k].force) << k;
            ASSERT_EQ(a.forces[k].reasons, b.forces[k].reasons) << k;
            ASSERT_FALSE(a.contacts[k].in_hole);
        }
    }
}

TEST_F(HoleWall, AllowsZeroStiffness) {
    const PathResult result = run_path(along(3.3, 3.2), without_ramp(), CliffAndHole(0));
    EXPECT_TRUE(result.contacts.back().touching);
    EXPECT_EQ(newtons(result.forces.back()), 0);
}

/// A finger at rest 5 mm deep on the ground, a pixel beside a hole that opens or closes.
TEST(HoleStiffness, ClosingHoleDoesNotKick) {
    HoleyField field(65, 65);
    field.set(field.prev, 34, 32, nothing);
    FingerGuard guard(without_ramp(), 0.001);
    FingerState finger;
    guard.guard(field.touch(finger, {0.1, 0, -90}));
    const dvec3 goal{0.1, 0, -105};
    for (int tick = 0; tick < 200; ++tick) guard.guard(field.touch(finger, goal));
    double last = length(guard.guard(field.touch(finger, goal)).force);
    EXPECT_LT(last, 0.6 * scene_k * 0.005);
    field.set(field.prev, 34, 32, 100);
    double fastest = 0;
    for (int tick = 0; tick < 200; ++tick) {
        const double now = length(guard.guard(field.touch(finger, goal)).force);
        fastest = std::max(fastest, now - last);
        last = now;
    }
    EXPECT_NEAR(fastest, rise_from_hole, 1e-9);
    EXPECT_NEAR(last, scene_k * 0.005, 1e-9);
}

/// The ground becomes stiffer under a finger at rest. Its place, (40.4, 32), is 0.4 of the way to a
/// neighbour of the pixel that may become a hole in the same tick.
TEST(HoleStiffness, JumpsOnlyWithoutHole) {
    for (const bool opens : {false, true}) {
        HoleyField field(65, 64);
        FingerState finger;
        field.touch(finger, {1.975, 0, -90});
        field.touch(finger, {1.975, 0, -105});
        field.scene.default_properties.stiffness = 1000;
        if (opens) field.set(field.prev, 42, 31, nothing);
        const Contact contact = field.touch(finger, {1.975, 0, -105});
        EXPECT_NEAR(contact.hole_share, opens ? 0.4 : 0, 1e-9);
        EXPECT_EQ(contact.jumped, !opens);
    }
}

TEST_F(HoleWall, BecomesCliffWithoutKick) {
    CliffAndHole field(hole_k / 1000);
    field.shape(field.next, [](int x, int) { return x < 32 ? 100.0 : 400.0; });
    FingerGuard guard(without_ramp(), 0.001);
    FingerState finger;
    Path forces;
    const auto touch = [&](const dvec3& goal, double blend) {
        forces.push_back(guard.guard(field.touch(finger, goal, blend)).force);
    };
    for (const dvec3& goal : path_along({{2, 3.3, -50}, {2, 3.3, -110}, {-30, 3.3, -110}}, 0.1))
        touch(goal, 0);
    const std::size_t caught = forces.size();
    for (int tick = 0; tick < 600; ++tick) touch({-30, 3.3, -110}, std::min(0.99, 0.03 * tick));
    double fastest = 0;
    for (std::size_t k = caught; k < forces.size(); ++k)
        fastest = std::max(fastest, length(forces[k] - forces[k - 10]));
    EXPECT_NEAR(length(forces[caught]), hole_k * 0.03, 0.1);
    EXPECT_NEAR(length(forces.back()), 10, 1e-9);
    EXPECT_NEAR(fastest, 10 * rise_from_hole, 1e-6);
}

/// A surface that jumps from 4 to 12 mm in front of a goal when its hole closes; a few ticks later the hole
/// opens again, and at last it is gone. The jump takes its 100 ms, and the stiffness its time.
TEST(HoleStiffness, JumpFadesInEvenly) {
    FingerGuard guard(without_ramp(), 0.001);
    std::vector<double> forces;
    for (int tick = 0; tick < 1000; ++tick) {
        const bool jumped = tick >= 10;
        const double x = jumped ? 12 : 4;
        double hole_share = !jumped ? 1.0 : std::clamp((tick - 20) / 16.0, 0.0, 1.0);
        if (tick >= 60) hole_share = 0;
        const double k = scene_k + (hole_k - scene_k) * hole_share;
        Contact contact = pressing({0, 0, 0.001 * k * x}, k);
        contact.hole_share = hole_share;
        contact.carried_stiffness = k;
        contact.jumped = tick == 10;
        if (contact.jumped) contact.jumped_force = contact.force;
        forces.push_back(length(guard.guard(contact).force));
    }
    double fastest = 0;
    for (std::size_t k = 10; k < forces.size(); ++k) fastest = std::max(fastest, forces[k] - forces[k - 10]);
    EXPECT_NEAR(forces[9], 0.4, 1e-9);
    EXPECT_NEAR(forces[10], 0.4, 0.1);
    EXPECT_NEAR(forces.back(), 7.2, 1e-9);
    // The fade is at its steepest half-way, 1.5 of the jump in 100 ms: 8 mm at the stiffness of that moment.
    EXPECT_LT(fastest, 10 * rise_from_hole + 0.15 * 0.008 * 300);
    EXPECT_GT(fastest, 10 * rise_from_hole);
}

TEST(HoleStiffness, HoleNeedsAnInvalidVertex) {
    HoleyField small(20, 20);
    small.set(small.prev, 10, 10, nothing);
    const HeightField field = small.field();
    const WorldSpace space(field);
    const auto in_hole = [&](Feature feature, int i, int j) {
        Place place;
        place.feature = feature;
        place.i = i;
        place.j = j;
        return is_in_hole(space, place);
    };
    EXPECT_FALSE(in_hole(Feature::free, 10, 10));
    EXPECT_TRUE(in_hole(Feature::vertex, 10, 10));
    EXPECT_FALSE(in_hole(Feature::vertex, 9, 10));
    EXPECT_TRUE(in_hole(Feature::vertex, -1, 10));  // the ring
    EXPECT_TRUE(in_hole(Feature::edge_h, 9, 10));
    EXPECT_FALSE(in_hole(Feature::edge_h, 9, 11));
    EXPECT_TRUE(in_hole(Feature::edge_v, 10, 9));
    EXPECT_FALSE(in_hole(Feature::edge_v, 9, 9));
    EXPECT_TRUE(in_hole(Feature::edge_d, 9, 9));
    EXPECT_FALSE(in_hole(Feature::edge_d, 9, 10));
    // Six of the eight triangles of the cells around it have that vertex.
    EXPECT_TRUE(in_hole(Feature::face_lower, 9, 9));
    EXPECT_TRUE(in_hole(Feature::face_upper, 9, 9));
    EXPECT_TRUE(in_hole(Feature::face_lower, 10, 10));
    EXPECT_TRUE(in_hole(Feature::face_upper, 10, 10));
    EXPECT_TRUE(in_hole(Feature::face_lower, 9, 10));
    EXPECT_FALSE(in_hole(Feature::face_upper, 9, 10));
    EXPECT_FALSE(in_hole(Feature::face_lower, 10, 9));
    EXPECT_TRUE(in_hole(Feature::face_upper, 10, 9));
}

}  // namespace
}  // namespace touchable::test
