// SPDX-License-Identifier: Apache-2.0
// Files that a window reads and writes: each once, whole or up to where a disk is full, and never one in
// place of another.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/authoring/materials.hpp"
#include "engine/base/threads.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/sound.hpp"
#include "player/run/run_files.hpp"
#include "player/session/clip_choice.hpp"
#include "player/window/play_window.hpp"
#include "tests/player/program.hpp"
#include "tests/temporary_files.hpp"
#include "tests/video/remuxed_clip.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

/// Neither to know which files may be written, nor for other settings; kept ones are refused here at first.
TEST(WindowFiles, OpensEachFrameOnce) {
    const TemporaryFolder folder;
    const std::string pictures = (folder / "pictures").string();
    ASSERT_EQ(run_touchable({"convert", made_clip("globe", 30).string(), pictures + "/"}).code, 0);
    std::ofstream(folder / "play.json") << R"({"a": {"temporal": "on"}})";
    OpenedFiles opened(pictures);
    shot_of(pictures, "0 speed 0.25\n0.3 median 5\n0.8 metric pixel\n1.3 filters auto\n", "2",
            {"--record", (folder / "hand.touch").string(), "--settings", (folder / "play.json").string()});
    const auto times = opened.counts();
    EXPECT_TRUE(times.contains("scene.json") && times.contains("depth_000003.png"));
    for (const auto& [file, count] : times) EXPECT_EQ(count, 1) << file;
    const auto recording = read_recording(folder / "hand.touch");
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_GT(recording->size(), 1U) << "nothing was changed";
}

/// A part of it, up to where the disk was full.
void expect_recorded(const std::string& record) {
    const auto recording = read_recording(record);
    ASSERT_TRUE(recording) << recording.error().message;
    EXPECT_GT(recording->front().ticks.size(), 100U);
}

TEST(WindowFiles, FullDiskKeepsWrittenData) {
    const TemporaryFolder folder;
    const std::string record = (folder / "hand.touch").string(), sound = (folder / "heard.wav").string();
    const Outcome played = run_on_full_disk(
        {"play", made_clip("globe", 30).string(), "--headless", "--size", "320x240", "--seconds", "2",
         "--painter", "cpu", "--builder", "cpu", "--record", record, "--sound", sound},
        100);
    EXPECT_EQ(played.code, 3) << played.err;
    for (const std::string& file : {"--record " + record, "--sound " + sound}) {
        const std::size_t at_once = played.err.find("touchable: warning: " + file + ": cannot be written: ");
        const std::size_t in_the_end = played.err.find("touchable: --record " + record + ": cannot be");
        EXPECT_LT(at_once, in_the_end) << played.err;
        EXPECT_NE(in_the_end, std::string::npos) << played.err;
    }
    expect_recorded(record);
    const auto again = run_touchable({"touch", "--replay", record});
    EXPECT_EQ(again.code, 0) << again.err;
    EXPECT_TRUE(contains(again.out, "as recorded, to the bit"));
    const std::string wav = file_contents(sound);
    ASSERT_GT(wav.size(), 60'000U);
    std::uint32_t samples = 0;
    std::memcpy(&samples, wav.data() + 40, sizeof samples);
    EXPECT_EQ(samples, wav.size() - 44) << "what the header says is what is there";
}

TEST(WindowFiles, FullDiskKeepsFilm) {
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << "0 loop\n0 overlay depth\n0.3 size 640x480\n0.6 overlay normals\n";
    const std::string film = (folder / "film.mp4").string(), record = (folder / "hand.touch").string();
    const Outcome played =
        run_on_full_disk({"play", made_clip("globe", 30).string(), "--headless", "--size", "640x480",
                          "--seconds", "4", "--painter", "cpu", "--builder", "cpu", "--script",
                          (folder / "script").string(), "--video", film, "--record", record},
                         250);
    EXPECT_EQ(played.code, 3) << played.err;
    const std::string full = film + ": the film cannot be written: the disk is full";
    const std::size_t at_once = played.err.find("touchable: warning: " + full + "\n");
    const std::size_t in_the_end = played.err.find(full + "; it is kept up to there\n");
    EXPECT_LT(at_once, in_the_end) << played.err;
    EXPECT_NE(in_the_end, std::string::npos) << played.err;
    EXPECT_EQ(played.err.find("warning: " + full, at_once + full.size()), std::string::npos) << "told twice";
    EXPECT_GE(seen_in_film(film).size(), 2U) << "pictures that were complete";
    expect_recorded(record);
}

TEST(WindowFiles, HeadlessNeedsAnEnd) {
    expect_refused({"play", made_clip("globe", 30).string(), "--headless"}, 2);
    const TemporaryFolder folder;
    std::ofstream(folder / "script") << "0.1 quit\n";
    const std::string film = (folder / "FILM.MP4").string();
    const auto ends = run_touchable({"play", made_clip("globe", 30).string(), "--headless", "--size",
                                     "320x240", "--script", (folder / "script").string(), "--video", film});
    EXPECT_EQ(ends.code, 0) << ends.err;
    EXPECT_FALSE(seen_in_film(film).empty());
    expect_refused({"play", "nowhere.mkv", "--headless", "--seconds", "1"}, 3);
}

TEST(WindowFiles, EarlyInterruptWritesNothing) {
    const TemporaryFolder folder;
    const auto ended = run_interrupted_at_once({"play", made_clip("globe", 30).string(), "--headless",
                                                "--seconds", "9", "--video", (folder / "film.mkv").string()});
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_TRUE(ended.one_line_of_error()) << ended.err;
    EXPECT_FALSE(contains(ended.err, "is written"));
    EXPECT_FALSE(contains(ended.err, "; written"));
    EXPECT_TRUE(names_in(folder.path()).empty());
}

TEST(WindowFiles, NeverOverwritesItsClip) {
    const TemporaryFolder folder;
    std::filesystem::copy(made_clip("globe", 30), folder / "globe.mkv");
    const std::string clip = (folder / "globe.mkv").string(), before = file_contents(clip);
    const std::string other_spelling = (folder / ".").string() + "/globe.mkv";
    const std::vector<std::string> play{"play", clip, "--headless", "--seconds", "0.2"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), play.begin(), play.end());
        return more;
    };
    expect_refused(with({"--record", other_spelling, "--overwrite"}), 2);
    EXPECT_EQ(run_touchable(with({"--settings", other_spelling})).code, 2);
    std::ofstream(folder / "script") << "0 open " << clip << "\n0 screenshot " << (folder / "a.png").string()
                                     << "\n";
    std::filesystem::create_symlink(clip, folder / "a.png");
    const auto drawn = run_touchable({"play", made_clip("globe", 1).string(), "--headless", "--seconds",
                                      "0.2", "--script", (folder / "script").string(), "--overwrite"});
    EXPECT_EQ(drawn.code, 2) << drawn.err;
    EXPECT_EQ(file_contents(clip), before);
}

