// SPDX-License-Identifier: Apache-2.0
// What users of other players expect of the window: keys, full screen, a playlist, volume, a bar that
// gives way, words that stay. Without a window, by the program as a person starts it.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
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
#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

/// Clips of one scene each, once for all tests of this program: a second of a globe, a still of it, and a
/// still of bumps, which fill the picture.
const fs::path& some_clips() {
    static const TemporaryFolder folder;
    if (folder.file_count() == 0) {
        make_clip(folder / "a-globe.mkv", "globe", 30, "160x120");
        make_clip(folder / "b-still.mkv", "globe", 1, "160x120");
        make_clip(folder / "c-bumps.mkv", "bumps", 1, "160x120");
    }
    return folder.path();
}
std::string clip(const std::string& name) {
    return (some_clips() / (name + ".mkv")).string();
}
const std::string globe = "a-globe", still = "b-still", bumps = "c-bumps";
Image shown(const std::string& name, const std::string& script, const std::string& seconds) {
    return shot_of(clip(name), script, seconds).image;
}
/// The same with the bumps as the next clip.
Image in_turn(const std::string& name, const std::string& script, const std::string& seconds) {
    return played_by({clip(name), clip(bumps)}, script, seconds).image;
}

/// The picture's middle, without words, bars and curves.
int in_the_middle(const Image& a, const Image& b) {
    return differences(a, b, {100, 100, 220, 170});
}

/// Whether the window of these words is still there when a picture is asked for after so many seconds.
bool stays(const std::vector<std::string>& words, const std::string& script, const char* asked_s = "0.6",
           const char* end_s = "1") {
    const auto files = played_by(words, script + asked_s + " screenshot there.png\n", end_s).files;
    return std::ranges::count(files, "there.png") > 0;
}

TEST(PlayerControls, QCloses) {
    EXPECT_FALSE(stays({clip(still)}, "0.3 key q\n"));
    EXPECT_TRUE(stays({clip(still)}, "0.3 key x\n0.3 key e\n")) << "other keys lead the finger";
}

TEST(PlayerControls, EscapeLeavesFullScreenFirst) {
    const std::string escape = "0.3 key escape\n";
    EXPECT_TRUE(stays({clip(still), "--fs"}, escape));
    EXPECT_FALSE(stays({clip(still), "--fullscreen"}, escape + "0.4 key escape\n"));
    EXPECT_FALSE(stays({clip(still)}, escape));
    EXPECT_TRUE(stays({clip(still)}, "0.1 key f11\n" + escape));
}

TEST(PlayerControls, DoubleClickFillsScreen) {
    const auto fills = [](const std::string& place, const std::string& second, const std::string& released) {
        return stays({clip(still)},
                     "0 move " + place + "\n0.2 press left\n0.25 release left\n" + second + " press left\n" +
                         released + " release left\n0.65 key escape\n",
                     "0.75");
    };
    EXPECT_TRUE(fills("160 110", "0.3", "0.35"));
    EXPECT_FALSE(fills("160 110", "0.6", "0.65")) << "too slow";
    EXPECT_FALSE(fills("160 224", "0.3", "0.35")) << "that is the bar's";
}

/// Newtons on the first finger in the end.
double force_in_the_end(const std::string& name, const std::string& script, const std::string& seconds) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string();
    played_by({clip(name), "--record", record}, script, seconds);
    const auto recording = read_recording(record);
    EXPECT_TRUE(recording) << recording.error().message;
    if (!recording || recording->back().ticks.empty()) return -1;
    return glm::length(recording->back().ticks.back().forces.at(0));
}

/// The place that is pressed twice becomes the view's middle.
TEST(PlayerControls, MiddleDoubleClickCentres) {
    const auto pressed_at = [](const std::string& first, const std::string& second) {
        const std::string press = " press middle\n", release = " release middle\n";
        return shown(still,
                     "0.1 move 130 120\n0.2" + press + "0.25" + release + first + press + second + release,
                     "1.5");
    };
    const Image twice = pressed_at("0.4", "0.45"), slowly = pressed_at("0.6", "0.65");
    EXPECT_LT(in_the_middle(slowly, shown(still, "0.1 move 130 120\n", "1.5")), 50);
    EXPECT_GT(in_the_middle(slowly, twice), 1000);
}

