#include "engine/formats/depth_values.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stop_token>

#include "engine/base/threads.hpp"
#include "engine/formats/value_evidence.hpp"
#include "engine/scene/frames.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

Scene scene_of(int width, int height) {
    Scene scene = small_scene(width, height, 16);
    scene.camera = {500, 500, 0.5, 0.5};
    scene.depth.semantics = DepthSemantics::planar;
    return scene;
}

StoredImage floats(int width, std::vector<float> values) {
    StoredImage picture;
    picture.image.width = width;
    picture.image.height = static_cast<int>(values.size()) / width;
    picture.values = std::move(values);
    return picture;
}

StoredImage words(int width, const std::vector<std::uint16_t>& values) {
    StoredImage picture;
    picture.image = {width, static_cast<int>(values.size()) / width, 2, 1, {}};
    picture.image.samples.resize(2 * values.size());
    std::memcpy(picture.image.samples.data(), values.data(), 2 * values.size());
    return picture;
}

/// What the settled scene says of a pixel; 0 where it is not valid.
double depth_at(const Scene& scene, const Image& codes, int x) {
    const std::uint16_t code = static_cast<std::uint16_t>(codes.view().sample(x, 0));
    return scene.depth.is_valid(code) ? scene.depth.depth(code) : 0;
}

/// The same, but for a far plane that is stated.
SceneDescription without_far(const Scene& scene) {
    SceneDescription described(scene);
    described.unstated.far = true;
    return described;
}

TEST(DepthValues, FloatsComeBackWithinHalfACode) {
    const float inf = std::numeric_limits<float>::infinity();
    const std::vector<float> depths{0.4F, 1, 1.7F, 2.5F, 3.999F, 0, -1, NAN, inf, -inf};
    for (const double metres : {1.0, 0.001}) {
        Scene scene = scene_of(10, 1);
        scene.metres_per_unit = 1;
        scene.depth.kind = DepthCodingKind::metric;
        scene.depth.scale = metres;
        scene.depth.near = 0;
        scene.depth.far = 65.535;
        std::vector<float> stored;
        for (const float depth : depths) stored.push_back(static_cast<float>(depth / metres));
        DepthValues values(without_far(scene));
        ASSERT_TRUE(values.needs_looks(floats(10, stored)));
        values.look(floats(10, stored));
        const auto said = values.settle(scene);
        ASSERT_EQ(message(said), "");
        const Image codes = values.codes(floats(10, stored));
        for (int x = 0; x < 5; ++x) {
            const double wanted = depths[static_cast<std::size_t>(x)], near = scene.depth.near,
                         far = scene.depth.far;
            const double half = scene.depth.kind == DepthCodingKind::linear
                                    ? 0.5 * (far - near) / scene.depth.code_max
                                    : 0.5 * wanted * wanted * (1 / near - 1 / far) / scene.depth.code_max;
            EXPECT_NEAR(depth_at(scene, codes, x), wanted, 1.01 * half + 1e-6 * wanted) << x << " " << *said;
        }
        for (int x = 5; x < 10; ++x) EXPECT_EQ(depth_at(scene, codes, x), 0) << x;
        EXPECT_NE(said->find("half a code is"), std::string::npos);
    }
}

TEST(DepthValues, FarSkiesDoNotTakeTheStepsFromWhatIsNear) {
    std::vector<float> stored(1000, 0.5F);
    for (std::size_t k = 0; k < 100; ++k) stored[k] = 10000;
    Scene scene = scene_of(1000, 1);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 1;
    scene.depth.near = 0;
    DepthValues values(without_far(scene));
    values.look(floats(1000, stored));
    ASSERT_EQ(message(values.settle(scene)), "");
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::inverse);
    EXPECT_NEAR(depth_at(scene, values.codes(floats(1000, stored)), 500), 0.5, 1e-5);
    EXPECT_NEAR(depth_at(scene, values.codes(floats(1000, stored)), 5), 10000, 800);
}

/// A picture of 30x30 pixels: a ball from 4 to 6 in the middle third of it, and background.
StoredImage ball_before(float background) {
    std::vector<float> stored(900, background);
    for (int y = 10; y < 20; ++y)
        for (int x = 10; x < 20; ++x)
            stored[static_cast<std::size_t>(30 * y + x)] =
                4 + 2 * std::sqrt(static_cast<float>((x - 15) * (x - 15) + (y - 15) * (y - 15)) / 50);
    return floats(30, stored);
}

Scene scene_of_lengths(int width, int height, double scale = 1) {
    Scene scene = scene_of(width, height);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = scale;
    scene.depth.near = 0;
    return scene;
}