TEST(WindowFiles, FilmMatchesWindow) {
    const TemporaryFolder folder;
    const std::string film = (folder / "film.mkv").string();
    // The other size, and the panel in the right half from then on; a while after the press, for the finger
    // comes later where ticks are skipped, and at the other size the pointer is beside the globe.
    const Played shot =
        shot_of(made_clip("globe", 1), "0 move 160 130\n0.2 press left\n1.3 size 640x480\n1.3 panel\n", "1.8",
                {"--video", film, "--words"});
    EXPECT_TRUE(contains(shot.outcome.out, "film "));
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
    ASSERT_TRUE(track && *track);
    // All of it: where the machine stood still, the finger pressed later.
    std::vector<StereoSample> heard(static_cast<std::size_t>(48'000 * (lasted_s + 1)));
    (*track)->read(heard);
    const auto is_silent = [](const StereoSample& sample) { return sample.left == 0 && sample.right == 0; };
    const auto first = std::find_if_not(heard.begin(), heard.end(), is_silent) - heard.begin();
    EXPECT_GE(first, 0.2 * 48'000) << "before the finger pressed";
    EXPECT_LT(first, std::ssize(heard)) << "no tap";
    expect_refused({"play", made_clip("globe", 1).string(), "--headless", "--seconds", "0.2", "--video",
                    (folder / "film.avi").string()},
                   2);
}

// Films without a window, in virtual time.

/// A turning globe that beeps, and a touch: with settings, another clip and paint in between.
class OfflineFilm : public ::testing::Test {
protected:
    void SetUp() override {
        write_sounding_clip(clip_, tone(480, 1.8), made_clip("globe", 30));
        std::ofstream(folder_ / "script") << "0 move 80 60\n0 press left\n0.1 move 90 64\n0.1 median 5\n"
                                             "0.15 seek 0.5\n0.2 turn 20\n0.25 material brick\n"
                                             "0.25 paint 60,70\n0.3 drop "
                                          << made_clip("globe", 1).string() << "\n0.35 press left\n";
    }
    /// Of 0.4 s by the CPU, unless the words `more` say otherwise.
    Outcome film(const std::string& name, std::vector<std::string> more = {}, bool has_script = true) const {
        std::vector<std::string> words{"play",      clip_.string(), "--headless", "--seconds", "0.4",
                                       "--builder", "cpu",          "--video",    path(name)};
        if (has_script) words.insert(words.end(), {"--script", path("script")});
        for (const auto& [option, usual] : {std::pair{"--size", "160x120"}, {"--painter", "cpu"}})
            if (std::ranges::find(more, option) == more.end()) words.insert(words.end(), {option, usual});
        words.insert(words.end(), more.begin(), more.end());
        Outcome made = run_touchable(words);
        EXPECT_EQ(made.code, 0) << made.err;
        return made;
    }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }
    Image picture(const std::string& name) const {
        auto read = read_image(path(name));
        EXPECT_TRUE(read) << read.error().message;
        return read ? std::move(*read) : Image();
    }

    const TemporaryFolder folder_;
    const std::filesystem::path clip_ = folder_ / "sounding.mkv";
};

/// Beside another run of its own, which slows both.
TEST_F(OfflineFilm, HasSameBytesOnEachRun) {
    for (const std::string ending : {".mp4", ".mkv"}) {
        EXPECT_TRUE(contains(film("alone" + ending).out, "12 pictures, 0 left out\n"));
        std::thread beside([&] { film("beside" + ending, {"--words"}); });
        EXPECT_TRUE(contains(film("busy" + ending).out, "12 pictures, 0 left out\n"));
        beside.join();
        EXPECT_EQ(seen_in_film(path("busy" + ending)).size(), 12U);
        EXPECT_EQ(file_contents(path("alone" + ending)), file_contents(path("busy" + ending))) << ending;
    }
}

/// Bars and messages included.
TEST_F(OfflineFilm, GpuPicturesAreRepeatable) {
    const std::vector<std::string> words{"--painter", "raster", "--words"};
    film("a%d.png", words);
    film("b%d.png", words);
    film("bare%d.png", {"--painter", "raster"});
    for (const std::string number : {"1", "5", "12"})
        EXPECT_EQ(file_contents(path("a" + number + ".png")), file_contents(path("b" + number + ".png")));
    EXPECT_GT(differences(picture("a12.png"), picture("bare12.png"), {0, 90, 159, 119}), 500) << "no bar";
}

/// Pictures, by contrast, are of the rate.
TEST_F(OfflineFilm, TouchMatchesReplayAtAnyRate) {
    std::ofstream(folder_ / "script") << "0 move 80 60\n0.05 press left\n0.11 move 90 64\n0.2 turn 20\n";
    std::vector<std::string> hashes;
    for (const auto& [rate, pictures] : {std::pair{"7", 3U}, {"60", 24U}}) {
        const std::string name = std::string("at") + rate;
        film(name + ".mkv", {"--fps", rate, "--record", path(name + ".touch")});
        const auto seen = seen_in_film(path(name + ".mkv"));
        ASSERT_EQ(seen.size(), pictures);
        EXPECT_NEAR(seen.back().seconds, (pictures - 1) / std::stod(rate), 0.001);
        const std::string told = replayed(folder_.path(), name + ".touch");
        const std::size_t at = told.find("\"force_hash\"");
        ASSERT_NE(at, std::string::npos) << told;
        hashes.push_back(told.substr(at, 40));
    }
    EXPECT_EQ(hashes[0], hashes[1]);
}

/// However long it takes to open.
TEST_F(OfflineFilm, ShowsNextClipAtItsMoment) {
    std::ofstream(folder_ / "script") << "0.2 drop " << made_clip("bumps", 1).string() << "\n";
    film("shot-%d.png");
    const Image last = picture("shot-6.png"), next = picture("shot-7.png"), later = picture("shot-8.png");
    EXPECT_GT(differences(last, next, {0, 0, 159, 119}), 5000);
    EXPECT_EQ(differences(next, later, {0, 0, 159, 119}, 0), 0);
}

/// As in a window: the last surface stays, and can be touched.
TEST_F(OfflineFilm, KeepsSurfaceOfBrokenClip) {
    const std::string frames = path("frames");
    ASSERT_EQ(run_touchable({"convert", made_clip("bumps", 12).string(), frames}).code, 0);
    std::vector<std::filesystem::path> depths;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(frames))
        if (contains(entry.path().string(), "depth") && entry.is_regular_file())
            depths.push_back(entry.path());
    std::ranges::sort(depths);
    ASSERT_EQ(depths.size(), 12U);
    std::ofstream(depths[4]) << "no picture";
    std::ofstream(folder_ / "script") << "0.2 move 80 60\n0.2 press left\n";
    const Outcome made =
        run_touchable({"play", frames, "--headless", "--seconds", "0.5", "--size", "160x120", "--painter",
                       "cpu", "--video", path("shot-%d.png"), "--script", path("script")});
    EXPECT_EQ(made.code, 3);
    EXPECT_TRUE(contains(made.err, depths[4].filename().string())) << made.err;
    EXPECT_GT(differences(picture("shot-6.png"), picture("shot-15.png"), {0, 0, 159, 119}), 50) << "a finger";
}

TEST_F(OfflineFilm, SoundLastsAsLongAsPictures) {
    film("film.mkv", {}, false);
    auto track = SoundTrack::open(path("film.mkv"));
    ASSERT_TRUE(track && *track);
    std::vector<StereoSample> heard(48'000);
    (*track)->read(heard);
    const auto is_heard = [&](std::size_t from, std::size_t to) {
        return std::any_of(heard.begin() + static_cast<std::ptrdiff_t>(from),
                           heard.begin() + static_cast<std::ptrdiff_t>(to),
                           [](const StereoSample& sample) { return std::abs(sample.left) > 0.05F; });
    };
    EXPECT_TRUE(is_heard(0, 480)) << "from the first picture on";
    EXPECT_TRUE(is_heard(19'200 - 100, 19'200)) << "to the last one's end";
    EXPECT_FALSE(is_heard(19'200, 48'000));
}

TEST_F(OfflineFilm, WritesNumberedPictures) {
    film("shot-%03d.png", {"--size", "161x121"});
    for (int number = 1; number <= 12; ++number) {
        const Image seen =
            picture("shot-0" + std::string(number < 10 ? "0" : "") + std::to_string(number) + ".png");
        EXPECT_EQ(seen.width, 161);
        EXPECT_EQ(seen.height, 121);
    }
    EXPECT_FALSE(std::filesystem::exists(path("shot-000.png")));
    EXPECT_FALSE(std::filesystem::exists(path("shot-013.png")));
    std::filesystem::remove(path("shot-001.png"));
    const std::vector<std::string> play{"play",      clip_.string(), "--headless",
                                        "--seconds", "0.1",          "--painter",
                                        "cpu",       "--video",      path("shot-%03d.png")};
    expect_refused(play, 2, "shot-0");
    EXPECT_FALSE(std::filesystem::exists(path("shot-001.png")));
    film("shot-%03d.png", {"--size", "64x64", "--overwrite"});
    EXPECT_EQ(picture("shot-012.png").width, 64);
}

/// Of the picture that is twice or four times as large, averaged as light (sRGB).
TEST_F(OfflineFilm, PixelIsMeanOfSamples) {
    std::ofstream(folder_ / "turned") << "0 turn 30\n";
    const auto first = [&](const std::string& samples, const std::string& size) {
        const std::string name = "s" + samples + "-" + size;
        film(name + "-%d.png", {"--samples", samples, "--size", size, "--script", path("turned")}, false);
        return picture(name + "-1.png");
    };
    const auto light_of = [](int byte) {
        const double share = byte / 255.0;
        return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
    };
    for (const int samples : {2, 4}) {
        const Image large = first("1", std::to_string(samples * 80) + "x" + std::to_string(samples * 64)),
                    mean = first(std::to_string(samples), "80x64");
        int most = 0;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 80; ++x)
                for (std::size_t c = 0; c < 3; ++c) {
                    double light = 0;
                    for (int k = 0; k < samples * samples; ++k)
                        light += light_of(
                            colour_at(large, samples * x + k % samples, samples * y + k / samples)[c]);
                    light /= samples * samples;
                    const double share =
                        light <= 0.0031308 ? light * 12.92 : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
                    most = std::max(most, static_cast<int>(
                                              std::lround(std::abs(255 * share - colour_at(mean, x, y)[c]))));
                }
        EXPECT_LE(most, 1) << samples;
    }
}

TEST_F(OfflineFilm, RefusesOptionsWithoutIt) {
    const auto refused = [&](std::vector<std::string> more, const std::string& part) {
        more.insert(more.begin(), {"play", clip_.string(), "--seconds", "0.1"});
        expect_refused(more, 2, part);
    };
    const std::string video = path("film.mp4");
    refused({"--video", video, "--fps", "60"}, "--headless");
    refused({"--headless", "--samples", "1"}, "--video");
    refused({"--headless", "--words"}, "--video");
    refused({"--video", path("shot-%d.png")}, "--headless");
    refused({"--headless", "--video", path("shot.png")}, "shot-%04d.png");
    refused({"--headless", "--video", path("shot-%s.png")}, "shot-%04d.png");
    refused({"--headless", "--video", video, "--fps", "241"}, "1 to 240");
    refused({"--headless", "--video", video, "--samples", "3"}, "1, 2 or 4");
    refused({"--headless", "--video", video, "--size", "8192x64", "--samples", "4"}, "32768 samples");
    EXPECT_FALSE(std::filesystem::exists(video));
}

// The brush of materials in a window, by scripts: what it shows, saves, and finds again.

namespace fs = std::filesystem;

class BrushScript : public ScriptedClipTest {
protected:
    BrushScript() : ScriptedClipTest("320x240", "2") {}
    void SetUp() override { ASSERT_NO_FATAL_FAILURE(write_two_surfaces(clip_, 4)); }
    /// The window's picture once the script is done; drawn by the CPU, without text.
    Image shot(const std::string& script, std::vector<std::string> more = {}) {
        more.insert(more.end(), {"--painter", "cpu", "--builder", "cpu"});
        return ScriptedClipTest::shot(script, more);
    }
    /// The names that were saved.
    SegmentNames names() const {
        auto read = parse_segment_names(saved(), "saved");
        EXPECT_TRUE(read) << read.error().message;
        return read ? std::move(*read) : SegmentNames();
    }
    std::string saved() const { return file_contents(folder_ / "saved.json"); }
    std::string save() const { return "0 save-materials " + (folder_ / "saved.json").string() + "\n"; }
    const std::string quit_ = "0 quit\n";
    const std::vector<std::string> history{"--brush-history", (folder_ / "state").string()};
};

// Pixels of the window, on either half of the wall.
constexpr int left = 80, right = 240, row = 120;

TEST_F(BrushScript, PaintIsFeltAndCompared) {
    const std::string overlay = "0 overlay stiffness\n", paint =
                                                             "0 material water\n0 paint 20,32\n"
                                                             "0 material brick\n0 paint 70,32,3\n";
    const Image before = shot(overlay), painted = shot(overlay + paint),
                compared = shot(overlay + paint + "0.2 key b\n"),
                again = shot(overlay + paint + "0.2 key b\n0.5 key b\n"),
                undone = shot(overlay + paint + "0.2 undo\n0.2 undo\n0.2 tool touch\n");
    EXPECT_EQ(colour_at(before, left, row), colour_at(before, right, row))
        << "the clip is the same everywhere";
    EXPECT_NE(colour_at(painted, left, row), colour_at(painted, right, row));
    EXPECT_EQ(colour_at(again, left, row), colour_at(painted, left, row));
    EXPECT_EQ(colour_at(again, right, row), colour_at(painted, right, row));
    for (const Image* image : {&compared, &undone}) {
        EXPECT_EQ(colour_at(*image, left, row), colour_at(before, left, row));
        EXPECT_EQ(colour_at(*image, right, row), colour_at(before, right, row));
    }
}

TEST_F(BrushScript, ToolTintsPicture) {
    const std::string paint = "0 material grass\n0 paint 20,32\n0 material water\n0 paint 70,32\n";
    const Image tinted = shot(paint), away = shot(paint + "0.2 tool touch\n"), plain = shot("");
    EXPECT_GT(colour_at(tinted, left, row)[1], colour_at(tinted, left, row)[0] + 30) << "green";
    EXPECT_GT(colour_at(tinted, right, row)[2], colour_at(tinted, right, row)[1] + 30) << "blue";
    EXPECT_EQ(colour_at(away, left, row), colour_at(plain, left, row));
}

/// In a window that is so large that the panel, which comes with the tool, covers neither place.
TEST_F(BrushScript, ClicksAndStrokesMatchCommands) {
    const std::string large = "0 size 960x640\n", click = "0 press left\n0 release left\n",
                      on_left = "0 move 240 320\n" + click, on_right = "0 move 560 320\n" + click;
    const Outcome done =
        run(large + "0 material felt\n" + on_left + "0 tool join\n" + on_left + on_right + save() + quit_);
    ASSERT_EQ(done.code, 0);
    EXPECT_EQ(done.err, "");
    const SegmentNames joined = names();
    ASSERT_EQ(joined.segments.size(), 1U);
    EXPECT_EQ(joined.segments[0].material, "felt");
    EXPECT_EQ(joined.segments[0].at.size(), 2U);
    std::string stroke = "0 tool cut\n0 move 10 500\n0 press left\n";
    for (int x = 20; x <= 560; x += 10) stroke += "0 move " + std::to_string(x) + " 500\n";
    ASSERT_EQ(run(large + stroke + "0 release left\n" + save() + quit_).code, 0);
    const SegmentNames cut = names();
    ASSERT_EQ(cut.cuts.size(), 1U);
    EXPECT_GT(cut.cuts[0].stroke.size(), 10U);
}

TEST_F(BrushScript, SavedMaterialsMatchFeltClip) {
    ASSERT_EQ(run("0 material foam\n0 paint 20,32\n0 cut 40,30 95,30\n0 paint 70,5\n0 otherwise brick\n" +
                  save() + quit_)
                  .code,
              0);
    const fs::path out = folder_ / "out.mkv";
    const Outcome made = run_touchable(
        {"materials", clip_.string(), out.string(), "--segments", (folder_ / "saved.json").string()});
    ASSERT_EQ(made.code, 0) << made.err;
    ClipChoice felt;
    felt.file = clip_;
    auto segments = read_chosen_segments(felt, {});
    ASSERT_TRUE(segments);
    const SegmentNames found = names();
    auto brush = MaterialBrush::begin(std::move(*segments), found);
    ASSERT_TRUE(brush) << brush.error().message;
    felt.painted = brush->painted();
    auto of_window = felt.open();
    auto of_command = open_clip(out);
    ASSERT_TRUE(of_window && of_command);
    for (int n = 0; n < 4; ++n) {
        const auto a = (*of_window)->next(), b = (*of_command)->next();
        ASSERT_TRUE(a && b && *a && *b) << n;
        for (int y = 0; y < 64; ++y)
            for (int x = 0; x < 96; ++x)
                for (int c = 0; c < 3; ++c)
                    ASSERT_EQ((*a)->haptic.sample(x, y, c), (*b)->haptic.sample(x, y, c)) << x << ' ' << y;
    }
}

TEST_F(BrushScript, NextWindowRestoresHistory) {
    ASSERT_EQ(run("0 material foam\n0 paint 20,32\n0 material glass\n0 paint 70,32\n" + quit_, history).code,
              0);
    EXPECT_EQ(names_in(folder_ / "state").size(), 1U);
    ASSERT_EQ(run("0 undo\n" + save() + quit_, history).code, 0);
    const SegmentNames found = names();
    ASSERT_EQ(found.segments.size(), 1U);
    EXPECT_EQ(found.segments[0].material, "foam");
    // Without a history file the next window starts anew.
    const Outcome none = run("0 undo\n" + quit_);
    EXPECT_TRUE(contains(none.err, "nothing to undo"));
}

TEST_F(BrushScript, SavesWithoutOverwriting) {
    ASSERT_EQ(run("0 material foam\n0 paint 20,32\n0 save-materials\n" + quit_).code, 0);
    EXPECT_TRUE(fs::exists(folder_ / "wall.mkv.materials.json"));
    // It is where the next one begins, and a file that is given counts before it.
    ASSERT_EQ(run(save() + quit_).code, 0);
    EXPECT_EQ(saved(), file_contents(folder_ / "wall.mkv.materials.json"));
    std::ofstream(folder_ / "given.json") << R"({"touchable_segments": 1, "segments":
        [{"name": "left", "material": "carpet", "at": [20, 32]}]})";
    const std::vector<std::string> given{"--segments", (folder_ / "given.json").string()};
    ASSERT_EQ(run(save() + quit_, given).code, 0);
    EXPECT_TRUE(contains(saved(), "carpet"));
    // Given materials are felt once segments are read, also without a tool in the hand.
    const Image felt = shot("0 overlay friction\n", given), own = shot("0 overlay friction\n");
    EXPECT_NE(colour_at(felt, left, row), colour_at(felt, right, row));
    EXPECT_EQ(colour_at(own, left, row), colour_at(own, right, row))
        << "the file beside it is the brush's alone";
    std::ofstream(folder_ / "saved.json") << "my diary";
    const Outcome refused = run("0 material foam\n" + save() + quit_);
    EXPECT_TRUE(contains(refused.err, "not saved in its place"));
    EXPECT_EQ(refused.code, 3);
    EXPECT_EQ(saved(), "my diary");
    const std::string good = "0 save-materials " + (folder_ / "good.json").string() + "\n";
    EXPECT_EQ(run("0 material foam\n" + save() + good + quit_).code, 0) << "what was saved last is there";
    EXPECT_EQ(run("0 material foam\n" + good + save() + quit_).code, 3);
    EXPECT_NE(run(save() + quit_, {"--record", (folder_ / "hand.touch").string()}).code, 0);
}

