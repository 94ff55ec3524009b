// SPDX-License-Identifier: Apache-2.0
// The guard between a solver and a hand.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "engine/base/same_bits.hpp"
#include "engine/run/touch_run.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/solver.hpp"
#include "tests/sweep.hpp"

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
                               .rise = at_once};
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
    ForceGuard guard({.ramp_in_ticks = 10, .ramp_out_ticks = 10, .rise = at_once}, 0.001);
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
            ForceGuard guard({.ramp_in_ticks = in, .ramp_out_ticks = out, .rise = at_once}, 0.001);
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
    ForceGuard guard({.ramp_in_ticks = 0, .ramp_out_ticks = 0, .rise = at_once}, 0.001);
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

// Surfaces that do what surfaces do not: rise through a hand, change at every frame, come late, stop. Through
// the whole tick, as a device feels it.

constexpr double newtons_per_unit = 0.6;  // 600 N/m, a unit is a millimetre
/// The most that a surface may add to a force in a tick where frames are interpolated: slow motion, and the
/// steepest of a fade over the device's 10 N, with a fifth for fades that overlap.
constexpr double largest_rise = 0.1 * newtons_per_unit + 1.2 * 10 * 1.5 / JumpCancellation::fade_ticks;

/// One finger over a small field, through TouchStep; every tick is looked at.
class Stage : public StepRig {
public:
    explicit Stage(FrameInterpolation interpolation) : StepRig(200, DepthSemantics::range) {
        field.scene.default_properties = {600, 0, 0};
        field.scene.interpolation = interpolation;
    }

    /// A tick over a pair of frames; asserts what holds of every tick.
    void tick(std::int64_t number, const FramePair& pair, const dvec3& goal) {
        const TouchTick done = run(number, pair, goal);
        const HeightField surface(field.scene, pair);
        const double before = glm::length(force);
        const dvec3 spring_before = contact.force;
        contact = done.contacts[0];
        force = done.forces[0].force;
        reasons = done.forces[0].reasons;
        const bool exact = settings.metric == TouchMetric::world;  // the paper's surface is a bit another
        ASSERT_FALSE(done.behind && exact);
        ASSERT_FALSE(exact && is_behind_surface(surface, contact.proxy, 1e-12)) << "tick " << number;
        ASSERT_TRUE(std::isfinite(glm::dot(force, force)));
        ASSERT_LE(glm::length(force), guard.max_force * (1 + 1e-12));
        ASSERT_LE(glm::length(force), glm::length(contact.force) * (1 + 1e-12));
        ASSERT_FALSE(contact.counts.capped);
        if (exact && contact.touching && field.scene.default_properties.static_friction == 0) {
            ASSERT_LT(reference::excess_over_minimum({field.scene, pair}, step->states()[0].proxy, goal),
                      1e-9L * (1 + glm::distance(contact.proxy, goal)));
        }
        // The pull from one valley to the next turns a force, which is no rise of the surface.
        const double spring = glm::length(contact.force), was = glm::length(spring_before);
        const double turn =
            contact.jumped || was == 0 ? 0.0 : glm::length(contact.force - spring_before * (spring / was));
        rise = glm::length(force) - before - turn;
        touching += contact.touching;
        jumped += contact.jumped;
    }

    Contact contact;
    dvec3 force{0.0};
    std::uint32_t reasons = 0;
    double rise = 0;  ///< of |force| since the tick before, but for what the solver's force turned by
    int touching = 0, jumped = 0;
};

TEST(SuddenSurface, NeverKicksFreeFinger) {
    Random random(21);
    for (const int levels : {1, 2, 3, 7, 20, 64, 128, 255})
        for (const double rough : {0.0, 0.5, 20.0}) {
            SCOPED_TRACE(std::to_string(levels) + " levels a tick, rough " + std::to_string(rough));
            Stage stage(FrameInterpolation::linear);
            const double level = stage.field.scene.depth.level();
            std::vector<double> grain(33 * 33);
            for (double& g : grain) g = random.within(-rough, rough);
            double most = 0;
            for (int sweep = 0; sweep < 3; ++sweep) {
                stage.begin();
                stage.force = dvec3(0.0);
                const dvec3 goal{random.within(-3, 3), random.within(-3, 3), random.within(-330, -250)};
                double depth = 370;
                for (int tick = 0; tick < 40; ++tick) {
                    stage.field.shape(stage.field.prev, [&](int x, int y) {
                        return std::max(60.0, depth) + grain[static_cast<std::size_t>(33 * y + x)];
                    });
                    const FramePair pair = still(stage.field.prev, tick, tick * 1'000'000);
                    ASSERT_NO_FATAL_FAILURE(stage.tick(tick, pair, goal));
                    most = std::max(most, stage.rise);
                    depth -= levels * level;
                }
            }
            EXPECT_GT(stage.touching, levels > 3 ? 20 : -1);
            EXPECT_LE(most, largest_rise);
        }
}

