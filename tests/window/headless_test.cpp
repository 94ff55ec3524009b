// The window without a window: what it shows, and by which settings it is felt, by the program as a person
// starts it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string>
#include <vector>

#include "player/run/run_files.hpp"
#include "tests/player/recording_bytes.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

TEST(HeadlessWindow, ShowsAFingerWhereThePointerPresses) {
    const Played without = shot_of(made_clip("globe", 1), "", "0.8");
    const Played with = shot_of(made_clip("globe", 1), "0 move 160 110\n0.1 press left\n", "0.8");
    ASSERT_EQ(with.image.width, 320);
    ASSERT_EQ(with.image.height, 240);
    // Apart from the words in the corners and the bar below: round the pointer a finger with its arrow,
    // beside it none.
    EXPECT_GT(differences(without.image, with.image, {140, 90, 180, 130}), 60);
    EXPECT_EQ(differences(without.image, with.image, {220, 100, 310, 170}), 0);
    EXPECT_NE(with.outcome.out.find("pictures"), std::string::npos) << with.outcome.out;
}

/// In the middle, where there is no panel and beside the finger no ring: nothing draws those without a GPU.
/// (Fingers are compared by Drawing.HasATwinOnTheCpu.)
TEST(HeadlessWindow, IsDrawnByTheCpuAlike) {
    const std::string large = "0 size 640x480\n", touch = large + "0 move 330 190\n0.1 press left\n";
    const std::vector<std::string> by_cpu{"--painter", "cpu", "--builder", "cpu"};
    const Played gpu = shot_of(made_clip("globe", 1), touch, "0.8", {"--painter", "raster"});
    const Played cpu = shot_of(made_clip("globe", 1), touch, "0.8", by_cpu);
    const Played bare = shot_of(made_clip("globe", 1), large, "0.3", by_cpu);
    EXPECT_GT(differences(bare.image, cpu.image, {300, 140, 420, 220}), 400);
    EXPECT_LE(differences(gpu.image, cpu.image, {240, 60, 300, 400}), 60);
    EXPECT_LE(differences(gpu.image, cpu.image, {300, 220, 620, 400}), 60);
    EXPECT_NE(cpu.outcome.out.find("by the cpu painter\n"), std::string::npos) << cpu.outcome.out;
}

TEST(HeadlessWindow, OverlayColoursTheSurface) {
    const Played colour = shot_of(made_clip("globe", 1), "", "0.5");
    const Played depth = shot_of(made_clip("globe", 1), "0 overlay depth\n", "0.5");
    EXPECT_GT(differences(colour.image, depth.image, {120, 80, 200, 160}), 3000);
}

TEST(HeadlessWindow, OverlayIsNotCarriedToTheNextClip) {
    const TemporaryFolder folder;
    const std::vector<std::string> settings{"--settings", (folder / "play.json").string()};
    const Played depth = shot_of(made_clip("globe", 1), "0 overlay depth\n", "0.5", settings);
    const Played next = shot_of(made_clip("globe", 1), "", "0.5", settings),
                 plain = shot_of(made_clip("globe", 1), "", "0.5");
    EXPECT_GT(differences(depth.image, next.image, {120, 80, 200, 160}), 3000);
    EXPECT_EQ(differences(plain.image, next.image, {120, 80, 200, 160}), 0);
}

TEST(HeadlessWindow, TouchThatIsRecordedRepeatsToTheBitWithoutIt) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string();
    shot_of(made_clip("globe", 30),
            "0 move 150 110\n0.1 press left\n0.3 move 170 115\n0.4 key space\n0.5 move 160 120\n0.6 seek "
            "0.2\n0.7 speed 2\n"
            "0.8 key space\n0.9 wheel 2\n1.0 key .\n1.1 key 3\n1.2 loop\n",
            "1.4", {"--record", record});
    const auto again = run_touchable({"touch", "--replay", record, "--json", "-"});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.err.find("as recorded, to the bit"), std::string::npos) << again.err;
    EXPECT_EQ(again.out.find("\"contact_ticks\": 0,"), std::string::npos) << "nothing was touched";
    EXPECT_NE(again.out.find("\"fingers_led\": 3,"), std::string::npos) << "one, and three from 1.1 s on";
}