/// Commands given before another clip comes are finished first, and are kept as this clip's.
TEST_F(BrushScript, BrushFinishesBeforeNextClip) {
    const fs::path other = folder_ / "other.mkv";
    ASSERT_NO_FATAL_FAILURE(write_two_surfaces(other, 4));
    const Outcome done =
        run("0 material foam\n0 drop " + other.string() + "\n0 cut 40,30 95,30\n0.2 quit\n", history);
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(done.err, "");
    ASSERT_EQ(run(save() + quit_, history).code, 0);
    const SegmentNames found = names();
    EXPECT_EQ(found.cuts.size(), 1U);
}

/// Paint that is not felt starts no session.
TEST_F(BrushScript, UnfeltPaintRestartsNothing) {
    const auto frames_after = [this](const std::string& feel) {
        std::string script = "0 material foam\n0.1 " + feel + "\n";
        for (int k = 0; k < 10; ++k)
            script += std::to_string(1 + k) + "e-1" + (k % 2 ? " undo\n" : " paint 20,32\n");
        const Outcome done = run(script + "1.5 quit\n");
        EXPECT_EQ(done.code, 0) << done.err;
        const std::size_t at = done.out.find("\nframes   ");
        return at == std::string::npos
                   ? -1
                   : std::atoi(done.out.c_str() + done.out.find_first_of("0123456789", at));
    };
    const int unfelt = frames_after("materials off"), felt = frames_after("materials on");
    EXPECT_GT(unfelt, 0);
    EXPECT_LT(unfelt + 1, felt) << "of ten changes, each felt";
}

