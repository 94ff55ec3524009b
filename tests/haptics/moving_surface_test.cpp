// SPDX-License-Identifier: Apache-2.0
// A surface that moves under the finger, and the edges of the world.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <cmath>
#include <optional>

#include "haptics_cpu/surface_carry.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "haptics_cpu/world_space.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/solver.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

TEST(MovingSurface, RisingLiftsFingerAlongRay) {
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    wall.fill(wall.next, 80.0);
    FingerState finger;
    const dvec3 goal{1, 0.5, -95};
    EXPECT_FALSE(wall.touch(finger, goal, 0.0).touching);
    EXPECT_FALSE(wall.touch(finger, goal, 0.2).touching);
    const Contact contact = wall.touch(finger, goal, 0.75);  // the wall is at 85 now
    ASSERT_TRUE(contact.touching);
    EXPECT_NEAR(contact.proxy.z, -85, 1e-9);
    EXPECT_NEAR(contact.proxy.x, 1, 1e-9);  // frictionless: from its ray it slides to under the goal
}

TEST(MovingSurface, StickingFingerStaysOnRay) {
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    wall.scene.default_properties = {1000, 0.9, 0.9};
    wall.fill(wall.next, 99.0);
    FingerState finger;
    wall.touch(finger, {2, 0, -99});
    wall.touch(finger, {2, 0, -103});
    const Contact contact = wall.touch(finger, {2, 0, -103}, 0.999);
    EXPECT_NEAR(contact.proxy.x / contact.proxy.z, 2.0 / -100, 1e-9);
    EXPECT_NEAR(contact.proxy.z, -99.001, 1e-9);
}

TEST(MovingSurface, SinkingReleasesFinger) {
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    wall.fill(wall.next, 120.0);
    FingerState finger;
    const dvec3 goal{0, 0, -102};
    wall.touch(finger, {0, 0, -99});
    EXPECT_TRUE(wall.touch(finger, goal, 0.0).touching);
    const Contact contact = wall.touch(finger, goal, 0.5);
    EXPECT_FALSE(contact.touching);
    EXPECT_EQ(contact.force, dvec3(0.0));
    EXPECT_EQ(contact.proxy, goal);
}

/// The scene `moving` and the stroke over it (docs/content.md), at a speed in m/s.
struct Motion {
    FrameInterpolation interpolation;
    double speed;
};

void PrintTo(const Motion& motion, std::ostream* out) {
    *out << (motion.interpolation == FrameInterpolation::hold ? "held" : "linear") << " at " << motion.speed
         << " m/s";
}

class MovingRelief : public testing::TestWithParam<Motion> {
protected:
    static constexpr int width = 320, height = 240, frames_in_two_seconds = 60;

    static void SetUpTestSuite() {
        rig_ = std::make_unique<TouchRig>("moving", sized(width, height), TouchRig::Depth::codes);
        frames_ = std::vector<SurfaceFrame>(frames_in_two_seconds);  // then it repeats
        for (std::size_t n = 0; n < frames_.size(); ++n)
            rig_->load(static_cast<std::int64_t>(n), TouchRig::Depth::codes, frames_[n]);
    }
    static void TearDownTestSuite() {
        rig_.reset();
        frames_.clear();
    }

    static FramePair pair_at(std::int64_t time_ns) {
        return pair_around(time_ns, rig_->scene().rate, [](std::int64_t n) {
            return &frames_[static_cast<std::size_t>(n) % frames_.size()];
        });
    }

    static std::unique_ptr<TouchRig> rig_;
    static std::vector<SurfaceFrame> frames_;
};
std::unique_ptr<TouchRig> MovingRelief::rig_;
std::vector<SurfaceFrame> MovingRelief::frames_;

