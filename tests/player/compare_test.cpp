// What differs between two runs of the same hand.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>
#include <numbers>

#include "player/run/run_files.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/temporary_folder.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;

/// A finger that presses with this force in every tick.
template <class ForceAt>
ForceTable pressing(std::size_t ticks, ForceAt force_at) {
    ForceTable table;
    table.fingers = 1;
    for (std::size_t tick = 0; tick < ticks; ++tick)
        table.samples.push_back(
            {{1, 2, -static_cast<double>(tick)}, force_at(0.001 * static_cast<double>(tick)), true});
    return table;
}

TEST(CompareForces, ARunIsTheSameAsItself) {
    const ForceTable a = pressing(600, [](double t) { return glm::dvec3(0, t, 1); });
    const auto same = compare_forces(a, a);
    ASSERT_TRUE(same);
    EXPECT_EQ(same->both, 600);
    EXPECT_EQ(same->difference_n.max, 0);
    EXPECT_EQ(same->direction_degrees.max, 0);
    EXPECT_EQ(same->noise_a_n, same->noise_b_n);
    EXPECT_TRUE(same->worst.empty());
}

TEST(CompareForces, DirectionAndLengthAreToldApart) {
    const double turned = 10 * std::numbers::pi / 180;
    const ForceTable a = pressing(300, [](double) { return glm::dvec3(0, 0, 2); });
    const ForceTable b =
        pressing(300, [&](double) { return 1.5 * glm::dvec3(std::sin(turned), 0, std::cos(turned)); });
    const auto c = compare_forces(a, b);
    ASSERT_TRUE(c);
    EXPECT_NEAR(c->direction_degrees.mean, 10, 1e-9);
    EXPECT_NEAR(c->longer_n, 0.5, 1e-12);
    const double apart = std::sqrt(4 + 2.25 - 2 * 2 * 1.5 * std::cos(turned));
    EXPECT_NEAR(c->difference_n.p95, apart, 1e-12);
    ASSERT_EQ(c->worst.size(), 5U) << "of each 50 ms one";
    EXPECT_EQ(c->worst[0].tick, 0);
    EXPECT_EQ(c->worst[1].tick, 50);
}

TEST(CompareForces, AHumIsFoundInItsBand) {
    const ForceTable quiet = pressing(1024, [](double) { return glm::dvec3(0, 0, 1); });
    for (const auto& [hz, band] : {std::pair{12.0, 0U}, {50.0, 1U}, {150.0, 2U}, {400.0, 3U}}) {
        const ForceTable humming = pressing(1024, [hz = hz](double t) {
            return glm::dvec3(0, 0.1 * std::sin(2 * std::numbers::pi * hz * t), 1);
        });
        const auto c = compare_forces(humming, quiet);
        ASSERT_TRUE(c);
        EXPECT_EQ(c->noise_windows, 4);
        for (std::size_t k = 0; k < ForceComparison::noise_bands.size(); ++k) {
            const double rms = 0.1 / std::numbers::sqrt2;
            EXPECT_NEAR(c->noise_a_n[k], k == band ? rms : 0, 0.05 * rms) << hz << " Hz, band " << k;
            EXPECT_NEAR(c->noise_b_n[k], 0, 1e-12);
        }
    }
}

TEST(CompareForces, WhoTouchesIsCounted) {
    ForceTable a = pressing(4, [](double) { return glm::dvec3(0, 0, 1); }), b = a;
    a.samples[1] = b.samples[2] = {{1, 2, -1}, {}, false};
    a.samples[2].goal = b.samples[2].goal;
    b.samples[1].goal = a.samples[1].goal;
    a.samples[3].goal.x += 1e-9;
    const auto c = compare_forces(a, b);
    ASSERT_TRUE(c);
    EXPECT_EQ(c->both, 1);
    EXPECT_EQ(c->only_b, 1);
    EXPECT_EQ(c->only_a, 1);
    EXPECT_EQ(c->other_goals, 1);
    EXPECT_EQ(c->noise_windows, 0);
}

TEST(CompareForces, RunsThatHaveNothingInCommonAreRefused) {
    const ForceTable a = pressing(3, [](double) { return glm::dvec3(0, 0, 1); });
    ForceTable other = a, two = a;
    for (ForceTable::Sample& sample : other.samples) sample.goal.x = 7;
    EXPECT_EQ(compare_forces(a, other).error().kind, ErrorKind::usage);
    two.fingers = 3;
    EXPECT_EQ(compare_forces(a, two).error().kind, ErrorKind::usage);
}

