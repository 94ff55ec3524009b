// SPDX-License-Identifier: Apache-2.0
// The window without a window: what it shows, and by which settings it is felt, by the program as a person
// starts it.

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <future>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "player/audio/window_sound.hpp"
#include "player/run/run_files.hpp"
#include "player/window/kiosk.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/temporary_files.hpp"
#include "tests/video/remuxed_clip.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

/// A window that shows the still of a globe.
Played shot_of_globe(const std::string& script, const std::string& seconds,
                     const std::vector<std::string>& more = {}) {
    return shot_of(made_clip("globe", 1), script, seconds, more);
}

TEST(HeadlessWindow, ShowsFingerUnderPointer) {
    const Played without = shot_of_globe("", "0.8");
    const Played with = shot_of_globe("0 move 160 110\n0.1 press left\n", "0.8");
    ASSERT_EQ(with.image.width, 320);
    ASSERT_EQ(with.image.height, 240);
    // Apart from the words in the corners and the bar below: round the pointer a finger with its arrow,
    // beside it none.
    EXPECT_GT(differences(without.image, with.image, {140, 90, 180, 130}), 60);
    EXPECT_EQ(differences(without.image, with.image, {220, 100, 310, 170}), 0);
    EXPECT_TRUE(contains(with.outcome.out, "pictures"));
}

/// To the bit, where vertices lie on pixels: all but the last row and column.
TEST(HeadlessWindow, ShowsColoursAsTheyAre) {
    const TemporaryFolder folder;
    const auto& clip = made_clip("globe", 1);
    ASSERT_EQ(run_touchable({"export", clip.string(), "--frame", "0", "--out", folder.path() / "frame"}).code,
              0);
    const auto colour = read_image(folder / "frame/colour.png");
    ASSERT_TRUE(colour);
    for (const auto* light : {"off", "full"}) {
        const Image shown =
            played_by({clip.string(), "--painter", "cpu", "--light", light}, "", "0.3", "160x120").image;
        const int unlike = differences(*colour, shown, {0, 0, 159, 119}, 0);
        EXPECT_TRUE(light == std::string("off") ? unlike == 0 : unlike > 1000) << light << ": " << unlike;
    }
}

/// A window whose clock runs ahead, a tenth of a second each turn.
class HastyScreen final : public WrappedScreen {
public:
    using WrappedScreen::WrappedScreen;
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        WindowClock::put_forward(std::chrono::milliseconds(100));
        return WrappedScreen::poll(longest);
    }
};

/// How many pictures half a minute of a still globe has.
std::int64_t pictures_at_rest(const std::string& script) {
    PlayOptions options = headless_by_cpu(made_clip("globe", 1));
    options.make_screen = [](const ScreenOptions& size) { return std::make_unique<HastyScreen>(size); };
    options.script = inputs_of(script);
    options.seconds = 30;
    const auto played = play_in_window(options);
    EXPECT_TRUE(played);
    return played ? played->pictures : -1;
}

/// A few at first, and when words come and go.
TEST(HeadlessWindow, DrawsNothingAtRest) {
    const std::int64_t few = pictures_at_rest(""), more = pictures_at_rest("10 volume 50\n");
    EXPECT_GT(few, 0);
    EXPECT_LT(few, 20) << "five a second would be 150";
    EXPECT_GE(more, few + 2);
    EXPECT_LT(more, few + 20);
}

/// A window whose pictures take long, the first ones longer still.
class SlowScreen final : public WrappedScreen {
public:
    using WrappedScreen::WrappedScreen;
    Result<void> present(GpuCommands commands, const GpuImage& canvas) override {
        std::this_thread::sleep_for(std::chrono::milliseconds(++pictures_ < 5 ? 400 : 100));
        return WrappedScreen::present(std::move(commands), canvas);
    }

private:
    int pictures_ = 0;
};

/// Smaller pictures are for what moves.
TEST(HeadlessWindow, DrawsWholePictureAtRest) {
    const TemporaryFolder folder;
    const auto shot = [&]<class Made>(const char* name, std::type_identity<Made>) {
        PlayOptions options = headless_by_cpu(made_clip("globe", 90));
        options.painter = "auto";
        options.make_screen = [](const ScreenOptions& size) { return std::make_unique<Made>(size); };
        options.screenshot = folder / name;
        options.seconds = 5;
        const auto played = play_in_window(options);
        EXPECT_TRUE(played);
        return std::pair(*read_image(folder / name), played->least_detail);
    };
    const auto [quick, by_quick] = shot("quick.png", std::type_identity<WrappedScreen>());
    const auto [slow, by_slow] = shot("slow.png", std::type_identity<SlowScreen>());
    EXPECT_LT(by_slow, 0.3);
    EXPECT_EQ(differences(quick, slow, {60, 40, 260, 190}, 0), 0);
}