TEST_F(BrushScript, RejectsInvalidInOneLine) {
    const Outcome done = run("0 paint 20,32,9\n0 join 20,32 21,32\n0 materials off\n0 redo\n" + quit_);
    EXPECT_EQ(done.code, 0);
    for (const char* words :
         {"beyond the clip", "both places are on segment", "nothing is painted", "nothing to do again"})
        EXPECT_TRUE(contains(done.err, words));
    const Outcome recorded = run("0 paint 20,32\n" + quit_, {"--record", (folder_ / "hand.touch").string()});
    EXPECT_TRUE(contains(recorded.err, "a window that records has no brush"));
    const Outcome camera = run_touchable({"play", "--camera", "replay:" + clip_.string(), "--headless",
                                          "--script", (folder_ / "script").string()});
    EXPECT_EQ(camera.code, 0);
    EXPECT_TRUE(contains(camera.err, "a camera has no brush"));
    std::ofstream(folder_ / "bad.json") << R"({"touchable_segments": 1, "segments": [{}]})";
    const Outcome bad = run(quit_, {"--segments", (folder_ / "bad.json").string()});
    EXPECT_EQ(bad.code, 3);
    EXPECT_TRUE(bad.one_line_of_error()) << bad.err;
    const Outcome both = run(quit_, {"--segments", (folder_ / "bad.json").string(), "--record", "r.touch"});
    EXPECT_EQ(both.code, 2) << both.err;
}

