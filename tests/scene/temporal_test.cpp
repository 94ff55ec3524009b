#include "engine/scene/filter_codes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

namespace touchable {
namespace {

Scene coded(DepthCodingKind kind, int code_max, bool near_is_high, DepthLength noise) {
    Scene scene;
    scene.width = 720;
    scene.height = 480;
    scene.camera = {420, 420, 360, 239};
    scene.depth_bits = 16;
    scene.depth.kind = kind;
    scene.depth.near_is_high = near_is_high;
    scene.depth.near = 400;
    scene.depth.far = 2800;
    scene.depth.scale = kind == DepthCodingKind::metric ? 1 : 0;
    scene.depth.code_max = static_cast<std::uint16_t>(code_max);
    derive_valid_range(scene.depth);
    scene.filter = {.median = 5, .temporal = true, .temporal_noise = noise};
    return scene;
}

constexpr DepthCodingKind kinds[] = {DepthCodingKind::linear, DepthCodingKind::inverse,
                                     DepthCodingKind::metric, DepthCodingKind::hue};
constexpr int largest_codes[] = {3, 100, 255, 1023, 1536, 4095, 16383, 65535};

TEST(Temporal, TheGateIsTheNoiseInCodesOfEveryCoding) {
    for (const DepthLength noise : {DepthLength{6, 0}, DepthLength{0, 4e-6}, DepthLength{2, 1e-6}})
        for (const DepthCodingKind kind : kinds)
            for (const int code_max : largest_codes)
                for (const bool near_is_high : {false, true}) {
                    if (kind == DepthCodingKind::metric && code_max < 500) continue;
                    const Scene scene = coded(kind, code_max, near_is_high, noise);
                    const TemporalFilter filter = *temporal_filter(scene);
                    const int last = largest_code(filter.coding);
                    for (int part = 0; part <= 8; ++part) {
                        const int span = filter.coding.valid_max - filter.coding.valid_min;
                        const int code = filter.coding.valid_min + span * part / 8;
                        const double depth = filter.coding.depth(static_cast<std::uint16_t>(code));
                        const double wide = noise.constant + noise.quadratic * depth * depth;
                        const double steps = kind == DepthCodingKind::metric ? wide / filter.coding.scale
                                             : kind == DepthCodingKind::inverse
                                                 ? wide / (depth * depth) * last / (1.0 / 400 - 1.0 / 2800)
                                                 : wide * last / 2400;
                        // Each of three parts is rounded down, from a coefficient to the nearest 1/65536.
                        EXPECT_NEAR(filter.gate.at(static_cast<std::uint16_t>(code)), steps, 4.5)
                            << static_cast<int>(kind) << ", " << code_max << ", code " << code;
                    }
                }
}

/// LeRobot's planes in mm, and a camera's: by codes of their own, of which the gate is exact.
TEST(Temporal, TheGateOfLogarithmicDepthIsTheNoiseToo) {
    for (const auto& [near, far, shift] : {std::tuple{10.0, 10000.0, 3500.0}, {400.0, 2800.0, 0.0}})
        for (const DepthLength noise : {DepthLength{20, 0}, DepthLength{0, 2e-5}, DepthLength{12, 1e-5}})
            for (const bool near_is_high : {false, true}) {
                Scene scene = coded(DepthCodingKind::log, 4095, near_is_high, noise);
                scene.depth.near = near;
                scene.depth.far = far;
                scene.depth.shift = shift;
                derive_valid_range(scene.depth);
                const TemporalFilter filter = *temporal_filter(scene);
                const DepthCoding& coding = filter.coding;
                const double ends = 1 / (near + coding.shift) - 1 / (far + coding.shift);
                for (int code = 0; code <= coding.code_max; code += 97) {
                    const double depth = coding.depth(static_cast<std::uint16_t>(code)),
                                 beyond = depth + coding.shift;
                    const double steps = noise.at(depth) / (beyond * beyond * ends) * coding.code_max;
                    EXPECT_NEAR(filter.gate.at(static_cast<std::uint16_t>(code)), steps, 4.5) << code;
                }
            }
}

TEST(Temporal, TheGateGrowsWithTheNoiseAlongTheCodes) {
    for (const DepthCodingKind kind : kinds)
        for (const int code_max : {600, 4095, 65535})
            for (const bool near_is_high : {false, true}) {
                const DepthLength noise =
                    kind == DepthCodingKind::inverse ? DepthLength{3, 0} : DepthLength{1, 4e-6};
                const TemporalFilter filter = *temporal_filter(coded(kind, code_max, near_is_high, noise));
                const bool up = filter.coding.deeper_is_higher() != (kind == DepthCodingKind::inverse);
                for (int code = filter.coding.valid_min; code < filter.coding.valid_max; ++code) {
                    const int here = filter.gate.at(static_cast<std::uint16_t>(code)),
                              next = filter.gate.at(static_cast<std::uint16_t>(code + 1));
                    ASSERT_TRUE(up ? next >= here : next <= here) << code;
                }
            }
}

TEST(Temporal, ATwentiethOfAMillimetreOrAKilometreOfNoiseOverflowsNothing) {
    for (const double noise : {0.05, 1e3, 1e12})
        for (const DepthCodingKind kind : kinds)
            for (const int code_max : largest_codes)
                for (const DepthLength of :
                     {DepthLength{noise, 0}, DepthLength{0, noise}, DepthLength{noise, noise}}) {
                    if (kind == DepthCodingKind::metric && code_max < 500) continue;
                    const TemporalFilter filter = *temporal_filter(coded(kind, code_max, true, of));
                    for (int code = 0; code <= largest_code(filter.coding); code += 13) {
                        const int gate = filter.gate.at(static_cast<std::uint16_t>(code));
                        ASSERT_GE(gate, 0);
                        ASSERT_LE(gate, code_curve_most);
                        if (noise >= 1e3 && of.constant > 0 && kind != DepthCodingKind::inverse) {
                            ASSERT_GT(gate, noise > 1e3 ? 15000 : 100);
                        }
                    }
                }
}

TEST(Temporal, PlanesThatDoublesHardlyTellApartHaveTheLargestCoefficients) {
    Scene scene = coded(DepthCodingKind::inverse, 255, true, {6, 1e-6});
    scene.depth.near = 1.5000000000000002;
    scene.depth.far = std::nextafter(scene.depth.near, 2);
    ASSERT_EQ(1 / scene.depth.near, 1 / scene.depth.far);
    const CodeCurve gate = temporal_filter(scene)->gate;
    for (const int coefficient : {gate.constant, gate.linear, gate.quadratic}) EXPECT_EQ(coefficient, 21845);
}

TEST(Temporal, AMedianLeavesLessNoiseAndSoASmallerGate) {
    Scene scene = coded(DepthCodingKind::linear, 65535, true, {6, 0});
    const int after5 = temporal_filter(scene)->gate.at(0);
    EXPECT_NEAR(after5, 6 * 65535 / 2400, 1);
    scene.filter.median = 3;
    EXPECT_NEAR(temporal_filter(scene)->gate.at(0), after5 * 4 / 3, 1);
    scene.filter.median = 0;
    EXPECT_NEAR(temporal_filter(scene)->gate.at(0), after5 * 2, 1);
}

TEST(Temporal, CodesAreAsMuchFinerAsBeforeTerraceRemoval) {
    for (const int code_max : {255, 1023, 16383, 65535}) {
        Scene scene = coded(DepthCodingKind::linear, code_max, true, {6, 0});
        const auto filter = temporal_filter(scene);
        ASSERT_TRUE(filter);
        const auto working = working_codes(scene);
        ASSERT_TRUE(working);
        EXPECT_EQ(filter->working, working->table ? unchanged_codes(scene.depth) : *working)
            << "no code is looked up for that alone";
        for (int code = 0; code <= code_max; code += 7)
            EXPECT_EQ(filter->coding.depth(filter->working.of(code)),
                      scene.depth.depth(static_cast<std::uint16_t>(code)));
        scene.filter.terraces = TerraceRemoval::on;
        const auto before = temporal_filter(scene);
        const auto terraces = terrace_filter(scene);
        scene.filter.temporal = false;
        const auto alone = terrace_filter(scene);
        ASSERT_TRUE(terraces && alone);
        EXPECT_EQ(before->working, *working);
        EXPECT_EQ(alone->working, *working);
        EXPECT_EQ(terraces->working, unchanged_codes(working->coding)) << "they are finer already";
        EXPECT_EQ(terraces->gate_at(0), alone->gate_at(0));
        EXPECT_EQ(terraces->most_at(0), alone->most_at(0));
        EXPECT_EQ(terraces->coding, alone->coding);
    }
}

TEST(Temporal, IsOffUnlessAskedFor) {
    Scene scene = coded(DepthCodingKind::linear, 255, true, {6, 0});
    scene.filter.temporal = false;
    EXPECT_FALSE(temporal_filter(scene));
}

}  // namespace
}  // namespace touchable
