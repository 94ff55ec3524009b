// What is dropped on a window, whether a clip is there or none yet: which of it is opened, what is told of
// the rest, and what stays as it was.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "engine/base/threads.hpp"
#include "player/window/play_window.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

using namespace std::chrono_literals;
using Words = std::vector<std::string>;

constexpr PicturePart middle{110, 140, 300, 176}, top{60, 0, 260, 60};

/// A clip of one frame.
std::string still_of(const char* scene) {
    return made_clip(scene, 1).string();
}
const Image& image_of_bumps() {
    static const Image image = played_by({still_of("bumps")}, "", "0.8").image;
    return image;
}
bool shows_bumps(const Image& image) {
    return differences(image, image_of_bumps(), middle) < 50;
}

TEST(DroppedClips, ThatCannotBeOpenedLeaveTheListAsItWas) {
    const Words two{still_of("globe"), still_of("bumps")};
    const Played next = played_by(two, "0.1 drop nowhere.mkv\n1 key pagedown\n", "3");
    EXPECT_NE(next.outcome.err.find("nowhere.mkv"), std::string::npos) << next.outcome.err;
    EXPECT_TRUE(shows_bumps(next.image)) << "the next of the clips that were there before";
}

TEST(DroppedClips, ThatCannotBeOpenedAreToldAndGonePast) {
    const std::string drop = "0.2 drop nowhere.mkv\n0.2 drop " + still_of("bumps") + "\n";
    for (const Words& words : {Words{still_of("globe")}, Words{}}) {
        const Played played = played_by(words, drop, "3");
        EXPECT_TRUE(shows_bumps(played.image)) << words.size() << " clips were there";
        EXPECT_NE(played.outcome.err.find("nowhere.mkv"), std::string::npos) << played.outcome.err;
        EXPECT_GT(differences(played.image, image_of_bumps(), top), 100) << "it is not told in the window";
    }
}

TEST(DroppedClips, OfVeryManyTheFirstFewAreTold) {
    std::string drop;
    for (int k = 0; k < 300; ++k) drop += "0.2 drop nowhere" + std::to_string(k) + ".mkv\n";
    const Played played = played_by({still_of("globe")}, drop + "0.2 drop " + still_of("bumps") + "\n", "4");
    EXPECT_TRUE(shows_bumps(played.image));
    EXPECT_NE(played.outcome.err.find("nowhere3.mkv"), std::string::npos) << played.outcome.err;
    EXPECT_EQ(played.outcome.err.find("nowhere4.mkv"), std::string::npos) << played.outcome.err;
    EXPECT_NE(played.outcome.err.find("296 more clips cannot be opened"), std::string::npos)
        << played.outcome.err;
}

TEST(DroppedClips, WhatIsInTheListAndCannotBeOpenedIsGonePastEitherWay) {
    const TemporaryFolder folder;
    const std::string broken = (folder / "broken.mkv").string();
    std::ofstream(broken) << "no clip";
    const Words three{still_of("globe"), broken, still_of("bumps")};
    EXPECT_TRUE(shows_bumps(played_by(three, "0.1 key pagedown\n2.4 dismiss\n", "3").image));
    const Image first = played_by({still_of("globe")}, "", "0.8").image;
    const Played back = played_by(three, "0.1 key pagedown\n2.4 dismiss\n2.5 key pageup\n4.6 dismiss\n", "5");
    EXPECT_LT(differences(back.image, first, middle), 50);
}

TEST(DroppedClips, ForceThatIsStoppedWhileOneOpensStaysOff) {
    const std::string drop = "0.2 drop " + still_of("bumps") + "\n";
    const Image on = played_by({still_of("globe")}, drop, "3").image,
                off = played_by({still_of("globe")}, drop + "0.2 key f\n", "3").image;
    const PicturePart words{60, 140, 260, 176};
    EXPECT_LT(differences(on, image_of_bumps(), words), 50);
    EXPECT_GT(differences(off, on, words), 300) << "it does not say that force is off";
}

/// The pointer has not moved since: the new clip has a finger there all the same.
TEST(DroppedClips, AreTouchedWhereThePointerRested) {
    const std::string drop = "0.1 move 160 120\n0.2 drop " + still_of("bumps") + "\n";
    const Image pressed = played_by({still_of("globe")}, drop + "1.5 press left\n", "3").image,
                moved =
                    played_by({still_of("globe")}, drop + "1.4 move 160 121\n1.5 press left\n", "3").image,
                rested = played_by({still_of("globe")}, drop, "3").image;
    const PicturePart finger{130, 90, 190, 150};
    EXPECT_GT(differences(moved, rested, finger), 100);
    EXPECT_GT(differences(pressed, rested, finger), 100);
}