/// Most of the picture, so that its median, its far plane and its unit would be the background's.
TEST(DepthValues, ARenderersBackgroundIsNoDepthBeforeAnythingIsGuessed) {
    const float inf = std::numeric_limits<float>::infinity();
    for (const float background : {1e10F, 1e9F, 65504.0F, inf, 3e38F, -1e10F, -65504.0F, -inf}) {
        SCOPED_TRACE(background);
        const StoredImage picture = ball_before(background);
        const EstimatedValues estimated = estimate_values(picture);
        EXPECT_NEAR(estimated.median, 4.7, 0.5);
        EXPECT_EQ(estimated.negative, 0);
        Scene scene = scene_of_lengths(30, 30);
        DepthValues values(without_far(scene));
        values.look(picture);
        const auto said = values.settle(scene);
        ASSERT_EQ(message(said), "");
        EXPECT_NE(said->find("88.89 % of the pixels are background"), std::string::npos) << *said;
        EXPECT_NEAR(scene.depth.near, 4, 1e-9);
        EXPECT_NEAR(scene.depth.far, 6 * 1.05, 1e-6);
        const Image codes = values.codes(picture);
        EXPECT_EQ(depth_at(scene, codes, 0), 0);
        EXPECT_EQ(codes.view().sample(0, 15), 65535);
        const std::uint16_t nearest = codes.view().sample(15, 15);
        EXPECT_NEAR(scene.depth.depth(nearest), 4, 1e-3);
    }
}

/// What is stored in millimetres may be 65.504 m away, and codes have no background.
TEST(DepthValues, TheLargestHalfIsADepthWhereSomethingIsFarther) {
    std::vector<float> stored(100, 65504);
    stored[1] = 65510;
    Scene scene = scene_of_lengths(100, 1, 0.001);
    DepthValues values(without_far(scene));
    values.look(floats(100, stored));
    ASSERT_EQ(message(values.settle(scene)), "");
    EXPECT_NEAR(depth_at(scene, values.codes(floats(100, stored)), 0), 65.504, 1e-3);
    EXPECT_EQ(estimate_values(words(3, {65504, 65504, 100})).median, 65504);
}

/// A background says that values have a unit: shares of a range have none.
TEST(DepthValues, WhatHasABackgroundIsNotDepthWithoutAScale) {
    std::vector<float> stored(1000);
    for (std::size_t k = 0; k < 1000; ++k) stored[k] = static_cast<float>(k) / 999;
    EXPECT_TRUE(estimate_values(floats(1000, stored)).is_normalised);
    stored[500] = 1e10F;
    EXPECT_FALSE(estimate_values(floats(1000, stored)).is_normalised);
}

/// Whatever the frames hold that were looked at: a later one may go from plane to plane.
TEST(DepthValues, PlanesThatAreBothStatedAreThoseOfTheCodes) {
    const float near = 0.7F, far = 9.1F;  // of which the doubles 0.7 and 9.1 are beyond or before
    for (const bool is_seen : {true, false}) {
        Scene scene = scene_of_lengths(6, 1);
        scene.depth.near = 0.7;
        scene.depth.far = 9.1;
        DepthValues values(scene);
        values.look(floats(6, std::vector<float>(6, is_seen ? 2.0F : 1e10F)));
        ASSERT_EQ(message(values.settle(scene)), "");
        EXPECT_EQ(scene.depth.near, 0.7);
        EXPECT_EQ(scene.depth.far, 9.1);
        EXPECT_EQ(scene.depth.code_max, 65534);
        const Image codes = values.codes(floats(6, {near, far, 0.8F, 8.9F, 0.69F, 9.2F}));
        EXPECT_EQ(depth_at(scene, codes, 0), 0.7);
        EXPECT_DOUBLE_EQ(depth_at(scene, codes, 1), 9.1);
        EXPECT_NEAR(depth_at(scene, codes, 2), 0.8, 1e-4);
        EXPECT_NEAR(depth_at(scene, codes, 3), 8.9, 1e-3);
        EXPECT_EQ(depth_at(scene, codes, 4), 0);
        EXPECT_EQ(depth_at(scene, codes, 5), 0);
    }
}

TEST(DepthValues, ValuesBeyondAllMeasureAreNoDepth) {
    std::vector<float> stored(1000, 2.0F);
    stored[0] = 1e10F;
    stored[1] = 1e-7F;
    stored[2] = -1;
    Scene scene = scene_of(1000, 1);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 1;
    scene.depth.near = 0;
    DepthValues values(without_far(scene));
    values.look(floats(1000, stored));
    ASSERT_EQ(message(values.settle(scene)), "");
    const Image codes = values.codes(floats(1000, stored));
    for (int x = 0; x < 3; ++x) EXPECT_EQ(depth_at(scene, codes, x), 0) << x;
    EXPECT_NEAR(depth_at(scene, codes, 3), 2, 1e-2);
}

