// SPDX-License-Identifier: Apache-2.0
// The camera behind depths, recognised by the codes that occur.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/estimators.hpp"
#include "tests/must.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

constexpr int wide = 320, high = 240;

Scene millimetres(double far = 6000) {
    return metric_scene(wide, high, {262, 262, 159.5, 119.5}, far);
}

/// Measures one picture.
MeasuredDepth measured_of(const Scene& scene, const std::vector<std::uint16_t>& codes) {
    DepthEstimator estimator(scene);
    estimator.add(store_plane(scene.width, scene.height, codes, {}).frame());
    return estimator.measured().value();
}

/// A ground that rises to a hill, 1.5 to 2.7 m away, some noise, and holes; `store`: a code of a depth in mm.
template <class Store>
DepthLength levels_of(Store store) {
    SplitMix64 random(7);
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < high; ++y)
        for (int x = 0; x < wide; ++x) {
            const double hill = std::hypot(x - 200.0, y - 90.0) / 60;
            const double noise = static_cast<double>(random.next() >> 40) * 0x1p-24 - 0.5;
            const double depth = 1500 + 3 * x + y - 300 * std::exp(-hill * hill) + 2 * noise;
            codes.push_back(random.next() % 50 == 0 ? 0 : store(depth));
        }
    return measured_of(millimetres(), codes).levels;
}

std::uint16_t rounded(double depth) {
    return static_cast<std::uint16_t>(depth + 0.5);
}

TEST(DepthEstimator, FindsDisparityLevelsInMillimetres) {
    for (const double q : {1.5e-6, 2.85e-6, 6e-6}) {
        // Depth of a disparity that is a whole number of steps: 1 / z = k q.
        const DepthLength levels =
            levels_of([&](double depth) { return rounded(1 / (q * std::floor(1 / (q * depth)))); });
        EXPECT_NEAR(levels.quadratic, q, 0.05 * q);
        EXPECT_EQ(levels.constant, 0);
    }
}

TEST(DepthEstimator, FindsEvenLevels) {
    for (const int step : {4, 10, 25}) {
        const DepthLength levels = levels_of(
            [&](double depth) { return static_cast<std::uint16_t>(step * std::floor(depth / step)); });
        EXPECT_EQ(levels, (DepthLength{static_cast<double>(step), 0})) << step;
    }
}

TEST(DepthEstimator, FindsNoLevelsIfDense) {
    EXPECT_EQ(levels_of(rounded), DepthLength{});
}

TEST(DepthEstimator, FindsNoIrregularLevels) {
    SplitMix64 random(3);
    std::vector<std::uint16_t> of_depth;
    for (int depth = 0, level = 1; depth < 8000; ++depth) {
        if (random.next() % 12 == 0) level = depth;
        of_depth.push_back(static_cast<std::uint16_t>(level));
    }
    const DepthLength levels =
        levels_of([&](double depth) { return of_depth[static_cast<std::size_t>(depth)]; });
    // A mean of 12 is the best that may be said of them.
    EXPECT_TRUE(levels == DepthLength{} || (levels.quadratic == 0 && levels.constant < 25));
}

// Codes of each column, of which no two are neighbours; but no terraces.
TEST(DepthEstimator, TakesSlopeForNoStaircase) {
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < high; ++y)
        for (int x = 0; x < wide; ++x) codes.push_back(rounded(1 / (1e-3 - 2.5e-6 * x)));
    EXPECT_EQ(measured_of(millimetres(), codes).levels, DepthLength{});
}

TEST(DepthEstimator, CountsLargestCode) {
    const std::vector<std::uint16_t> codes(wide * high, 65535);
    EXPECT_EQ(measured_of(millimetres(65535), codes).median, 65535);
}

TEST(DepthEstimator, MeasuresNothingWithoutFrames) {
    EXPECT_FALSE(DepthEstimator(millimetres()).measured());
}