// A surface takes a proxy along by its speed, which is its way over the time that has passed. But the hand
// feels at once only as much of it as one tick brings, however many were left out.
TEST(SuddenSurface, SkippedTicksAreFeltByFade) {
    const auto run = [](double metres_per_s, int every) {
        Stage stage(FrameInterpolation::linear);
        stage.begin();
        double most = 0;
        for (int tick = 0; tick <= 400; tick += every) {
            stage.field.fill(stage.field.prev, 200 - metres_per_s * tick);  // a unit is a millimetre
            stage.tick(tick, still(stage.field.prev, tick, tick * 1'000'000), {0, 0, -199});
            most = std::max(most, stage.rise);
        }
        EXPECT_GT(stage.touching, 1);
        EXPECT_LE(most, largest_rise) << metres_per_s << " m/s, each " << every << " ms";
        return stage.jumped;
    };
    EXPECT_EQ(run(0.09, 1), 0);
    EXPECT_GT(run(0.11, 1), 0);
    EXPECT_EQ(run(0.04, 2), 0) << "0.08 mm";
    for (const int every : {2, 10, 33, 50, 100}) EXPECT_GT(run(0.09, every), 0) << every;
}

/// A hand that presses and wanders over frames that have nothing to do with each other.
class CutEveryFrame : public testing::TestWithParam<FrameInterpolation> {};

TEST_P(CutEveryFrame, NeverKicksOrLosesSurface) {
    const bool hold = GetParam() == FrameInterpolation::hold;
    Random random(hold ? 31 : 32);
    Stage stage(GetParam());
    const double spread[] = {4, 15, 60, 150};
    const auto cut = [&](SurfaceFrame& frame, std::int64_t n) {
        const double depth = 200 + random.within(-0.5, 0.5) * spread[n / 8 % 4];
        const double tilt_x = random.within(-0.4, 0.4), tilt_y = random.within(-0.4, 0.4);
        stage.field.shape(frame, [&](int x, int y) { return depth + tilt_x * (x - 16) + tilt_y * (y - 16); });
    };
    stage.begin();
    SurfaceFrame *prev = &stage.field.prev, *next = &stage.field.next;
    cut(*prev, 0);
    double most = 0;
    int felt = 0, blended = 0;
    std::int64_t n = -1;
    const FrameRate& rate = stage.field.scene.rate;
    const int ticks = 8000;
    dvec3 goal(0, 0, -150);
    for (int tick = 0; tick < ticks; ++tick) {
        const std::int64_t time_ns = tick * 1'000'000LL;
        while (rate.time_ns(n + 1) <= time_ns) {
            ++n;
            if (n > 0) std::swap(prev, next);
            cut(*next, n + 1);
        }
        const FramePair pair =
            pair_around(time_ns, rate, [&](std::int64_t m) { return m == n ? prev : next; });
        const dvec3 wanted(3 * std::sin(tick * 0.001), 2 * std::cos(tick * 0.0013),
                           -203 - 3 * std::sin(tick * 0.002));
        const dvec3 way = wanted - goal;
        const double step = std::min(1.0, 0.1 / (1e-9 + glm::length(way)));
        goal += way * step;  // at most 0.1 m/s
        ASSERT_NO_FATAL_FAILURE(stage.tick(tick, pair, goal)) << "tick " << tick;
        // 3.3 mm of a held frame are not sudden.
        most = std::max(most, stage.rise - newtons_per_unit * glm::length(way * step));
        felt += glm::length(stage.force) > 0.1;
        blended += (stage.reasons & guard_jump) != 0;
    }
    EXPECT_LE(most, hold ? newtons_per_unit * 3.34 : largest_rise);
    EXPECT_GT(stage.jumped, 40);
    EXPECT_GT(blended, 500);
    EXPECT_GT(felt, ticks / 20);
    EXPECT_GT(stage.touching, ticks / 4);
    std::cout << "largest rise " << most << " N, " << stage.jumped << " jumps, blended in " << blended
              << ", felt in " << felt << " of " << ticks << " ticks\n";
}