TEST_F(BrushScript, ReportsUnsavedPaint) {
    const std::string paint = "0 material water\n0 paint 20,32\n",
                      not_saved = "what was painted is not saved";
    const auto told = [&](const std::string& script, const std::vector<std::string>& more = {}) {
        const Outcome done = run(script + quit_, more);
        EXPECT_EQ(done.code, 0) << done.err;
        return done.out;
    };
    EXPECT_TRUE(contains(told(paint), not_saved + ", and is lost"));
    EXPECT_TRUE(
        contains(told(paint, {"--brush-history", (folder_ / "kept").string()}), "for the next window"));
    EXPECT_FALSE(contains(told(paint + save()), not_saved));
    EXPECT_FALSE(contains(told("0 tool paint\n"), not_saved));
}

TEST_F(BrushScript, RejectsUnfitSegments) {
    const fs::path file = folder_ / "other.json";
    std::ofstream(file) << R"({"touchable_segments": 1, "segments": [
        {"name": "a", "material": "wood", "at": [9000, 1]}]})";
    const Outcome done = run("0 tool paint\n" + quit_, {"--segments", file.string()});
    EXPECT_EQ(done.code, 3) << done.out;
    EXPECT_TRUE(contains(done.err, "outside of the picture"));
}

// Files dropped on a window, with a clip or without one yet: which are opened, what is reported of the rest,
// and what stays as it was.

