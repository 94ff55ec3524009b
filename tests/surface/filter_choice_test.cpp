// SPDX-License-Identifier: Apache-2.0
// The measurements from which each filter is chosen, and its strength: the numbers of docs/scene_file.md,
// Filters that are left out.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/filter_codes.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "engine/surface/estimators.hpp"
#include "engine/surface/surface_builder.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

/// 1 mm a code, a pixel at the median depth of 1000 mm is 2 mm wide, the picture 640 mm.
constexpr double median_mm = 1000, pixel_mm = 2;
constexpr int columns = 320;

Scene open_scene() {
    Scene scene = metric_scene(columns, 240, {500, 500, 159.5, 119.5}, 4000);
    scene.depth.code_max = 4000;
    derive_valid_range(scene.depth);
    return scene;
}

/// A camera's by its dropouts, else clean.
MeasuredDepth of_a_camera() {
    MeasuredDepth measured;
    measured.frames = 16;
    measured.median = median_mm;
    measured.pixel = pixel_mm;
    measured.distance = 1;
    measured.dropouts = 0.01;
    return measured;
}

FilterSettings chosen_by(const MeasuredDepth& measured) {
    Scene scene = open_scene();
    choose_filters(measured, all_unstated, scene);
    EXPECT_TRUE(validate(scene));
    return scene.filter;
}

TEST(ChosenFilters, AreNoneForCleanDepth) {
    EXPECT_EQ(chosen_by(of_a_camera()), FilterSettings{});
}

// 0.15 of a pixel's width is 0.3 mm.
TEST(ChosenFilters, NeedRoughnessForMedian) {
    MeasuredDepth measured = of_a_camera();
    measured.roughness = 0.299;
    EXPECT_EQ(chosen_by(measured).median, 0);
    measured.roughness = 0.301;
    EXPECT_EQ(chosen_by(measured).median, 3) << "codes are 1 mm apart";
    measured.dropouts = 0;
    EXPECT_EQ(chosen_by(measured).median, 0) << "no camera";
}

TEST(ChosenFilters, ShrinkMedianForCoarseLevels) {
    MeasuredDepth measured = of_a_camera();
    measured.distance = 12;
    for (const bool by_noise : {false, true}) {
        measured.roughness = by_noise ? 1 : 7.99;
        measured.noise.constant = by_noise ? 7.99 : 1;
        EXPECT_EQ(chosen_by(measured).median, 3) << by_noise;
        (by_noise ? measured.noise.constant : measured.roughness) = 8.01;
        EXPECT_EQ(chosen_by(measured).median, 5) << by_noise;
    }
}

// A ten-thousandth of 640 mm.
TEST(ChosenFilters, NeedNoiseForTemporalFilter) {
    MeasuredDepth measured = of_a_camera();
    measured.noise = {0.03, 0.0339 / (median_mm * median_mm)};
    EXPECT_FALSE(chosen_by(measured).temporal);
    measured.noise = {0.03, 0.0341 / (median_mm * median_mm)};
    EXPECT_TRUE(chosen_by(measured).temporal);
    EXPECT_EQ(chosen_by(measured).temporal_noise.constant, 0.9 * 0.03);
    EXPECT_NEAR(chosen_by(measured).temporal_noise.at(median_mm), 0.9 * 0.0641, 1e-12);
}

// A gate is twice the noise that the median leaves, and that of no median the most.
TEST(ChosenFilters, RaiseTemporalNoiseAfterMedian) {
    MeasuredDepth measured = of_a_camera();
    measured.noise = {2, 0};
    measured.roughness = 1;
    measured.distance = 4;
    EXPECT_EQ(chosen_by(measured).median, 3);
    EXPECT_EQ(chosen_by(measured).temporal_noise, (DepthLength{2.8, 0}));
    measured.distance = 1;
    EXPECT_EQ(chosen_by(measured).median, 5);
    EXPECT_EQ(chosen_by(measured).temporal_noise, (DepthLength{3, 0}));
    measured.roughness = 0;
    EXPECT_EQ(chosen_by(measured).median, 0);
    EXPECT_EQ(chosen_by(measured).temporal_noise, (DepthLength{1.8, 0}));
}

// The tried filters decide unless the scene states one of the two.
TEST(ChosenFilters, TakeMildestOfBestTried) {
    MeasuredDepth measured = of_a_camera();
    measured.roughness = 2;
    measured.kappa = 1;
    measured.noise = {1, 0};
    measured.tried = {{true, 0, false, {}, 0, 30},        {true, 0, true, {4, 0}, 0.7, 4.1},
                      {true, 3, true, {4, 0}, 1.05, 4},   {true, 5, true, {6, 0}, 1.9, 3.99},
                      {false, 0, true, {4, 0}, 0.7, 9.1}, {false, 3, true, {4, 0}, 1.05, 7}};
    EXPECT_EQ(chosen_by(measured).median, 0);
    EXPECT_EQ(chosen_by(measured).terraces, TerraceRemoval::on);
    EXPECT_EQ(chosen_by(measured).levels, (DepthLength{4, 0}));
    measured.tried[1].left_deg = 5;
    EXPECT_EQ(chosen_by(measured).median, 3);
    Scene scene = open_scene();
    scene.filter.median = 5;
    UnstatedFilters unstated = all_unstated;
    unstated.median = false;
    choose_filters(measured, unstated, scene);
    EXPECT_EQ(scene.filter.median, 5);
    EXPECT_EQ(scene.filter.levels, DepthLength{}) << "as measured";
    // If the scene states that averaging is off, the trials without averaging count.
    scene = open_scene();
    unstated = all_unstated;
    unstated.temporal = false;
    choose_filters(measured, unstated, scene);
    EXPECT_FALSE(scene.filter.temporal);
    EXPECT_EQ(scene.filter.median, 3);
}

