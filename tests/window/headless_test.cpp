// The window without a window: what it shows, and what is felt in it, by the program as a person starts it.
#include <gtest/gtest.h>
#include <sys/inotify.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "engine/picture/image_file.hpp"
#include "engine/sound/sound_track.hpp"
#include "player/record/recording.hpp"
#include "player/record/repeating_hand.hpp"
#include "tests/player/program.hpp"
#include "tests/player/recording_bytes.hpp"
#include "tests/video/film_reader.hpp"

namespace touchable::test {
namespace {

/// A small globe, once for all tests of this program.
const std::filesystem::path& globe() {
    static const TemporaryFolder folder;
    static const std::filesystem::path clip = [] {
        const auto made = run_touchable(
            {"make", "globe", (folder / "globe.mkv").string(), "--size", "160x120", "--frames", "30"});
        EXPECT_EQ(made.code, 0) << made.err;
        return folder / "globe.mkv";
    }();
    return clip;
}

/// One frame of it: what is shown does not depend on when.
const std::filesystem::path& still() {
    static const TemporaryFolder folder;
    static const std::filesystem::path clip = [] {
        const auto made = run_touchable(
            {"make", "globe", (folder / "still.mkv").string(), "--size", "160x120", "--frames", "1"});
        EXPECT_EQ(made.code, 0) << made.err;
        return folder / "still.mkv";
    }();
    return clip;
}

struct Shot {
    Outcome outcome;
    Image image;
};

/// What the window shows `seconds` after it opened, once `script` has been done to it.
Shot shot_of(const std::filesystem::path& clip, const std::string& script, const std::string& seconds,
             const std::vector<std::string>& more = {}) {
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << script;
    std::vector<std::string> words{"play",
                                   clip.string(),
                                   "--headless",
                                   "--size",
                                   "320x240",
                                   "--script",
                                   (folder / "script").string(),
                                   "--screenshot",
                                   (folder / "shot.png").string(),
                                   "--at",
                                   seconds};
    words.insert(words.end(), more.begin(), more.end());
    Shot shot{run_touchable(words), {}};
    EXPECT_EQ(shot.outcome.code, 0) << shot.outcome.err;
    const auto image = read_image(folder / "shot.png");
    EXPECT_TRUE(image.ok());
    if (image.ok()) shot.image = *image;
    return shot;
}

/// How many pixels of a part differ by more than 24 of 255 in a channel.
int differences(const Image& a, const Image& b, int x0, int y0, int x1, int y1) {
    if (a.width != b.width || a.height != b.height) return -1;
    int count = 0;
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x)
            for (int c = 0; c < 3; ++c) {
                const auto at = static_cast<std::size_t>((y * a.width + x) * 3 + c);
                if (std::abs(a.samples[at] - b.samples[at]) <= 24) continue;
                ++count;
                break;
            }
    return count;
}

TEST(HeadlessWindow, ShowsAFingerWhereThePointerPresses) {
    const Shot without = shot_of(still(), "", "0.8");
    const Shot with = shot_of(still(), "0 move 160 110\n0.1 press left\n", "0.8");
    ASSERT_EQ(with.image.width, 320);
    ASSERT_EQ(with.image.height, 240);
    // Apart from the words in the corners and the bar below: round the pointer a finger with its arrow,
    // beside it none.
    EXPECT_GT(differences(without.image, with.image, 140, 90, 180, 130), 60);
    EXPECT_EQ(differences(without.image, with.image, 220, 100, 310, 170), 0);
    EXPECT_NE(with.outcome.out.find("pictures"), std::string::npos) << with.outcome.out;
}

/// In the middle, where there is no panel and beside the finger no ring: nothing draws those without a GPU.
/// (Fingers are compared by Drawing.HasATwinOnTheCpu.)
TEST(HeadlessWindow, IsDrawnByTheCpuAlike) {
    const std::string large = "0 size 640x480\n", touch = large + "0 move 330 190\n0.1 press left\n";
    const std::vector<std::string> by_cpu{"--painter", "cpu", "--builder", "cpu"};
    const Shot gpu = shot_of(still(), touch, "0.8", {"--painter", "raster"});
    const Shot cpu = shot_of(still(), touch, "0.8", by_cpu);
    const Shot bare = shot_of(still(), large, "0.3", by_cpu);
    EXPECT_GT(differences(bare.image, cpu.image, 300, 140, 420, 220), 400);
    EXPECT_LE(differences(gpu.image, cpu.image, 240, 60, 300, 400), 60);
    EXPECT_LE(differences(gpu.image, cpu.image, 300, 220, 620, 400), 60);
    EXPECT_NE(cpu.outcome.out.find("by the cpu painter\n"), std::string::npos) << cpu.outcome.out;
}

TEST(HeadlessWindow, OverlayColoursTheSurface) {
    const Shot colour = shot_of(still(), "", "0.5");
    const Shot depth = shot_of(still(), "0 overlay depth\n", "0.5");
    EXPECT_GT(differences(colour.image, depth.image, 120, 80, 200, 160), 3000);
}

TEST(HeadlessWindow, OverlayIsNotCarriedToTheNextClip) {
    const TemporaryFolder folder;
    const std::vector<std::string> settings{"--settings", (folder / "play.json").string()};
    const Shot depth = shot_of(still(), "0 overlay depth\n", "0.5", settings);
    const Shot next = shot_of(still(), "", "0.5", settings), plain = shot_of(still(), "", "0.5");
    EXPECT_GT(differences(depth.image, next.image, 120, 80, 200, 160), 3000);
    EXPECT_EQ(differences(plain.image, next.image, 120, 80, 200, 160), 0);
}

TEST(HeadlessWindow, TouchThatIsRecordedRepeatsToTheBitWithoutIt) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string();
    shot_of(globe(),
            "0 move 150 110\n0.1 press left\n0.3 move 170 115\n0.4 key space\n0.5 move 160 120\n0.6 seek "
            "0.2\n0.7 speed 2\n"
            "0.8 key space\n0.9 wheel 2\n1.0 key .\n1.1 key 3\n1.2 loop\n",
            "1.4", {"--record", record});
    const auto again = run_touchable({"touch", "--replay", record, "--json", "-"});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.err.find("as recorded, to the bit"), std::string::npos) << again.err;
    EXPECT_EQ(again.out.find("\"contact_ticks\": 0,"), std::string::npos) << "nothing was touched";
}

