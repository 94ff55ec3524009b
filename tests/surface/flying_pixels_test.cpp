// Pixels that hang between two surfaces are pulled to one of them; slopes, steps and thin things stay.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "engine/scene/filter_codes.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

constexpr int side = 24;

/// Codes are millimetres; those that differ by 10 or less belong to one surface.
std::vector<std::uint16_t> landed_picture(const std::function<int(int x, int y)>& code) {
    Scene scene = depth_scene(side, side, 12, Marking::range_and_few, {.flying_pixels = {10, 0}});
    std::vector<std::uint16_t> stored;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) stored.push_back(static_cast<std::uint16_t>(code(x, y)));
    const StoredPlane plane = store_plane(side, side, stored, {});
    SurfaceFrame frame;
    EXPECT_TRUE(make_cpu_builder(scene)->build(plane.frame(), frame));
    return {frame.codes.begin(), frame.codes.end()};
}

std::string changes(const std::function<int(int x, int y)>& code) {
    const auto picture = landed_picture(code);
    std::string words;
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const int is = picture[static_cast<std::size_t>(y * side + x)];
            if (is != code(x, y))
                words += std::to_string(x) + "," + std::to_string(y) + ": " + std::to_string(code(x, y)) +
                         " to " + std::to_string(is) + "; ";
        }
    return words;
}

TEST(FlyingPixels, OneOrTwoBetweenTwoSurfacesGoToTheNearerOne) {
    for (const bool down : {false, true})
        for (const int wide : {1, 2})
            for (const auto& codes : {std::pair{1000, 900}, {1099, 900}, {1101, 1300}, {1270, 1300}}) {
                const int flying = codes.first, landed = codes.second;
                const auto picture = landed_picture([&](int x, int y) {
                    const int along = down ? y : x;
                    return along < 12 ? 900 : along < 12 + wide ? flying : 1300;
                });
                for (int k = 0; k < side; ++k)
                    for (int n = 0; n < side; ++n) {
                        const int along = down ? n : k;
                        const int expected = along < 12 ? 900 : along < 12 + wide ? landed : 1300;
                        ASSERT_EQ(picture[static_cast<std::size_t>(n * side + k)], expected)
                            << k << ", " << n;
                    }
            }
}

/// From 900 to 900 + 40 n in n steps, from the pixel `first` on.
int on_a_ramp(int along, int first, int steps) {
    return 900 + 40 * std::clamp(along - first, 0, steps);
}

// Edges of depth that was made larger. Half of the ramp goes to each side, and pixels within twice the gate
// of a side are its.
TEST(FlyingPixels, RampsUpTo12StepsGoToTheirTwoSides) {
    for (const bool down : {false, true})
        for (int steps = 2; steps <= 12; ++steps) {
            const auto picture =
                landed_picture([&](int x, int y) { return on_a_ramp(down ? y : x, 6, steps); });
            for (int k = 0; k < side; ++k)
                for (int n = 0; n < side; ++n) {
                    const int along = down ? n : k;
                    const int expected = 2 * (along - 6) <= steps ? 900 : 900 + 40 * steps;
                    ASSERT_EQ(picture[static_cast<std::size_t>(n * side + k)], expected)
                        << steps << ": " << k << ", " << n;
                }
        }
}

TEST(FlyingPixels, WhatIsNoRampStays) {
    EXPECT_EQ(changes([](int x, int) { return on_a_ramp(x, 5, 13); }), "") << "wider: a real slope";
    EXPECT_EQ(changes([](int x, int) { return 900 + 9 * std::clamp(x - 6, 0, 10); }), "") << "gentle";
    EXPECT_EQ(changes([](int x, int) { return x < 6 || x > 16 ? 900 : 900 + 40 * std::min(x - 5, 17 - x); }),
              "")
        << "a ridge, whose sides end at its edge";
    EXPECT_EQ(changes([](int x, int y) { return (x == 10 || x == 11) && y > 4 ? 900 : 1300; }), "")
        << "a pen two pixels wide";
}

TEST(FlyingPixels, HalfWayTheLowerCodeWins) {
    const auto picture = landed_picture([](int x, int) { return x < 12 ? 900 : x == 12 ? 1000 : 1100; });
    EXPECT_EQ(picture[12], 900);
}

TEST(FlyingPixels, WhatBelongsToASurfaceStays) {
    EXPECT_EQ(changes([](int x, int) { return 600 + 40 * x; }), "") << "a steep slope";
    EXPECT_EQ(changes([](int x, int y) { return 600 + 9 * x + 9 * y; }), "") << "a slope";
    EXPECT_EQ(changes([](int x, int) { return x < 12 ? 900 : 1300; }), "") << "a silhouette";
    EXPECT_EQ(changes([](int x, int) { return x < 12 ? 900 : 920; }), "") << "a small step";
    EXPECT_EQ(changes([](int x, int) { return 600 + 100 * (x / 3); }), "") << "stairs three pixels wide";
    EXPECT_EQ(changes([](int x, int y) { return x >= 10 && x < 15 && y > 4 ? 900 : 1300; }), "") << "a pen";
    EXPECT_EQ(changes([](int x, int y) { return x == 12 && y > 4 ? 900 : 1300; }), "")
        << "a wire in front of a wall";
    EXPECT_EQ(changes([](int x, int y) { return x == 12 && y == 12 ? 900 : 1300; }), "") << "a speck";
}

