// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/content/scenes.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/content/made_maps.hpp"
#include "tests/must.hpp"

namespace touchable::test {
namespace {

std::string refusal(std::string_view name, const SceneOptions& options) {
    const auto scene = make_scene(name, options);
    return scene ? "" : scene.error().message;
}

TEST(Scenes, ListKnownNamesForUnknown) {
    const auto scene = make_scene("glob", {});
    ASSERT_FALSE(scene);
    EXPECT_EQ(scene.error().kind, ErrorKind::usage);
    for (const std::string_view name : scene_names())
        EXPECT_NE(scene.error().message.find(name), std::string::npos) << name;
}

TEST(Scenes, NameImpossibleNumbers) {
    EXPECT_NE(refusal("bumps", sized(720, 480, 7)).find("7 bits"), std::string::npos);
    EXPECT_NE(refusal("bumps", sized(720, 480, 17)).find("17 bits"), std::string::npos);
    for (const std::string_view name : scene_names()) {
        for (const auto& [width, height] : {std::pair{1, 480}, {16385, 480}, {720, 1}, {720, 16385}})
            EXPECT_NE(refusal(name, sized(width, height)).find("is impossible"), std::string::npos) << name;
        EXPECT_NE(refusal(name, sized(-5, -5)).find("-5x-5"), std::string::npos) << name;
    }
    EXPECT_NE(refusal("globe", sized(100, 200)).find("too tall"), std::string::npos);
    EXPECT_NE(refusal("rough", sized(100, 401)).find("too tall"), std::string::npos);
    EXPECT_NE(refusal("step", sized(21, 21)).find("21"), std::string::npos);
    for (const double tilt : {-1.0, 60.5, std::nan("")}) {
        SceneOptions options;
        options.tilt_degrees = tilt;
        EXPECT_NE(refusal("plane", options).find("tilt"), std::string::npos) << tilt;
    }
    SceneOptions properties;
    properties.properties = true;
    EXPECT_NE(refusal("bumps", properties).find("globe"), std::string::npos);
}

TEST(Scenes, AreValidForEveryName) {
    for (const std::string_view name : scene_names())
        for (const int bits : {8, 10, 12, 16}) {
            const auto scene = made(name, sized(96, 64, bits));
            ASSERT_TRUE(scene);
            EXPECT_TRUE(validate(scene->scene())) << name;
            EXPECT_EQ(scene->scene().name, name);
            EXPECT_EQ(scene->scene().depth.code_max, (1 << bits) - 1);
            const RawFrame frame = scene->frame(2);
            EXPECT_EQ(frame.number, 2);
            EXPECT_EQ(frame.time_ns, 66666666);
            ASSERT_EQ(frame.depth.width, 96);
            ASSERT_EQ(frame.depth.height, 64);
            EXPECT_EQ(frame.depth.bytes_per_sample, bits == 8 ? 1 : 2);
            for (int y = 0; y < 64; ++y)
                for (int x = 0; x < 96; ++x)
                    ASSERT_TRUE(scene->scene().depth.is_valid(frame.depth.sample(x, y)))
                        << name << " " << x << " " << y;
        }
}

TEST(Scenes, RoundAnalyticDepth) {
    for (const std::string_view name : scene_names())
        for (const int bits : {8, 10, 16}) {
            const auto scene = made(name, sized(90, 60, bits));
            const DepthCoding& coding = scene->scene().depth;
            const double step = (coding.far - coding.near) / coding.code_max;
            const RawFrame frame = scene->frame(17);
            for (int y = 0; y < 60; ++y)
                for (int x = 0; x < 90; ++x) {
                    const double depth = scene->depth(x, y, scene->time_of(17));
                    ASSERT_LE(depth, coding.far) << name;
                    ASSERT_GE(depth, coding.near) << name;
                    ASSERT_LE(std::fabs(coding.depth(frame.depth.sample(x, y)) - depth), step * (0.5 + 1e-9))
                        << name;
                }
        }
}

TEST(Scenes, GiveExactFrames) {
    SceneOptions options = sized(75, 50);
    options.properties = true;
    const auto scene = made("globe", options);
    SurfaceFrame exact;
    exact.codes.assign(3, 7);  // of a slot used before
    exact_frame(*scene, 40, exact);
    const RawFrame frame = scene->frame(40);
    EXPECT_TRUE(exact.codes.empty());
    EXPECT_TRUE(exact.tiles.empty());
    EXPECT_EQ(exact.coding, scene->scene().depth);
    ASSERT_EQ(exact.haptic.size(), 75U * 50U * 3U);
    ASSERT_EQ(exact.heights.size(), 75U * 50U);
    for (int y = 0; y < 50; ++y)
        for (int x = 0; x < 75; ++x) {
            ASSERT_TRUE(exact.is_valid(x, y));
            const DepthSample sample = exact.vertices->at(x, y);
            ASSERT_TRUE(sample.valid);
            ASSERT_EQ(sample.depth, scene->depth(x, y, scene->time_of(40)));
            ASSERT_EQ(exact.heights[exact.index(x, y)], frame.height.sample(x, y));
            ASSERT_EQ(exact.haptic[3 * exact.index(x, y) + 1], frame.haptic.sample(x, y, 1));
        }
}

TEST(Scenes, HaveRequestedRate) {
    SceneOptions options = sized(64, 48);
    options.rate = {30000, 1001};
    const auto scene = made("moving", options);
    EXPECT_EQ(scene->scene().rate.num, 30000);
    EXPECT_EQ(scene->frame(30000).time_ns, 1001'000'000'000);
    EXPECT_DOUBLE_EQ(scene->time_of(30000), 1001);
    EXPECT_EQ(scene->frame(3).depth.sample(40, 20),
              scene->scene().depth.code(scene->depth(40, 20, 3 * 1001.0 / 30000)));
}

/// All bytes of a frame, plane after plane.
std::string bytes_of(const RawFrame& frame) {
    std::string bytes;
    for (const PlaneView* plane : {&frame.depth, &frame.colour, &frame.haptic, &frame.height})
        for (int y = 0; y < plane->height; ++y)
            bytes.append(reinterpret_cast<const char*>(plane->row(y)),
                         static_cast<std::size_t>(plane->stride));
    return bytes;
}

TEST(Scenes, GiveSameBitsWithThreads) {
    for (const std::string_view name : scene_names()) {
        SceneOptions options = sized(75, 151, name == "step" ? 8 : 16);
        if (name == "globe") options = sized(150, 101);
        options.properties = name == "globe";
        options.threads = 1;
        const std::string alone = bytes_of(made(name, options)->frame(5));
        for (const int threads : {2, 3, 7}) {
            options.threads = threads;
            EXPECT_TRUE(bytes_of(made(name, options)->frame(5)) == alone) << name << ", " << threads;
        }
    }
}

TEST(Scenes, GiveFramesThatOutliveThem) {
    auto scene = made("bumps", sized(20, 20));
    const std::uint16_t code = scene->frame(0).depth.sample(3, 4);
    const RawFrame frame = scene->frame(5);
    scene.reset();
    EXPECT_EQ(frame.depth.sample(3, 4), code);
}

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

TEST_P(HeightFields, Show200MillimetresAtOneMetre) {
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

TEST_P(HeightFields, SolveTheirDefinition) {
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

TEST_P(HeightFields, HaveRightDerivatives) {
    SplitMix64 random(5);
    for (int trial = 0; trial < 500; ++trial) {
        const double x = random.within(-100, 100), y = random.within(-70, 70), t = random.within(0, 3);
        const ReliefPoint at = surface_at(relief_of(GetParam()), x, y, t);
        const auto z = [&](real dx, real dy) {
            return 1000 * height(GetParam(), (x + dx) / 1000, (y + dy) / 1000, t);
        };
        const real h = 1e-4L;
        ASSERT_NEAR(at.z, static_cast<double>(z(0, 0) - 1000), 1e-12 * 1000);
        ASSERT_NEAR(at.zx, static_cast<double>((z(h, 0) - z(-h, 0)) / (2 * h)), 1e-8);
        ASSERT_NEAR(at.zy, static_cast<double>((z(0, h) - z(0, -h)) / (2 * h)), 1e-8);
        ASSERT_NEAR(at.zxx, static_cast<double>((z(h, 0) - 2 * z(0, 0) + z(-h, 0)) / (h * h)), 1e-6);
        ASSERT_NEAR(at.zyy, static_cast<double>((z(0, h) - 2 * z(0, 0) + z(0, -h)) / (h * h)), 1e-6);
        ASSERT_NEAR(at.zxy, static_cast<double>((z(h, h) - z(h, -h) - z(-h, h) + z(-h, -h)) / (4 * h * h)),
                    1e-6);
    }
}

TEST_P(HeightFields, FindLocallyClosestPoint) {
    const ExactSurface exact(GetParam(), sized(720, 480));
    ReliefStroke stroke(relief_of(GetParam()), 720, 480, 0.3);
    SplitMix64 random(11);
    glm::dvec3 tracked{0, 0, -1000};
    for (int tick = 0; tick < 5000; ++tick) {
        const double t = tick * 0.001;
        const glm::dvec3 goal = stroke.next().goal;
        const auto truth = exact.closest(goal, tracked, t);
        ASSERT_TRUE(truth);
        tracked = truth->point;
        if (tick % 25 != 0) continue;
        const glm::dvec3 p = truth->point, out = p - goal;
        ASSERT_NEAR(p.z, surface_at(relief_of(GetParam()), p.x, p.y, t).z, 1e-12 * 1000);
        const glm::dvec3 n = truth->normal;
        const glm::dvec3 across{out.y * n.z - out.z * n.y, out.z * n.x - out.x * n.z,
                                out.x * n.y - out.y * n.x};
        ASSERT_LT(length(across), 1e-10) << "tick " << tick;
        ASSERT_NEAR(length(n), 1, 1e-14);
        for (int probe = 0; probe < 50; ++probe) {
            const double reach = probe % 2 ? 0.02 : 0.0005;
            const double x = p.x + random.within(-reach, reach), y = p.y + random.within(-reach, reach);
            const glm::dvec3 near{x, y, surface_at(relief_of(GetParam()), x, y, t).z};
            ASSERT_GE(length(near - goal), length(out) - 1e-12) << "tick " << tick;
        }
    }
}

TEST(HeightFieldDescent, StaysInItsBasin) {
    // A goal midway over a valley's axis is nearest to both flanks; each start keeps its own side.
    const ExactSurface exact("bumps", sized(720, 480));
    const glm::dvec3 goal{-25, 20, -950};
    const auto left = exact.closest(goal, {-15, 20, -1000}, 0),
               right = exact.closest(goal, {-40, 20, -1000}, 0);
    ASSERT_TRUE(left && right);
    EXPECT_GT(left->point.x, goal.x);
    EXPECT_LT(right->point.x, goal.x);
    EXPECT_GT(length(left->point - right->point), 5);
}

TEST(HeightFieldMotion, IsOnlyInMoving) {
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

TEST(Noise, CoversRangeUniformly) {
    for (const int bits : {8, 10, 16}) {
        const RawFrame frame = made("noise", sized(128, 128, bits))->frame(0);
        std::array<int, 16> bins{};
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 128; ++x)
                ++bins[static_cast<std::size_t>(frame.depth.sample(x, y) >> (bits - 4))];
        for (const int count : bins) EXPECT_NEAR(count, 1024, 5 * 31);  // five standard deviations
    }
}

TEST(Noise, MakesCliffsNearOrFar) {
    const auto scene = made("cliffs", sized(128, 128, 10));
    const RawFrame frame = scene->frame(0);
    int near = 0;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) {
            const int code = frame.depth.sample(x, y);
            ASSERT_TRUE(code == 0 || code == 1023);
            near += code == 1023;
        }
    EXPECT_NEAR(near, 8192, 5 * 64);
}

TEST(Noise, KeepsGrainWithinTwoLevels) {
    const RawFrame frame = made("grain", sized(128, 128, 8))->frame(0);
    std::array<int, 5> counts{};
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) {
            const int off = frame.depth.sample(x, y) - 128;
            ASSERT_LE(std::abs(off), 2);
            ++counts[static_cast<std::size_t>(off + 2)];
        }
    for (const int count : counts) EXPECT_NEAR(count, 3277, 5 * 51);
}

TEST(Noise, HasUncorrelatedNeighbours) {
    const RawFrame frame = made("noise", sized(128, 128, 16))->frame(0);
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}}) {
        double product = 0;
        for (int y = 0; y < 127; ++y)
            for (int x = 0; x < 127; ++x)
                product += (frame.depth.sample(x, y) / 65535.0 - 0.5) *
                           (frame.depth.sample(x + dx, y + dy) / 65535.0 - 0.5);
        EXPECT_NEAR(product / (127 * 127) * 12, 0, 5.0 / 127) << dx << " " << dy;
    }
}