/// Measures a clip's frames: all, or as many as are enough.
std::optional<MeasuredDepth> measured_clip(ClipReader& clip, bool all = false) {
    DepthEstimator estimator(clip.scene());
    while (all || !estimator.enough()) {
        const auto frame = must(clip.next());
        if (!frame) break;
        estimator.add(*frame);
    }
    return estimator.measured();
}

const auto scene_files = std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes";

/// Views from different places, by structured light.
MeasuredDepth measured_redwood(const std::filesystem::path& folder, const std::filesystem::path& scene_file) {
    auto clip = must(open_clip(folder, scene_file));
    const auto measured = measured_clip(*clip, true);
    EXPECT_TRUE(measured);
    EXPECT_EQ(measured->noise, DepthLength{}) << "views from different places are no noise";
    EXPECT_TRUE(measured->from_a_camera());
    return *measured;
}

TEST(DepthEstimator, RecognisesGeneratedStructuredLight) {
    const TemporaryFolder folder;
    const StandIn what = stand_in("redwood5");
    const auto measured = measured_redwood(folder.path(), write_stand_in(folder.path(), what));
    EXPECT_NEAR(measured.levels.quadratic, what.level_per_mm, 0.05 * what.level_per_mm);
}

TEST(DepthEstimator, RecognisesRealStructuredLight) {
    TOUCHABLE_NEEDS_DATA(real_data("stills/redwood5"));
    const auto measured = measured_redwood(real_data("stills/redwood5"), scene_files / "redwood5.json");
    EXPECT_NEAR(measured.levels.quadratic * 2000 * 2000, 14.2, 0.3) << "mm at 2 m";
    EXPECT_NEAR(measured.median, 1861, 1);
}

// How wide and how high terraces are, worked out by hand, and what is chosen by it.

using CodeAt = std::function<int(int x, int y)>;

Contours contours_of(int width, int height, const CodeAt& code) {
    CodePicture picture{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) picture.codes.push_back(code(x, y));
    ContourEstimator estimator;
    estimator.add(picture);
    return estimator.contours();
}

// Columns are of one code, so without steps. Rows: eight treads, of which six have steps at both ends.
TEST(Contours, MatchStairs) {
    for (const int tread : {8, 20, 50, 90})
        for (const int step : {1, 4}) {
            const Contours found =
                contours_of(8 * tread, 16, [&](int x, int) { return 100 + step * (x / tread); });
            EXPECT_EQ(found, (Contours{tread, step}));
        }
}

TEST(Contours, SpanShortRamps) {
    // 100, ..., 100, 101, 102, 103, 104, ..., 104: three pixels of ramp before each tread of 57.
    const Contours found = contours_of(600, 8, [](int x, int) {
        const int n = x % 60;
        return 100 + 4 * (x / 60) + (n < 57 ? 0 : n - 56);
    });
    EXPECT_EQ(found.height, 4);
    EXPECT_EQ(found.width, 57);
}

TEST(Contours, IgnoreFlatsBetweenSilhouettes) {
    // A stair of 12 pixels between two walls of 200.
    const Contours found = contours_of(520, 8, [](int x, int) {
        return x < 200 ? 20 : x >= 320 ? 220 : 100 + (x - 200) / 12;
    });
    EXPECT_EQ(found, (Contours{12, 1}));
    EXPECT_EQ(contours_of(300, 40, [](int, int) { return 7; }), Contours{});
}

TEST(Contours, IgnoreFewFlatThings) {
    const auto halves = [](int x, int) { return x < 200 ? 100 : 140; };
    const auto card = [](int x, int y) { return x > 129 && x < 270 && y > 79 && y < 220 ? 140 : 100; };
    const auto one_behind_the_other = [](int x, int) { return 100 + 30 * (x / 160); };  // 100, 130, 160
    for (const CodeAt& things : {CodeAt(halves), CodeAt(card), CodeAt(one_behind_the_other)}) {
        const Contours found = contours_of(400, 300, things);
        EXPECT_EQ(found.width, 0);
        EXPECT_EQ(found.reach(), 16);
    }
}

