// What is said to be lost, by numbers worked out by hand.
#include "player/commands/convert_command.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "player/run/terminal.hpp"

namespace touchable::test {
namespace {

PlaneView row_of(const std::vector<std::uint8_t>& samples) {
    return {samples.data(), std::ssize(samples), static_cast<int>(samples.size()), 1, 1, 1};
}

TEST(PlaneLoss, IsTheLargestAndTheMeanSquareOfWhatDiffers) {
    Scene scene;
    scene.width = 4;
    scene.height = 1;
    scene.metres_per_unit = 0.01;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 2;
    scene.depth.far = 2 * 200;
    scene.depth.invalid_code_count = 1;  // 0
    derive_valid_range(scene.depth);
    const std::vector<std::uint8_t> before{10, 20, 0, 40}, now{13, 20, 7, 36}, gone{10, 0, 0, 40};
    RawFrame a, b, c;
    a.depth = row_of(before);
    b.depth = row_of(now);
    c.depth = row_of(gone);
    PlaneLosses losses{};
    add_loss(a, a, scene, losses);
    EXPECT_EQ(losses[0].samples, 4);
    EXPECT_EQ(losses[0].changed, 0);
    add_loss(a, b, scene, losses);
    EXPECT_EQ(losses[0].samples, 8);
    EXPECT_EQ(losses[0].changed, 3);
    EXPECT_EQ(losses[0].largest, 7);
    EXPECT_DOUBLE_EQ(losses[0].squares, 9 + 49 + 16);
    EXPECT_EQ(losses[0].pixels, 3);
    EXPECT_DOUBLE_EQ(losses[0].largest_metres, 4 * 2 * 0.01);
    EXPECT_DOUBLE_EQ(losses[0].squares_metres, (36 + 64) * 1e-4);
    EXPECT_EQ(losses[0].appeared, 1);
    EXPECT_EQ(losses[0].disappeared, 0);
    add_loss(a, c, scene, losses);
    EXPECT_EQ(losses[0].disappeared, 1);
}

TEST(PlaneLoss, OfASmallerPictureIsThatOfEachPixelBefore) {
    Scene scene;
    scene.depth.near = 1;
    scene.depth.far = 2;
    const std::vector<std::uint8_t> before{10, 20, 30, 44}, now{20, 44};
    RawFrame a, b;
    a.depth = row_of(before);
    b.depth = row_of(now);
    PlaneLosses losses{};
    add_loss(a, b, scene, losses);
    EXPECT_EQ(losses[0].changed, 2);
    EXPECT_EQ(losses[0].largest, 14);
    EXPECT_DOUBLE_EQ(losses[0].rms(), std::sqrt((100 + 196) / 4.0));
}

TEST(Pace, IsToldInWholeWords) {
    EXPECT_EQ(pace_in_words(50, 100, 0.9), "");
    EXPECT_EQ(pace_in_words(0, 100, 2), "");
    EXPECT_EQ(pace_in_words(50, 100, 2), ", 25/s, 2 s left");
    EXPECT_EQ(pace_in_words(10, 100, 4), ", 2.5/s, 36 s left");
    EXPECT_EQ(pace_in_words(10, 1000, 10), ", 1.0/s, 17 min left");
    EXPECT_EQ(pace_in_words(10, 100'000, 10), ", 1.0/s, 28 h left");
    EXPECT_EQ(pace_in_words(50, 0, 2), ", 25/s");
    EXPECT_EQ(pace_in_words(100, 100, 2), ", 50/s");
}

}  // namespace
}  // namespace touchable::test
