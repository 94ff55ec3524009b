// SPDX-License-Identifier: Apache-2.0
// A slice of the stress suites, every tick certified: `touchable-soak` goes on where this ends
// (docs/paper.md).

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <sstream>
#include <utility>

#include "tests/stress/golden_runs.hpp"
#include "tests/stress/soak.hpp"
#include "tests/stress/suites.hpp"
#include "tests/stress/watch.hpp"

namespace touchable::stress {

void PrintTo(const Suite& suite, std::ostream* out) {
    *out << suite.what;
}

namespace {

constexpr std::uint64_t seeds = 8;
constexpr std::int64_t ticks_each = 1500;

class Stress : public testing::TestWithParam<Suite> {};

TEST_P(Stress, InvariantsHoldAndRunsRepeat) {
    const Suite& suite = GetParam();
    Coverage coverage;
    for (std::uint64_t seed = 0; seed < seeds; ++seed) {
        const Watched watched = watch(*suite.run(seed), {ticks_each, 1, 16});
        for (const std::string& violation : watched.violations)
            ADD_FAILURE() << "--suite " << suite.name << " --seed " << seed << ": " << violation;
        EXPECT_EQ(watch(*suite.run(seed), {ticks_each, 0, 0}).force_hash, watched.force_hash)
            << "S6, seed " << seed;
        coverage.add(watched.coverage);
    }
    EXPECT_EQ(coverage.missing(suite.needs), "");
    std::cout << suite.name << ": " << coverage.in_words() << '\n';
}

INSTANTIATE_TEST_SUITE_P(Suites, Stress, testing::ValuesIn(suites().begin(), suites().end()),
                         [](const auto& suite) { return name_of_test(suite.param.name); });

struct Known {
    const char* suite;
    std::uint64_t seed;
    std::int64_t ticks;
    int compare_every = 0;
};
/// Gives how many ticks were cut off.
std::int64_t expect_no_violation(const Known& known) {
    const Watched watched =
        watch(*find_suite(known.suite)->run(known.seed), {known.ticks, 1, known.compare_every});
    EXPECT_EQ(watched.violation_count, 0) << known.suite << ' ' << known.seed;
    return watched.coverage.capped;
}

// docs/paper.md, what it found: a foot on the very rim of a face; a proxy that had to stay on the surface and
// comes to its foot there, or within its friction; a way a few roundings beside a row of vertices; a fraction
// of a pixel whose rounding is a tenth of a millimetre.
TEST(Stress, EarlyRestRunsReachMinimum) {
    for (const Known& known :
         {Known{"lattice-lines", 9, 2000}, Known{"lattice-lines", 28, 3000}, Known{"lattice-lines", 32, 4000},
          Known{"lattice-lines", 7, 19000}, Known{"far-million", 0, 13000}, Known{"far-million", 355, 7000},
          Known{"height-limit", 204, 12000}, Known{"lattice-lines", 535, 8100},
          Known{"lattice-lines", 1941, 1700}, Known{"rising", 438, 13300}, Known{"corner-jumps", 1114, 50000},
          Known{"far-million", 2035, 17400}, Known{"lattice-lines", 566, 1300},
          Known{"lattice-lines", 19, 2100}})
        EXPECT_EQ(expect_no_violation(known), 0) << "places a rounding apart take turns: " << known.suite;
}

// Goals that come from a thousand pictures away: a way that long ended a rounding of its own beside its foot.
// And a goal a billion units below, so far that no step seemed to bring the proxy nearer. The last three
// created energy: a way from far aside that met the strip beyond the ring was put down in the middle of its
// last interval, thousands of pixels from where it met it; a step next to the camera's plane that wound up
// the spring; a landing a rounding before the goal.
TEST(Stress, OtherKnownRunsPass) {
    for (const Known& known : {Known{"camera-plane", 164, 6000, 16}, Known{"camera-plane", 296, 11000, 16},
                               Known{"camera-plane", 602, 19300, 16}, Known{"camera-plane", 918, 16200, 16},
                               Known{"camera-axis", 492, 7000}, Known{"height-limit", 827, 7000},
                               Known{"press-slide-retract", 830, 7000},
                               // A step of force: a jump without a goal cut the force that comes back.
                               Known{"jumping-walls", 185, 9000}})
        expect_no_violation(known);
}

TEST(Stress, GeneratedScenesPassEveryCheck) {
    Coverage coverage;
    for (const GoldenRun& golden : golden_runs()) {
        if (golden.metric != TouchMetric::world) continue;  // the paper's knows no minimum in the world
        const Watched watched = watch(*golden.make(GoldenBuilder::cpu), {GoldenRun::ticks, 1, 4});
        for (const std::string& violation : watched.violations)
            ADD_FAILURE() << golden.name << ": " << violation;
        coverage.add(watched.coverage);
    }
    EXPECT_GT(coverage.compared, 10000);
    EXPECT_LT(coverage.other_basins, 10);
    std::cout << coverage.in_words() << '\n';
}

TEST(Stress, CatchesPixelMetricEnergy) {
    const Watched watched = watch(*find_golden_run("globe-pixels")->make(GoldenBuilder::cpu), {1000, 0, 0});
    EXPECT_TRUE(
        std::any_of(watched.violations.begin(), watched.violations.end(),
                    [](const std::string& violation) { return violation.find("S7") != std::string::npos; }));
}

// A single suite need not meet with everything; all of them together must.
TEST(Stress, SuitesTogetherCoverEverything) {
    Coverage all;
    for (const Suite& suite : suites())
        for (std::uint64_t seed = 0; seed < 2; ++seed) all.add(watch(*suite.run(seed), {400, 4, 0}).coverage);
    EXPECT_GT(all.with_heights, 0);
    EXPECT_GT(all.with_friction, 0);
    EXPECT_GT(all.sliding, 0);
    EXPECT_GT(all.at_invalid, 0);
    EXPECT_GT(all.landings, 0);
    EXPECT_GT(all.departures, 0);
    EXPECT_GT(all.between_frames, 0);
    EXPECT_GT(all.held_goals, 0);
    EXPECT_GT(all.refusals, 0);
}

TEST(Stress, EmptyRunIsReported) {
    Coverage nothing;
    nothing.ticks = nothing.finger_ticks = 100;
    EXPECT_NE(nothing.missing({0.1}).find("contact"), std::string::npos);
    nothing.contact = nothing.certified = 50;
    EXPECT_EQ(nothing.missing({0.1}), "");
    EXPECT_NE(nothing.missing({0.1, true}), "");
    EXPECT_NE(nothing.missing({0.1, false, true}), "");
    EXPECT_NE(nothing.missing({0.1, false, false, true}), "");
    nothing.certified = 0;
    EXPECT_NE(nothing.missing({0.1}), "");
}

// The soak goes on where it ended, and trusts no state that is not its own.

namespace fs = std::filesystem;

class Soak : public testing::Test {
protected:
    Soak() : folder(fs::temp_directory_path() / ("touchable-soak-" + std::to_string(getpid()))) {
        settings.plan.unit_ticks = 300;
        settings.plan.replay_every = 5;
        settings.state = folder / "deep" / "state.json";
        settings.ticks = 300 * 66;
    }
    ~Soak() override { fs::remove_all(folder); }
    std::string contents() const {
        std::ostringstream text;
        text << std::ifstream(settings.state).rdbuf();
        return text.str();
    }
    Result<SoakState> run() { return soak(settings, progress); }

