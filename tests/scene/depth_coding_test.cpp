// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "engine/scene/scene.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

DepthCoding between_planes(DepthCodingKind kind, double near, double far, std::uint16_t code_max,
                           bool near_is_high) {
    DepthCoding coding;
    coding.kind = kind;
    coding.near = near;
    coding.far = far;
    coding.code_max = code_max;
    coding.near_is_high = near_is_high;
    derive_valid_range(coding);
    return coding;
}

DepthCoding metric(double scale, double near, double far, std::uint16_t code_max = 65535) {
    DepthCoding coding;
    coding.kind = DepthCodingKind::metric;
    coding.scale = scale;
    coding.near = near;
    coding.far = far;
    coding.code_max = code_max;
    derive_valid_range(coding);
    return coding;
}

/// The header's formulas, in long double.
long double long_depth(const DepthCoding& coding, std::uint16_t code) {
    const auto near = static_cast<long double>(coding.near), far = static_cast<long double>(coding.far);
    if (coding.kind == DepthCodingKind::metric) return static_cast<long double>(coding.scale) * code;
    const long double n = coding.near_is_high ? code : coding.code_max - code;
    if (coding.kind == DepthCodingKind::log) {
        const auto shift = static_cast<long double>(coding.shift);
        const long double low = std::log(near + shift), high = std::log(far + shift);
        return std::exp(high + (low - high) * n / coding.code_max) - shift;
    }
    if (coding.kind == DepthCodingKind::linear) return far + (near - far) * n / coding.code_max;
    return 1 / (1 / far + (1 / near - 1 / far) * n / coding.code_max);
}

DepthCoding random_coding(Random& random) {
    const double near = random.between(0.01, 50), far = near + random.between(0.01, 200);
    const auto code_max = static_cast<std::uint16_t>(1 + random.below(random.below(2) ? 255 : 4095));
    DepthCoding coding;
    switch (random.below(4)) {
        case 0:
            coding = between_planes(DepthCodingKind::log, near, far, code_max, random.below(2));
            coding.shift = random.between(-0.9 * near, 4 * near);
            derive_valid_range(coding);
            break;
        case 3:
            coding = between_planes(DepthCodingKind::linear, near, far, code_max, random.below(2));
            break;
        case 1:
            coding = between_planes(DepthCodingKind::inverse, near, far, code_max, random.below(2));
            break;
        default:
            coding = metric(random.between(0.01, 0.5), random.below(2) ? near : 0.0, far, code_max);
    }
    coding.invalid_code_count = random.below(DepthCoding::max_invalid_codes + 1);
    const int first = random.below(coding.code_max + 1);  // neighbours, the hardest case, or anywhere
    const bool together = random.below(2);
    for (int k = 0; k < coding.invalid_code_count; ++k)
        coding.invalid_codes[static_cast<std::size_t>(k)] =
            static_cast<std::uint16_t>(together ? first + k : random.below(coding.code_max + 1));
    if (random.below(2)) derive_valid_range(coding);
    return coding;
}

std::vector<std::uint16_t> valid_codes(const DepthCoding& coding) {
    std::vector<std::uint16_t> codes;
    for (int code = 0; code <= 65535; ++code)
        if (coding.is_valid(static_cast<std::uint16_t>(code)))
            codes.push_back(static_cast<std::uint16_t>(code));
    return codes;
}

TEST(DepthCoding, ReachesBothPlanesExactly) {
    Random random(21);
    for (int k = 0; k < 20000; ++k) {
        const double near = random.between(0.01, 50), far = near + random.between(1e-3, 200);
        const auto code_max = static_cast<std::uint16_t>(1 + random.below(65535));
        for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse, DepthCodingKind::log}) {
            const DepthCoding high = between_planes(kind, near, far, code_max, true);
            ASSERT_EQ(high.depth(code_max), near);
            ASSERT_EQ(high.depth(0), far);
            const DepthCoding low = between_planes(kind, near, far, code_max, false);
            ASSERT_EQ(low.depth(code_max), far);
            ASSERT_EQ(low.depth(0), near);
        }
    }
}

TEST(DepthCoding, AgreesWithLongDoubles) {
    Random random(22);
    for (int k = 0; k < 100; ++k) {
        const DepthCoding coding = random_coding(random);
        for (const std::uint16_t code : valid_codes(coding)) {
            const long double truth = long_depth(coding, code);
            const double largest = coding.far + std::fabs(coding.shift);
            ASSERT_NEAR(coding.depth(code), static_cast<double>(truth), 16 * 0x1p-53 * largest) << code;
        }
    }
}

