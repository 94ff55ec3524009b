// Stiffness and friction that change in time under a finger at rest: what the hand feels of it, tick by tick,
// through the whole tick.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "haptics_cpu/touch_step.hpp"
#include "tests/haptics/small_field.hpp"
#include "tests/haptics/touch_rig.hpp"

namespace touchable::test {
namespace {

using glm::dvec3;

/// The frames around a tick of a clip whose frames are at `rate`.
template <class FrameOf>
FramePair pair_at(std::int64_t tick, const FrameRate& rate, FrameOf frame_of) {
    const std::int64_t time_ns = tick * 1'000'000;
    std::int64_t n = 0;
    while (rate.time_ns(n + 1) <= time_ns) ++n;
    FramePair pair;
    pair.prev = {n, rate.time_ns(n), frame_of(n)};
    pair.next = {n + 1, rate.time_ns(n + 1), frame_of(n + 1)};
    pair.blend = static_cast<double>(time_ns - pair.prev.time_ns) /
                 static_cast<double>(pair.next.time_ns - pair.prev.time_ns);
    return pair;
}

/// What came of a rest of some ticks.
struct Rest {
    double first = 0, last = 0;  ///< N
    double steepest_rise = 0;    ///< of |F|, N in a tick
    double farthest = 0;         ///< that the proxy went in a tick, scene units
    int jumps = 0, cancelled = 0;
};

/// One finger that rests at a goal under the surface, from tick 1 on.
template <class FrameOf>
Rest rest_at(const dvec3& goal, int ticks, const Scene& scene, FrameOf frame_of) {
    TouchSettings settings;
    settings.metres_per_scene_unit = scene.device_metres_per_unit.value_or(0.001);
    GuardSettings guard;
    guard.ramp_in_ticks = 0;
    const TouchSolver solver = TouchSolver::create(scene, settings).value();
    TouchStep step(solver, guard, 1);
    Rest rest;
    dvec3 proxy(0.0);
    for (int tick = 0; tick < ticks; ++tick) {
        step.goals()[0] = tick == 0 ? goal * 0.5 : goal;
        const TouchTick done = step.run(tick, tick * 1'000'000LL, scene, pair_at(tick, scene.rate, frame_of));
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
    Rest rest(const dvec3& goal, int ticks = 300) const {
        return rest_at(goal, ticks, field.scene,
                       [this](std::int64_t n) { return n < 2 ? &field.prev : &field.next; });
    }

    SmallField field;
};

/// The steepest of a fade.
double steepest_fade(double newtons) {
    return newtons * 1.5 / JumpCancellation::fade_ticks;
}

class ChangingProperties : public testing::TestWithParam<FrameInterpolation> {};

TEST_P(ChangingProperties, GroundThatTurnsFromTheSoftestToTheStiffestIsNoStep) {
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

TEST_P(ChangingProperties, AsMuchAsFromSeaToLandIsNoStepOfATenthOfANewton) {
    const Rest rest = ChangingWall(GetParam(), {8, 0, 0}, {28, 0, 0}).rest({0.1, 0.1, -101.2});
    EXPECT_GT(rest.last - rest.first, 0.9);
    EXPECT_LE(rest.steepest_rise, 0.1);
    // Held, it is a jump; interpolated, the ground turns stiff in its own time.
    EXPECT_EQ(rest.jumps > 0, GetParam() == FrameInterpolation::hold);
}

TEST_P(ChangingProperties, WhatIsLessThanATenthOfANewtonIsNoJump) {
    const Rest rest = ChangingWall(GetParam(), {100, 0, 0}, {102, 0, 0}).rest({0.1, 0.1, -101.2});
    EXPECT_GT(rest.last - rest.first, 0.09);
    EXPECT_EQ(rest.jumps, 0);
    EXPECT_EQ(rest.cancelled, 0);
}

TEST_P(ChangingProperties, AForceThatDropsDropsAtOnce) {
    const Rest rest = ChangingWall(GetParam(), {255, 0, 0}, {0, 0, 0}).rest({0.1, 0.1, -100.8}, 80);
    EXPECT_NEAR(rest.first, 8.0, 1e-9);
    EXPECT_NEAR(rest.last, 0.08, 1e-9);
    EXPECT_LE(rest.steepest_rise, 1e-12);
}

TEST_P(ChangingProperties, FrictionThatVanishesIsNoJump) {
    // Held at mu_s 1 where it would slide 0.7 away; the ground turns slippery.
    const ChangingWall wall(GetParam(), {100, 255, 255}, {100, 0, 0});
    TouchSettings settings;
    FingerState finger;
    wall.field.touch(finger, {0.1, 0.1, -99});
    wall.field.touch(finger, {0.1, 0.1, -101});
    const auto frame_of = [&](std::int64_t n) { return n < 2 ? &wall.field.prev : &wall.field.next; };
    const TouchSolver solver = TouchSolver::create(wall.field.scene, settings).value();
    const dvec3 goal{0.8, 0.1, -101};
    Contact contact;
    for (int tick = 0; tick < 100; ++tick) {
        const HeightField field(wall.field.scene, pair_at(tick, wall.field.scene.rate, frame_of));
        solver.tick(field, {&goal, 1}, {&finger, 1}, {&contact, 1});
        EXPECT_FALSE(contact.jumped) << tick;
        if (tick == 0) {
            EXPECT_NEAR(contact.proxy.x, 0.1, 1e-12);
        }
    }
    EXPECT_NEAR(contact.proxy.x, 0.8, 1e-9);
}

TEST_P(ChangingProperties, WhatACutBringsIsCancelledInEveryMetric) {
    for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled}) {
        const ChangingWall wall(GetParam(), {0, 0, 0}, {255, 0, 0});
        TouchSettings settings;
        settings.metric = metric;
        const TouchSolver solver = TouchSolver::create(wall.field.scene, settings).value();
        FingerState finger;
        Contact contact;
        dvec3 goal{0.1, 0.1, -50};
        const auto tick_on = [&](const SurfaceFrame& frame, std::int64_t number) {
            FramePair pair;
            pair.prev = pair.next = {number, number * 33'000'000, &frame};
            solver.tick(HeightField(wall.field.scene, pair), {&goal, 1}, {&finger, 1}, {&contact, 1});
        };
        tick_on(wall.field.prev, 0);
        goal.z = -100.8;
        tick_on(wall.field.prev, 0);
        ASSERT_TRUE(contact.touching);
        EXPECT_FALSE(contact.jumped);
        tick_on(wall.field.next, 1);
        EXPECT_TRUE(contact.jumped) << name_of(metric);
        EXPECT_NEAR(glm::distance(contact.jumped_force, contact.force), 0, 1e-9);
        EXPECT_NEAR(contact.force.z, 8.0, 1e-2);
        tick_on(wall.field.next, 1);
        EXPECT_FALSE(contact.jumped);
    }
}

TEST_P(ChangingProperties, AMovingCoastIsNoClickUnderAFingerAtRest) {
    SceneOptions options;
    options.width = 96;
    options.height = 64;
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
    // What is less than a jump, beside the fade of one before.
    EXPECT_LE(most, GetParam() == FrameInterpolation::hold ? 0.1 + steepest_fade(1.0) : 0.1);
    EXPECT_GT(changing, 5);
    std::cout << "largest rise " << most << " N, " << changing << " fingers on ground that changes, "
              << cancelled << " of them cancelled\n";
}

INSTANTIATE_TEST_SUITE_P(Frames, ChangingProperties,
                         testing::Values(FrameInterpolation::hold, FrameInterpolation::linear),
                         [](const auto& run) {
                             return run.param == FrameInterpolation::hold ? "Held" : "Linear";
                         });

}  // namespace
}  // namespace touchable::test
