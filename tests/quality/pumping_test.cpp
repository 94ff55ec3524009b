// Depth that goes to and fro as a whole.
#include "engine/authoring/quality_estimators.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <random>

namespace touchable::test {
namespace {

/// Of a slope whose depth is `scale(k)` times itself in frame k, under an even colour where one is given.
std::optional<double> pumping_of(int frames, const std::function<double(int)>& scale,
                                 const std::function<int(int)>& brightness = {}) {
    constexpr int width = 64, height = 48;
    DepthCoding coding;
    coding.kind = DepthCodingKind::metric;
    coding.scale = 0.1;
    coding.far = 6000;
    coding.code_max = 65535;
    derive_valid_range(coding);
    PumpingEstimator estimator(coding);
    std::vector<std::uint16_t> codes(width * height);
    for (int k = 0; k < frames; ++k) {
        for (int pixel = 0; pixel < width * height; ++pixel)
            codes[static_cast<std::size_t>(pixel)] = coding.code(scale(k) * (1000 + pixel % width));
        RawFrame frame;
        frame.number = k;
        frame.depth = {reinterpret_cast<const std::uint8_t*>(codes.data()), 2 * width, width, height, 2, 1};
        std::vector<std::uint8_t> colour;
        if (brightness) {
            colour.assign(3 * width * height, static_cast<std::uint8_t>(brightness(k)));
            frame.colour = {colour.data(), 3 * width, width, height, 1, 3};
        }
        estimator.add(frame);
    }
    return estimator.share();
}

TEST(Pumping, IsThatOfScalesThatChangeByChance) {
    std::mt19937 random(7);
    std::vector<double> scales;
    for (int k = 0; k < 400; ++k)
        scales.push_back(1 + 0.01 * (static_cast<double>(random() % 2001) / 1000 - 1));
    const auto share = pumping_of(400, [&](int k) { return scales[static_cast<std::size_t>(k)]; });
    ASSERT_TRUE(share);
    EXPECT_NEAR(*share, 0.01 / std::sqrt(3.0), 0.0006);  // of an even distribution
}

TEST(Pumping, IsNotWhatStandsStillOrMovesOn) {
    EXPECT_LT(pumping_of(30, [](int) { return 1.0; }).value_or(9), 1e-9);
    EXPECT_LT(pumping_of(30, [](int k) { return 1 - 0.01 * k; }).value_or(9), 1e-9);
}

/// A shot of one frame between two of another place.
TEST(Pumping, IsNotWhatACutChanges) {
    const auto scale = [](int k) { return k % 6 == 3 ? 1.4 : 1.0; };
    EXPECT_LT(pumping_of(30, scale, [](int k) { return k % 6 == 3 ? 200 : 60; }).value_or(9), 1e-9);
    EXPECT_GT(pumping_of(30, scale, [](int k) { return k % 6 == 3 ? 70 : 60; }).value_or(0), 0.05);
}

TEST(Pumping, IsNotKnownOfFewFrames) {
    EXPECT_FALSE(pumping_of(1, [](int) { return 1.0; }));
    EXPECT_FALSE(pumping_of(3, [](int k) { return 1.0 + 0.1 * (k % 2); }));
}

}  // namespace
}  // namespace touchable::test
