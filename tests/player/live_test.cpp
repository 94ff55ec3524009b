// SPDX-License-Identifier: Apache-2.0
// Touch in real time: decoding, building and the haptic loop on threads of their own. No test depends on a
// deadline.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <utility>

#include "player/run/run_files.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

class LiveRun : public ::testing::Test {
protected:
    LiveRun() { succeed({"make", "moving", clip, "--size", "64x48", "--frames", "12"}); }

    TemporaryFolder folder;
    std::string clip = folder / "moving.mkv";
};

TEST_F(LiveRun, ReplaysWithEveryBuilder) {
    const auto live =
        touch({clip, "--live", "--fingers", "3", "--seconds", "0.6", "--record", folder / "live.rec"});
    EXPECT_EQ(live["clock"], "wall");
    EXPECT_EQ(live["proxy_behind_mesh_ticks"], 0);
    EXPECT_EQ(live["nonfinite_ticks"], 0);
    EXPECT_TRUE(live["scheduling"].is_string());
    const auto late = live["late_ticks"].get<std::int64_t>(),
               skipped = live["skipped_ticks"].get<std::int64_t>();
    EXPECT_LE(late, skipped) << "each that is late by a tick skips one and more";
    EXPECT_EQ(late == 0, skipped == 0);
    std::int64_t counted = 0;
    for (const auto& bin : live["late_us_histogram"]) counted += bin["ticks"].get<std::int64_t>();
    EXPECT_EQ(counted, live["ticks"]);
#ifdef __SANITIZE_THREAD__  // which does not see into the GPU driver
    for (const char* builder : {"cpu", "lazy", "reference"}) {
#else
    for (const char* builder : {"cpu", "lazy", "reference", "vulkan"}) {
#endif
        const auto replay = touch({"--replay", folder / "live.rec", "--builder", builder});
        EXPECT_EQ(replay["force_hash"], live["force_hash"]) << builder;
        EXPECT_EQ(replay["ticks"], live["ticks"]);
        EXPECT_EQ(replay["clock"], "virtual");
    }
}

// Which frames were there when an epoch was wanted is a matter of the moment, and part of the recording.
TEST_F(LiveRun, ReplaysPlaybackCommands) {
    const std::string play = folder / "play.txt";
    std::ofstream(play) << "0.05 pause\n0.1 step\n0.15 play\n0.2 rate 2\n0.25 loop 0.1 0.25\n0.5 seek 0.3\n"
                           "0.5 unloop\n0.52 seek 0\n0.521 seek 0.2\n0.6 rate 0.2\n";
    for (const Words& filter : {Words{}, Words{"--temporal", "5"}}) {
        const auto live = touch(plus({clip, "--live", "--start-buried", "--play", play, "--seconds", "2",
                                      "--record", folder / "live.rec"},
                                     filter));
        const RecordingBytes raw(file_contents(folder / "live.rec"));
        EXPECT_GT(raw.integer(raw.epoch_at(raw.ticks() - 1), 8), 3U);
        const auto replay = touch({"--replay", folder / "live.rec", "--builder", "reference"});
        EXPECT_EQ(replay["force_hash"], live["force_hash"]);
        EXPECT_EQ(replay["playback"], live["playback"]);
        RecordingBytes early = raw;
        early.set_integer(early.epoch_at(raw.ticks() - 1), 8, 1U << 30);
        std::ofstream(folder / "early.rec", std::ios::binary) << early.bytes();
        expect_failure({"touch", "--replay", folder / "early.rec"}, 3, "which no command has begun");
    }
}

// A live session's threads read ahead of the hand; a replay reads no more than it needs.
TEST_F(LiveRun, ReplayBlamesOnlyChangedClip) {
    touch({clip, "--live", "--seconds", "0.2", "--record", folder / "live.rec"});
    RecordingBytes raw(file_contents(folder / "live.rec"));
    const std::size_t at = raw.force_at(raw.ticks() - 1, 0);
    raw.set_integer(at, 8, raw.integer(at, 8) ^ 1);
    std::ofstream(folder / "changed.rec", std::ios::binary) << raw.bytes();
    const std::string blame = "the clip's frames are not the recorded ones";
    const Outcome same = run_touchable({"touch", "--replay", folder / "changed.rec"});
    EXPECT_EQ(same.code, 6) << same.err;
    EXPECT_EQ(same.err.find(blame), std::string::npos) << same.err;
    const std::string other = folder / "other.mkv";
    succeed({"make", "bumps", other, "--size", "64x48", "--frames", "12"});
    expect_failure({"touch", other, "--replay", folder / "changed.rec"}, 6, blame);
}

// A thousand frames a second, each far more work than a millisecond.
/// A clip that no machine keeps up with, 60 frames in 60 ms: what has passed is not decoded any more.
TEST_F(LiveRun, DropsFramesAlreadyPast) {
    const std::string hard = folder / "hard.mkv", run = folder / "run.rec";
    succeed({"make", "moving", hard, "--size", "100x76", "--frames", "60"});
    succeed({"export", hard, "--frame", "0", "--out", folder / "frame"});
    auto scene = json_in(folder / "frame/scene.json");
    scene["rate"] = {1000, 1};
    std::ofstream(folder / "fast.json") << scene;
    for (const std::string temporal : {"off", "0.5"}) {
        const auto report =
            touch({hard, "--scene", folder / "fast.json", "--live", "--builder", "reference", "--median", "5",
                   "--temporal", temporal, "--seconds", "0.4", "--record", run, "--overwrite"});
        const auto dropped = report["dropped_frames"].get<std::int64_t>();
        EXPECT_GE(dropped, 15) << "none until decoding can begin again";
        EXPECT_LE(report["frames"].get<std::int64_t>(), 60 - dropped);
        EXPECT_PRED2(says, report["warnings"].dump(), "frames were left out");
        const Outcome again = succeed({"touch", "--replay", run, "--builder", "cpu"});
        EXPECT_PRED2(says, again.out + again.err, "every force is as recorded") << again.out;
    }
}

TEST_F(LiveRun, CountsLateFrames) {
    TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(
        "every frame comes too late when everything takes ten times as long");
    const std::string hard = folder / "hard.mkv";
    succeed({"make", "moving", hard, "--size", "256x256", "--frames", "8"});
    succeed({"export", hard, "--frame", "0", "--out", folder / "frame"});
    auto scene = json_in(folder / "frame/scene.json");
    scene["rate"] = {1000, 1};
    std::ofstream(folder / "fast.json") << scene;
    const auto late = touch({hard, "--scene", folder / "fast.json", "--live", "--builder", "reference",
                             "--median", "5", "--seconds", "0.5"});
    const double count = late["late_frames"], frames = late["frames"];
    EXPECT_GT(count, 0);
    EXPECT_LE(count, frames);
    EXPECT_DOUBLE_EQ(late["late_frames_pct"].get<double>(), 100 * count / frames);
    EXPECT_PRED2(says, late["warnings"].dump(), "frames came too late") << late["warnings"];
    EXPECT_EQ(late["warnings"].dump().find("no real-time scheduling") != std::string::npos,
              late["scheduling"].get<std::string>().find("not permitted") != std::string::npos);
    const Outcome strict =
        expect_failure({"touch", hard, "--scene", folder / "fast.json", "--live", "--builder", "reference",
                        "--median", "5", "--seconds", "0.5", "--strict"},
                       6, "frames came too late");
    EXPECT_TRUE(strict.out.starts_with("  warning ")) << strict.out;
}

TEST_F(LiveRun, ReplaysWithoutSimulatedDevice) {
    const auto live = touch({clip, "--live", "--device", "simulated:hand=0.2", "--hand", "press:depth=4",
                             "--seconds", "0.8", "--record", folder / "live.rec"});
    EXPECT_EQ(live["device"], "simulated:hand=0.2");
    EXPECT_GT(live["contact_ticks"], 0);
    const auto replay = touch({"--replay", folder / "live.rec"});
    EXPECT_EQ(replay["force_hash"], live["force_hash"]);
}

TEST_F(LiveRun, GuardEnforcesDeviceLimits) {
    const Words press{clip,         "--live",        "--device",  "simulated:force=0.3,hand=2",
                      "--hand",     "press:depth=6", "--seconds", "0.8",
                      "--max-force"};
    const auto with = [&](const char* newtons) { return touch(plus(press, {newtons})); };
    const auto more = with("50"), less = with("0.1");
    EXPECT_GT(more["force_limited"]["finger_ticks"], 0);
    EXPECT_GT(more["force_n"]["max"], 0.25);
    EXPECT_LE(more["force_n"]["max"], 0.3);
    EXPECT_LE(less["force_n"]["max"], 0.1);
}

// A hand that begins inside, comes out within 0.2 s, and goes in again.
TEST_F(LiveRun, BuriedFingerWaitsUntilFree) {
    std::ofstream(folder / "inside.csv") << "t_s,in\n0,0.02\n0.2,0\n0.4,0.02\n";
    const std::string hand = "csv:" + (folder / "inside.csv").string() + ":columns=in,contact=0.2";
    const Words inside{clip, "--hand", hand, "--record", folder / "live.rec"};
    const auto touch_inside = [&](const Words& words) { return touch(plus(inside, words)); };
    const auto waited = touch_inside({"--live"});
    EXPECT_GT(waited["waiting_ticks"], 0);
    EXPECT_LT(waited["waiting_ticks"], waited["contact_ticks"]);
    EXPECT_GT(waited["force_n"]["max"], 0);
    EXPECT_EQ(touch({"--replay", folder / "live.rec"})["force_hash"], waited["force_hash"]);
    const auto pushed = touch_inside({"--live", "--start-buried"});
    EXPECT_EQ(pushed["waiting_ticks"], 0);
    EXPECT_EQ(touch({"--replay", folder / "live.rec"})["force_hash"], pushed["force_hash"]);
    EXPECT_EQ(touch_inside({})["waiting_ticks"], 0);
    expect_failure({"touch", clip, "--start-buried"}, 2, "--live");
}

TEST_F(LiveRun, UnplugEndsSessionWithoutLoss) {
    const std::string json = folder / "r.json", record = folder / "live.rec";
    const Outcome outcome = expect_failure({"touch", clip, "--live", "--device", "simulated:unplug=0.2",
                                            "--seconds", "5", "--json", json, "--record", record},
                                           5, "simulated device was unplugged");
    EXPECT_PRED2(says, outcome.err, "what was asked for is written, up to there");
    const auto report = json_in(json);
    ASSERT_TRUE(report.is_object());
    EXPECT_GT(report["ticks"], 0);
    EXPECT_EQ(touch({"--replay", record})["force_hash"], report["force_hash"]);
}

// People end a live run by an interrupt.
TEST_F(LiveRun, InterruptCompletesEveryFile) {
    const std::string json = folder / "r.json", forces = folder / "f.csv", record = folder / "live.rec",
                      picture = folder / "p.png";
    const Outcome outcome = expect_failure(
        run_interrupted_while_live({"touch", clip, "--live", "--seconds", "1000", "--json", json, "--forces",
                                    forces, "--record", record, "--picture", picture, "--picture-size",
                                    "64x48", "--painter", "cpu", "--builder", "cpu"}),
        130);
    EXPECT_PRED2(says, outcome.out, "  verdict  ");
    const auto report = json_in(json);
    ASSERT_TRUE(report.is_object());
    EXPECT_EQ(report["interrupted"], true);
    const auto ticks = report["ticks"].get<std::int64_t>();
    ASSERT_GT(ticks, 0);
    std::string seconds = std::to_string((ticks + report["skipped_ticks"].get<std::int64_t>()) / 1000.0);
    seconds.resize(seconds.size() - 3);
    EXPECT_PRED2(says, outcome.err, "interrupted after " + seconds + " s;") << seconds << ": " << outcome.err;
    const std::string rows = file_contents(forces);
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), ticks + 1);
    EXPECT_GT(std::filesystem::file_size(picture), 100U);
    const auto replay = touch({"--replay", record});
    EXPECT_EQ(replay["force_hash"], report["force_hash"]);
    EXPECT_EQ(names_in(folder.path()).size(), 5U) << "and the clip";
}

