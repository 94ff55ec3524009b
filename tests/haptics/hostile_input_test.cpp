// SPDX-License-Identifier: Apache-2.0
// Input of any bits gives a force that a device can bear, and leaves no trace in later ticks.

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/base/same_bits.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/haptic_loop.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "haptics_cpu/world_space.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/limits.hpp"
#include "tests/stress/drawn_scene.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

using Limits = std::numeric_limits<double>;
constexpr double nan = Limits::quiet_NaN();

/// A number of any bits, or one of the dangerous ones.
double any_double(SplitMix64& random) {
    constexpr double inf = Limits::infinity(), tiny = Limits::denorm_min();
    const std::array<double, 8> feared{nan, inf, -inf, Limits::max(), tiny, -0.0, 1e12, -1.0};
    const std::uint64_t bits = random.next();
    return random.next() % 3 == 0 ? feared[bits % feared.size()] : std::bit_cast<double>(bits);
}

dvec3 any_vector(SplitMix64& random) {
    const double x = any_double(random), y = any_double(random), z = any_double(random);
    return {x, y, z};
}

/// The contact of a finger that is in the air for 10 ticks, lands, and presses deeper and less deep from then
/// on.
Contact good_contact(int tick) {
    const double depth = tick < 10 ? -1 : 1 + 0.5 * sine(0.05 * (tick - 10));
    Contact contact;
    contact.goal = contact.proxy = {0.01 * tick, 0, -depth};
    if (depth < 0) return contact;
    contact.touching = true;
    contact.proxy.z = 0;
    contact.properties.stiffness = 1000;
    contact.force = 1.0 * (contact.proxy - contact.goal);
    if (tick == 10) return contact;
    contact.carried = {0.01 * (tick - 1), 0, 0};
    contact.carried_stiffness = 1000;
    return contact;
}

/// A good contact in which any of the fields may be anything.
Contact any_contact(SplitMix64& random, int tick) {
    Contact contact = good_contact(tick);
    const std::uint64_t bad = random.next() & random.next();
    const auto is_bad = [&](int field) { return (bad >> field & 1) != 0; };
    for (dvec3* v : {&contact.goal, &contact.proxy, &contact.force, &contact.carried, &contact.jumped_force})
        for (int axis = 0; axis < 3; ++axis)
            if (random.next() % 8 == 0) (*v)[axis] = any_double(random);
    if (is_bad(0)) contact.touching = !contact.touching;
    if (is_bad(1)) contact.goal_held = true;
    if (is_bad(2)) contact.jumped = true;
    if (is_bad(3)) contact.off_its_ray = true;
    if (is_bad(4)) contact.properties.stiffness = any_double(random);
    if (is_bad(5)) contact.properties.static_friction = any_double(random);
    if (is_bad(6)) contact.properties.dynamic_friction = any_double(random);
    if (is_bad(7)) contact.carried_stiffness = any_double(random);
    if (is_bad(8)) contact.carried_stiffness.reset();
    if (is_bad(9)) contact.ticks = std::bit_cast<int>(static_cast<std::uint32_t>(random.next()));
    if (is_bad(10)) contact.pixel_x = contact.pixel_y = any_double(random);
    return contact;
}

GuardSettings everything(SplitMix64& random) {
    const auto coin = [&] { return random.next() % 2 == 0; };
    return {.max_force = 3,
            .max_stiffness = 5000,
            .rise = {coin(), coin() ? 500 : Limits::infinity()},
            .damping = 10,
            .passivity = 50,
            .waits_to_be_free = coin()};
}

/// Squares may lose a rounding; a device looks at components too.
bool can_be_borne(const GuardedForce& out, double most) {
    const dvec3& f = out.force;
    return std::hypot(f.x, f.y, f.z) <= most * (1 + 1e-15) && std::sqrt(glm::dot(f, f)) <= most &&
           std::isfinite(out.energy.balance()) && std::isfinite(out.energy.bound);
}