/// In the middle, where there is no panel and beside the finger no ring: nothing draws those without a GPU.
/// (Fingers are compared by Drawing.CpuTwinMatchesCpuOnDevice.)
TEST(HeadlessWindow, CpuPictureMatchesGpu) {
    const std::string large = "0 size 640x480\n", touch = large + "0 move 330 190\n0.1 press left\n";
    const std::vector<std::string> by_cpu{"--painter", "cpu", "--builder", "cpu"};
    const Played gpu = shot_of_globe(touch, "0.8", {"--painter", "raster"});
    const Played cpu = shot_of_globe(touch, "0.8", by_cpu);
    const Played bare = shot_of_globe(large, "0.3", by_cpu);
    EXPECT_GT(differences(bare.image, cpu.image, {300, 140, 420, 220}), 400);
    EXPECT_LE(differences(gpu.image, cpu.image, {240, 60, 300, 400}), 60);
    EXPECT_LE(differences(gpu.image, cpu.image, {300, 220, 620, 400}), 60);
    EXPECT_TRUE(contains(cpu.outcome.out, "by the cpu painter\n"));
}

TEST(HeadlessWindow, OverlayColoursTheSurface) {
    const Played colour = shot_of_globe("", "0.5");
    const Played depth = shot_of_globe("0 overlay depth\n", "0.5");
    EXPECT_GT(differences(colour.image, depth.image, {120, 80, 200, 160}), 3000);
}

TEST(HeadlessWindow, OverlayEndsWithClip) {
    const TemporaryFolder folder;
    const std::vector<std::string> settings{"--settings", (folder / "play.json").string()};
    const Played depth = shot_of_globe("0 overlay depth\n", "0.5", settings);
    const Played next = shot_of_globe("", "0.5", settings), plain = shot_of_globe("", "0.5");
    EXPECT_GT(differences(depth.image, next.image, {120, 80, 200, 160}), 3000);
    EXPECT_EQ(differences(plain.image, next.image, {120, 80, 200, 160}), 0);
}

TEST(HeadlessWindow, RecordedTouchReplaysExactly) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string();
    shot_of(made_clip("globe", 30),
            "0 move 150 110\n0.1 press left\n0.3 move 170 115\n0.4 key space\n0.5 move 160 120\n0.6 seek "
            "0.2\n0.7 speed 2\n"
            "0.8 key space\n0.9 wheel 2\n1.0 key .\n1.1 key 3\n1.2 loop\n",
            "1.4", {"--record", record});
    EXPECT_TRUE(contains(replayed(folder.path(), record), "\"fingers_led\": 3,"))
        << "one, and three from 1.1 s on";
}

TEST(HeadlessWindow, KeepsClipWhenOpenFails) {
    const Played shot = shot_of_globe("0.1 drop nowhere.mkv\n0.2 move 160 110\n", "0.7");
    const Played without = shot_of_globe("0.2 move 160 110\n", "0.7");
    EXPECT_GT(differences(shot.image, without.image, {60, 0, 260, 60}), 100) << "no message";
    EXPECT_TRUE(contains(shot.outcome.err, "nowhere.mkv")) << "the message is not on the terminal";
    EXPECT_EQ(differences(shot.image, without.image, {220, 100, 310, 160}), 0);
}

TEST(HeadlessWindow, DroppedClipReplacesOldOne) {
    const Played before = shot_of(made_clip("globe", 30), "0 key space\n0 seek 0.5\n", "0.8");
    // Late, for a clip opens in the background, and a busy machine takes its time.
    const Played other =
        shot_of(made_clip("globe", 30), "0 drop " + made_clip("globe", 1).string() + "\n", "3");
    const Played same = shot_of_globe("", "0.8");
    EXPECT_GT(differences(before.image, other.image, {100, 60, 220, 180}), 100);
    EXPECT_LT(differences(same.image, other.image, {100, 60, 220, 180}), 20);
    const TemporaryFolder folder;
    const auto closed = run_scripted(
        {made_clip("globe", 1).string(), "--seconds", "20"},
        "0.1 drop " + made_clip("globe", 30).string() + "\n0.1 key b\n0.1 quit\n", folder.path());
    EXPECT_EQ(closed.code, 0) << closed.err;
    EXPECT_EQ(closed.err, "");
}

