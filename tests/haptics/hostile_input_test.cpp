// Whatever bits go in: what comes out is a number a device can bear, and nothing of it stays.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "engine/content/seeded_noise.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "tests/haptics/force_path.hpp"
#include "tests/haptics/small_field.hpp"

namespace touchable::test {
namespace {

using glm::dvec3;
using Limits = std::numeric_limits<double>;

/// Of any bits at all, or one that is feared.
double any_double(SplitMix64& random) {
    const std::array<double, 8> feared{Limits::quiet_NaN(),
                                       Limits::infinity(),
                                       -Limits::infinity(),
                                       Limits::max(),
                                       Limits::denorm_min(),
                                       -0.0,
                                       1e12,
                                       -1.0};
    const std::uint64_t bits = random.next();
    return random.next() % 3 == 0 ? feared[bits % feared.size()] : std::bit_cast<double>(bits);
}

dvec3 any_vector(SplitMix64& random) {
    const double x = any_double(random), y = any_double(random), z = any_double(random);
    return {x, y, z};
}

/// Of a finger that is in the air for 10 ticks, lands, and presses deeper and less deep from then on.
Contact good_contact(int tick) {
    Contact contact;
    const double depth = tick < 10 ? -1 : 1 + 0.5 * sine(0.05 * (tick - 10));
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
    GuardSettings settings;
    settings.max_force = 3;
    settings.max_stiffness = 5000;
    settings.rise = {random.next() % 2 == 0, random.next() % 2 == 0 ? 500 : Limits::infinity()};
    settings.damping = 10;
    settings.passivity = 50;
    settings.waits_to_be_free = random.next() % 2 == 0;
    return settings;
}

/// Of squares a rounding may be lost; a device looks at components too.
bool can_be_borne(const GuardedForce& out, double most) {
    const dvec3& f = out.force;
    return std::hypot(f.x, f.y, f.z) <= most * (1 + 1e-15) && std::sqrt(glm::dot(f, f)) <= most &&
           std::isfinite(out.energy.balance()) && std::isfinite(out.energy.bound);
}

TEST(HostileInput, ContactsOfAnyBitsLeaveAForceADeviceCanBearAndNothingBehind) {
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

TEST(HostileInput, EveryFieldThatAForceIsMadeOfIsLookedAt) {
    const auto out_of = [](auto spoil) {
        FingerGuard guard(without_ramp(), 0.001);
        for (int tick = 0; tick < 20; ++tick) guard.guard(good_contact(tick));
        Contact contact = good_contact(20);
        spoil(contact);
        return guard.guard(contact).reasons;
    };
    EXPECT_EQ(out_of([](Contact&) {}), guard_none);
    for (const double bad : {Limits::quiet_NaN(), Limits::infinity(), -Limits::infinity(), 1e200}) {
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
    // What is not there is not looked at.
    EXPECT_EQ(out_of([](Contact& c) { c.jumped_force.x = NAN; }), guard_none);

    ForceGuard guard(without_ramp(), 0.001);
    for (const BlendedForce& blended :
         {BlendedForce{dvec3(NAN, 0, 0)}, BlendedForce{dvec3(1e200, 0, 0)}, BlendedForce{.presence = NAN},
          BlendedForce{.presence = 2}, BlendedForce{.presence = -0.5}})
        EXPECT_EQ(guard.guard_blended(good_contact(20), blended).reasons, guard_fault);
}

// Time goes on by a tick at least, and no contact says otherwise.
TEST(HostileInput, ATickThatTookNoTimeCountsAsOne) {
    GuardSettings settings = without_ramp();
    settings.damping = 10;
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

TEST(HostileInput, GoalsOfAnyBitsLeaveAForceADeviceCanBearAndNothingBehind) {
    SplitMix64 random(12);
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    TouchSettings touch;
    touch.metres_per_scene_unit = 0.001;
    touch.stribeck_speed = 0.1;
    wall.scene.default_properties = {1000, 0.4, 0.2};
    const TouchSolver solver = TouchSolver::create(wall.scene, touch).value();
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

TEST(HostileInput, WhatCannotGoOutIsZeroAndAllBeginsAnew) {
    GuardSettings settings;
    settings.max_force = 3;
    settings.damping = 1e308;
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

TEST(HostileInput, AFrameThatIsMissingOrOfAnotherSizeEndsTheForceWithoutAJump) {
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
                if (tick == 149 || tick == 499) {
                    ASSERT_NEAR(force, 3, 1e-9) << tick;
                }
                if (tick == 299) {
                    ASSERT_EQ(force, 0);
                }
            }
        }
}

TEST(GuardSettings, WhatNoGuardCanKeepIsRefusedAndAGuardOfItExertsNoForce) {
    EXPECT_TRUE(validate(GuardSettings{}));
    const double nan = Limits::quiet_NaN(), inf = Limits::infinity();
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
    for (const double b : {nan, inf, -1.0}) {
        refuse("damping", [=](GuardSettings& s) { s.damping = b; });
        refuse("damping", [=](GuardSettings& s) { s.passivity = b; });
    }
    const Contact nowhere = [] {  // all of it at 0, but the force
        Contact contact;
        contact.touching = true;
        contact.properties.stiffness = 1000;
        contact.force = {0, 0, 5};
        return contact;
    }();
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

}  // namespace
}  // namespace touchable::test