TEST(Contours, IgnoreHoles) {
    const auto holed = [](int x, int) { return x % 50 == 0 ? CodePicture::invalid : 100 + x / 50; };
    EXPECT_EQ(contours_of(400, 8, holed), Contours{});
}

TEST(Contours, HaveNoWidthWithoutTreads) {
    const Contours found = contours_of(400, 40, [](int x, int y) { return 100 + x / 3 + y / 5; });
    EXPECT_FALSE(found.are_wide());
    EXPECT_EQ(found.reach(), 16);
}

TEST(Contours, ChooseReachByWidth) {
    for (const auto& [width, reach] :
         {std::pair{0, 16}, {32, 16}, {33, 64}, {64, 64}, {65, 128}, {128, 128}, {999, 128}}) {
        EXPECT_EQ((Contours{width, 1}).are_wide(), reach > 16) << width;
        EXPECT_EQ((Contours{width, 1}).reach(), reach) << width;
    }
}

/// A slope of so many pixels a level, of `step` codes, in depth that a phone stores.
struct Phone {
    Scene scene;
    StoredPlane plane;
};
Phone phone(double pixels, int step) {
    Phone made{depth_scene(480, 320, 8, Marking::none), {}};
    made.scene.depth.kind = DepthCodingKind::inverse;
    made.scene.depth.near = 500;
    made.scene.depth.far = 4000;
    derive_valid_range(made.scene.depth);
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < 320; ++y)
        for (int x = 0; x < 480; ++x)
            codes.push_back(static_cast<std::uint16_t>(80 + step * std::lround((x + 0.7 * y) / pixels)));
    made.plane = store_plane(480, 320, codes, {.bytes_per_sample = 1});
    return made;
}

FilterSettings chosen_for(const Phone& of, UnstatedFilters unstated = all_unstated,
                          FilterSettings stated = {}) {
    DepthEstimator estimator(of.scene);
    estimator.add(of.plane.frame());
    Scene scene = of.scene;
    scene.filter = stated;
    choose_filters(estimator.measured(), unstated, scene);
    return scene.filter;
}

TEST(ChosenReach, FollowsTerraceWidth) {
    EXPECT_EQ(chosen_for(phone(90, 1)).terrace_reach, 128);
    EXPECT_EQ(chosen_for(phone(44, 1)).terrace_reach, 64);
    EXPECT_EQ(chosen_for(phone(90, 1)).levels, DepthLength{});
    EXPECT_EQ(chosen_for(phone(9, 1)).terrace_reach, 16);
    EXPECT_EQ(chosen_for(phone(90, 1)).terraces, TerraceRemoval::on);
}

TEST(ChosenReach, RespectsStatedRemoval) {
    UnstatedFilters unstated;
    const FilterSettings on{.terraces = TerraceRemoval::on};
    EXPECT_EQ(chosen_for(phone(90, 1), unstated, on), on);
    unstated.terrace_reach = true;
    EXPECT_EQ(chosen_for(phone(90, 1), unstated, on).terrace_reach, 128);
    const FilterSettings automatic{.terraces = TerraceRemoval::automatic};
    EXPECT_EQ(chosen_for(phone(90, 1), unstated, automatic).terrace_reach, 128);
    EXPECT_EQ(chosen_for(phone(90, 1), {}, automatic).terrace_reach, 16) << "stated";
    const FilterSettings said{.terraces = TerraceRemoval::automatic, .terrace_reach = 32};
    EXPECT_EQ(chosen_for(phone(90, 1), {}, said).terrace_reach, 32);
    EXPECT_EQ(chosen_for(phone(90, 1), {}, {}), FilterSettings{}) << "off";
}

FilterSettings chosen_of_recording(const std::filesystem::path& file,
                                   const std::filesystem::path& scene_file = {}) {
    auto clip = must(scene_file.empty() ? open_clip(file) : open_clip(file, scene_file));
    Scene scene = clip->scene();
    choose_filters(measured_clip(*clip), all_unstated, scene);
    return scene.filter;
}