// 1 is as recorded, 0 the smoothest of the tried filters, and between lie those that leave less and less.
TEST(ChosenFilters, FollowDetail) {
    MeasuredDepth measured = of_a_camera();
    measured.noise = {1, 0};
    measured.tried = {{false, 0, false, {}, 0, 30},    {true, 0, false, {}, 0, 26},
                      {false, 3, false, {}, 0.17, 29}, {true, 3, false, {}, 0.17, 27},
                      {true, 0, true, {2, 0}, 0.7, 9}, {true, 3, true, {2, 0}, 0.9, 8.95},
                      {true, 0, true, {4, 0}, 1, 5},   {true, 3, true, {4, 0}, 1.17, 2.1},
                      {true, 0, true, {6, 0}, 1.4, 2}};
    const auto with = [&](std::optional<double> detail, int stated_median = -1) {
        Scene scene = open_scene();
        UnstatedFilters unstated = all_unstated;
        unstated.detail = detail;
        unstated.median = stated_median < 0;
        scene.filter.median = std::max(stated_median, 0);
        choose_filters(measured, unstated, scene);
        EXPECT_TRUE(validate(scene));
        return scene.filter;
    };
    EXPECT_EQ(with(1), FilterSettings{});
    EXPECT_EQ(measured.detail_of(with(1)), 1);
    double before = 31;
    for (const double detail : {1.0, 0.8, 0.6, 0.4, 0.2, 0.0}) {
        const FilterSettings filter = with(detail);
        const TriedFilters* const chosen = found_among(measured.tried, filter);
        ASSERT_NE(chosen, nullptr) << detail;
        EXPECT_LT(chosen->left_deg, before) << detail;
        EXPECT_NEAR(*measured.detail_of(filter), detail, 1e-9);
        before = chosen->left_deg;
    }
    EXPECT_EQ(before, 2);
    EXPECT_EQ(with(std::nullopt).levels, (DepthLength{4, 0})) << "hardly more than the smoothest";
    EXPECT_EQ(with(1, 5).median, 5) << "stated";
    // Of those with the stated median: 29 degrees, 27, 8.95 and 2.1.
    EXPECT_EQ(with(1, 3).terraces, TerraceRemoval::off);
    EXPECT_EQ(with(0.34, 3).levels, (DepthLength{2, 0}));
    EXPECT_EQ(with(0, 3).levels, (DepthLength{4, 0}));
    EXPECT_EQ(with(0, 3).median, 3);
    // Averaging that is stated, but was not tried, does not keep the others from being smooth.
    std::erase_if(measured.tried, &TriedFilters::temporal);
    measured.tried.push_back({false, 0, true, {4, 0}, 1, 5});
    Scene averaged = open_scene();
    averaged.filter.temporal = true;
    averaged.filter.temporal_noise = {1, 0};
    UnstatedFilters unstated = all_unstated;
    unstated.detail = 0;
    unstated.temporal = false;
    choose_filters(measured, unstated, averaged);
    EXPECT_EQ(averaged.filter.levels, (DepthLength{4, 0}));
    EXPECT_TRUE(averaged.filter.temporal);
    // Where nothing could be tried, all detail is no filter.
    measured.tried.clear();
    measured.roughness = 20;
    EXPECT_EQ(with(std::nullopt).median, 5);
    EXPECT_EQ(with(1).median, 0);
}

TEST(ChosenFilters, NeedTinyHolesForFilling) {
    MeasuredDepth measured = of_a_camera();
    measured.tiny_holes = 0.0000999;
    EXPECT_EQ(chosen_by(measured).fill_holes, 0);
    measured.tiny_holes = 0.0001;
    EXPECT_EQ(chosen_by(measured).fill_holes, 2);
}

TEST(ChosenFilters, LandFlyingPixelsOfCamera) {
    MeasuredDepth measured = of_a_camera();
    measured.flying = 0.0000999;
    EXPECT_EQ(chosen_by(measured).flying_pixels, DepthLength{});
    measured.flying = 0.0001;
    EXPECT_NE(chosen_by(measured).flying_pixels, DepthLength{});
}

// Depth without signs of a camera: a phone's, or a rendered one's.
TEST(ChosenFilters, LandMidwayPixelsWithoutCamera) {
    MeasuredDepth measured = of_a_camera();
    measured.dropouts = 0;
    measured.flying = 0.01;
    EXPECT_EQ(chosen_by(measured).flying_pixels, DepthLength{}) << "rounded rims";
    measured.midway = 0.0000999;
    EXPECT_EQ(chosen_by(measured).flying_pixels, DepthLength{});
    measured.midway = 0.001;
    EXPECT_NE(chosen_by(measured).flying_pixels, DepthLength{});
    measured.clean_edges = 0.00399;
    EXPECT_NE(chosen_by(measured).flying_pixels, DepthLength{});
    measured.clean_edges = 0.00401;
    EXPECT_EQ(chosen_by(measured).flying_pixels, DepthLength{});
}

// Ten pixels' widths, but no more than a fiftieth of the depth; two levels where these are farther apart.
TEST(ChosenFilters, SetFlyingGateWithoutCamera) {
    MeasuredDepth measured = of_a_camera();
    measured.dropouts = 0;
    measured.flying = measured.midway = 0.001;
    for (const auto& [pixel, length] : {std::pair{1.0, 10.0}, {1.5, 15.0}, {2.5, 20.0}}) {
        measured.pixel = pixel;
        const DepthLength flat = chosen_by(measured).flying_pixels;
        EXPECT_NEAR(flat.at(median_mm), length, 1e-9);
        EXPECT_NEAR((flat.at(median_mm + 1) - flat.at(median_mm - 1)) / 2, length / median_mm, 1e-9);
    }
    measured.distance = 15;
    const DepthLength levels = chosen_by(measured).flying_pixels;
    EXPECT_NEAR(levels.at(median_mm), 30, 1e-9);
    EXPECT_NEAR(levels.constant, 10, 1e-9) << "what is near has finer levels";
}