TEST(HostileInput, AnyContactGivesSafeForce) {
    SplitMix64 random(11);
    int faults = 0, forces = 0;
    for (int run = 0; run < 3000; ++run) {
        const GuardSettings settings = everything(random);
        FingerGuard hostile(settings, 0.001), fresh(settings, 0.001);
        const int bad = 1 + static_cast<int>(random.next() % 40);
        for (int tick = 0; tick < bad; ++tick) {
            const GuardedForce out = hostile.guard(any_contact(random, tick));
            ASSERT_TRUE(can_be_borne(out, settings.max_force)) << "run " << run << ", tick " << tick;
            faults += (out.reasons & guard_fault) != 0;
            forces += out.force != dvec3(0.0);
        }
        for (int tick = 0; tick < 130; ++tick) {
            const GuardedForce out = hostile.guard(good_contact(tick)),
                               wanted = fresh.guard(good_contact(tick));
            ASSERT_TRUE(can_be_borne(out, settings.max_force)) << "run " << run << ", tick " << tick;
            if (tick < 100) continue;
            ASSERT_NEAR(length(out.force - wanted.force), 0, 1e-5) << "run " << run << ", tick " << tick;
            ASSERT_EQ(out.reasons, wanted.reasons);
        }
    }
    EXPECT_GT(faults, 10'000);
    EXPECT_GT(forces, 5'000);
}

TEST(HostileInput, ChecksEveryContactField) {
    const auto out_of = [](auto spoil) {
        FingerGuard guard(without_ramp(), 0.001);
        for (int tick = 0; tick < 20; ++tick) guard.guard(good_contact(tick));
        Contact contact = good_contact(20);
        spoil(contact);
        return guard.guard(contact).reasons;
    };
    EXPECT_EQ(out_of([](Contact&) {}), guard_none);
    for (const double bad : {nan, Limits::infinity(), -Limits::infinity(), 1e200}) {
        EXPECT_EQ(out_of([&](Contact& c) { c.force.x = bad; }), guard_fault) << bad;
        EXPECT_EQ(out_of([&](Contact& c) { c.goal.y = bad; }), guard_fault) << bad;
        EXPECT_EQ(out_of([&](Contact& c) { c.proxy.z = bad; }), guard_fault) << bad;
        EXPECT_EQ(out_of([&](Contact& c) { c.carried.x = bad; }), guard_fault) << bad;
        EXPECT_EQ(out_of([&](Contact& c) { c.carried_stiffness = bad; }), guard_fault) << bad;
        EXPECT_EQ(out_of([&](Contact& c) { c.properties.stiffness = bad; }), guard_fault) << bad;
        const auto spoil_jump = [&](Contact& c) { c.jumped = true, c.jumped_force.x = bad; };
        EXPECT_EQ(out_of(spoil_jump), guard_fault) << bad;
    }
    EXPECT_EQ(out_of([](Contact& c) { c.properties.stiffness = -1; }), guard_fault);
    EXPECT_EQ(out_of([](Contact& c) { c.carried_stiffness = -1; }), guard_fault);
    // A jump's force is ignored without a jump.
    EXPECT_EQ(out_of([](Contact& c) { c.jumped_force.x = NAN; }), guard_none);

    ForceGuard guard(without_ramp(), 0.001);
    for (const BlendedForce& blended :
         {BlendedForce{dvec3(NAN, 0, 0)}, BlendedForce{dvec3(1e200, 0, 0)}, BlendedForce{.presence = NAN},
          BlendedForce{.presence = 2}, BlendedForce{.presence = -0.5}})
        EXPECT_EQ(guard.guard_blended(good_contact(20), blended).reasons, guard_fault);
}

// Time goes on by a tick at least, and no contact says otherwise.
TEST(HostileInput, ZeroTicksCountAsOne) {
    GuardSettings settings{.ramp_in_ticks = 0, .rise = at_once, .damping = 10};
    for (const int ticks : {0, -1, std::numeric_limits<int>::min()}) {
        FingerGuard hostile(settings, 0.001), good(settings, 0.001);
        for (int tick = 0; tick < 60; ++tick) {
            Contact contact = good_contact(tick);
            const GuardedForce wanted = good.guard(contact);
            contact.ticks = ticks;
            ASSERT_EQ(hostile.guard(contact).force, wanted.force) << ticks;
        }
    }
}

TEST(HostileInput, AnyGoalGivesSafeForce) {
    SplitMix64 random(12);
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    wall.scene.default_properties = {1000, 0.4, 0.2};
    const TouchSolver solver = TouchSolver::create(wall.scene, {.stribeck_speed = 0.1}).value();
    for (int run = 0; run < 300; ++run) {
        const GuardSettings settings = everything(random);
        TouchStep hostile(solver, settings, 1), fresh(solver, settings, 1);
        std::int64_t tick = 0;
        const auto felt = [&](TouchStep& step, const dvec3& goal) {
            step.goals()[0] = goal;
            return step.run(tick, tick * 1'000'000, wall.scene, wall.pair()).forces[0];
        };
        for (; tick < 30; tick += 1 + static_cast<std::int64_t>(random.next() % 3))
            ASSERT_TRUE(can_be_borne(felt(hostile, any_vector(random)), settings.max_force)) << "run " << run;
        const std::int64_t start = tick;
        for (; tick < start + 130; ++tick) {
            const double depth = tick < start + 10 ? -1 : 0.02 * static_cast<double>(tick - start - 10);
            const dvec3 goal{0.2, 0.1, -100 - depth};
            const GuardedForce out = felt(hostile, goal), wanted = felt(fresh, goal);
            ASSERT_TRUE(can_be_borne(out, settings.max_force)) << "run " << run;
            if (tick >= start + 100) {
                ASSERT_NEAR(length(out.force - wanted.force), 0, 1e-5) << "run " << run;
            }
        }
    }
}

TEST(HostileInput, OverflowGivesZeroAndRestarts) {
    GuardSettings settings{.max_force = 3, .rise = at_once, .damping = 1e308};
    FingerGuard guard(settings, 0.001), fresh(settings, 0.001);
    for (int tick = 0; tick < 150; ++tick) guard.guard(good_contact(tick));
    // A goal 1 km deeper at once: the damper is beyond all numbers.
    Contact far = good_contact(150);
    far.goal.z -= 1e6;
    const GuardedForce out = guard.guard(far);
    EXPECT_EQ(out.force, dvec3(0.0));
    EXPECT_EQ(out.reasons, guard_fault);
    for (int tick = 0; tick < 150; ++tick) {
        const GuardedForce again = guard.guard(good_contact(tick)), wanted = fresh.guard(good_contact(tick));
        ASSERT_EQ(again.force, wanted.force) << tick;
        ASSERT_EQ(again.reasons, wanted.reasons) << tick;
    }
    // A cut that buried the finger is forgotten too.
    Contact cut = good_contact(20);
    cut.jumped = true;
    cut.force = cut.jumped_force = {0, 0, 60};
    guard.guard(cut);
    ASSERT_EQ(guard.guard(far).reasons, guard_fault);
    FingerGuard other(settings, 0.001);
    Contact resting = good_contact(20);
    resting.carried = resting.proxy;
    for (int tick = 0; tick < 150; ++tick)
        ASSERT_EQ(guard.guard(resting).force, other.guard(resting).force) << tick;
    EXPECT_GT(length(guard.guard(resting).force), 1);
}

TEST(HostileInput, BadFrameRampsForceOut) {
    SmallField field(20, 20, 100);
    SmallField other(21, 20, 100);
    SurfaceFrame bare;
    bare.width = bare.height = 20;
    SmallField wrong_haptic(20, 20, 100), wrong_heights(20, 20, 100);
    wrong_haptic.prev.haptic.resize(7);
    wrong_heights.prev.heights.resize(399);
    const SurfaceFrame* frames[] = {nullptr, &other.prev, &bare, &wrong_haptic.prev, &wrong_heights.prev};
    const auto solver = TouchSolver::create(field.scene, {});
    for (const SurfaceFrame* frame : frames)
        for (const bool later : {false, true}) {
            TouchStep step(*solver, GuardSettings{}, 1);
            step.goals()[0] = {0, 0, -103};
            double last = 0;
            for (int tick = 0; tick < 500; ++tick) {
                FramePair pair = field.pair();
                if (tick >= 150 && tick < 300) (later ? pair.next : pair.prev).frame = frame;
                const TouchTick done = step.run(tick, tick, field.scene, pair);
                const double force = done.forces[0].force.z;
                const bool missing = tick >= 150 && tick < 300;
                ASSERT_EQ(done.contacts[0].touching, !missing) << tick;
                ASSERT_EQ(done.contacts[0].goal, dvec3(0, 0, -103)) << tick;
                ASSERT_LE(std::abs(force - last), 3.0 / 100 + 1e-9) << tick;
                last = force;
                if (tick == 149 || tick == 299 || tick == 499) {
                    ASSERT_NEAR(force, missing ? 0 : 3, missing ? 0 : 1e-9) << tick;
                }
            }
        }
}

TEST(GuardSettings, InvalidGiveNoForce) {
    EXPECT_TRUE(validate(GuardSettings{}));
    const double inf = Limits::infinity();
    std::vector<std::pair<GuardSettings, const char*>> refused;
    const auto refuse = [&](const char* word, auto spoil) {
        GuardSettings settings;
        spoil(settings);
        refused.emplace_back(settings, word);
    };
    for (const double force : {nan, inf, -1.0, 0.0, 1e-7, 1e10})
        refuse("force", [=](GuardSettings& s) { s.max_force = force; });
    for (const double k : {nan, inf, -1.0, 0.0, 1e13})
        refuse("stiffness", [=](GuardSettings& s) { s.max_stiffness = k; });
    refuse("ramp", [](GuardSettings& s) { s.ramp_in_ticks = -1; });
    refuse("ramp", [](GuardSettings& s) { s.ramp_out_ticks = -1; });
    for (const double rise : {nan, 0.0, -1.0})
        refuse("rise", [=](GuardSettings& s) { s.rise.per_tick = rise; });
    for (const std::int64_t age : {std::int64_t{-1}, std::int64_t{3'600'000'000'001}})
        refuse("stale", [=](GuardSettings& s) { s.stale_after_ns = age; });
    for (const double b : {nan, inf, -1.0}) {
        refuse("damping", [=](GuardSettings& s) { s.damping = b; });
        refuse("damping", [=](GuardSettings& s) { s.passivity = b; });
    }
    const Contact nowhere = pressing({0, 0, 5});  // all of it at 0, but the force
    for (const auto& [settings, word] : refused) {
        const auto checked = validate(settings);
        ASSERT_FALSE(checked) << word;
        EXPECT_NE(checked.error().message.find(word), std::string::npos) << checked.error().message;
        FingerGuard guard(settings, 0.001);
        for (int tick = 0; tick < 150; ++tick) {
            const GuardedForce out = guard.guard(good_contact(tick));
            ASSERT_EQ(out.force, dvec3(0.0)) << word;
            ASSERT_EQ(out.reasons, guard_fault) << word;
            ASSERT_EQ(guard.guard(nowhere).force, dvec3(0.0)) << word;
            ASSERT_EQ(guard.guard(nowhere).reasons, guard_fault) << word;
        }
    }
    for (const double scale : {nan, inf, 0.0, -0.001}) {
        FingerGuard guard(without_ramp(), scale);
        EXPECT_EQ(guard.guard(good_contact(20)).reasons, guard_fault) << scale;
        EXPECT_EQ(guard.guard(good_contact(20)).force, dvec3(0.0)) << scale;
        EXPECT_EQ(guard.guard(nowhere).force, dvec3(0.0)) << scale;
    }
}

// Scenes and states at the edge of what is let in: touched without a number that is none, and never from
// behind.

/// One frame of drawn codes, and a finger. Its planes may be such as no scene file may state: a program that
/// links the solver need not validate them.
class CodedScene {
public:
    CodedScene(const Scene& made, stress::DrawnPlanes planes) : scene(made) {
        stress::FrameMaker(scene).build(planes, frame_);
        settings.metres_per_scene_unit = 0.16 / scene.depth.far;
    }
    HeightField field() const { return {scene, still(frame_)}; }
    const Contact& touch(const dvec3& goal) {
        return contact = tick_one(TouchSolver::create(scene, settings).value(), field(), finger, goal);
    }
    bool is_sound() const {
        const dvec3 sum = contact.proxy + contact.force + contact.carried + contact.jumped_force;
        return std::isfinite(sum.x + sum.y + sum.z + finger.proxy.a + finger.proxy.b) &&
               std::isfinite(length(finger.proxy.point));
    }

    Scene scene;
    TouchSettings settings;
    FingerState finger;
    Contact contact;

private:
    SurfaceFrame frame_;
};

Scene between(double near, double far, DepthCodingKind kind = DepthCodingKind::linear) {
    Scene scene;
    scene.width = 24;
    scene.height = 20;
    scene.camera = {20, 20, 12, 9};
    scene.depth.semantics = DepthSemantics::planar;
    stress::set_planes(scene, kind, near, far, 16);
    scene.default_properties = {1000, 0, 0};
    return scene;
}

stress::DrawnPlanes noise(const Scene& scene) {
    SplitMix64 random(3);
    return stress::draw_noise(scene, random);
}

// Heights are bounded by the nearest code that is valid, and so is the field: code 255 stood for a depth of
// 1, off which 1.5 was taken, so that the surface was thought to reach behind the camera.
TEST(ExtremeScene, NearestValidCodeBoundsField) {
    Scene scene = between(1, 256);
    stress::set_planes(scene, DepthCodingKind::linear, 1, 256, 8);
    scene.depth.invalid_codes[0] = 255;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    scene.height_coding = {1.5, HeightUnits::world, 255};
    stress::DrawnPlanes planes = noise(scene);
    planes.heights.assign(planes.codes.size(), 255);
    CodedScene touched(scene, planes);
    EXPECT_EQ(touched.field().nearest_depth_anywhere(), 0.5);
    Random random(7);
    for (int k = 0; k < 4000; ++k) {
        // Before all there is, and behind the camera; sideways anywhere.
        const auto in_front = [&] {
            return dvec3(random.below(400) - 200.0, random.below(400) - 200.0, random.below(2) ? 0.25 : -0.4);
        };
        touched.finger = {};
        for (int tick = 0; tick < 3; ++tick) {
            ASSERT_FALSE(touched.touch(in_front()).touching) << "a force where nothing is, " << k;
            ASSERT_TRUE(touched.is_sound()) << k;
        }
        touched.touch({random.below(400) - 200.0, random.below(400) - 200.0, -1.0 * random.below(300)});
        ASSERT_TRUE(touched.is_sound()) << k;
    }
}

// The way was cut where its depth rounds to 0: half a billion units are counted in steps of 6e-8.
TEST(ExtremeScene, CrossingCameraPlaneFindsSurface) {
    const Scene scene = between(1e-9, 1e9);
    for (const dvec3& aside : {dvec3(0), dvec3(0, 5e8, 0), dvec3(5e8, 0, 0)}) {
        CodedScene touched(scene, noise(scene));
        int touching = 0;
        for (int k = 0; k < 200; ++k) {
            const double depth = k % 4 == 0 ? -5e8 : (k % 4 == 1 ? 5e8 : 2e9);
            touched.touch(dvec3(0, 0, -depth) + aside * (k % 8 < 4 ? 1.0 : -1.0));
            ASSERT_TRUE(touched.is_sound()) << k;
            touching += touched.contact.touching;
        }
        EXPECT_GT(touching, 50);
    }
}

TEST(ExtremeScene, TouchesBeyondBillionUnits) {
    const Scene scene = between(1e11, 1e12);
    CodedScene touched(scene, noise(scene));
    touched.touch({0, 0, -1e10});
    EXPECT_FALSE(touched.contact.goal_held);
    EXPECT_TRUE(touched.touch({0, 0, -1.5e12}).touching);
    EXPECT_TRUE(touched.touch({0, 0, -2 * largest_goal(scene)}).goal_held);
}

TEST(ExtremeScene, TouchesStretchedPixels) {
    for (const DepthSemantics semantics : {DepthSemantics::planar, DepthSemantics::range})
        for (const double fx : {1e-6, 1e6}) {
            Scene scene = between(40, 180);
            scene.depth.semantics = semantics;
            scene.camera.fx = fx;
            scene.camera.fy = 1 / fx;
            CodedScene touched(scene, noise(scene));
            Random random(5);
            int touching = 0;
            for (int k = 0; k < 2000; ++k) {
                const double x = random.below(26) - 1.0, y = random.below(22) - 1.0;
                double depth = 20.0 + random.below(200);
                depth = planar_depth(scene.camera, semantics, x, y, depth);
                touched.touch(unproject(scene.camera, x, y, depth));
                ASSERT_TRUE(touched.is_sound()) << k;
                touching += touched.contact.touching;
            }
            EXPECT_GT(touching, 500);
        }
}

// Nothing makes such a state; should one come from anywhere, one good goal is enough.
TEST(ExtremeScene, NanStateHeals) {
    const Scene scene = between(40, 180);
    const auto spoiled = [](int which) {
        FingerState finger;
        finger.started = true;
        finger.proxy.feature = Feature::face_lower;
        double* const numbers[] = {&finger.proxy.point.y, &finger.proxy.a,    &finger.proxy.b,
                                   &finger.goal.x,        &finger.slip_speed, &finger.place.z};
        *numbers[which] = nan;
        return finger;
    };
    for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled})
        for (int which = 0; which < 6; ++which) {
            CodedScene touched(scene, noise(scene));
            touched.settings.metric = metric;
            touched.settings.stribeck_speed = 0.01;
            touched.finger = spoiled(which);
            touched.touch({nan, 0, 0});
            EXPECT_TRUE(touched.is_sound());
            touched.touch({0, 0, -20});
            EXPECT_TRUE(touched.is_sound()) << which;
            EXPECT_TRUE(touched.touch({0, 0, -300}).touching) << which;
            EXPECT_TRUE(touched.is_sound());
        }
}