class PhonePictures : public testing::TestWithParam<const char*> {};

TEST_P(PhonePictures, HaveWideFourCodeTerraces) {
    const auto file = real_data(GetParam());
    TOUCHABLE_NEEDS_DATA(file);
    const FilterSettings filter = chosen_of_recording(file);
    EXPECT_EQ(filter.terraces, TerraceRemoval::on);
    EXPECT_EQ(filter.terrace_reach, 128);
    Scene scene = (*open_clip(file))->scene();
    EXPECT_EQ(filter.levels, code_step(scene.depth).times(4));
}
INSTANTIATE_TEST_SUITE_P(LensBlur, PhonePictures,
                         testing::Values("stills/lensblur/greek-helmet.jpg",
                                         "stills/lensblur/yamasa-maneki-neko.jpg"),
                         [](const auto& test) { return test.index == 0 ? "Helmet" : "Neko"; });

class OtherRecordings : public testing::TestWithParam<const char*> {};

TEST_P(OtherRecordings, KeepDefaultReach) {
    const auto file = real_data(GetParam());
    TOUCHABLE_NEEDS_DATA(file);
    EXPECT_EQ(chosen_of_recording(file).terrace_reach, 16);
}
INSTANTIATE_TEST_SUITE_P(Recordings, OtherRecordings,
                         testing::Values("stills/redwood5", "stills/icl_nuim5", "stills/midas_moon/moon.png",
                                         "castel_sr300", "visp_cube_realsense", "depthkit_typing/Test.mov"),
                         [](const auto& test) { return "Number" + std::to_string(test.index); });

// Noise and holes measured in the first frames of a clip, and the filters that they call for.

constexpr int estimate_width = 160, estimate_height = 120;

/// Millimetres; 0 is no depth.
Scene camera_scene() {
    return metric_scene(estimate_width, estimate_height, {131, 131, 79.5, 59.5}, 8000);
}

FilterSettings chosen_by(const std::optional<MeasuredDepth>& measured) {
    Scene scene = camera_scene();
    choose_filters(measured, all_unstated, scene);
    EXPECT_TRUE(validate(scene));
    return scene.filter;
}

double noise(SplitMix64& random) {
    return normal([&] { return random.unit(); });
}

/// Depth of a pixel in a frame, mm; below 0.5 it is none.
using Depth = std::function<double(int x, int y, int frame, SplitMix64& random)>;

std::optional<MeasuredDepth> measured_of(const Depth& depth, int frames = 16) {
    DepthEstimator estimator(camera_scene());
    SplitMix64 random(11);
    for (int n = 0; n < frames; ++n) {
        std::vector<std::uint16_t> codes;
        for (int y = 0; y < estimate_height; ++y)
            for (int x = 0; x < estimate_width; ++x)
                codes.push_back(static_cast<std::uint16_t>(depth(x, y, n, random) + 0.5));
        estimator.add(store_plane(estimate_width, estimate_height, codes, {}).frame());
    }
    return estimator.measured();
}

double slope(int x, int y) {
    return 800 + 10 * x + 2 * y;
}

// As infrared and depth in one folder: four frames tell.
TEST(DepthEstimator, FindsKindsThatAlternate) {
    const auto factor = [](int kinds, int frames) {
        const auto depth = [kinds](int x, int y, int n, SplitMix64&) {
            return (1 + n % kinds) * slope(x, y);
        };
        return measured_of(depth, frames)->alternates_by;
    };
    EXPECT_NEAR(factor(2, 4), 2, 0.01);
    EXPECT_EQ(factor(2, 3), 1);
    EXPECT_EQ(factor(1, 4), 1);
}

