// A surface that moves suddenly: which way does it take the proxy along?
#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>

#include "haptics_cpu/surface_carry.hpp"
#include "haptics_cpu/world_space.hpp"
#include "tests/frame/random.hpp"
#include "tests/haptics/small_field.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/reference/certificate.hpp"

namespace touchable::test {
namespace {

constexpr double never = std::numeric_limits<double>::infinity();

/// Nearest of the window without rings: many points on every triangle, each nearer than the last.
double nearest_by_sampling(const WorldSpace& space, const Place& around, const glm::dvec3& point) {
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

TEST(NearestPlace, NoSampleOfTheWindowIsNearerAndItIsNearestOnItsOwnTriangles) {
    Random random(11);
    int found = 0, refused = 0;
    for (int round = 0; round < 60; ++round) {
        SmallField field(40, 40, 100.0);
        const double rough = round % 3 == 0 ? 0.5 : (round % 3 == 1 ? 5.0 : 60.0);
        field.shape(field.prev, [&](int, int) { return 160 + random.within(-rough, rough); });
        const FramePair pair{{0, 0, &field.prev}, {0, 0, &field.prev}, 0};
        const HeightField surface(field.scene, pair);
        const WorldSpace space(surface);
        const Place around = face_under(random.within(-3, 42), random.within(-3, 42));
        // Behind the surface, on the place's ray.
        const glm::dvec3 point = surface_point(space, around) * random.within(1.0, 1.1);
        const double reach = random.within(0.2, 20);
        const auto place = nearest_place(space, around, point, reach);
        const double sampled = nearest_by_sampling(space, around, point);
        if (!place) {
            EXPECT_GE(sampled, reach * (1 - 1e-12)) << "round " << round;
            ++refused;
            continue;
        }
        ++found;
        const glm::dvec3 found_at = surface_point(space, *place);
        const double distance = glm::distance(found_at, point);
        EXPECT_LE(distance, sampled * (1 + 1e-9)) << "round " << round;
        EXPECT_LT(distance, reach);
        EXPECT_LT(reference::excess_over_minimum({field.scene, pair}, {*place, found_at}, point), 1e-9L)
            << "round " << round;
    }
    EXPECT_GT(found, 20);
    EXPECT_GT(refused, 3);
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
    Contact touch(FingerState& finger, const glm::dvec3& goal, std::int64_t n, int edge,
                  TouchSettings settings = {}) {
        field.shape(field.prev, [edge](int x, int) { return x <= edge ? 970.0 : 1000.0; });
        FramePair pair;
        pair.prev = pair.next = {n, field.scene.rate.time_ns(n), &field.prev};
        now = pair;
        Contact contact;
        const auto solver = TouchSolver::create(field.scene, settings);
        solver.value().tick(surface(), {&goal, 1}, {&finger, 1}, {&contact, 1});
        return contact;
    }
    HeightField surface() const { return {field.scene, now}; }
    /// World X of the middle of the side, at Z = -985.
    static double side(int edge) { return (edge + 0.5 - 80) / 800 * 985; }

    SmallField field;
    FramePair now;
};

TEST(SurfaceCarry, AnObjectFromTheSidePushesTheFingerAside) {
    Block block;
    FingerState finger;
    const glm::dvec3 goal{Block::side(43) - 0.5, 0, -985};
    EXPECT_FALSE(block.touch(finger, goal, 0, 40).touching);
    for (int n = 1; n <= 3; ++n) {  // three pixels a frame: 3.7 mm
        const Contact contact = block.touch(finger, goal, n, 40 + 3 * n);
        ASSERT_TRUE(contact.touching);
        EXPECT_NEAR(contact.proxy.x, Block::side(40 + 3 * n), 0.7) << "frame " << n;
        EXPECT_GT(contact.force.x, 0);
        EXPECT_LT(std::abs(contact.force.z), 0.2 * contact.force.x) << "popped to the front";
        EXPECT_FALSE(is_behind_surface(block.surface(), contact.proxy, 1e-12));
        EXPECT_LT(reference::excess_over_minimum({block.field.scene, block.now}, finger.proxy, goal), 1e-9L);
    }
}

TEST(SurfaceCarry, AlongTheRayAloneItWouldPopToTheFront) {
    Block block;
    FingerState finger;
    const glm::dvec3 goal{Block::side(43) - 0.5, 0, -985};
    TouchSettings only_ray;
    only_ray.sudden_speed = never;
    block.touch(finger, goal, 0, 40, only_ray);
    block.touch(finger, goal, 1, 43, only_ray);
    const Contact contact = block.touch(finger, goal, 2, 46, only_ray);
    EXPECT_GT(contact.proxy.z, -971);
    EXPECT_GT(contact.force.z, 5);
}

TEST(SurfaceCarry, AFingerWhoseObjectWentAwayIsFreeWhereItWas) {
    Block block;
    FingerState finger;
    block.touch(finger, {Block::side(40) + 3, 0, -985}, 0, 40);
    const glm::dvec3 goal{Block::side(40) - 2, 0, -985};
    EXPECT_TRUE(block.touch(finger, goal, 0, 40).touching);
    // The side goes 3 pixels back, past the goal: nothing is touched, nor was on the way.
    const Contact gone = block.touch(finger, goal, 1, 37);
    EXPECT_FALSE(gone.touching);
    EXPECT_EQ(gone.proxy, goal);
    EXPECT_EQ(gone.force, glm::dvec3(0.0));
}

TEST(SurfaceCarry, SidewaysBackByAPixelItStaysAtTheSide) {
    Block block;
    FingerState finger;
    block.field.scene.default_properties = {600, 0.8, 0.6};  // so that where it lands is where it stays
    block.touch(finger, {Block::side(40) + 3, 0, -985}, 0, 40);
    const glm::dvec3 goal{Block::side(40) - 4, 0, -985};
    EXPECT_TRUE(block.touch(finger, goal, 0, 40).touching);
    const Contact contact = block.touch(finger, goal, 1, 39);
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
    const double m = std::tan(degrees * 3.14159265358979323846 / 180);
    const auto shape = [&](double depth) {
        slope.shape(slope.prev, [&](int x, int) { return depth / (1 + m * slope.scene.camera.u(x)); });
    };
    TouchSettings settings;
    settings.sudden_speed = sudden_speed;
    const auto solver = TouchSolver::create(slope.scene, settings);
    FingerState finger;
    Contact contact;
    const auto tick = [&](std::int64_t n, double depth, double z) {
        shape(depth);
        FramePair pair;
        pair.prev = pair.next = {n, slope.scene.rate.time_ns(n), &slope.prev};
        const glm::dvec3 goal{0.3, 0.2, z};
        const HeightField field(slope.scene, pair);
        solver.value().tick(field, {&goal, 1}, {&finger, 1}, {&contact, 1});
    };
    tick(0, 1000, -990);
    tick(0, 1000, -1003);
    tick(1, 1000 - rise, -1003);
    EXPECT_TRUE(contact.touching);
    return finger.proxy;
}

TEST(SurfaceCarry, ASlopeThatRisesKeepsAStickingFingerOnItsRay) {
    for (const double degrees : {0.0, 30.0, 50.0})
        for (const double rise : {0.5, 3.0, 8.0}) {
            const Proxy ray = stuck_on_a_rising_slope(degrees, rise, never);
            const Proxy now = stuck_on_a_rising_slope(degrees, rise, TouchSettings{}.sudden_speed);
            EXPECT_EQ(now.point, ray.point) << degrees << " degrees, " << rise << " mm";
        }
}

// Of a plane the nearest place is cos(slope) of the ray's way off: 0.53 at 58 degrees, 0.47 at 62. Less than
// half decides (docs/solver.md).
TEST(SurfaceCarry, ASlopeOfSixtyDegreesDividesTheRayFromTheNearestPlace) {
    for (const double rise : {8.0, 15.0}) {
        const auto moved = [&](double degrees) {
            const Proxy ray = stuck_on_a_rising_slope(degrees, rise, never);
            return glm::distance(stuck_on_a_rising_slope(degrees, rise, TouchSettings{}.sudden_speed).point,
                                 ray.point);
        };
        EXPECT_EQ(moved(58), 0) << rise << " mm";
        // From the foot of the perpendicular to the ray's place.
        EXPECT_NEAR(moved(62), rise * std::sin(62 * 3.14159265358979323846 / 180), 0.02 * rise);
    }
}

TEST(SurfaceCarry, WhatIsNotSuddenIsTheSameToTheBitAsWithoutALimit) {
    Random random(5);
    SmallField field(24, 24, 100.0);
    field.shape(field.prev, [&](int, int) { return 150 + random.within(-20, 20); });
    field.shape(field.next, [&](int, int) { return 150 + random.within(-20, 20); });
    FingerState bounded, unbounded;
    TouchSettings wide, none;
    wide.sudden_speed = 1000;
    none.sudden_speed = never;
    int touching = 0;
    for (int tick = 0; tick < 1000; ++tick) {
        const glm::dvec3 goal{random.within(-4, 4), random.within(-4, 4), random.within(-170, -130)};
        const double blend = random.within(0, 0.999);
        const Contact a = field.touch(bounded, goal, blend, wide),
                      b = field.touch(unbounded, goal, blend, none);
        ASSERT_EQ(a.force, b.force) << "tick " << tick;
        ASSERT_EQ(a.proxy, b.proxy) << "tick " << tick;
        EXPECT_FALSE(b.jumped);
        touching += a.touching;
    }
    EXPECT_GT(touching, 200);
}

}  // namespace
}  // namespace touchable::test