TEST(EmptyWindow, HasTheKeysErrorsAndTouchesOfOneWithAClip) {
    const std::string there = "0.9 screenshot there.png\n";
    const auto stays = [&](const std::string& script) {
        const Played played = played_by({}, script + there, "1.2");
        return std::ranges::find(played.files, "there.png") != played.files.end();
    };
    const std::string at = "160 25";  // of the box that tells what went wrong
    EXPECT_FALSE(stays("0.3 key escape\n"));
    EXPECT_TRUE(stays("0.3 drop nowhere.mkv\n0.6 key escape\n")) << "Escape reads the fault before it closes";
    EXPECT_FALSE(stays("0.2 drop nowhere.mkv\n0.6 touch 1 " + at + "\n0.7 touch-end 1\n0.85 key escape\n"))
        << "a finger does not read it";
    const std::string twice =
        "0.2 touch 1 100 200\n0.25 touch-end 1\n0.3 touch 1 100 200\n0.35 touch-end 1\n";
    EXPECT_TRUE(stays(twice + "0.6 key escape\n")) << "a double tap fills the screen";
    const Image page = played_by({}, "", "0.6").image, help = played_by({}, "0.2 key ?\n", "0.6").image;
    EXPECT_GT(differences(page, help, {20, 20, 300, 180}), 3000) << "no help";
    EXPECT_TRUE(stays("0.3 key ?\n0.6 key escape\n")) << "Escape leaves the help before it closes";
}

TEST(EmptyWindow, SaysWhyNoClipOpens) {
    const TemporaryFolder folder;
    std::ofstream(folder / "film.mkv") << "no clip";
    PlayOptions options;
    options.session.clip.file = folder / "film.mkv";
    options.painter = "raster";  // the CPU draws no words
    options.headless = true;
    options.screen = {640, 480, false};
    options.seconds = 0.6;
    options.screenshot = folder / "end.png";
    EXPECT_FALSE(play_in_window(options));
    EXPECT_FALSE(std::filesystem::exists(folder / "end.png")) << "unless it is asked for, it does not stay";
    options.stays_without_clip = true;
    const auto played = play_in_window(options);
    ASSERT_FALSE(played);
    EXPECT_NE(played.error().message.find("film.mkv"), std::string::npos) << played.error().message;
    const auto end = read_image(folder / "end.png");
    ASSERT_TRUE(end) << end.error().message;
    const Image page = played_by({}, "", "0.6", "640x480").image;
    EXPECT_GT(differences(*end, page, {60, 0, 580, 100}), 300) << "the fault is not shown";
    EXPECT_LT(differences(*end, page, {10, 240, 630, 470}), 500) << "it does not wait for another clip";
    options.screen = {320, 240, false};
    options.script = {{0.2, InputEvent{.kind = InputEvent::Kind::dropped, .word = still_of("bumps")}}};
    options.existing = Existing::replace;
    options.seconds = 3;
    options.script.push_back({1.5, WindowCommand{.verb = WindowVerb::dismiss}});
    EXPECT_EQ(play_in_window(options).error().kind, ErrorKind::input);
    EXPECT_TRUE(shows_bumps(*read_image(folder / "end.png"))) << "a clip that is dropped is not opened";
}

TEST(EmptyWindow, OpensAGpuThatIsLostAnew) {
    const TemporaryFolder folder;
    PlayOptions options;
    options.gpu = std::make_shared<RunGpu>("auto");
    options.painter = "raster";
    options.headless = true;
    options.screen = {320, 200, false};
    options.seconds = 1.2;
    options.screenshot = folder / "end.png";
    options.script = {{0.1, WindowCommand{WindowVerb::screenshot, 0, (folder / "first.png").string()}}};
    const auto device = *options.gpu->open();
    std::atomic<bool> has_ended{false};
    std::thread loss([&] {
        while (!has_ended && !std::filesystem::exists(folder / "first.png"))
            std::this_thread::sleep_for(10ms);
        device->lose();
    });
    const auto played = play_in_window(options);
    has_ended = true;
    loss.join();
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_TRUE(device->lost());
    EXPECT_TRUE(read_image(folder / "end.png"));
}

/// A disk that does not answer costs no picture, and nobody waits for it at the end. (Were the folder listed
/// by the window, the test would end after ten seconds, with fewer pictures.)
TEST(DroppedFolder, IsListedBesideTheWindow) {
    const TemporaryFolder folder;
    struct Disk {
        std::atomic<bool> is_asked{false}, answers{false};
    };
    const auto disk = std::make_shared<Disk>();
    PlayOptions options;
    options.session.clip.file = still_of("globe");
    options.session.builder.name = options.painter = "cpu";
    options.headless = true;
    options.screen = {320, 240, false};
    options.seconds = 3;
    options.clips_of = [disk](const std::filesystem::path& named) {
        disk->is_asked = true;
        for (int k = 0; k < 10'000 && !disk->answers; ++k) std::this_thread::sleep_for(1ms);
        return std::vector<std::filesystem::path>{named};
    };
    const auto picture = [&](double s) {
        return ScriptedInput{
            s, WindowCommand{WindowVerb::screenshot, 0, (folder / std::to_string(s)).string() + ".png"}};
    };
    options.script = {{0.1, InputEvent{.kind = InputEvent::Kind::dropped, .word = "far"}},
                      picture(0.5),
                      {0.6, WindowCommand{WindowVerb::quit}}};
    const auto played = play_in_window(options);
    EXPECT_TRUE(played) << played.error().message;
    EXPECT_TRUE(disk->is_asked);
    EXPECT_FALSE(disk->answers);
    EXPECT_LT(played->seconds, 8) << "the window waited for the disk";
    EXPECT_EQ(names_in(folder.path()).size(), 1U);
    disk->answers = true;
    while (abandoned_threads > 0) std::this_thread::sleep_for(1ms);
}

}  // namespace
}  // namespace touchable::test