TEST(ExtremeScene, ScaledMetricSurvivesCameraPlane) {
    const Scene scene = between(40, 180);
    for (const double z : {-1e-320, -1e-300, -1e-12, 0.0, 5.0}) {
        CodedScene touched(scene, noise(scene));
        touched.settings.metric = TouchMetric::scaled;
        for (int k = 0; k < 4; ++k) {
            touched.touch({0, 0, z});
            EXPECT_TRUE(touched.is_sound()) << z;
            EXPECT_TRUE(touched.touch({0, 0, -300}).touching) << z;
            EXPECT_TRUE(touched.is_sound()) << z;
        }
    }
}

TEST(ExtremeScene, RejectsInvalidTickLimits) {
    const Scene scene = between(40, 180);
    for (const int limit : {0, -1, std::numeric_limits<int>::min(), 1'000'001}) {
        TouchSettings events, cells;
        events.event_limit = cells.cell_limit = limit;
        const auto refused = TouchSolver::create(scene, events);
        ASSERT_FALSE(refused) << limit;
        EXPECT_NE(refused.error().message.find("event limit: " + std::to_string(limit)), std::string::npos);
        EXPECT_NE(refused.error().message.find("from 1 to 1000000"), std::string::npos);
        EXPECT_FALSE(TouchSolver::create(scene, cells));
    }
}