INSTANTIATE_TEST_SUITE_P(Frames, CutEveryFrame,
                         testing::Values(FrameInterpolation::hold, FrameInterpolation::linear), name_of_run);

/// A producer that publishes a wall at some depth; the finger presses on it.
class Producer {
public:
    explicit Producer(Stage& stage) : stage_(stage) { stage.begin(); }
    void publish(std::int64_t n, double depth) {
        SurfaceFrame* slot = timeline.acquire();
        ASSERT_NE(slot, nullptr);
        slot->width = slot->height = 33;
        slot->coding = stage_.field.scene.depth;
        slot->vertices = std::make_unique<ExactVertices>(33, 33, std::vector<double>(33 * 33, depth));
        ASSERT_TRUE(timeline.publish(n, stage_.field.scene.rate.time_ns(n)));
    }
    void tick(std::int64_t tick, const dvec3& goal) {
        FramePair pair;
        ASSERT_TRUE(timeline.pair_at(tick * 1'000'000, pair));
        ASSERT_NO_FATAL_FAILURE(stage_.tick(tick, pair, goal));
    }
    SurfaceTimeline timeline{4};

private:
    Stage& stage_;
};

TEST(SuddenSurface, StoppedProducerStandsStill) {
    for (const auto interpolation : {FrameInterpolation::hold, FrameInterpolation::linear}) {
        Stage stage(interpolation);
        Producer producer(stage);
        for (int n = 0; n < 3; ++n) producer.publish(n, 200 - 2.0 * n);  // 60 mm/s towards the hand
        const dvec3 goal(0, 0, -203);
        double most = 0;
        dvec3 standing(0.0);
        producer.tick(0, {0, 0, -190});
        for (int tick = 1; tick < 3000; ++tick) {
            ASSERT_NO_FATAL_FAILURE(producer.tick(tick, goal));
            if (tick > 1) most = std::max(most, stage.rise);
            if (tick == 67) standing = stage.force;
            if (tick > 67) {
                ASSERT_EQ(stage.force, standing) << "tick " << tick;
            }
        }
        EXPECT_NEAR(glm::length(standing), newtons_per_unit * 7, 1e-3);
        EXPECT_LE(most, newtons_per_unit * (interpolation == FrameInterpolation::hold ? 2.0001 : 0.0601));
        EXPECT_EQ(stage.reasons, 0U);
        EXPECT_EQ(stage.jumped, 0);
    }
}

TEST(SuddenSurface, LateFramesMakeNoKick) {
    for (const auto interpolation : {FrameInterpolation::hold, FrameInterpolation::linear})
        for (const bool dropped : {false, true}) {
            const bool is_held = interpolation == FrameInterpolation::hold;
            SCOPED_TRACE((is_held ? "held " : "linear ") + std::string(dropped ? "dropped" : "late"));
            Stage stage(interpolation);
            Producer producer(stage);
            // 45 mm/s
            const auto depth_of = [](std::int64_t n) { return 206 - 1.5 * static_cast<double>(n); };
            producer.publish(0, depth_of(0));
            std::int64_t published = 0;
            double most = 0;
            producer.tick(0, {0, 0, -190});
            for (int tick = 1; tick < 800; ++tick) {
                // Two frames ahead; but what is due from 100 to 300 ms comes at 300 ms, or never.
                const std::int64_t due = tick * 30 / 1000 + 2;
                while (published < std::min<std::int64_t>(due, 6)) {
                    if (published >= 2 && tick >= 100 && tick < 300) break;
                    ++published;
                    producer.publish(published, depth_of(published));
                }
                if (dropped && tick == 300) {
                    producer.publish(10, depth_of(10));
                    published = 99;
                }
                ASSERT_NO_FATAL_FAILURE(producer.tick(tick, {0, 0, -205}));
                if (tick > 1) most = std::max(most, stage.rise);
            }
            EXPECT_GT(stage.touching, 700);
            EXPECT_LE(most, is_held ? newtons_per_unit * 3.34 : largest_rise);
        }
}

/// A wall at some depth at a moment of the clip, pressed by a resting finger; ticks go on from call to call.
class PressedWall {
public:
    explicit PressedWall(FrameInterpolation interpolation = FrameInterpolation::linear)
        : stage(interpolation) {}
    /// The largest rise of force meanwhile.
    double press(int ticks, double depth, std::int64_t clip_ns, std::uint64_t epoch) {
        stage.field.fill(stage.field.prev, depth);
        FramePair pair = still(stage.field.prev, clip_ns / 33'000'000, clip_ns);
        pair.epoch = epoch;
        double most = 0;
        for (int k = 0; k < ticks; ++k) {
            stage.tick(tick_++, pair, {0, 0, -203});
            if (tick_ > 1) most = std::max(most, stage.rise);
        }
        return most;
    }
    double force() const { return glm::length(stage.force); }
    Stage stage;

private:
    std::int64_t tick_ = 0;
};