// A fiftieth of the median depth, or three times the noise; about in proportion to depth around it.
TEST(ChosenFilters, SetFlyingGateOfCamera) {
    MeasuredDepth measured = of_a_camera();
    measured.flying = 0.01;
    for (const auto& [noise, length] : {std::pair{6.6, 20.0}, {6.7, 20.1}, {10.0, 30.0}}) {
        measured.noise.constant = noise;
        const DepthLength flat = chosen_by(measured).flying_pixels;
        EXPECT_NEAR(flat.at(median_mm), length, 1e-9);
        EXPECT_NEAR((flat.at(median_mm + 1) - flat.at(median_mm - 1)) / 2, length / median_mm, 1e-9);
    }
}

TEST(ChosenFilters, NeedKappaForTerraceRemoval) {
    MeasuredDepth measured = of_a_camera();
    measured.levels = {0, 3e-6};
    measured.kappa = 0.2499;
    EXPECT_EQ(chosen_by(measured).terraces, TerraceRemoval::off);
    EXPECT_EQ(chosen_by(measured).levels, DepthLength{});
    measured.kappa = 0.25;
    EXPECT_EQ(chosen_by(measured).terraces, TerraceRemoval::on);
    EXPECT_EQ(chosen_by(measured).levels, measured.levels);
}

TEST(ChosenFilters, KeepTerracesWithoutRoom) {
    MeasuredDepth measured = of_a_camera();
    measured.kappa = 1;
    Scene scene = open_scene();
    scene.depth.scale = 0.2;
    scene.depth.code_max = 20'000;
    derive_valid_range(scene.depth);
    for (const double level : {0.0, 2.0}) {
        measured.levels = {level, 0};
        EXPECT_TRUE(removal_advised(measured, scene)) << level;
    }
    measured.levels = {1e6, 0};
    EXPECT_FALSE(removal_advised(measured, scene));
}

// All that was measured here asks for a filter.
TEST(ChosenFilters, KeepEachStatedFilter) {
    MeasuredDepth measured = of_a_camera();
    measured.roughness = 2;
    measured.flying = measured.tiny_holes = 0.01;
    measured.kappa = 1;
    measured.noise = {2, 0};
    const FilterSettings all = chosen_by(measured);
    const auto chosen_but = [&](bool UnstatedFilters::*stated) {
        Scene scene = open_scene();
        UnstatedFilters unstated = all_unstated;
        unstated.*stated = false;
        choose_filters(measured, unstated, scene);
        return scene.filter;
    };
    FilterSettings but = all;
    but.median = 0;
    but.temporal_noise = {1.8, 0};
    EXPECT_EQ(chosen_but(&UnstatedFilters::median), but);
    but = all;
    but.fill_holes = 0;
    EXPECT_EQ(chosen_but(&UnstatedFilters::fill_holes), but);
    but = all;
    but.flying_pixels = {};
    EXPECT_EQ(chosen_but(&UnstatedFilters::flying_pixels), but);
    but = all;
    but.terraces = TerraceRemoval::off;
    but.levels = {};
    EXPECT_EQ(chosen_but(&UnstatedFilters::terraces), but);
    but = all;
    but.temporal = false;
    but.temporal_noise = {};
    EXPECT_EQ(chosen_but(&UnstatedFilters::temporal), but);
}

TEST(ChosenFilters, ResolveAutomaticTerraces) {
    for (const bool is_measured : {false, true}) {
        Scene scene = open_scene();
        scene.filter.terraces = TerraceRemoval::automatic;
        MeasuredDepth measured = of_a_camera();
        measured.kappa = 1;
        choose_filters(is_measured ? std::optional(measured) : std::nullopt, {}, scene);
        EXPECT_EQ(scene.filter.terraces, is_measured ? TerraceRemoval::on : TerraceRemoval::off);
    }
}

TEST(ChosenFilters, KeepStatedNoise) {
    Scene scene = open_scene();
    scene.filter.temporal_noise = {0.7, 0};
    MeasuredDepth measured = of_a_camera();
    measured.noise = {2, 0};
    choose_filters(measured, all_unstated, scene);
    EXPECT_TRUE(scene.filter.temporal);
    EXPECT_EQ(scene.filter.temporal_noise, (DepthLength{0.7, 0}));
}

FilterPlan plan_of(const FilterSettings& filter, int bits = 8) {
    return FilterPlan(depth_scene(40, 30, bits, Marking::none, filter));
}

TEST(FilterPlan, OnlyDecodesWithoutFilters) {
    const FilterPlan plan = plan_of({});
    EXPECT_TRUE(plan.filters.empty());
    EXPECT_EQ(plan.reach(), 0);
    EXPECT_FALSE(plan.remembers());
    EXPECT_EQ(plan.coding(), plan.stored);
}