TEST(HeadlessWindow, KioskInvitesAndResets) {
    // The overlay and the view of the last visitor are gone; a finger shows how; Escape does nothing.
    const std::string visit =
        "0 overlay depth\n0 turn 40\n0 move 160 110\n0.05 key escape\n0.05 drop nowhere\n";
    const Played during = shot_of_globe(visit, "0.4", {"--kiosk", "--idle", "5", "9"});
    const Played after = shot_of_globe(visit, "1.2", {"--kiosk", "--idle", "0.3", "0.3"});
    const Played plain = shot_of_globe("", "0.4", {"--kiosk"});
    const Played invited = shot_of_globe("", "1.4", {"--kiosk", "--idle", "0.1", "9"});
    EXPECT_EQ(invited.outcome.err, "");
    EXPECT_GT(differences(during.image, plain.image, {60, 60, 260, 180}), 3000);
    // Beside the bar, the words, and the finger that invites.
    EXPECT_GT(differences(during.image, plain.image, {100, 40, 160, 120}), 1000);
    EXPECT_LT(differences(after.image, plain.image, {100, 40, 160, 120}), 100);
    EXPECT_GT(differences(invited.image, plain.image, {60, 180, 260, 230}), 2000) << "no words";
    EXPECT_GT(differences(invited.image, plain.image, {60, 60, 260, 150}), 60) << "no finger";
    const std::vector<std::string> kiosk{
        "play", made_clip("globe", 1).string(), "--headless", "--seconds", "0.2", "--kiosk"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), kiosk.begin(), kiosk.end());
        return more;
    };
    EXPECT_EQ(run_touchable(with({"--settings", "play.json"})).code, 2);
    expect_refused(with({"--idle", "60", "20"}), 2);
}

TEST(HeadlessWindow, ShowsThatForceIsOff) {
    const std::string press = "0 move 160 110\n0.05 press left\n";
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--kiosk"}}) {
        const Played on = shot_of_globe(press, "0.6", more),
                     off = shot_of_globe(press + "0.1 key f\n", "0.6", more);
        EXPECT_GT(differences(on.image, off.image, {60, 140, 260, 235}), 1500) << "no words";
    }
    // A visitor who finds it so need not know how; nor does the finger that invites.
    const std::vector<std::string> kiosk{"--kiosk"}, idle{"--kiosk", "--idle", "0.3", "9"};
    const Played pressed = shot_of_globe("0 key f\n0.3 move 160 110\n0.4 press left\n", "1.5", kiosk),
                 never_off = shot_of_globe("0.3 move 160 110\n0.4 press left\n", "1.5", kiosk);
    EXPECT_LT(differences(pressed.image, never_off.image, {60, 140, 260, 235}), 300);
    const Played plain = shot_of_globe("", "0.3", {"--kiosk"}),
                 invited = shot_of_globe("0 key f\n", "1.8", idle);
    EXPECT_GT(differences(invited.image, plain.image, {60, 60, 260, 150}), 60) << "no finger";
}

/// Of the tests' own means (turns_clock.cpp): what is asked for at one moment is done, and drawn, before what
/// is asked for later, on a machine that lets the window go on for 10 ms of 410 (60 of 460 where it is
/// sanitized).
TEST(HeadlessWindow, ScriptWaitsForTheWindow) {
    const TemporaryFolder folder;
    std::string script = "0 screenshot begun.png\n0.15 key q\n";
    for (const char* const late : {"0.2", "0.25", "0.3"})
        script += late + std::string(" screenshot ") + late + ".png\n";
    std::ofstream(folder / "script") << script;
    const Outcome played = run_in_folder_halting(
        {"play", made_clip("globe", 1).string(), "--headless", "--size", "320x240", "--script", "script",
         "--seconds", "9", "--painter", "cpu", "--builder", "cpu"},
        folder.path(), folder / "begun.png");
    EXPECT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"begun.png", "script"}));
}

TEST(HeadlessWindow, PlaysClipWithoutCommand) {
    const auto played = run_touchable(
        {made_clip("globe", 30).string(), "--headless", "--seconds", "0.3", "--size", "320x240"});
    EXPECT_EQ(played.code, 0) << played.err;
    EXPECT_TRUE(contains(played.out, "pictures"));
}