TEST(NoiseEstimator, FindsConstantNoise) {
    for (const double sigma : {1.5, 4.0, 12.0}) {
        const auto measured = measured_of(
            [&](int x, int y, int, SplitMix64& random) { return slope(x, y) + sigma * noise(random); });
        EXPECT_NEAR(measured->noise_at_median(), sigma, 0.1 * sigma);
        EXPECT_NEAR(measured->roughness, sigma, 0.15 * sigma);
        EXPECT_TRUE(measured->from_a_camera());
    }
}

TEST(NoiseEstimator, FindsNoiseGrowingWithDepth) {
    const auto measured = measured_of([](int x, int y, int, SplitMix64& random) {
        const double z = slope(x, y);
        return z + (1 + 3e-6 * z * z) * noise(random);
    });
    for (const double z : {1000.0, 1600.0, 2200.0}) {
        const double found = measured->noise.constant + measured->noise.quadratic * z * z;
        EXPECT_NEAR(found, 1 + 3e-6 * z * z, 0.12 * (1 + 3e-6 * z * z)) << z;
    }
}

TEST(NoiseEstimator, SeparatesNoiseFromMotion) {
    const auto moving = [](double speed, double sigma) {
        return measured_of([=](int x, int y, int n, SplitMix64& random) {
            return slope(x, y) - speed * n + sigma * noise(random);
        });
    };
    EXPECT_NEAR(moving(1, 3)->noise_at_median(), 3, 0.5);
    for (const double speed : {0.0, 0.3, 1.0, 7.5, 40.0}) {
        EXPECT_EQ(moving(speed, 0)->noise, DepthLength{}) << speed;
        EXPECT_FALSE(moving(speed, 0)->from_a_camera()) << speed;
    }
}

// A ball that passes is no noise of the wall behind it, and the wall's noise is seen in spite of it.
TEST(NoiseEstimator, IgnoresPassingThings) {
    const auto scene = [](double sigma) {
        return measured_of([=](int x, int y, int n, SplitMix64& random) {
            const double dx = x - 8.0 * n, dy = y - 60.0;
            const bool ball = dx * dx + dy * dy < 30 * 30;
            return (ball ? 900 : slope(x, y)) + sigma * noise(random);
        });
    };
    EXPECT_EQ(scene(0)->noise, DepthLength{});
    EXPECT_NEAR(scene(4)->noise_at_median(), 4, 0.6);
}

TEST(NoiseEstimator, NeedsThreeFrames) {
    const Depth noisy = [](int x, int y, int, SplitMix64& random) { return slope(x, y) + 5 * noise(random); };
    EXPECT_EQ(measured_of(noisy, 1)->noise, DepthLength{});
    EXPECT_EQ(measured_of(noisy, 2)->noise, DepthLength{});
}

/// Hills of 40 mm and less, others for each number.
double hills(double x, int y, int number) {
    const double a = 0.031 * (number % 5 + 1), b = 0.023 * (number * 3 % 5 + 1);
    return 1500 + 25 * std::sin(a * x + number) + 15 * std::cos(b * y + 0.02 * x + 2 * number);
}

// They go up and down like noise of some 25 mm.
TEST(NoiseEstimator, IgnoresUnrelatedPictures) {
    for (const double sigma : {0.0, 1.0, 4.0}) {
        const auto stills = measured_of(
            [&](int x, int y, int n, SplitMix64& random) {
                const bool hole = (x / 10 + y / 10 + n) % 5 == 0;
                return hole ? 0 : hills(x, y, n) + sigma * noise(random);
            },
            5);
        EXPECT_EQ(stills->noise, DepthLength{}) << sigma;
        EXPECT_EQ(stills->noise_at_edges, 0) << sigma;
        EXPECT_EQ(stills->dropouts, 0) << sigma;
        EXPECT_FALSE(stills->from_a_camera()) << sigma;
        EXPECT_FALSE(chosen_by(stills).temporal) << sigma;
    }
}