using namespace std::chrono_literals;
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

TEST(DroppedClips, UnopenableClipKeepsPlaylist) {
    const Words two{still_of("globe"), still_of("bumps")};
    const Played next = played_by(two, "0.1 drop nowhere.mkv\n1 key pagedown\n", "3");
    EXPECT_TRUE(contains(next.outcome.err, "nowhere.mkv"));
    EXPECT_TRUE(shows_bumps(next.image)) << "the next of the clips that were there before";
}

TEST(DroppedClips, ReportsAndSkipsUnopenableClip) {
    const std::string drop = "0.2 drop nowhere.mkv\n0.2 drop " + still_of("bumps") + "\n";
    for (const Words& words : {Words{still_of("globe")}, Words{}}) {
        const Played played = played_by(words, drop, "3");
        EXPECT_TRUE(shows_bumps(played.image)) << words.size() << " clips were there";
        EXPECT_TRUE(contains(played.outcome.err, "nowhere.mkv"));
        EXPECT_GT(differences(played.image, image_of_bumps(), top), 100) << "it is not told in the window";
    }
}

TEST(DroppedClips, FaultListIsLimited) {
    std::string drop;
    for (int k = 0; k < 300; ++k) drop += "0.2 drop nowhere" + std::to_string(k) + ".mkv\n";
    const Played played = played_by({still_of("globe")}, drop + "0.2 drop " + still_of("bumps") + "\n", "4");
    EXPECT_TRUE(shows_bumps(played.image));
    EXPECT_TRUE(contains(played.outcome.err, "nowhere3.mkv"));
    EXPECT_FALSE(contains(played.outcome.err, "nowhere4.mkv"));
    EXPECT_TRUE(contains(played.outcome.err, "296 more clips cannot be opened"));
}