TEST(DepthCoding, IsStrictlyMonotone) {
    for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse, DepthCodingKind::log})
        for (const bool near_is_high : {true, false}) {
            const DepthCoding coding = between_planes(kind, 0.1, 100, 65535, near_is_high);
            EXPECT_EQ(coding.deeper_is_higher(), !near_is_high);
            for (int code = 1; code <= 65535; ++code) {
                const double before = coding.depth(static_cast<std::uint16_t>(code - 1));
                const double here = coding.depth(static_cast<std::uint16_t>(code));
                ASSERT_EQ(here > before, !near_is_high) << code;
                ASSERT_NE(here, before) << code;
                ASSERT_GE(here, coding.near);
                ASSERT_LE(here, coding.far);
            }
        }
    EXPECT_TRUE(metric(0.001, 0, 10).deeper_is_higher());
}

/// Numbers of the formula in lerobot's depth_utils.py, worked out by numpy; the code of a depth comes back.
TEST(DepthCoding, MatchesLeRobotsLog) {
    DepthCoding coding = between_planes(DepthCodingKind::log, 0.01, 10, 4095, false);
    coding.shift = 3.5;
    coding.invalid_codes[0] = 0;
    coding.invalid_code_count = 1;
    derive_valid_range(coding);
    EXPECT_EQ(coding.valid_min, 1);
    const std::pair<int, double> known[] = {{200, 0.249},  {500, 0.638},  {1000, 1.377},
                                            {1677, 2.594}, {2500, 4.489}, {3794, 8.727}};
    for (const auto& [code, depth] : known) {
        EXPECT_NEAR(coding.depth(static_cast<std::uint16_t>(code)), depth, 0.0006);
        EXPECT_EQ(coding.code(coding.depth(static_cast<std::uint16_t>(code))), code);
    }
    const double step = std::log(13.5 / 3.51) / 4095;
    for (int code = 1; code < 4095; ++code)
        ASSERT_NEAR(coding.depth(static_cast<std::uint16_t>(code)), 3.51 * std::exp(step * code) - 3.5,
                    1e-14);
}

TEST(DepthCoding, AcceptsExactlyFittingCodes) {
    Random random(23);
    for (int k = 0; k < 300; ++k) {
        DepthCoding coding = random_coding(random);
        coding.invalid_code_count = 0;
        derive_valid_range(coding);
        for (int c = 0; c <= 65535; ++c) {
            const auto code = static_cast<std::uint16_t>(c);
            const bool fits = code <= coding.code_max && coding.depth(code) > 0 &&
                              coding.depth(code) >= coding.near && coding.depth(code) <= coding.far;
            ASSERT_EQ(coding.is_valid(code), fits) << code;
        }
    }
}

TEST(DepthCoding, AcceptsNothingIfNothingFits) {
    const DepthCoding coding = metric(1.0, 2.25, 2.75);
    EXPECT_TRUE(valid_codes(coding).empty());
}

TEST(DepthCoding, RejectsMarkedCodes) {
    DepthCoding coding = between_planes(DepthCodingKind::linear, 40, 180, 255, true);
    coding.invalid_codes = {0, 255, 17, 0};
    coding.invalid_code_count = 3;
    EXPECT_EQ(valid_codes(coding).size(), 253u);
    EXPECT_FALSE(coding.is_valid(17));
}

TEST(DepthCoding, AcceptsRangesOfValidCodes) {
    DepthCoding coding = between_planes(DepthCodingKind::linear, 40, 180, 255, true);
    coding.invalid_codes = {0, 255, 17, 0};
    coding.invalid_code_count = 3;
    derive_valid_range(coding);
    for (int first = 0; first <= 260; ++first) {
        bool all = true;
        for (int last = first; last <= 260; ++last) {
            all = all && coding.is_valid(static_cast<std::uint16_t>(last));
            ASSERT_EQ(coding.all_valid(static_cast<std::uint16_t>(first), static_cast<std::uint16_t>(last)),
                      all)
                << first << " to " << last;
        }
    }
}

