// A surface that moves under the finger, and the edges of the world.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "engine/content/height_fields.hpp"
#include "tests/haptics/small_field.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/certificate.hpp"

namespace touchable::test {
namespace {

TEST(MovingSurface, ARisingSurfaceTakesAFreeFingerAlongItsRay) {
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    wall.fill(wall.next, 80.0);
    FingerState finger;
    const glm::dvec3 goal{1, 0.5, -95};
    EXPECT_FALSE(wall.touch(finger, goal, 0.0).touching);
    EXPECT_FALSE(wall.touch(finger, goal, 0.2).touching);
    const Contact contact = wall.touch(finger, goal, 0.75);  // the wall is at 85 now
    ASSERT_TRUE(contact.touching);
    EXPECT_NEAR(contact.proxy.z, -85, 1e-9);
    EXPECT_NEAR(contact.proxy.x, 1, 1e-9);  // frictionless: from its ray it slides to under the goal
}

TEST(MovingSurface, AStickingFingerStaysOnItsRay) {
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

TEST(MovingSurface, ASinkingSurfaceLetsTheFingerGo) {
    SmallField wall(33, 33, 100.0, DepthSemantics::planar);
    wall.fill(wall.next, 120.0);
    FingerState finger;
    const glm::dvec3 goal{0, 0, -102};
    wall.touch(finger, {0, 0, -99});
    EXPECT_TRUE(wall.touch(finger, goal, 0.0).touching);
    const Contact contact = wall.touch(finger, goal, 0.5);
    EXPECT_FALSE(contact.touching);
    EXPECT_EQ(contact.force, glm::dvec3(0.0));
    EXPECT_EQ(contact.proxy, goal);
}

/// The scene `moving` and the stroke over it (docs/scenes.md), at a speed in m/s.
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
        SceneOptions options;
        options.width = width;
        options.height = height;
        rig_ = std::make_unique<TouchRig>("moving", options, TouchRig::Depth::codes);
        frames_ = std::vector<SurfaceFrame>(frames_in_two_seconds);  // then it repeats
        for (std::size_t n = 0; n < frames_.size(); ++n)
            rig_->load(static_cast<std::int64_t>(n), TouchRig::Depth::codes, frames_[n]);
    }
    static void TearDownTestSuite() {
        rig_.reset();
        frames_.clear();
    }

    static FramePair pair_at(std::int64_t time_ns) {
        const FrameRate& rate = rig_->scene().rate;
        std::int64_t n = time_ns * rate.num / (rate.den * 1'000'000'000);
        while (rate.time_ns(n + 1) <= time_ns) ++n;
        const auto timed = [&](std::int64_t m) {
            return TimedFrame{m, rate.time_ns(m), &frames_[static_cast<std::size_t>(m) % frames_.size()]};
        };
        FramePair pair{timed(n), timed(n + 1), 0};
        pair.blend = static_cast<double>(time_ns - pair.prev.time_ns) /
                     static_cast<double>(pair.next.time_ns - pair.prev.time_ns);
        return pair;
    }

    static std::unique_ptr<TouchRig> rig_;
    static std::vector<SurfaceFrame> frames_;
};
std::unique_ptr<TouchRig> MovingRelief::rig_;
std::vector<SurfaceFrame> MovingRelief::frames_;

TEST_P(MovingRelief, NoContactIsLostAndNoTickIsOffTheSurface) {
    TouchRig& rig = *rig_;
    const bool held = GetParam().interpolation == FrameInterpolation::hold;
    rig.scene().default_properties = {600, 0, 0};
    rig.scene().interpolation = GetParam().interpolation;
    rig.lift_fingers();
    ReliefStroke stroke(Relief::moving, width, height, GetParam().speed);
    const int ticks = 8000;
    int under_ticks = 0, off = 0;
    double farthest = 0;
    std::optional<glm::dvec3> truth;
    for (int tick = 0; tick < ticks; ++tick) {
        const std::int64_t time_ns = tick * 1'000'000LL;
        rig.pair = pair_at(time_ns);
        const glm::dvec3 goal = stroke.next().goal;
        const Contact& contact = rig.tick(goal);
        ASSERT_FALSE(is_behind_surface(rig.field(), contact.proxy, 1e-12)) << "tick " << tick;
        ASSERT_FALSE(contact.jumped) << "tick " << tick << ": smooth motion is not sudden";
        // A frame that is held is the surface of its own moment.
        const double t = held ? static_cast<double>(rig.pair.prev.time_ns) / 1e9 : tick * 0.001;
        if (relief_z(Relief::moving, goal.x, goal.y, t) - goal.z < 0.5) continue;
        ++under_ticks;
        ASSERT_TRUE(contact.touching) << "tick " << tick;
        ASSERT_LT(reference::excess_over_minimum({rig.scene(), rig.pair}, rig.finger().proxy, goal), 1e-9L)
            << "tick " << tick;
        truth = rig.content().closest(goal, truth.value_or(contact.proxy), t)->point;
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

TEST(Border, ComingInFromTheSideMeetsAWall) {
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

TEST(Border, AHoleHasWallsAndAFloorAtTheFarPlane) {
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

TEST(Border, PicturesOfOneOrTwoPixelsCanBeTouched) {
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

TEST(Goals, BehindTheCameraAndVeryFarAwayAreFollowedSafely) {
    SmallField wall(65, 65, 100.0);
    FingerState finger;
    wall.touch(finger, {0, 0, -99});
    wall.touch(finger, {0, 0, -101});
    for (const glm::dvec3 goal : {glm::dvec3{0, 0, 10},
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

}  // namespace
}  // namespace touchable::test
