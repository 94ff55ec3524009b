// Where edges of colour are, against edges of depth that are known.
#include "engine/authoring/quality_estimators.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int width = 640, height = 480;

/// Boxes before a wall. Their colour is moved, and smaller or larger than they are.
class ColourEdgesOf : public ::testing::Test {
protected:
    /// `x`, `y`: 0 or more. `uneven_`: each is at another place of its square of 80 pixels, of
    /// another size.
    bool in_box(int x, int y, int larger = 0) const {
        const int square = x / 80 + 10 * (y / 80);
        const int column = x % 80 - (uneven_ ? 31 * square % 29 - 10 : 0);
        const int row = y % 80 - (uneven_ ? 17 * square % 29 - 10 : 0);
        const int end = (uneven_ ? 44 + 13 * square % 17 : 50) + larger;
        return column >= 20 - larger && column < end && row >= 20 - larger && row < end;
    }
    ClipQuality::ColourFit fit(int right, int below, int colour_larger, bool with_shadow = false) {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {
                const bool shadow = with_shadow && !in_box(x + 80, y + 80) && in_box(x + 87, y + 80);
                depth_.push_back(shadow ? invalid : in_box(x + 80, y + 80) ? 200 : 60);
                const bool is_red = in_box(x - right + 80, y - below + 80, colour_larger);
                const int noise = (x * 7 + y * 13) % 11;
                colour_.push_back(static_cast<std::uint8_t>((is_red ? 190 : 40) + noise));
                colour_.push_back(static_cast<std::uint8_t>(60 + noise));
                colour_.push_back(static_cast<std::uint8_t>((is_red ? 30 : 170) + noise));
            }
        RawFrame frame;
        frame.depth = {depth_.data(), width, width, height, 1, 1};
        frame.colour = {colour_.data(), 3 * width, width, height, 1, 3};
        Scene scene = small_scene(width, height);
        scene.depth.invalid_codes[0] = invalid;
        scene.depth.invalid_code_count = 1;
        derive_valid_range(scene.depth);
        ColourEdges edges(scene);
        where.assign(depth_.size(), 0);
        edges.add(frame, &where);
        const auto found = edges.fit();
        EXPECT_TRUE(found);
        return found.value_or(ClipQuality::ColourFit{});
    }

    static constexpr std::uint8_t invalid = 0;
    bool uneven_ = false;
    std::vector<std::uint8_t> depth_, colour_, where;
};

TEST_F(ColourEdgesOf, RegisteredPicturesFit) {
    const auto fitted = fit(0, 0, 0);
    EXPECT_NEAR(fitted.right.value_or(9), 0, 0.01);
    EXPECT_NEAR(fitted.below.value_or(9), 0, 0.01);
    EXPECT_NEAR(fitted.rim, 0, 0.51);
    EXPECT_EQ(std::count(where.begin(), where.end(), 1), 0);
}

TEST_F(ColourEdgesOf, ShiftIsTold) {
    const auto fitted = fit(3, -2, 0);
    EXPECT_NEAR(fitted.right.value_or(9), 3, 0.01);
    EXPECT_NEAR(fitted.below.value_or(9), -2, 0.01);
    EXPECT_NEAR(fitted.rim, 0, 0.51);
    EXPECT_GT(std::count(where.begin(), where.end(), 1), 500);
}

TEST_F(ColourEdgesOf, RimIsToldFromAShift) {
    const auto narrow = fit(-2, 0, -3);
    EXPECT_NEAR(narrow.right.value_or(9), -2, 0.01);
    EXPECT_NEAR(narrow.rim, 3, 0.51);
}

TEST_F(ColourEdgesOf, ColourBeyondTheSurfaceIsARimBelowZero) {
    const auto fitted = fit(0, 1, 2);
    EXPECT_NEAR(fitted.below.value_or(9), 1, 0.01);
    EXPECT_NEAR(fitted.rim, -2, 0.51);
}

TEST_F(ColourEdgesOf, ColourFarBesideDepthAgreesOnNoPlace) {
    uneven_ = true;
    EXPECT_TRUE(fit(3, -2, 0).agrees());
    for (const auto& [right, below] : {std::pair{30, 0}, {-30, 0}, {0, -30}}) {
        depth_.clear();
        colour_.clear();
        const auto fitted = fit(right, below, 0);
        EXPECT_FALSE(fitted.agrees()) << right << ' ' << below << ": " << fitted.agreement;
    }
}

TEST_F(ColourEdgesOf, ShadowWithoutDepthChangesNothing) {
    const auto fitted = fit(2, 0, 0, true);
    EXPECT_NEAR(fitted.right.value_or(9), 2, 0.01);
}

TEST(ColourEdgesWithout, EdgesSayNothing) {
    const std::vector<std::uint8_t> depth(width * height, 100), colour(3 * width * height, 100);
    RawFrame frame;
    frame.depth = {depth.data(), width, width, height, 1, 1};
    frame.colour = {colour.data(), 3 * width, width, height, 1, 3};
    ColourEdges edges(small_scene(width, height));
    edges.add(frame);
    EXPECT_FALSE(edges.fit());
    // Neither does a picture of one pixel.
    frame.depth.width = frame.depth.height = frame.colour.width = frame.colour.height = 1;
    edges.add(frame);
    EXPECT_FALSE(edges.fit());
}

}  // namespace
}  // namespace touchable::test