TEST_P(MovingRelief, KeepsContactAndFollowsSurface) {
    TouchRig& rig = *rig_;
    const bool held = GetParam().interpolation == FrameInterpolation::hold;
    rig.scene().default_properties = {600, 0, 0};
    rig.scene().interpolation = GetParam().interpolation;
    rig.lift_fingers();
    ReliefStroke stroke(Relief::moving, width, height, GetParam().speed);
    const int ticks = 8000;
    int under_ticks = 0, off = 0;
    double farthest = 0;
    const ExactSurface exact("moving");
    std::optional<dvec3> truth;
    for (int tick = 0; tick < ticks; ++tick) {
        const std::int64_t time_ns = tick * 1'000'000LL;
        rig.pair = pair_at(time_ns);
        const dvec3 goal = stroke.next().goal;
        const Contact& contact = rig.tick(goal);
        ASSERT_FALSE(is_behind_surface(rig.field(), contact.proxy, 1e-12)) << "tick " << tick;
        ASSERT_FALSE(contact.jumped) << "tick " << tick << ": smooth motion is not sudden";
        // A frame that is held is the surface of its own moment.
        const double t = held ? static_cast<double>(rig.pair.prev.time_ns) / 1e9 : tick * 0.001;
        if (surface_at(Relief::moving, goal.x, goal.y, t).z - goal.z < 0.5) continue;
        ++under_ticks;
        ASSERT_TRUE(contact.touching) << "tick " << tick;
        ASSERT_LT(reference::excess_over_minimum({rig.scene(), rig.pair}, rig.finger().proxy, goal), 1e-9L)
            << "tick " << tick;
        truth = exact.closest(goal, truth.value_or(contact.proxy), t)->point;
        const double distance = length(contact.proxy - *truth);
        farthest = std::max(farthest, distance);
        off += !(distance <= 2.0);
    }
    EXPECT_GT(under_ticks, ticks * 8 / 10);
    EXPECT_EQ(off, 0) << "farthest " << farthest << " mm";
}

INSTANTIATE_TEST_SUITE_P(
    Strokes, MovingRelief,
    testing::Values(Motion{FrameInterpolation::linear, 0.05}, Motion{FrameInterpolation::linear, 0.1},
                    Motion{FrameInterpolation::linear, 0.3}, Motion{FrameInterpolation::hold, 0.05},
                    Motion{FrameInterpolation::hold, 0.1}, Motion{FrameInterpolation::hold, 0.3}));

TEST(Border, SideOfPictureIsWall) {
    SmallField block(17, 17, 100.0, DepthSemantics::planar);
    FingerState finger;
    // Beside the picture, deep under its surface but before the far plane: free.
    const double side = block.scene.camera.u(40) * 150;
    EXPECT_FALSE(block.touch(finger, {side, 0, -150}).touching);
    const Contact contact = block.touch(finger, {0, 0, -150});
    ASSERT_TRUE(contact.touching);
    EXPECT_GT(contact.force.x, 0);
    EXPECT_GE(contact.pixel_x, 16);
    EXPECT_LE(contact.pixel_x, 17);
}

TEST(Border, HoleHasWallsAndFloor) {
    SmallField block(33, 33, 100.0, DepthSemantics::planar);
    block.shape(block.prev, [](int x, int y) { return x > 10 && x < 24 && y > 10 && y < 24 ? NAN : 100.0; });
    FingerState finger;
    block.touch(finger, {0, 0, -90});
    EXPECT_FALSE(block.touch(finger, {0, 0, -390}).touching);
    const Contact floor = block.touch(finger, {0, 0, -405});
    ASSERT_TRUE(floor.touching);
    EXPECT_NEAR(floor.proxy.z, -400, 1e-9);
    FingerState other;
    block.touch(other, {0, 0, -90});
    block.touch(other, {0, 0, -150});
    EXPECT_TRUE(block.touch(other, {20, 0, -150}).touching) << "the hole's wall lets a finger through";
}

TEST(Border, TinyPicturesCanBeTouched) {
    for (const int w : {1, 2})
        for (const int h : {1, 2}) {
            SmallField tiny(w, h, 100.0);
            tiny.scene.camera.cx = tiny.scene.camera.cy = 0;
            FingerState finger;
            tiny.touch(finger, {0, 0, -50});
            const Contact contact = tiny.touch(finger, {0, 0, -130});
            ASSERT_TRUE(contact.touching);
            EXPECT_FALSE(is_behind_surface(tiny.field(), contact.proxy, 1e-12));
            const reference::Surface surface(tiny.scene, tiny.pair());
            EXPECT_LT(reference::excess_over_minimum(surface, finger.proxy, contact.goal), 1e-9L);
        }
}