TEST(DepthCoding, TrimsRangeToValidCodes) {
    Random random(25);
    int trimmed = 0, nothing_left = 0;
    for (int k = 0; k < 2000; ++k) {
        DepthCoding coding = random_coding(random);
        coding.invalid_codes = {0, coding.code_max, 1, static_cast<std::uint16_t>(coding.code_max - 1)};
        coding.invalid_code_count = random.below(5);
        derive_valid_range(coding);
        std::vector<std::uint16_t> fitting;
        for (int c = 0; c <= coding.code_max; ++c) {
            const auto code = static_cast<std::uint16_t>(c);
            const auto last = coding.invalid_codes.begin() + coding.invalid_code_count;
            if (coding.depth(code) > 0 && coding.depth(code) >= coding.near &&
                coding.depth(code) <= coding.far &&
                std::find(coding.invalid_codes.begin(), last, code) == last)
                fitting.push_back(code);
        }
        if (fitting.empty()) {
            ++nothing_left;
            EXPECT_GT(coding.valid_min, coding.valid_max);
            continue;
        }
        ASSERT_EQ(coding.valid_min, fitting.front());
        ASSERT_EQ(coding.valid_max, fitting.back());
        double nearest = HUGE_VAL;
        for (const std::uint16_t code : fitting) nearest = std::min(nearest, coding.depth(code));
        ASSERT_EQ(coding.nearest_depth(), nearest);
        trimmed += coding.invalid_code_count > 0 && coding.valid_min > 0;
    }
    EXPECT_GT(trimmed, 500);
    EXPECT_GT(nothing_left, 0);
}

TEST(DepthCoding, InvertsEveryValidCode) {
    std::vector<DepthCoding> codings = {metric(0.001, 0, 65.535), metric(1.0 / 5000, 0.3, 12)};
    for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse, DepthCodingKind::log})
        for (const std::uint16_t code_max : {std::uint16_t{255}, std::uint16_t{1023}, std::uint16_t{65535}})
            for (const bool near_is_high : {true, false})
                codings.push_back(between_planes(kind, 0.3, 12, code_max, near_is_high));
    for (const DepthCoding& coding : codings)
        for (const std::uint16_t code : valid_codes(coding)) ASSERT_EQ(coding.code(coding.depth(code)), code);
}

TEST(DepthCoding, EncodesToNearestValidCode) {
    Random random(24);
    for (int k = 0; k < 400; ++k) {
        const DepthCoding coding = random_coding(random);
        const std::vector<std::uint16_t> codes = valid_codes(coding);
        if (codes.empty()) continue;
        for (int n = 0; n < 20; ++n) {
            const double depth =
                random.below(4) ? random.between(coding.near, coding.far) : random.between(-10, 400);
            std::uint16_t nearest = codes.front();
            for (const std::uint16_t code : codes)
                if (std::fabs(coding.depth(code) - depth) < std::fabs(coding.depth(nearest) - depth))
                    nearest = code;
            ASSERT_EQ(coding.code(depth), nearest) << depth;
        }
    }
}

TEST(DepthCoding, BreaksTiesDownwards) {
    const DepthCoding falling = between_planes(DepthCodingKind::linear, 1, 5, 4, true);
    EXPECT_EQ(falling.code(2.5), 2);  // codes 2 and 3 stand for 3 and 2
    const DepthCoding rising = between_planes(DepthCodingKind::linear, 1, 5, 4, false);
    EXPECT_EQ(rising.code(2.5), 1);
    EXPECT_EQ(metric(1, 0, 9).code(2.5), 2);
}

TEST(DepthCoding, EncodesAnythingValidly) {
    for (const DepthCoding& coding :
         {between_planes(DepthCodingKind::inverse, 0.3, 12, 255, true), metric(0.001, 0, 9)})
        for (const double depth : {-1.0, 0.0, 1e-300, 1e300, HUGE_VAL, -HUGE_VAL, std::nan("")})
            EXPECT_TRUE(coding.is_valid(coding.code(depth))) << depth;
}

TEST(DepthCoding, HasLevelsOf255thOfRange) {
    for (const std::uint16_t code_max : {std::uint16_t{255}, std::uint16_t{1023}, std::uint16_t{65535}})
        EXPECT_DOUBLE_EQ(between_planes(DepthCodingKind::linear, 40, 180, code_max, true).level(),
                         140.0 / 255);
}

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

TEST(Camera, HasPublishedFieldsOfView) {
    for (const Preset& preset : presets) {
        const Camera camera = camera_from_focal_length(preset.focal_length, preset.pixel_width, 720, 480);
        EXPECT_NEAR(degrees_of_view(720, camera.fx), preset.horizontal, 0.05) << preset.name;
        EXPECT_NEAR(degrees_of_view(480, camera.fy), preset.vertical, 0.05) << preset.name;
        EXPECT_EQ(camera.fx, camera.fy);
        EXPECT_EQ(camera.cx, 360.0);
        EXPECT_EQ(camera.cy, 239.0);
    }
}

TEST(Camera, KeepsFieldOfView) {
    for (const Preset& preset : presets)
        for (const int width : {320, 1280, 1920, 3840}) {
            const Camera camera =
                camera_from_focal_length(preset.focal_length, preset.pixel_width * 720.0 / width, width, 240);
            EXPECT_NEAR(degrees_of_view(width, camera.fx), preset.horizontal, 0.05) << preset.name << width;
        }
}