TEST(HeadlessWindow, FileThatCannotBeOpenedLeavesTheOldClip) {
    const Played shot = shot_of(made_clip("globe", 1), "0.1 drop nowhere.mkv\n0.2 move 160 110\n", "0.7");
    const Played without = shot_of(made_clip("globe", 1), "0.2 move 160 110\n", "0.7");
    EXPECT_GT(differences(shot.image, without.image, {60, 0, 260, 60}), 100) << "no message";
    EXPECT_NE(shot.outcome.err.find("nowhere.mkv"), std::string::npos) << "nobody sees that message";
    EXPECT_EQ(differences(shot.image, without.image, {220, 100, 310, 160}), 0);
}

TEST(HeadlessWindow, OtherClipTakesThePlaceOfTheOldOneAndIsNotWaitedForInTheEnd) {
    const Played before = shot_of(made_clip("globe", 30), "0 key space\n0 seek 0.5\n", "0.8");
    // Late, for a clip opens in the background, and a busy machine takes its time.
    const Played other =
        shot_of(made_clip("globe", 30), "0 drop " + made_clip("globe", 1).string() + "\n", "3");
    const Played same = shot_of(made_clip("globe", 1), "", "0.8");
    EXPECT_GT(differences(before.image, other.image, {100, 60, 220, 180}), 100);
    EXPECT_LT(differences(same.image, other.image, {100, 60, 220, 180}), 20);
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << "0.1 drop " << made_clip("globe", 30).string()
                                     << "\n0.1 key b\n0.1 quit\n";
    const auto closed =
        run_touchable({"play", made_clip("globe", 1).string(), "--headless", "--size", "320x240", "--script",
                       (folder / "script").string(), "--seconds", "20"});
    EXPECT_EQ(closed.code, 0) << closed.err;
    EXPECT_EQ(closed.err, "");
}

TEST(HeadlessWindow, KioskInvitesAndBeginsAnewAndNothingEndsIt) {
    // The overlay and the view of the last visitor are gone; a finger shows how; Escape is nobody's.
    const std::string visit =
        "0 overlay depth\n0 turn 40\n0 move 160 110\n0.05 key escape\n0.05 drop nowhere\n";
    const Played during = shot_of(made_clip("globe", 1), visit, "0.4", {"--kiosk", "--idle", "5", "9"});
    const Played after = shot_of(made_clip("globe", 1), visit, "1.2", {"--kiosk", "--idle", "0.3", "0.3"});
    const Played plain = shot_of(made_clip("globe", 1), "", "0.4", {"--kiosk"});
    const Played invited = shot_of(made_clip("globe", 1), "", "1.4", {"--kiosk", "--idle", "0.1", "9"});
    EXPECT_EQ(invited.outcome.err, "");
    EXPECT_GT(differences(during.image, plain.image, {60, 60, 260, 180}), 3000);
    // Beside the bar, the words, and the finger that invites.
    EXPECT_GT(differences(during.image, plain.image, {100, 40, 160, 120}), 1000);
    EXPECT_LT(differences(after.image, plain.image, {100, 40, 160, 120}), 100);
    EXPECT_GT(differences(invited.image, plain.image, {60, 180, 260, 230}), 2000) << "no words";
    EXPECT_GT(differences(invited.image, plain.image, {60, 60, 260, 150}), 60) << "no finger";
    const auto kept = run_touchable({"play", made_clip("globe", 1).string(), "--headless", "--seconds", "0.2",
                                     "--kiosk", "--settings", "play.json"});
    EXPECT_EQ(kept.code, 2);
    const auto backward = run_touchable({"play", made_clip("globe", 1).string(), "--headless", "--seconds",
                                         "0.2", "--kiosk", "--idle", "60", "20"});
    EXPECT_EQ(backward.code, 2);
    EXPECT_TRUE(backward.one_line_of_error()) << backward.err;
}