    fs::path folder;
    SoakSettings settings;
    std::ostringstream progress;
};

TEST_F(Soak, ResumesToSameState) {
    settings.threads = 1;
    const auto whole = run();
    ASSERT_TRUE(whole);
    EXPECT_EQ(whole->ticks(), settings.ticks);
    EXPECT_EQ(whole->violations, std::vector<std::string>());
    EXPECT_EQ(whole->coverage.size(), suites().size());
    const std::string one_go = contents();
    fs::remove(settings.state);
    settings.threads = 3;
    settings.ticks = 300 * 29;
    ASSERT_TRUE(run());
    settings.ticks = 300 * 66;
    ASSERT_TRUE(run());
    EXPECT_EQ(contents(), one_go);
    EXPECT_NE(progress.str().find("0 violations"), std::string::npos);
}

TEST_F(Soak, RejectsForeignStateUnlessFresh) {
    ASSERT_TRUE(run());
    std::string text = contents();
    const std::size_t at = text.find("\"solver\": \"") + 11;
    text[at] = text[at] == '0' ? '1' : '0';
    std::ofstream(settings.state) << text;
    auto refused = run();
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    EXPECT_NE(refused.error().message.find("another solver"), std::string::npos);
    settings.fresh = true;
    EXPECT_TRUE(run());
    settings.fresh = false;
    EXPECT_TRUE(run());
    settings.plan.certify_every = 3;
    EXPECT_FALSE(run());
}

TEST_F(Soak, RejectsInvalidState) {
    fs::create_directories(settings.state.parent_path());
    for (const char* text :
         {"", "{}", "[1]", "{\"soak\": 2}", "{\"soak\": 1, \"solver\": 3}", "violations"}) {
        std::ofstream(settings.state) << text;
        const auto refused = run();
        ASSERT_FALSE(refused) << text;
        EXPECT_EQ(refused.error().kind, ErrorKind::input);
        EXPECT_NE(refused.error().message.find("state.json"), std::string::npos);
    }
}

TEST_F(Soak, ReportsUnwritableState) {
    fs::create_directories(folder);
    std::ofstream(folder / "deep") << "a file";
    const auto refused = run();
    ASSERT_FALSE(refused);
}

TEST(SoakState, ViolationNamesItsReproduction) {
    SoakState state;
    Watched watched;
    watched.violation_count = 2;
    watched.violations = {"tick 7, finger 0: S1"};
    state.add(*find_suite("plateau"), 12, watched);
    EXPECT_EQ(state.violation_count, 2);
    EXPECT_EQ(state.violations.front(), "--suite plateau --seed 12 --ticks 20000: tick 7, finger 0: S1");
    ASSERT_EQ(state.empty_suites().size(), 1U);
    EXPECT_NE(state.empty_suites().front().find("plateau: contact"), std::string::npos);
}

// Where two runs part is found to the tick, the finger and the field.

std::string states_of(const GoldenRun& golden, GoldenBuilder builder, std::int64_t ticks) {
    std::ostringstream out;
    StateWriter writer(out);
    watch(*golden.make(builder), {ticks, 0, 0}, &writer);
    return out.str();
}

std::optional<std::string> difference_from(const std::string& recorded, const GoldenRun& golden,
                                           std::int64_t ticks) {
    std::istringstream in(recorded);
    StateComparison comparison(in);
    watch(*golden.make(GoldenBuilder::cpu), {ticks, 0, 0}, &comparison);
    return comparison.difference();
}

class TickStates : public testing::Test {
protected:
    const GoldenRun& golden = *find_golden_run("globe-planet");
    static constexpr std::int64_t ticks = 300;

