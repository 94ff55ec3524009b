#include "player/draw/legends.hpp"
#include "player/draw/overlays.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace touchable::test {
namespace {

Image even_image(int width, int height) {
    Image image{width, height, 1, 3, {}};
    image.samples.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height) * 3, 100);
    return image;
}

std::string joined(const std::vector<ScaleMark>& marks) {
    std::string words;
    for (const ScaleMark& mark : marks) words += mark.text + " ";
    return words;
}

TEST(ScaleBar, NamesRoundValuesAsManyAsFit) {
    const auto five = [](const auto& marks) { return marks.size() <= 5; };
    EXPECT_EQ(joined(scale_marks({64, 96}, five)), "70 80 90 ");
    EXPECT_EQ(joined(scale_marks({0, 0.55}, five)), "0.0 0.2 0.4 ");
    EXPECT_EQ(joined(scale_marks({-1, 1}, five)), "-1.0 -0.5 0.0 0.5 1.0 ");
    EXPECT_EQ(joined(scale_marks({1234.21, 1234.24}, five)), "1234.21 1234.22 1234.23 1234.24 ");
    EXPECT_EQ(scale_marks({3, 8}, [](const auto&) { return false; }).size(), 1U);
    for (double size = 1e-3; size < 1e6; size *= 1.37) {
        const Overlays::Range range{0.7 * size, 1.7 * size};
        const auto marks = scale_marks(range, five);
        EXPECT_GE(marks.size(), 2U) << size;
        for (const ScaleMark& mark : marks) {
            EXPECT_GE(mark.value, range.least * (1 - 1e-6));
            EXPECT_LE(mark.value, range.greatest * (1 + 1e-6));
            EXPECT_NEAR(std::stod(mark.text), mark.value, 1e-6 * size);
        }
    }
}

bool shows(const Image& image, PackedColour colour) {
    for (std::size_t k = 0; k < image.samples.size(); k += 3)
        if (pack_colour(image.samples[k], image.samples[k + 1], image.samples[k + 2]) == colour) return true;
    return false;
}

TEST(ScaleBar, ShowsItsColours) {
    Overlays::Scale scale{.name = "depth", .unit = "mm", .range = {64, 96}, .least_is_light = true};
    Image image = even_image(1280, 720);
    ASSERT_TRUE(draw_scale_bar(scale, image));
    for (std::size_t k = 0; k < 256; k += 5) EXPECT_TRUE(shows(image, colour_ramp()[k])) << k;
    image = even_image(1280, 720);
    scale.range = {3, 3};
    ASSERT_TRUE(draw_scale_bar(scale, image));
    EXPECT_TRUE(shows(image, ramp_colour(0.5)));
    EXPECT_FALSE(shows(image, ramp_colour(0)));
    image = even_image(1280, 720);
    scale.classes = {{pack_colour(1, 2, 3), "this"}, {pack_colour(250, 3, 4), "that"}};
    ASSERT_TRUE(draw_scale_bar(scale, image));
    for (const auto& one : scale.classes) EXPECT_TRUE(shows(image, one.colour));
}

TEST(ScaleBar, StaysInItsCornerAtEverySizeAndOutOfSmallPictures) {
    const Overlays::Scale scale{.name = "dynamic friction", .range = {-1234.5, 98765.4}};
    for (const auto& [width, height] :
         {std::pair(480, 270), std::pair(1280, 720), std::pair(3840, 2160), std::pair(600, 1800)}) {
        Image image = even_image(width, height);
        ASSERT_TRUE(draw_scale_bar(scale, image));
        EXPECT_FALSE(std::all_of(image.samples.begin(), image.samples.end(), [](int s) { return s == 100; }));
        for (int y = 0; y < height; ++y)
            for (const int x : {0, width / 5, width - 1})
                ASSERT_EQ(image.view().sample(x, y, 0), 100) << x << ", " << y;
        for (int x = 0; x < width; ++x)
            for (const int y : {0, height / 2, height - 1})
                ASSERT_EQ(image.view().sample(x, y, 0), 100) << x << ", " << y;
    }
    Image small = even_image(479, 300);
    ASSERT_TRUE(draw_scale_bar(scale, small));
    EXPECT_EQ(small.samples, even_image(479, 300).samples);
}

}  // namespace
}  // namespace touchable::test