TEST(HeadlessWindow, SaysLargeThatForceIsOff) {
    const std::string press = "0 move 160 110\n0.05 press left\n";
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--kiosk"}}) {
        const Played on = shot_of(made_clip("globe", 1), press, "0.6", more),
                     off = shot_of(made_clip("globe", 1), press + "0.1 key f\n", "0.6", more);
        EXPECT_GT(differences(on.image, off.image, {60, 140, 260, 235}), 1500) << "no words";
    }
    // A visitor who finds it so need not know how; nor does the finger that invites.
    const std::vector<std::string> kiosk{"--kiosk"}, idle{"--kiosk", "--idle", "0.3", "9"};
    const Played pressed = shot_of(made_clip("globe", 1), "0 key f\n0.3 move 160 110\n0.4 press left\n",
                                   "1.5", kiosk),
                 never_off =
                     shot_of(made_clip("globe", 1), "0.3 move 160 110\n0.4 press left\n", "1.5", kiosk);
    EXPECT_LT(differences(pressed.image, never_off.image, {60, 140, 260, 235}), 300);
    const Played plain = shot_of(made_clip("globe", 1), "", "0.3", {"--kiosk"}),
                 invited = shot_of(made_clip("globe", 1), "0 key f\n", "1.8", idle);
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

TEST(HeadlessWindow, ClipAloneIsPlayed) {
    const auto played = run_touchable(
        {made_clip("globe", 30).string(), "--headless", "--seconds", "0.3", "--size", "320x240"});
    EXPECT_EQ(played.code, 0) << played.err;
    EXPECT_NE(played.out.find("pictures"), std::string::npos);
}

TEST(HeadlessWindow, SettingsChangeWhatIsFeltWhereTheClipStands) {
    const std::string touch = "0.1 move 160 110\n0.1 press left\n";
    const Played plain = shot_of(made_clip("globe", 1), touch, "0.9");
    // A and B have a force each; A, of 0.2 N, is in effect in the end.
    const Played other = shot_of(
        made_clip("globe", 1),
        touch + "0.2 max-force 0.2\n0.3 settings b\n0.4 max-force 10\n0.4 key b\n0.5 median 5\n", "0.9");
    EXPECT_GT(differences(plain.image, other.image, {12, 30, 40, 100}), 100)
        << "the bar is as high as before";
    // The clip stands still where it stood: the surface beside finger and words is the same.
    EXPECT_LT(differences(plain.image, other.image, {180, 150, 300, 170}), 20);
}

TEST(HeadlessWindow, KeepsSettingsWhereItIsToldTo) {
    const TemporaryFolder folder;
    const auto kept_after = [&folder](const std::string& script) {
        std::ofstream(folder / "script") << script;
        const auto played = run_touchable(
            {"play", made_clip("globe", 1).string(), "--headless", "--seconds", "0.1", "--size", "320x240",
             "--script", (folder / "script").string(), "--settings", (folder / "play.json").string()});
        EXPECT_EQ(played.code, 0) << played.err;
        return file_contents(folder / "play.json");
    };
    const std::string kept =
        kept_after("0 median 3\n0 key b\n0 metric pixel\n0 key 2\n0 overlay depth\n0 panel\n");
    for (const char* words : {"\"fingers\": 2", "\"median\": 3", "\"metric\": \"pixel\"",
                              "\"filters\": \"off\"", "\"panel\": true"})
        EXPECT_NE(kept.find(words), std::string::npos) << words << " in " << kept;
    EXPECT_EQ(kept.find("window"), std::string::npos) << "the size was stated";
    EXPECT_EQ(kept_after("0 reset\n").find("median"), std::string::npos);
}