// A camera turns by an eighth of the picture from frame to frame, or is shaken to and fro.
TEST(NoiseEstimator, FindsNoiseInFastFilm) {
    for (const double speed : {0.0, 2.0, 8.0, 20.0})
        for (const bool is_shaken : {false, true}) {
            const auto film = measured_of([&](int x, int y, int n, SplitMix64& random) {
                const double way = is_shaken ? speed / 4 * (n % 2) : speed * n;
                // A wall, and pillars before it that pass.
                const double at = std::fmod(x + way, 150);
                const double z = at < 40 ? 900 : 2000 + 0.5 * y;
                return z + 4 * noise(random);
            });
            EXPECT_NEAR(film->noise_at_median(), 4, 1) << speed << (is_shaken ? " to and fro" : "");
            EXPECT_TRUE(chosen_by(film).temporal) << speed;
        }
}

TEST(NoiseEstimator, CountsDropoutsAndTinyHoles) {
    const auto dropouts = measured_of([](int x, int y, int n, SplitMix64&) {
        return n % 2 == 1 && x % 10 == 4 && y % 10 == 4 ? 0 : slope(x, y);
    });
    EXPECT_NEAR(dropouts->dropouts, 0.005, 0.001) << "of 7 odd and 7 even frames in the middle";
    EXPECT_NEAR(dropouts->tiny_holes, 0.005, 0.001);
    // A round hole that stays has neither.
    const auto hole = measured_of([](int x, int y, int, SplitMix64&) {
        return std::hypot(x - 80.0, y - 60.0) < 21.5 ? 0 : slope(x, y);
    });
    EXPECT_EQ(hole->dropouts, 0);
    EXPECT_EQ(hole->tiny_holes, 0);
}

// Windows of codes that end beyond the largest one are of the codes that there are.
TEST(NoiseEstimator, MeasuresCodingsToLastCode) {
    for (const int code_max : {16, 100, 200, 3994, 4074, 65535})
        for (const bool near_is_high : {false, true})
            for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse}) {
                Scene scene = camera_scene();
                scene.depth.kind = kind;
                scene.depth.near_is_high = near_is_high;
                scene.depth.near = 500;
                scene.depth.far = 8000;
                scene.depth.code_max = static_cast<std::uint16_t>(code_max);
                scene.depth.invalid_code_count = 0;
                derive_valid_range(scene.depth);
                DepthEstimator estimator(scene);
                SplitMix64 random(3);
                for (int n = 0; n < 8; ++n) {
                    std::vector<std::uint16_t> codes;
                    for (int k = 0; k < estimate_width * estimate_height; ++k)
                        codes.push_back(
                            static_cast<std::uint16_t>((0.998 + 0.002 * random.unit()) * code_max));
                    estimator.add(store_plane(estimate_width, estimate_height, codes, {}).frame());
                }
                const auto measured = estimator.measured();
                ASSERT_TRUE(measured);
                EXPECT_TRUE(std::isfinite(measured->noise_at_median()));
                EXPECT_TRUE(code_max < 1000 || measured->roughness > 0) << code_max;
            }
}

// Noise of 2 mm in film whose frames are up to 0.6 % too deep or too near, all pixels by as much.
TEST(NoiseEstimator, TellsGainFromNoise) {
    for (const double gain : {0.0, 0.001, 0.003, 0.006}) {
        const auto film = measured_of([&](int x, int y, int n, SplitMix64& random) {
            SplitMix64 of_frame(mix64(static_cast<std::uint64_t>(n) + 7));
            return (slope(x, y) + 2 * noise(random)) * (1 + of_frame.within(-gain, gain));
        });
        EXPECT_NEAR(film->noise_at_median(), 2, 0.5) << gain;
    }
}

