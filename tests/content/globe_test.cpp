#include <gtest/gtest.h>

#include <cmath>

#include "engine/content/families.hpp"
#include "tests/content/made.hpp"

namespace touchable {
namespace {

using real = long double;

struct Published {
    CameraPreset preset;
    real focal_length, pixel_width, near, far, distance;
    double width_degrees, height_degrees;
};
const Published published[] = {
    {CameraPreset::a, 6.983L, 0.00123L, 10, 200, 105, 7.26, 4.84},
    {CameraPreset::a_prime, 6.983L, 0.0123L, 10, 200, 105, 64.8, 45.8},
    {CameraPreset::b, 4.7L, 0.0112L, 40, 180, 110, 81.3, 59.5},
};

double degrees(double radians) {
    return radians * 180 / 3.14159265358979;
}

TEST(Globe, PresetsHaveThePublishedFieldsOfView) {
    for (const Published& p : published) {
        SceneOptions options;
        options.preset = p.preset;
        const auto globe = made("globe", options);
        const Camera& camera = globe->scene().camera;
        EXPECT_NEAR(degrees(2 * std::atan(360 / camera.fx)), p.width_degrees, 0.05);
        EXPECT_NEAR(degrees(2 * std::atan(240 / camera.fy)), p.height_degrees, 0.05);
        EXPECT_EQ(camera.cx, 360);
        EXPECT_EQ(camera.cy, 239);
        EXPECT_EQ(globe->scene().depth.semantics, DepthSemantics::range);
    }
}

TEST(Globe, HorizontalFieldOfViewIsTheSameAtEverySize) {
    for (const auto& [width, height] : {std::pair{320, 240}, {1280, 720}, {1920, 1080}, {3840, 2160}}) {
        const auto globe = made("globe", sized(width, height));
        EXPECT_NEAR(globe->scene().camera.fx * 720 / width, 4.7 / 0.0112, 1e-9);
    }
}

TEST(Globe, DepthIsTheNearerCrossingOfRayAndSphere) {
    for (const Published& p : published)
        for (const auto& [width, height] : {std::pair{320, 240}, {720, 480}, {1920, 1080}}) {
            SceneOptions options = sized(width, height);
            options.preset = p.preset;
            const auto globe = made("globe", options);
            const real scale = p.pixel_width * 720 / width / p.focal_length;
            const real radius = p.distance * std::sin(std::atan(0.8L * (height / 2.0L) * scale));
            SplitMix64 random(static_cast<std::uint64_t>(width));
            int met = 0;
            for (int trial = 0; trial < 4000; ++trial) {
                const double x = random.within(-1, width), y = random.within(-1, height);
                // |s (u, v, -1) - (0, 0, -D)| = R for the planar depth s; the range is s L.
                const real u = (x - width / 2) * scale, v = -(y - (height / 2 - 1)) * scale;
                const real a = u * u + v * v + 1, half_b = p.distance,
                           c = p.distance * p.distance - radius * radius;
                const real under_root = half_b * half_b - a * c;
                if (std::fabs(under_root) < 1e-9L) continue;
                const real range =
                    under_root > 0 ? (half_b - std::sqrt(under_root)) / a * std::sqrt(a) : p.far;
                met += under_root > 0;
                const double limb = static_cast<double>(1 / std::sqrt(std::fabs(under_root)));
                ASSERT_NEAR(globe->depth(x, y, 0), static_cast<double>(range), 1e-12 * (100 + 1000 * limb));
            }
            EXPECT_GT(met, 500);
        }
}

TEST(Globe, FillsEightTenthsOfThePicturesHeight) {
    for (const Published& p : published)
        for (const auto& [width, height] : {std::pair{320, 240}, {720, 480}, {1920, 1080}}) {
            SceneOptions options = sized(width, height);
            options.preset = p.preset;
            const auto globe = made("globe", options);
            int rows = 0, columns = 0;
            for (int y = 0; y < height; ++y) rows += globe->depth(width / 2, y, 0) < globe->scene().depth.far;
            for (int x = 0; x < width; ++x)
                columns += globe->depth(x, height / 2 - 1, 0) < globe->scene().depth.far;
            EXPECT_NEAR(rows, 0.8 * height, 1);
            EXPECT_NEAR(columns, 0.8 * height, 1);
        }
}

TEST(Globe, BesideTheSphereLiesTheFarPlaneAsCodeZero) {
    for (const int bits : {8, 16}) {
        const auto globe = made("globe", sized(120, 80, bits));
        EXPECT_EQ(globe->frame(0).depth.sample(0, 0), 0);
        EXPECT_GT(globe->frame(0).depth.sample(60, 40), 0);
    }
}

TEST(Globe, RadiusCorrespondsTo32MillimetresOfTheDevice) {
    const auto globe = made("globe");
    const GlobeSphere sphere = globe_sphere(CameraPreset::b, 720, 480);
    EXPECT_NEAR(sphere.radius, 45.77, 0.01);
    EXPECT_DOUBLE_EQ(*globe->scene().device_metres_per_unit * sphere.radius, 0.032);
    EXPECT_EQ(globe->scene().default_properties.stiffness, 1000);
    EXPECT_EQ(globe->scene().default_properties.static_friction, 0);
}

TEST(Globe, ClosestPointIsUnderTheGoalsOwnNormal) {
    const auto globe = made("globe");
    const GlobeSphere sphere = globe_sphere(CameraPreset::b, 720, 480);
    SplitMix64 random(3);
    for (int trial = 0; trial < 200; ++trial) {
        const glm::dvec3 way{random.within(-1, 1), random.within(-1, 1), random.within(0.1, 1)};
        const double reach = random.within(0.5, 1.2) * sphere.radius;
        const glm::dvec3 goal = sphere.centre + way * (reach / length(way));
        const auto truth = globe->closest(goal, goal, 0);
        ASSERT_TRUE(truth);
        ASSERT_NEAR(length(truth->point - sphere.centre), sphere.radius, 1e-12 * sphere.radius);
        ASSERT_NEAR(length(truth->normal - way / length(way)), 0, 1e-14);
        ASSERT_NEAR(length(truth->point - goal), std::fabs(reach - sphere.radius), 1e-12 * sphere.radius);
    }
    const auto centre = globe->closest(sphere.centre, sphere.centre, 0);
    EXPECT_NEAR(length(centre->point - sphere.centre), sphere.radius, 1e-12 * sphere.radius);
}

}  // namespace
}  // namespace touchable
