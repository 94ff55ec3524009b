// The panel that explains fingers in a picture.
#include "player/draw/legends.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "player/draw/finger_marks.hpp"

namespace touchable::test {
namespace {

Image grey(int width, int height) {
    Image image{width, height, 1, 3, {}};
    image.samples.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 100);
    return image;
}

bool has_colour(const Image& image, PackedColour colour) {
    for (std::size_t k = 0; k < image.samples.size(); k += 3)
        if (pack_colour(image.samples[k], image.samples[k + 1], image.samples[k + 2]) == colour) return true;
    return false;
}

TEST(Legend, TheScaleIsARoundNumberOfNewtonsThatFits) {
    EXPECT_DOUBLE_EQ(scale_newtons(50, 76), 1);
    EXPECT_DOUBLE_EQ(scale_newtons(30, 76), 2);
    EXPECT_DOUBLE_EQ(scale_newtons(15.2, 76), 5);
    EXPECT_DOUBLE_EQ(scale_newtons(800, 76), 0.05);
    EXPECT_DOUBLE_EQ(scale_newtons(0.3, 76), 200);
    for (double pixels = 0.01; pixels < 1e4; pixels *= 1.07) {
        const double length = scale_newtons(pixels, 76) * pixels;
        EXPECT_LE(length, 76 * (1 + 1e-12));
        EXPECT_GT(length, 76 / 2.6);
    }
}

TEST(Legend, NamesTheColoursOfTheFingersThatAreThere) {
    for (const std::size_t fingers : {1U, 5U, 10U, 200U}) {
        Image image = grey(1280, 720);
        ASSERT_TRUE(draw_legend({fingers, 60}, image));
        for (std::size_t k = 0; k < 10; ++k) EXPECT_EQ(has_colour(image, finger_colour(k)), k < fingers) << k;
    }
}

TEST(Legend, StaysInItsCornerAtEverySize) {
    for (const auto& [width, height] :
         {std::pair(480, 270), std::pair(1280, 720), std::pair(3840, 2160), std::pair(600, 1800)}) {
        Image image = grey(width, height);
        ASSERT_TRUE(draw_legend({10, 60}, image));
        EXPECT_FALSE(std::all_of(image.samples.begin(), image.samples.end(), [](int s) { return s == 100; }));
        for (int y = 0; y < height / 3; ++y) EXPECT_EQ(image.view().sample(5, y, 0), 100);
        for (int y = 0; y < height; ++y)
            for (const int x : {0, width - 1}) ASSERT_EQ(image.view().sample(x, y, 0), 100) << x << ", " << y;
    }
}

TEST(Legend, IsLeftOutWhereItWouldHideTheScene) {
    Image image = grey(479, 300);
    ASSERT_TRUE(draw_legend({3, 60}, image));
    EXPECT_EQ(image.samples, grey(479, 300).samples);
}

}  // namespace
}  // namespace touchable::test
