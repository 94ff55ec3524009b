#include "player/window/window_picture.hpp"

#include <gtest/gtest.h>

#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

TEST(WordsScale, GrowsWithTheWindowInStepsOfAQuarter) {
    EXPECT_EQ(words_scale({640, 400, 1}, false), 1);
    EXPECT_EQ(words_scale({1280, 720, 1}, false), 1);
    EXPECT_EQ(words_scale({1500, 800, 1}, false), 1);
    EXPECT_EQ(words_scale({1920, 1080, 1}, false), 1.25);
    EXPECT_EQ(words_scale({2560, 1440, 1}, false), 1.5);
    EXPECT_EQ(words_scale({3840, 2160, 1}, false), 1.75);
    EXPECT_EQ(words_scale({2560, 720, 1}, false), 1) << "there is no more room from top to bottom";
}

TEST(WordsScale, IsTheDisplaysWhereTheWindowIsNoLargerThanUsual) {
    EXPECT_EQ(words_scale({960, 600, 2}, false), 2);
    EXPECT_EQ(words_scale({2560, 1440, 2}, false), 2);
    EXPECT_EQ(words_scale({3840, 2160, 2}, false), 2.5);
}

TEST(WordsScale, ForVisitorsKeepsTheirShareOfTheScreen) {
    EXPECT_EQ(words_scale({1280, 720, 1}, true), 1);
    EXPECT_EQ(words_scale({1920, 1080, 1}, true), 1.5);
    EXPECT_EQ(words_scale({2560, 1440, 1}, true), 2);
    EXPECT_EQ(words_scale({3840, 2160, 2}, true), 3);
    EXPECT_EQ(words_scale({7680, 4320, 1}, true), 4);
}

/// Rows of the bar's dark ground in the picture's middle column.
int bar_height(const Image& image) {
    int rows = 0;
    for (int y = image.height / 2; y < image.height; ++y) {
        const auto k = static_cast<std::size_t>((y * image.width + image.width / 2) * 3);
        rows += image.samples[k] < 90 && image.samples[k + 1] < 90;
    }
    return rows;
}

TEST(WordsScale, OfAWindowThatGrowsFollowsUnlessItIsStated) {
    const std::string clip = made_clip("bumps", 1).string(), grown = "0.2 size 1920x1080\n0.5 move 20 20\n";
    const auto height = [&](const std::vector<std::string>& words, const std::string& script) {
        return bar_height(played_by(words, script, "0.9").image);
    };
    const int usual = height({clip, "--scale", "1"}, grown);
    EXPECT_GT(usual, 20);
    EXPECT_NEAR(height({clip}, grown), 1.25 * usual, 2);
    EXPECT_NEAR(height({clip}, grown + "0.6 size 1280x720\n"), usual, 2) << "and back";
}

}  // namespace
}  // namespace touchable::test
