// From which measurement on each filter is chosen, and how strong: the numbers of docs/scene_file.md, Filters
// that are left out.
#include "engine/surface/depth_estimator.hpp"

#include <gtest/gtest.h>

#include "engine/scene/filter_codes.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

/// 1 mm a code, a pixel at the median depth of 1000 mm is 2 mm wide, the picture 640 mm.
constexpr double median_mm = 1000, pixel_mm = 2;
constexpr int columns = 320;

Scene open_scene() {
    Scene scene;
    scene.width = columns;
    scene.height = 240;
    scene.camera = {500, 500, 159.5, 119.5};
    scene.depth_bits = 16;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 1;
    scene.depth.far = 4000;
    scene.depth.code_max = 4000;
    scene.depth.invalid_code_count = 1;
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

TEST(ChosenFilters, NoneWhereACamerasDepthIsCleanEverywhere) {
    EXPECT_EQ(chosen_by(of_a_camera()), FilterSettings{});
}

// 0.15 of a pixel's width is 0.3 mm.
TEST(ChosenFilters, AMedianFromARoughnessOf15HundredthsOfAPixelOn) {
    MeasuredDepth measured = of_a_camera();
    measured.roughness = 0.299;
    EXPECT_EQ(chosen_by(measured).median, 0);
    measured.roughness = 0.301;
    EXPECT_EQ(chosen_by(measured).median, 3) << "codes are 1 mm apart";
    measured.dropouts = 0;
    EXPECT_EQ(chosen_by(measured).median, 0) << "no camera";
}

TEST(ChosenFilters, TheMedianIsSmallWhereLevelsAreOneAndAHalfTimesTheNoiseOrRoughnessApart) {
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
TEST(ChosenFilters, TheTemporalFilterFromANoiseOfATenThousandthOfThePicturesWidthOn) {
    MeasuredDepth measured = of_a_camera();
    measured.noise = {0.03, 0.0339 / (median_mm * median_mm)};
    EXPECT_FALSE(chosen_by(measured).temporal);
    measured.noise = {0.03, 0.0341 / (median_mm * median_mm)};
    EXPECT_TRUE(chosen_by(measured).temporal);
    EXPECT_EQ(chosen_by(measured).temporal_noise.constant, 0.9 * 0.03);
    EXPECT_NEAR(chosen_by(measured).temporal_noise.at(median_mm), 0.9 * 0.0641, 1e-12);
}

// A gate is twice the noise that the median leaves, and that of no median the most.
TEST(ChosenFilters, TheTemporalFilterIsToldMoreOfTheNoiseAfterAMedian) {
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

// Those that were tried, where the scene states neither of the two filters.
TEST(ChosenFilters, TheMildestOfTheBestThatWereTriedOnTheRecording) {
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
    // Where the scene states that nothing is averaged, what was tried without averaging counts.
    scene = open_scene();
    unstated = all_unstated;
    unstated.temporal = false;
    choose_filters(measured, unstated, scene);
    EXPECT_FALSE(scene.filter.temporal);
    EXPECT_EQ(scene.filter.median, 3);
}

TEST(ChosenFilters, TwoPassesOfHoleFillingFromATenThousandthOfTinyHolesOn) {
    MeasuredDepth measured = of_a_camera();
    measured.tiny_holes = 0.0000999;
    EXPECT_EQ(chosen_by(measured).fill_holes, 0);
    measured.tiny_holes = 0.0001;
    EXPECT_EQ(chosen_by(measured).fill_holes, 2);
}

TEST(ChosenFilters, FlyingPixelsLandFromATenThousandthOfThemOn) {
    MeasuredDepth measured = of_a_camera();
    measured.flying = 0.0000999;
    EXPECT_EQ(chosen_by(measured).flying_pixels, DepthLength{});
    measured.flying = 0.0001;
    EXPECT_NE(chosen_by(measured).flying_pixels, DepthLength{});
}

// Of depth that shows nothing of a camera: a phone's, or a rendered one's.
TEST(ChosenFilters, FlyingPixelsOfOthersLandFromATenThousandthMidwayWhereEdgesAreNotClean) {
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
TEST(ChosenFilters, TenPixelsWidthsOrTwoLevelsAreOneSurfaceToFlyingPixelsOfOthers) {
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
TEST(ChosenFilters, AFiftiethOfTheDepthOrThreeTimesTheNoiseIsOneSurfaceToFlyingPixels) {
    MeasuredDepth measured = of_a_camera();
    measured.flying = 0.01;
    for (const auto& [noise, length] : {std::pair{6.6, 20.0}, {6.7, 20.1}, {10.0, 30.0}}) {
        measured.noise.constant = noise;
        const DepthLength flat = chosen_by(measured).flying_pixels;
        EXPECT_NEAR(flat.at(median_mm), length, 1e-9);
        EXPECT_NEAR((flat.at(median_mm + 1) - flat.at(median_mm - 1)) / 2, length / median_mm, 1e-9);
    }
}

TEST(ChosenFilters, TerracesGoFromAKappaOfAQuarterOn) {
    MeasuredDepth measured = of_a_camera();
    measured.levels = {0, 3e-6};
    measured.kappa = 0.2499;
    EXPECT_EQ(chosen_by(measured).terraces, TerraceRemoval::off);
    EXPECT_EQ(chosen_by(measured).levels, DepthLength{});
    measured.kappa = 0.25;
    EXPECT_EQ(chosen_by(measured).terraces, TerraceRemoval::on);
    EXPECT_EQ(chosen_by(measured).levels, measured.levels);
}

TEST(ChosenFilters, TerracesStayWhereLevelsLeaveNoRoom) {
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

// Whatever was measured: all of it asks for a filter here.
TEST(ChosenFilters, EachThatTheSceneStatesStays) {
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

TEST(ChosenFilters, AutomaticTerracesGoByWhatIsMeasured) {
    for (const bool is_measured : {false, true}) {
        Scene scene = open_scene();
        scene.filter.terraces = TerraceRemoval::automatic;
        MeasuredDepth measured = of_a_camera();
        measured.kappa = 1;
        choose_filters(is_measured ? std::optional(measured) : std::nullopt, {}, scene);
        EXPECT_EQ(scene.filter.terraces, is_measured ? TerraceRemoval::on : TerraceRemoval::off);
    }
}

TEST(ChosenFilters, NoiseThatTheSceneStatesIsKept) {
    Scene scene = open_scene();
    scene.filter.temporal_noise = {0.7, 0};
    MeasuredDepth measured = of_a_camera();
    measured.noise = {2, 0};
    choose_filters(measured, all_unstated, scene);
    EXPECT_TRUE(scene.filter.temporal);
    EXPECT_EQ(scene.filter.temporal_noise, (DepthLength{0.7, 0}));
}

}  // namespace
}  // namespace touchable::test