/// docs/scene_file.md: what is nearer than a metric scene's near, or deeper than its far, is no depth.
TEST(DepthValues, FloatsBeyondTheScenesPlanesAreNoDepth) {
    const std::vector<float> stored{0.3F, 0.49F, 0.6F, 1, 2.9F, 3.1F, 50};
    Scene scene = scene_of(7, 1);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 1;
    scene.depth.near = 0.5;
    scene.depth.far = 3;
    DepthValues values(scene);
    values.look(floats(7, stored));
    ASSERT_EQ(message(values.settle(scene)), "");
    EXPECT_GE(scene.depth.near, 0.5);
    EXPECT_LE(scene.depth.far, 3);
    const Image codes = values.codes(floats(7, stored));
    for (const int x : {0, 1, 5, 6})
        EXPECT_EQ(depth_at(scene, codes, x), 0) << stored[static_cast<std::size_t>(x)];
    for (const int x : {2, 3, 4})
        EXPECT_NEAR(depth_at(scene, codes, x), stored[static_cast<std::size_t>(x)], 1e-4);
}

/// Not every frame is looked at before.
TEST(DepthValues, NearerThanAllThatWasSeenIsAtTheNearPlaneAndFartherIsNoDepth) {
    Scene scene = scene_of(4, 1);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 1;
    scene.depth.near = 0;
    DepthValues values(without_far(scene));
    values.look(floats(4, {1, 2, 3, 4}));
    ASSERT_EQ(message(values.settle(scene)), "");
    const Image codes = values.codes(floats(4, {0.5F, 2, 4.1F, 4.3F}));
    EXPECT_DOUBLE_EQ(depth_at(scene, codes, 0), 1);
    EXPECT_NEAR(depth_at(scene, codes, 1), 2, 1e-3);
    EXPECT_NEAR(depth_at(scene, codes, 2), 4.1, 1e-3);
    EXPECT_EQ(depth_at(scene, codes, 3), 0);
}

TEST(DepthValues, AllOfSixteenBitsMayBeDepthWithoutAScale) {
    Scene scene = scene_of(3, 1);
    scene.depth.kind = DepthCodingKind::inverse;
    scene.depth.near = 0.5;
    scene.depth.far = 1.5;
    scene.stored.kind = StoredDepth::Kind::relative;
    DepthValues values(scene);
    values.look(words(3, {0, 65535, 1000}));
    const auto said = values.settle(scene);
    ASSERT_EQ(message(said), "");
    EXPECT_EQ(*said, "depth values from 0 to 65535 are depths from 1.5 to 0.5") << "large values near";
    const Image codes = values.codes(words(3, {0, 65535, 1000}));
    EXPECT_EQ(depth_at(scene, codes, 0), 1.5);
    EXPECT_EQ(depth_at(scene, codes, 1), 0.5);
}

TEST(DepthValues, DisparitiesOfIntegersAreExact) {
    for (const double scale : {1.0 / 16, -1.0}) {
        Scene scene = scene_of(7, 1);
        scene.depth.kind = DepthCodingKind::inverse;
        scene.stored = {StoredDepth::Kind::disparity, 0.2, scale, scale > 0 ? 2.5 : 1092.5, false, 0};
        scene.depth.invalid_codes[0] = 0;
        scene.depth.invalid_code_count = 1;
        const std::vector<std::uint16_t> stored{17, 100, 333, 999, 1000, 0, 500};
        DepthValues values(scene);
        values.look(words(7, stored));
        ASSERT_EQ(message(values.settle(scene)), "");
        EXPECT_TRUE(scene.stored.is_plain());
        const Image codes = values.codes(words(7, stored));
        for (int x = 0; x < 7; ++x) {
            const double value = stored[static_cast<std::size_t>(x)];
            const double wanted = value == 0 ? 0 : 500 * 0.2 / (scale * value + (scale > 0 ? 2.5 : 1092.5));
            EXPECT_NEAR(depth_at(scene, codes, x), wanted, 1e-12 * wanted) << x << " scale " << scale;
        }
        EXPECT_GE(scene.depth.far,
                  1.04 * scene.depth.depth(stored_code(codes.view(), scene.depth, scale > 0 ? 0 : 4, 0)));
    }
}