// One picture of noise has no holes, no frames to compare, and no levels.
TEST(FilterChoice, FiltersNoiseInOnePicture) {
    for (const double sigma : {2.0, 4.0, 8.0}) {
        const auto still = measured_of(
            [&](int x, int y, int, SplitMix64& random) { return slope(x, y) + sigma * noise(random); }, 1);
        EXPECT_FALSE(still->from_a_camera());
        EXPECT_TRUE(still->is_rough()) << sigma;
        const FilterSettings filter = chosen_by(still);
        EXPECT_EQ(filter.terraces, TerraceRemoval::on) << sigma;
        const TriedFilters* const chosen = found_among(still->tried, filter);
        ASSERT_NE(chosen, nullptr);
        EXPECT_LT(chosen->left_deg, 0.2 * found_among(still->tried, {})->left_deg) << sigma;
    }
}

// As rough, but the same in each frame: a texture. Noise that moves with nothing is none.
TEST(FilterChoice, KeepsTextureOfFilm) {
    const auto film = measured_of([](int x, int y, int, SplitMix64&) {
        SplitMix64 of_pixel(mix64(static_cast<std::uint64_t>(1000 * y + x)));
        return slope(x, y) + 4 * noise(of_pixel);
    });
    EXPECT_EQ(film->changing, 0);
    EXPECT_FALSE(film->is_rough());
    EXPECT_EQ(chosen_by(film), FilterSettings{});
}

// A table with a rough cloth: half of the picture is as smooth as its codes.
TEST(FilterChoice, KeepsTextureBesideSmoothPlaces) {
    const auto still = measured_of(
        [](int x, int y, int, SplitMix64& random) {
            return slope(x, y) + (x < estimate_width / 2 ? 0 : 8 * noise(random));
        },
        1);
    EXPECT_GT(still->smooth, 0.3);
    EXPECT_FALSE(still->is_rough());
}

// A slope in steps of 1 mm where a pixel is 8.6 mm wide leans by two degrees to and fro.
TEST(FilterChoice, RemovesFineTerracesThatAreFelt) {
    const auto measured = [](double step) {
        const auto stored = [=](double depth) { return step * std::floor(depth / step + 0.5); };
        return measured_of([&](int x, int y, int, SplitMix64&) { return stored(1000 + 1.1 * x + 0.7 * y); },
                           1);
    };
    const auto fine = measured(1);
    EXPECT_LT(fine->kappa, kappa_of_terraces);
    EXPECT_FALSE(fine->is_searched());
    EXPECT_EQ(chosen_by(fine).terraces, TerraceRemoval::on);
}

TEST(FilterChoice, EnablesAllForNoisyCamera) {
    const auto measured = measured_of([](int x, int y, int n, SplitMix64& random) {
        const double z = 500 + 0.5 * x + 4 * noise(random);
        return (x * 7 + y * 13 + n) % 211 == 0 ? 0 : z;
    });
    const FilterSettings filter = chosen_by(measured);
    EXPECT_EQ(filter.median, 3);
    EXPECT_EQ(filter.terraces, TerraceRemoval::on);
    EXPECT_EQ(filter.fill_holes, 2);
    EXPECT_TRUE(filter.temporal);
    EXPECT_EQ(filter.temporal_noise.constant, 1.4 * measured->noise.constant);
    EXPECT_NEAR(measured->noise_at_median(), 4, 0.5);
}

// A table before a wall; where they meet every other pixel saw some of both.
TEST(FilterChoice, PullsInFlyingPixels) {
    const auto silhouette = [](bool mixed) {
        return measured_of([=](int x, int y, int, SplitMix64& random) {
            const double off = 2 * noise(random);
            if (x == 80 && mixed && y % 2 == 0) return 700 + 40 * random.unit() + off;
            return (x < 80 ? 1000 : 500) + off;
        });
    };
    EXPECT_LT(silhouette(false)->flying, 1e-4);
    const auto measured = silhouette(true);
    EXPECT_NEAR(measured->flying, 0.5 / (estimate_width - 2), 0.0005);
    EXPECT_NEAR(chosen_by(measured).flying_pixels.at(measured->median), measured->median / 50, 0.1);
    EXPECT_EQ(chosen_by(silhouette(false)).flying_pixels, DepthLength{});
}

