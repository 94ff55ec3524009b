// What the depths that occur tell of the camera that made them.
#include "engine/surface/depth_estimator.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/content/seeded_noise.hpp"
#include "engine/formats/open_clip.hpp"
#include "tests/real_data.hpp"
#include "tests/stand_ins.hpp"
#include "tests/surface/pictures.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

constexpr int width = 320, height = 240;

Scene millimetres() {
    Scene scene;
    scene.width = width;
    scene.height = height;
    scene.camera = {262, 262, 159.5, 119.5};
    scene.depth_bits = 16;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 1;
    scene.depth.near = 0;
    scene.depth.far = 6000;
    scene.depth.code_max = 65535;
    scene.depth.invalid_codes = {0};
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    return scene;
}

/// A ground that rises to a hill, 1.5 to 2.7 m away, some noise, and holes; `store`: a code of a depth in mm.
template <class Store>
DepthLength levels_of(const Scene& scene, Store store) {
    DepthEstimator estimator(scene);
    SplitMix64 random(7);
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double hill = std::hypot(x - 200.0, y - 90.0) / 60;
            const double noise = static_cast<double>(random.next() >> 40) * 0x1p-24 - 0.5;
            const double depth = 1500 + 3 * x + y - 300 * std::exp(-hill * hill) + 2 * noise;
            codes.push_back(random.next() % 50 == 0 ? 0 : store(depth));
        }
    estimator.add(store_plane(width, height, codes, {.bytes_per_sample = 2}).frame());
    return estimator.measured()->levels;
}

std::uint16_t rounded(double depth) {
    return static_cast<std::uint16_t>(depth + 0.5);
}

TEST(DepthEstimator, FindsTheLevelsOfDisparityBehindMillimetres) {
    for (const double q : {1.5e-6, 2.85e-6, 6e-6}) {
        // Depth of a disparity that is a whole number of steps: 1 / z = k q.
        const DepthLength levels = levels_of(
            millimetres(), [&](double depth) { return rounded(1 / (q * std::floor(1 / (q * depth)))); });
        EXPECT_NEAR(levels.quadratic, q, 0.05 * q);
        EXPECT_EQ(levels.constant, 0);
    }
}

TEST(DepthEstimator, FindsLevelsThatAreEvenlyApart) {
    for (const int step : {4, 10, 25}) {
        const DepthLength levels = levels_of(millimetres(), [&](double depth) {
            return static_cast<std::uint16_t>(step * std::floor(depth / step));
        });
        EXPECT_EQ(levels, (DepthLength{static_cast<double>(step), 0})) << step;
    }
}

TEST(DepthEstimator, SeesNoLevelsWhereEveryCodeOccurs) {
    EXPECT_EQ(levels_of(millimetres(), rounded), DepthLength{});
}

TEST(DepthEstimator, SeesNoLevelsInDepthsWithoutARule) {
    SplitMix64 random(3);
    std::vector<std::uint16_t> of_depth;
    for (int depth = 0, level = 1; depth < 8000; ++depth) {
        if (random.next() % 12 == 0) level = depth;
        of_depth.push_back(static_cast<std::uint16_t>(level));
    }
    const DepthLength levels =
        levels_of(millimetres(), [&](double depth) { return of_depth[static_cast<std::size_t>(depth)]; });
    // A mean of 12 is the best that may be said of them.
    EXPECT_TRUE(levels == DepthLength{} || (levels.quadratic == 0 && levels.constant < 25));
}

// Codes of each column, of which no two are neighbours; but no terraces.
TEST(DepthEstimator, ASlopeIsNoStaircase) {
    const Scene scene = millimetres();
    std::vector<std::uint16_t> codes;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) codes.push_back(rounded(1 / (1e-3 - 2.5e-6 * x)));
    DepthEstimator estimator(scene);
    estimator.add(store_plane(width, height, codes, {.bytes_per_sample = 2}).frame());
    EXPECT_EQ(estimator.measured()->levels, DepthLength{});
}

TEST(DepthEstimator, EveryCodeCounts) {
    Scene scene = millimetres();
    scene.depth.far = 65535;
    derive_valid_range(scene.depth);
    const std::vector<std::uint16_t> codes(width * height, 65535);
    DepthEstimator estimator(scene);
    estimator.add(store_plane(width, height, codes, {.bytes_per_sample = 2}).frame());
    EXPECT_EQ(estimator.measured()->median, 65535);
}

TEST(DepthEstimator, OfNothingSaysNothing) {
    DepthEstimator estimator(millimetres());
    EXPECT_FALSE(estimator.measured());
}

TEST(DepthEstimator, TheMedianLeavesOutTheFarPlaneUnlessAllIsThere) {
    Scene scene = millimetres();
    std::vector<std::uint16_t> codes(width * height, 6000);
    DepthEstimator far(scene);
    far.add(store_plane(width, height, codes, {.bytes_per_sample = 2}).frame());
    EXPECT_EQ(far.measured()->median, 6000);
    for (std::size_t k = 0; k < 300; ++k) codes[k] = static_cast<std::uint16_t>(1000 + k);
    DepthEstimator some(scene);
    some.add(store_plane(width, height, codes, {.bytes_per_sample = 2}).frame());
    EXPECT_EQ(some.measured()->median, 1149);
}

TEST(DepthEstimator, KnowsAStructuredLightCameraByGeneratedPictures) {
    const test::TemporaryFolder folder;
    const test::StandIn what = test::stand_in("redwood5");
    auto reader = open_clip(folder.path(), test::write_stand_in(folder.path(), what));
    ASSERT_TRUE(reader) << reader.error().message;
    DepthEstimator estimator((*reader)->scene());
    for (auto frame = (*reader)->next(); frame && *frame; frame = (*reader)->next()) estimator.add(**frame);
    const auto measured = estimator.measured();
    ASSERT_TRUE(measured);
    EXPECT_NEAR(measured->levels.quadratic, what.level_per_mm, 0.05 * what.level_per_mm);
    EXPECT_EQ(measured->noise, DepthLength{}) << "views from different places are no noise";
    EXPECT_TRUE(measured->from_a_camera());
}

TEST(DepthEstimator, KnowsAStructuredLightCameraByItsPictures) {
    TOUCHABLE_NEEDS_DATA(real_data("stills/redwood5"));
    auto reader = open_clip(real_data("stills/redwood5"),
                            std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/scenes/redwood5.json");
    ASSERT_TRUE(reader) << reader.error().message;
    DepthEstimator estimator((*reader)->scene());
    for (auto frame = (*reader)->next(); frame && *frame; frame = (*reader)->next()) estimator.add(**frame);
    const auto measured = estimator.measured();
    ASSERT_TRUE(measured);
    EXPECT_NEAR(measured->levels.quadratic * 2000 * 2000, 14.2, 0.3) << "mm at 2 m";
    EXPECT_NEAR(measured->median, 1861, 1);
    EXPECT_EQ(measured->noise, DepthLength{}) << "views from different places are no noise";
    EXPECT_TRUE(measured->from_a_camera());
}

}  // namespace
}  // namespace touchable::test
