// Scenes and states at the edge of what is let in: touched without a number that is none, and never from
// behind.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "haptics_cpu/world_space.hpp"
#include "tests/frame/random.hpp"
#include "tests/haptics/small_field.hpp"
#include "tests/haptics/touch_rig.hpp"
#include "tests/stress/drawn_scene.hpp"

namespace touchable::test {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// One frame of drawn codes, and a finger. Also of planes that a scene may not have: who links the solver
/// need not ask.
class CodedScene {
public:
    CodedScene(const Scene& made, stress::DrawnPlanes planes) : scene(made) {
        stress::FrameMaker(scene).build(planes, frame_);
        settings.metres_per_scene_unit = 0.16 / scene.depth.far;
    }
    HeightField field() const { return {scene, {{0, 0, &frame_}, {0, 0, &frame_}, 0}}; }
    const Contact& touch(const glm::dvec3& goal) {
        const HeightField now = field();
        TouchSolver::create(scene, settings).value().tick(now, {&goal, 1}, {&finger, 1}, {&contact, 1});
        return contact;
    }
    bool is_sound() const {
        const glm::dvec3 sum = contact.proxy + contact.force + contact.carried + contact.jumped_force;
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
TEST(ExtremeScene, TheFieldIsBoundedByTheNearestValidCode) {
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
            return glm::dvec3(random.below(400) - 200.0, random.below(400) - 200.0,
                              random.below(2) ? 0.25 : -0.4);
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
TEST(ExtremeScene, GoalsThroughTheCamerasPlaneFindTheSurface) {
    const Scene scene = between(1e-9, 1e9);
    for (const glm::dvec3& aside : {glm::dvec3(0), glm::dvec3(0, 5e8, 0), glm::dvec3(5e8, 0, 0)}) {
        CodedScene touched(scene, noise(scene));
        int touching = 0;
        for (int k = 0; k < 200; ++k) {
            const double depth = k % 4 == 0 ? -5e8 : (k % 4 == 1 ? 5e8 : 2e9);
            touched.touch(glm::dvec3(0, 0, -depth) + aside * (k % 8 < 4 ? 1.0 : -1.0));
            ASSERT_TRUE(touched.is_sound()) << k;
            touching += touched.contact.touching;
        }
        EXPECT_GT(touching, 50);
    }
}

TEST(ExtremeScene, WhatIsDeeperThanABillionUnitsIsTouched) {
    const Scene scene = between(1e11, 1e12);
    CodedScene touched(scene, noise(scene));
    touched.touch({0, 0, -1e10});
    EXPECT_FALSE(touched.contact.goal_held);
    EXPECT_TRUE(touched.touch({0, 0, -1.5e12}).touching);
    EXPECT_TRUE(touched.touch({0, 0, -2 * largest_goal(scene)}).goal_held);
}

TEST(ExtremeScene, PixelsThatAreAMillionTimesAsWideAsHighAreTouched) {
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
TEST(ExtremeScene, AStateThatIsNoNumberHealsAtTheNextGoodGoal) {
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

TEST(ExtremeScene, TheScaledMetricHasAScaleAtEveryGoal) {
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

TEST(ExtremeScene, LimitsOfATickAreLimits) {
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
TEST(ExtremeScene, AWayThatIsCutGoesOnInTheNextTick) {
    const Scene scene = between(40, 180);
    const stress::DrawnPlanes planes = noise(scene);
    for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled}) {
        Random random(11);
        int cut = 0, landed = 0, same = 0;
        for (int k = 0; k < 300; ++k) {
            const auto any = [&](double depth) {
                return unproject(scene.camera, random.below(24), random.below(20), depth);
            };
            const glm::dvec3 from = any(35), to = any(60.0 + random.below(200));
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
TEST(ExtremeScene, NoPlaceIsFartherThanTheFarthestCorner) {
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

// What a run reports of a proxy behind the surface, and what tests ask.
TEST(IsBehindSurface, TellsByTheRelativeDepthUnderThePixel) {
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

}  // namespace
}  // namespace touchable::test