TEST(Compare, RefusesWhatIsNoForcesFile) {
    const TemporaryFolder folder;
    const std::string good = folder / "a.csv", bad = folder / "b.csv";
    const std::string header = "tick,finger,goal_x,goal_y,goal_z,force_x,force_y,force_z,contact\n";
    std::ofstream(good) << header << "0,0,1,2,3,0,0,1,1\n1,0,1,2,3,0,0,1,1\n";
    for (const auto& [rows, word] :
         {std::pair<std::string, const char*>{"tick,finger\n0,0\n", "goal_x"},
          {header + "0,0,1,2,3,0,0,1,1\n2,0,1,2,3,0,0,1,1\n", "line 3"},
          {header + "0,0,1,2,3,0,0,x,1\n", "line 2"},
          {header + "0,0,1,2,3,0,0,1,1\n0,1,1,2,3,0,0,1,1\n1,0,1,2,3,0,0,1,1\n", "lacks"}}) {
        std::ofstream(bad) << rows;
        const Outcome outcome = run_touchable({"compare", good, bad});
        EXPECT_EQ(outcome.code, 3) << outcome.err;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_NE(outcome.err.find(word), std::string::npos) << outcome.err;
    }
    EXPECT_EQ(run_touchable({"compare", good}).code, 2);
    EXPECT_EQ(run_touchable({"compare", good, good}).code, 0);
}

/// Two fingers over a globe of few bits, and the same goals with a filter and without.
TEST(Compare, AFilterIsJudgedByTheVeryGoalsOfARecording) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", rec = "rec:" + (folder / "a.rec").string();
    const std::string a = folder / "a.csv", b = folder / "b.csv", again = folder / "again.csv";
    make_clip("globe", clip, {"--size", "160x120", "--frames", "12", "--bits", "8"});
    const auto first = touch({clip, "--fingers", "2", "--seconds", "0.6", "--median", "0", "--record",
                              folder / "a.rec", "--forces", a});
    const auto same = touch({clip, "--hand", rec, "--median", "0", "--forces", again});
    EXPECT_EQ(same["force_hash"], first["force_hash"]);
    EXPECT_EQ(same["fingers"], 2);
    EXPECT_EQ(same["ticks"], 600);
    const auto filtered = touch({clip, "--hand", rec, "--median", "5", "--forces", b});
    EXPECT_NE(filtered["force_hash"], first["force_hash"]);

    EXPECT_NE(run_touchable({"compare", a, again}).out.find("every force is the same"), std::string::npos);
    const Outcome outcome = run_touchable({"compare", a, b, "--json"});
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto report = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(report["other_goals"], 0);
    EXPECT_EQ(report["fingers"], 2);
    EXPECT_GT(report["contact"]["both"], 300);
    EXPECT_GT(report["difference_n"]["max"], 0);
    const Outcome table = run_touchable({"compare", a, b});
    for (const char* word : {"contact ", "difference ", "direction ", "noise ", "worst "})
        EXPECT_NE(table.out.find(word), std::string::npos) << table.out;
}

TEST(Compare, ARecordedHandIsRefusedWhereItCannotBe) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", rec = "rec:" + (folder / "a.rec").string();
    make_clip("globe", clip, {"--size", "80x60", "--frames", "3"});
    touch({clip, "--fingers", "2", "--seconds", "0.1", "--record", folder / "a.rec"});
    for (const auto& [words, code, say] : {std::tuple{Words{"--hand", "rec:"}, 2, "--record"},
                                           {Words{"--hand", "rec:no.rec"}, 3, "no.rec"},
                                           {Words{"--hand", rec + ":speed=2"}, 2, "depth"},
                                           {Words{"--hand", rec, "--fingers", "3"}, 2, "has 2"},
                                           {Words{"--hand", "rec:" + clip}, 3, "globe.mkv"}}) {
        Words all{"touch", clip};
        all.insert(all.end(), words.begin(), words.end());
        const Outcome outcome = run_touchable(all);
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_NE(outcome.err.find(say), std::string::npos) << outcome.err;
    }
    // An input is never replaced, a hand's file neither.
    const Outcome kept =
        run_touchable({"touch", clip, "--hand", rec, "--record", folder / "a.rec", "--overwrite"});
    EXPECT_EQ(kept.code, 2) << kept.err;
}

}  // namespace
}  // namespace touchable::test