TEST(DroppedClips, SkipsUnopenableClipBothWays) {
    const TemporaryFolder folder;
    const std::string broken = (folder / "broken.mkv").string();
    std::ofstream(broken) << "no clip";
    const Words three{still_of("globe"), broken, still_of("bumps")},
        missing{three[0], (folder / "none.mkv").string(), three[2]};
    EXPECT_TRUE(shows_bumps(played_by(missing, "0.1 key pagedown\n2.4 dismiss\n", "3").image));
    EXPECT_TRUE(shows_bumps(played_by(three, "0.1 key pagedown\n2.4 dismiss\n", "3").image));
    const Image first = played_by({still_of("globe")}, "", "0.8").image;
    const Played back = played_by(three, "0.1 key pagedown\n2.4 dismiss\n2.5 key pageup\n4.6 dismiss\n", "5");
    EXPECT_LT(differences(back.image, first, middle), 50);
}

TEST(DroppedClips, StoppedForceStaysOff) {
    const std::string drop = "0.2 drop " + still_of("bumps") + "\n";
    const Image on = played_by({still_of("globe")}, drop, "3").image,
                off = played_by({still_of("globe")}, drop + "0.2 key f\n", "3").image;
    const PicturePart words{60, 140, 260, 176};
    EXPECT_LT(differences(on, image_of_bumps(), words), 50);
    EXPECT_GT(differences(off, on, words), 300) << "it does not say that force is off";
}

/// The pointer has not moved since: the new clip has a finger there all the same.
TEST(DroppedClips, AreTouchedUnderRestingPointer) {
    const std::string drop = "0.1 move 160 120\n0.2 drop " + still_of("bumps") + "\n";
    const Image pressed = played_by({still_of("globe")}, drop + "1.5 press left\n", "3").image,
                moved =
                    played_by({still_of("globe")}, drop + "1.4 move 160 121\n1.5 press left\n", "3").image,
                rested = played_by({still_of("globe")}, drop, "3").image;
    const PicturePart finger{130, 90, 190, 150};
    EXPECT_GT(differences(moved, rested, finger), 100);
    EXPECT_GT(differences(pressed, rested, finger), 100);
}

