#include "engine/content/height_fields.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include "tests/content/made.hpp"

namespace touchable {
namespace {

using real = long double;
constexpr real pi_l = 3.14159265358979323846264338L;

/// b in metres of x, y in metres, as the definition prints it.
real height(std::string_view name, real x, real y, real t) {
    const auto wave = [](real amplitude, real along, real period, real phase) {
        return amplitude * std::sin(2 * pi_l * along / period + phase);
    };
    if (name == "rough")
        return wave(0.0040L, x, 0.060L, 0) + wave(0.0030L, y, 0.045L, 0.7L) +
               wave(0.0015L, x + y, 0.020L, 1.3L) + wave(0.0004L, x - 2 * y, 0.007L, 0.2L);
    real b = wave(0.005L, x, 0.100L, 0) + wave(0.004L, y, 0.080L, 0.7L) + wave(0.0008L, x + y, 0.030L, 1.3L) +
             wave(0.000015L, x - 2 * y, 0.006L, 0.2L);
    if (name == "moving") b += 0.020L * std::sin(2 * pi_l * 0.5L * t);
    return b;
}

Relief relief_of(std::string_view name) {
    return name == "rough" ? Relief::rough : name == "moving" ? Relief::moving : Relief::bumps;
}

class HeightFields : public testing::TestWithParam<std::string_view> {};
INSTANTIATE_TEST_SUITE_P(, HeightFields, testing::Values("bumps", "rough", "moving"),
                         [](const auto& test) { return std::string(test.param); });

TEST_P(HeightFields, CameraSeesTwoHundredMillimetresAtOneMetre) {
    const auto scene = made(GetParam(), sized(320, 240));
    const Scene& s = scene->scene();
    EXPECT_DOUBLE_EQ(unproject(s.camera, 0, 0, 1000).x, -100);
    EXPECT_DOUBLE_EQ(unproject(s.camera, 319, 0, 1000).x, 100);
    EXPECT_DOUBLE_EQ(unproject(s.camera, 0, 0, 1000).y, 100.0 * 239 / 319);
    EXPECT_EQ(s.depth.semantics, DepthSemantics::planar);
    EXPECT_EQ(s.depth.near, GetParam() == "moving" ? 960 : 980);
    EXPECT_EQ(s.depth.far, GetParam() == "moving" ? 1040 : 1020);
    EXPECT_EQ(s.device_metres_per_unit, 0.001);
}

TEST_P(HeightFields, EveryPixelsDepthSolvesTheDefinition) {
    for (const auto& [width, rows] : {std::pair{320, 240}, {1920, 1080}, {100, 400}}) {
        const auto scene = made(GetParam(), sized(width, rows));
        const real focal = (width - 1) * 1000.0L / 200;
        SplitMix64 random(static_cast<std::uint64_t>(width));
        for (int trial = 0; trial < 3000; ++trial) {
            const double x = random.within(0, width - 1), y = random.within(0, rows - 1),
                         t = random.within(0, 20);
            const double d = scene->depth(x, y, t);
            const real u = (x - (width - 1) / 2.0L) / focal, v = -(y - (rows - 1) / 2.0L) / focal;
            const real residual = d - (1000 - 1000 * height(GetParam(), d * u / 1000, d * v / 1000, t));
            ASSERT_NEAR(static_cast<double>(residual), 0, 2e-12) << x << " " << y << " " << t;
        }
    }
}

TEST_P(HeightFields, DerivativesAreThoseOfTheSurface) {
    SplitMix64 random(5);
    for (int trial = 0; trial < 500; ++trial) {
        const double x = random.within(-100, 100), y = random.within(-70, 70), t = random.within(0, 3);
        const ReliefPoint at = relief_at(relief_of(GetParam()), x, y, t);
        const auto z = [&](real dx, real dy) {
            return 1000 * height(GetParam(), (x + dx) / 1000, (y + dy) / 1000, t);
        };
        const real h = 1e-4L;
        ASSERT_NEAR(at.z, static_cast<double>(z(0, 0) - 1000), 1e-12 * 1000);
        ASSERT_EQ(at.z, relief_z(relief_of(GetParam()), x, y, t));
        ASSERT_NEAR(at.zx, static_cast<double>((z(h, 0) - z(-h, 0)) / (2 * h)), 1e-8);
        ASSERT_NEAR(at.zy, static_cast<double>((z(0, h) - z(0, -h)) / (2 * h)), 1e-8);
        ASSERT_NEAR(at.zxx, static_cast<double>((z(h, 0) - 2 * z(0, 0) + z(-h, 0)) / (h * h)), 1e-6);
        ASSERT_NEAR(at.zyy, static_cast<double>((z(0, h) - 2 * z(0, 0) + z(0, -h)) / (h * h)), 1e-6);
        ASSERT_NEAR(at.zxy, static_cast<double>((z(h, h) - z(h, -h) - z(-h, h) + z(-h, -h)) / (4 * h * h)),
                    1e-6);
    }
}

TEST_P(HeightFields, ClosestPointIsALocalMinimumOnTheSurface) {
    const auto scene = made(GetParam(), sized(720, 480));
    ReliefStroke stroke(relief_of(GetParam()), 720, 480, 0.3);
    SplitMix64 random(11);
    glm::dvec3 tracked{0, 0, -1000};
    for (int tick = 0; tick < 5000; ++tick) {
        const double t = tick * 0.001;
        const glm::dvec3 goal = stroke.next().goal;
        const auto truth = scene->closest(goal, tracked, t);
        ASSERT_TRUE(truth);
        tracked = truth->point;
        if (tick % 25 != 0) continue;
        const glm::dvec3 p = truth->point, out = p - goal;
        ASSERT_NEAR(p.z, relief_z(relief_of(GetParam()), p.x, p.y, t), 1e-12 * 1000);
        const glm::dvec3 n = truth->normal;
        const glm::dvec3 across{out.y * n.z - out.z * n.y, out.z * n.x - out.x * n.z,
                                out.x * n.y - out.y * n.x};
        ASSERT_LT(length(across), 1e-10) << "tick " << tick;
        ASSERT_NEAR(length(n), 1, 1e-14);
        for (int probe = 0; probe < 50; ++probe) {
            const double reach = probe % 2 ? 0.02 : 0.0005;
            const double x = p.x + random.within(-reach, reach), y = p.y + random.within(-reach, reach);
            const glm::dvec3 near{x, y, relief_z(relief_of(GetParam()), x, y, t)};
            ASSERT_GE(length(near - goal), length(out) - 1e-12) << "tick " << tick;
        }
    }
}

TEST(HeightFieldsDescent, StaysInTheBasinItStartedIn) {
    // A goal midway over a valley's axis is nearest to both flanks; each start keeps its own side.
    const auto scene = made("bumps", sized(720, 480));
    const glm::dvec3 goal{-25, 20, -950};
    const auto left = scene->closest(goal, {-15, 20, -1000}, 0),
               right = scene->closest(goal, {-40, 20, -1000}, 0);
    ASSERT_TRUE(left && right);
    EXPECT_GT(left->point.x, goal.x);
    EXPECT_LT(right->point.x, goal.x);
    EXPECT_GT(length(left->point - right->point), 5);
}

TEST(HeightFieldsStillness, OnlyMovingMoves) {
    for (const std::string_view name : {"bumps", "rough", "moving"}) {
        const auto scene = made(name, sized(30, 20));
        const RawFrame a = scene->frame(0), b = scene->frame(10);
        bool same = true;
        for (int y = 0; y < 20; ++y)
            for (int x = 0; x < 30; ++x) same = same && a.depth.sample(x, y) == b.depth.sample(x, y);
        EXPECT_EQ(same, name != "moving");
        EXPECT_EQ(a.depth.data == b.depth.data, name != "moving");  // made once
    }
}

}  // namespace
}  // namespace touchable
