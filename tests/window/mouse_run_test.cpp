// What whoever knows other players looks for in the window: keys, full screen, a playlist, volume, a bar that
// gives way, words that stay. Without a window, by the program as a person starts it.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "engine/picture/sound.hpp"
#include "player/audio/heard_sound.hpp"
#include "player/run/run_files.hpp"
#include "player/window/command_table.hpp"
#include "player/window/window_command.hpp"
#include "tests/player/program.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

/// Clips of one scene each, once for all tests of this program: a second of a globe, a still of it, and a
/// still of bumps, which fill the picture.
const fs::path& some_clips() {
    static const TemporaryFolder folder;
    static const fs::path made = [] {
        const auto make = [](const std::string& scene, const std::string& name, const std::string& frames) {
            const auto done = run_touchable(
                {"make", scene, (folder / name).string(), "--size", "160x120", "--frames", frames});
            EXPECT_EQ(done.code, 0) << done.err;
        };
        make("globe", "a-globe.mkv", "30");
        make("globe", "b-still.mkv", "1");
        make("bumps", "c-bumps.mkv", "1");
        return folder.path();
    }();
    return made;
}

/// The picture's middle, without words, bars and curves.
int in_the_middle(const Image& a, const Image& b) {
    return differences(a, b, {100, 100, 220, 170});
}

bool has(const std::vector<std::string>& files, const std::string& name) {
    return std::find(files.begin(), files.end(), name) != files.end();
}

/// The window is still there when its picture `there.png` is asked for.
constexpr const char* there = "0.6 screenshot there.png\n";

TEST(Habits, QClosesAndOtherKeysLeadTheFinger) {
    EXPECT_FALSE(has(shot_of(some_clips() / "b-still.mkv", std::string("0.3 key q\n") + there, "1").files,
                     "there.png"));
    EXPECT_TRUE(
        has(shot_of(some_clips() / "b-still.mkv", std::string("0.3 key x\n0.3 key e\n") + there, "1").files,
            "there.png"));
}

TEST(Habits, EscapeLeavesFullScreenBeforeItCloses) {
    const std::string escape = std::string("0.3 key escape\n") + there,
                      twice = std::string("0.3 key escape\n0.4 key escape\n") + there;
    const std::string still = (some_clips() / "b-still.mkv").string();
    EXPECT_TRUE(has(played_by({still, "--fullscreen"}, escape, "1").files, "there.png"));
    EXPECT_FALSE(has(played_by({still, "--fullscreen"}, twice, "1").files, "there.png"));
    EXPECT_FALSE(has(played_by({still}, escape, "1").files, "there.png"));
    EXPECT_TRUE(has(played_by({still}, "0.1 key f11\n" + escape, "1").files, "there.png"));
}

TEST(Habits, ADoubleClickFillsTheScreenAndSlowOnesDoNot) {
    const std::string escape = std::string("0.5 key escape\n") + there;
    const std::string twice =
        "0.1 move 160 110\n0.2 press left\n0.25 release left\n0.3 press left\n0.35 release "
        "left\n";
    const std::string slow =
        "0 move 160 110\n0 press left\n0.05 release left\n0.4 press left\n0.45 release left\n";
    EXPECT_TRUE(has(shot_of(some_clips() / "b-still.mkv", twice + escape, "1").files, "there.png"));
    EXPECT_FALSE(has(shot_of(some_clips() / "b-still.mkv", slow + escape, "1").files, "there.png"));
    const std::string bar =
        "0.1 move 160 224\n0.2 press left\n0.25 release left\n0.3 press left\n0.35 release left\n";
    EXPECT_FALSE(has(shot_of(some_clips() / "b-still.mkv", bar + escape, "1").files, "there.png"))
        << "that is the bar's";
}

/// Newtons on the first finger in the end.
double force_in_the_end(const std::string& clip, const std::string& script, const std::string& seconds) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string();
    played_by({(some_clips() / clip).string(), "--record", record}, script, seconds);
    const auto recording = read_recording(record);
    EXPECT_TRUE(recording) << recording.error().message;
    if (!recording || recording->back().ticks.empty()) return -1;
    return glm::length(recording->back().ticks.back().forces.at(0));
}

TEST(Habits, TheSecondClickOfADoubleClickPressesNoFinger) {
    const std::string first = "0.1 move 160 100\n0.2 press left\n0.25 release left\n";
    EXPECT_GT(force_in_the_end("b-still.mkv", first + "0.8 press left\n", "1.6"), 0.05);
    EXPECT_EQ(force_in_the_end("b-still.mkv", first + "0.4 press left\n", "1.6"), 0);
}