TEST(HeadlessWindow, FileThatCannotBeOpenedLeavesTheOldClip) {
    const Shot shot = shot_of(still(), "0.1 drop nowhere.mkv\n0.2 move 160 110\n", "0.7");
    const Shot without = shot_of(still(), "0.2 move 160 110\n", "0.7");
    EXPECT_GT(differences(shot.image, without.image, 60, 0, 260, 60), 100) << "no message";
    EXPECT_NE(shot.outcome.err.find("nowhere.mkv"), std::string::npos) << "nobody sees that message";
    EXPECT_EQ(differences(shot.image, without.image, 220, 100, 310, 160), 0);
}

TEST(HeadlessWindow, OtherClipTakesThePlaceOfTheOldOneAndIsNotWaitedForInTheEnd) {
    const Shot before = shot_of(globe(), "0 key space\n0 seek 0.5\n", "0.8");
    // Late, for a clip opens in the background, and a busy machine takes its time.
    const Shot other = shot_of(globe(), "0 drop " + still().string() + "\n", "3");
    const Shot same = shot_of(still(), "", "0.8");
    EXPECT_GT(differences(before.image, other.image, 100, 60, 220, 180), 100);
    EXPECT_LT(differences(same.image, other.image, 100, 60, 220, 180), 20);
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << "0.1 drop " << globe().string() << "\n0.1 key b\n0.1 quit\n";
    const auto closed = run_touchable({"play", still().string(), "--headless", "--size", "320x240",
                                       "--script", (folder / "script").string(), "--seconds", "20"});
    EXPECT_EQ(closed.code, 0) << closed.err;
    EXPECT_EQ(closed.err, "");
}