TEST(FilterPlan, OrdersFiltersAsDocumented) {
    FilterSettings all{.median = 5, .fill_holes = 2, .terraces = TerraceRemoval::on};
    const FilterPlan still = plan_of(all);
    ASSERT_EQ(still.filters.size(), 3U);
    EXPECT_EQ(std::get<FilterPlan::HoleFilling>(still.filters[0].filter).passes, 2);
    EXPECT_EQ(std::get<FilterPlan::MedianWindow>(still.filters[1].filter).side, 5);
    EXPECT_EQ(std::get<TerraceFilter>(still.filters[2].filter).working.factor, 126);  // floor(32767 / 260)
    EXPECT_EQ(still.reach(), 2 + 2 + 16);
    EXPECT_FALSE(still.remembers());

    all.temporal = true;
    all.temporal_noise = {0.1, 0};
    const FilterPlan moving = plan_of(all);
    ASSERT_EQ(moving.filters.size(), 4U);
    EXPECT_EQ(std::get<TemporalFilter>(moving.filters[2].filter).working.factor, 126);
    EXPECT_EQ(std::get<TerraceFilter>(moving.filters[3].filter).working.factor, 1) << "multiplied before";
    EXPECT_TRUE(moving.remembers());
    EXPECT_NE(moving, still);
}

TEST(FilterPlan, EndsInLastFiltersCoding) {
    EXPECT_EQ(plan_of({.median = 3}).coding().code_max, 255);
    FilterSettings finer{.median = 3, .temporal = true, .temporal_noise = {0.1, 0}};
    EXPECT_EQ(plan_of(finer).coding().code_max, 255 * 126);
    finer.terraces = TerraceRemoval::on;
    EXPECT_EQ(plan_of(finer).coding().code_max, 255 * 126 * 2);
    EXPECT_EQ(plan_of(finer).filters.front().coding.code_max, 255);
}

TEST(FilterPlan, FindsRequestedFilters) {
    const FilterPlan plan = plan_of({.median = 3});
    ASSERT_NE(plan.find<FilterPlan::MedianWindow>(), nullptr);
    EXPECT_EQ(plan.find<FilterPlan::MedianWindow>()->side, 3);
    EXPECT_EQ(plan.find<FilterPlan::HoleFilling>(), nullptr);
    EXPECT_EQ(plan.find<TemporalFilter>(), nullptr);
    const FilterPlan too_fine = plan_of({.terraces = TerraceRemoval::automatic}, 16);
    EXPECT_EQ(too_fine.find<TerraceFilter>(), nullptr) << "a step is too small to be felt";
}

// Filters are tried on smooth places of a recording, put side by side.

constexpr int picture_width = 320, picture_height = 240;

Scene scene_of_millimetres() {
    return metric_scene(picture_width, picture_height, {300, 300, 159.5, 119.5}, 20700);
}

/// In codes of 0.05 mm: finer than all noise.
Scene fine_scene() {
    return metric_scene(picture_width, picture_height, {300, 300, 159.5, 119.5}, 3000, 0.05);
}

double noise(Random& random) {
    return normal([&] { return random.below(1 << 16) / 65536.0; });
}

/// Whole millimetres of a wall that leans.
struct Wall {
    double sigma = 0;  ///< standard deviation of noise, mm
    double level = 0;  ///< mm at a metre, of disparity; 0: none
    bool holes = false, strays = false;
    double pens = 0;  ///< mm that pens stand out: columns 5 wide, 80 apart

    static bool is_pen(int x) { return x % 80 >= 40 && x % 80 < 45; }

    CodePicture picture(std::uint64_t seed = 1) const {
        Random random(seed);
        CodePicture picture{picture_width, picture_height, {}};
        for (int y = 0; y < picture_height; ++y)
            for (int x = 0; x < picture_width; ++x) {
                double depth = 1000 / (1 - 0.3 * (x - 159.5) / 300 + 0.2 * (y - 119.5) / 300);
                depth += sigma * noise(random) - (is_pen(x) ? pens : 0);
                if (level > 0) {
                    const double step = level * 1e-6;
                    depth = 1 / (step * std::floor(1 / depth / step + 0.5));
                }
                int code = static_cast<int>(depth + 0.5);
                if (strays && random.below(2000) == 0) code = 19700;
                if (holes && random.below(50) == 0) code = CodePicture::invalid;
                picture.codes.push_back(code);
            }
        return picture;
    }
};

std::deque<CodePicture> still_of(const Wall& wall) {
    return {wall.picture()};
}

std::deque<CodePicture> film_of(const Wall& wall) {
    std::deque<CodePicture> pictures;
    for (std::uint64_t n = 1; n <= SmoothPatches::frames; ++n) pictures.push_back(wall.picture(n));
    return pictures;
}

/// `code` of each pixel.
template <class Code>
void change(CodePicture& picture, Code&& code) {
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x) {
            int& here = picture.codes[static_cast<std::size_t>(y * picture.width + x)];
            here = code(x, y, here);
        }
}

const TriedFilters& unfiltered(const std::vector<TriedFilters>& tried) {
    return *found_among(tried, {});
}

TEST(SmoothPatches, MeasureRoundingAsRoughness) {
    const SmoothPatches patches(scene_of_millimetres(), still_of({}));
    ASSERT_TRUE(patches.enough());
    EXPECT_NEAR(patches.roughness().at(patches.median_depth()), 1 / std::sqrt(12.0), 0.06);
    EXPECT_NEAR(patches.median_depth(), 1000, 60);
}

TEST(SmoothPatches, MeasureNoiseDespiteHoles) {
    for (const bool spoilt : {false, true}) {
        const SmoothPatches patches(scene_of_millimetres(),
                                    still_of({.sigma = 4, .holes = spoilt, .strays = spoilt}));
        ASSERT_TRUE(patches.enough());
        EXPECT_NEAR(patches.roughness().at(patches.median_depth()), 4, 0.4);
    }
}