TEST(Camera, CentresOddSizesBetweenPixels) {
    const Camera camera = camera_from_focal_length(4.7, 0.0112, 321, 241);
    EXPECT_EQ(camera.cx, 160.5);
    EXPECT_EQ(camera.cy, 119.5);
}

// Eq. 3 as printed: origin in the lower-left corner, y_p upwards, z_p from 0 (far) to 255 (near).
TEST(Camera, MatchesEquation3) {
    for (const Preset& preset : presets)
        for (const auto& [W, H] : {std::pair{720, 480}, std::pair{320, 240}}) {
            const double f = preset.focal_length, sigma = preset.pixel_width, z_near = 40, z_far = 180;
            const Camera camera = camera_from_focal_length(f, sigma, W, H);
            DepthCoding coding;
            coding.near = z_near;
            coding.far = z_far;
            Random random(11);
            for (int k = 0; k < 2000; ++k) {
                const int i = random.below(W);
                const int j = random.below(H);
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

TEST(Camera, MapsImageRightAndDown) {
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
        const int width = 1 + random.below(4096), height = 1 + random.below(4096);
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
TEST(Camera, ProjectsWhatItUnprojected) {
    Random random(13);
    for (int k = 0; k < 50000; ++k) {
        const int width = 1 + random.below(16384), height = 1 + random.below(16384);
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

TEST(Camera, SeesNothingBehindIt) {
    const Camera camera{500, 500, 320, 240};
    EXPECT_FALSE(project(camera, {0, 0, 0}));
    EXPECT_FALSE(project(camera, {1, 1, 0.5}));
    EXPECT_FALSE(project(camera, {0, 0, std::numeric_limits<double>::quiet_NaN()}));
    EXPECT_TRUE(project(camera, {0, 0, -1e-300}));
}

constexpr std::int64_t ms = 1'000'000;

TEST(FrameRate, ExtendsOwnTimesByMean) {
    const auto rate = rate_of_own_times({50 * ms, 60 * ms, 100 * ms, 150 * ms});
    ASSERT_TRUE(rate);
    EXPECT_EQ(rate->per_second(), 30);
    EXPECT_EQ(rate->num, 30);
    EXPECT_EQ(rate->den, 1);
    EXPECT_EQ(*rate->own_times, (std::vector<std::int64_t>{0, 10 * ms, 50 * ms, 100 * ms}));
    EXPECT_EQ(rate->time_ns(3), 100 * ms);
    EXPECT_EQ(rate->time_ns(4), 133'333'333);
    EXPECT_EQ(rate->time_ns(6), 200 * ms);
    EXPECT_EQ(rate->time_ns(-3), -100 * ms);
}

/// Against a search through all frames.
TEST(FrameRate, FindsFramesByTime) {
    Random random(16);
    std::vector<std::int64_t> times_ns{0};
    for (int n = 1; n < 40; ++n)
        times_ns.push_back(times_ns.back() + ms + static_cast<std::int64_t>(random.below(90)) * ms / 3);
    for (const FrameRate& rate : {FrameRate{30000, 1001}, *rate_of_own_times(times_ns)})
        for (std::int64_t time_ns = -100 * ms; time_ns < times_ns.back() + 200 * ms; time_ns += ms / 3 + 1) {
            std::int64_t at = -10, nearest = -10;
            for (std::int64_t n = -10; n < 200; ++n) {
                if (rate.time_ns(n) <= time_ns) at = n;
                if (std::abs(rate.time_ns(n) - time_ns) < std::abs(rate.time_ns(nearest) - time_ns))
                    nearest = n;
            }
            ASSERT_EQ(rate.frame_at(time_ns), at) << time_ns;
            ASSERT_EQ(rate.nearest(time_ns), nearest) << time_ns;
        }
    for (std::int64_t n = -5; n < 100; ++n) {
        const auto own = *rate_of_own_times(times_ns);
        ASSERT_EQ(own.frame_at(own.time_ns(n)), n);
        ASSERT_EQ(own.frame_at(own.time_ns(n) - 1), n - 1);
    }
}

TEST(FrameRate, RejectsImpossibleTimes) {
    EXPECT_FALSE(rate_of_own_times({}));
    EXPECT_FALSE(rate_of_own_times({5}));
    EXPECT_FALSE(rate_of_own_times({0, ms - 1}));
    EXPECT_FALSE(rate_of_own_times({0, 5 * ms, 4 * ms}));
    EXPECT_FALSE(rate_of_own_times({-4'000'000'000'000'000'000, 4'000'000'000'000'000'000}));
    EXPECT_TRUE(rate_of_own_times({-9'000'000'000'000'000'000, -9'000'000'000'000'000'000 + ms}));
}

}  // namespace
}  // namespace touchable::test
