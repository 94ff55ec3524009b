#include "engine/content/height_fields.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "tests/content/made.hpp"

namespace touchable {
namespace {

constexpr double one_degree = 3.14159265358979323846 / 180;

TEST(GlobeStroke, RunsOneMillimetreUnderTheSphereAlongItsNormals) {
    const GlobeStroke stroke(CameraPreset::b, 720, 480);
    const GlobeSphere sphere = globe_sphere(CameraPreset::b, 720, 480);
    const double units_per_mm = sphere.radius / 32;
    std::array<int, 4> bins{};
    for (int tick = GlobeStroke::approach_ticks;
         tick < GlobeStroke::approach_ticks + GlobeStroke::stroke_ticks; ++tick) {
        const double T = (tick - 200) * 0.001;
        const GlobeStroke::Goal at = stroke.at(tick);
        double nx = std::sin(50 * one_degree * std::sin(2 * M_PI * 0.37 * T));
        double ny = std::sin(50 * one_degree * std::sin(2 * M_PI * 0.29 * T + 1));
        if (nx * nx + ny * ny > 0.72) {
            const double scale = std::sqrt(0.72 / (nx * nx + ny * ny));
            nx *= scale, ny *= scale;
        }
        ASSERT_NEAR(at.normal.x, nx, 1e-13);
        ASSERT_NEAR(at.normal.y, ny, 1e-13);
        ASSERT_NEAR(length(at.normal), 1, 1e-14);
        ASSERT_GT(at.normal.z, 0);
        ASSERT_NEAR(length(at.goal - sphere.centre - (sphere.radius - units_per_mm) * at.normal), 0, 1e-10);
        ASSERT_NEAR(at.polar_angle, std::acos(at.normal.z), 1e-12);
        ASSERT_LE(at.polar_angle, 58.06 * one_degree);
        const double polar = at.polar_angle / one_degree;
        ++bins[polar < 15 ? 0 : polar < 30 ? 1 : polar < 45 ? 2 : 3];
    }
    for (const int count : bins) EXPECT_GT(count, 500);
}

TEST(GlobeStroke, ApproachesStraightFromTenMillimetresOutside) {
    const GlobeStroke stroke(CameraPreset::a_prime, 720, 480);
    const GlobeSphere sphere = globe_sphere(CameraPreset::a_prime, 720, 480);
    const double units_per_mm = sphere.radius / 32;
    EXPECT_NEAR(length(stroke.at(0).goal - sphere.centre), sphere.radius + 10 * units_per_mm, 1e-10);
    for (int tick = 1; tick <= 200; ++tick) {
        EXPECT_NEAR(length(stroke.at(tick).goal - stroke.at(tick - 1).goal), 11.0 / 200 * units_per_mm,
                    1e-10);
        EXPECT_EQ(stroke.at(tick).normal, stroke.at(200).normal);
    }
}

TEST(GlobeStroke, GoesOnlyWhereTheCameraSeesTheSphere) {
    const auto globe = made("globe");
    const GlobeStroke stroke(CameraPreset::b, 720, 480);
    for (int tick = 200; tick < 20200; tick += 7) {
        const auto truth = globe->closest(stroke.at(tick).goal, {}, 0);
        const auto pixel = project(globe->scene().camera, truth->point);
        ASSERT_TRUE(pixel);
        ASSERT_NEAR(globe->depth(pixel->x, pixel->y, 0), length(truth->point), 1e-9) << tick;
    }
}

TEST(ReliefStroke, KeepsItsSpeedExceptWhereItIsReflected) {
    for (const double speed : {0.05, 0.1, 0.3}) {
        ReliefStroke stroke(Relief::bumps, 1280, 720, speed);
        glm::dvec3 before = stroke.next().goal;
        int reflected = 0;
        for (int tick = 1; tick < 30000; ++tick) {
            const glm::dvec3 goal = stroke.next().goal;
            const double moved = std::hypot(goal.x - before.x, goal.y - before.y);
            ASSERT_LE(moved, speed + 1e-12);
            reflected += moved < speed - 1e-12;
            ASSERT_LE(std::fabs(goal.x), 88);
            ASSERT_LE(std::fabs(goal.y), 100.0 * 719 / 1279 - 12);
            before = goal;
        }
        EXPECT_LT(reflected, 400);
        EXPECT_TRUE(speed < 0.2 || reflected > 3);
    }
}

TEST(ReliefStroke, StartsAtTheMiddleFiftyMillimetresAboveAndTurnsAsDefined) {
    ReliefStroke stroke(Relief::bumps, 720, 480, 0.1);
    const ReliefStroke::Goal first = stroke.next(), second = stroke.next();
    EXPECT_EQ(first.goal.x, 0);
    EXPECT_EQ(first.goal.y, 0);
    EXPECT_EQ(first.under, -50);
    EXPECT_NEAR(std::atan2(second.goal.y, second.goal.x), 0.3, 1e-12);
    glm::dvec3 before = second.goal;
    for (int tick = 2; tick < 500; ++tick) {  // far from any edge: the heading is the integral of the law
        const glm::dvec3 goal = stroke.next().goal;
        const double t = (tick - 1) * 0.001;
        const double heading = 0.3 + 0.4 * t + 0.9 * (1 - std::cos(2 * M_PI * 0.37 * t)) / (2 * M_PI * 0.37);
        ASSERT_NEAR(std::atan2(goal.y - before.y, goal.x - before.x), heading, 2e-3);
        before = goal;
    }
}

TEST(ReliefStroke, StaysUnderTheSurfaceThatTheSceneShows) {
    for (const auto& [relief, name] :
         {std::pair{Relief::bumps, "bumps"}, {Relief::rough, "rough"}, {Relief::moving, "moving"}}) {
        const auto scene = made(name, sized(320, 240));
        ReliefStroke stroke(relief, 320, 240, 0.3);
        for (int tick = 0; tick < 5000; ++tick) {
            const double t = tick * 0.001;
            const ReliefStroke::Goal at = stroke.next();
            const auto pixel = project(scene->scene().camera, at.goal + glm::dvec3(0, 0, at.under));
            ASSERT_TRUE(pixel);
            ASSERT_NEAR(scene->depth(pixel->x, pixel->y, t), pixel->planar_depth, 1e-9);
            const double law = 3.5 + 1.5 * std::sin(2 * M_PI * 0.9 * t);
            ASSERT_NEAR(at.under, tick >= 250 ? law : -50 + (law + 50) * tick / 250, 1e-11);
        }
    }
}

TEST(RandomWalk, MovesAPixelAndThreeUnitsAndJumpsEveryFiftiethTick) {
    const auto scene = made("noise", sized(128, 128));
    const Scene& s = scene->scene();
    RandomWalk walk(s, 1), again(s, 1), other(s, 2);
    Camera::ImagePoint before = *project(s.camera, walk.next());
    (void)again.next();
    int jumps = 0, in_picture = 0;
    bool differs = false;
    const int ticks = 50000;
    for (int tick = 0; tick < ticks; ++tick) {
        const glm::dvec3 goal = walk.next();
        ASSERT_EQ(goal, again.next());
        differs = differs || goal != other.next();
        const auto at = project(s.camera, goal);
        ASSERT_TRUE(at);
        jumps += std::fabs(at->x - before.x) > 1 + 1e-9 || std::fabs(at->y - before.y) > 1 + 1e-9 ||
                 std::fabs(at->planar_depth - before.planar_depth) > 3 + 1e-9;
        ASSERT_GT(at->planar_depth, 0.89 * s.depth.near);
        ASSERT_LT(at->planar_depth, 1.06 * s.depth.far);
        in_picture += at->x >= 0 && at->x <= 127 && at->y >= 0 && at->y <= 127;
        before = *at;
    }
    EXPECT_NEAR(jumps, ticks / 50, 5 * 32);
    EXPECT_GT(in_picture, 0.8 * ticks);
    EXPECT_LT(in_picture, ticks);
    EXPECT_TRUE(differs);
}

}  // namespace
}  // namespace touchable