TEST(SmoothPatches, PredictLeanOfNoisyFaces) {
    for (const double sigma : {0.1, 0.3, 1.0}) {
        std::deque<CodePicture> pictures = still_of({});
        Random random(7);
        change(pictures[0],
               [&](int, int, int) { return static_cast<int>(20 * (1000 + sigma * noise(random)) + 0.5); });
        const SmoothPatches patches(fine_scene(), pictures);
        ASSERT_TRUE(patches.enough());
        SurfaceFrame built;
        ASSERT_TRUE(make_reference_builder(patches.mosaic_scene())->build(patches.mosaics().back(), built));
        // Two slopes across each other, each sqrt(2) noise over 10/3 mm.
        const double expected =
            std::atan(std::sqrt(2.0) * std::sqrt(2.0) * sigma / (1000.0 / 300)) * 180 / 3.14159265;
        EXPECT_NEAR(patches.faces_off_deg(built), expected, 0.08 * expected) << sigma;
    }
}

// Filters of a mosaic do to the middle of a patch's core, of which faces are looked at, what they do to the
// picture.
TEST(SmoothPatches, FilterLikeWholePicture) {
    Scene scene = scene_of_millimetres();
    const std::deque<CodePicture> pictures = still_of({.sigma = 2, .level = 3, .holes = true});
    const SmoothPatches patches(scene, pictures);
    ASSERT_TRUE(patches.enough());
    const FilterSettings filter{.median = 5, .terraces = TerraceRemoval::on, .levels = {0, 4e-6}};
    std::vector<std::uint16_t> codes;
    for (const int code : pictures[0].codes)
        codes.push_back(static_cast<std::uint16_t>(code == CodePicture::invalid ? 0 : code));
    const StoredPlane plane = store_plane(picture_width, picture_height, codes, {});
    scene.filter = filter;
    Scene mosaic = patches.mosaic_scene();
    mosaic.filter = filter;
    SurfaceFrame whole, built;
    ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), whole));
    ASSERT_TRUE(make_reference_builder(mosaic)->build(patches.mosaics().back(), built));
    ASSERT_GE(patches.places().size(), 30U);
    for (const auto& [from, to] : patches.places())
        for (int y = SmoothPatches::margin; y <= SmoothPatches::core - SmoothPatches::margin; ++y)
            for (int x = SmoothPatches::margin; x <= SmoothPatches::core - SmoothPatches::margin; ++x) {
                const auto in_mosaic = built.index(to.x + x, to.y + y),
                           in_whole = whole.index(from.x + x, from.y + y);
                ASSERT_EQ(built.codes[in_mosaic], whole.codes[in_whole]) << x << ", " << y;
            }
}

// A large picture is kept only as far as places can lie; their pixels are the picture's own.
TEST(SmoothPatches, CropLargePictures) {
    for (const auto& [width, height] : {std::pair{3000, 100}, {100, 3000}, {1600, 1545}}) {
        Scene scene = scene_of_millimetres();
        scene.width = width;
        scene.height = height;
        CodePicture picture{width, height, {}};
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) picture.codes.push_back((10000 + 3 * x + 2 * y) / 10);
        const CodePicture cropped = SmoothPatches::cropped(picture);
        EXPECT_EQ(cropped.width, std::min(width, 1536));
        EXPECT_EQ(cropped.height, std::min(height, 1536));
        const SmoothPatches patches(scene, {cropped});
        ASSERT_TRUE(patches.enough());
        EXPECT_NEAR(patches.roughness().at(patches.median_depth()), 1 / std::sqrt(12.0), 0.06);
        const PlaneView mosaic = patches.mosaics().back().depth;
        constexpr int around = (SmoothPatches::side - SmoothPatches::core) / 2;
        for (const auto& [from, to] : patches.places())
            for (int y = -around; y < SmoothPatches::side - around; ++y)
                for (int x = -around; x < SmoothPatches::side - around; ++x)
                    ASSERT_EQ(mosaic.sample(to.x + x, to.y + y), picture.row(from.y + y)[from.x + x]);
    }
}

// Pens of five times the noise fit into a patch that is about as smooth as the others.
TEST(SmoothPatches, LeaveOutLowRelief) {
    for (const double level : {0.0, 4.0}) {
        const SmoothPatches patches(scene_of_millimetres(),
                                    film_of({.sigma = 2, .level = level, .pens = 10}));
        ASSERT_TRUE(patches.enough());
        for (const auto& [from, to] : patches.places())
            for (int x = 2; x < SmoothPatches::core - 2; ++x)
                EXPECT_FALSE(Wall::is_pen(from.x + x)) << from.x << " + " << x;
        // Without pens no patch is left out.
        const auto without = film_of({.sigma = 2, .level = level});
        EXPECT_GE(SmoothPatches(scene_of_millimetres(), without).places().size(), 60U);
    }
}

// What is left out for its relief, or for noise that looks like some, does not change the depth at which
// levels are compared with noise.
TEST(SmoothPatches, TakeMedianDepthOfAllPlaces) {
    const auto median = [](bool has_pens) {
        std::deque<CodePicture> film = film_of({.sigma = 2});
        for (CodePicture& picture : film)
            change(picture, [&](int x, int, int code) {
                return has_pens && x < picture_width / 2 && x % 16 < 5 ? code - 6 : code;
            });
        const SmoothPatches patches(scene_of_millimetres(), film);
        std::size_t left = 0;
        for (const auto& [from, to] : patches.places())
            left += from.x + SmoothPatches::core < picture_width / 2;
        EXPECT_EQ(left == 0, has_pens);
        return patches.median_depth();
    };
    EXPECT_NEAR(median(true), median(false), 10);
}

// With relief everywhere, judging filters by it is better than not judging them.
TEST(SmoothPatches, KeepReliefThatIsEverywhere) {
    CodePicture picture = Wall{.sigma = 2}.picture();
    change(picture, [](int x, int, int code) { return x % 16 < 5 ? code - 10 : code; });
    EXPECT_TRUE(SmoothPatches(scene_of_millimetres(), {picture}).enough());
}