TEST(HeadlessWindow, SettingsChangeWhatIsFeltWhereTheClipStands) {
    const std::string touch = "0.1 move 160 110\n0.1 press left\n";
    const Shot plain = shot_of(still(), touch, "0.9");
    // A and B have a force each; A, of 0.2 N, is in effect in the end.
    const Shot other = shot_of(
        still(), touch + "0.2 max-force 0.2\n0.3 settings b\n0.4 max-force 10\n0.4 key b\n0.5 median 5\n",
        "0.9");
    EXPECT_GT(differences(plain.image, other.image, 12, 30, 40, 100), 100) << "the bar is as high as before";
    // The clip stands still where it stood: the surface beside finger and words is the same.
    EXPECT_LT(differences(plain.image, other.image, 100, 150, 220, 170), 20);
}

TEST(HeadlessWindow, KeepsSettingsWhereItIsToldTo) {
    const TemporaryFolder folder;
    const auto kept_after = [&folder](const std::string& script) {
        std::ofstream(folder / "script") << script;
        const auto played = run_touchable({"play", still().string(), "--headless", "--seconds", "0.1",
                                           "--size", "320x240", "--script", (folder / "script").string(),
                                           "--settings", (folder / "play.json").string()});
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
    const auto played = run_touchable({"play", still().string(), "--headless", "--seconds", "0.1", "--size",
                                       "320x240", "--script", (folder / "script").string(), "--settings",
                                       (folder / "play.json").string()});
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
    const Shot recorded = shot_of(globe(), "", "0.3", {"--record", record, "--settings", settings});
    EXPECT_NE(recorded.outcome.err.find("felt without relief: relief that is tried is not recorded"),
              std::string::npos)
        << recorded.outcome.err;
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording.ok()) << recording.error().message;
    EXPECT_EQ(recording->front().facts.at("guard").at("max_force"), 0.4);
    const std::string grey = (folder / "grey.mkv").string();
    ASSERT_EQ(run_touchable({"make", "bumps", grey, "--size", "64x48", "--frames", "1"}).code, 0);
    const Shot without_colour = shot_of(grey, "", "0.3", {"--settings", settings});
    EXPECT_NE(without_colour.outcome.err.find("felt without relief: "), std::string::npos)
        << without_colour.outcome.err;
    const std::string kept = file_contents(settings);
    for (const char* words : {"\"relief\": 100", "\"relief-height\": 1", "\"max-force\": 0.4"})
        EXPECT_NE(kept.find(words), std::string::npos) << words << " in " << kept;
}

TEST(HeadlessWindow, RecordingKeepsChangesOfSettings) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string();
    shot_of(globe(),
            "0 move 160 110\n0 press left\n0.2 key b\n0.5 max-force 0.4\n0.8 seek 0.1\n0.9 key b\n1.2 key "
            "space\n",
            "1.4", {"--record", record});
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording.ok()) << recording.error().message;
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
    ASSERT_TRUE(hand.ok()) << hand.error().message;
    EXPECT_EQ((*hand)->ticks(), ms) << "all parts one after the other";
}

/// How often each file of a folder was opened since.
class OpenedFiles {
public:
    explicit OpenedFiles(const std::filesystem::path& folder) : watch_(inotify_init1(IN_NONBLOCK)) {
        EXPECT_GE(inotify_add_watch(watch_, folder.c_str(), IN_OPEN), 0);
    }
    ~OpenedFiles() { close(watch_); }
    OpenedFiles(const OpenedFiles&) = delete;
    OpenedFiles& operator=(const OpenedFiles&) = delete;
    std::map<std::string, int> times() const {
        std::map<std::string, int> times;
        alignas(inotify_event) std::array<char, 65536> events{};
        for (ssize_t size; (size = read(watch_, events.data(), events.size())) > 0;)
            for (ssize_t at = 0; at < size;) {
                const auto* const event = reinterpret_cast<const inotify_event*>(events.data() + at);
                if (event->len > 0) ++times[event->name];
                at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
            }
        return times;
    }

private:
    const int watch_;
};