TEST_F(LiveRun, ShowsProgressOnTerminal) {
    EXPECT_EQ(run_touchable({"touch", clip, "--live", "--seconds", "0.6"}).err, "") << "for a terminal alone";
    const Outcome seen = run_on_terminal({"touch", clip, "--live", "--seconds", "60"},
                                         [](const std::string& shown) { return moments_shown(shown) > 2; });
    EXPECT_EQ(seen.code, 130) << "it was to end once three moments were shown: " << seen.err;
    for (const char* part : {"\rlive 0.", " ticks skipped, ", " frames late, ", " N\033[K"})
        EXPECT_PRED2(says, seen.err, part);
    const std::size_t gone = seen.err.rfind("\r\033[K");
    ASSERT_NE(gone, std::string::npos);
    EXPECT_EQ(seen.err.find("live ", gone), std::string::npos) << "it is gone in the end: " << seen.err;
    EXPECT_EQ(seen.err.substr(gone + 4, 23), "touchable: interrupted ") << seen.err;
}

TEST_F(LiveRun, HonoursNohup) {
    const Outcome outcome =
        run_under_nohup({"touch", clip, "--live", "--seconds", "0.4", "--json", folder / "r.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(std::filesystem::exists(folder / "r.json"));
}

TEST_F(LiveRun, ReportsThreadStartFailure) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take more address space than this test leaves";
#endif
    const char* named[] = {"the thread that decodes", "the thread that builds", "the thread of the hand"};
    for (int threads = 0; threads < 3; ++threads) {
        expect_failure(
            run_with_threads({"touch", clip, "--live", "--builder", "cpu", "--seconds", "0.1"}, threads), 1,
            named[threads]);
    }
}

TEST_F(LiveRun, RejectsInvalidDevice) {
    for (const auto& [words, part] : std::vector<std::pair<Words, const char*>>{
             {{"--device", "simulated"}, "--live"},
             {{"--live", "--device", "falkon"}, "simulated"},
             {{"--live", "--device", "simulated:mass=no"}, "0.05 to 10 kg"}})
        expect_failure(plus({"touch", clip}, words), 2, part);
}

// Outputs of a live run that cannot be written: a disk that is full, a pipe that is not read. The others are
// complete, and the run ends by itself.

namespace fs = std::filesystem;

class SpoiltOutput : public ::testing::Test {
protected:
    SpoiltOutput() { succeed({"make", "moving", clip, "--size", "64x48", "--frames", "12"}); }
    /// Number of the last tick of a forces file.
    static std::int64_t last_tick(const std::string& rows) {
        const std::size_t end = rows.rfind('\n'), begin = rows.rfind('\n', end - 1);
        return std::stoll(rows.substr(begin + 1));
    }
    void expect_replayed() {
        const Outcome replay = succeed({"touch", "--replay", record});
        EXPECT_PRED2(says, replay.out, "every force is as recorded, to the bit");
        EXPECT_FALSE(says(replay.out, "frames are not the recorded ones")) << replay.out;
    }

    const TemporaryFolder folder;
    const std::string clip = folder / "moving.mkv", record = folder / "live.rec", forces = folder / "f.csv",
                      report = folder / "r.json";
};

TEST_F(SpoiltOutput, FullDiskKeepsPartialRecording) {
    constexpr std::uintmax_t kibibytes = 64;
    const Outcome live = run_on_full_disk(
        {"touch", clip, "--live", "--seconds", "2.5", "--record", record, "--forces", "-", "--json", report},
        kibibytes);
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_PRED2(says, live.err, "touchable: warning: --record " + record + ": cannot be written: ");
    EXPECT_PRED2(says, live.err, "touchable: --record " + record + ": cannot be written: ");
    // A busy machine skips ticks, and counts them; the last skip may reach beyond the end. None is missing
    // besides.
    const auto figures = json_in(report);
    const auto skipped = figures.at("skipped_ticks").get<std::int64_t>();
    const auto ticks = std::count(live.out.begin(), live.out.end(), '\n') - 1;
    EXPECT_LE(ticks, 2500);
    EXPECT_GE(ticks + skipped, 2500) << "the run is as long as it was to be";
    constexpr std::uintmax_t two_ticks = 2 * 92;
    EXPECT_LE(fs::file_size(record), kibibytes * 1024);
    EXPECT_GT(fs::file_size(record) + two_ticks, kibibytes * 1024) << "there was room for more";
    const auto recording = must(read_recording(record));
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.3f",
                  1e-9 * static_cast<double>(recording.front().ticks.back().time_ns));
    EXPECT_TRUE(says(live.err, std::string("; it is kept, and replays, up to ") + seconds + " s"))
        << live.err;
    expect_replayed();
}