// A way that is cut goes on in the next tick, free and in front of the surface, and ends where a whole one
// does.
TEST(ExtremeScene, CappedPathContinuesNextTick) {
    const Scene scene = between(40, 180);
    const stress::DrawnPlanes planes = noise(scene);
    for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled}) {
        Random random(11);
        int cut = 0, landed = 0, same = 0;
        for (int k = 0; k < 300; ++k) {
            const auto any = [&](double depth) {
                return unproject(scene.camera, random.below(24), random.below(20), depth);
            };
            const dvec3 from = any(35), to = any(60.0 + random.below(200));
            CodedScene whole(scene, planes), pieces(scene, planes);
            whole.settings.metric = pieces.settings.metric = metric;
            pieces.settings.cell_limit = 3;
            whole.touch(from);
            pieces.touch(from);
            whole.touch(to);
            double left = length(to - from);
            for (int tick = 0; tick < 200; ++tick) {
                pieces.touch(to);
                const double now = length(to - pieces.contact.proxy);
                EXPECT_TRUE(metric != TouchMetric::world || now <= left * (1 + 1e-12));
                left = now;
                EXPECT_LE(pieces.contact.counts.cells, 4);
                // (In pixels the surface is flat between other points than in the world.)
                EXPECT_FALSE(metric == TouchMetric::world &&
                             is_behind_surface(pieces.field(), pieces.contact.proxy, 1e-9));
                if (!pieces.contact.counts.capped) break;
                ++cut;
                EXPECT_TRUE(pieces.contact.touching || length(pieces.contact.force) == 0);
            }
            EXPECT_FALSE(pieces.contact.counts.capped);
            EXPECT_TRUE(metric == TouchMetric::scaled || pieces.contact.touching == whole.contact.touching);
            landed += whole.contact.touching;
            same += length(pieces.contact.proxy - whole.contact.proxy) < 1e-6;
        }
        // A hit a rounding aside may lie beyond a ridge; scaled, each tick measures by where the proxy is
        // then.
        EXPECT_GE(same, metric == TouchMetric::scaled ? 0 : 295);
        EXPECT_GT(cut, 300);
        EXPECT_GT(landed, 100);
    }
}