TEST(Habits, AFingerUnderTheBarIsFelt) {
    const std::string near = "0 nearer 1.6\n";  // the globe is under the bar too
    const std::string pressed = near + "0.1 move 160 100\n0.1 wheel 16\n";
    EXPECT_GT(force_in_the_end("b-still.mkv", pressed + "0.4 move 160 180\n0.5 move 160 200\n", "1.6"), 0.05)
        << "by the wheel";
    const std::string held = near + "0.1 move 160 100\n0.1 press left\n0.4 move 160 180\n0.5 move 160 200\n";
    EXPECT_GT(force_in_the_end("b-still.mkv", held, "1.6"), 0.05) << "by the button";
    EXPECT_EQ(force_in_the_end("b-still.mkv", near + "0.1 move 160 200\n0.3 press left\n", "1.6"), 0)
        << "a click there is the bar's";
}

TEST(Habits, AFingerThatTouchesNothingIsNotDrawnWhileThePointerIsOnTheBar) {
    const auto at = [](const std::string& script) {
        return shot_of(some_clips() / "b-still.mkv", "0 nearer 1.6\n" + script, "1").image;
    };
    // Just within the bar, whose upper side cuts the ring.
    const std::string onto_bar = "0.1 move 160 100\n0.5 move 160 183\n";
    const PicturePart above{130, 150, 190, 178};
    const Image bare = at("0.1 leave\n0.2 move 20 183\n");
    EXPECT_EQ(differences(bare, at(onto_bar), above), 0) << "it looks as if it were behind the bar";
    EXPECT_GT(differences(bare, at("0.1 move 160 100\n0.1 wheel 16\n0.5 move 160 183\n"), above), 20)
        << "it is pressed by the wheel, and felt";
    EXPECT_GT(differences(bare, at("0.1 move 160 100\n0.5 move 160 170\n"), above), 20)
        << "beside the bar it is drawn";
    EXPECT_GT(differences(bare, at(onto_bar + "0.6 key w\n0.7 key w\n0.75 key w\n"), above), 20)
        << "keys have moved it away from the bar";
}

TEST(Habits, TheBarGoesWhenNothingMovesAndComesBack) {
    const Image there_is = shot_of(some_clips() / "c-bumps.mkv", "0 move 20 20\n", "1").image;
    const Image rests = shot_of(some_clips() / "c-bumps.mkv", "0 move 20 20\n", "4.8").image;
    const Image back = shot_of(some_clips() / "c-bumps.mkv", "0 move 20 20\n4.5 move 21 20\n", "4.9").image;
    EXPECT_GT(differences(there_is, rests, {20, 185, 300, 225}), 2000) << "it is still there";
    EXPECT_LT(differences(there_is, back, {20, 185, 300, 225}), 200) << "it did not come back";
    // Where a finger presses under it, it goes at once.
    const Image under =
        shot_of(some_clips() / "c-bumps.mkv", "0 move 160 100\n0 press left\n0.4 move 160 205\n", "1").image;
    EXPECT_LT(differences(rests, under, {20, 185, 120, 225}), 200) << "it hides the finger";
}

TEST(Habits, TheSeekHandleEndsAtTheEndOfItsBar) {
    const Image image = shot_of(some_clips() / "a-globe.mkv", "0 seek 10\n", "0.8").image;
    ASSERT_EQ(image.width, 320);
    const int y = 240 - 12 - 24;
    const auto at = [&](int x, int c) {
        return int{image.samples[static_cast<std::size_t>((y * 320 + x) * 3 + c)]};
    };
    // The handle is the accent's blue; what is right of it, the bar's own ground and then its end.
    int right = -1;
    for (int x = 0; x < 320; ++x)
        if (at(x, 2) > 180 && at(x, 2) - at(x, 0) > 80) right = x;
    ASSERT_GT(right, 0) << "no handle";
    int beyond = 0;
    while (right + 3 + beyond < 320 && std::abs(at(right + 3 + beyond, 1) - at(right + 3, 1)) < 8 &&
           beyond < 40)
        ++beyond;
    const Image begin = shot_of(some_clips() / "a-globe.mkv", "0 key space\n0 seek 0\n", "0.8").image;
    ASSERT_EQ(begin.width, 320);
    int left = 320;
    for (int x = 319; x >= 0; --x) {
        const auto k = static_cast<std::size_t>((y * 320 + x) * 3);
        if (begin.samples[k + 2] > 180 && begin.samples[k + 2] - begin.samples[k] > 80) left = x;
    }
    ASSERT_LT(left, right);
    // At the beginning the place at which it ends is ground of the same bar.
    const auto ground = [&](int x) {
        return int{begin.samples[static_cast<std::size_t>((y * 320 + x) * 3 + 1)]};
    };
    int room = 0;
    while (right + room + 1 < 320 && std::abs(ground(right + room + 1) - ground(right - 2)) < 8) ++room;
    EXPECT_LE(room, 4) << "so many pixels of the bar are right of the handle";
}