TEST_F(SpoiltOutput, FullDiskKeepsWholeRows) {
    Outcome live;
    nlohmann::json figures;
    for (int go = 0; go == 0 || (stood_still(figures) && go < most_standstills); ++go) {
        live = run_on_full_disk({"touch", clip, "--live", "--seconds", "1", "--overwrite", "--record", record,
                                 "--forces", forces, "--fingers", "2", "--json", report},
                                190);
        figures = json_in(report);
    }
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_PRED2(says, live.err, "--forces " + forces + ": cannot be written: ");
    EXPECT_TRUE(says(live.err, "; it is kept up to there")) << live.err;
    EXPECT_FALSE(says(live.err, "--record")) << live.err;
    const std::string rows = file_contents(forces);
    ASSERT_TRUE(rows.ends_with('\n'));
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n') % 2, 1) << "a header, and ticks of two fingers";
    EXPECT_GT(last_tick(rows), 200);
    EXPECT_TRUE(figures.is_object());
    expect_replayed();
}

TEST_F(SpoiltOutput, ReportsFullStandardOutputFirst) {
    const Outcome live = expect_failure(run_with_full_output({"touch", clip, "--live", "--seconds", "600",
                                                              "--record", record, "--forces", "-"}),
                                        3);
    EXPECT_PRED2(says, live.err, "--forces -: standard output cannot be written: ");
    EXPECT_FALSE(fs::exists(record));
}