TEST(HeadlessWindow, SettingsApplyInPlace) {
    const std::string touch = "0.1 move 160 110\n0.1 press left\n";
    const Played plain = shot_of_globe(touch, "0.9");
    // A and B have a force each; A, of 0.2 N, is in effect in the end.
    const Played other = shot_of(
        made_clip("globe", 1),
        touch + "0.2 max-force 0.2\n0.3 settings b\n0.4 max-force 10\n0.4 key b\n0.5 median 5\n", "0.9");
    EXPECT_GT(differences(plain.image, other.image, {12, 30, 40, 100}), 100)
        << "the bar is as high as before";
    // The clip stands still where it stood: the surface beside finger and words is the same.
    EXPECT_LT(differences(plain.image, other.image, {180, 150, 300, 170}), 20);
}

TEST(HeadlessWindow, KeepsSettingsInGivenFile) {
    const TemporaryFolder folder;
    const auto kept_after = [&folder](const std::string& script) {
        const auto played =
            run_scripted({made_clip("globe", 1).string(), "--seconds", "0.1", "--settings", "play.json"},
                         script, folder.path());
        EXPECT_EQ(played.code, 0) << played.err;
        return file_contents(folder / "play.json");
    };
    const std::string kept =
        kept_after("0 median 3\n0 key b\n0 metric pixel\n0 key 2\n0 overlay depth\n0 panel\n");
    for (const char* words : {"\"fingers\": 2", "\"median\": 3", "\"metric\": \"pixel\"",
                              "\"filters\": \"off\"", "\"panel\": true"})
        EXPECT_TRUE(contains(kept, words));
    EXPECT_FALSE(contains(kept, "window")) << "the size was stated";
    EXPECT_FALSE(contains(kept_after("0 reset\n"), "median"));
}

TEST(HeadlessWindow, KeepsSettingsUnfitForClip) {
    const TemporaryFolder folder;
    std::ofstream(folder / "play.json") << R"({"a": {"temporal": "on"}, "b": {"metric": "pixel"}})";
    const auto played =
        run_scripted({made_clip("globe", 1).string(), "--seconds", "0.1", "--settings", "play.json"},
                     "0 median 3\n", folder.path());
    EXPECT_EQ(played.code, 0) << played.err;
    EXPECT_TRUE(contains(played.err, "felt as the clip says"));
    const std::string kept = file_contents(folder / "play.json");
    for (const char* words : {"\"temporal\": \"on\"", "\"metric\": \"pixel\"", "\"median\": 3"})
        EXPECT_TRUE(contains(kept, words));
}

TEST(HeadlessWindow, UnfitReliefKeepsOtherSettings) {
    const TemporaryFolder folder;
    const std::string settings = (folder / "play.json").string(), record = (folder / "hand.touch").string();
    std::ofstream(settings) << R"({"a": {"relief": 100, "relief-height": 1, "max-force": 0.4}})";
    const Played recorded =
        shot_of(made_clip("globe", 30), "", "0.3", {"--record", record, "--settings", settings});
    EXPECT_TRUE(contains(recorded.outcome.err, "felt without relief: relief that is tried is not recorded"));
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_EQ(recording->front().facts.at("guard").at("max_force"), 0.4);
    const std::string grey = (folder / "grey.mkv").string();
    make_clip(grey, "bumps", 1);
    const Played without_colour = shot_of(grey, "", "0.3", {"--settings", settings});
    EXPECT_TRUE(contains(without_colour.outcome.err, "felt without relief: "));
    const std::string kept = file_contents(settings);
    for (const char* words : {"\"relief\": 100", "\"relief-height\": 1", "\"max-force\": 0.4"})
        EXPECT_TRUE(contains(kept, words));
}