// A background of one code is the smoothest place of all, and says nothing.
TEST(SmoothPatches, SkipConstantBackground) {
    std::deque<CodePicture> pictures = still_of({.level = 12});
    change(pictures[0], [](int x, int, int code) { return x < picture_width / 2 ? 3000 : code; });
    const SmoothPatches patches(scene_of_millimetres(), pictures);
    ASSERT_TRUE(patches.enough());
    for (const auto& [from, to] : patches.places())
        EXPECT_GT(from.x + SmoothPatches::core, picture_width / 2);
}

TEST(SmoothPatches, NeedEnoughDepth) {
    Scene scene = scene_of_millimetres();
    EXPECT_FALSE(SmoothPatches(scene, {}).enough());
    CodePicture none{picture_width, picture_height,
                     std::vector<int>(std::size_t{picture_width} * picture_height, CodePicture::invalid)};
    EXPECT_FALSE(SmoothPatches(scene, {none}).enough());
    scene.width = 63;
    CodePicture small{63, 64, std::vector<int>(std::size_t{63} * 64, 1000)};
    EXPECT_FALSE(SmoothPatches(scene, {small}).enough());
}

TEST(FilterSearch, SmoothsNoisyWall) {
    const SmoothPatches patches(scene_of_millimetres(), still_of({.sigma = 4, .strays = true}));
    const auto tried = tried_filters(patches, {}, {});
    ASSERT_GT(tried.size(), 10U);
    const TriedFilters& best = *mildest_of_the_best(tried, false);
    EXPECT_GT(unfiltered(tried).left_deg, 30);
    EXPECT_LT(best.left_deg, 6);
    EXPECT_TRUE(best.terraces);
    for (std::size_t n = 1; n < tried.size(); ++n) EXPECT_GE(tried[n].harshness, tried[n - 1].harshness);
}

// Filters that smooth pens away leave no less than others, so the mildest is taken.
TEST(FilterSearch, KeepsLowRelief) {
    const auto chosen = [](double pens) {
        const auto pictures = film_of({.sigma = 2, .pens = pens});
        const auto tried = tried_filters(SmoothPatches(scene_of_millimetres(), pictures), {}, {2, 0});
        return *mildest_of_the_best(tried, true);
    };
    const TriedFilters with = chosen(12), without = chosen(0);
    EXPECT_LE(with.harshness, without.harshness);
    EXPECT_LT(with.left_deg, 1.3 * without.left_deg);
}

TEST(FilterSearch, TriesAveragingOfNoisyFrames) {
    const SmoothPatches patches(scene_of_millimetres(), film_of({.sigma = 4}));
    const auto tried = tried_filters(patches, {}, {4, 0});
    for (const TriedFilters& one : tried) {
        FilterSettings filter{.median = one.median, .levels = one.levels, .temporal = !one.temporal};
        filter.terraces = one.terraces ? TerraceRemoval::on : TerraceRemoval::off;
        const TriedFilters* const other = found_among(tried, filter);
        ASSERT_NE(other, nullptr);
        if (one.temporal) {
            EXPECT_LT(one.left_deg, other->left_deg) << one.harshness;
        }
    }
    EXPECT_LT(mildest_of_the_best(tried, true)->left_deg, mildest_of_the_best(tried, false)->left_deg);
}

TEST(FilterSearch, UsesMeasuredLevels) {
    const SmoothPatches patches(scene_of_millimetres(), still_of({.level = 12}));
    const auto tried = tried_filters(patches, {0, 12e-6}, {});
    const TriedFilters& best = *mildest_of_the_best(tried, false);
    EXPECT_EQ(best.median, 0);
    EXPECT_TRUE(best.terraces);
    EXPECT_GE(best.levels.quadratic, 12e-6);
    EXPECT_LE(best.levels.quadratic, 1.4001 * 12e-6);
    EXPECT_LT(best.left_deg, 0.1 * unfiltered(tried).left_deg);
}

// From as recorded to smooth: each point leaves less, and keeps only higher relief.
TEST(FilterSearch, ReachesFromDetailToSmooth) {
    for (const double sigma : {2.0, 5.0}) {
        const SmoothPatches patches(scene_of_millimetres(), film_of({.sigma = sigma}));
        const auto tried = tried_filters(patches, {}, {sigma, 0});
        const auto points = frontier(tried, true);
        EXPECT_GE(points.size(), 5U);
        EXPECT_EQ(points.front(), &unfiltered(tried));
        EXPECT_TRUE(std::ranges::count(points, mildest_of_the_best(tried, true)));
        double left = 180, relief = 0;
        for (const TriedFilters* const point : points) {
            EXPECT_LT(point->left_deg, left);
            left = point->left_deg;
            const double least = least_relief(patches, *point, {sigma, 0});
            EXPECT_GE(least, 0.8 * relief) << point->harshness;
            relief = std::max(relief, least);
        }
        EXPECT_GT(relief, sigma);
        EXPECT_EQ(least_relief(patches, *points.front(), {}), 0);
    }
}

// What stands still, and is far rougher than noise from frame to frame, is relief: nothing is tried on it.
TEST(FilterSearch, LeavesReliefOfFilmsAlone) {
    const DepthLength noise{0.7, 0};
    std::deque<CodePicture> pictures = film_of({.sigma = 0.6});
    EXPECT_TRUE(SmoothPatches(scene_of_millimetres(), pictures, noise).enough());
    for (CodePicture& picture : pictures)  // keys 4 mm high
        change(picture, [](int x, int y, int code) { return x % 11 < 9 && y % 11 < 9 ? code - 4 : code; });
    EXPECT_TRUE(SmoothPatches(scene_of_millimetres(), pictures).enough()) << "may be noise";
    EXPECT_FALSE(SmoothPatches(scene_of_millimetres(), pictures, noise).enough());
    EXPECT_TRUE(SmoothPatches(scene_of_millimetres(), pictures, noise, {0, 6e-6}).enough()) << "levels";
}