TEST_F(SpoiltOutput, UnreadForcesPipeEndsRun) {
    const Outcome live =
        run_unread({"touch", clip, "--live", "--seconds", "600", "--record", record, "--forces", "-"});
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_PRED2(says, live.err, "touchable: --forces -: its disk or its reader was too slow");
    EXPECT_PRED2(says, live.err, " ticks are missing");
    const auto recording = must(read_recording(record));
    const auto ticks = std::ssize(recording.front().ticks);
    EXPECT_GE(ticks, 4000);
    EXPECT_LE(ticks, 4200) << "as soon as that many wait";
    expect_replayed();
}

TEST_F(SpoiltOutput, UnreadReportPipeEndsRun) {
    const Outcome live =
        run_unread({"touch", clip, "--live", "--seconds", "0.2", "--record", record, "--json", "-"});
    EXPECT_EQ(live.code, 3) << live.err;
    EXPECT_PRED2(says, live.err, "touchable: --json -: ");
    expect_replayed();
}

TEST_F(SpoiltOutput, UnreadPipeIsInterruptible) {
    const Outcome offline = run_unread({"touch", clip, "--seconds", "100000", "--forces", "-"}, true);
    EXPECT_EQ(offline.code, 130) << offline.err;
}

TEST_F(SpoiltOutput, OfflineRunKeepsOtherOutputs) {
    const Outcome run = expect_failure(
        run_on_full_disk(
            {"touch", clip, "--seconds", "1", "--record", record, "--forces", forces, "--json", report}, 150),
        3);
    EXPECT_PRED2(says, run.err, "--forces " + forces + ": cannot be written: ");
    EXPECT_FALSE(fs::exists(forces));
    EXPECT_FALSE(says(run.out, forces)) << "as if it were there: " << run.out;
    EXPECT_PRED2(says, run.out, report);
    EXPECT_EQ(json_in(report)["ticks"], 1000);
    expect_replayed();
}

}  // namespace
}  // namespace touchable::test
