#include "engine/scene/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include "tests/scene/random.hpp"

namespace touchable {
namespace {

constexpr double unit_roundoff = 0x1p-53;

/// The conventions once more, independently, in long double.
struct LongPoint {
    long double x, y, z;
};
LongPoint long_unproject(const Camera& camera, DepthSemantics semantics, double i, double j, double depth) {
    const long double u = (static_cast<long double>(i) - static_cast<long double>(camera.cx)) / camera.fx;
    const long double v = (static_cast<long double>(camera.cy) - static_cast<long double>(j)) / camera.fy;
    long double along = depth;
    if (semantics == DepthSemantics::range) along /= std::sqrt(u * u + v * v + 1.0L);
    return {along * u, along * v, -along};
}

Camera random_camera(Random& random, int width, int height) {
    return {random.between(0.3, 4.0) * width, random.between(0.3, 4.0) * width,
            random.between(-0.2, 1.2) * width, random.between(-0.2, 1.2) * height};
}

double degrees_of_view(int pixels, double focal_pixels) {
    return 2.0 * std::atan(pixels / 2.0 / focal_pixels) * 180.0 / std::acos(-1.0);
}

struct Preset {
    const char* name;
    double focal_length, pixel_width, horizontal, vertical;  // degrees at 720x480
};
constexpr Preset presets[] = {
    {"A", 6.983, 0.00123, 7.3, 4.8}, {"A'", 6.983, 0.0123, 64.8, 45.8}, {"B", 4.7, 0.0112, 81.3, 59.5}};

TEST(Camera, PaperPresetsHaveTheirFieldsOfView) {
    for (const Preset& preset : presets) {
        const Camera camera = camera_from_focal_length(preset.focal_length, preset.pixel_width, 720, 480);
        EXPECT_NEAR(degrees_of_view(720, camera.fx), preset.horizontal, 0.05) << preset.name;
        EXPECT_NEAR(degrees_of_view(480, camera.fy), preset.vertical, 0.05) << preset.name;
        EXPECT_EQ(camera.fx, camera.fy);
        EXPECT_EQ(camera.cx, 360.0);
        EXPECT_EQ(camera.cy, 239.0);
    }
}

TEST(Camera, HorizontalFieldOfViewStaysWhenPixelWidthScales) {
    for (const Preset& preset : presets)
        for (const int width : {320, 1280, 1920, 3840}) {
            const Camera camera =
                camera_from_focal_length(preset.focal_length, preset.pixel_width * 720.0 / width, width, 240);
            EXPECT_NEAR(degrees_of_view(width, camera.fx), preset.horizontal, 0.05) << preset.name << width;
        }
}

TEST(Camera, OddSizesHaveTheirCentreBetweenPixels) {
    const Camera camera = camera_from_focal_length(4.7, 0.0112, 321, 241);
    EXPECT_EQ(camera.cx, 160.5);
    EXPECT_EQ(camera.cy, 119.5);
}

// Eq. 3 as printed: origin in the lower-left corner, y_p upwards, z_p from 0 (far) to 255 (near).
TEST(Camera, AgreesWithThePapersEquation3) {
    for (const Preset& preset : presets)
        for (const auto& [W, H] : {std::pair{720, 480}, std::pair{320, 240}}) {
            const double f = preset.focal_length, sigma = preset.pixel_width, z_near = 40, z_far = 180;
            const Camera camera = camera_from_focal_length(f, sigma, W, H);
            DepthCoding coding;
            coding.near = z_near;
            coding.far = z_far;
            Random random(11);
            for (int k = 0; k < 2000; ++k) {
                const int i = static_cast<int>(random.below(static_cast<std::uint64_t>(W)));
                const int j = static_cast<int>(random.below(static_cast<std::uint64_t>(H)));
                const auto code = static_cast<std::uint16_t>(random.below(256));

                const double x_p = i, y_p = H - 1 - j, z_p = code;  // rows flipped
                const double x = sigma * (x_p - W / 2.0), y = sigma * (y_p - H / 2.0), z = -f;
                const double range = z_near + (z_far - z_near) * (255 - z_p) / 255;
                const double length = std::sqrt(x * x + y * y + z * z);

                const double planar = planar_depth(camera, DepthSemantics::range, i, j, coding.depth(code));
                const glm::dvec3 point = unproject(camera, i, j, planar);
                ASSERT_NEAR(point.x, range * x / length, 1e-13 * range);
                ASSERT_NEAR(point.y, range * y / length, 1e-13 * range);
                ASSERT_NEAR(point.z, range * z / length, 1e-13 * range);
            }
        }
}

TEST(Camera, RightInTheImageIsRightAndDownIsDown) {
    const Camera camera{500, 400, 320, 240};
    const glm::dvec3 centre = unproject(camera, 320, 240, 2);
    EXPECT_EQ(centre, glm::dvec3(0, 0, -2));
    EXPECT_EQ(unproject(camera, 820, 240, 2), glm::dvec3(2, 0, -2));
    EXPECT_EQ(unproject(camera, 320, 640, 2), glm::dvec3(0, -2, -2));
}

// Bound: x - cx, / fx and * d round once each; range adds the length of the ray and a division.
TEST(Camera, UnprojectAgreesWithLongDouble) {
    Random random(12);
    for (int k = 0; k < 100000; ++k) {
        const int width = 1 + static_cast<int>(random.below(4096)),
                  height = 1 + static_cast<int>(random.below(4096));
        const Camera camera = random_camera(random, width, height);
        const double i = random.between(-1, width), j = random.between(-1, height),
                     d = random.between(1e-3, 1e4);
        for (const auto semantics : {DepthSemantics::planar, DepthSemantics::range}) {
            const glm::dvec3 point = unproject(camera, i, j, planar_depth(camera, semantics, i, j, d));
            const LongPoint truth = long_unproject(camera, semantics, i, j, d);
            const double bound = (semantics == DepthSemantics::planar ? 4 : 10) * unit_roundoff;
            ASSERT_LE(std::fabs(point.x - truth.x), bound * std::fabs(truth.x));
            ASSERT_LE(std::fabs(point.y - truth.y), bound * std::fabs(truth.y));
            ASSERT_LE(std::fabs(point.z - truth.z), bound * std::fabs(truth.z));
        }
    }
}

// Bound: five roundings of x - cx on the way there and back, one of the sum with cx.
TEST(Camera, ProjectUndoesUnprojectAtCornersAndBetween) {
    Random random(13);
    for (int k = 0; k < 50000; ++k) {
        const int width = 1 + static_cast<int>(random.below(16384)),
                  height = 1 + static_cast<int>(random.below(16384));
        const Camera camera = random_camera(random, width, height);
        const double right = width - 1, bottom = height - 1;
        const std::pair<double, double> places[] = {{0, 0},
                                                    {right, 0},
                                                    {0, bottom},
                                                    {right, bottom},
                                                    {-1, -1},
                                                    {width, height},
                                                    {camera.cx, camera.cy},
                                                    {random.between(0, width), random.between(0, height)}};
        for (const auto& [i, j] : places)
            for (const auto semantics : {DepthSemantics::planar, DepthSemantics::range}) {
                const double planar = planar_depth(camera, semantics, i, j, random.between(1e-3, 1e4));
                const auto seen = project(camera, unproject(camera, i, j, planar));
                ASSERT_TRUE(seen);
                ASSERT_EQ(seen->planar_depth, planar);
                ASSERT_LE(std::fabs(seen->x - i),
                          unit_roundoff * (6 * std::fabs(i - camera.cx) + std::fabs(i)));
                ASSERT_LE(std::fabs(seen->y - j),
                          unit_roundoff * (6 * std::fabs(j - camera.cy) + std::fabs(j)));
            }
    }
}

TEST(Camera, RangeIsTheDistanceFromTheCamera) {
    Random random(14);
    for (int k = 0; k < 10000; ++k) {
        const Camera camera = random_camera(random, 640, 480);
        const double i = random.between(0, 640), j = random.between(0, 480),
                     range = random.between(0.1, 1000);
        const glm::dvec3 point =
            unproject(camera, i, j, planar_depth(camera, DepthSemantics::range, i, j, range));
        ASSERT_NEAR(std::sqrt(point.x * point.x + point.y * point.y + point.z * point.z), range,
                    1e-14 * range);
    }
}

TEST(Camera, NothingIsSeenBesideOrBehindTheCamera) {
    const Camera camera{500, 500, 320, 240};
    EXPECT_FALSE(project(camera, {0, 0, 0}));
    EXPECT_FALSE(project(camera, {1, 1, 0.5}));
    EXPECT_FALSE(project(camera, {0, 0, std::numeric_limits<double>::quiet_NaN()}));
    EXPECT_TRUE(project(camera, {0, 0, -1e-300}));
}

}  // namespace
}  // namespace touchable