TEST(HeadlessWindow, RecordingHasPartPerSetting) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string();
    shot_of(made_clip("globe", 30),
            "0 move 160 110\n0 press left\n0.2 key b\n0.5 max-force 0.4\n0.8 seek 0.1\n0.9 key b\n1.2 key "
            "space\n",
            "1.4", {"--record", record});
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    ASSERT_GT(recording->size(), 2U);
    EXPECT_EQ(recording->front().facts.at("guard").at("max_force"), 10);
    double least = 10;
    for (const RecordedPart& part : *recording) {
        EXPECT_EQ(part.facts.at("S"), recording->front().facts.at("S"));
        least = std::min(least, part.facts.at("guard").at("max_force").get<double>());
    }
    EXPECT_EQ(least, 0.4);
    const auto report = nlohmann::json::parse(replayed(folder.path(), record));
    EXPECT_GT(report.at("contact_ticks"), 100) << "nothing was touched";
    EXPECT_EQ(report.at("parts").size(), recording->size());

    // A recording that was cut between its parts, and one whose last part another program made.
    const std::string whole = file_contents(record);
    const std::size_t last = whole.rfind("TOUCHREC");
    std::ofstream(record, std::ios::binary) << whole.substr(0, last);
    expect_refused({"touch", "--replay", record}, 3);
    RecordingBytes other(whole.substr(last));
    other.set_real(other.force_at(other.ticks() / 2, 0), 0.125);
    std::ofstream(record, std::ios::binary) << whole.substr(0, last) << other.bytes();
    const auto differs = run_touchable({"touch", "--replay", record});
    EXPECT_EQ(differs.code, 6);
    EXPECT_TRUE(contains(differs.err, "part " + std::to_string(recording->size()) + ", tick"));
    std::int64_t ms = 0;
    for (const RecordedPart& part : *recording) ms += part.ticks.back().time_ns / 1'000'000 + 1;
    const auto hand = RepeatingHand::read("rec:" + record);
    ASSERT_TRUE(hand) << hand.error().message;
    EXPECT_EQ((*hand)->ticks(), ms) << "all parts one after the other";
}

// A kiosk's log of use.

using namespace std::chrono_literals;

class KioskLog : public ::testing::Test {
protected:
    /// 2026-11-24 10:00:00 and so many seconds, universal time.
    static UseLog::Time at(int seconds) { return UseLog::Time(std::chrono::seconds(1795514400 + seconds)); }
    std::string text() const { return file_contents(file_); }
    const TemporaryFolder folder_;
    const std::filesystem::path file_ = folder_ / "use.csv";
};

TEST_F(KioskLog, LogsVisitsAndFaultsAnonymously) {
    {
        auto log = UseLog::open(file_);
        ASSERT_TRUE(log) << log.error().message;
        (*log)->start(at(0));
        (*log)->visit(at(5), 42.26);
        (*log)->fault(at(60), "globe.mkv: \"cut\", short\nor so");
        (*log)->visit(at(70), 3);
        (*log)->end(at(90));
        EXPECT_FALSE((*log)->missing());
    }
    EXPECT_EQ(text(), std::string(UseLog::header) +
                          "2026-11-24T10:00:00Z,start,,,\n"
                          "2026-11-24T10:00:05Z,visit,1,42.3,\n"
                          "2026-11-24T10:01:00Z,fault,,,\"globe.mkv: \"\"cut\"\", short\\nor so\"\n"
                          "2026-11-24T10:01:10Z,visit,2,3.0,\n"
                          "2026-11-24T10:01:30Z,end,,,\n");
}

TEST_F(KioskLog, WritesRowsAtOnce) {
    auto log = UseLog::open(file_);
    ASSERT_TRUE(log);
    (*log)->visit(at(0), 1);
    EXPECT_TRUE(comes_true([&] { return bool(contains(text(), ",visit,1,1.0,\n")); }));
    EXPECT_FALSE(UseLog::open(file_)) << "two programs would write between each other's rows";
}

TEST_F(KioskLog, AppendsAfterTruncatedRow) {
    std::ofstream(file_) << UseLog::header << "2026-11-24T09:00:00Z,vis";
    {
        auto log = UseLog::open(file_);
        ASSERT_TRUE(log) << log.error().message;
        (*log)->start(at(0));
    }
    EXPECT_EQ(text(),
              std::string(UseLog::header) + "2026-11-24T09:00:00Z,vis\n2026-11-24T10:00:00Z,start,,,\n");
}

TEST_F(KioskLog, OverwritesNoOtherFile) {
    std::ofstream(file_) << "my diary\n";
    const auto refused = UseLog::open(file_);
    ASSERT_FALSE(refused);
    EXPECT_TRUE(contains(refused.error().message, "no log of use"));
    EXPECT_EQ(text(), "my diary\n");
    EXPECT_FALSE(UseLog::open(folder_.path()));
    EXPECT_FALSE(UseLog::open(folder_ / "nowhere" / "use.csv"));
    EXPECT_FALSE(UseLog::open("/dev/full"));
}

/// A pipe takes all that is written to it, and has no disk.
TEST(DurableAppend, ReportsUnsyncedRow) {
    int ends[2] = {};
    ASSERT_EQ(pipe(ends), 0);
    EXPECT_EQ(append_durably(ends[1], "row\n"), EINVAL);
    close(ends[0]);
    close(ends[1]);
}

