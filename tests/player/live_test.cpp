// Touch in real time: decoding, building and the haptic loop on threads of their own. No test depends on a
// deadline.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/player/program.hpp"
#include "tests/player/recording_bytes.hpp"
#include "tests/player/standstill.hpp"
#include "tests/sanitizers.hpp"

namespace touchable::test {
namespace {

using Words = std::vector<std::string>;

class Live : public ::testing::Test {
protected:
    Live() {
        const Outcome made = run_touchable({"make", "moving", clip, "--size", "64x48", "--frames", "12"});
        EXPECT_EQ(made.code, 0) << made.err;
    }
    nlohmann::json touch(std::vector<std::string> arguments) {
        arguments.insert(arguments.begin(), "touch");
        arguments.insert(arguments.end(), {"--overwrite", "--json", folder / "report.json"});
        nlohmann::json report;
        for (int go = 0; go == 0 || (stood_still(report) && go < most_standstills); ++go) {
            const Outcome outcome = run_touchable(arguments);
            EXPECT_EQ(outcome.code, 0) << outcome.err;
            report = nlohmann::json::parse(file_contents(folder / "report.json"), nullptr, false);
        }
        return report;
    }

    TemporaryFolder folder;
    std::string clip = folder / "moving.mkv";
};

TEST_F(Live, ASessionReplaysToItsHashWithEveryBuilder) {
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
    for (const char* builder : {"cpu", "lazy", "reference"}) {
        const auto replay = touch({"--replay", folder / "live.rec", "--builder", builder});
        EXPECT_EQ(replay["force_hash"], live["force_hash"]) << builder;
        EXPECT_EQ(replay["ticks"], live["ticks"]);
        EXPECT_EQ(replay["clock"], "virtual");
    }
}

// Which frames were there when an epoch was wanted is a matter of the moment, and part of the recording.
TEST_F(Live, ASessionOfPausesSeeksLoopsAndOtherSpeedsReplaysToItsHash) {
    const std::string play = folder / "play.txt";
    std::ofstream(play) << "0.05 pause\n0.1 step\n0.15 play\n0.2 rate 2\n0.25 loop 0.1 0.25\n0.5 seek 0.3\n"
                           "0.5 unloop\n0.52 seek 0\n0.521 seek 0.2\n0.6 rate 0.2\n";
    for (const Words& filter : {Words{}, Words{"--temporal", "5"}}) {
        Words words{clip,        "--live", "--start-buried", "--play",           play,
                    "--seconds", "2",      "--record",       folder / "live.rec"};
        words.insert(words.end(), filter.begin(), filter.end());
        const auto live = touch(words);
        const RecordingBytes raw(file_contents(folder / "live.rec"));
        EXPECT_GT(raw.integer(raw.epoch_at(raw.ticks() - 1), 8), 3U);
        const auto replay = touch({"--replay", folder / "live.rec", "--builder", "reference"});
        EXPECT_EQ(replay["force_hash"], live["force_hash"]);
        EXPECT_EQ(replay["playback"], live["playback"]);
        RecordingBytes early = raw;
        early.set_integer(early.epoch_at(raw.ticks() - 1), 8, 1U << 30);
        std::ofstream(folder / "early.rec", std::ios::binary) << early.bytes();
        const Outcome refused = run_touchable({"touch", "--replay", folder / "early.rec"});
        EXPECT_EQ(refused.code, 3);
        EXPECT_NE(refused.err.find("which no command has begun"), std::string::npos) << refused.err;
    }
}

// A live session's threads read ahead of the hand; a replay reads no more than it needs.
TEST_F(Live, AReplayThatDiffersBlamesTheClipOnlyForAnotherClip) {
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
    ASSERT_EQ(run_touchable({"make", "bumps", other, "--size", "64x48", "--frames", "12"}).code, 0);
    const Outcome different = run_touchable({"touch", other, "--replay", folder / "changed.rec"});
    EXPECT_EQ(different.code, 6) << different.err;
    EXPECT_NE(different.err.find(blame), std::string::npos) << different.err;
}

TEST_F(Live, ASessionReplaysToItsHashOnVulkan) {
    TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER("ThreadSanitizer does not see into the GPU driver");
    const auto live = touch({clip, "--live", "--seconds", "0.3", "--record", folder / "live.rec"});
    EXPECT_EQ(touch({"--replay", folder / "live.rec", "--builder", "vulkan"})["force_hash"],
              live["force_hash"]);
}

// A thousand frames a second, each far more work than a millisecond.
/// A clip that no machine keeps up with, 60 frames in 60 ms: what has passed is not decoded any more.
TEST_F(Live, FramesThatNobodyWouldFeelAreLeftOut) {
    const std::string hard = folder / "hard.mkv", run = folder / "run.rec";
    ASSERT_EQ(run_touchable({"make", "moving", hard, "--size", "100x76", "--frames", "60"}).code, 0);
    ASSERT_EQ(run_touchable({"export", hard, "--frame", "0", "--out", folder / "frame"}).code, 0);
    auto scene = nlohmann::json::parse(file_contents(folder / "frame/scene.json"));
    scene["rate"] = {1000, 1};
    std::ofstream(folder / "fast.json") << scene;
    for (const std::string temporal : {"off", "0.5"}) {
        const auto report =
            touch({hard, "--scene", folder / "fast.json", "--live", "--builder", "reference", "--median", "5",
                   "--temporal", temporal, "--seconds", "0.4", "--record", run, "--overwrite"});
        const auto dropped = report["dropped_frames"].get<std::int64_t>();
        EXPECT_GE(dropped, 15) << "none until decoding can begin again";
        EXPECT_LE(report["frames"].get<std::int64_t>(), 60 - dropped);
        EXPECT_NE(report["warnings"].dump().find("frames were left out"), std::string::npos);
        const Outcome again = run_touchable({"touch", "--replay", run, "--builder", "cpu"});
        EXPECT_EQ(again.code, 0) << temporal << ": " << again.err;
        EXPECT_NE((again.out + again.err).find("every force is as recorded"), std::string::npos) << again.out;
    }
}

TEST_F(Live, FramesThatComeTooLateAreCounted) {
    TOUCHABLE_SKIP_UNDER_THREAD_SANITIZER(
        "every frame comes too late when everything takes ten times as long");
    const std::string hard = folder / "hard.mkv";
    ASSERT_EQ(run_touchable({"make", "moving", hard, "--size", "256x256", "--frames", "8"}).code, 0);
    ASSERT_EQ(run_touchable({"export", hard, "--frame", "0", "--out", folder / "frame"}).code, 0);
    auto scene = nlohmann::json::parse(file_contents(folder / "frame/scene.json"));
    scene["rate"] = {1000, 1};
    std::ofstream(folder / "fast.json") << scene;
    const auto late = touch({hard, "--scene", folder / "fast.json", "--live", "--builder", "reference",
                             "--median", "5", "--seconds", "0.5"});
    const double count = late["late_frames"], frames = late["frames"];
    EXPECT_GT(count, 0);
    EXPECT_LE(count, frames);
    EXPECT_DOUBLE_EQ(late["late_frames_pct"].get<double>(), 100 * count / frames);
    EXPECT_NE(late["warnings"].dump().find("frames came too late"), std::string::npos) << late["warnings"];
    EXPECT_EQ(late["warnings"].dump().find("no real-time scheduling") != std::string::npos,
              late["scheduling"].get<std::string>().find("not permitted") != std::string::npos);
    const Outcome strict =
        run_touchable({"touch", hard, "--scene", folder / "fast.json", "--live", "--builder", "reference",
                       "--median", "5", "--seconds", "0.5", "--strict"});
    EXPECT_EQ(strict.code, 6);
    EXPECT_TRUE(strict.one_line_of_error()) << strict.err;
    EXPECT_NE(strict.err.find("frames came too late"), std::string::npos) << strict.err;
    EXPECT_TRUE(strict.out.starts_with("  warning ")) << strict.out;
}

TEST_F(Live, ATickIsRunOrCountedAsSkipped) {
    const auto live = touch({clip, "--live", "--seconds", "0.3"});
    const auto run = live["ticks"].get<int>(), skipped = live["skipped_ticks"].get<int>();
    EXPECT_GE(run + skipped, 300);
    EXPECT_GE(skipped, live["late_ticks"].get<int>());
}

TEST_F(Live, ASessionWithASimulatedDeviceReplaysWithoutOne) {
    const auto live = touch({clip, "--live", "--device", "simulated:hand=0.2", "--hand", "press:depth=4",
                             "--seconds", "0.8", "--record", folder / "live.rec"});
    EXPECT_EQ(live["device"], "simulated:hand=0.2");
    EXPECT_GT(live["contact_ticks"], 0);
    const auto replay = touch({"--replay", folder / "live.rec"});
    EXPECT_EQ(replay["force_hash"], live["force_hash"]);
}

TEST_F(Live, TheGuardKeepsToTheDevicesLimitsWhateverIsAskedFor) {
    const Words press{clip,         "--live",        "--device",  "simulated:force=0.3,hand=2",
                      "--hand",     "press:depth=6", "--seconds", "0.8",
                      "--max-force"};
    const auto with = [&](const char* newtons) {
        Words words = press;
        words.emplace_back(newtons);
        return touch(words);
    };
    const auto more = with("50"), less = with("0.1");
    EXPECT_GT(more["force_limited"]["finger_ticks"], 0);
    EXPECT_GT(more["force_n"]["max"], 0.25);
    EXPECT_LE(more["force_n"]["max"], 0.3);
    EXPECT_LE(less["force_n"]["max"], 0.1);
}

// A hand that begins inside, comes out within 0.2 s, and goes in again.
TEST_F(Live, AFingerThatBeginsInsideFeelsNothingUntilItHasBeenFree) {
    std::ofstream(folder / "inside.csv") << "t_s,in\n0,0.02\n0.2,0\n0.4,0.02\n";
    const std::string hand = "csv:" + (folder / "inside.csv").string() + ":columns=in,contact=0.2";
    const Words inside{clip, "--hand", hand, "--record", folder / "live.rec"};
    const auto touch_inside = [&](const Words& words) {
        Words all = inside;
        all.insert(all.end(), words.begin(), words.end());
        return touch(all);
    };
    const auto waited = touch_inside({"--live"});
    EXPECT_GT(waited["waiting_ticks"], 0);
    EXPECT_LT(waited["waiting_ticks"], waited["contact_ticks"]);
    EXPECT_GT(waited["force_n"]["max"], 0);
    EXPECT_EQ(touch({"--replay", folder / "live.rec"})["force_hash"], waited["force_hash"]);
    const auto pushed = touch_inside({"--live", "--start-buried"});
    EXPECT_EQ(pushed["waiting_ticks"], 0);
    EXPECT_EQ(touch({"--replay", folder / "live.rec"})["force_hash"], pushed["force_hash"]);
    EXPECT_EQ(touch_inside({})["waiting_ticks"], 0);
    const Outcome offline = run_touchable({"touch", clip, "--start-buried"});
    EXPECT_EQ(offline.code, 2);
    EXPECT_NE(offline.err.find("--live"), std::string::npos) << offline.err;
}

TEST_F(Live, ADeviceThatIsUnpluggedEndsTheSessionWithCode5AndLosesNothing) {
    const std::string json = folder / "r.json", record = folder / "live.rec";
    const Outcome outcome = run_touchable({"touch", clip, "--live", "--device", "simulated:unplug=0.2",
                                           "--seconds", "5", "--json", json, "--record", record});
    EXPECT_EQ(outcome.code, 5);
    EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
    EXPECT_NE(outcome.err.find("simulated device was unplugged"), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find("what was asked for is written, up to there"), std::string::npos)
        << outcome.err;
    const auto report = nlohmann::json::parse(file_contents(json), nullptr, false);
    ASSERT_TRUE(report.is_object());
    EXPECT_GT(report["ticks"], 0);
    EXPECT_EQ(touch({"--replay", record})["force_hash"], report["force_hash"]);
}

// That is how people end a live run.
TEST_F(Live, AnInterruptCompletesEveryFileAndSaysHowLongItRan) {
    const std::string json = folder / "r.json", forces = folder / "f.csv", record = folder / "live.rec",
                      picture = folder / "p.png";
    const Outcome outcome = run_interrupted_while_live(
        {"touch", clip, "--live", "--seconds", "1000", "--json", json, "--forces", forces, "--record", record,
         "--picture", picture, "--picture-size", "64x48", "--painter", "cpu", "--builder", "cpu"});
    EXPECT_EQ(outcome.code, 130) << outcome.err;
    EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
    EXPECT_NE(outcome.out.find("  verdict  "), std::string::npos) << outcome.out;
    const auto report = nlohmann::json::parse(file_contents(json), nullptr, false);
    ASSERT_TRUE(report.is_object());
    EXPECT_EQ(report["interrupted"], true);
    const auto ticks = report["ticks"].get<std::int64_t>();
    ASSERT_GT(ticks, 0);
    std::string seconds = std::to_string((ticks + report["skipped_ticks"].get<std::int64_t>()) / 1000.0);
    seconds.resize(seconds.size() - 3);
    EXPECT_NE(outcome.err.find("interrupted after " + seconds + " s;"), std::string::npos)
        << seconds << ": " << outcome.err;
    const std::string rows = file_contents(forces);
    EXPECT_EQ(std::count(rows.begin(), rows.end(), '\n'), ticks + 1);
    EXPECT_GT(std::filesystem::file_size(picture), 100U);
    const auto replay = touch({"--replay", record});
    EXPECT_EQ(replay["force_hash"], report["force_hash"]);
    EXPECT_EQ(names_in(folder.path()).size(), 6U) << "and the clip, and the replay's report";
}

TEST_F(Live, OnATerminalALineMoves) {
    EXPECT_EQ(run_touchable({"touch", clip, "--live", "--seconds", "0.6"}).err, "") << "for a terminal alone";
    const Outcome seen = run_on_terminal({"touch", clip, "--live", "--seconds", "60"},
                                         [](const std::string& shown) { return moments_shown(shown) > 2; });
    EXPECT_EQ(seen.code, 130) << "it was to end once three moments were shown: " << seen.err;
    for (const char* part : {"\rlive 0.", " ticks skipped, ", " frames late, ", " N\033[K"})
        EXPECT_NE(seen.err.find(part), std::string::npos) << part << seen.err;
    const std::size_t gone = seen.err.rfind("\r\033[K");
    ASSERT_NE(gone, std::string::npos);
    EXPECT_EQ(seen.err.find("live ", gone), std::string::npos) << "it is gone in the end: " << seen.err;
    EXPECT_EQ(seen.err.substr(gone + 4, 23), "touchable: interrupted ") << seen.err;
}

TEST_F(Live, NohupIsHeeded) {
    const Outcome outcome =
        run_under_nohup({"touch", clip, "--live", "--seconds", "0.4", "--json", folder / "r.json"});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_TRUE(std::filesystem::exists(folder / "r.json"));
}

TEST_F(Live, AThreadThatCannotStartIsOneLineOfError) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take more address space than this test leaves";
#endif
    const char* named[] = {"the thread that decodes", "the thread that builds", "the thread of the hand"};
    for (int threads = 0; threads < 3; ++threads) {
        const Outcome outcome =
            run_with_threads({"touch", clip, "--live", "--builder", "cpu", "--seconds", "0.1"}, threads);
        EXPECT_EQ(outcome.code, 1) << threads;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_NE(outcome.err.find(named[threads]), std::string::npos) << outcome.err;
    }
}

TEST_F(Live, ADeviceIsRefusedWhereItCannotBe) {
    for (const auto& [words, fragment] : std::vector<std::pair<Words, const char*>>{
             {{"--device", "simulated"}, "--live"},
             {{"--live", "--device", "falkon"}, "simulated"},
             {{"--live", "--device", "simulated:mass=no"}, "0.05 to 10 kg"}}) {
        Words all{"touch", clip};
        all.insert(all.end(), words.begin(), words.end());
        const Outcome outcome = run_touchable(all);
        EXPECT_EQ(outcome.code, 2);
        EXPECT_NE(outcome.err.find(fragment), std::string::npos) << outcome.err;
    }
}

}  // namespace
}  // namespace touchable::test
