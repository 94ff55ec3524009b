// What of a picture becomes relief, and where there is none.
#include "engine/authoring/relief_filter.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <vector>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int width = 96, height = 64;

/// A grey picture over depths, both by column and row.
class ReliefOf : public ::testing::Test {
protected:
    template <class Grey, class Code>
    const NumberField& relief(Grey&& grey, Code&& code, const ReliefSettings& settings = {}) {
        colour_.clear();
        depth_.clear();
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                for (int channel = 0; channel < 3; ++channel)
                    colour_.push_back(static_cast<std::uint8_t>(grey(x, y)));
                depth_.push_back(static_cast<std::uint8_t>(code(x, y)));
            }
        RawFrame frame;
        frame.depth = {depth_.data(), width, width, height, 1, 1};
        frame.colour = {colour_.data(), 3 * width, width, height, 1, 3};
        filter_ = std::make_unique<ReliefFilter>(settings, coding_);
        return filter_->apply(frame);
    }
    static int even(int, int) { return 120; }
    static int spot(int x, int y) { return std::abs(x - 48) <= 2 && std::abs(y - 32) <= 2 ? 160 : 110; }

    const DepthCoding coding_ = small_scene(width, height).depth;
    std::vector<std::uint8_t> colour_, depth_;
    std::unique_ptr<ReliefFilter> filter_;
};

TEST_F(ReliefOf, WhatIsBrightStandsOutAndWhatIsEvenDoesNot) {
    for (const std::int32_t number : relief(even, even).numbers) EXPECT_EQ(number, 0);
    const NumberField& raised = relief(spot, even);
    EXPECT_GT(raised.row(32)[48], 16 * 20);
    EXPECT_LT(raised.row(32)[54], 0);
    ReliefSettings inverted;
    inverted.invert = true;
    const std::int32_t before = raised.row(32)[48];
    EXPECT_EQ(relief(spot, even, inverted).row(32)[48], -before);
}

TEST_F(ReliefOf, BandsAddUpByTheirShares) {
    std::int32_t sum = 0;
    for (int band = 0; band < DifferenceOfGaussians::bands; ++band) {
        ReliefSettings one{{0, 0, 0}};
        one.bands[static_cast<std::size_t>(band)] = 100;
        sum += relief(spot, even, one).row(32)[48];
    }
    EXPECT_EQ(relief(spot, even, {{100, 100, 100}}).row(32)[48], sum);
    EXPECT_NEAR(relief(spot, even, {{200, 200, 200}}).row(32)[48], 2 * sum, 2);
}

TEST_F(ReliefOf, NothingIsFeltOfAColourThatChangesWithASurface) {
    const auto half = [](int x, int) { return x < 48 ? 90 : 180; };
    const auto step = [](int x, int) { return x < 48 ? 128 : 60; };
    const NumberField& one_surface = relief(half, even);
    EXPECT_GT(one_surface.row(32)[48], 16 * 10);
    for (const std::int32_t number : relief(half, step).numbers) EXPECT_LE(std::abs(number), 1);
}

/// Grey of 128 stands for it; any other grey is a colour.
TEST_F(ReliefOf, WhatTheColourCameraDoesNotSeeHasNone) {
    const auto half_seen = [](int x, int) { return x < 48 ? 128 : 90; };
    const auto half_grey = [](int x, int) { return x < 48 ? 127 : 90; };
    for (const std::int32_t number : relief(half_seen, even).numbers) EXPECT_EQ(number, 0);
    EXPECT_GT(relief(half_grey, even).row(32)[47], 16 * 3);
}

TEST_F(ReliefOf, ShadowsHighlightsAndHolesHaveNone) {
    const auto in_the_dark = [](int x, int y) { return spot(x, y) == 160 ? 5 : 0; };
    const auto overexposed = [](int x, int y) { return spot(x, y) == 160 ? 255 : 253; };
    for (const std::int32_t number : relief(in_the_dark, even).numbers) EXPECT_EQ(number, 0);
    for (const std::int32_t number : relief(overexposed, even).numbers) EXPECT_EQ(number, 0);
    DepthCoding coding = coding_;
    coding.invalid_codes[0] = 0;
    coding.invalid_code_count = 1;
    const auto with_hole = [](int x, int y) { return x > 30 && x < 66 && y > 14 && y < 50 ? 0 : 128; };
    relief(spot, with_hole);
    ReliefFilter filter({}, coding);
    RawFrame frame;
    frame.depth = {depth_.data(), width, width, height, 1, 1};
    frame.colour = {colour_.data(), 3 * width, width, height, 1, 3};
    EXPECT_EQ(filter.apply(frame).row(32)[48], 0);
    EXPECT_EQ(filter.confidence().row(32)[48], 0);
}

}  // namespace
}  // namespace touchable::test