// Force is not trusted where levels are ten pixels wide, which are depth/300 each, or places lean by 9
// degrees.
TEST(FilterSearch, TellsHowFarForceIsTrusted) {
    constexpr double q = 1e-6, width = 1.0 / 300;
    Random random(3);
    std::deque<CodePicture> pictures = film_of({});
    for (CodePicture& picture : pictures)  // from 1.5 m away to 8 m
        change(picture, [&](int, int y, int) {
            const double depth = 1 / (1.0 / 1500 + (1.0 / 8000 - 1.0 / 1500) * y / (picture_height - 1));
            return static_cast<int>(depth + q * depth * depth * noise(random) + 0.5);
        });
    MeasuredDepth measured;
    measured.median = 3000;
    measured.pixel = 3000 * width;
    measured.farthest = 8000;
    measured.noise = {0, q};
    measured.patches = std::make_shared<const SmoothPatches>(scene_of_millimetres(), pictures);
    measured.tried = {{.terraces = true, .levels = {0, 8e-6}, .left_deg = 1}, {.levels = {}, .left_deg = 1}};
    const auto trusted_to = [&](std::size_t n) {
        FilterSettings filter;
        measured.tried[n].apply(measured.noise, filter);
        return measured.trusted_to(filter);
    };
    EXPECT_NEAR(trusted_to(0).value_or(0), 10 * width / 8e-6, 1e-9);
    EXPECT_FALSE(trusted_to(1)) << "9 degrees are farther away";
    measured.tried[0].levels = {100, 8e-6};
    EXPECT_EQ(trusted_to(0), 0) << "levels are wider at every depth";
    measured.tried[0].levels = {0, 8e-6};
    // Noise of q depth^2 leans in proportion to depth.
    const double here = measured.patches->median_depth();
    measured.tried[1].left_deg = 9 * here / 5000;
    EXPECT_NEAR(trusted_to(1).value_or(0), 5000, 250);
    measured.noise = {};
    measured.tried[1].left_deg = 10;
    EXPECT_FALSE(trusted_to(1)) << "fine relief of one picture leans, too";
    measured.noise = {0, q};
    EXPECT_EQ(trusted_to(1), 0);
    measured.farthest = 4000;
    EXPECT_FALSE(trusted_to(0)) << "nothing is so far away";
    EXPECT_FALSE(measured.trusted_to({.median = 3})) << "not tried";
}

// Removal for levels l apart takes steps up to a code beyond l, and leaves those of four levels.
TEST(FilterSearch, MeasuresLeastRelief) {
    const SmoothPatches patches(scene_of_millimetres(), film_of({.sigma = 2}));
    for (const double level : {4.0, 8.0}) {
        const double least = least_relief(patches, {.terraces = true, .levels = {level, 0}}, {});
        EXPECT_GT(least, level);
        EXPECT_LT(least, 4 * level);
    }
}

TEST(FilterSearch, LeavesASmoothWallAlone) {
    std::deque<CodePicture> pictures = still_of({});
    change(pictures[0],
           [](int x, int, int) { return static_cast<int>(20 * 1000 / (1 - 0.3 * (x - 159.5) / 300) + 0.5); });
    const auto tried = tried_filters(SmoothPatches(fine_scene(), pictures), {}, {});
    ASSERT_FALSE(tried.empty());
    const TriedFilters& best = *mildest_of_the_best(tried, false);
    EXPECT_EQ(best.median, 0);
    EXPECT_FALSE(best.terraces);
}

TEST(FilterSearch, MeasuresRemovalAlone) {
    const SmoothPatches patches(scene_of_millimetres(), still_of({.level = 12}));
    const auto tried = tried_removal(patches, {0, 12e-6});
    ASSERT_EQ(tried.size(), 2U);
    EXPECT_LT(tried[1].left_deg, 0.1 * tried[0].left_deg);
    EXPECT_EQ(found_among(tried, {.terraces = TerraceRemoval::on, .levels = {0, 12e-6}}), &tried[1]);
    EXPECT_EQ(found_among(tried, {.median = 5}), nullptr);
}

// Small pictures worked out by hand; in them 0 is an invalid pixel. Every builder must agree with the hand.

using Codes = std::vector<std::uint16_t>;

void expect_filtered(int width, int height, const Codes& stored, FilterSettings filter,
                     const Codes& expected) {
    for (const int bytes : {1, 2}) {
        const Scene scene = depth_scene(width, height, 8 * bytes, Marking::zero, filter);
        const StoredPlane plane = store_plane(width, height, stored, {.bytes_per_sample = bytes});
        SurfaceFrame reference, cpu, lazy;
        ASSERT_TRUE(make_reference_builder(scene)->build(plane.frame(), reference));
        ASSERT_TRUE(make_cpu_builder(scene)->build(plane.frame(), cpu));
        ASSERT_TRUE(make_lazy_builder(scene)->build(plane.frame(), lazy));
        EXPECT_EQ(reference.codes, expected);
        EXPECT_EQ(cpu.codes, expected);
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const std::uint16_t code = expected[reference.index(x, y)];
                EXPECT_EQ(reference.is_valid(x, y), code != 0) << x << ", " << y;
                EXPECT_EQ(cpu.is_valid(x, y), code != 0) << x << ", " << y;
                EXPECT_EQ(lazy.vertices->at(x, y).valid, code != 0) << x << ", " << y;
                if (code == 0) continue;
                EXPECT_EQ(lazy.vertices->at(x, y).depth, scene.depth.depth(code)) << x << ", " << y;
            }
    }
}