/// Neither to know which files may be written, nor for other settings; kept ones are refused here at first.
TEST(HeadlessWindow, OpensEachFrameOnceWhateverIsWrittenAndFelt) {
    const TemporaryFolder folder;
    const std::string pictures = (folder / "pictures").string();
    ASSERT_EQ(run_touchable({"convert", globe().string(), pictures + "/"}).code, 0);
    std::ofstream(folder / "play.json") << R"({"a": {"temporal": "on"}})";
    const OpenedFiles opened(pictures);
    shot_of(pictures, "0 speed 0.25\n0.3 median 5\n0.8 metric pixel\n1.3 filters auto\n", "2",
            {"--record", (folder / "hand.touch").string(), "--settings", (folder / "play.json").string()});
    const auto times = opened.times();
    EXPECT_TRUE(times.contains("scene.json") && times.contains("depth_000003.png"));
    for (const auto& [file, count] : times) EXPECT_EQ(count, 1) << file;
    const auto recording = read_recording(folder / "hand.touch");
    ASSERT_TRUE(recording.ok()) << recording.error().message;
    EXPECT_GT(recording->size(), 1U) << "nothing was changed";
}

TEST(HeadlessWindow, ADiskThatIsFullIsSaidAtOnceAndWhatIsThereIsKept) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string(), sound = (folder / "heard.wav").string();
    const Outcome played =
        run_on_full_disk({"play", globe().string(), "--headless", "--size", "320x240", "--seconds", "2",
                          "--painter", "cpu", "--builder", "cpu", "--record", record, "--sound", sound},
                         100);
    EXPECT_EQ(played.code, 3) << played.err;
    for (const std::string& file : {"--record " + record, "--sound " + sound}) {
        const std::size_t at_once = played.err.find("touchable: warning: " + file + ": cannot be written: ");
        const std::size_t in_the_end = played.err.find("touchable: --record " + record + ": cannot be");
        EXPECT_LT(at_once, in_the_end) << played.err;
        EXPECT_NE(in_the_end, std::string::npos) << played.err;
    }
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording.ok()) << recording.error().message;
    EXPECT_GT(recording->front().ticks.size(), 100U);
    const auto again = run_touchable({"touch", "--replay", record});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_NE(again.out.find("as recorded, to the bit"), std::string::npos) << again.out;
    const std::string wav = file_contents(sound);
    ASSERT_GT(wav.size(), 60'000U);
    std::uint32_t samples = 0;
    std::memcpy(&samples, wav.data() + 40, sizeof samples);
    EXPECT_EQ(samples, wav.size() - 44) << "what the header says is what is there";
}

TEST(HeadlessWindow, AFilmIsKeptUpToWhereItsDiskBecameFull) {
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << "0 overlay depth\n0.3 size 640x480\n0.6 overlay normals\n";
    const std::string film = (folder / "film.mp4").string(), record = (folder / "hand.touch").string();
    const Outcome played = run_on_full_disk(
        {"play", globe().string(), "--headless", "--size", "640x480", "--seconds", "1.5", "--painter", "cpu",
         "--builder", "cpu", "--script", (folder / "script").string(), "--video", film, "--record", record},
        250);
    EXPECT_EQ(played.code, 3) << played.err;
    const std::string full = film + ": the film cannot be written: the disk is full";
    const std::size_t at_once = played.err.find("touchable: warning: " + full + "\n");
    const std::size_t in_the_end = played.err.find(full + "; it is kept up to there\n");
    EXPECT_LT(at_once, in_the_end) << played.err;
    EXPECT_NE(in_the_end, std::string::npos) << played.err;
    EXPECT_GE(seen_in_film(film).size(), 2U) << "pictures that were complete";
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording.ok()) << recording.error().message;
    EXPECT_GT(recording->front().ticks.size(), 100U) << "the other output, up to where it is full";
}

TEST(HeadlessWindow, IsRefusedWhereItCouldNotEnd) {
    const auto endless = run_touchable({"play", globe().string(), "--headless"});
    EXPECT_EQ(endless.code, 2);
    EXPECT_TRUE(endless.one_line_of_error()) << endless.err;
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << "0.1 quit\n";
    const std::string film = (folder / "FILM.MP4").string();
    const auto ends = run_touchable({"play", globe().string(), "--headless", "--size", "320x240", "--script",
                                     (folder / "script").string(), "--video", film});
    EXPECT_EQ(ends.code, 0) << ends.err;
    EXPECT_FALSE(seen_in_film(film).empty());
    const auto none = run_touchable({"play", "nowhere.mkv", "--headless", "--seconds", "1"});
    EXPECT_EQ(none.code, 3);
    EXPECT_TRUE(none.one_line_of_error()) << none.err;
}