// Levels much farther apart than depth is noisy: the small median keeps edges.
TEST(FilterChoice, ShrinksMedianForCoarseLevels) {
    const auto chosen = [](double q, double sigma) {
        const auto measured = measured_of([=](int x, int y, int, SplitMix64& random) {
            const double z = slope(x, y) + sigma * noise(random);
            return 1 / (q * std::floor(1 / (q * z)));
        });
        return chosen_by(measured);
    };
    EXPECT_EQ(chosen(1e-5, 2).median, 0);
    EXPECT_EQ(chosen(1e-5, 30).median, 3);
    EXPECT_EQ(chosen(1e-5, 2).terraces, TerraceRemoval::on);
    EXPECT_NEAR(chosen(1e-5, 2).levels.quadratic, 1e-5, 1e-6);
}

TEST(FilterChoice, EnablesNothingWithoutMeasurement) {
    EXPECT_EQ(chosen_by(std::nullopt), FilterSettings{});
}

// Generated scenes have neither noise nor levels apart; terraces where kappa says so, nothing else.
TEST(FilterChoice, LimitsGeneratedScenesToTerraces) {
    for (const char* name :
         {"globe", "bumps", "rough", "moving", "plane", "spheres", "step", "noise", "cliffs", "grain"})
        for (const int bits : {8, 12, 16})
            for (const bool properties : {false, true}) {
                if (properties && std::string(name) != "globe") continue;
                SceneOptions options;
                options.width = 240;
                options.height = 160;
                options.bits = bits;
                options.properties = properties;
                const auto made = must(make_scene(name, options));
                Scene scene = made->scene();
                DepthEstimator estimator(scene);
                for (int frame = 0; !estimator.enough(); ++frame) {
                    ASSERT_LT(frame, DepthEstimator::first_few) << name << ", " << bits << " bits";
                    estimator.add(made->frame(frame));
                }
                const auto measured = estimator.measured();
                ASSERT_TRUE(measured);
                EXPECT_EQ(measured->levels, DepthLength{}) << name << ", " << bits << " bits";
                EXPECT_FALSE(measured->from_a_camera()) << name << ", " << bits << " bits";
                choose_filters(measured, all_unstated, scene);
                FilterSettings only;
                // Finer ones where it was tried and helps: steps of a smooth slope.
                const auto& tried = measured->tried;
                const bool helps = tried.size() == 2 && tried[1].left_deg < 0.9 * tried[0].left_deg;
                only.terraces =
                    measured->kappa >= kappa_of_terraces || helps ? TerraceRemoval::on : TerraceRemoval::off;
                EXPECT_TRUE(bits < 16 || only.terraces == TerraceRemoval::off) << name;
                EXPECT_EQ(scene.filter, only) << name << ", " << bits << " bits";
            }
}

struct Recording {
    const char *name, *scene;
    int median;
    bool holes, terraces, temporal;
};

TEST(FilterChoice, MatchesRealRecordings) {
    for (const Recording& known : {Recording{"castel_sr300", "castel_sr300", 0, true, true, false},
                                   {"visp_cube_realsense", "visp_cube_realsense", 0, true, true, true},
                                   {"stills/redwood5", "redwood5", 3, false, true, false},
                                   {"stills/icl_nuim5", "icl_nuim5", 0, false, true, false}}) {
        TOUCHABLE_NEEDS_DATA(real_data(known.name));
        const FilterSettings filter =
            chosen_of_recording(real_data(known.name), scene_files / (std::string(known.scene) + ".json"));
        EXPECT_EQ(filter.median, known.median) << known.name;
        EXPECT_EQ(filter.fill_holes, known.holes ? 2 : 0) << known.name;
        EXPECT_EQ(filter.terraces == TerraceRemoval::on, known.terraces) << known.name;
        EXPECT_EQ(filter.temporal, known.temporal) << known.name;
    }
}

}  // namespace
}  // namespace touchable::test