TEST_F(KioskLog, NeverWaitsForHungDisk) {
    std::promise<void> answer;
    const std::shared_future<void> answers = answer.get_future().share();
    auto log = UseLog::open(file_, [answers](int out, std::string_view row) {
        answers.wait();
        return append_durably(out, row);
    });
    ASSERT_TRUE(log) << log.error().message;
    (*log)->start(at(0));
    (*log)->end(at(1));
    const auto missing = (*log)->finish(20ms);
    ASSERT_FALSE(missing);
    EXPECT_TRUE(contains(missing.error().message,
                         "not written in time: the disk hangs, or this machine is busy; the last rows"));
    EXPECT_EQ(text(), UseLog::header);
    answer.set_value();
    EXPECT_TRUE((*log)->finish(60s)) << "it was only slow";
    EXPECT_TRUE(contains(text(), ",end,,,\n"));
}

TEST_F(KioskLog, LogsClipThatCannotOpen) {
    std::ofstream(folder_ / "broken.mkv") << "no clip";
    const auto ended = run_touchable({"play", (folder_ / "broken.mkv").string(),
                                      (folder_ / "broken.mkv").string(), "--headless", "--painter", "cpu",
                                      "--kiosk", "--use-log", file_.string(), "--seconds", "1"});
    EXPECT_EQ(ended.code, 3) << ended.err;
    EXPECT_TRUE(std::regex_search(text(), std::regex("start,,,\n.*fault,,,\".*broken.mkv.*\n.*end,,,\n$")))
        << text();
}

TEST_F(KioskLog, ReportsFullDiskOnce) {
    const std::string clip = (folder_ / "globe.mkv").string();
    make_clip(clip, "globe", 2);
    std::string script;  // three visitors
    for (const double come_s : {0.1, 2.3, 4.5})
        script += std::to_string(come_s) + " move 80 60\n" + std::to_string(come_s + 0.2) + " move 90 60\n";
    std::ofstream(folder_ / "script") << script;
    const std::vector<std::string> words{
        "play",      clip,        "--headless",   "--painter", "cpu",
        "--size",    "160x120",   "--kiosk",      "--idle",    "1.4",
        "1.5",       "--use-log", file_.string(), "--script",  (folder_ / "script").string(),
        "--seconds", "6.4"};
    const auto played = run_touchable(words);
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(played.err, "");
    EXPECT_TRUE(std::regex_search(
        text(),
        std::regex(
            "start,,,\n.*visit,1,0\\.[0-9],\n.*visit,2,0\\.[0-9],\n.*visit,3,0\\.[0-9],\n.*end,,,\n$")))
        << text();
    std::string long_log = UseLog::header;
    while (long_log.size() < 4050) long_log += "2026-11-24T10:00:05Z,visit,1,42.3,\n";
    std::ofstream(file_) << long_log;
    const auto full = run_on_full_disk(words, 4);
    EXPECT_EQ(full.code, 0) << full.err;
    EXPECT_TRUE(contains(full.err, "rows of the log of use are lost"));
    EXPECT_EQ(std::count(full.err.begin(), full.err.end(), '\n'), 1) << full.err;
    EXPECT_EQ(text().back(), '\n') << "only whole rows";
}

// The sound of a finger on a surface: from the pointer to the file and to the loudspeakers.

/// Samples of the left channel, by milliseconds.
class Wav {
public:
    explicit Wav(const std::filesystem::path& file) {
        const std::string bytes = file_contents(file);
        EXPECT_GE(bytes.size(), 44U);
        if (bytes.size() < 44) return;
        EXPECT_EQ(std::string(bytes.data(), 4), "RIFF");
        EXPECT_EQ(std::string(bytes.data() + 8, 8), "WAVEfmt ");
        EXPECT_EQ(number(bytes, 4, 4), bytes.size() - 8);
        EXPECT_EQ(number(bytes, 22, 2), 2U);
        EXPECT_EQ(number(bytes, 24, 4), 48000U);
        EXPECT_EQ(number(bytes, 40, 4), bytes.size() - 44);
        for (std::size_t at = 44; at + 4 <= bytes.size(); at += 4)
            samples_.push_back(static_cast<std::int16_t>(number(bytes, at, 2)) / 32767.0);
    }
    std::size_t milliseconds() const { return samples_.size() / 48; }
    double loudness(std::size_t from_ms, std::size_t to_ms) const {
        double sum = 0;
        for (std::size_t k = from_ms * 48; k < to_ms * 48 && k < samples_.size(); ++k)
            sum += samples_[k] * samples_[k];
        return std::sqrt(sum / static_cast<double>((to_ms - from_ms) * 48));
    }

private:
    static std::size_t number(const std::string& bytes, std::size_t at, std::size_t count) {
        std::size_t value = 0;
        for (std::size_t k = 0; k < count; ++k)
            value |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[at + k])) << (8 * k);
        return value;
    }
    std::vector<double> samples_;
};

