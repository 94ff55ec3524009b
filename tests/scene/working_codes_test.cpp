#include "engine/scene/filter_codes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

// Codes that are looked up because multiplied ones would not fit 15 bits.
namespace touchable {
namespace {

struct LookedUpCase {
    const char* name;
    DepthCodingKind kind;
    double near, far, scale;
    bool near_is_high;
    DepthLength levels;
    double shift = 0;
};

// Scene units are metres. Floats become 65535 codes; a pixel of a stray reflection is at 19.7 m; some
// recordings are in tenths and fifths of a millimetre.
constexpr LookedUpCase looked_up_cases[] = {
    {"inverse", DepthCodingKind::inverse, 0.4, 9, 0, true, {}},
    {"inverse, low is near", DepthCodingKind::inverse, 0.4, 9, 0, false, {0, 0.003}},
    {"linear", DepthCodingKind::linear, 0.2, 20.7, 0, true, {}},
    {"linear, low is near", DepthCodingKind::linear, 0.2, 20.7, 0, false, {0.001, 0.002}},
    {"millimetres", DepthCodingKind::metric, 0.3, 20.7, 0.001, true, {0, 0.00275}},
    {"fifths", DepthCodingKind::metric, 0.0002, 9, 0.0002, true, {0, 0.003}},
    {"tenths", DepthCodingKind::metric, 0.1, 6.5, 0.0001, true, {}},
    {"log", DepthCodingKind::log, 0.01, 10, 0, false, {}, 3.5},
    {"log, high is near", DepthCodingKind::log, 0.3, 8, 0, true, {0, 0.002}, 0},
};

Scene looked_up_scene(const LookedUpCase& of, double noise = 0) {
    Scene scene;
    scene.width = 640;
    scene.height = 480;
    scene.camera = {525, 525, 320, 240};
    scene.metres_per_unit = 1;
    scene.depth_bits = 16;
    scene.depth.kind = of.kind;
    scene.depth.near_is_high = of.near_is_high;
    scene.depth.near = of.near;
    scene.depth.far = of.far;
    scene.depth.scale = of.scale;
    scene.depth.shift = of.shift;
    scene.depth.code_max = 65535;
    scene.depth.invalid_codes = {30000};
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    scene.filter.terraces = TerraceRemoval::on;
    scene.filter.levels = of.levels;
    scene.filter.terrace_noise = noise;
    return scene;
}

TEST(WorkingCodes, AreTheNearestToEveryStoredDepthAndInItsOrder) {
    for (const LookedUpCase& of : looked_up_cases) {
        SCOPED_TRACE(of.name);
        const Scene scene = looked_up_scene(of);
        const auto working = working_codes(scene);
        ASSERT_TRUE(working && working->table);
        ASSERT_EQ(working->table->size(), 65536U);
        EXPECT_LE(working->coding.code_max, terrace_range);
        EXPECT_EQ(working->coding.deeper_is_higher(), scene.depth.deeper_is_higher());
        int before = 0;
        for (int code = scene.depth.valid_min; code <= scene.depth.valid_max; ++code) {
            const int found = working->of(code);
            ASSERT_GE(found, before) << code;
            before = found;
            const double depth = scene.depth.depth(static_cast<std::uint16_t>(code)),
                         there = working->coding.depth(static_cast<std::uint16_t>(found)),
                         step = step_of_code(working->coding, static_cast<std::uint16_t>(found));
            ASSERT_LE(std::fabs(there - depth), 0.501 * step + 1e-9) << code;
            ASSERT_TRUE(working->coding.is_valid(static_cast<std::uint16_t>(found))) << code;
        }
    }
}

// Rounding to codes is half of a step.
TEST(WorkingCodes, AreFineAgainstAPixelFromAFiftiethOfTheDeepestDepthOn) {
    for (const LookedUpCase& of : looked_up_cases) {
        const Scene scene = looked_up_scene(of);
        const DepthCoding coding = working_codes(scene)->coding;
        for (double depth = std::max(of.near, of.far / 50); depth < of.far; depth *= 1.1) {
            const double kappa = step_of_code(coding, coding.code(depth)) / (depth / 525);
            EXPECT_LT(kappa, 0.18) << of.name << " at " << depth;
        }
    }
}

TEST(WorkingCodes, OfASurfaceDoNotDependOnWhatIsFarBehindIt) {
    LookedUpCase stray = looked_up_cases[4];
    for (stray.far = 8.2; stray.far < 42; stray.far *= 1.3) {
        const DepthCoding coding = working_codes(looked_up_scene(stray))->coding;
        EXPECT_LT(step_of_code(coding, coding.code(0.5)), 0.0003)
            << stray.far << ": less than a third of a millimetre";
    }
}

// The curves are what a double says, but for rounding coefficients and two of three products down.
TEST(WorkingCodes, LevelsAndStepsAreThoseOfTheScene) {
    for (const double noise : {0.0, 0.5, 4.0})
        for (const LookedUpCase& of : looked_up_cases) {
            SCOPED_TRACE(of.name);
            const Scene scene = looked_up_scene(of, noise);
            const auto filter = terrace_filter(scene);
            ASSERT_TRUE(filter);
            const DepthCoding& coding = filter->working.coding;
            const DepthLength stored = code_step(scene.depth);
            for (int part = 0; part <= 64; ++part) {
                const auto code = static_cast<std::uint16_t>(coding.code_max * part / 64);
                const double depth = coding.depth(code), step = stored.at(depth);
                const double length = std::max(of.levels.at(depth), step) + 0.6 * noise * step;
                const double beyond = depth + coding.shift;
                const double of_code = beyond * beyond *
                                       (1 / (coding.near + coding.shift) - 1 / (coding.far + coding.shift)) /
                                       coding.code_max;
                const double expected = std::clamp(length / of_code, 1.0, 2900.0);
                EXPECT_NEAR(filter->level_at(code), expected, 1.5 + expected / 1000) << depth;
                EXPECT_LE(code + filter->gate_at(code), terrace_range);
            }
        }
}

/// Of however few codes, as no curve of levels is exact in them; the step is that of every depth, roughly.
TEST(WorkingCodes, OfLogCodesAreAlwaysLookedUp) {
    LookedUpCase lerobot = looked_up_cases[7];
    Scene scene = looked_up_scene(lerobot);
    scene.depth.code_max = 4095;
    derive_valid_range(scene.depth);
    const auto working = working_codes(scene);
    ASSERT_TRUE(working && working->table);
    const double ends = std::log(13.5 / 3.51) / 4095;
    for (double depth = 0.02; depth < 10; depth += 0.01) {
        const double truth = (depth + 3.5) * ends;
        EXPECT_NEAR(code_step(scene.depth).at(depth), truth, 0.2 * truth) << depth;
        if (depth < 3) {
            EXPECT_LT(step_of_code(working->coding, working->coding.code(depth)), truth / 4) << depth;
        }
    }
    EXPECT_TRUE(terraces_advised(scene));
}

TEST(WorkingCodes, AreLookedUpOnce) {
    Scene scene = looked_up_scene(looked_up_cases[4]);
    scene.filter.temporal = true;
    scene.filter.temporal_noise = {0.001, 0};
    EXPECT_TRUE(temporal_filter(scene)->working.table);
    EXPECT_FALSE(terrace_filter(scene)->working.table);
    EXPECT_EQ(terrace_filter(scene)->coding.code_max, 2 * temporal_filter(scene)->coding.code_max);
    scene.filter.terraces = TerraceRemoval::off;
    EXPECT_FALSE(temporal_filter(scene)->working.table) << "averaging alone has room in the stored codes";
}

TEST(WorkingCodes, AreNotThereWhereLevelsLeaveNoRoom) {
    Scene scene = looked_up_scene(looked_up_cases[2]);
    scene.filter.levels = {1e9, 0};
    EXPECT_FALSE(has_working_codes(scene));
    EXPECT_FALSE(terrace_filter(scene));
}

}  // namespace
}  // namespace touchable