// Beside a corner 10^18 times as near, the least share of a pixel is a long way; none is farther than the far
// plane (what a hand asks for, and where a proxy would be infinitely far).
TEST(ExtremeScene, NoPlaceExceedsFarthestCorner) {
    const Scene scene = between(1e-9, 1e9);
    stress::DrawnPlanes planes;
    for (int k = 0; k < scene.width * scene.height; ++k)
        planes.codes.push_back(static_cast<std::uint16_t>(k % 3 == 0 ? 65535 : 0));
    CodedScene touched(scene, planes);
    const HeightField field = touched.field();
    const WorldSpace world(field);
    Random random(2);
    for (int k = 0; k < 20000; ++k) {
        const auto share = [&] { return 1 - (1 + random.below(8)) * 0x1p-53; };
        const double x = random.below(20) + share(), y = random.below(17) + share();
        for (const Feature face : {Feature::face_lower, Feature::face_upper}) {
            const Place at = face_place(face, random.below(20), random.below(17), share(), share());
            ASSERT_GE(surface_w(world, at), 1e-9 * (1 - 1e-15));
            ASSERT_LE(length(surface_point(world, at)), 2e9);
        }
        ASSERT_GE(surface_w(world, face_under(x, y)), 1e-9 * (1 - 1e-15));
    }
}

