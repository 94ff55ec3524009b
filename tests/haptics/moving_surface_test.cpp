// A surface that moves under the finger, and the edges of the world.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/content/strokes.hpp"
#include "tests/haptics/small_field.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/certificate.hpp"

namespace touchable::test {
namespace {

TEST(MovingSurface, ARisingSurfaceTakesAFreeFingerAlongItsRay) {
    SmallField wall(33, 33, 100.0);
    wall.scene.depth.semantics = DepthSemantics::planar;
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
    SmallField wall(33, 33, 100.0);
    wall.scene.depth.semantics = DepthSemantics::planar;
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
    SmallField wall(33, 33, 100.0);
    wall.scene.depth.semantics = DepthSemantics::planar;
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

TEST(MovingSurface, NoContactIsLostOnTheMovingReliefAtThirtyFramesASecond) {
    SceneOptions options;
    options.width = 320;
    options.height = 240;
    TouchRig rig("moving", options, TouchRig::Depth::codes);
    rig.scene().default_properties = {600, 0, 0};
    ReliefStroke stroke(Relief::moving, options.width, options.height, 0.1);
    std::vector<SurfaceFrame> frames(62);
    for (std::size_t n = 0; n < frames.size(); ++n)
        rig.load(static_cast<std::int64_t>(n), TouchRig::Depth::codes, frames[n]);
    const FrameRate rate = rig.scene().rate;

    int under_ticks = 0;
    std::size_t prev = 0;
    for (int tick = 0; tick < 2000; ++tick) {
        const std::int64_t time = tick * 1'000'000LL;
        while (rate.time_ns(static_cast<std::int64_t>(prev) + 1) <= time) ++prev;
        const std::int64_t from = rate.time_ns(static_cast<std::int64_t>(prev));
        const std::int64_t to = rate.time_ns(static_cast<std::int64_t>(prev) + 1);
        rig.pair = {{static_cast<std::int64_t>(prev), from, &frames[prev]},
                    {static_cast<std::int64_t>(prev) + 1, to, &frames[prev + 1]},
                    static_cast<double>(time - from) / static_cast<double>(to - from)};
        const auto goal = stroke.next();
        const Contact& contact = rig.tick(goal.goal);
        EXPECT_FALSE(is_behind_surface(rig.field(), contact.proxy, 1e-12)) << "tick " << tick;
        if (goal.under < 0.5) continue;
        ++under_ticks;
        ASSERT_TRUE(contact.touching) << "tick " << tick;
        const reference::Surface surface(rig.scene(), rig.pair);
        EXPECT_LT(reference::excess_over_minimum(surface, rig.finger().proxy, goal.goal), 1e-9L);
    }
    EXPECT_GT(under_ticks, 1500);
}

TEST(Border, ComingInFromTheSideMeetsAWall) {
    SmallField block(17, 17, 100.0);
    block.scene.depth.semantics = DepthSemantics::planar;
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
    SmallField block(33, 33, 100.0);
    block.scene.depth.semantics = DepthSemantics::planar;
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
