// How wide and how high terraces are, worked out by hand, and what is chosen by it.
#include "engine/surface/estimators.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "engine/formats/open_clip.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "tests/real_data.hpp"
#include "tests/surface/pictures.hpp"

namespace touchable::test {
namespace {

using CodeAt = std::function<int(int x, int y)>;

CodePicture coded(int width, int height, const CodeAt& code) {
    CodePicture made{width, height, {}};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) made.codes.push_back(code(x, y));
    return made;
}

Contours contours_of(const CodePicture& picture) {
    ContourEstimator estimator;
    estimator.add(picture);
    return estimator.contours();
}

// Columns are of one code, so without steps. Rows: eight treads, of which six have steps at both ends.
TEST(Contours, OfStairsAreAsWideAndHighAsTheseAre) {
    for (const int tread : {8, 20, 50, 90})
        for (const int step : {1, 4}) {
            const Contours found =
                contours_of(coded(8 * tread, 16, [&](int x, int) { return 100 + step * (x / tread); }));
            EXPECT_EQ(found, (Contours{tread, step}));
        }
}

TEST(Contours, AreFoundAcrossShortRampsToo) {
    // 100, ..., 100, 101, 102, 103, 104, ..., 104: three pixels of ramp before each tread of 57.
    const Contours found = contours_of(coded(600, 8, [](int x, int) {
        const int n = x % 60;
        return 100 + 4 * (x / 60) + (n < 57 ? 0 : n - 56);
    }));
    EXPECT_EQ(found.height, 4);
    EXPECT_EQ(found.width, 57);
}

TEST(Contours, WhatIsFlatBetweenSilhouettesIsNoTerrace) {
    // A stair of 12 pixels between two walls of 200.
    const Contours found = contours_of(coded(520, 8, [](int x, int) {
        return x < 200 ? 20 : x >= 320 ? 220 : 100 + (x - 200) / 12;
    }));
    EXPECT_EQ(found, (Contours{12, 1}));
    EXPECT_EQ(contours_of(coded(300, 40, [](int, int) { return 7; })), Contours{});
}

TEST(Contours, AFewFlatThingsAreNoSlope) {
    const auto halves = [](int x, int) { return x < 200 ? 100 : 140; };
    const auto card = [](int x, int y) { return x > 129 && x < 270 && y > 79 && y < 220 ? 140 : 100; };
    const auto one_behind_the_other = [](int x, int) { return 100 + 30 * (x / 160); };  // 100, 130, 160
    for (const CodeAt& things : {CodeAt(halves), CodeAt(card), CodeAt(one_behind_the_other)}) {
        const Contours found = contours_of(coded(400, 300, things));
        EXPECT_EQ(found.width, 0);
        EXPECT_EQ(found.reach(), 16);
    }
}

TEST(Contours, HolesAreNoSteps) {
    EXPECT_EQ(contours_of(coded(
                  400, 8, [](int x, int) { return x % 50 == 0 ? CodePicture::invalid : 100 + x / 50; })),
              Contours{});
}

TEST(Contours, OfWhatHasNoTreadsHaveNoWidth) {
    const Contours found = contours_of(coded(400, 40, [](int x, int y) { return 100 + x / 3 + y / 5; }));
    EXPECT_FALSE(found.are_wide());
    EXPECT_EQ(found.reach(), 16);
}

TEST(Contours, AreWideFrom33PixelsOnAndReachedUpTo128) {
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

TEST(ChosenReach, OfWideTerracesIsWideAndOfOthersAsItWas) {
    EXPECT_EQ(chosen_for(phone(90, 1)).terrace_reach, 128);
    EXPECT_EQ(chosen_for(phone(44, 1)).terrace_reach, 64);
    EXPECT_EQ(chosen_for(phone(90, 1)).levels, DepthLength{});
    EXPECT_EQ(chosen_for(phone(9, 1)).terrace_reach, 16);
    EXPECT_EQ(chosen_for(phone(90, 1)).terraces, TerraceRemoval::on);
}

TEST(ChosenReach, StatedRemovalIsAsItWasUnlessItsReachIsOpen) {
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

FilterSettings chosen_of_recording(const std::filesystem::path& file) {
    auto clip = open_clip(file);
    EXPECT_TRUE(clip) << clip.error().message;
    Scene scene = (*clip)->scene();
    DepthEstimator estimator(scene);
    while (!estimator.enough()) {
        const auto frame = (*clip)->next();
        if (!frame || !*frame) break;
        estimator.add(**frame);
    }
    choose_filters(estimator.measured(), all_unstated, scene);
    return scene.filter;
}

class PhonePictures : public testing::TestWithParam<const char*> {};

TEST_P(PhonePictures, HaveWideTerracesOfFourCodes) {
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

TEST_P(OtherRecordings, KeepTheReachThatTheyHad) {
    const auto file = real_data(GetParam());
    TOUCHABLE_NEEDS_DATA(file);
    EXPECT_EQ(chosen_of_recording(file).terrace_reach, 16);
}
INSTANTIATE_TEST_SUITE_P(Recordings, OtherRecordings,
                         testing::Values("stills/redwood5", "stills/icl_nuim5", "stills/midas_moon/moon.png",
                                         "castel_sr300", "visp_cube_realsense", "depthkit_typing/Test.mov"),
                         [](const auto& test) { return "Number" + std::to_string(test.index); });

}  // namespace
}  // namespace touchable::test
