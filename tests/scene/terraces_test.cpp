#include "engine/scene/filter_codes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace touchable {
namespace {

/// The camera of a globe, and `bits` of depth between its planes.
Scene coded(DepthCodingKind kind, int bits, bool near_is_high = true) {
    Scene scene;
    scene.width = 720;
    scene.height = 480;
    scene.camera = {420, 420, 360, 239};
    scene.depth_bits = bits;
    scene.depth.kind = kind;
    scene.depth.near_is_high = near_is_high;
    scene.depth.near = 40;
    scene.depth.far = 180;
    scene.depth.code_max = static_cast<std::uint16_t>((1 << bits) - 1);
    derive_valid_range(scene.depth);
    return scene;
}

Scene millimetres(double near, double far) {
    Scene scene = coded(DepthCodingKind::metric, 16);
    scene.depth.scale = 1;
    scene.depth.near = near;
    scene.depth.far = far;
    derive_valid_range(scene.depth);
    return scene;
}

Scene removed(Scene scene, double noise = 0) {
    scene.filter.terraces = TerraceRemoval::on;
    scene.filter.terrace_noise = noise;
    return scene;
}

/// 0 where working codes are looked up.
int multiplied_by(const Scene& scene) {
    const auto working = working_codes(scene);
    return working && !working->table ? working->factor : 0;
}

// 32767 over the largest code and room for the gate, five factors.
TEST(Terraces, TheFactorIsWhatSixteenBitsHaveRoomFor) {
    const std::pair<int, int> expected[] = {{8, 126}, {9, 63}, {10, 31}, {11, 15},
                                            {12, 7},  {13, 3}, {14, 0},  {16, 0}};
    for (const auto& [bits, factor] : expected)
        EXPECT_EQ(multiplied_by(coded(DepthCodingKind::linear, bits)), factor) << bits;
    Scene few = coded(DepthCodingKind::linear, 8);
    few.depth.code_max = 15;
    EXPECT_EQ(multiplied_by(few), 126);
    Scene hue = coded(DepthCodingKind::hue, 8, false);
    hue.depth.code_max = 1536;
    EXPECT_EQ(multiplied_by(hue), 21);
    EXPECT_EQ(multiplied_by(millimetres(300, 1000)), 32) << "codes beyond `far` need no room";
    EXPECT_EQ(multiplied_by(millimetres(300, 1500)), 16) << "of metric codes a power of two";
    EXPECT_EQ(multiplied_by(millimetres(300, 4090)), 8);
    EXPECT_EQ(multiplied_by(millimetres(300, 4091)), 0)
        << "four times as many would be coarse near the camera";
}

TEST(Terraces, FinerCodesAreValidFromTheLeastToTheLargestValidOne) {
    Scene scene = coded(DepthCodingKind::linear, 8);
    scene.depth.invalid_codes = {0, 255, 1, 90};
    scene.depth.invalid_code_count = 4;
    derive_valid_range(scene.depth);
    const DepthCoding fine = finer(scene.depth, 10);
    EXPECT_FALSE(fine.is_valid(19));
    for (int code = 20; code <= 2540; ++code) EXPECT_TRUE(fine.is_valid(static_cast<std::uint16_t>(code)));
    EXPECT_FALSE(fine.is_valid(2541));
    EXPECT_EQ(fine.depth(770), scene.depth.depth(77));
}

TEST(Terraces, CodesAndGateFitTheRangeWithTheMostNoise) {
    for (int code_max = 255; code_max < 65536; code_max = code_max * 9 / 8) {
        Scene scene = coded(DepthCodingKind::linear, 16);
        scene.depth.code_max = static_cast<std::uint16_t>(code_max);
        derive_valid_range(scene.depth);
        const auto filter = terrace_filter(removed(scene, most_terrace_noise));
        ASSERT_TRUE(filter);
        const int last = filter->working.of(code_max);
        EXPECT_LE(last + filter->gate_at(static_cast<std::uint16_t>(last)), terrace_range) << code_max;
        EXPECT_LE(last + filter->gate_at(0), terrace_range) << code_max;
        EXPECT_EQ(filter->coding.code_max, 2 * last);
    }
}

TEST(Terraces, AFinerCodeOfAnUnchangedPixelIsTheSameDepthToTheBit) {
    std::vector<Scene> scenes;
    for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse})
        for (const int bits : {8, 10, 13})
            for (const bool near_is_high : {false, true}) scenes.push_back(coded(kind, bits, near_is_high));
    scenes.push_back(millimetres(300, 2000));
    scenes.back().depth.scale = 0.977;
    for (Scene scene : scenes) {
        scene.depth.invalid_codes = {100};
        scene.depth.invalid_code_count = 1;
        const auto filter = terrace_filter(removed(scene));
        ASSERT_TRUE(filter);
        const DepthCoding &stored = scene.depth, &finer = filter->coding;
        for (int code = stored.valid_min; code <= stored.valid_max; ++code) {
            const auto fine = static_cast<std::uint16_t>(code * 2 * filter->working.factor);
            ASSERT_EQ(finer.depth(fine), stored.depth(static_cast<std::uint16_t>(code))) << code;
            ASSERT_TRUE(finer.is_valid(fine)) << code;
        }
        EXPECT_EQ(finer.valid_min, stored.valid_min * 2 * filter->working.factor);
        EXPECT_EQ(finer.valid_max, stored.valid_max * 2 * filter->working.factor);
        EXPECT_EQ(finer.near, stored.near);
        EXPECT_EQ(finer.far, stored.far);
    }
}

