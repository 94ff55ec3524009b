#include <gtest/gtest.h>

#include <array>
#include <cstring>

#include "tests/content/made.hpp"

namespace touchable {
namespace {

TEST(Noise, CodesAreUniformOverTheWholeRange) {
    for (const int bits : {8, 10, 16}) {
        const RawFrame frame = made("noise", sized(128, 128, bits))->frame(0);
        std::array<int, 16> bins{};
        for (int y = 0; y < 128; ++y)
            for (int x = 0; x < 128; ++x)
                ++bins[static_cast<std::size_t>(frame.depth.sample(x, y) >> (bits - 4))];
        for (const int count : bins) EXPECT_NEAR(count, 1024, 5 * 31);  // five standard deviations
    }
}

TEST(Noise, CliffsAreNearOrFarAndNothingBetween) {
    const auto scene = made("cliffs", sized(128, 128, 10));
    const RawFrame frame = scene->frame(0);
    int near = 0;
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) {
            const int code = frame.depth.sample(x, y);
            ASSERT_TRUE(code == 0 || code == 1023);
            near += code == 1023;
        }
    EXPECT_NEAR(near, 8192, 5 * 64);
}

TEST(Noise, GrainStaysWithinTwoLevelsOfItsMean) {
    const RawFrame frame = made("grain", sized(128, 128, 8))->frame(0);
    std::array<int, 5> counts{};
    for (int y = 0; y < 128; ++y)
        for (int x = 0; x < 128; ++x) {
            const int off = frame.depth.sample(x, y) - 128;
            ASSERT_LE(std::abs(off), 2);
            ++counts[static_cast<std::size_t>(off + 2)];
        }
    for (const int count : counts) EXPECT_NEAR(count, 3277, 5 * 51);
}

TEST(Noise, NeighboursAreUncorrelated) {
    const RawFrame frame = made("noise", sized(128, 128, 16))->frame(0);
    for (const auto& [dx, dy] : {std::pair{1, 0}, {0, 1}, {1, 1}}) {
        double product = 0;
        for (int y = 0; y < 127; ++y)
            for (int x = 0; x < 127; ++x)
                product += (frame.depth.sample(x, y) / 65535.0 - 0.5) *
                           (frame.depth.sample(x + dx, y + dy) / 65535.0 - 0.5);
        EXPECT_NEAR(product / (127 * 127) * 12, 0, 5.0 / 127) << dx << " " << dy;
    }
}

TEST(Noise, SeedsDifferAndRepeat) {
    for (const std::string_view name : {"noise", "cliffs", "grain"}) {
        SceneOptions options = sized(128, 128);
        options.seed = 7;
        const RawFrame a = made(name, options)->frame(0), again = made(name, options)->frame(0);
        options.seed = 8;
        const RawFrame b = made(name, options)->frame(0);
        EXPECT_EQ(std::memcmp(a.depth.data, again.depth.data, 128U * 128U * 2U), 0);
        EXPECT_NE(std::memcmp(a.depth.data, b.depth.data, 128U * 128U * 2U), 0);
    }
}

TEST(Noise, HasNoTruth) {
    const glm::dvec3 goal{0, 0, -100};
    for (const std::string_view name : {"noise", "cliffs", "grain"})
        EXPECT_FALSE(made(name, sized(128, 128))->closest(goal, goal, 0));
}

}  // namespace
}  // namespace touchable