TEST(Noise, RepeatsPerSeed) {
    for (const std::string_view name : {"noise", "cliffs", "grain"}) {
        SceneOptions options = sized(128, 128);
        options.seed = 7;
        const RawFrame a = made(name, options)->frame(0), again = made(name, options)->frame(0);
        options.seed = 8;
        const RawFrame b = made(name, options)->frame(0);
        EXPECT_EQ(std::memcmp(a.depth.data, again.depth.data, 128U * 128U * 2U), 0);
        EXPECT_NE(std::memcmp(a.depth.data, b.depth.data, 128U * 128U * 2U), 0);
    }
}

TEST(Noise, HasNoTruth) {
    const glm::dvec3 goal{0, 0, -100};
    for (const std::string_view name : {"noise", "cliffs", "grain"})
        EXPECT_FALSE(ExactSurface(name, sized(128, 128)).closest(goal, goal, 0));
    SceneOptions planet = sized(90, 60);
    planet.properties = true;
    EXPECT_FALSE(ExactSurface("globe", planet).closest(goal, goal, 0));
}

constexpr real degree = 3.14159265358979323846264338L / 180;

SceneOptions tilted(double tilt, double direction) {
    SceneOptions options = sized(320, 240);
    options.tilt_degrees = tilt;
    options.tilt_direction_degrees = direction;
    return options;
}