// The test for a proxy behind the surface that runs and tests use.
TEST(IsBehindSurface, ComparesRelativeDepth) {
    for (const DepthSemantics semantics : {DepthSemantics::planar, DepthSemantics::range}) {
        SmallField wall(16, 12, 100.0, semantics);
        const HeightField field = wall.field();
        for (const auto& [x, y] : {std::pair{3.0, 4.0}, {7.25, 5.5}, {14.0, 0.5}}) {
            const WorldSpace world(field);
            const double depth = 1 / surface_w(world, face_under(x, y));
            const auto at = [&, i = x, j = y](double share) {
                return unproject(wall.scene.camera, i, j, depth * share);
            };
            EXPECT_TRUE(is_behind_surface(field, at(1 + 3e-9), 1e-9));
            EXPECT_TRUE(is_behind_surface(field, at(2), 1e-9));
            EXPECT_FALSE(is_behind_surface(field, at(1 + 3e-10), 1e-9));
            EXPECT_FALSE(is_behind_surface(field, at(0.5), 1e-9));
        }
        EXPECT_TRUE(is_behind_surface(field, {900, 0, -500}, 1e-9)) << "beside the picture, behind its ring";
        EXPECT_FALSE(is_behind_surface(field, {0, 0, 5}, 1e-9)) << "behind the camera";
        EXPECT_FALSE(is_behind_surface(field, {nan, 0, -500}, 1e-9));
    }
}