TEST(EmptyWindow, TakesKeysAndTouches) {
    const std::string there = "0.9 screenshot there.png\n";
    const auto stays = [&](const std::string& script) {
        return std::ranges::count(played_by({}, script + there, "1.2").files, "there.png") > 0;
    };
    const std::string at = "160 25";  // of the box that tells what went wrong
    EXPECT_FALSE(stays("0.3 key escape\n"));
    EXPECT_TRUE(contains(played_by({}, "0.2 play-pause\n", "0.4").outcome.err,
                         "there is no clip yet: drop one on the window"));
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

TEST(EmptyWindow, ShowsWhyClipFailed) {
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
    EXPECT_TRUE(contains(played.error().message, "film.mkv"));
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

TEST(EmptyWindow, ReopensLostGpu) {
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

/// A disk that does not answer costs no picture, and the window does not wait for it at the end. (Were the
/// folder listed by the window, the test would end after ten seconds, with fewer pictures.)
TEST(DroppedFolder, IsListedInBackground) {
    const TemporaryFolder folder;
    struct Disk {
        std::atomic<bool> is_asked{false}, answers{false};
    };
    const auto disk = std::make_shared<Disk>();
    PlayOptions options = headless_by_cpu(still_of("globe"));
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

// Pressed while the next clip is being opened: pause, which means the clip that comes.

/// The second of two clips, a globe that turns, is opened only once there is a picture of 1.5 s, so that
/// earlier keys come while it is being opened.
class NextClip : public ::testing::Test {
protected:
    void SetUp() override {
        // 30 s, in which any machine has taken the last picture: at a clip's end the button says play.
        for (const auto& [scene, clip] : {std::pair("bumps", first_), {"globe", second_}}) {
            const auto made = run_touchable(
                {"make", scene, clip.string(), "--size", "160x120", "--frames", "120", "--rate", "4"});
            ASSERT_EQ(made.code, 0) << made.err;
        }
    }
    struct Seen {
        Image before, first, later;  ///< the clip that was there; the one that came, and again
    };
    /// The pictures of a run by this script.
    Seen seen(const std::string& script) {
        PlayOptions options = headless_by_cpu(first_);
        options.next_clips.emplace_back().file = second_;
        const std::string taken = picture("taken");
        std::filesystem::remove(taken);
        options.session.late_playback = [taken, openings = std::make_shared<int>(0)] {
            if ((*openings)++ == 1)
                for (int k = 0; k < 60'000 && !std::filesystem::exists(taken); ++k)
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return std::vector<PlaybackCommand>();
        };
        options.existing = Existing::replace;
        options.kiosk = kiosk_;
        options.script =
            inputs_of(script + "1.5 screenshot " + taken + "\n3.5 screenshot " + picture("first") +
                      "\n4.0 screenshot " + picture("later") + "\n4.1 quit\n");
        const auto played = play_in_window(options);
        EXPECT_TRUE(played) << played.error().message;
        return {image("before"), image("first"), image("later")};
    }
    std::string picture(const std::string& name) const { return (folder_ / name).string() + ".png"; }
    Image image(const std::string& name) const {
        auto read = read_image(picture(name));
        if (!read) return {};
        return std::move(*read);
    }
    static constexpr PicturePart middle{60, 40, 260, 180};
    const TemporaryFolder folder_;
    std::filesystem::path first_ = folder_ / "bumps.mkv", second_ = folder_ / "globe.mkv";
    std::optional<PlayOptions::Kiosk> kiosk_;
};

TEST_F(NextClip, ComesPaused) {
    const Seen paused = seen("0.3 next\n0.6 key space\n0.9 screenshot " + picture("before") + "\n");
    EXPECT_GT(differences(paused.before, paused.first, middle), 3000) << "no other clip came";
    EXPECT_EQ(differences(paused.first, paused.later, middle), 0);
}

TEST_F(NextClip, PlaysUnlessPaused) {
    for (const char* const script :
         {"0.3 next\n", "0.3 next\n0.6 key space\n0.9 key space\n", "0.2 key space\n0.3 next\n",
          "0.2 key space\n0.3 next\n0.6 key space\n", "0.1 seek 29.9\n1.4 key space\n"}) {
        const Seen playing = seen(script);
        EXPECT_GT(differences(image("taken"), playing.first, middle), 3000)
            << script << "brought no other clip";
        EXPECT_GT(differences(playing.first, playing.later, middle), 500) << script;
    }
}

TEST_F(NextClip, PlaysForNextKioskVisitor) {
    std::swap(first_, second_);
    kiosk_ = PlayOptions::Kiosk();
    kiosk_->times = {.invite_s = 20, .reset_s = 0.8};
    const Seen playing = seen("0.2 next\n0.3 next\n0.5 key space\n");
    EXPECT_GT(differences(playing.first, playing.later, middle), 500);
}

}  // namespace
}  // namespace touchable::test