TEST(ExtremeGoal, IsFollowedSafely) {
    SmallField wall(65, 65, 100.0);
    FingerState finger;
    wall.touch(finger, {0, 0, -99});
    wall.touch(finger, {0, 0, -101});
    for (const dvec3 goal : {dvec3{0, 0, 10},
                             {1e6, -1e6, -300},
                             {0, 0, -1e6},
                             {3, 2, 0},
                             {1e6, 0, 1e6},
                             {0, 0, -101},
                             {-1e8, 1e8, -1e-9},
                             {0, 0, -101}}) {
        const Contact contact = wall.touch(finger, goal);
        EXPECT_TRUE(std::isfinite(length(contact.proxy)));
        EXPECT_FALSE(is_behind_surface(wall.field(), contact.proxy, 1e-9))
            << goal.x << ' ' << goal.y << ' ' << goal.z;
    }
    EXPECT_TRUE(wall.touch(finger, {0, 0, -101}).touching);
}

// A finger that is inside a surface when the surface is new to it: at the start, in another clip, after an
// outage.

/// A finger over a wall at 100 mm, 1 N/mm; `depth` mm under it, above it where that is below 0.
class NewSurface : public testing::Test, protected StepRig {
protected:
    NewSurface() { guard.waits_to_be_free = true; }
    double press(double depth, double x = 0) { return give({x, 0, -100 - depth}); }
    double without_goal(int ticks = 1) {
        double force = 0;
        for (int k = 0; k < ticks; ++k) force = give({0, 0, NAN});
        return force;
    }
    /// Inside it has no force for so long, and the whole of it once it has been free.
    void expect_waiting(double depth, int ticks) {
        for (int k = 0; k < ticks; ++k) ASSERT_EQ(press(depth), 0) << k;
        press(-0.1);
        EXPECT_NEAR(press(4), 4, 1e-9);
    }
    /// The largest change of force from tick to tick while a finger rests there, and the force in the end.
    std::pair<double, double> rest(double depth, int ticks, double last) {
        double most = 0;
        for (int k = 0; k < ticks; ++k) {
            const double force = press(depth);
            most = std::max(most, std::abs(force - last));
            last = force;
        }
        return {most, last};
    }

    std::uint32_t reasons = 0;
    Contact contact;
    bool behind = false;

private:
    double give(const dvec3& goal) {
        const TouchTick done = run(tick_++, field.pair(), goal);
        reasons = done.forces[0].reasons;
        contact = done.contacts[0];
        behind = done.behind;
        return done.forces[0].force.z;
    }
    std::int64_t tick_ = 0;
};

constexpr double steepest = 1.5 / JumpCancellation::fade_ticks;  // of a fade, per tick