TEST(FlyingPixels, ANeighbourWithoutDepthLeavesItToOtherLines) {
    // A hole on the line across leaves the two diagonals.
    const auto code = [](int x, int y) {
        if (x == 10 && y == 12) return 0;
        return x < 12 ? 900 : x == 12 ? 1000 : 1300;
    };
    EXPECT_EQ(landed_picture(code)[12 * side + 12], 900);
    EXPECT_EQ(changes([](int x, int) {
                  return x == 11 || x == 13 ? 0 : x < 12 ? 900 : x == 12 ? 1000 : 1300;
              }),
              "");
}

Scene log_scene(double near, double far, double shift, int code_max, bool near_is_high, DepthLength length) {
    Scene scene = depth_scene(96, 64, 16, Marking::none, {.flying_pixels = length});
    DepthCoding& depth = scene.depth;
    depth.kind = DepthCodingKind::log;
    depth.near = near;
    depth.far = far;
    depth.shift = shift;
    depth.code_max = static_cast<std::uint16_t>(code_max);
    depth.near_is_high = near_is_high;
    derive_valid_range(depth);
    return scene;
}

// The gate of docs/conventions.md, step 5, for log codes.
TEST(FlyingPixels, LogGateEqualsThreePointPolynomial) {
    int falling = 0, rising = 0;
    struct Planes {
        double near, far, shift;
    };
    for (const Planes planes : {Planes{0.01, 10, 3.5}, {400, 2800, 0}, {0.5, 1.5, -0.2}})
        for (const int code_max : {300, 4095, 65535})
            for (const DepthLength share : {DepthLength{0.02, 0}, {0, 0.02}, {0.01, 0.01}, {0.2, 0.3}})
                for (const bool near_is_high : {false, true}) {
                    const double near = planes.near, far = planes.far, shift = planes.shift;
                    const double middle = std::sqrt((near + shift) * (far + shift)) - shift;
                    const DepthLength length{share.constant * middle, share.quadratic / middle};
                    const Scene scene = log_scene(near, far, shift, code_max, near_is_high, length);
                    const FlyingPixels filter = *flying_pixels(scene);
                    const double way = std::log((far + shift) / (near + shift));
                    const auto in_codes = [&](double z) {
                        return code_max * (length.constant + length.quadratic * z * z) / ((z + shift) * way);
                    };
                    const double a = in_codes(near), m = in_codes(middle), b = in_codes(far);
                    const double linear = 4 * m - 3 * a - b, quadratic = 2 * (a + b) - 4 * m;
                    ++(linear < 0 ? falling : rising);
                    int scale = 1;
                    while (code_max * scale * 2 <= 65535) scale *= 2;
                    const double unit = 65536.0 / (code_max * scale);
                    const auto rounded = [](double x) {
                        return static_cast<std::int64_t>(std::floor(std::min(x, 21845.0) + 0.5));
                    };
                    const std::int64_t constant = rounded(a), slope = rounded(std::fabs(linear) * unit),
                                       bend = rounded(quadratic * unit * unit);
                    for (int code = 0; code <= code_max; ++code) {
                        const std::int64_t from_near = near_is_high ? code_max - code : code;
                        const std::int64_t n = from_near * scale, part = slope * n / 65536;
                        const std::int64_t rest = constant + bend * (n * n / 65536) / 65536;
                        const std::int64_t gate =
                            linear < 0 ? std::max<std::int64_t>(rest - part, 0) : rest + part;
                        ASSERT_EQ(filter.gate_at(static_cast<std::uint16_t>(code)),
                                  std::clamp<std::int64_t>(gate, 1, 32767))
                            << near << " to " << far << ", largest code " << code_max << ", code " << code;
                    }
                }
    EXPECT_GT(falling, 10);
    EXPECT_GT(rising, 4);
}

// Each row is a ramp from one end of the codes to the other, with steps between the least gate, which is in
// the middle, and those of its ends.
TEST(FlyingPixels, LogRampsLandByEveryBuilder) {
    for (const bool near_is_high : {false, true}) {
        const Scene scene = log_scene(500, 1500, -200, 4095, near_is_high, {26, 7.5e-5});
        const FlyingPixels filter = *flying_pixels(scene);
        const int low = 512, high = 3584, steps = 8;
        ASSERT_GT(std::min(filter.gate_at(low), filter.gate_at(high)), (high - low) / steps);
        ASSERT_LT(filter.gate_at(2048), (high - low) / steps);
        std::vector<std::uint16_t> stored;
        for (int y = 0; y < scene.height; ++y)
            for (int x = 0; x < scene.width; ++x)
                stored.push_back(static_cast<std::uint16_t>(
                    low + (high - low) * std::clamp(x % 48 - 12, 0, steps) / steps));
        const StoredPlane plane = store_plane(scene.width, scene.height, stored, {});
        SurfaceFrame expected, frame;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), expected));
        EXPECT_FALSE(std::equal(stored.begin(), stored.end(), expected.codes.begin()));
        for (const VectorUnit unit : usable_vector_units()) {
            ASSERT_TRUE(make_cpu_builder(scene, {1, unit})->build(plane.frame(), frame));
            EXPECT_EQ(first_difference(expected, frame), "") << "vectors " << static_cast<int>(unit);
        }
    }
}

}  // namespace
}  // namespace touchable::test