// 6 mm at 0.6 N/mm under a finger that rests 3 mm deep.
TEST(SuddenSurface, NewEpochIsAlwaysJump) {
    for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled})
        for (const std::int64_t clip_ns : {1'000'000'000LL, 500'000'000LL, 2'000'000'000LL}) {
            SCOPED_TRACE(std::string(name_of(metric)) + " to " + std::to_string(clip_ns));
            PressedWall wall;
            wall.stage.settings.metric = metric;
            wall.stage.begin();
            wall.press(200, 200, 1'000'000'000, 4);
            EXPECT_NEAR(wall.force(), 1.8, 1e-3);
            EXPECT_EQ(wall.stage.jumped, 0);
            EXPECT_LE(wall.press(150, 194, clip_ns, 5), 3.6 * 1.51 / JumpCancellation::fade_ticks);
            EXPECT_EQ(wall.stage.jumped, 1);
            EXPECT_NEAR(wall.force(), 5.4, 1e-3);
            EXPECT_LE(wall.press(10, 202, clip_ns, 6), 1e-12) << "what drops, drops at once";
            EXPECT_NEAR(wall.force(), 0.6, 1e-3);
        }
}

TEST(SuddenSurface, NewEpochRisesGently) {
    PressedWall wall;
    wall.stage.begin();
    wall.press(5, 210, 0, 0);
    EXPECT_EQ(wall.force(), 0);
    EXPECT_LE(wall.press(150, 193, 0, 1), 6.01 * 1.51 / JumpCancellation::fade_ticks);
    EXPECT_NEAR(wall.force(), 6, 2e-3);
    EXPECT_LE(wall.press(150, 160, 0, 2), 0) << "beyond the device's force: it fades to nothing";
    EXPECT_EQ(wall.force(), 0);
}

TEST(SuddenSurface, NewEpochStiffnessIsJump) {
    PressedWall wall;
    wall.stage.begin();
    wall.press(200, 200, 0, 0);
    wall.stage.field.scene.default_properties.stiffness = 630;  // 0.09 N: less than other stuff makes
    EXPECT_LE(wall.press(150, 200, 0, 1), 0.0901 * 1.51 / JumpCancellation::fade_ticks);
    EXPECT_EQ(wall.stage.jumped, 1);
    EXPECT_NEAR(wall.force(), 1.89, 1e-3);
}

// The surface's speed under the hand counts, not its speed before the camera.
TEST(SuddenSurface, PlaybackSpeedCounts) {
    const auto jumps = [](double metres_per_s, double rate) {
        PressedWall wall;
        wall.stage.begin();
        for (int tick = 0; tick < 60; ++tick)
            wall.press(1, 200 - metres_per_s * rate * tick, std::llround(1e6 * rate * tick), 0);
        return wall.stage.jumped;
    };
    EXPECT_EQ(jumps(0.5, 0.1), 0);
    EXPECT_GT(jumps(0.5, 1), 50);
    EXPECT_EQ(jumps(0.05, 1), 0);
    EXPECT_GT(jumps(0.05, 8), 50);
}

// Frames 100 ms apart in a clip that says 30 a second: 9 mm of a held frame are 0.09 m/s.
TEST(SuddenSurface, HeldFrameUsesFrameInterval) {
    for (const bool sudden : {false, true}) {
        Stage stage(FrameInterpolation::hold);
        stage.begin();
        for (int n = 0; n < 4; ++n) {
            stage.field.fill(stage.field.prev, 200 - (sudden ? 11 : 9) * n);
            FramePair pair;
            pair.prev = {n, n * 100'000'000LL, &stage.field.prev};
            pair.next = {n + 1, (n + 1) * 100'000'000LL, &stage.field.next};
            for (int tick = 100 * n; tick < 100 * (n + 1); ++tick) {
                pair.blend = 0.01 * (tick % 100);
                stage.tick(tick, pair, {0, 0, -199});
            }
        }
        EXPECT_EQ(stage.jumped, sudden ? 3 : 0);
    }
}

}  // namespace
}  // namespace touchable::test
