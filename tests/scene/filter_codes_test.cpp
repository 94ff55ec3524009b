// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <tuple>

#include "engine/base/words.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/scene/scene.hpp"

// Codes that are looked up because multiplied ones would not fit 15 bits.
namespace touchable::test {
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

TEST(WorkingCodes, AreNearestAndInOrder) {
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
TEST(WorkingCodes, AreFineAgainstPixels) {
    for (const LookedUpCase& of : looked_up_cases) {
        const Scene scene = looked_up_scene(of);
        const DepthCoding coding = working_codes(scene)->coding;
        for (double depth = std::max(of.near, of.far / 50); depth < of.far; depth *= 1.1) {
            const double kappa = step_of_code(coding, coding.code(depth)) / (depth / 525);
            EXPECT_LT(kappa, 0.18) << of.name << " at " << depth;
        }
    }
}

TEST(WorkingCodes, StayFineDespiteFarStrays) {
    LookedUpCase stray = looked_up_cases[4];
    for (stray.far = 8.2; stray.far < 42; stray.far *= 1.3) {
        const DepthCoding coding = working_codes(looked_up_scene(stray))->coding;
        EXPECT_LT(step_of_code(coding, coding.code(0.5)), 0.0003)
            << stray.far << ": less than a third of a millimetre";
    }
}

// The curves are what a double says, but for rounding coefficients and two of three products down.
TEST(WorkingCodes, KeepLevelsAndSteps) {
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

/// However few codes there are, no curve of levels is exact in them; the step fits every depth, roughly.
TEST(WorkingCodes, AreLookedUpForLog) {
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

TEST(WorkingCodes, NeedRoomBetweenLevels) {
    Scene scene = looked_up_scene(looked_up_cases[2]);
    scene.filter.levels = {1e9, 0};
    EXPECT_FALSE(has_working_codes(scene));
    EXPECT_FALSE(terrace_filter(scene));
}

// The table of filters' settings, which scene files, options, windows and reports use.

const FilterSetting& setting_of(std::string_view name) {
    return *std::ranges::find(filter_settings(), name,
                              [](const FilterSetting& setting) { return std::string_view(setting.name); });
}

TEST(SettingRange, TakesNamesAndNumbersOnly) {
    const SettingRange names{.words = {"off", "on", "auto"}}, sides{.words = {"0", "3", "5"}, .whole = true},
        passes{.most = 16, .whole = true, .unit = "passes"}, force{.least = 0.1, .most = 20, .unit = "N"};
    EXPECT_EQ(names.value_of("auto"), 2);
    EXPECT_EQ(names.word_of(1), "on");
    EXPECT_EQ(names.value_of("1"), std::nullopt);
    EXPECT_EQ(names.in_words(), "off, on or auto");
    EXPECT_EQ(sides.value_of("5"), 5);
    EXPECT_EQ(sides.value_of("4"), std::nullopt);
    EXPECT_TRUE(sides.has(3));
    EXPECT_FALSE(sides.has(1)) << "which is a place, and no side";
    for (const char* word : {"17", "-1", "1.5", "2.0", "1e1", "x", "", " 2", "nan"})
        EXPECT_EQ(passes.value_of(word), std::nullopt) << word;
    EXPECT_EQ(passes.value_of("010"), 10);
    EXPECT_EQ(passes.in_words(), "a whole number from 0 to 16 passes");
    EXPECT_EQ(force.value_of("2.50"), 2.5);
    EXPECT_EQ(force.word_of(2.5), "2.5");
    for (const char* word : {"0.05", "21", "inf", "nan", "2,5"})
        EXPECT_EQ(force.value_of(word), std::nullopt) << word;
}

TEST(FilterSetting, HasOwnNameAndDefault) {
    std::set<std::string> names;
    for (const FilterSetting& setting : filter_settings()) {
        EXPECT_TRUE(names.insert(setting.name).second) << setting.name;
        EXPECT_TRUE(setting.is_default({})) << setting.name;
        EXPECT_TRUE(setting.range.is_length || setting.range.has(setting.value.of({}).constant))
            << setting.name;
        FilterSettings named;
        if (*setting.usual) {
            EXPECT_TRUE(setting.read(setting.usual, named)) << setting.name;
            EXPECT_FALSE(setting.is_default(named)) << setting.name;
        }
        EXPECT_TRUE((!*setting.what && !*setting.in_list) || setting.open)
            << setting.name << ": a choice says whether it is stated";
    }
    EXPECT_EQ(with_dashes(setting_of("fill_holes").name), "fill-holes");
}

TEST(FilterSetting, ReadsTypedValues) {
    FilterSettings filter;
    EXPECT_TRUE(setting_of("terraces").read("auto", filter));
    EXPECT_EQ(filter, FilterSettings{.terraces = TerraceRemoval::automatic});
    EXPECT_FALSE(setting_of("terraces").read("2", filter));
    const FilterSetting& temporal = setting_of("temporal");
    for (const char* word : {"1.5,2e-6", "1.5+2e-6"}) {
        filter = {};
        EXPECT_TRUE(temporal.read(word, filter)) << word;
        EXPECT_EQ(filter, (FilterSettings{.temporal = true, .temporal_noise = {1.5, 2e-6}})) << word;
    }
    EXPECT_TRUE(temporal.read("1e+5", filter));
    EXPECT_EQ(filter.temporal_noise, (DepthLength{1e5, 0}));
    for (const char* word : {"", "0", "0,0", "-1", "1,", ",1", "1,2,3", "1,-1", "nan", "much"})
        EXPECT_FALSE(temporal.read(word, filter)) << word;
    EXPECT_TRUE(temporal.read("on", filter));
    EXPECT_EQ(filter, FilterSettings{.temporal = true}) << "the noise is the scene's again";
    EXPECT_FALSE(setting_of("flying_pixels").read("on", filter));
    EXPECT_TRUE(setting_of("flying_pixels").read("2", filter));
    EXPECT_EQ(filter.flying_pixels, (DepthLength{2, 0}));
}

TEST(FilterSetting, CopiesItsLength) {
    const FilterSetting& temporal = setting_of("temporal");
    FilterSettings scene{.median = 5, .temporal_noise = {3, 0}};
    temporal.copy({.median = 3, .temporal = true}, scene);
    EXPECT_EQ(scene, (FilterSettings{.median = 5, .temporal = true, .temporal_noise = {3, 0}}));
    temporal.copy({.temporal_noise = {4, 1}}, scene);
    EXPECT_EQ(scene, (FilterSettings{.median = 5, .temporal_noise = {4, 1}}));
}

TEST(FilterSetting, LeavesReachOpenWithRemoval) {
    const FilterSetting& reach = setting_of("terrace_reach");
    EXPECT_TRUE(reach.is_open_if_left_out({}, {.terraces = true}));
    EXPECT_TRUE(reach.is_open_if_left_out({.terraces = TerraceRemoval::automatic}, {}));
    EXPECT_FALSE(reach.is_open_if_left_out({.terraces = TerraceRemoval::on}, {.median = true}));
    EXPECT_TRUE(setting_of("median").is_open_if_left_out({}, {}));
    EXPECT_FALSE(setting_of("levels").is_open_if_left_out({}, {}));
}

/// The camera of a globe, and `bits` of depth between its planes.
Scene globe_scene(DepthCodingKind kind, int bits, bool near_is_high = true) {
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

Scene coded(DepthCodingKind kind, int code_max, bool near_is_high, DepthLength noise) {
    Scene scene = globe_scene(kind, 16, near_is_high);
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

TEST(TemporalCodes, ExpressGateInEveryCoding) {
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
TEST(TemporalCodes, ExpressGateInLogCodes) {
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

TEST(TemporalCodes, GrowGateWithNoise) {
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

TEST(TemporalCodes, NeverOverflow) {
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

TEST(TemporalCodes, LimitCoefficientsOfEqualPlanes) {
    Scene scene = coded(DepthCodingKind::inverse, 255, true, {6, 1e-6});
    scene.depth.near = 1.5000000000000002;
    scene.depth.far = std::nextafter(scene.depth.near, 2);
    ASSERT_EQ(1 / scene.depth.near, 1 / scene.depth.far);
    const CodeCurve gate = temporal_filter(scene)->gate;
    for (const int coefficient : {gate.constant, gate.linear, gate.quadratic}) EXPECT_EQ(coefficient, 21845);
}

TEST(TemporalCodes, ShrinkGateAfterMedian) {
    Scene scene = coded(DepthCodingKind::linear, 65535, true, {6, 0});
    const int after5 = temporal_filter(scene)->gate.at(0);
    EXPECT_NEAR(after5, 6 * 65535 / 2400, 1);
    scene.filter.median = 3;
    EXPECT_NEAR(temporal_filter(scene)->gate.at(0), after5 * 4 / 3, 1);
    scene.filter.median = 0;
    EXPECT_NEAR(temporal_filter(scene)->gate.at(0), after5 * 2, 1);
}

TEST(TemporalCodes, AreFinerLikeTerraceCodes) {
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

TEST(TemporalCodes, AreOffByDefault) {
    Scene scene = coded(DepthCodingKind::linear, 255, true, {6, 0});
    scene.filter.temporal = false;
    EXPECT_FALSE(temporal_filter(scene));
}

Scene millimetres(double near, double far) {
    Scene scene = globe_scene(DepthCodingKind::metric, 16);
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
TEST(TerraceCodes, MultiplyWithinSixteenBits) {
    const std::pair<int, int> expected[] = {{8, 126}, {9, 63}, {10, 31}, {11, 15},
                                            {12, 7},  {13, 3}, {14, 0},  {16, 0}};
    for (const auto& [bits, factor] : expected)
        EXPECT_EQ(multiplied_by(globe_scene(DepthCodingKind::linear, bits)), factor) << bits;
    Scene few = globe_scene(DepthCodingKind::linear, 8);
    few.depth.code_max = 15;
    EXPECT_EQ(multiplied_by(few), 126);
    Scene hue = globe_scene(DepthCodingKind::hue, 8, false);
    hue.depth.code_max = 1536;
    EXPECT_EQ(multiplied_by(hue), 21);
    EXPECT_EQ(multiplied_by(millimetres(300, 1000)), 32) << "codes beyond `far` need no room";
    EXPECT_EQ(multiplied_by(millimetres(300, 1500)), 16) << "of metric codes a power of two";
    EXPECT_EQ(multiplied_by(millimetres(300, 4090)), 8);
    EXPECT_EQ(multiplied_by(millimetres(300, 4091)), 0)
        << "four times as many would be coarse near the camera";
}

TEST(TerraceCodes, KeepValidRange) {
    Scene scene = globe_scene(DepthCodingKind::linear, 8);
    scene.depth.invalid_codes = {0, 255, 1, 90};
    scene.depth.invalid_code_count = 4;
    derive_valid_range(scene.depth);
    const DepthCoding fine = finer(scene.depth, 10);
    EXPECT_FALSE(fine.is_valid(19));
    for (int code = 20; code <= 2540; ++code) EXPECT_TRUE(fine.is_valid(static_cast<std::uint16_t>(code)));
    EXPECT_FALSE(fine.is_valid(2541));
    EXPECT_EQ(fine.depth(770), scene.depth.depth(77));
}

TEST(TerraceCodes, FitRangeWithMostNoise) {
    for (int code_max = 255; code_max < 65536; code_max = code_max * 9 / 8) {
        Scene scene = globe_scene(DepthCodingKind::linear, 16);
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

TEST(TerraceCodes, KeepUnchangedDepthsExactly) {
    std::vector<Scene> scenes;
    for (const auto kind : {DepthCodingKind::linear, DepthCodingKind::inverse})
        for (const int bits : {8, 10, 13})
            for (const bool near_is_high : {false, true})
                scenes.push_back(globe_scene(kind, bits, near_is_high));
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

TEST(TerraceCodes, GateByLevelAndNoise) {
    const auto quiet = terrace_filter(removed(globe_scene(DepthCodingKind::linear, 8)));
    EXPECT_EQ(quiet->gate_at(0), 157);  // 5/4 of 126
    EXPECT_EQ(quiet->most_at(0), 126);
    const auto noisy = terrace_filter(removed(globe_scene(DepthCodingKind::linear, 8), 1));
    EXPECT_EQ(noisy->gate_at(0), 252);  // (5 x 126 + 3 x 126)/4
    EXPECT_EQ(noisy->most_at(0), 220);
    const auto ten = terrace_filter(removed(globe_scene(DepthCodingKind::linear, 10), 0.3));
    EXPECT_EQ(ten->gate_at(0), (5 * 31 + 3 * 9) / 4);  // 0.3 x 31 = 9.3
    EXPECT_EQ(ten->most_at(0), (4 * 31 + 3 * 9) / 4);
}

// A camera that measures disparity and stores millimetres: levels are 11 mm apart at 2 m.
TEST(TerraceCodes, WidenGateForCoarseLevels) {
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
TEST(TerraceCodes, ExpressInverseLevels) {
    for (const bool near_is_high : {true, false}) {
        Scene scene = removed(globe_scene(DepthCodingKind::inverse, 10, near_is_high));
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

TEST(TerraceCodes, FitRangeWithAnyLevels) {
    for (const double constant : {0.0, 3.0, 500.0, 1e9})
        for (const double quadratic : {0.0, 1e-6, 1e-3, 1e9})
            for (const auto kind :
                 {DepthCodingKind::linear, DepthCodingKind::inverse, DepthCodingKind::metric})
                for (const int bits : {8, 10, 12, 16}) {
                    Scene scene = kind == DepthCodingKind::metric ? millimetres(20, (1 << bits) - 1)
                                                                  : globe_scene(kind, bits);
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
TEST(TerraceCodes, AdviseRemovalByKappa) {
    Scene scene = globe_scene(DepthCodingKind::linear, 8);
    EXPECT_NEAR(kappa_of_scene(scene), 140.0 / 255 / (110.0 / 420), 1e-9);
    for (const auto& [bits, advised] : {std::pair{8, true}, {11, true}, {12, false}, {16, false}}) {
        scene = globe_scene(DepthCodingKind::linear, bits);
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
}  // namespace touchable::test