TEST(HeadlessWindow, InterruptedBeforeItsFirstPictureSaysThatNothingIsWritten) {
    const TemporaryFolder folder;
    const auto ended = run_interrupted_at_once({"play", globe().string(), "--headless", "--seconds", "9",
                                                "--video", (folder / "film.mkv").string()});
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_TRUE(ended.one_line_of_error()) << ended.err;
    EXPECT_EQ(ended.err.find("is written"), std::string::npos) << ended.err;
    EXPECT_EQ(ended.err.find("; written"), std::string::npos) << ended.err;
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(HeadlessWindow, NeverWritesOverWhatItShows) {
    const TemporaryFolder folder;
    std::filesystem::copy(globe(), folder / "globe.mkv");
    const std::string clip = (folder / "globe.mkv").string(), before = file_contents(clip);
    const std::string other_spelling = (folder / ".").string() + "/globe.mkv";
    const auto recorded = run_touchable(
        {"play", clip, "--headless", "--seconds", "0.2", "--record", other_spelling, "--overwrite"});
    EXPECT_EQ(recorded.code, 2) << recorded.err;
    EXPECT_TRUE(recorded.one_line_of_error());
    const auto kept =
        run_touchable({"play", clip, "--headless", "--seconds", "0.2", "--settings", other_spelling});
    EXPECT_EQ(kept.code, 2) << kept.err;
    std::ofstream(folder / "script") << "0 open " << clip << "\n0 screenshot " << (folder / "a.png").string()
                                     << "\n";
    std::filesystem::create_symlink(clip, folder / "a.png");
    const auto drawn = run_touchable({"play", still().string(), "--headless", "--seconds", "0.2", "--script",
                                      (folder / "script").string(), "--overwrite"});
    EXPECT_EQ(drawn.code, 2) << drawn.err;
    EXPECT_EQ(file_contents(clip), before);
}

TEST(HeadlessWindow, KioskInvitesAndBeginsAnewAndNothingEndsIt) {
    // The overlay and the view of the last visitor are gone; a finger shows how; Escape is nobody's.
    const std::string visit =
        "0 overlay depth\n0 turn 40\n0 move 160 110\n0.05 key escape\n0.05 drop nowhere\n";
    const Shot during = shot_of(still(), visit, "0.4", {"--kiosk", "--idle", "5", "9"});
    const Shot after = shot_of(still(), visit, "1.2", {"--kiosk", "--idle", "0.3", "0.3"});
    const Shot plain = shot_of(still(), "", "0.4", {"--kiosk"});
    const Shot invited = shot_of(still(), "", "1.4", {"--kiosk", "--idle", "0.1", "9"});
    EXPECT_EQ(invited.outcome.err, "");
    EXPECT_GT(differences(during.image, plain.image, 60, 60, 260, 180), 3000);
    // Beside the bar, the words, and the finger that invites.
    EXPECT_GT(differences(during.image, plain.image, 100, 40, 160, 120), 1000);
    EXPECT_LT(differences(after.image, plain.image, 100, 40, 160, 120), 100);
    EXPECT_GT(differences(invited.image, plain.image, 60, 180, 260, 230), 2000) << "no words";
    EXPECT_GT(differences(invited.image, plain.image, 60, 60, 260, 150), 60) << "no finger";
    const auto kept = run_touchable(
        {"play", still().string(), "--headless", "--seconds", "0.2", "--kiosk", "--settings", "play.json"});
    EXPECT_EQ(kept.code, 2);
    const auto backward = run_touchable(
        {"play", still().string(), "--headless", "--seconds", "0.2", "--kiosk", "--idle", "60", "20"});
    EXPECT_EQ(backward.code, 2);
    EXPECT_TRUE(backward.one_line_of_error()) << backward.err;
}

TEST(HeadlessWindow, SaysLargeThatForceIsOff) {
    const std::string press = "0 move 160 110\n0.05 press left\n";
    for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--kiosk"}}) {
        const Shot on = shot_of(still(), press, "0.6", more),
                   off = shot_of(still(), press + "0.1 key f\n", "0.6", more);
        EXPECT_GT(differences(on.image, off.image, 60, 140, 260, 235), 1500) << "no words";
    }
    // A visitor who finds it so need not know how; nor does the finger that invites.
    const std::vector<std::string> kiosk{"--kiosk"}, idle{"--kiosk", "--idle", "0.3", "9"};
    const Shot pressed = shot_of(still(), "0 key f\n0.3 move 160 110\n0.4 press left\n", "1.5", kiosk),
               never_off = shot_of(still(), "0.3 move 160 110\n0.4 press left\n", "1.5", kiosk);
    EXPECT_LT(differences(pressed.image, never_off.image, 60, 140, 260, 235), 300);
    const Shot plain = shot_of(still(), "", "0.3", {"--kiosk"}),
               invited = shot_of(still(), "0 key f\n", "1.8", idle);
    EXPECT_GT(differences(invited.image, plain.image, 60, 60, 260, 150), 60) << "no finger";
}