TEST(PlayerControls, DoubleClickPressesOnce) {
    const std::string first = "0.1 move 160 100\n0.2 press left\n0.25 release left\n";
    EXPECT_GT(force_in_the_end(still, first + "0.8 press left\n", "1.6"), 0.05);
    EXPECT_EQ(force_in_the_end(still, first + "0.4 press left\n", "1.6"), 0);
}

TEST(PlayerControls, FingerUnderBarIsFelt) {
    const std::string near = "0 nearer 1.6\n";  // the globe is under the bar too
    const std::string pressed = near + "0.1 move 160 100\n0.1 wheel 16\n";
    EXPECT_GT(force_in_the_end(still, pressed + "0.4 move 160 180\n0.5 move 160 200\n", "1.6"), 0.05)
        << "by the wheel";
    const std::string held = near + "0.1 move 160 100\n0.1 press left\n0.4 move 160 180\n0.5 move 160 200\n";
    EXPECT_GT(force_in_the_end(still, held, "1.6"), 0.05) << "by the button";
    EXPECT_EQ(force_in_the_end(still, near + "0.1 move 160 200\n0.3 press left\n", "1.6"), 0)
        << "a click there is the bar's";
}

TEST(PlayerControls, BarHidesIdleFinger) {
    const auto at = [](const std::string& script) { return shown(still, "0 nearer 1.6\n" + script, "1"); };
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

TEST(PlayerControls, BarHidesWhenIdle) {
    const Image there_is = shown(bumps, "0 move 20 20\n", "1");
    const Image rests = shown(bumps, "0 move 20 20\n", "4.8");
    const Image back = shown(bumps, "0 move 20 20\n4.5 move 21 20\n", "4.9");
    EXPECT_GT(differences(there_is, rests, {20, 185, 300, 225}), 2000) << "it is still there";
    EXPECT_LT(differences(there_is, back, {20, 185, 300, 225}), 200) << "it did not come back";
    // Where a finger presses under it, it goes at once.
    const Image under = shown(bumps, "0 move 160 100\n0 press left\n0.4 move 160 205\n", "1");
    EXPECT_LT(differences(rests, under, {20, 185, 120, 225}), 200) << "it hides the finger";
}

TEST(PlayerControls, SeekHandleReachesBarEnd) {
    const Image image = shown(globe, "0 seek 10\n", "0.8");
    ASSERT_EQ(image.width, 320);
    const int y = 240 - 12 - 24;
    // The handle is the accent's blue; what is right of it, the bar's own ground and then its end.
    const auto is_handle = [&](const Image& seen, int x) {
        const auto colour = colour_at(seen, x, y);
        return colour[2] > 180 && colour[2] - colour[0] > 80;
    };
    int right = 319;
    while (right > 0 && !is_handle(image, right)) --right;
    ASSERT_GT(right, 0) << "no handle";
    const Image begin = shown(globe, "0 key space\n0 seek 0\n", "0.8");
    ASSERT_EQ(begin.width, 320);
    int left = 0;
    while (left < 320 && !is_handle(begin, left)) ++left;
    ASSERT_LT(left, right);
    // At the beginning the place at which it ends is ground of the same bar.
    const auto ground = [&](int x) { return colour_at(begin, x, y)[1]; };
    int room = 0;
    while (right + room + 1 < 320 && std::abs(ground(right + room + 1) - ground(right - 2)) < 8) ++room;
    EXPECT_LE(room, 4) << "so many pixels of the bar are right of the handle";
}

TEST(PlayerControls, KeysChangeVolumePersistently) {
    const TemporaryFolder folder;
    const std::string settings = (folder / "play.json").string();
    const auto kept_after = [&](const std::string& script) {
        played_by({clip(still), "--settings", settings}, script, "0.4");
        return file_contents(settings);
    };
    const std::string kept = kept_after("0 key 9\n0 key 9\n0 key 9\n0 key 0\n0 key /\n0 key /\n0 key *\n");
    EXPECT_TRUE(contains(kept, "\"volume\": 85"));
    EXPECT_TRUE(contains(kept_after("0 louder 5\n"), "\"volume\": 90")) << "from 85";
    EXPECT_TRUE(contains(kept_after("0 reset\n"), "\"volume\": 100"));
}

TEST(PlayerControls, HalfVolumeIsAnEighth) {
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
        played_by({clip(still), "--sound", file}, volume + "0.1 move 160 100\n0.2 press left\n", "1.2");
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

TEST(PlayerControls, ClipEndStartsNext) {
    const Image end = shown(globe, "", "2.5"), next = shown(bumps, "", "0.8");
    ASSERT_GT(in_the_middle(end, next), 1000);
    EXPECT_LT(in_the_middle(in_turn(globe, "", "4"), next), 50);
    EXPECT_GT(in_the_middle(in_turn(globe, "0.1 loop\n", "4"), next), 1000) << "it is looped";
    EXPECT_GT(in_the_middle(in_turn(globe, "0.1 move 160 110\n0.2 press left\n", "4"), next), 1000)
        << "it is touched";
}

TEST(PlayerControls, ShortClipPausesBeforeNext) {
    const Image first = shown(still, "", "0.8"), next = shown(bumps, "", "0.8");
    EXPECT_LT(in_the_middle(in_turn(still, "", "3"), first), 50);
    EXPECT_LT(in_the_middle(in_turn(still, "", "6.5"), next), 50);
}

/// A clip of a second, whose end comes while a finger presses.
TEST(PlayerControls, ClipStaysBetweenStrokes) {
    const Image next = shown(bumps, "", "0.8");
    const auto after = [&](const char* seconds) {
        return in_turn(globe, "0.1 move 160 110\n0.2 press left\n3 release left\n", seconds);
    };
    EXPECT_GT(in_the_middle(after("5"), next), 1000) << "it went as the finger was lifted";
    EXPECT_LT(in_the_middle(after("8"), next), 50) << "it is not touched any more";
}

TEST(PlayerControls, KioskCyclesUnattended) {
    const auto seen = [](std::vector<std::string> clips, const char* seconds, const char* invited_after) {
        for (std::string& name : clips) name = clip(name);
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

TEST(PlayerControls, KeysStepThroughFolder) {
    const std::string folder = some_clips().string();
    const Image last = shown(bumps, "", "0.8"), middle = shown(still, "", "0.8");
    const std::string on = "0.1 key pagedown\n1.2 key >\n";
    EXPECT_LT(in_the_middle(played_by({folder}, on, "3").image, last), 50);
    EXPECT_LT(in_the_middle(played_by({folder}, on + "2.4 key <\n", "4").image, middle), 50);
    EXPECT_LT(in_the_middle(played_by({folder}, on + "2.4 key pagedown\n", "3.5").image, last), 50);
    expect_refused({"play", folder, "--headless", "--seconds", "1", "--record", "a.touch"}, 2);
}

TEST(PlayerControls, UndoesViewByGesture) {
    const TemporaryFolder folder;
    // A film's time is virtual: changes go on as one gesture for 0.6 s.
    const auto played = run_scripted({clip(still), "--video", "film.mkv", "--fps", "20"},
                                     "0.1 turn 10\n0.3 turn 15\n0.4 turn -5\n0.8 screenshot turned.png\n"
                                     "1.2 nearer 1.6\n1.9 home\n2.1 screenshot home.png\n"
                                     "2.2 key u\n2.4 screenshot near.png\n"
                                     "2.5 key u\n2.7 screenshot back.png\n"
                                     "2.8 undo-view\n3 screenshot own.png\n3.1 undo-view\n3.2 quit\n",
                                     folder.path());
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_TRUE(contains(played.err, "the view has not been turned")) << "there were three gestures";
    std::map<std::string, Image> seen;
    for (const std::string name : {"turned", "home", "near", "back", "own"}) {
        auto image = read_image(folder / (name + ".png"));
        ASSERT_TRUE(image) << name;
        seen[name] = std::move(*image);
    }
    EXPECT_GT(in_the_middle(seen["turned"], seen["home"]), 1000);
    EXPECT_GT(in_the_middle(seen["near"], seen["turned"]), 1000);
    EXPECT_LT(in_the_middle(seen["back"], seen["turned"]), 50);
    EXPECT_LT(in_the_middle(seen["own"], seen["home"]), 50);
}

TEST(PlayerControls, SkipsUnopenableClip) {
    const TemporaryFolder folder;
    std::ofstream(folder / "broken.mkv") << "no clip";
    std::ofstream(folder / "script") << "0.2 dismiss\n";
    const std::string broken = (folder / "broken.mkv").string(), picture = (folder / "end.png").string();
    const auto played =
        run_touchable({"play", broken, clip(still), "--headless", "--size", "320x240", "--screenshot",
                       picture, "--at", "0.8", "--script", (folder / "script").string()});
    EXPECT_EQ(played.code, 3);
    EXPECT_TRUE(contains(played.err, "broken.mkv"));
    const auto image = read_image(picture);
    ASSERT_TRUE(image) << image.error().message;
    EXPECT_LT(in_the_middle(*image, shown(still, "", "0.8")), 50);
    EXPECT_EQ(run_touchable({"play", broken, broken, "--headless", "--seconds", "1"}).code, 3);
}

TEST(PlayerControls, FaultStaysUntilEscape) {
    const std::string fault = "0.1 drop nowhere.mkv\n", later = "5.5 move 20 100\n";
    const Image without = shown(bumps, later, "6"), with = shown(bumps, fault + later, "6");
    EXPECT_GT(differences(with, without, {60, 0, 260, 60}), 300) << "it went by itself";
    EXPECT_TRUE(stays({clip(bumps)}, fault + later + "5.5 key escape\n", "5.7", "6.1"))
        << "Escape closed the window";
    const std::string click = "1 move 160 25\n1.2 press left\n1.4 release left\n";
    EXPECT_FALSE(stays({clip(bumps)}, fault + click + "1.6 key escape\n", "1.8", "2"))
        << "a click did not read it: Escape had to";
}

TEST(PlayerControls, ShowsScreenshotName) {
    const std::string press = "0 move 160 100\n0 press left\n0.1 release left\n";
    const Image without = shown(bumps, press, "1.2"), with = shown(bumps, press + "0.3 key f12\n", "1.2");
    EXPECT_GT(differences(with, without, {60, 8, 260, 60}), 300);
}

TEST(PlayerControls, EmptyWindowOpensDroppedClip) {
    const Image page = played_by({}, "", "0.6").image;
    ASSERT_EQ(page.width, 320);
    int bright = 0;
    for (const auto sample : page.samples) bright += sample > 150 ? 1 : 0;
    EXPECT_GT(bright, 1000) << "no words";
    const Played dropped = played_by({}, "0.3 drop " + clip(still) + "\n", "3");
    EXPECT_LT(in_the_middle(dropped.image, shown(still, "", "0.8")), 50);
    const Played wrong = played_by({}, "0.2 drop nowhere.mkv\n0.5 key o\n", "1.5");
    EXPECT_TRUE(contains(wrong.outcome.err, "nowhere.mkv"));
    EXPECT_GT(differences(wrong.image, page, {60, 0, 260, 60}), 300) << "the fault is not shown";
    EXPECT_LT(differences(wrong.image, page, {10, 126, 310, 230}), 500) << "it does not wait for another";
    EXPECT_FALSE(stays({}, "0.3 key q\n"));
    expect_refused({"play", "--headless", "--seconds", "1", "--record", "a.touch"}, 2);
}

TEST(PlayerControls, ListOpensChosenFile) {
    const TemporaryFolder folder;
    const std::string settings = (folder / "play.json").string();
    const std::vector<std::string> words{"--settings", settings};
    const Image wanted = shown(still, "", "0.8"), page = played_by(words, "", "0.6").image;
    const std::string list = "0.1 choose " + some_clips().string() + "\n";
    // ../, a-globe, b-still, c-bumps; over a clip below that one, the last opened
    const std::string third = "1.2 key down\n1.4 key down\n1.6 key down\n1.8 key enter\n";
    EXPECT_LT(in_the_middle(played_by(words, list + third, "4").image, wanted), 50);
    EXPECT_TRUE(contains(file_contents(settings), "/b-still.mkv"));
    EXPECT_LT(in_the_middle(played_by({clip(bumps)}, list + "1 key down\n" + third, "4").image, wanted), 50);
    EXPECT_TRUE(stays({clip(bumps)}, list + "0.5 key escape\n", "0.7", "1")) << "Escape closed the window";
    // The page of the next window has it, below what may be dropped.
    EXPECT_GT(differences(played_by(words, "", "0.6").image, page, {10, 120, 310, 230}), 300);
    EXPECT_LT(in_the_middle(played_by(words, "0.6 key down\n0.8 key enter\n", "3").image, wanted), 50);
}

class ClipboardScreen final : public WrappedScreen {
public:
    ClipboardScreen(const ScreenOptions& options, std::string& copied)
        : WrappedScreen(options), copied_(copied) {}
    void set_clipboard(const std::string& text) override { copied_ = text; }

private:
    std::string& copied_;
};

/// What a window of a globe's still has copied by this script.
std::string copied_by(const std::string& script) {
    std::string copied;
    const TemporaryFolder folder;
    PlayOptions options = headless_by_cpu(clip(still));
    options.video = folder / "film.mkv";  // so that its time is virtual
    options.film = {.rate = 20, .samples = 1, .has_words = true};
    options.make_screen = [&copied](const ScreenOptions& wanted) {
        return std::make_unique<ClipboardScreen>(wanted, copied);
    };
    options.script = inputs_of(script + "2 quit\n");
    const auto played = play_in_window(std::move(options));
    EXPECT_TRUE(played) << played.error().message;
    return copied;
}

TEST(PlayerControls, CopiesValuesAtPointer) {
    EXPECT_EQ(copied_by("0.1 copy\n"), "") << "nothing was pointed at";
    const std::string copied = copied_by("0.1 move 160 110\n0.6 copy\n");
    EXPECT_EQ(copied.find("pixel 80, 5"), 0U) << copied;
    for (const char* part : {", code ", ", z ", " m, ", ", stiffness ", ", friction ", ", sliding "})
        EXPECT_TRUE(contains(copied, part));
    EXPECT_EQ(copied.find('\n'), std::string::npos) << "it is one line";
}

TEST(PlayerControls, RightClickOpensMenu) {
    // Left of its rows, so that keys begin at the first.
    const std::string click = "0.1 move 20 60\n0.5 press right\n0.6 release right\n";
    const std::string copied = copied_by("0.1 move 20 60\n0.6 copy\n");
    ASSERT_NE(copied, "");
    EXPECT_EQ(copied_by(click + "0.9 move 200 30\n1 press left\n1.1 release left\n"), copied);
    EXPECT_EQ(copied_by(click + "0.9 key down\n1.1 key enter\n"), copied);
    EXPECT_EQ(copied_by("0 key h\n" + click + "0.9 key down\n1.1 key enter\n"), copied) << "all is hidden";
    EXPECT_EQ(copied_by(click + "0.9 key escape\n1 key down\n1.2 key enter\n"), "") << "it is closed";
    EXPECT_EQ(copied_by("0.1 move 20 60\n0.5 press right\n0.55 move 20 90\n0.6 release right\n"
                        "0.9 key down\n1.1 key enter\n"),
              "")
        << "a drag presses deeper";
    const auto measured = played_by({clip(still)},
                                    "0.1 move 160 110\n0.5 press right\n0.6 release right\n"
                                    "0.9 move 200 51\n1 press left\n1.1 release left\n"
                                    "1.4 move 130 100\n1.6 press left\n1.7 release left\n",
                                    "2.2");
    EXPECT_TRUE(contains(measured.outcome.out, "measured"));
}

TEST(PlayerControls, TabLeadsKeysIntoPanel) {
    const TemporaryFolder folder;
    const std::string settings = (folder / "play.json").string();
    // reset, fingers 1, 2, 3
    const std::string third = "0.5 key down\n0.7 key down\n0.9 key right\n1.1 key right\n1.3 key enter\n";
    const auto fingers_after = [&](const std::string& script) {
        std::filesystem::remove(settings);
        played_by({clip(still), "--settings", settings}, script + "1.5 key 9\n", "1.8");
        return nlohmann::json::parse(file_contents(settings)).at("fingers").get<int>();
    };
    EXPECT_EQ(fingers_after("0.1 key tab\n" + third), 3);
    EXPECT_EQ(fingers_after("0.1 key tab\n0.3 key escape\n" + third), 1) << "Escape gives them back";
    EXPECT_EQ(fingers_after("0.1 panel\n" + third), 1) << "a click on the button leaves them";
}

TEST(PlayerControls, ScaleEnlargesText) {
    const auto height = [](const char* scale) {
        const std::string large = "0 size 640x480\n0.3 move 20 20\n";
        return bar_height(played_by({clip(bumps), "--scale", scale}, large, "0.9").image);
    };
    const int one = height("1");
    EXPECT_GT(one, 20);
    EXPECT_GT(height("2"), 1.6 * one);
    expect_refused({"play", clip(bumps), "--headless", "--seconds", "1", "--scale", "0.2"}, 2);
}

// A person who never read anything, with a mouse and no keys: finds the help, reads what buttons do, presses,
// turns, measures, goes to the next clip and back; in windows small and large. Without a window, by the
// program as a person starts it.

struct WindowOfSize {
    int width, height;
};

/// The scale of text and bars: sqrt(2), to the next quarter, where the window has twice as much room.
double scale_of(const WindowOfSize& window) {
    return window.width > 2000 ? 1.5 : 1;
}

/// A person's actions with a mouse as a script, and pictures of the window.
class MouseScript {
public:
    explicit MouseScript(const WindowOfSize& window) : window_(window) {}
    /// Large pictures take long to be written: a script with so many takes more time.
    double times() const { return window_.width > 2000 ? 3 : 1; }

    /// A place of the picture, in thousandths of its sides.
    void move(double at_s, int x, int y) {
        move_to(at_s, window_.width * x / 1000, window_.height * y / 1000);
    }
    void press(double at_s) { add(at_s, "press left"); }
    void release(double at_s) { add(at_s, "release left"); }
    void click(double at_s, int x, int y) {
        move(at_s, x, y);
        press(at_s + 0.05);
        release(at_s + 0.1);
    }
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
    void key(double at_s, const std::string& name) { add(at_s, "key " + name); }
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

class MouseOnly : public ::testing::TestWithParam<WindowOfSize> {
protected:
    void SetUp() override {
        for (const std::string scene : {"globe", "bumps"})
            make_clip(folder_ / (scene + ".mkv"), scene, 1, "160x120");
    }
    /// The program's output.
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

TEST_P(MouseOnly, FindsHelpTurnsAndMeasures) {
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
    script.click(3.8, 420, 400);
    script.click(4, 560, 520);
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
    EXPECT_TRUE(contains(said, "measured"));
    const int width = GetParam().width;  // of which the panel has the same pixels on the right
    EXPECT_GT(differs("settings.png", "turned.png", 1000 - 240'000 / width, 100, 1000 - 20'000 / width, 700),
              0.2);
}

TEST_P(MouseOnly, StepsThroughClips) {
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
TEST_P(MouseOnly, SeesLegendAboveTooltip) {
    MouseScript script(GetParam());
    script.leave(0.1);
    script.picture(0.5, "away.png");
    script.move_to_bar(0.6, settings);
    script.picture(1, "explained.png");
    script.quit(1.1);
    play({"globe.mkv"}, "0 overlay depth\n" + script.words());
    EXPECT_GT(lower_right_differs("explained.png", "away.png", 200, 140, 20, 104), 0.2);
}

INSTANTIATE_TEST_SUITE_P(Sizes, MouseOnly,
                         ::testing::Values(WindowOfSize{640, 400}, WindowOfSize{1280, 720},
                                           WindowOfSize{2560, 1440}),
                         [](const auto& named) { return "Wide" + std::to_string(named.param.width); });

/// In a narrow window the bar keeps what is needed most, and the legend of an overlay is in the lower right,
/// beside what is said of the pixel under the pointer.
class NarrowWindowMouse : public MouseOnly {};

TEST_P(NarrowWindowMouse, FindsHelpAndReadsLegends) {
    MouseScript script(GetParam());
    script.move(0.1, 450, 400);
    const std::string legend = "0.1 overlay depth\n";
    script.picture(0.5, "legend.png");
    script.leave(0.6);
    script.picture(0.9, "away.png");
    script.click_bar(1, help);
    script.picture(1.4, "help.png");
    script.click_bar(1.5, help);
    script.key(1.6, "h");
    script.leave(1.6);
    script.picture(1.9, "bare.png");
    script.quit(2);
    play({"globe.mkv"}, legend + script.words());
    EXPECT_GT(differs("help.png", "away.png", 200, 100, 800, 600), 0.3);
    const auto [width, height] = GetParam();
    const int left = 1000 - 120'000 / width, top = 1000 - 110'000 / height, right = 1000 - 20'000 / width,
              bottom = 1000 - 76'000 / height;
    EXPECT_GT(differs("legend.png", "bare.png", left, top, right, bottom), 0.5);
    EXPECT_LT(differs("legend.png", "away.png", left, top, right, bottom), 0.001) << "it has moved";
    EXPECT_LT(differs("away.png", "bare.png", 350, 350, 1000, 1000 - 170'000 / height), 0.001)
        << "it covers the middle";
}

/// What is wrong is said above the bar, however long it is.
TEST_P(NarrowWindowMouse, FaultLeavesBarFree) {
    MouseScript script(GetParam());
    script.leave(0.1);
    script.click_bar(0.2, GetParam().width < 400 ? help : settings);
    script.leave(0.4);
    script.picture(0.7, "before.png");
    std::string path = "0.8 drop ";
    for (int k = 0; k < 20; ++k) path += "/nowhere-at-all-" + std::to_string(k);
    play({"globe.mkv"}, script.words() + path + "\n1.5 screenshot fault.png\n1.6 quit\n");
    const int bar = 1000 - 64'000 / GetParam().height;
    EXPECT_GT(differs("fault.png", "before.png", 0, 0, 1000, bar), 0.05);
    EXPECT_LT(differs("fault.png", "before.png", 0, bar, 1000, 1000), 0.001);
}

/// They take a fifth of its height, and are not said of what the bar covers, where buttons explain
/// themselves.
TEST_P(NarrowWindowMouse, PixelTextLeavesPictureFree) {
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

/// The house is among what is needed most: without keys it is the way back.
TEST_P(NarrowWindowMouse, ReturnsToOwnView) {
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

INSTANTIATE_TEST_SUITE_P(Narrow, NarrowWindowMouse,
                         ::testing::Values(WindowOfSize{320, 400}, WindowOfSize{480, 360}),
                         [](const auto& named) { return "Wide" + std::to_string(named.param.width); });

// With any input, of a person, a cat or a child, the window goes on, and no force is above the limit.

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

TEST(RandomInput, KeepsForceBelowLimit) {
    const TemporaryFolder folder;
    const std::string clip = (folder / "globe.mkv").string(), record = (folder / "hand.touch").string();
    make_clip(clip, "globe", 30, "160x120");
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