    /// The recorded text with one character of a cell changed.
    std::string changed(std::string text, std::size_t row, const std::string& field) const {
        const auto& fields = state_fields();
        const auto column =
            static_cast<std::size_t>(std::find(fields.begin(), fields.end(), field) - fields.begin());
        std::size_t at = 0;
        for (std::size_t k = 0; k <= row; ++k) at = text.find('\n', at) + 1;
        for (std::size_t k = 0; k < column; ++k) at = text.find(',', at) + 1;
        const std::size_t end = text.find_first_of(",\n", at);
        text[end - 1] = text[end - 1] == '1' ? '2' : '1';
        return text;
    }
};

TEST_F(TickStates, RepeatWithEitherBuilder) {
    for (const GoldenBuilder builder : {GoldenBuilder::cpu, GoldenBuilder::lazy})
        EXPECT_EQ(difference_from(states_of(golden, builder, ticks), golden, ticks), std::nullopt);
}

TEST_F(TickStates, NameFirstDifferingField) {
    const std::string text = states_of(golden, GoldenBuilder::cpu, ticks);
    for (const auto& [row, field] : {std::pair{5 * 217 + 3, "a"},
                                     {5 * 100 + 0, "proxy_z"},
                                     {4, "guard"},
                                     {5 * 299 + 4, "force_x"},
                                     {5 * 8 + 1, "frame_next"}}) {
        const auto difference =
            difference_from(changed(text, static_cast<std::size_t>(row), field), golden, ticks);
        ASSERT_TRUE(difference);
        const std::string where = "tick " + std::to_string(row / 5) + ", finger " + std::to_string(row % 5) +
                                  ", field " + field + ":";
        EXPECT_EQ(difference->substr(0, where.size()), where) << *difference;
    }
}

TEST_F(TickStates, ReportDifferentLength) {
    const std::string text = states_of(golden, GoldenBuilder::cpu, ticks);
    EXPECT_NE(difference_from(text, golden, ticks - 1)->find("goes on"), std::string::npos);
    EXPECT_NE(
        difference_from(text, golden, ticks + 1)->find("tick 300, finger 0: the recorded run has ended"),
        std::string::npos);
    EXPECT_TRUE(difference_from("", golden, 1));
    EXPECT_TRUE(difference_from("tick,finger\n0,0\n", golden, 1));
}

}  // namespace
}  // namespace touchable::stress
