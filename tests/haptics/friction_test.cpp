// Friction against closed forms, and friction at edges where only its promises are known.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/haptics/small_field.hpp"
#include "tests/haptics/touch_rig.hpp"

namespace touchable::test {
namespace {

/// A large flat wall at planar depth 100 and a finger pressed `depth` into it at the centre.
class Wall : public testing::Test {
protected:
    Wall() : wall(65, 65, 100.0, DepthSemantics::planar) { wall.scene.default_properties = {1000, 0.5, 0.3}; }
    Contact goal_at(double x, double depth) { return wall.touch(finger, {x, 0.1, -100 - depth}); }

    SmallField wall;
    FingerState finger;
};

TEST_F(Wall, HoldsWhileThePullIsInsideTheStaticCone) {
    goal_at(0, -1);
    goal_at(0, 1);
    const Contact contact = goal_at(0.499, 1);
    EXPECT_NEAR(contact.proxy.x, 0, 1e-9);
    EXPECT_NEAR(contact.proxy.z, -100, 1e-9);
}

TEST_F(Wall, SlidesToTheDynamicConeOnceThePullLeavesTheStaticOne) {
    goal_at(0, -1);
    goal_at(0, 1);
    const Contact contact = goal_at(0.501, 1);
    EXPECT_NEAR(contact.proxy.x, 0.501 - 0.3, 1e-9);
    // F_t = mu_d F_n while it slides.
    EXPECT_NEAR(-contact.force.x / contact.force.z, 0.3, 1e-9);
}

TEST_F(Wall, KeepsSlidingAtTheDynamicConeWhileTheHandMoves) {
    goal_at(0, -1);
    goal_at(0, 1);
    double x = 0.6;
    for (int k = 0; k < 50; ++k, x += 0.05) {
        const Contact contact = goal_at(x, 1);
        ASSERT_TRUE(contact.touching);
        EXPECT_NEAR(contact.proxy.x, x - 0.3, 1e-8);
    }
}

TEST_F(Wall, SticksAgainOnceTheHandHasStopped) {
    goal_at(0, -1);
    goal_at(0, 1);
    goal_at(0.6, 1);
    goal_at(0.6, 1);  // rests: from here on static friction holds
    EXPECT_NEAR(goal_at(0.75, 1).proxy.x, 0.3, 1e-9);
    EXPECT_NEAR(goal_at(0.81, 1).proxy.x, 0.51, 1e-9);
}

TEST_F(Wall, HysteresisLoopHasTheAreaOfItsFriction) {
    // Slide to and fro at a constant load: work lost per loop = 2 x 2 x mu_d N x (stroke - slack).
    wall.scene.default_properties = {1000, 0.3, 0.3};
    goal_at(-1, -1);
    double work = 0, last_x = -1, last_force = 0;
    auto stroke = [&](double from, double to) {
        const int steps = 20000;
        for (int k = 1; k <= steps; ++k) {
            const double x = from + (to - from) * k / steps;
            const Contact contact = goal_at(x, 1);
            work -= 0.5 * (contact.force.x + last_force) * (x - last_x) * 0.001;
            last_x = x;
            last_force = contact.force.x;
        }
    };
    stroke(-1, 1);
    stroke(1, -1);
    work = 0;
    stroke(-1, 1);
    stroke(1, -1);
    const double load = 1.0;             // N: 1000 N/m, 1 mm
    const double slide = 2.0 - 2 * 0.3;  // mm of each stroke in which it slides
    const double expected = 2 * (0.3 * load * slide * 0.001);
    EXPECT_NEAR(work, expected, 1e-3 * expected);
}

TEST(Friction, ATiltedPlaneHoldsUpToTheAngleOfFriction) {
    // A load along -Z on a plane tilted by a slips where tan a > mu_s.
    for (const double tilt : {20.0, 25.0, 28.0, 33.0, 40.0}) {
        SceneOptions options;
        options.width = 320;
        options.height = 240;
        options.tilt_degrees = tilt;
        TouchRig rig("plane", options, TouchRig::Depth::exact);
        rig.scene().default_properties = {1000, 0.6, 0.6};       // angle of friction 30.96 degrees
        const double z = -rig.content().depth(159.5, 119.5, 0);  // on the axis
        rig.tick({0, 0, z + 5});
        const Contact landed = rig.tick({0, 0, z - 2});
        ASSERT_TRUE(landed.touching);
        const double along = std::hypot(landed.proxy.x, landed.proxy.y);
        // The plane takes 2 cos a of the load; the rest, 2 sin a, drags it until mu_d 2 cos a is left.
        const double a = tilt * 3.14159265358979 / 180;
        const double slid = std::max(0.0, 2 * std::cos(a) * (std::sin(a) - 0.6 * std::cos(a)));
        EXPECT_NEAR(along, slid, 1e-8) << tilt;
    }
}

TEST(Friction, AValleyHoldsByTheLoadOnBothItsWalls) {
    // A V along y: walls of slope 1 on both sides of column 16. Pulled along the valley, the load is l0 + l1.
    SmallField valley(33, 65, 0, DepthSemantics::planar);
    valley.scene.default_properties = {1000, 0.4, 0.4};
    valley.scene.camera.cx = 16;
    valley.shape(valley.prev, [](int x, int) { return 100.0 - 0.25 * std::abs(x - 16); });
    FingerState finger;
    valley.touch(finger, {0, 0, -95});
    const Contact bottom = valley.touch(finger, {0, 0, -102});
    ASSERT_TRUE(bottom.touching);
    EXPECT_NEAR(bottom.proxy.x, 0, 1e-9);
    EXPECT_NEAR(bottom.proxy.z, -100, 1e-9);
    // Both walls have the slope 0.25 per pixel of 0.25: their normals stand at 45 degrees, so l0 + l1 = 2
    // sqrt(2).
    const double slip = 0.4 * 2 * std::sqrt(2.0);
    EXPECT_NEAR(valley.touch(finger, {0, 0.99 * slip, -102}).proxy.y, 0, 1e-6);
    EXPECT_NEAR(valley.touch(finger, {0, 1.5 * slip, -102}).proxy.y, 0.5 * slip, 0.02);
}

TEST(Friction, FrictionlessSceneNeedsNoFriction) {
    SmallField wall(9, 9, 100.0);
    EXPECT_FALSE(wall.field().has_friction());
    wall.scene.default_properties.static_friction = 0.1;
    EXPECT_TRUE(wall.field().has_friction());
}

}  // namespace
}  // namespace touchable::test