TEST(HeadlessWindow, FilmShowsWhatTheWindowDidAndSoundsAsIt) {
    const TemporaryFolder folder;
    const std::string film = (folder / "film.mkv").string();
    // The other size, and the panel in the right half from then on; a while after the press, for the finger
    // comes later where ticks are skipped, and at the other size the pointer is beside the globe.
    const Shot shot = shot_of(still(), "0 move 160 130\n0.2 press left\n1.3 size 640x480\n1.3 panel\n", "1.8",
                              {"--video", film});
    EXPECT_NE(shot.outcome.out.find("film "), std::string::npos) << shot.outcome.out;
    const auto seen = seen_in_film(film);
    ASSERT_GE(seen.size(), 30U);
    double lasted_s = 0;
    ASSERT_EQ(std::sscanf(shot.outcome.out.c_str(), "pictures %*d in %lf s", &lasted_s), 1)
        << shot.outcome.out;
    EXPECT_LE(seen.size(), 30 * lasted_s + 5) << "longer than the window was there";
    EXPECT_NEAR(seen.back().seconds, static_cast<double>(seen.size() - 1) / 30, 0.01);
    EXPECT_EQ(seen.front().width, 320);
    EXPECT_EQ(seen.back().width, 320);
    const auto light_in = [](const SeenPicture& picture, int x0, int x1) {
        double sum = 0;
        for (int y = 20; y < 200; ++y)
            for (int x = x0; x < x1; ++x) sum += picture.at(x, y) - 16;
        return sum / (180 * (x1 - x0));
    };
    EXPECT_GT(light_in(seen.front(), 100, 220), 30) << "black";
    EXPECT_GT(light_in(seen.back(), 100, 180), 20) << "black";
    EXPECT_GT(std::abs(light_in(seen.front(), 210, 310) - light_in(seen.back(), 210, 310)), 3) << "no panel";
    auto track = SoundTrack::open(film);
    ASSERT_TRUE(track.ok() && *track);
    // All of it: where the machine stood still, the finger pressed later.
    std::vector<StereoSample> heard(static_cast<std::size_t>(48'000 * (lasted_s + 1)));
    (*track)->read(heard);
    const auto is_silent = [](const StereoSample& sample) { return sample.left == 0 && sample.right == 0; };
    const auto first = std::find_if_not(heard.begin(), heard.end(), is_silent) - heard.begin();
    EXPECT_GE(first, 0.2 * 48'000) << "before the finger pressed";
    EXPECT_LT(first, std::ssize(heard)) << "no tap";
    const auto refused = run_touchable({"play", still().string(), "--headless", "--seconds", "0.2", "--video",
                                        (folder / "film.avi").string()});
    EXPECT_EQ(refused.code, 2);
    EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
}

TEST(HeadlessWindow, ClipAloneIsPlayed) {
    const auto played =
        run_touchable({globe().string(), "--headless", "--seconds", "0.3", "--size", "320x240"});
    EXPECT_EQ(played.code, 0) << played.err;
    EXPECT_NE(played.out.find("pictures"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
