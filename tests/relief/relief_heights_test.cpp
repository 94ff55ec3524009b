// Heights of a clip, frame after frame: steady where nothing moves, and quick where something does.
#include "engine/authoring/relief_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int pixels = 400;

/// About normal: a sum of four even ones, each of that width.
std::int32_t noise(Numbers& numbers, int deviation) {
    std::int32_t sum = 0;
    for (int k = 0; k < 4; ++k) sum += numbers.below(2 * deviation + 1) - deviation;
    return sum * 87 / 100;  // 4 (2d)^2/12 is 1.33 d^2
}

TEST(ReliefHeights, AreLevelInTheMiddleAndReachTheEnds) {
    NumberField relief(3, 1);
    relief.numbers = {0, 500, -500};
    EXPECT_EQ(ReliefHeights({500, 0}, 100).next(relief), (std::vector<std::uint8_t>{128, 255, 1}));
    EXPECT_EQ(ReliefHeights({1000, 0}, 100).next(relief), (std::vector<std::uint8_t>{128, 192, 65}));
    EXPECT_EQ(ReliefHeights({1000, 0}, 400).next(relief), (std::vector<std::uint8_t>{128, 255, 0}));
    EXPECT_EQ(ReliefHeights({500, 0}, 0).next(relief), (std::vector<std::uint8_t>{128, 128, 128}));
}

/// The target of the issue: a still point of a still camera flickers by a level at most.
TEST(ReliefHeights, OfAStillPointFlickerByALevelAtMost) {
    constexpr int deviation = 16, full = 16 * 36;  // a level of brightness, as much detail as castel's
    Numbers numbers(5);
    NumberField truth(pixels, 1), seen = truth;
    for (auto& number : truth.numbers) number = numbers.below(2 * full + 1) - full;
    ReliefHeights heights({full, deviation}, 100);
    std::vector<std::uint8_t> least(pixels, 255), most(pixels, 0), plain_least = least, plain_most = most;
    ReliefHeights unsteady({full, 0}, 100);
    for (int frame = 0; frame < 90; ++frame) {
        for (std::size_t k = 0; k < pixels; ++k)
            seen.numbers[k] = truth.numbers[k] + noise(numbers, deviation);
        const auto steady = heights.next(seen), plain = unsteady.next(seen);
        if (frame < 30) continue;  // the first frame is noise too
        for (std::size_t k = 0; k < pixels; ++k) {
            least[k] = std::min(least[k], steady[k]);
            most[k] = std::max(most[k], steady[k]);
            plain_least[k] = std::min(plain_least[k], plain[k]);
            plain_most[k] = std::max(plain_most[k], plain[k]);
        }
    }
    int flicker = 0, plain_flicker = 0;
    double error = 0;
    for (std::size_t k = 0; k < pixels; ++k) {
        flicker += most[k] - least[k];
        plain_flicker += plain_most[k] - plain_least[k];
        error += std::abs((most[k] + least[k]) / 2.0 - (128 + 127.0 * truth.numbers[k] / full));
    }
    EXPECT_GT(plain_flicker, 10 * pixels);
    EXPECT_LE(flicker, 4 * pixels) << "mean range over 60 frames";
    EXPECT_LT(error / pixels, 1.5);
    // As the clip's note says it, of all frames.
    const auto told = heights.flicker();
    ASSERT_TRUE(told);
    EXPECT_LT(told->mean, 0.25);
    EXPECT_LT(told->more_than_one, 0.01);
}

TEST(ReliefHeights, OfOneFrameNothingIsSaidOfFlicker) {
    ReliefHeights heights({16, 4}, 100);
    heights.next(NumberField(8, 1));
    EXPECT_FALSE(heights.flicker());
    heights.next(NumberField(8, 1));
    ASSERT_TRUE(heights.flicker());
    EXPECT_EQ(heights.flicker()->mean, 0);
}

TEST(ReliefHeights, FollowWhatMovesAtOnceAndWhatChangesALittleInTime) {
    NumberField relief(1, 1);
    ReliefHeights heights({1000, 10}, 100);
    EXPECT_EQ(heights.next(relief)[0], 128);
    relief.numbers[0] = 500;
    EXPECT_EQ(heights.next(relief)[0], 192);
    relief.numbers[0] = 480;  // twice the noise
    EXPECT_GT(heights.next(relief)[0], 189);
    for (int frame = 0; frame < 30; ++frame) heights.next(relief);
    EXPECT_NEAR(heights.next(relief)[0], 189, 1);
    heights.forget();
    relief.numbers[0] = 470;
    EXPECT_EQ(heights.next(relief)[0], 188);
}

TEST(ReliefEstimator, TakesThePercentilesOfAllFrames) {
    NumberField weights(pixels, 1), relief = weights;
    weights.numbers.assign(pixels, DifferenceOfGaussians::most_weight);
    Numbers numbers(9);
    ReliefEstimator estimator;
    EXPECT_EQ(estimator.range().full, 1);
    for (int frame = 0; frame < 40; ++frame) {
        for (std::size_t k = 0; k < pixels; ++k)
            relief.numbers[k] = static_cast<std::int32_t>(k) + noise(numbers, 8);
        weights.numbers[399] = 0;  // does not count, whatever it is
        relief.numbers[399] = 30000;
        estimator.add(relief, weights, frame > 0);
    }
    EXPECT_NEAR(estimator.range().full, 396, 8);
    EXPECT_NEAR(estimator.range().noise.value_or(-1), 8, 2);
}

}  // namespace
}  // namespace touchable::test