// As of a camera file that is wrong: what was seen keeps its steps, and the far plane lies no farther than
// codes go.
TEST(DepthValues, DisparitiesWithAnOffsetFarAboveThemAreExact) {
    for (const double scale : {1.0, -1.0}) {
        Scene scene = scene_of(200, 1);
        scene.depth.kind = DepthCodingKind::inverse;
        scene.stored = {StoredDepth::Kind::disparity, 0.2, scale, 1e7, false, 0};
        std::vector<float> stored;
        for (int k = 0; k < 200; ++k) stored.push_back(static_cast<float>(20 + 0.25 * (k * 37 % 200)));
        DepthValues values(scene);
        values.look(floats(200, stored));
        ASSERT_EQ(message(values.settle(scene)), "");
        EXPECT_GT(scene.depth.code_max, 60000);
        const Image codes = values.codes(floats(200, stored));
        for (int x = 0; x < 200; ++x) {
            const double wanted = 500 * 0.2 / (scale * stored[static_cast<std::size_t>(x)] + 1e7);
            EXPECT_NEAR(depth_at(scene, codes, x), wanted, 1e-12 * wanted) << x << " scale " << scale;
        }
    }
}

TEST(DepthValues, DepthWithoutAScaleKeepsItsOrder) {
    for (const bool near_is_high : {true, false})
        for (const DepthCodingKind kind : {DepthCodingKind::inverse, DepthCodingKind::linear}) {
            Scene scene = scene_of(4, 1);
            scene.depth.kind = kind;
            scene.depth.near = 0.5;
            scene.depth.far = 1.5;
            scene.depth.near_is_high = near_is_high;
            scene.stored.kind = StoredDepth::Kind::relative;
            const std::vector<float> stored{-0.5F, 0.25F, 0.75F, 1.5F};
            DepthValues values(scene);
            values.look(floats(4, stored));
            ASSERT_EQ(message(values.settle(scene)), "");
            const Image codes = values.codes(floats(4, stored));
            EXPECT_NEAR(depth_at(scene, codes, near_is_high ? 3 : 0), 0.5, 1e-9);
            EXPECT_NEAR(depth_at(scene, codes, near_is_high ? 0 : 3), 1.5, 1e-9);
            const double q = 1 / depth_at(scene, codes, 2);  // 1.25 of 2 from the first
            if (kind == DepthCodingKind::inverse)
                EXPECT_NEAR(q, 2.0 / 3 + (near_is_high ? 0.625 : 0.375) * (2 - 2.0 / 3), 2e-5);
            else
                EXPECT_NEAR(1 / q, near_is_high ? 1.5 - 0.625 : 0.5 + 0.625, 2e-5);
        }
}

TEST(DepthValues, WordsInAnotherOrderAreTurnedBack) {
    Scene scene = scene_of(3, 1);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 0.001;
    scene.stored.rotated = 3;
    // SUN RGB-D: depth << 3 with its upper bits below.
    const Image turned =
        DepthValues(scene).codes(words(3, {800 << 3, static_cast<std::uint16_t>(9000 << 3 | 9000 >> 13), 5}));
    EXPECT_EQ(turned.view().sample(0, 0), 800);
    EXPECT_EQ(turned.view().sample(1, 0), 9000);
    EXPECT_EQ(turned.view().sample(2, 0), 5 << 13);
    scene.stored.used_bits = 13;
    EXPECT_EQ(DepthValues(scene).codes(words(1, {800 << 3 | 5})).view().sample(0, 0), 800);
    scene.stored = {};
    scene.stored.bytes_swapped = true;
    EXPECT_EQ(DepthValues(scene).codes(words(3, {0x0102, 0xff00, 7})).view().sample(0, 0), 0x0201);
}

TEST(DepthValues, WithoutAValueAreRefused) {
    Scene scene = scene_of(2, 1);
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 1;
    DepthValues values(without_far(scene));
    values.look(floats(2, {NAN, 0}));
    EXPECT_TRUE(is_refused(values.settle(scene), "no frame has a valid depth"));
}

/// As sorting all of them tells it.
TEST(EstimatedValues, MedianIsExact) {
    Numbers numbers(3);
    for (const int count : {1, 2, 3, 1000, 300'001}) {
        std::vector<float> stored;
        for (int k = 0; k < count; ++k)
            stored.push_back(static_cast<float>(numbers.below(2000) - 1000) / 7 + 0.001F);
        std::vector<float> sorted = stored;
        std::sort(sorted.begin(), sorted.end());
        EXPECT_EQ(estimate_values(floats(1, stored)).median, sorted[sorted.size() / 2]) << count;
    }
}

TEST(EstimatedValues, EndsWhenStopped) {
    std::stop_source given_up;
    const StopScope until(given_up.get_token());
    EXPECT_TRUE(estimate_values(words(3, {1, 2, 3})).any);
    given_up.request_stop();
    EXPECT_FALSE(estimate_values(words(3, {1, 2, 3})).any);
}

}  // namespace
}  // namespace touchable::test