TEST(Median, TakesLowerOfEvenCount) {
    // At (0, 0), for example: 10 10 20 / 10 10 20 / 40 40 -, sorted 10 10 10 10 20 20 40 40, element 7/2
    // is 10.
    expect_filtered(3, 3,
                    {10, 20, 30,  //
                     40, 0, 60,   //
                     70, 80, 90},
                    {.median = 3},
                    {10, 20, 30,  //
                     40, 0, 60,   //
                     70, 70, 80});
}

TEST(Median, ReplicatesBorderPixels) {
    expect_filtered(5, 1, {9, 1, 8, 2, 7}, {.median = 5}, {9, 8, 7, 7, 7});
    expect_filtered(5, 1, {9, 1, 0, 2, 7}, {.median = 5}, {9, 2, 0, 2, 7});
    // At (1, 0): columns 0, 1 and 2, of which column 0 is an invalid border pixel three times over.
    expect_filtered(3, 1, {0, 4, 6}, {.median = 3}, {0, 4, 6});
}

TEST(Median, KeepsSinglePixel) {
    expect_filtered(1, 1, {42}, {.median = 5}, {42});
    expect_filtered(1, 1, {0}, {.median = 5, .fill_holes = 16}, {0});
}

TEST(Median, RemovesSpikeAndKeepsEdge) {
    expect_filtered(5, 3,
                    {10, 10, 10, 50, 50,  //
                     10, 99, 10, 50, 50,  //
                     10, 10, 10, 50, 50},
                    {.median = 3},
                    {10, 10, 10, 50, 50,  //
                     10, 10, 10, 50, 50,  //
                     10, 10, 10, 50, 50});
}

// One rim at a time: a pixel is filled from what was valid before the pass, and neighbours beyond the edge do
// not count, so (1, 0) with two valid neighbours has to wait for (1, 1), whose neighbours 3 5 7 9 give 5.
TEST(HoleFilling, ReadsStateBeforePass) {
    const Codes stored = {5, 0, 0, 0,  //
                          9, 0, 0, 0,  //
                          7, 3, 0, 0};
    expect_filtered(4, 3, stored, {.fill_holes = 0}, stored);
    expect_filtered(4, 3, stored, {.fill_holes = 1},
                    {5, 0, 0, 0,  //
                     9, 5, 0, 0,  //
                     7, 3, 0, 0});
    expect_filtered(4, 3, stored, {.fill_holes = 2},
                    {5, 5, 0, 0,  //
                     9, 5, 0, 0,  //
                     7, 3, 0, 0});
    expect_filtered(4, 3, stored, {.fill_holes = 3},
                    {5, 5, 0, 0,  //
                     9, 5, 5, 0,  //
                     7, 3, 0, 0});
}

TEST(HoleFilling, ComesBeforeTheMedian) {
    // The centre becomes 2, from 1 1 2 2 2 2 9 9. Had the median come first, the upper row would be 1 1 1.
    expect_filtered(3, 3,
                    {1, 9, 1,  //
                     2, 0, 2,  //
                     2, 2, 9},
                    {.median = 3, .fill_holes = 1},
                    {2, 2, 2,  //
                     2, 2, 2,  //
                     2, 2, 2});
}

TEST(HoleFilling, NeedsThreeValidNeighbours) {
    expect_filtered(3, 1, {4, 0, 6}, {.fill_holes = 16}, {4, 0, 6});
}

TEST(TileBounds, ShareVerticesBetweenTiles) {
    // 18 columns: the first tile has the vertices 0 to 16, the second 16 and 17.
    Codes stored(36, 100);
    stored[16] = 200;     // (16, 0): in both
    stored[18 + 3] = 50;  // (3, 1): in the first
    stored[18 + 17] = 0;  // (17, 1): in the second
    const Scene scene = depth_scene(18, 2, 16, Marking::zero);
    const StoredPlane plane = store_plane(18, 2, stored, {});
    for (const auto& builder : {make_reference_builder(scene), make_cpu_builder(scene)}) {
        SurfaceFrame frame;
        ASSERT_TRUE(builder->build(plane.frame(), frame));
        const std::vector<TileBounds> expected = {{50, 200, false}, {100, 200, true}};
        EXPECT_EQ(frame.tiles, expected) << builder->name();
    }
}

TEST(TileBounds, AreEmptyWithoutValidPixels) {
    const Scene scene = depth_scene(3, 3, 16, Marking::zero);
    const StoredPlane plane = store_plane(3, 3, Codes(9, 0), {});
    for (const auto& builder : {make_reference_builder(scene), make_cpu_builder(scene)}) {
        SurfaceFrame frame;
        ASSERT_TRUE(builder->build(plane.frame(), frame));
        EXPECT_EQ(frame.tiles, (std::vector<TileBounds>{{65535, 0, true}})) << builder->name();
    }
}

TEST(Decode, ZeroesInvalidCodes) {
    Scene scene =
        depth_scene(6, 1, 12, Marking::range_and_few);  // metric: 511 to 3840, but not 1365, 2047, 2048
    ASSERT_EQ(scene.depth.valid_min, 511);
    ASSERT_EQ(scene.depth.valid_max, 3840);
    const StoredPlane plane = store_plane(6, 1, {510, 511, 2047, 3840, 3841, 4096}, {});
    for (const auto& builder : {make_reference_builder(scene), make_cpu_builder(scene)}) {
        SurfaceFrame frame;
        ASSERT_TRUE(builder->build(plane.frame(), frame));
        EXPECT_EQ(frame.codes, (Codes{0, 511, 0, 3840, 0, 0})) << builder->name();
        EXPECT_EQ(frame.validity, (std::vector<std::uint32_t>{0b001010})) << builder->name();
    }
}

}  // namespace
}  // namespace touchable::test
