#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "shaders/cut_rule.h"

namespace touchable {
namespace {

TEST(CutRule, ATriangleWithAnInvalidCornerIsCut) {
    EXPECT_TRUE(triangle_is_cut(0, 0, 0));
    EXPECT_TRUE(triangle_is_cut(0, 1, 1));
    EXPECT_TRUE(triangle_is_cut(1, 0, 1));
    EXPECT_TRUE(triangle_is_cut(1, 1, 0));
}

/// docs/drawing.md says so.
TEST(CutRule, DepthsMayDifferBySixPercentAndNoMore) {
    const float most = 1.06F * 0.01F;
    EXPECT_FALSE(triangle_is_cut(0.01F, most, 0.0105F));
    EXPECT_TRUE(triangle_is_cut(0.01F, std::nextafter(most, 1.0F), 0.0105F));
}

TEST(CutRule, TheOrderOfCornersDoesNotMatter) {
    for (const auto& corners : {std::array{1.0F, 1.03F, 1.059F}, std::array{1.0F, 1.03F, 1.061F}}) {
        std::array<int, 3> order{0, 1, 2};
        const bool expected = triangle_is_cut(corners[0], corners[1], corners[2]);
        do {
            auto q = [&](std::size_t k) { return corners[static_cast<std::size_t>(order[k])]; };
            EXPECT_EQ(triangle_is_cut(q(0), q(1), q(2)), expected);
        } while (std::next_permutation(order.begin(), order.end()));
    }
}

TEST(CutRule, ScaleDoesNotMatter) {
    for (const float scale : {1e-6F, 1.0F, 1e6F}) {
        EXPECT_FALSE(triangle_is_cut(scale, 1.05F * scale, scale));
        EXPECT_TRUE(triangle_is_cut(scale, 1.07F * scale, scale));
    }
}

TEST(CutRule, OfTheClipsOwnViewLeavesOutHolesAlone) {
    EXPECT_TRUE(triangle_has_hole(0, 1, 1));
    EXPECT_TRUE(triangle_has_hole(1, 0, 1));
    EXPECT_TRUE(triangle_has_hole(1, 1, 0));
    EXPECT_FALSE(triangle_has_hole(1, 0.01F, 100));
}

}  // namespace
}  // namespace touchable