TEST(Habits, VolumeIsByKeysAndKept) {
    const TemporaryFolder folder;
    const std::string settings = (folder / "play.json").string();
    const auto kept_after = [&](const std::string& script) {
        played_by({(some_clips() / "b-still.mkv").string(), "--settings", settings}, script, "0.4");
        return file_contents(settings);
    };
    const std::string kept = kept_after("0 key 9\n0 key 9\n0 key 9\n0 key 0\n0 key /\n0 key /\n0 key *\n");
    EXPECT_NE(kept.find("\"volume\": 85"), std::string::npos) << kept;
    EXPECT_NE(kept_after("0 louder 5\n").find("\"volume\": 90"), std::string::npos) << "from 85";
    EXPECT_NE(kept_after("0 reset\n").find("\"volume\": 100"), std::string::npos);
}

TEST(Habits, VolumeIsOfAllThatIsHeardAndHalfOfItAnEighth) {
    // The same contact at full and at half of the volume: to the bit but for the factor.
    const auto heard = [](float loudness) {
        ClipSound none;
        HeardSound sound;
        std::vector<StereoSample> all;
        for (int k = 0; k < 60; ++k) {
            HeardTick tick;
            tick.loudness = loudness;
            tick.fingers[0].touching = k >= 5;
            tick.fingers[0].stiffness = 1000;
            tick.fingers[0].newtons = 1;
            tick.fingers[0].met = k == 5 ? 0.2F : 0;
            ContactSound::Samples samples{};
            sound.render(tick, none, samples);
            all.insert(all.end(), samples.begin(), samples.end());
        }
        return all;
    };
    const auto full = heard(1), half = heard(0.125F);
    ASSERT_EQ(full.size(), half.size());
    float loudest_full = 0;
    for (std::size_t k = 0; k < full.size(); ++k) {
        EXPECT_EQ(half[k].left, 0.125F * full[k].left) << k;
        loudest_full = std::max(loudest_full, std::abs(full[k].left));
    }
    EXPECT_GT(loudest_full, 0.01F) << "nothing was heard";

    const auto loudest = [](const std::string& volume) {
        const TemporaryFolder folder;
        const std::string file = (folder / "heard.wav").string();
        played_by({(some_clips() / "b-still.mkv").string(), "--sound", file},
                  volume + "0.1 move 160 100\n0.2 press left\n", "1.2");
        const auto track = SoundTrack::open(file);
        EXPECT_TRUE(track && *track);
        std::vector<StereoSample> samples(48'000);
        if (track && *track) (*track)->read(samples);
        float most = 0;
        for (const StereoSample& sample : samples) most = std::max(most, std::abs(sample.left));
        return most;
    };
    EXPECT_GT(loudest(""), 0.001F);
    EXPECT_EQ(loudest("0 volume 0\n"), 0);
}

TEST(Habits, TheEndOfAClipIsTheBeginningOfTheNext) {
    const std::string globe = (some_clips() / "a-globe.mkv").string(),
                      bumps = (some_clips() / "c-bumps.mkv").string();
    const Image end = played_by({globe}, "", "2.5").image, next = played_by({bumps}, "", "0.8").image;
    ASSERT_GT(in_the_middle(end, next), 1000);
    EXPECT_LT(in_the_middle(played_by({globe, bumps}, "", "4").image, next), 50);
    EXPECT_GT(in_the_middle(played_by({globe, bumps}, "0.1 loop\n", "4").image, next), 1000)
        << "it is looped";
    EXPECT_GT(in_the_middle(played_by({globe, bumps}, "0.1 move 160 110\n0.2 press left\n", "4").image, next),
              1000)
        << "somebody touches it";
}

TEST(Habits, WhatIsOverInABlinkRestsBeforeTheNext) {
    const std::string still = (some_clips() / "b-still.mkv").string(),
                      bumps = (some_clips() / "c-bumps.mkv").string();
    const Image first = played_by({still}, "", "0.8").image, next = played_by({bumps}, "", "0.8").image;
    EXPECT_LT(in_the_middle(played_by({still, bumps}, "", "3").image, first), 50);
    EXPECT_LT(in_the_middle(played_by({still, bumps}, "", "6.5").image, next), 50);
}

/// A clip of a second, whose end comes while a finger presses.
TEST(Habits, ClipStaysBetweenTwoStrokes) {
    const std::string globe = (some_clips() / "a-globe.mkv").string(),
                      bumps = (some_clips() / "c-bumps.mkv").string();
    const Image next = played_by({bumps}, "", "0.8").image;
    const auto after = [&](const char* seconds) {
        return played_by({globe, bumps}, "0.1 move 160 110\n0.2 press left\n3 release left\n", seconds).image;
    };
    EXPECT_GT(in_the_middle(after("5"), next), 1000) << "it went as the finger was lifted";
    EXPECT_LT(in_the_middle(after("8"), next), 50) << "it is not touched any more";
}

TEST(Habits, AKioskGoesThroughItsClipsAlsoWhileNobodyIsThere) {
    const std::string still = (some_clips() / "b-still.mkv").string(),
                      bumps = (some_clips() / "c-bumps.mkv").string();
    const auto seen = [](std::vector<std::string> clips, const char* seconds, const char* invited_after) {
        clips.insert(clips.end(), {"--kiosk", "--idle", invited_after, "200"});
        return played_by(clips, "", seconds).image;
    };
    const char* const without_bar = "4.5";
    const Image first = seen({still}, without_bar, "100"), next = seen({bumps}, without_bar, "100");
    ASSERT_GT(in_the_middle(first, next), 1000);
    EXPECT_LT(in_the_middle(seen({still, bumps}, "6.5", "100"), next), 50);
    EXPECT_LT(in_the_middle(seen({still, bumps}, "12.5", "100"), first), 50) << "the first after the last";
    EXPECT_GT(in_the_middle(seen({still, bumps}, "6.5", "0.5"), first), 1000) << "a finger invites";
}

TEST(Habits, KeysGoToTheNextClipOfAFolderAndBack) {
    const std::string folder = some_clips().string();
    const Image globe = shot_of(some_clips() / "a-globe.mkv", "0 key space\n0 seek 0\n", "0.8").image,
                bumps = shot_of(some_clips() / "c-bumps.mkv", "", "0.8").image,
                still = shot_of(some_clips() / "b-still.mkv", "", "0.8").image;
    const std::string on = "0.1 key pagedown\n1.2 key >\n";
    EXPECT_LT(in_the_middle(played_by({folder}, on, "3").image, bumps), 50);
    EXPECT_LT(in_the_middle(played_by({folder}, on + "2.4 key <\n", "4").image, still), 50);
    EXPECT_LT(in_the_middle(played_by({folder}, on + "2.4 key pagedown\n", "3.5").image, bumps), 50)
        << "the last";
    const auto recorded =
        run_touchable({"play", folder, "--headless", "--seconds", "1", "--record", "a.touch"});
    EXPECT_EQ(recorded.code, 2);
    EXPECT_TRUE(recorded.one_line_of_error()) << recorded.err;
    const auto nowhere = run_touchable(
        {"play", (some_clips() / "b-still.mkv").string(), "nowhere.mkv", "--headless", "--seconds", "1"});
    EXPECT_EQ(nowhere.code, 3);
    EXPECT_NE(nowhere.err.find("nowhere.mkv"), std::string::npos) << nowhere.err;
}

TEST(Habits, AClipThatCannotBeOpenedIsGonePast) {
    const TemporaryFolder folder;
    std::ofstream(folder / "broken.mkv") << "no clip";
    std::ofstream(folder / "script") << "0.2 dismiss\n";
    const std::string broken = (folder / "broken.mkv").string(), picture = (folder / "end.png").string();
    const auto played = run_touchable({"play", broken, (some_clips() / "b-still.mkv").string(), "--headless",
                                       "--size", "320x240", "--screenshot", picture, "--at", "0.8",
                                       "--script", (folder / "script").string()});
    EXPECT_EQ(played.code, 3);
    EXPECT_NE(played.err.find("broken.mkv"), std::string::npos) << played.err;
    const auto image = read_image(picture);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_LT(in_the_middle(*image, shot_of(some_clips() / "b-still.mkv", "", "0.8").image), 50);
    EXPECT_EQ(run_touchable({"play", broken, broken, "--headless", "--seconds", "1"}).code, 3);
}

TEST(Habits, AFaultStaysUntilItWasReadAndEscapeReadsIt) {
    const Image without = shot_of(some_clips() / "c-bumps.mkv", "5.5 move 20 100\n", "6").image;
    const Image after_long =
        shot_of(some_clips() / "c-bumps.mkv", "0.1 drop nowhere.mkv\n5.5 move 20 100\n", "6").image;
    const Played read =
        shot_of(some_clips() / "c-bumps.mkv",
                "0.1 drop nowhere.mkv\n5.5 move 20 100\n5.5 key escape\n5.7 screenshot there.png\n", "6.1");
    EXPECT_GT(differences(after_long, without, {60, 0, 260, 60}), 300) << "it went by itself";
    EXPECT_TRUE(has(read.files, "there.png")) << "Escape closed the window";
    const Played clicked =
        shot_of(some_clips() / "c-bumps.mkv",
                "0.1 drop nowhere.mkv\n1 move 160 25\n1.2 press left\n1.4 release left\n1.6 key escape\n" +
                    std::string("1.8 screenshot there.png\n"),
                "2");
    EXPECT_FALSE(has(clicked.files, "there.png")) << "a click did not read it: Escape had to";
}

TEST(Habits, TheNameOfAScreenshotIsShown) {
    const Image without =
        shot_of(some_clips() / "c-bumps.mkv", "0 move 160 100\n0 press left\n0.1 release left\n", "1.2")
            .image;
    const Image with = shot_of(some_clips() / "c-bumps.mkv",
                               "0 move 160 100\n0 press left\n0.1 release left\n0.3 key f12\n", "1.2")
                           .image;
    EXPECT_GT(differences(with, without, {60, 8, 260, 60}), 300);
}

TEST(Habits, AWindowWithoutAClipSaysWhatToDropAndOpensIt) {
    const std::string still = (some_clips() / "b-still.mkv").string();
    const Image page = played_by(std::vector<std::string>{}, "", "0.6").image;
    ASSERT_EQ(page.width, 320);
    int bright = 0;
    for (const auto sample : page.samples) bright += sample > 150 ? 1 : 0;
    EXPECT_GT(bright, 1000) << "no words";
    const Played dropped = played_by(std::vector<std::string>{}, "0.3 drop " + still + "\n", "3");
    EXPECT_LT(in_the_middle(dropped.image, shot_of(some_clips() / "b-still.mkv", "", "0.8").image), 50);
    const Played wrong = played_by(std::vector<std::string>{}, "0.2 drop nowhere.mkv\n0.5 key o\n", "1.5");
    EXPECT_NE(wrong.outcome.err.find("nowhere.mkv"), std::string::npos) << wrong.outcome.err;
    EXPECT_GT(differences(wrong.image, page, {60, 0, 260, 60}), 300) << "the fault is not shown";
    EXPECT_LT(differences(wrong.image, page, {10, 120, 310, 230}), 500) << "it does not wait for another";
    EXPECT_FALSE(has(played_by(std::vector<std::string>{}, std::string("0.3 key q\n") + there, "1").files,
                     "there.png"));
    const auto recorded = run_touchable({"play", "--headless", "--seconds", "1", "--record", "a.touch"});
    EXPECT_EQ(recorded.code, 2);
    EXPECT_TRUE(recorded.one_line_of_error()) << recorded.err;
}

TEST(Habits, WordsAreAsLargeAsTheyAreAskedToBe) {
    const auto bar_height = [](const Image& image) {
        // The bar's dark ground over bright bumps, from below, at its left edge.
        int rows = 0;
        for (int y = 0; y < image.height; ++y) {
            const auto k = static_cast<std::size_t>((y * image.width + image.width / 2) * 3);
            if (y > image.height / 2 && image.samples[k] < 90 && image.samples[k + 1] < 90) ++rows;
        }
        return rows;
    };
    const std::vector<std::string> words{(some_clips() / "c-bumps.mkv").string()};
    const auto sized = [&](const std::string& scale) {
        auto all = words;
        all.insert(all.end(), {"--scale", scale});
        return played_by(all, "0 size 640x480\n0.3 move 20 20\n", "0.9").image;
    };
    const int one = bar_height(sized("1")), two = bar_height(sized("2"));
    EXPECT_GT(one, 20);
    EXPECT_GT(two, 1.6 * one);
    const auto refused = run_touchable({"play", words[0], "--headless", "--seconds", "1", "--scale", "0.2"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
}

// Somebody who never read anything, with a mouse and no keys: finds the help, reads what buttons do, presses,
// turns, measures, goes to the next clip and back; in windows small and large. Without a window, by the
// program as a person starts it.

struct WindowOfSize {
    int width, height;
};

/// Of words and bars: sqrt(2), to the next quarter, where the window has twice as much room.
double scale_of(const WindowOfSize& window) {
    return window.width > 2000 ? 1.5 : 1;
}

/// What somebody does with a mouse, as a script, and pictures of what is seen then.
class MouseScript {
public:
    explicit MouseScript(const WindowOfSize& window) : window_(window) {}
    /// Large pictures take long to be written: whoever sees so many takes more time.
    double times() const { return window_.width > 2000 ? 3 : 1; }

    /// A place of the picture, in thousandths of its sides.
    void move(double at_s, int x, int y) {
        move_to(at_s, window_.width * x / 1000, window_.height * y / 1000);
    }
    void press(double at_s) { add(at_s, "press left"); }
    void release(double at_s) { add(at_s, "release left"); }
    void leave(double at_s) { add(at_s, "leave"); }
    void picture(double at_s, const std::string& name) { add(at_s, "screenshot " + name); }
    /// On the bar, so many pixels from its right end; below 0: from its left one.
    void move_to_bar(double at_s, int from_end) {
        const int along = scaled(std::abs(from_end));
        move_to(at_s, from_end < 0 ? along : window_.width - along, window_.height - scaled(36));
    }
    void click_bar(double at_s, int from_end) {
        move_to_bar(at_s, from_end);
        press(at_s);
        release(at_s);
    }
    void drag(double at_s) {
        move(at_s, 400, 450);
        press(at_s + 0.05);
        move(at_s + 0.1, 520, 450);
        release(at_s + 0.15);
        leave(at_s + 0.2);
    }
    void turn(double at_s, int degrees) { add(at_s, "turn " + std::to_string(degrees)); }
    void quit(double at_s) { add(at_s, "quit"); }
    const std::string& words() const { return words_; }

private:
    void add(double at_s, const std::string& what) {
        words_ += std::to_string(at_s * times()) + " " + what + "\n";
    }
    int scaled(int pixels) const { return static_cast<int>(scale_of(window_) * pixels); }
    void move_to(double at_s, int x, int y) {
        add(at_s, "move " + std::to_string(x) + " " + std::to_string(y));
    }

    WindowOfSize window_;
    std::string words_;
};

/// Where buttons are.
constexpr int help = 39, settings = 84, measure = 170, turn = 288, previous = -39, next = -115;

class MouseAlone : public ::testing::TestWithParam<WindowOfSize> {
protected:
    void SetUp() override {
        for (const char* scene : {"globe", "bumps"})
            ASSERT_EQ(run_touchable({"make", scene, (folder_ / (scene + std::string(".mkv"))).string(),
                                     "--size", "160x120", "--frames", "1"})
                          .code,
                      0);
    }
    /// What the program says in the end.
    std::string play(const std::vector<std::string>& clips, const std::string& script) {
        const auto [width, height] = GetParam();
        const auto played =
            run_scripted(clips, script, folder_.path(), std::to_string(width) + "x" + std::to_string(height));
        EXPECT_EQ(played.code, 0) << played.err;
        return played.out;
    }
    /// Share of a part of two pictures, in thousandths of their sides, that differs.
    double differs(const std::string& name, const std::string& other, int x0, int y0, int x1, int y1) {
        const auto a = read_image(folder_ / name), b = read_image(folder_ / other);
        EXPECT_TRUE(a && b) << name << ", " << other;
        if (!a || !b) return -1;
        const PicturePart part{a->width * x0 / 1000, a->height * y0 / 1000, a->width * x1 / 1000,
                               a->height * y1 / 1000};
        const double all = (part.x1 - part.x0) * (part.y1 - part.y0);
        return differences(*a, *b, part) / all;
    }
    double middle_differs(const std::string& name, const std::string& other) {
        return differs(name, other, 300, 300, 700, 700);
    }
    /// Of a part whose corners are so far from the picture's right and lower side, in pixels of the words'
    /// scale.
    double lower_right_differs(const std::string& name, const std::string& other, int left, int top,
                               int right, int bottom) {
        const auto [width, height] = GetParam();
        const auto place = [&](int pixels, int side) {
            return 1000 - static_cast<int>(scale_of(GetParam()) * 1000 * pixels / side);
        };
        return differs(name, other, place(left, width), place(top, height), place(right, width),
                       place(bottom, height));
    }
    /// Just above the bar, on its right: where the words of a button are.
    double words_differ(const std::string& name, const std::string& other) {
        return lower_right_differs(name, other, 220, 92, 24, 68);
    }

    const TemporaryFolder folder_;
};

TEST_P(MouseAlone, FindsHelpTurnsAndMeasures) {
    MouseScript script(GetParam());
    script.picture(0.4, "untouched.png");
    script.click_bar(0.5, help);
    script.move(0.5, 500, 500);  // a quick hand is elsewhere in the next picture
    script.picture(0.9, "help.png");
    script.click_bar(1, help);
    script.leave(1.2);
    script.picture(1.3, "closed.png");
    script.move_to_bar(1.4, measure);
    script.picture(1.6, "on-measure.png");
    script.move_to_bar(1.65, settings);
    script.picture(1.85, "on-settings.png");
    script.drag(1.9);
    script.picture(2.3, "pressed.png");
    script.click_bar(2.4, turn);
    script.drag(2.6);
    script.picture(2.9, "turned.png");
    script.click_bar(3, turn);
    script.drag(3.2);
    script.picture(3.5, "pressed-again.png");
    script.click_bar(3.6, measure);
    script.move(3.8, 420, 400);
    script.press(3.85);
    script.release(3.9);
    script.move(4, 560, 520);
    script.press(4.05);
    script.release(4.1);
    script.click_bar(4.3, settings);
    script.picture(4.5, "settings.png");
    script.click_bar(4.6, settings);
    script.quit(5);
    const std::string said = play({"globe.mkv"}, script.words());

    EXPECT_GT(middle_differs("help.png", "untouched.png"), 0.2);
    EXPECT_LT(middle_differs("closed.png", "untouched.png"), 0.02);
    EXPECT_GT(words_differ("on-measure.png", "untouched.png"), 0.1);
    EXPECT_GT(words_differ("on-measure.png", "on-settings.png"), 0.02) << "each has words of its own";
    EXPECT_LT(middle_differs("pressed.png", "untouched.png"), 0.02) << "a drag presses";
    EXPECT_GT(middle_differs("turned.png", "untouched.png"), 0.05);
    EXPECT_LT(middle_differs("pressed-again.png", "turned.png"), 0.02);
    EXPECT_NE(said.find("measured"), std::string::npos) << said;
    const int width = GetParam().width;  // of which the panel has the same pixels on the right
    EXPECT_GT(differs("settings.png", "turned.png", 1000 - 240'000 / width, 100, 1000 - 20'000 / width, 700),
              0.2);
}

TEST_P(MouseAlone, GoesToTheNextClipAndBack) {
    MouseScript script(GetParam());
    script.picture(0.3, "first.png");
    script.click_bar(0.5, next);
    script.leave(0.6);
    script.picture(1.2, "next.png");
    script.click_bar(1.4, previous);
    script.leave(1.5);
    script.picture(2.2, "back.png");
    script.quit(2.3);
    play({"globe.mkv", "bumps.mkv"}, script.words());
    EXPECT_GT(middle_differs("next.png", "first.png"), 0.3);
    EXPECT_LT(middle_differs("back.png", "first.png"), 0.02);
}

/// Above what is said of the button.
TEST_P(MouseAlone, ReadsTheLegendWhileAButtonIsExplained) {
    MouseScript script(GetParam());
    script.leave(0.1);
    script.picture(0.5, "away.png");
    script.move_to_bar(0.6, settings);
    script.picture(1, "explained.png");
    script.quit(1.1);
    play({"globe.mkv"}, "0 overlay depth\n" + script.words());
    EXPECT_GT(lower_right_differs("explained.png", "away.png", 200, 140, 20, 104), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Sizes, MouseAlone,
                         ::testing::Values(WindowOfSize{640, 400}, WindowOfSize{1280, 720},
                                           WindowOfSize{2560, 1440}),
                         [](const auto& named) { return "Wide" + std::to_string(named.param.width); });

/// In a narrow window the bar keeps what is needed most, and the legend of an overlay has a place beside
/// what is said of the pixel under the pointer.
class MouseInANarrowWindow : public MouseAlone {};

TEST_P(MouseInANarrowWindow, FindsHelpAndReadsLegends) {
    MouseScript script(GetParam());
    script.move(0.1, 450, 400);
    const std::string legend = "0.1 overlay depth\n";
    script.picture(0.5, "legend.png");
    script.leave(0.6);
    script.picture(0.9, "away.png");
    script.click_bar(1, help);
    script.picture(1.4, "help.png");
    script.quit(1.5);
    play({"globe.mkv"}, legend + script.words());
    EXPECT_GT(differs("help.png", "away.png", 200, 100, 800, 600), 0.3);
    // The lower right, where the legend is when nothing is said of a pixel.
    const auto [width, height] = GetParam();
    const int top = 1000 - 110'000 / height, bottom = 1000 - 66'000 / height;
    EXPECT_GT(differs("legend.png", "away.png", 1000 - 200'000 / width, top, 1000 - 20'000 / width, bottom),
              0.2);
}

/// They take a fifth of its height, and are not said of what the bar covers, where buttons explain
/// themselves.
TEST_P(MouseInANarrowWindow, ThePixelsWordsLeaveThePictureFree) {
    MouseScript script(GetParam());
    script.move(0.1, 800, 300);
    script.picture(0.5, "said.png");
    script.leave(0.6);
    script.picture(0.9, "away.png");
    script.move_to_bar(1, help);
    script.picture(1.4, "on-help.png");
    script.quit(1.5);
    play({"globe.mkv"}, script.words());
    const auto [width, height] = GetParam();
    const int left = 20'000 / width, right = 110'000 / width, bottom = 1000 - 74'000 / height;
    EXPECT_LT(differs("said.png", "away.png", left, 470, right, 1000 - 148'000 / height), 0.001);
    EXPECT_GT(differs("said.png", "away.png", left, 1000 - 100'000 / height, right, bottom), 0.1);
    EXPECT_LT(differs("on-help.png", "away.png", left, 470, right, bottom), 0.001);
}

/// The house is among what is needed most: whoever has no keys comes back by it.
TEST_P(MouseInANarrowWindow, FindsTheWayBackToTheClipsOwnView) {
    MouseScript script(GetParam());
    script.leave(0.1);
    script.picture(0.5, "own.png");
    script.turn(0.6, 30);
    script.picture(0.9, "turned.png");
    script.click_bar(1, GetParam().width < 400 ? 77 : 158);
    script.leave(1.2);
    script.picture(1.5, "back.png");
    script.quit(1.6);
    play({"globe.mkv"}, script.words());
    EXPECT_GT(middle_differs("turned.png", "own.png"), 0.1);
    EXPECT_LT(middle_differs("back.png", "own.png"), 0.02);
}

INSTANTIATE_TEST_SUITE_P(Narrow, MouseInANarrowWindow,
                         ::testing::Values(WindowOfSize{320, 400}, WindowOfSize{480, 360}),
                         [](const auto& named) { return "Wide" + std::to_string(named.param.width); });

// Whatever a person, a cat or a child does to the window, it goes on, and no force is above the limit.

/// Seconds of it; longer by TOUCHABLE_RANDOM_SECONDS.
double seconds_of_input() {
    const char* const asked = std::getenv("TOUCHABLE_RANDOM_SECONDS");
    return asked ? std::atof(asked) : 2;
}

class RandomScript {
public:
    explicit RandomScript(unsigned seed) : random_(seed) {}

    std::string of(double seconds) {
        std::ostringstream out;
        out << "0 move 320 200\n0 press left\n";
        for (double at = 0.8; at < seconds; at += 0.001 * below(60)) out << at << ' ' << something() << '\n';
        return out.str();
    }

private:
    int below(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
    std::string number(int below_this) { return std::to_string(below(below_this)); }

    std::string something() {
        const char* const buttons[] = {"left", "right", "middle"};
        switch (below(17)) {
            case 0:
            case 1:
            case 2:
            case 3:
                return "move " + number(700) + ' ' + number(420);
            case 4:
                return std::string("press ") + buttons[below(3)];
            case 5:
                return std::string("release ") + buttons[below(3)];
            case 6:
                return "wheel " + std::to_string(below(7) - 3);
            case 7:
                return "seek 0." + number(100);
            case 8:
                return "size " + std::to_string(64 + below(700)) + 'x' + std::to_string(64 + below(400));
            case 9:
                return "drop nowhere-" + number(9);
            case 10:
            case 11:
                return "touch " + finger() + ' ' + number(700) + ' ' + number(420);
            case 12:
            case 13:
                return "touch-move " + finger() + ' ' + number(700) + ' ' + number(420);
            case 14:
                return below(8) == 0 ? "leave" : "touch-end " + finger();
            default:
                return key();
        }
    }

    std::string finger() { return std::to_string(1 + below(7)); }

    /// Any but those that end it, leave files or fill the screen.
    std::string key() {
        const auto keys = key_bindings();
        for (;;) {
            const KeyBinding& one = keys[static_cast<std::size_t>(below(static_cast<int>(keys.size())))];
            if (!one.shift && !one.control && one.verb != WindowVerb::quit && one.verb != WindowVerb::leave &&
                one.verb != WindowVerb::screenshot && one.verb != WindowVerb::fullscreen)
                return std::string("key ") + one.key;
        }
    }

    std::minstd_rand random_;
};

TEST(RandomInput, EndsWellAndNoForceIsAboveTheLimit) {
    const TemporaryFolder folder;
    const std::string clip = (folder / "globe.mkv").string(), record = (folder / "hand.touch").string();
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "160x120", "--frames", "30"}).code, 0);
    const double seconds = seconds_of_input();
    const auto played = run_scripted({clip, "--seconds", std::to_string(seconds + 0.2), "--record", record},
                                     RandomScript(20).of(seconds), folder.path(), "640x400");
    ASSERT_EQ(played.code, 0) << played.err;
    const auto again = run_touchable({"touch", "--replay", record, "--json", "-"});
    ASSERT_EQ(again.code, 0) << again.err;
    const auto report = nlohmann::json::parse(again.out);
    EXPECT_GT(report.at("force_n").at("max").get<double>(), 0) << "nothing was touched";
    EXPECT_LE(report.at("force_n").at("max").get<double>(), 10) << "the usual --max-force";
}

}  // namespace
}  // namespace touchable::test
