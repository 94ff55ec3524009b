// What a person may do to forces on their way to the hand, and what the report says of their energy.
#include <gtest/gtest.h>

#include <set>

#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;

class TouchShaping : public ::testing::Test {
protected:
    void make(const std::string& scene) const {
        make_clip(scene, clip(), {"--size", "72x48", "--frames", "6"});
    }
    std::string clip() const { return folder / "clip.mkv"; }
    Words with(const Words& more) const {
        Words words{clip(), "--seconds", "2", "--hand", hand};
        words.insert(words.end(), more.begin(), more.end());
        return words;
    }
    /// Rows of a run in which a bit of the guard is set.
    int rows_with(int bit, const Words& more) const {
        Words words = with(more);
        words.insert(words.end(), {"--forces", folder / "forces.csv"});
        touch(words);
        int rows = 0;
        for (const ForcesRow& row : read_forces(folder / "forces.csv"))
            rows += (static_cast<int>(row["guard"]) & bit) != 0;
        return rows;
    }

    TemporaryFolder folder;
    std::string hand = "stroke:speed=0.3";  // from land to water and back
};

const std::vector<Words> shapings{{"--stribeck", "0.05"},
                                  {"--stiffness", "passive"},
                                  {"--stiffness-slew", "5"},
                                  {"--damping", "3"},
                                  {"--passivity", "20"}};

TEST_F(TouchShaping, TheReportSaysHowLongTheDevicesForceWasNotEnough) {
    make("globe");
    const auto free = touch(with({"--max-force", "1000"}));
    EXPECT_EQ(free["force_limited"]["finger_ticks"], 0);
    const Words weak{"--max-force", "0.4", "--fingers", "3"};
    const int rows = rows_with(2, weak);
    ASSERT_GT(rows, 100);
    const auto report = touch(with(weak));
    EXPECT_EQ(report["force_limited"]["finger_ticks"], rows);
    const int longest = report["force_limited"]["longest_ticks"];
    EXPECT_GT(longest, 10);
    EXPECT_LE(longest, rows);
    Words words = with(weak);
    words.insert(words.begin(), "touch");
    EXPECT_NE(run_touchable(words).out.find("at the device's limit for"), std::string::npos);
}

TEST_F(TouchShaping, EachIsFeltAndRepeatsToTheBit) {
    make("globe");  // land and water differ in stiffness and friction
    const std::string plain = force_hash(with({}));
    EXPECT_EQ(
        force_hash(with({"--stribeck", "0", "--stiffness", "map", "--damping", "0", "--passivity", "0"})),
        plain)
        << "the defaults";
    std::set<std::string> all{plain};
    const std::string recording = folder / "run.rec";
    for (const Words& shaping : shapings) {
        Words words = with(shaping);
        if (shaping[0] == "--passivity") words.insert(words.end(), {"--metric", "pixel"});
        words.insert(words.end(), {"--record", recording});
        EXPECT_TRUE(all.insert(force_hash(words)).second) << shaping[0] << " changed nothing";
        const Outcome again = run_touchable({"touch", "--replay", recording});
        EXPECT_EQ(again.code, 0) << shaping[0] << ": " << again.err;
    }
}

TEST_F(TouchShaping, ForcesThatAreNotTheSolversSayWhy) {
    make("globe");
    EXPECT_EQ(rows_with(16 | 32 | 64, {}), 0);
    EXPECT_GT(rows_with(16, {"--stiffness", "passive"}), 5);
    EXPECT_GT(rows_with(16, {"--stiffness-slew", "5"}), 5);
    EXPECT_GT(rows_with(32, {"--damping", "3"}), 100);
}

TEST_F(TouchShaping, TheControllerBrakesInThePapersMetricAndNotInTheWorlds) {
    make_clip("globe", clip(), {"--plain", "--size", "72x48", "--frames", "2"});
    hand = "press:x=0.6,y=0.4,depth=4";
    EXPECT_EQ(rows_with(64, {"--passivity", "20"}), 0);
    EXPECT_GT(rows_with(64, {"--passivity", "20", "--metric", "pixel"}), 100);
}

TEST_F(TouchShaping, TheReportAccountsForEnergy) {
    make_clip("globe", clip(), {"--plain", "--size", "72x48", "--frames", "2"});
    hand = "press:x=0.6,y=0.4,depth=4";
    const auto world = touch(with({}))["energy_mj"], pixel = touch(with({"--metric", "pixel"}))["energy_mj"];
    for (const char* name : {"created", "zoh_bound", "surface", "on_hand"})
        EXPECT_TRUE(world[name].is_number()) << name;
    EXPECT_GT(world["zoh_bound"], 0);
    EXPECT_LE(world["created"], world["zoh_bound"]);
    EXPECT_GT(pixel["created"], 10 * pixel["zoh_bound"].get<double>());
    const Outcome told = run_touchable({"touch", clip(), "--seconds", "0.3", "--verbose"});
    EXPECT_NE(told.out.find("energy from nowhere"), std::string::npos) << told.out;
}

TEST_F(TouchShaping, EnergyThatTheClipsStiffnessGivesIsSaidToBeThat) {
    make_clip("globe", clip(), {"--size", "72x48", "--frames", "60"});
    hand = "press:x=0.4,y=0.4,depth=8";  // it rests, and water and land turn below it
    const auto report = touch(with({}));
    ASSERT_LT(report["stiffness_limited"]["smallest_n_mm"], report["stiffness_limited"]["largest_n_mm"]);
    ASSERT_GT(report["energy_mj"]["created"], report["energy_mj"]["zoh_bound"]) << "this hand shows nothing";
    EXPECT_TRUE(report["energy_mj"]["of_the_map"].get<bool>());
    const auto passive = touch(with({"--stiffness", "passive"}))["energy_mj"];
    EXPECT_LE(passive["created"], passive["zoh_bound"]);
    EXPECT_FALSE(passive["of_the_map"].get<bool>());
}

TEST_F(TouchShaping, TheReportSaysWhatStiffnessWasAskedForAndHowOftenItWasLimited) {
    make("bumps");
    const auto soft = touch(with({}))["stiffness_limited"];
    EXPECT_EQ(soft["ticks"], 0);
    EXPECT_DOUBLE_EQ(soft["largest_n_mm"].get<double>(), 0.6);
    const auto report = touch(with({"--max-stiffness", "0.2"}));
    EXPECT_EQ(report["stiffness_limited"]["ticks"], report["contact_ticks"]);
    EXPECT_DOUBLE_EQ(report["stiffness_limited"]["largest_n_mm"].get<double>(), 0.6);
}

TEST_F(TouchShaping, WhatCannotBeIsRefused) {
    make("plane");
    for (const Words& wrong : std::vector<Words>{{"--stribeck", "-1"},
                                                 {"--stribeck", "nan"},
                                                 {"--stiffness", "hard"},
                                                 {"--stiffness-slew", "0"},
                                                 {"--stiffness-slew", "nan"},
                                                 {"--damping", "-1"},
                                                 {"--damping", "101"},
                                                 {"--damping", "nan"},
                                                 {"--passivity", "-1"},
                                                 {"--passivity", "1e9"}}) {
        Words words = with(wrong);
        words.insert(words.begin(), "touch");
        const Outcome run = run_touchable(words);
        EXPECT_EQ(run.code, 2) << wrong[0] << ' ' << wrong[1];
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(wrong[0]), std::string::npos) << run.err;
    }
}

}  // namespace
}  // namespace touchable::test