/// A pointer over the globe, in a time of its own.
class HeardGlobe : public FingersOverGlobe {
protected:
    HeardGlobe() : FingersOverGlobe({320, 240}, {640, 480}) {}
    // Pixels of the picture: sea, and mountains.
    static constexpr glm::dvec2 sea{220, 250}, land{250, 120};

    void SetUp() override {
        const Scene& scene = shown_->scene;
        auto solver = TouchSolver::create(scene, {.metres_per_scene_unit = workspace_.metres_per_scene_unit});
        ASSERT_TRUE(solver);
        solver_.emplace(std::move(*solver));
        step_.emplace(*solver_, GuardSettings{}, PointerFingers::most);
        auto sound = WindowSound::create(false, file(), Existing::keep);
        ASSERT_TRUE(sound);
        sound_ = std::move(*sound);
        listener_.emplace(*sound_, scene.width);
        listener_->begin(PlaybackClock(scene.rate), 0);
    }
    std::filesystem::path file() const { return folder_ / "heard.wav"; }
    void go_on(int ticks) {
        for (int k = 0; k < ticks; ++k, ++tick_) {
            if (tick_ % 16 == 0) fingers_->intend(field(), camera());
            ASSERT_TRUE(device_.read_positions(step_->goals()));
            for (glm::dvec3& goal : step_->goals()) goal = workspace_.to_scene(goal);
            const TouchTick done = step_->run(tick_, tick_ * 1'000'000, shown_->scene, shown_->pair());
            ASSERT_TRUE(listener_->consume(done));
        }
    }
    /// Over the picture, pressed, and then to the right for 600 ms.
    void stroke(const glm::dvec2& from, int pixels) {
        fingers_->set_pointer(from);
        go_on(300);
        fingers_->press(true);
        go_on(300);
        for (int k = 0; k < 40; ++k) {
            fingers_->set_pointer(from + glm::dvec2(pixels * k / 40.0, 0));
            go_on(15);
        }
        fingers_->press(false);
        fingers_->set_pointer({});
    }
    Wav heard() {
        EXPECT_TRUE(sound_->finish());
        return Wav(file());
    }

    TemporaryFolder folder_;
    std::optional<TouchSolver> solver_;
    std::optional<TouchStep> step_;
    std::unique_ptr<WindowSound> sound_;
    std::optional<TouchListener> listener_;
    std::int64_t tick_ = 0;
};

TEST_F(HeardGlobe, LandIsLouderThanSea) {
    stroke(sea, 90);
    go_on(300);
    stroke(land, 90);
    const Wav wav = heard();
    ASSERT_EQ(wav.milliseconds(), 2700U);
    EXPECT_EQ(wav.loudness(0, 300), 0) << "over the surface";
    EXPECT_GT(wav.loudness(300, 500), 0.002) << "no tap";
    EXPECT_GT(wav.loudness(700, 1200), 0.002) << "the sea is not heard";
    EXPECT_EQ(wav.loudness(1450, 1500), 0) << "away";
    EXPECT_GT(wav.loudness(2200, 2700), 1.5 * wav.loudness(700, 1200));
}

TEST_F(HeardGlobe, ChangedSurfaceIsNoTap) {
    fingers_->set_pointer(sea);
    go_on(300);
    fingers_->press(true);
    go_on(800);
    listener_.emplace(*sound_, shown_->scene.width);  // other settings, with the finger where it was
    listener_->begin(PlaybackClock(shown_->scene.rate), 0);
    tick_ = 0;
    go_on(200);
    fingers_->press(false);
    go_on(300);
    fingers_->press(true);
    go_on(300);
    const Wav wav = heard();
    EXPECT_GT(wav.loudness(300, 500), 0.002) << "no tap";
    EXPECT_LT(wav.loudness(1100, 1300), 1e-4);
    EXPECT_GT(wav.loudness(1600, 1900), 0.002) << "no tap";
}

TEST_F(HeardGlobe, IsSilentWhileMuted) {
    sound_->set_muted(true);
    EXPECT_EQ(sound_->state(), "sound off");
    stroke(sea, 90);
    sound_->set_muted(false);
    stroke(sea, 90);
    const Wav wav = heard();
    EXPECT_EQ(wav.loudness(0, 1200), 0);
    EXPECT_GT(wav.loudness(1500, 2400), 0.002);
}