TEST(Plane, TiltsInEveryDirection) {
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

TEST(Plane, FindsClosestPointByProjection) {
    const auto plane = made("plane", tilted(50, 25));
    const ExactSurface exact("plane", tilted(50, 25));
    SplitMix64 random(2);
    for (int trial = 0; trial < 200; ++trial) {
        const glm::dvec3 goal{random.within(-60, 60), random.within(-40, 40), random.within(-1100, -900)};
        const auto truth = exact.closest(goal, goal, 0);
        const glm::dvec3 out = goal - truth->point;
        const double along = out.x * truth->normal.x + out.y * truth->normal.y + out.z * truth->normal.z;
        ASSERT_NEAR(std::fabs(along), length(out), 1e-10);
        const auto pixel = project(plane->scene().camera, truth->point);
        ASSERT_NEAR(plane->depth(pixel->x, pixel->y, 0), pixel->planar_depth, 1e-9);
    }
}

TEST(Plane, RejectsTooTallPictures) {
    SceneOptions options = tilted(60, 90);
    options.height = 1280;
    expect_error(make_scene("plane", options), "320x1280");
}

struct Ball {
    real x, y, z, radius;
};
constexpr Ball balls[] = {{-22, 4, -1020, 45}, {35, -10, -960, 30}};

TEST(Spheres, ShowNearestPiece) {
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

TEST(Spheres, FindClosestOfAllPieces) {
    const ExactSurface exact("spheres", sized(640, 480));
    SplitMix64 random(4);
    for (int trial = 0; trial < 300; ++trial) {
        const glm::dvec3 goal{random.within(-90, 90), random.within(-60, 60), random.within(-1085, -930)};
        const auto truth = exact.closest(goal, goal, 0);
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

TEST(Step, RisesByGrowingLevels) {
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

TEST(Step, LiesExactlyOnLevels) {
    const auto scene = made("step", sized(330, 100));
    const DepthCoding& coding = scene->scene().depth;
    for (int x = 0; x < 330; ++x) {
        const double levels = (coding.far - scene->depth(x, 50, 0)) / coding.level();
        ASSERT_NEAR(levels, std::floor(levels + 0.5), 1e-9);
    }
}

TEST(Step, FindsClosestBandOrRiser) {
    const auto scene = made("step", sized(330, 100));
    const ExactSurface exact("step", sized(330, 100));
    SplitMix64 random(6);
    for (int trial = 0; trial < 300; ++trial) {
        const glm::dvec3 goal{random.within(-95, 95), random.within(-25, 25), random.within(-1008, -990)};
        const auto truth = exact.closest(goal, goal, 0);
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

TEST(Step, HasRiserNormalsOverBands) {
    const auto scene = made("step", sized(330, 100));
    // Just right of the last step's edge and half way up its 10 levels, inside the higher band.
    const double edge = scene->scene().camera.u(10 * 30 - 0.5), level = scene->scene().depth.level();
    const double d = scene->scene().depth.far - level * (100 + 45 + 5);
    const auto truth = ExactSurface("step", sized(330, 100)).closest({edge * d + 0.01, 0, -d}, {0, 0, 0}, 0);
    EXPECT_LT(truth->normal.x, -0.99);
    EXPECT_NEAR(truth->point.x, edge * d, 1e-3);
}

constexpr double one_degree = 3.14159265358979323846 / 180;

TEST(GlobeStroke, RunsOneMillimetreUnderSphere) {
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

TEST(GlobeStroke, ApproachesStraightFromOutside) {
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

TEST(GlobeStroke, StaysInCamerasView) {
    const auto globe = made("globe");
    const GlobeStroke stroke(CameraPreset::b, 720, 480);
    const ExactSurface exact("globe");
    for (int tick = 200; tick < 20200; tick += 7) {
        const auto truth = exact.closest(stroke.at(tick).goal, {}, 0);
        const auto pixel = project(globe->scene().camera, truth->point);
        ASSERT_TRUE(pixel);
        ASSERT_NEAR(globe->depth(pixel->x, pixel->y, 0), length(truth->point), 1e-9) << tick;
    }
}

TEST(ReliefStroke, KeepsSpeedExceptWhenReflected) {
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

TEST(ReliefStroke, StartsAboveMiddleAndTurns) {
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

TEST(ReliefStroke, StaysUnderShownSurface) {
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

TEST(RandomWalk, MovesInStepsAndJumps) {
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
}  // namespace touchable::test
