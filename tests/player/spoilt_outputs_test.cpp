// Outputs of a live run that cannot be written: a disk that is full, a pipe that nobody reads. The others are
// complete, and the run ends by itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "player/run/run_files.hpp"
#include "tests/player/program.hpp"
#include "tests/player/standstill.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

class SpoiltOutput : public ::testing::Test {
protected:
    SpoiltOutput() {
        const Outcome made = run_touchable({"make", "moving", clip, "--size", "64x48", "--frames", "12"});
        EXPECT_EQ(made.code, 0) << made.err;
    }
    static bool says(const std::string& text, const std::string& part) {
        return text.find(part) != std::string::npos;
    }
    /// Number of the last tick of a forces file.
    static std::int64_t last_tick(const std::string& rows) {
        const std::size_t end = rows.rfind('\n'), begin = rows.rfind('\n', end - 1);
        return std::stoll(rows.substr(begin + 1));
    }
    void expect_replayed(const std::string& part_of_error) {
        const Outcome replay = run_touchable({"touch", "--replay", record});
        EXPECT_EQ(replay.code, 0) << replay.err << part_of_error;
        EXPECT_TRUE(says(replay.out, "every force is as recorded, to the bit")) << replay.out;
        EXPECT_FALSE(says(replay.out, "frames are not the recorded ones")) << replay.out;
    }

    const TemporaryFolder folder;
    const std::string clip = folder / "moving.mkv", record = folder / "live.rec", forces = folder / "f.csv",
                      report = folder / "r.json";
};

TEST_F(SpoiltOutput, ADiskThatIsFullUnderTheRecordingKeepsTheForcesAndTheRecordingSoFar) {
    constexpr std::uintmax_t kibibytes = 64;
    const Outcome live = run_on_full_disk(
        {"touch", clip, "--live", "--seconds", "2.5", "--record", record, "--forces", "-", "--json", report},
        kibibytes);
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_TRUE(says(live.err, "touchable: warning: --record " + record + ": cannot be written: "))
        << live.err;
    EXPECT_TRUE(says(live.err, "touchable: --record " + record + ": cannot be written: ")) << live.err;
    // A busy machine skips ticks, and counts them; the last skip may reach beyond the end. None is missing
    // besides.
    const auto figures = nlohmann::json::parse(file_contents(report));
    const auto skipped = figures.at("skipped_ticks").get<std::int64_t>();
    const auto ticks = std::count(live.out.begin(), live.out.end(), '\n') - 1;
    EXPECT_LE(ticks, 2500);
    EXPECT_GE(ticks + skipped, 2500) << "the run is as long as it was to be";
    constexpr std::uintmax_t two_ticks = 2 * 92;
    EXPECT_LE(fs::file_size(record), kibibytes * 1024);
    EXPECT_GT(fs::file_size(record) + two_ticks, kibibytes * 1024) << "there was room for more";
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.3f",
                  1e-9 * static_cast<double>(recording->front().ticks.back().time_ns));
    EXPECT_TRUE(says(live.err, std::string("; it is kept, and replays, up to ") + seconds + " s"))
        << live.err;
    expect_replayed(live.err);
}

TEST_F(SpoiltOutput, ADiskThatIsFullUnderTheForcesKeepsTheRecordingAndWholeRows) {
    Outcome live;
    nlohmann::json figures;
    for (int go = 0; go == 0 || (stood_still(figures) && go < most_standstills); ++go) {
        live = run_on_full_disk({"touch", clip, "--live", "--seconds", "1", "--overwrite", "--record", record,
                                 "--forces", forces, "--fingers", "2", "--json", report},
                                190);
        figures = nlohmann::json::parse(file_contents(report), nullptr, false);
    }
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_TRUE(says(live.err, "--forces " + forces + ": cannot be written: ")) << live.err;
    EXPECT_TRUE(says(live.err, "; it is kept up to there")) << live.err;
    EXPECT_FALSE(says(live.err, "--record")) << live.err;
    const std::string rows = file_contents(forces);
    ASSERT_TRUE(rows.ends_with('\n'));
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n') % 2, 1) << "a header, and ticks of two fingers";
    EXPECT_GT(last_tick(rows), 200);
    EXPECT_TRUE(figures.is_object());
    expect_replayed(live.err);
}

TEST_F(SpoiltOutput, StandardOutputOnAFullDiskIsToldBeforeTheRun) {
    const Outcome live = run_with_full_output(
        {"touch", clip, "--live", "--seconds", "600", "--record", record, "--forces", "-"});
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_TRUE(live.one_line_of_error()) << live.err;
    EXPECT_TRUE(says(live.err, "--forces -: standard output cannot be written: ")) << live.err;
    EXPECT_FALSE(fs::exists(record));
}

TEST_F(SpoiltOutput, APipeThatNobodyReadsEndsALiveRunWithItsNameAndKeepsTheRest) {
    const Outcome live =
        run_unread({"touch", clip, "--live", "--seconds", "600", "--record", record, "--forces", "-"});
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_TRUE(says(live.err, "touchable: --forces -: its disk or its reader was too slow")) << live.err;
    EXPECT_TRUE(says(live.err, " ticks are missing")) << live.err;
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    const auto ticks = std::ssize(recording->front().ticks);
    EXPECT_GE(ticks, 4000);
    EXPECT_LE(ticks, 4200) << "as soon as that many wait";
    expect_replayed(live.err);
}

TEST_F(SpoiltOutput, APipeThatNobodyReadsEndsALiveRunsReport) {
    const Outcome live =
        run_unread({"touch", clip, "--live", "--seconds", "0.2", "--record", record, "--json", "-"});
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_TRUE(says(live.err, "touchable: --json -: ")) << live.err;
    expect_replayed(live.err);
}

TEST_F(SpoiltOutput, WhatWaitsForAReaderEndsWhenItIsAskedTo) {
    const Outcome offline = run_unread({"touch", clip, "--seconds", "100000", "--forces", "-"}, true);
    EXPECT_EQ(offline.code, 130) << offline.err;
}

TEST_F(SpoiltOutput, OfflineItLeavesNothingAndTheOthersAreComplete) {
    const Outcome run = run_on_full_disk(
        {"touch", clip, "--seconds", "1", "--record", record, "--forces", forces, "--json", report}, 150);
    EXPECT_EQ(run.code, 3) << run.err;
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
    EXPECT_TRUE(says(run.err, "--forces " + forces + ": cannot be written: ")) << run.err;
    EXPECT_FALSE(fs::exists(forces));
    EXPECT_FALSE(says(run.out, forces)) << "as if it were there: " << run.out;
    EXPECT_TRUE(says(run.out, report)) << run.out;
    EXPECT_EQ(nlohmann::json::parse(file_contents(report))["ticks"], 1000);
    expect_replayed(run.err);
}

}  // namespace
}  // namespace touchable::test