TEST(Terraces, GateAndMostAreOfALevelAndOfNoise) {
    const auto quiet = terrace_filter(removed(coded(DepthCodingKind::linear, 8)));
    EXPECT_EQ(quiet->gate_at(0), 157);  // 5/4 of 126
    EXPECT_EQ(quiet->most_at(0), 126);
    const auto noisy = terrace_filter(removed(coded(DepthCodingKind::linear, 8), 1));
    EXPECT_EQ(noisy->gate_at(0), 252);  // (5 x 126 + 3 x 126)/4
    EXPECT_EQ(noisy->most_at(0), 220);
    const auto ten = terrace_filter(removed(coded(DepthCodingKind::linear, 10), 0.3));
    EXPECT_EQ(ten->gate_at(0), (5 * 31 + 3 * 9) / 4);  // 0.3 x 31 = 9.3
    EXPECT_EQ(ten->most_at(0), (4 * 31 + 3 * 9) / 4);
}

// Of a camera that measures disparity and stores millimetres: 11 mm apart at 2 m.
TEST(Terraces, LevelsThatAreFartherApartThanCodesMakeGateAndKappaWider) {
    Scene scene = removed(millimetres(500, 2000));
    scene.filter.levels = {0, 2.75e-6};
    const auto filter = terrace_filter(scene);
    ASSERT_TRUE(filter);
    EXPECT_EQ(filter->working.factor, 16);
    for (const double depth : {500.0, 700.0, 1000.0, 1400.0, 1700.0, 2000.0}) {
        const auto code = static_cast<std::uint16_t>(16 * depth);
        const double level = std::max(1.0, 2.75e-6 * depth * depth);
        EXPECT_NEAR(filter->level_at(code), 16 * level, 2.5) << depth;
        EXPECT_EQ(filter->gate_at(code), 5 * filter->level_at(code) / 4);
        EXPECT_EQ(filter->most_at(code), filter->level_at(code));
        EXPECT_NEAR(level_distance(scene, depth), level, 1e-9) << depth;
        EXPECT_NEAR(kappa_of_depth(scene, depth), level / (depth / 420), 1e-9) << depth;
        EXPECT_LE(code + filter->gate_at(code), terrace_range);
    }
    scene.filter.levels = {0, 30e-6};
    EXPECT_EQ(terrace_filter(scene)->working.factor, 8) << "levels of 120 codes at 2 m need room";
}

// Levels as of disparity are as far apart everywhere in inverse depth.
TEST(Terraces, LevelsOfInverseCodesAreToldInCodesToo) {
    for (const bool near_is_high : {true, false}) {
        Scene scene = removed(coded(DepthCodingKind::inverse, 10, near_is_high));
        const double step = (1.0 / 40 - 1.0 / 180) / 1023;
        scene.filter.levels = {0, 3 * step};
        const auto filter = terrace_filter(scene);
        ASSERT_TRUE(filter);
        for (int code = 0; code <= 1023; code += 93)
            EXPECT_NEAR(filter->level_at(static_cast<std::uint16_t>(code * filter->working.factor)),
                        3 * filter->working.factor, 1)
                << code;
    }
}

TEST(Terraces, CodesAndGateFitTheRangeWhateverTheLevels) {
    for (const double constant : {0.0, 3.0, 500.0, 1e9})
        for (const double quadratic : {0.0, 1e-6, 1e-3, 1e9})
            for (const auto kind :
                 {DepthCodingKind::linear, DepthCodingKind::inverse, DepthCodingKind::metric})
                for (const int bits : {8, 10, 12, 16}) {
                    Scene scene = kind == DepthCodingKind::metric ? millimetres(20, (1 << bits) - 1)
                                                                  : coded(kind, bits);
                    scene = removed(scene, most_terrace_noise);
                    scene.filter.levels = {constant, quadratic};
                    const auto filter = terrace_filter(scene);
                    if (!filter) continue;
                    const int last = largest_code(filter->working.coding);
                    for (const int code : {0, last / 3, last}) {
                        const int gate = filter->gate_at(static_cast<std::uint16_t>(code));
                        ASSERT_LE(last + gate, terrace_range) << constant << " " << quadratic << " " << bits;
                        ASSERT_LE(2 * filter->most_at(static_cast<std::uint16_t>(code)), 32767);
                    }
                }
}

// Half-way between the planes, at 110, a pixel is 110/420 wide and a step (180 - 40)/255 deep.
TEST(Terraces, AreRemovedAutomaticallyWhereKappaSaysSo) {
    Scene scene = coded(DepthCodingKind::linear, 8);
    EXPECT_NEAR(kappa_of_scene(scene), 140.0 / 255 / (110.0 / 420), 1e-9);
    for (const auto& [bits, advised] : {std::pair{8, true}, {11, true}, {12, false}, {16, false}}) {
        scene = coded(DepthCodingKind::linear, bits);
        EXPECT_EQ(terraces_advised(scene), advised) << bits;
        EXPECT_FALSE(terrace_filter(scene)) << "off unless asked for";
        scene.filter.terraces = TerraceRemoval::automatic;
        EXPECT_EQ(terrace_filter(scene).has_value(), advised) << bits;
        scene.filter.terraces = TerraceRemoval::on;
        EXPECT_TRUE(terrace_filter(scene)) << bits;
    }
    EXPECT_TRUE(terraces_advised(millimetres(300, 2000))) << "16 bits, but a step is a third of a pixel";
}

}  // namespace
}  // namespace touchable