TEST(HeadlessWindow, SettingsThatDoNotGoWithTheClipStayKeptWhateverIsChanged) {
    const TemporaryFolder folder;
    std::ofstream(folder / "play.json") << R"({"a": {"temporal": "on"}, "b": {"metric": "pixel"}})";
    std::ofstream(folder / "script") << "0 median 3\n";
    const auto played = run_touchable({"play", made_clip("globe", 1).string(), "--headless", "--seconds",
                                       "0.1", "--size", "320x240", "--script", (folder / "script").string(),
                                       "--settings", (folder / "play.json").string()});
    EXPECT_EQ(played.code, 0) << played.err;
    EXPECT_NE(played.err.find("felt as the clip says"), std::string::npos) << played.err;
    const std::string kept = file_contents(folder / "play.json");
    for (const char* words : {"\"temporal\": \"on\"", "\"metric\": \"pixel\"", "\"median\": 3"})
        EXPECT_NE(kept.find(words), std::string::npos) << words << " in " << kept;
}

TEST(HeadlessWindow, ReliefThatDoesNotGoWithTheClipTakesNoOtherSettingWithIt) {
    const TemporaryFolder folder;
    const std::string settings = (folder / "play.json").string(), record = (folder / "hand.touch").string();
    std::ofstream(settings) << R"({"a": {"relief": 100, "relief-height": 1, "max-force": 0.4}})";
    const Played recorded =
        shot_of(made_clip("globe", 30), "", "0.3", {"--record", record, "--settings", settings});
    EXPECT_NE(recorded.outcome.err.find("felt without relief: relief that is tried is not recorded"),
              std::string::npos)
        << recorded.outcome.err;
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_EQ(recording->front().facts.at("guard").at("max_force"), 0.4);
    const std::string grey = (folder / "grey.mkv").string();
    ASSERT_EQ(run_touchable({"make", "bumps", grey, "--size", "64x48", "--frames", "1"}).code, 0);
    const Played without_colour = shot_of(grey, "", "0.3", {"--settings", settings});
    EXPECT_NE(without_colour.outcome.err.find("felt without relief: "), std::string::npos)
        << without_colour.outcome.err;
    const std::string kept = file_contents(settings);
    for (const char* words : {"\"relief\": 100", "\"relief-height\": 1", "\"max-force\": 0.4"})
        EXPECT_NE(kept.find(words), std::string::npos) << words << " in " << kept;
}

TEST(HeadlessWindow, RecordingKeepsChangesOfSettings) {
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
    const auto again = run_touchable({"touch", "--replay", record, "--json", "-"});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.err.find("as recorded, to the bit"), std::string::npos) << again.err;
    const auto report = nlohmann::json::parse(again.out);
    EXPECT_GT(report.at("contact_ticks"), 100) << "nothing was touched";
    EXPECT_EQ(report.at("parts").size(), recording->size());

    // A recording that was cut between its parts, and one whose last part another program made.
    const std::string whole = file_contents(record);
    const std::size_t last = whole.rfind("TOUCHREC");
    std::ofstream(record, std::ios::binary) << whole.substr(0, last);
    const auto cut = run_touchable({"touch", "--replay", record});
    EXPECT_EQ(cut.code, 3);
    EXPECT_TRUE(cut.one_line_of_error()) << cut.err;
    RecordingBytes other(whole.substr(last));
    other.set_real(other.force_at(other.ticks() / 2, 0), 0.125);
    std::ofstream(record, std::ios::binary) << whole.substr(0, last) << other.bytes();
    const auto differs = run_touchable({"touch", "--replay", record});
    EXPECT_EQ(differs.code, 6);
    EXPECT_NE(differs.err.find("part " + std::to_string(recording->size()) + ", tick"), std::string::npos)
        << differs.err;
    std::int64_t ms = 0;
    for (const RecordedPart& part : *recording) ms += part.ticks.back().time_ns / 1'000'000 + 1;
    const auto hand = RepeatingHand::read("rec:" + record);
    ASSERT_TRUE(hand) << hand.error().message;
    EXPECT_EQ((*hand)->ticks(), ms) << "all parts one after the other";
}

}  // namespace
}  // namespace touchable::test
