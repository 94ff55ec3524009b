#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/scene/frames.hpp"

namespace touchable {
namespace {

/// The hue of HSV in turns, 0 to below 1, as textbooks have it.
double hue_of(int r, int g, int b) {
    const int most = std::max({r, g, b}), chroma = most - std::min({r, g, b});
    if (chroma == 0) return 0;
    double sixths = 0;
    if (most == r)
        sixths = static_cast<double>(g - b) / chroma;
    else if (most == g)
        sixths = 2 + static_cast<double>(b - r) / chroma;
    else
        sixths = 4 + static_cast<double>(r - g) / chroma;
    return (sixths < 0 ? sixths + 6 : sixths) / 6;
}

template <class Check>
void for_every_colour(Check&& check) {
    for (int r = 0; r < 256; ++r)
        for (int g = 0; g < 256; ++g)
            for (int b = 0; b < 256; ++b) check(r, g, b);
}

uint code_of(int r, int g, int b) {
    return hue_code(static_cast<uint>(r), static_cast<uint>(g), static_cast<uint>(b));
}

TEST(HueCode, OfEveryColourIsItsHueToHalfACode) {
    double worst = 0;
    uint largest = 0;
    for_every_colour([&](int r, int g, int b) {
        const uint code = code_of(r, g, b);
        largest = std::max(largest, code);
        worst = std::max(worst, std::fabs(hue_of(r, g, b) * 1536 - code));
    });
    EXPECT_LE(worst, 0.5);
    EXPECT_GT(worst, 0.49);  // or the formula above says nothing
    EXPECT_EQ(largest, 1535U);
}

TEST(HueCode, EveryCodeIsSomeColours) {
    std::vector<bool> met(1536);
    for_every_colour([&](int r, int g, int b) { met[code_of(r, g, b)] = true; });
    EXPECT_EQ(std::count(met.begin(), met.end(), true), 1536);
}

TEST(HueCode, FullySaturatedHuesAllDiffer) {
    // The way round the colour cube's edges, one step of one byte at a time.
    std::array<int, 3> colour{255, 0, 0};
    constexpr std::array<std::array<int, 2>, 6> legs{{{1, 1}, {0, -1}, {2, 1}, {1, -1}, {0, 1}, {2, -1}}};
    uint before = code_of(255, 0, 0);
    EXPECT_EQ(before, 0U);
    for (const auto& [channel, step] : legs)
        for (int k = 0; k < 255; ++k) {
            colour[static_cast<std::size_t>(channel)] += step;
            const uint code = code_of(colour[0], colour[1], colour[2]);
            if (colour == std::array<int, 3>{255, 0, 0}) {
                EXPECT_EQ(code, 0U);  // round the circle
                EXPECT_EQ(before, 1535U);
                return;
            }
            ASSERT_GT(code, before);
            ASSERT_LE(code, before + 2);
            before = code;
        }
    FAIL() << "never came back to red";
}

TEST(HueCode, SectorsMeetWithoutAStep) {
    // Where two channels are equal, both sectors' formulas must say the same; a step to either side moves the
    // code by no more than the step in hue.
    for (int most = 1; most < 256; ++most)
        for (int least = 0; least < most; ++least) {
            ASSERT_EQ(code_of(most, least, least), 0U);
            ASSERT_EQ(code_of(most, most, least), 256U);
            ASSERT_EQ(code_of(least, most, least), 512U);
            ASSERT_EQ(code_of(least, most, most), 768U);
            ASSERT_EQ(code_of(least, least, most), 1024U);
            ASSERT_EQ(code_of(most, least, most), 1280U);
        }
}

TEST(HueCode, AColourIsValidFromItsLeastSumOnUnlessItIsGrey) {
    for (const int least_sum : {0, 1, 77, 400, 765})
        for_every_colour([&](int r, int g, int b) {
            if ((r + 3 * g + 7 * b) % 5 != 0 && r + g + b != least_sum) return;  // a fifth, and the limit
            const bool grey = r == g && g == b;
            ASSERT_EQ(hue_is_valid(static_cast<uint>(r), static_cast<uint>(g), static_cast<uint>(b),
                                   static_cast<uint>(least_sum)),
                      r + g + b >= least_sum && !grey)
                << r << " " << g << " " << b;
        });
}

TEST(StoredCode, IsTheHueOfThreeChannelsAndElseTheValueAsStored) {
    const std::vector<std::uint8_t> samples{9, 9, 9, 0, 255, 0, 25, 26, 25, 26, 26, 25, 0xEE, 0xEE};
    const PlaneView rgb{samples.data(), 14, 4, 1, 1, 3};
    DepthCoding coding;
    coding.kind = DepthCodingKind::hue;
    coding.near = 1;
    coding.far = 2;
    coding.near_is_high = false;
    coding.code_max = DepthCoding::hue_circle;
    coding.least_sum = 77;
    derive_valid_range(coding);
    EXPECT_EQ(stored_code(rgb, coding, 0, 0), no_hue);  // grey
    EXPECT_EQ(stored_code(rgb, coding, 1, 0), 512);
    EXPECT_EQ(stored_code(rgb, coding, 2, 0), no_hue);  // 76: too dark
    EXPECT_EQ(stored_code(rgb, coding, 3, 0), 256);     // 77
    EXPECT_FALSE(coding.is_valid(no_hue));
    EXPECT_DOUBLE_EQ(coding.depth(512), 1 + 1 / 3.0);
    coding.kind = DepthCodingKind::linear;
    const PlaneView wide{samples.data(), 14, 2, 1, 2, 1};
    EXPECT_EQ(stored_code(wide, coding, 1, 0), wide.sample(1, 0));
}

}  // namespace
}  // namespace touchable
