#include <gtest/gtest.h>

#include <cmath>

#include "tests/content/made.hpp"

namespace touchable {
namespace {

using real = long double;
constexpr real degree = 3.14159265358979323846264338L / 180;

SceneOptions tilted(double tilt, double direction) {
    SceneOptions options = sized(320, 240);
    options.tilt_degrees = tilt;
    options.tilt_direction_degrees = direction;
    return options;
}

TEST(Plane, IsTiltedAsAskedForInEveryDirection) {
    for (const double tilt : {0.0, 20.0, 45.0, 60.0})
        for (const double direction : {0.0, 90.0, 180.0, -90.0, 37.0, 360.0}) {
            const auto plane = made("plane", tilted(tilt, direction));
            const real nx = std::sin(tilt * degree) * std::cos(direction * degree);
            const real ny = std::sin(tilt * degree) * std::sin(direction * degree);
            const real nz = std::cos(tilt * degree);
            SplitMix64 random(1);
            for (int trial = 0; trial < 300; ++trial) {
                const glm::dvec3 p = seen(*plane, random.within(0, 319), random.within(0, 239), 0);
                ASSERT_NEAR(static_cast<double>(nx * p.x + ny * p.y + nz * (p.z + 1000.0L)), 0, 1e-9);
            }
        }
}

TEST(Plane, RecedesWhereItIsTold) {
    EXPECT_GT(made("plane", tilted(30, 0))->depth(319, 120, 0),
              made("plane", tilted(30, 0))->depth(0, 120, 0));
    EXPECT_GT(made("plane", tilted(30, 90))->depth(160, 0, 0),
              made("plane", tilted(30, 90))->depth(160, 239, 0));
}

TEST(Plane, ClosestPointIsTheProjection) {
    const auto plane = made("plane", tilted(50, 25));
    SplitMix64 random(2);
    for (int trial = 0; trial < 200; ++trial) {
        const glm::dvec3 goal{random.within(-60, 60), random.within(-40, 40), random.within(-1100, -900)};
        const auto truth = plane->closest(goal, goal, 0);
        const glm::dvec3 out = goal - truth->point;
        const double along = out.x * truth->normal.x + out.y * truth->normal.y + out.z * truth->normal.z;
        ASSERT_NEAR(std::fabs(along), length(out), 1e-10);
        const auto pixel = project(plane->scene().camera, truth->point);
        ASSERT_NEAR(plane->depth(pixel->x, pixel->y, 0), pixel->planar_depth, 1e-9);
    }
}

TEST(Plane, PictureTooTallForItsTiltIsRefused) {
    SceneOptions options = tilted(60, 90);
    options.height = 1280;
    const auto plane = make_scene("plane", options);
    ASSERT_FALSE(plane);
    EXPECT_NE(plane.error().message.find("320x1280"), std::string::npos);
}

struct Ball {
    real x, y, z, radius;
};
constexpr Ball balls[] = {{-22, 4, -1020, 45}, {35, -10, -960, 30}};

TEST(Spheres, DepthIsTheFirstOfTwoBallsAndTheWall) {
    const auto scene = made("spheres", sized(640, 480));
    int on_ball[3] = {0, 0, 0};
    for (int y = 0; y < 480; y += 3)
        for (int x = 0; x < 640; x += 3) {
            const double depth = scene->depth(x, y, 0);
            const real u = scene->scene().camera.u(x), v = scene->scene().camera.v(y);
            // Each ball along the ray by its own quadratic in long double; the wall at 1080.
            real nearest = 1080;
            int which = 2;
            for (int k = 0; k < 2; ++k) {
                const Ball& b = balls[k];
                const real a = u * u + v * v + 1, h = u * b.x + v * b.y - b.z;
                const real c = b.x * b.x + b.y * b.y + b.z * b.z - b.radius * b.radius;
                if (h * h - a * c <= 0) continue;
                const real d = (h - std::sqrt(h * h - a * c)) / a;
                if (d < nearest) {
                    nearest = d;
                    which = k;
                }
            }
            ++on_ball[which];
            ASSERT_NEAR(depth, static_cast<double>(nearest), 1e-8);
        }
    for (const int count : on_ball) EXPECT_GT(count, 1000);
}

TEST(Spheres, OneBallHidesPartOfTheOther) {
    // Along the row through the nearer ball's silhouette the depth leaps from ball to ball, not only to the
    // wall.
    const auto scene = made("spheres", sized(640, 480));
    bool ball_to_ball = false;
    for (int y = 0; y < 480; ++y)
        for (int x = 0; x + 1 < 640; ++x) {
            const double a = scene->depth(x, y, 0), b = scene->depth(x + 1, y, 0);
            ball_to_ball = ball_to_ball || (std::fabs(a - b) > 15 && a < 1079 && b < 1079);
        }
    EXPECT_TRUE(ball_to_ball);
}

TEST(Spheres, ClosestPointIsTheNearestOfAllPieces) {
    const auto scene = made("spheres", sized(640, 480));
    SplitMix64 random(4);
    for (int trial = 0; trial < 300; ++trial) {
        const glm::dvec3 goal{random.within(-90, 90), random.within(-60, 60), random.within(-1085, -930)};
        const auto truth = scene->closest(goal, goal, 0);
        double least = std::fabs(goal.z + 1080);
        for (const Ball& b : balls) {
            const glm::dvec3 centre(static_cast<double>(b.x), static_cast<double>(b.y),
                                    static_cast<double>(b.z));
            least = std::fmin(least, std::fabs(length(goal - centre) - static_cast<double>(b.radius)));
        }
        ASSERT_NEAR(length(truth->point - goal), least, 1e-10);
        ASSERT_NEAR(length(truth->normal), 1, 1e-14);
    }
}

TEST(Step, EightBitCodesRiseByOneToTenLevels) {
    const auto scene = made("step", sized(720, 480, 8));
    const RawFrame frame = scene->frame(0);
    int step = 1;
    for (int x = 1; x < 720; ++x) {
        const int rise = frame.depth.sample(x, 200) - frame.depth.sample(x - 1, 200);
        if (rise == 0) continue;
        EXPECT_EQ(rise, step) << "column " << x;
        ++step;
    }
    EXPECT_EQ(step, 11);
}

TEST(Step, FlatBandsLieExactlyOnLevels) {
    const auto scene = made("step", sized(330, 100));
    const DepthCoding& coding = scene->scene().depth;
    for (int x = 0; x < 330; ++x) {
        const double levels = (coding.far - scene->depth(x, 50, 0)) / coding.level();
        ASSERT_NEAR(levels, std::floor(levels + 0.5), 1e-9);
    }
}

TEST(Step, ClosestPointIsNearestAmongBandsAndRisers) {
    const auto scene = made("step", sized(330, 100));
    SplitMix64 random(6);
    for (int trial = 0; trial < 300; ++trial) {
        const glm::dvec3 goal{random.within(-95, 95), random.within(-25, 25), random.within(-1008, -990)};
        const auto truth = scene->closest(goal, goal, 0);
        const double found = length(truth->point - goal);
        double least = 1e9;  // over columns sampled a hundredth of a pixel apart, at the goal's Y
        for (double x = -2; x < 332; x += 0.01) {
            const double d = scene->depth(x, 0, 0), dx = scene->scene().camera.u(x) * d - goal.x;
            least = std::fmin(least, std::sqrt(dx * dx + (goal.z + d) * (goal.z + d)));
        }
        ASSERT_LE(found, least + 1e-9);
        ASSERT_GT(found, least - 1.0) << "a riser may be nearer than any band, by no more than its height";
        ASSERT_GT(truth->normal.z, -0.1) << "a riser lies along the camera's rays";
    }
}

TEST(Step, NormalOfARiserPointsOverTheLowerBand) {
    const auto scene = made("step", sized(330, 100));
    // Just right of the last step's edge and half way up its 10 levels, inside the higher band.
    const double edge = scene->scene().camera.u(10 * 30 - 0.5), level = scene->scene().depth.level();
    const double d = scene->scene().depth.far - level * (100 + 45 + 5);
    const auto truth = scene->closest({edge * d + 0.01, 0, -d}, {0, 0, 0}, 0);
    EXPECT_LT(truth->normal.x, -0.99);
    EXPECT_NEAR(truth->point.x, edge * d, 1e-3);
}

}  // namespace
}  // namespace touchable