// A tick allocates nothing, with one finger or ten, in the air or on the ground, at still and at moving
// surfaces.

using MakeBuilder = std::unique_ptr<SurfaceBuilder> (*)(const Scene&);

std::size_t allocations_in_ticks(MakeBuilder make_builder) {
    SceneOptions options = sized(320, 240);
    options.properties = true;
    const auto content = std::move(make_scene("globe", options)).value();
    Scene scene = content->scene();
    scene.filter.median = 5;
    scene.filter.fill_holes = 1;
    std::vector<SurfaceFrame> frames(2);
    const auto builder = make_builder(scene);
    for (int n : {0, 1}) EXPECT_TRUE(builder->build(content->frame(n), frames[static_cast<std::size_t>(n)]));
    TouchSettings settings{.metres_per_scene_unit = *scene.device_metres_per_unit, .stribeck_speed = 0.05};
    const auto solver = TouchSolver::create(scene, settings);
    const GlobeStroke stroke(options.preset, options.width, options.height);
    std::vector<dvec3> goals(10);
    std::vector<FingerState> fingers(10);
    std::vector<Contact> contacts(10);
    GuardSettings everything{.rise = {.paid = true}, .damping = 1, .passivity = 10};
    std::vector<ForceGuard> guards(10, ForceGuard(everything, settings.metres_per_scene_unit));

    int touching = 0;
    const std::size_t before = allocations();
    for (int tick = 0; tick < 2000; ++tick) {
        const FramePair pair{{0, 0, &frames[0]}, {1, 1, &frames[1]}, tick % 100 * 0.01};
        for (std::size_t k = 0; k < goals.size(); ++k)
            goals[k] = stroke.at((tick + 100 * static_cast<int>(k)) % 2000).goal;
        solver.value().tick(HeightField(scene, pair), goals, fingers, contacts);
        for (std::size_t k = 0; k < goals.size(); ++k) {
            guards[k].guard(contacts[k]);
            touching += contacts[k].touching;
        }
    }
    const std::size_t during = allocations() - before;
    EXPECT_GT(touching, 10000);
    return during;
}

TEST(NoAllocation, InTicksOnFilteredFrames) {
    EXPECT_EQ(allocations_in_ticks([](const Scene& scene) { return make_cpu_builder(scene); }), 0U);
}
TEST(NoAllocation, InTicksOnLazyFrames) {
    EXPECT_EQ(allocations_in_ticks(make_lazy_builder), 0U);
}

TEST(NoAllocation, TheCounterCounts) {
    const std::size_t before = allocations();
    std::vector<int> grown(100);
    grown.resize(1000);
    EXPECT_EQ(allocations() - before, 2U);
}

/// Not one for each tick that it has room for: it is made between two sessions of a hand.
TEST(NoAllocation, TickLogMakesFew) {
    const std::size_t before = allocations();
    const TickLog log(4096, 5);
    EXPECT_LE(allocations() - before, 8U);
}

}  // namespace
}  // namespace touchable::test