TEST(Sound, WindowSoundIsSaved) {
    const TemporaryFolder folder;
    const std::string clip = made_clip("globe", 2).string(), wav = (folder / "heard.wav").string();
    const auto play = [&] {
        return run_scripted({clip, "--seconds", "0.6", "--sound", wav}, "0 move 160 130\n0.2 press left\n",
                            folder.path());
    };
    const auto played = play();
    ASSERT_EQ(played.code, 0) << played.err;
    const Wav heard(wav);
    EXPECT_GT(heard.milliseconds(), 400U);
    EXPECT_GT(heard.loudness(0, heard.milliseconds()), 0.001);
    const auto again = play();
    EXPECT_EQ(again.code, 2);
    EXPECT_TRUE(contains(again.err, "--overwrite"));
}

/// A visitor has stopped forces: the next one presses, and feels.
TEST(Sound, KioskSoundReturnsOnPress) {
    const TemporaryFolder folder;
    const std::string clip = made_clip("globe", 2).string(), wav = (folder / "heard.wav").string();
    const auto played = run_scripted({clip, "--kiosk", "--seconds", "1.5", "--sound", wav},
                                     "0 move 160 130\n0 key f\n0.3 press left\n", folder.path());
    ASSERT_EQ(played.code, 0) << played.err;
    const Wav heard(wav);
    EXPECT_GT(heard.loudness(0, heard.milliseconds()), 0.001);
}

TEST(Sound, ClipSoundIsSaved) {
    const TemporaryFolder folder;
    const std::string clip = (folder / "globe.mkv").string(), wav = (folder / "heard.wav").string();
    make_clip(clip, "globe", 60);
    std::vector<StereoSample> sound = tone(480, 1.8);
    std::fill_n(sound.begin(), 24'000, StereoSample{});  // for half a second it is silent
    write_sounding_clip(folder / "sounding.mkv", sound, clip);
    const auto played = run_touchable({"play", (folder / "sounding.mkv").string(), "--headless", "--size",
                                       "160x120", "--seconds", "1.2", "--sound", wav});
    ASSERT_EQ(played.code, 0) << played.err;
    const Wav heard(wav);
    ASSERT_GT(heard.milliseconds(), 1000U);
    EXPECT_EQ(heard.loudness(0, 300), 0);
    EXPECT_GT(heard.loudness(700, 1000), 0.3);
}

/// ALSA as those lines configure it.
class Loudspeakers : public ::testing::Test {
protected:
    void configure(const std::string& lines) {
        std::ofstream(folder_ / "asound.conf") << lines;
        ASSERT_EQ(setenv("ALSA_CONFIG_PATH", (folder_ / "asound.conf").c_str(), 1), 0);
    }
    void TearDown() override { unsetenv("ALSA_CONFIG_PATH"); }
    TemporaryFolder folder_;
};

TEST_F(Loudspeakers, MissingDeviceIsNoError) {
    configure("");
    auto sound = WindowSound::create(true, {}, Existing::keep);
    ASSERT_TRUE(sound);
    testing::internal::CaptureStderr();
    EXPECT_TRUE(comes_true([&] { return (*sound)->state().starts_with("no sound: "); })) << (*sound)->state();
    (*sound)->consume({}, 1);
    EXPECT_TRUE((*sound)->finish());
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(Loudspeakers, PlayTouch) {
#ifndef TOUCHABLE_HAS_ALSA
    GTEST_SKIP() << "built without ALSA";
#endif
    const std::string file = (folder_ / "raw").string();
    configure("pcm.!default {\n type file\n file \"" + file +
              "\"\n format raw\n slave.pcm { type null }\n}\n");
    auto sound = WindowSound::create(true, {}, Existing::keep);
    ASSERT_TRUE(sound);
    ASSERT_TRUE(comes_true([&] { return (*sound)->state() == "sound on"; })) << (*sound)->state();
    HeardTick tick;
    tick.fingers[0] = {.touching = true, .newtons = 2, .slip = 0.1F, .stiffness = 1000};
    const bool heard = comes_true([&] {
        (*sound)->consume(tick, 1);
        const std::string bytes = file_contents(file);
        return std::any_of(bytes.begin(), bytes.end(), [](char byte) { return byte != 0; });
    });
    EXPECT_TRUE(heard);
}

}  // namespace
}  // namespace touchable::test