TEST_F(NewSurface, WaitsUntilFingerWasFree) {
    begin();
    for (int k = 0; k < 300; ++k) {
        ASSERT_EQ(press(5 - 0.01 * k), 0) << k;
        ASSERT_EQ(reasons, std::uint32_t{guard_jump | guard_waiting});
    }
    without_goal(10);  // which sets no finger free
    EXPECT_EQ(press(2), 0);
    EXPECT_EQ(press(-0.5), 0);
    EXPECT_NEAR(press(2), 2, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(NewSurface, MayBeFeltFromStart) {
    guard.waits_to_be_free = false;
    begin();
    EXPECT_NEAR(press(5), 5, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(NewSurface, FadesForceOfFingerInside) {
    for (const bool waits : {true, false}) {
        guard.waits_to_be_free = waits;
        field.fill(field.prev, 100.0);
        begin();
        press(-1);
        const double before = press(4);
        step->meet_new_surface();
        field.fill(field.prev, 98.0);
        const auto [most, force] = rest(4, 150, before);  // 6 mm deep now
        EXPECT_LE(most, (waits ? before : 2) * steepest * (1 + 1e-9));
        EXPECT_NEAR(force, waits ? 0 : 6, waits ? 0 : 1e-9);
        EXPECT_EQ(press(0) == 0, waits) << "2 mm deep still";
        press(-2.5);
        EXPECT_NEAR(press(4), 6, 1e-9);
    }
}

TEST_F(NewSurface, LeavesFreeFingerAlone) {
    begin();
    press(-1);
    step->meet_new_surface();
    press(-1);
    EXPECT_NEAR(press(2), 2, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(NewSurface, WaitsAfterOutageOnly) {
    guard.ramp_out_ticks = 20;
    begin();
    press(-1);
    press(4);
    without_goal();
    EXPECT_NEAR(press(4), 4, 1e-9);
    EXPECT_NEAR(rest(4, 150, 4).second, 4, 1e-9) << "for good";
    without_goal(20);
    press(4);
    EXPECT_NE(reasons & guard_waiting, 0U);
    expect_waiting(4, 50);
}

// The last goal is kept, but a surface passes no hand that has let go.
TEST_F(NewSurface, LostHandKeepsLastGoal) {
    guard.ramp_out_ticks = 20;
    begin();
    press(-1);
    without_goal(30);
    field.fill(field.prev, 90.0);
    without_goal();
    EXPECT_EQ(contact.goal, dvec3(0, 0, -99));
    EXPECT_FALSE(contact.touching);
    EXPECT_FALSE(behind);
}

// Friction holds the proxy at 0 while the goal goes to 3 mm beside it.
TEST_F(NewSurface, StartsProxyAtGoal) {
    field.scene.default_properties = {1000, 5, 5};
    guard.waits_to_be_free = false;
    guard.ramp_out_ticks = 20;
    begin();
    press(-1);
    press(2);
    press(2, 3);
    ASSERT_NEAR(contact.proxy.x, 0, 1e-9);
    without_goal(30);
    press(2, 3);
    EXPECT_NEAR(contact.proxy.x, 0, 1e-9) << "it is where it was left";
    step->meet_new_surface();
    press(2, 3);
    EXPECT_NEAR(contact.proxy.x, 3, 0.1) << "on the goal's ray";
}

TEST_F(NewSurface, InterruptionInAirLeavesFree) {
    guard.ramp_out_ticks = 20;
    for (const bool has_gap : {false, true}) {
        begin();
        press(4);
        if (has_gap)
            step->come_back();
        else
            without_goal(30);
        EXPECT_EQ(press(-1), 0);
        EXPECT_NEAR(press(4), 4, 1e-9);
    }
}

TEST_F(NewSurface, WaitsAfterGapInside) {
    begin();
    press(-1);
    press(4);
    step->come_back();
    EXPECT_EQ(press(7), 0) << "at once, not by a fade: it may be another hand";
    EXPECT_EQ(reasons, std::uint32_t{guard_jump | guard_waiting | guard_gap});
    for (int k = 0; k < 300; ++k) {
        ASSERT_EQ(press(7 - 0.02 * k), 0) << k;
        ASSERT_EQ(reasons & (guard_waiting | guard_gap), std::uint32_t{guard_waiting}) << k;
    }
    press(-0.1);
    EXPECT_NEAR(press(4), 4, 1e-9);
}

TEST_F(NewSurface, WaitsAfterEnteringDuringGap) {
    begin();
    press(-20);
    step->come_back();
    expect_waiting(5, 300);
}

TEST_F(NewSurface, MissingGoalAfterGapWaits) {
    begin();
    press(-1);
    press(4);
    step->come_back();
    for (int k = 0; k < 5; ++k) EXPECT_EQ(without_goal(), 0) << "nothing is left to ramp out";
    for (int k = 0; k < 300; ++k) ASSERT_EQ(press(4), 0) << k;
}

TEST_F(NewSurface, MayRampInAfterGap) {
    guard.waits_to_be_free = false;
    guard.ramp_in_ticks = 100;
    begin();
    press(-1);
    rest(4, 200, 0);
    step->come_back();
    EXPECT_EQ(press(4), 0);
    const auto [most, force] = rest(4, 150, 0);
    EXPECT_LE(most, 4 * 0.01 * (1 + 1e-9));
    EXPECT_NEAR(force, 4, 1e-9);
}

TEST_F(NewSurface, DamperIgnoresMotionDuringGap) {
    guard.waits_to_be_free = false;
    guard.damping = 10;
    begin();
    press(-1);
    press(1);
    step->come_back();
    // 3 mm farther: in one tick that would be 3 m/s, and 12 N.
    EXPECT_NEAR(press(4), 4, 10 * 0.04);
}

// A live surface that is not renewed: it goes soft, lets go, and comes back without a step of force.

constexpr std::int64_t stale_ticks = 250;
constexpr double for_rounding = 1 + 1e-9;

/// A finger that rests 4 mm under a wall at 100 mm, 1 N/mm. The newest frame is of `newest_tick`.
class StaleSurface : public testing::Test, protected StepRig {
protected:
    StaleSurface() {
        guard.ramp_in_ticks = guard.ramp_out_ticks = 100;
        guard.stale_after_ns = stale_ticks * 1'000'000;
    }
    /// Past the first ramp.
    void begin() {
        StepRig::begin();
        for (int k = 0; k < 200; ++k) fresh(-1);
        for (int k = 0; k < 200; ++k) fresh(4);
    }
    double fresh(double depth) {
        newest_tick = tick;
        return press(depth);
    }
    double press(double depth, int ticks = 1) {
        tick += ticks - 1;
        FramePair pair = field.pair();
        pair.prev.time_ns = pair.next.time_ns = newest_tick * 1'000'000;
        const TouchTick done = run(tick++, pair, {0, 0, -100 - depth});
        reasons = done.forces[0].reasons;
        change = std::abs(done.forces[0].force.z - force);
        force = done.forces[0].force.z;
        return force;
    }
    void become_stale() {
        while (tick - newest_tick <= stale_ticks) ASSERT_NEAR(press(4), 4, 1e-9) << tick - newest_tick;
    }
    void let_go() {
        become_stale();
        for (int k = 0; k < 100; ++k) press(4);
        ASSERT_EQ(force, 0);
    }

    std::int64_t tick = 0, newest_tick = 0;
    std::uint32_t reasons = 0;
    double force = 0, change = 0;
};

TEST_F(StaleSurface, RampsForceOut) {
    begin();
    become_stale();
    for (int k = 1; k <= 100; ++k) {
        ASSERT_NEAR(press(4), 4 - 0.04 * k, 1e-9) << k;
        ASSERT_EQ(reasons, std::uint32_t{guard_stale});
    }
    for (int k = 0; k < 1000; ++k) ASSERT_EQ(press(4 + 0.01 * k), 0) << k;
}

TEST_F(StaleSurface, RampsForceIn) {
    begin();
    let_go();
    for (int k = 0; k < 300; ++k) {
        fresh(4);
        ASSERT_LE(change, 2 * 0.04 * for_rounding) << k;  // two ramps at once
    }
    EXPECT_NEAR(force, 4, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(StaleSurface, RampTurnsBackMidway) {
    begin();
    become_stale();
    for (int k = 0; k < 40; ++k) press(4);
    EXPECT_NEAR(force, 2.4, 1e-9);
    EXPECT_NEAR(fresh(4), 2.44, 1e-9);
    for (int k = 0; k < 39; ++k) fresh(4);
    EXPECT_NEAR(force, 4, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

TEST_F(StaleSurface, NearerReturnMakesNoStep) {
    begin();
    let_go();
    field.fill(field.prev, 94.0);  // 10 mm deep now
    field.fill(field.next, 94.0);
    for (int k = 0; k < 400; ++k) {
        fresh(4);
        ASSERT_LE(change, (steepest + 2 * 0.01) * 10 * for_rounding) << k;
    }
    EXPECT_NEAR(force, 10, 1e-9);
}

TEST_F(StaleSurface, WaitsUntilHandIsFree) {
    guard.waits_to_be_free = true;
    begin();
    let_go();
    for (int k = 0; k < 300; ++k) ASSERT_EQ(fresh(4), 0) << k;
    EXPECT_NE(reasons & guard_waiting, 0U);
    fresh(-1);
    EXPECT_NEAR(fresh(4), 4, 1e-9);
}

TEST_F(StaleSurface, AgesByNewerFrame) {
    begin();
    for (int k = 0; k < 2 * stale_ticks; ++k, ++tick) {
        FramePair pair = field.pair();
        pair.prev.time_ns = newest_tick * 1'000'000;
        pair.next.time_ns = tick * 1'000'000;
        ASSERT_NEAR(run(tick, pair, {0, 0, -104}).forces[0].force.z, 4, 1e-9) << k;
    }
}

TEST_F(StaleSurface, CountsSkippedTicks) {
    begin();
    become_stale();
    press(4, 30);
    EXPECT_NEAR(force, 4 * 0.7, 1e-9);
}

TEST_F(StaleSurface, MissingGoalsMakeNoStep) {
    for (const int held : {1, 2, 50}) {
        for (const bool rising : {false, true}) {
            tick = newest_tick = 0;
            begin();
            become_stale();
            for (int k = 0; k < 50; ++k) press(4);
            EXPECT_NEAR(force, 2, 1e-9);
            const auto go_on = [&](double depth) {
                if (rising) newest_tick = tick;
                press(depth);
                EXPECT_LE(change, 2 * 0.04 * for_rounding) << held << rising;
            };
            for (int k = 0; k < held; ++k) go_on(NAN);
            for (int k = 0; k < 200; ++k) go_on(4);
            EXPECT_NEAR(force, rising ? 4 : 0, 1e-9);
        }
    }
}

TEST_F(StaleSurface, StaysWithoutAgeLimit) {
    guard.stale_after_ns = 0;
    begin();
    for (int k = 0; k < 2000; ++k) press(4);
    EXPECT_NEAR(force, 4, 1e-9);
    EXPECT_EQ(reasons, guard_none);
}

// A surface that moves suddenly: which way does it take the proxy along?

constexpr double never = std::numeric_limits<double>::infinity();

/// Nearest of the window without rings: many points on every triangle, each nearer than the last.
double nearest_by_sampling(const WorldSpace& space, const Place& around, const dvec3& point) {
    double least = never;
    const int n = 6;
    for (std::int64_t j = around.j - nearest_window; j <= around.j + nearest_window; ++j)
        for (std::int64_t i = around.i - nearest_window; i <= around.i + nearest_window; ++i)
            for (int b = 0; b <= n; ++b)
                for (int a = 0; a <= n; ++a) {
                    const auto face = a >= b ? Feature::face_lower : Feature::face_upper;
                    const Place at =
                        face_place(face, i, j, static_cast<double>(a) / n, static_cast<double>(b) / n);
                    least = std::min(least, glm::distance(surface_point(space, at), point));
                }
    return least;
}

TEST(NearestPlace, NoSampleIsNearer) {
    Random random(11);
    int found = 0, refused = 0;
    for (int round = 0; round < 60; ++round) {
        SmallField field(40, 40, 100.0);
        const double rough = round % 3 == 0 ? 0.5 : (round % 3 == 1 ? 5.0 : 60.0);
        field.shape(field.prev, [&](int, int) { return 160 + random.within(-rough, rough); });
        const FramePair pair = still(field.prev);
        const HeightField surface(field.scene, pair);
        const WorldSpace space(surface);
        const Place around = face_under(random.within(-3, 42), random.within(-3, 42));
        // Behind the surface, on the place's ray.
        const dvec3 point = surface_point(space, around) * random.within(1.0, 1.1);
        const double reach = random.within(0.2, 20);
        const auto place = nearest_place(space, around, point, reach);
        const double sampled = nearest_by_sampling(space, around, point);
        if (!place) {
            EXPECT_GE(sampled, reach * (1 - 1e-12)) << "round " << round;
            ++refused;
            continue;
        }
        ++found;
        const dvec3 found_at = surface_point(space, *place);
        const double distance = glm::distance(found_at, point);
        EXPECT_LE(distance, sampled * (1 + 1e-9)) << "round " << round;
        EXPECT_LT(distance, reach);
        EXPECT_LT(reference::excess_over_minimum({field.scene, pair}, {*place, found_at}, point), 1e-9L)
            << "round " << round;
    }
    EXPECT_GT(found, 20);
    EXPECT_GT(refused, 3);
}

/// A step of the ground one cell beside a buried point, which is nearer than the ground above it.
TEST(NearestPlace, FindsStepOnEverySide) {
    struct Side {
        double a, b;
        int di, dj;
    };
    for (const Side& side :
         {Side{0.97, 0.5, 1, 0}, {0.03, 0.5, -1, 0}, {0.5, 0.97, 0, 1}, {0.5, 0.03, 0, -1}}) {
        SmallField field(40, 40, 100.0, DepthSemantics::planar);
        field.shape(field.prev, [side](int x, int y) {
            const bool falls = side.di > 0 ? x > 21 : side.di < 0 ? x < 20 : side.dj > 0 ? y > 21 : y < 20;
            return falls ? 200.0 : 160.0;
        });
        const HeightField surface = field.field();
        const WorldSpace space(surface);
        const Place around = face_under(20 + side.a, 20 + side.b);
        const auto place =
            nearest_place(space, around, unproject(field.scene.camera, 20 + side.a, 20 + side.b, 160.1), 1);
        ASSERT_TRUE(place);
        EXPECT_EQ(place->i, 20 + side.di);
        EXPECT_EQ(place->j, 20 + side.dj);
    }
}

/// A block 30 mm high before a wall at 1000, its side at column `edge`, under the tabletop's camera.
class Block {
public:
    Block() : field(161, 41, 1000.0, DepthSemantics::planar) {
        field.scene.camera = {800, 800, 80, 20};  // 1.25 mm a pixel at 1000
        field.scene.depth.near = 900;
        field.scene.depth.far = 1100;
        field.scene.default_properties = {600, 0, 0};
        field.scene.interpolation = FrameInterpolation::hold;
    }
    /// Frame n, its side at that column.
    Contact touch(const dvec3& goal, std::int64_t n, int edge, const TouchSettings& settings = {}) {
        field.shape(field.prev, [edge](int x, int) { return x <= edge ? 970.0 : 1000.0; });
        now = still(field.prev, n, field.scene.rate.time_ns(n));
        return tick_one(TouchSolver::create(field.scene, settings).value(), surface(), finger, goal);
    }
    HeightField surface() const { return {field.scene, now}; }
    /// World X of the middle of the side, at Z = -985.
    static double side(int edge) { return (edge + 0.5 - 80) / 800 * 985; }

    SmallField field;
    FramePair now;
    FingerState finger;
};

TEST(SurfaceCarry, PushesFingerAside) {
    Block block;
    const dvec3 goal{Block::side(43) - 0.5, 0, -985};
    EXPECT_FALSE(block.touch(goal, 0, 40).touching);
    for (int n = 1; n <= 3; ++n) {  // three pixels a frame: 3.7 mm
        const Contact contact = block.touch(goal, n, 40 + 3 * n);
        ASSERT_TRUE(contact.touching);
        EXPECT_NEAR(contact.proxy.x, Block::side(40 + 3 * n), 0.7) << "frame " << n;
        EXPECT_GT(contact.force.x, 0);
        EXPECT_LT(std::abs(contact.force.z), 0.2 * contact.force.x) << "popped to the front";
        EXPECT_FALSE(is_behind_surface(block.surface(), contact.proxy, 1e-12));
        EXPECT_LT(reference::excess_over_minimum({block.field.scene, block.now}, block.finger.proxy, goal),
                  1e-9L);
    }
}

TEST(SurfaceCarry, RayAlonePopsToFront) {
    Block block;
    const dvec3 goal{Block::side(43) - 0.5, 0, -985};
    TouchSettings only_ray{.sudden_speed = never};
    block.touch(goal, 0, 40, only_ray);
    block.touch(goal, 1, 43, only_ray);
    const Contact contact = block.touch(goal, 2, 46, only_ray);
    EXPECT_GT(contact.proxy.z, -971);
    EXPECT_GT(contact.force.z, 5);
}

TEST(SurfaceCarry, VanishedObjectFreesFinger) {
    Block block;
    block.touch({Block::side(40) + 3, 0, -985}, 0, 40);
    const dvec3 goal{Block::side(40) - 2, 0, -985};
    EXPECT_TRUE(block.touch(goal, 0, 40).touching);
    // The side goes 3 pixels back, past the goal: nothing is touched, nor was on the way.
    const Contact gone = block.touch(goal, 1, 37);
    EXPECT_FALSE(gone.touching);
    EXPECT_EQ(gone.proxy, goal);
    EXPECT_EQ(gone.force, dvec3(0.0));
}

TEST(SurfaceCarry, StaysAtRecedingSide) {
    Block block;
    block.field.scene.default_properties = {600, 0.8, 0.6};  // so that where it lands is where it stays
    block.touch({Block::side(40) + 3, 0, -985}, 0, 40);
    const dvec3 goal{Block::side(40) - 4, 0, -985};
    EXPECT_TRUE(block.touch(goal, 0, 40).touching);
    const Contact contact = block.touch(goal, 1, 39);
    ASSERT_TRUE(contact.touching);
    EXPECT_NEAR(contact.proxy.x, Block::side(39), 0.7);
    EXPECT_NEAR(contact.proxy.z, -985, 0.7);
}

/// A face tilted by `degrees`, rising along the ray by `rise` between two frames, a finger stuck to it.
Proxy stuck_on_a_rising_slope(double degrees, double rise, double sudden_speed) {
    SmallField slope(81, 81, 1000.0, DepthSemantics::planar);
    slope.scene.camera = {400, 400, 40, 40};
    slope.scene.depth.near = 500;
    slope.scene.depth.far = 1500;
    slope.scene.default_properties = {600, 5, 5};
    slope.scene.interpolation = FrameInterpolation::hold;
    const double m = std::tan(degrees * pi / 180);
    const auto solver = TouchSolver::create(slope.scene, {.sudden_speed = sudden_speed});
    FingerState finger;
    const auto tick = [&](std::int64_t n, double depth, double z) {
        slope.shape(slope.prev, [&](int x, int) { return depth / (1 + m * slope.scene.camera.u(x)); });
        const FramePair pair = still(slope.prev, n, slope.scene.rate.time_ns(n));
        return tick_one(*solver, {slope.scene, pair}, finger, {0.3, 0.2, z}).touching;
    };
    tick(0, 1000, -990);
    tick(0, 1000, -1003);
    EXPECT_TRUE(tick(1, 1000 - rise, -1003));
    return finger.proxy;
}

TEST(SurfaceCarry, SlopeKeepsFingerOnRay) {
    for (const double degrees : {0.0, 30.0, 50.0})
        for (const double rise : {0.5, 3.0, 8.0}) {
            const Proxy ray = stuck_on_a_rising_slope(degrees, rise, never);
            const Proxy now = stuck_on_a_rising_slope(degrees, rise, TouchSettings{}.sudden_speed);
            EXPECT_EQ(now.point, ray.point) << degrees << " degrees, " << rise << " mm";
        }
}

// The nearest place of a plane is cos(slope) of the ray's way off: 0.53 at 58 degrees, 0.47 at 62. Less than
// half decides (docs/solver.md).
TEST(SurfaceCarry, NearestPlaceWinsAbove60Degrees) {
    for (const double rise : {8.0, 15.0}) {
        const auto moved = [&](double degrees) {
            const Proxy ray = stuck_on_a_rising_slope(degrees, rise, never);
            return glm::distance(stuck_on_a_rising_slope(degrees, rise, TouchSettings{}.sudden_speed).point,
                                 ray.point);
        };
        EXPECT_EQ(moved(58), 0) << rise << " mm";
        // From the foot of the perpendicular to the ray's place.
        EXPECT_NEAR(moved(62), rise * std::sin(62 * pi / 180), 0.02 * rise);
    }
}

TEST(SurfaceCarry, LimitLeavesSlowMotionUnchanged) {
    Random random(5);
    SmallField field(24, 24, 100.0);
    field.shape(field.prev, [&](int, int) { return 150 + random.within(-20, 20); });
    field.shape(field.next, [&](int, int) { return 150 + random.within(-20, 20); });
    FingerState bounded, unbounded;
    int touching = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const dvec3 goal{random.within(-4, 4), random.within(-4, 4), random.within(-170, -130)};
        const double blend = random.within(0, 0.999);
        const Contact a = field.touch(bounded, goal, blend, {.sudden_speed = 1000}),
                      b = field.touch(unbounded, goal, blend, {.sudden_speed = never});
        ASSERT_EQ(a.force, b.force) << "tick " << tick;
        ASSERT_EQ(a.proxy, b.proxy) << "tick " << tick;
        EXPECT_FALSE(b.jumped);
        touching += a.touching;
    }
    EXPECT_GT(touching, 200);
}

}  // namespace
}  // namespace touchable::test
