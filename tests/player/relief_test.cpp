// SPDX-License-Identifier: Apache-2.0
// `touchable relief`, as a person calls it.

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/clip/clip.hpp"
#include "engine/clip/clip_file.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "tests/clip/made_clip.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

class Relief : public ::testing::Test {
protected:
    Relief() { make_clip("globe", at("globe.mkv"), {"--size", "96x64", "--frames", "4"}); }
    std::string at(const std::string& name) const { return folder_ / name; }

    TemporaryFolder folder_;
};

TEST_F(Relief, AddsHeightsToClip) {
    const Outcome run = succeed({"relief", at("globe.mkv"), at("relief.mkv"), "--max-height", "2"});
    EXPECT_PRED2(says, run.out, "colour  every value kept (h264)");
    for (const char* told :
         {"relief: the largest height stands for details of", "relief: a pixel is", "heights change by"})
        EXPECT_PRED2(says, run.out, told);
    auto clip = open_clip(at("relief.mkv"));
    ASSERT_TRUE(clip) << clip.error().message;
    // The globe's radius is 32 mm of the hand.
    EXPECT_NEAR((*clip)->scene().height_coding.max_height * *(*clip)->scene().device_metres_per_unit, 0.002,
                1e-9);
    const auto first = (*clip)->next();
    ASSERT_TRUE(first && *first);
    EXPECT_FALSE((*first)->height.empty());
    // A clip that has relief already gets another.
    const Outcome again = run_touchable({"relief", at("relief.mkv"), at("relief.mkv")});
    EXPECT_EQ(again.code, 2) << again.err;
    const Outcome other = succeed({"relief", at("relief.mkv"), at("other.mkv"), "--amount", "0", "--invert"});
    auto flat = must(open_clip(at("other.mkv")));
    const auto level = flat->next();
    ASSERT_TRUE(level && *level);
    for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 96; ++x) EXPECT_EQ((*level)->height.sample(x, y), 128);
}

TEST_F(Relief, ResumesBatchIntoFolder) {
    fs::copy_file(at("globe.mkv"), at("other.mkv"));
    std::ofstream(at("broken.mkv")) << "nothing";
    const std::vector<std::string> words{"relief", at("globe.mkv"), at("broken.mkv"), at("other.mkv"),
                                         at("out") + "/"};
    const Outcome run = run_touchable(words);
    EXPECT_EQ(run.code, 3);
    EXPECT_PRED2(says, run.err, "broken.mkv");
    EXPECT_PRED2(says, run.err, "1 of 3 clips were not made");
    ASSERT_TRUE(fs::exists(at("out/globe.mkv")));
    ASSERT_TRUE(fs::exists(at("out/other.mkv")));
    fs::remove(at("out/other.mkv"));
    const auto made = fs::last_write_time(at("out/globe.mkv"));
    const Outcome again = succeed({"relief", at("globe.mkv"), at("other.mkv"), at("out") + "/"});
    EXPECT_PRED2(says, again.out, "globe.mkv: is there already");
    EXPECT_EQ(fs::last_write_time(at("out/globe.mkv")), made);
    EXPECT_TRUE(fs::exists(at("out/other.mkv")));
}

TEST_F(Relief, RejectsAmbiguousBatchOutput) {
    expect_failure({"relief", at("globe.mkv"), at("other.mkv"), at("third.mkv")}, 2, "is no folder");
    fs::create_directory(at("a"));
    fs::copy_file(at("globe.mkv"), at("a/globe.mkv"));
    expect_failure({"relief", at("globe.mkv"), at("a/globe.mkv"), at("out") + "/"}, 2, "would both be");
    EXPECT_FALSE(fs::exists(at("out")));
    // Without its slash a folder is a clip of pictures, as a shell gives all that is there.
    expect_failure({"relief", at("globe.mkv"), at("a")}, 2, "does not end in .mkv");
    expect_failure({"relief", at("globe.mkv"), at("globe.mkv"), at("a")}, 2, "is no folder");
    EXPECT_EQ(names_in(at("a")), std::vector<std::string>{"globe.mkv"});
}

TEST_F(Relief, BatchNeverReplacesInput) {
    fs::create_directory(at("a"));
    fs::copy_file(at("globe.mkv"), at("a/other.mkv"));
    for (const bool overwrite : {false, true}) {
        std::vector<std::string> words{"relief", at("globe.mkv"), at("a/other.mkv"), at("a") + "/"};
        if (overwrite) words.emplace_back("--overwrite");
        expect_failure(words, 2, "is one of the clips");
        EXPECT_EQ(names_in(at("a")), std::vector<std::string>{"other.mkv"});
    }
}

TEST_F(Relief, OfWorldSetsWorldHeight) {
    succeed({"relief", at("globe.mkv"), at("relief.mkv"), "--max-height", "2", "--of-world"});
    auto clip = must(open_clip(at("relief.mkv")));
    EXPECT_NEAR(clip->scene().height_coding.max_height * clip->scene().metres_per_unit, 0.002, 1e-9);
}

TEST_F(Relief, TakesHapticMap) {
    succeed({"convert", at("globe.mkv"), at("planes")});
    const Outcome run =
        succeed({"relief", at("globe.mkv"), at("relief.mkv"), "--haptic", at("planes/haptic_000002.png")});
    EXPECT_PRED2(says, run.out, "colour  every value kept (h264)");
}

/// The command makes a clip of the settings that were tried in a window.
TEST_F(Relief, WindowPrintsMatchingCommand) {
    std::ofstream(at("kept.json")) << R"({"a": {"relief": 60, "relief-fine": 30, "relief-invert": "on"}})";
    const Outcome window = succeed({"play", at("globe.mkv"), "--headless", "--seconds", "0.1", "--settings",
                                    at("kept.json"), "--size", "160x120"});
    const std::string wanted = "touchable relief " + at("globe.mkv") +
                               " OUT.mkv --amount 60 --max-height 0.5 --fine 30 --medium 70 --coarse 40 "
                               "--invert";
    EXPECT_PRED2(says, window.out, wanted);
    succeed({"relief", at("globe.mkv"), at("kept.mkv"), "--amount", "60", "--max-height", "0.5", "--fine",
             "30", "--medium", "70", "--coarse", "40", "--invert"});
}

TEST_F(Relief, RejectsInvalidOptions) {
    make_clip("bumps", at("grey.mkv"), {"--size", "32x24", "--frames", "1"});
    const auto expect = [&](const std::vector<std::string>& words, int code, const std::string& why) {
        expect_failure(words, code, why);
        EXPECT_FALSE(fs::exists(at("out.mkv")));
    };
    expect({"relief", at("grey.mkv"), at("out.mkv")}, 3, "has no colour");
    expect({"relief", at("globe.mkv"), at("out.mp4")}, 2, "does not end in .mkv");
    expect({"relief", at("globe.mkv"), at("out.mkv"), "--height", at("none.png")}, 2, "--height");
    expect({"relief", at("globe.mkv"), at("out.mkv"), "--fine", "500"}, 2, "--fine");
    expect({"relief", at("globe.mkv"), at("out.mkv"), "--max-height", "0"}, 2, "--max-height");
    expect({"relief", at("none.mkv"), at("out.mkv")}, 3, "none.mkv");
}

// Depth that a network guessed picture by picture, as it lies on disk, under a finger at rest.

/// A wall, in pictures to which a network gave a scale each.
class PumpingFolder : public ::testing::Test {
protected:
    PumpingFolder() {
        std::filesystem::create_directory(pictures());
        for (int n = 0; n < 24; ++n) {
            Random numbers(static_cast<std::uint64_t>(n) + 5);
            const double scale = 0.9 + 0.01 * numbers.below(40), shift = 0.001 * numbers.below(60);
            const RawFrame frame = guessed_frame({}, {scale, shift}, 2, true, n);
            write("depth_", n, frame.depth);
            write("rgb_", n, frame.colour);
        }
    }
    std::filesystem::path pictures() const { return folder_ / "guessed"; }
    void write(const char* name, int number, const PlaneView& plane) const {
        std::array<char, 32> file{};
        std::snprintf(file.data(), file.size(), "%s%03d.png", name, number);
        EXPECT_TRUE(write_png(pictures() / file.data(), plane));
    }
    /// How much the force changes from frame to frame, RMS, N: 1 s after the finger came to rest.
    double pulse(const std::string& align) const {
        const std::string csv = folder_ / "forces.csv";
        touch({pictures(), "--preset", "relative-inverse", "--align", align, "--filters", "off", "--loop",
               "0", "0.7", "--hand", "press:x=0.3,y=0.6,depth=30,lift=0,period=60", "--seconds", "10",
               "--forces", csv});
        const auto rows = read_forces(csv);
        double sum = 0;
        int count = 0;
        for (std::size_t tick = 8033; tick < rows.size(); tick += 33, ++count) {
            const double changed =
                length(rows[tick].vector("force")) - length(rows[tick - 33].vector("force"));
            sum += changed * changed;
        }
        return std::sqrt(sum / count);
    }

    TemporaryFolder folder_;
};

TEST_F(PumpingFolder, AlignmentReducesPulseTwentyfold) {
    const double before = pulse("off"), after = pulse("auto");
    std::cout << "a finger at rest: pulse " << before << " N from frame to frame, aligned " << after
              << " N\n";
    EXPECT_GT(before, 0.05);
    EXPECT_GE(before, 20 * after);
}

TEST_F(PumpingFolder, ReplaysWithRecordedAlignment) {
    const std::vector<std::string> info{"info", pictures(), "--preset", "relative-inverse"};
    const Outcome told = run_touchable(info);
    EXPECT_PRED2(says, told.out, "depth is aligned, as each frame had a scale of its own");
    Words off = plus(info, {"--align", "off"});
    EXPECT_EQ(run_touchable(off).out.find("depth is aligned"), std::string::npos);
    for (const std::string align : {"off", "auto", "on"}) {
        const std::string recording = folder_ / ("run-" + align + ".touch");
        succeed({"touch", pictures(), "--preset", "relative-inverse", "--align", align, "--seconds", "0.5",
                 "--record", recording});
        succeed({"touch", "--replay", recording});
        EXPECT_EQ(run_touchable({"touch", "--replay", recording, "--align", "off"}).code, 2);
    }
}

/// Once it is a clip nothing has to be aligned any more; a clip that was made before can be.
TEST_F(PumpingFolder, ConvertedClipIsAligned) {
    const std::string clip = folder_ / "aligned.mkv", raw = folder_ / "raw.mkv";
    for (const auto& [file, align] : {std::pair{clip, "auto"}, {raw, "off"}})
        succeed({"convert", pictures(), file, "--preset", "relative-inverse", "--align", align});
    const std::string direct = force_hash({pictures(), "--preset", "relative-inverse", "--seconds", "0.5"});
    EXPECT_EQ(force_hash({clip, "--seconds", "0.5"}), direct);
    EXPECT_NE(force_hash({raw, "--seconds", "0.5"}), direct);
    // (Lossy colour tells a little else of what stands still.)
    const Outcome later = run_touchable({"info", raw, "--align", "on"});
    EXPECT_PRED2(says, later.out, "depth is aligned");
    EXPECT_EQ(run_touchable({"info", raw}).out.find("depth is aligned"), std::string::npos);
}

/// Commands that write a clip anew copy the packets of unchanged planes; aligned depth is not unchanged.
TEST_F(PumpingFolder, RewritingCommandsAlignDepth) {
    const std::string raw = folder_ / "raw.mkv";
    succeed({"convert", pictures(), raw, "--preset", "relative-inverse", "--align", "off"});
    const auto hash_of_depth = [&](const std::string& file, DepthAlignment alignment) {
        auto clip = open_clip(file, {}, {}, Colour::wanted, alignment);
        EXPECT_TRUE(clip) << file;
        ByteHash hash;
        while (clip) {
            const auto frame = (*clip)->next();
            if (!frame || !*frame) break;
            const PlaneView& depth = (*frame)->depth;
            for (int y = 0; y < depth.height; ++y) hash.add(depth.row(y), std::size_t{2} * depth.width);
        }
        return hash.value();
    };
    const std::uint64_t stored = hash_of_depth(raw, DepthAlignment::off);
    const std::uint64_t aligned = hash_of_depth(raw, DepthAlignment::on);
    EXPECT_NE(stored, aligned);
    for (const std::string command : {"convert", "relief", "materials"}) {
        const std::string as_stored = folder_ / (command + "-auto.mkv"), on = folder_ / (command + "-on.mkv");
        succeed({command, raw, as_stored});
        EXPECT_EQ(hash_of_depth(as_stored, DepthAlignment::off), stored) << command;
        succeed({command, raw, on, "--align", "on"});
        EXPECT_EQ(hash_of_depth(on, DepthAlignment::off), aligned) << command;
    }
}

// Holes of a recording that other frames saw, filled on request.

constexpr const char* filled_words = "holes are filled from frames that saw what is behind: ";

/// A hand over a table, in pictures of millimetres and their colour.
class RecordedTable : public ::testing::Test {
protected:
    RecordedTable() {
        for (int n = 0; n < count; ++n) {
            const RawFrame frame = StillScene{}.frame(n);
            write("depth", n, frame.depth);
            write("rgb", n, frame.colour);
        }
        std::ofstream(scene()) << R"({"touchable_scene": 1, "width": 160, "height": 120,
            "camera": {"fx": 150, "fy": 150, "cx": 79.5, "cy": 59.5},
            "depth": {"coding": "metric", "scale": 1, "far": 4000, "invalid": [0]},
            "filter": {"median": 0, "fill_holes": 0, "temporal": "off", "terraces": "off"},
            "folder": {"depth": "depth_%03d.png", "colour": "rgb_%03d.png"}})";
    }
    static constexpr int count = 20;
    std::string scene() const { return folder_ / "scene.json"; }
    void write(const char* name, int number, const PlaneView& plane) const {
        std::array<char, 32> file{};
        std::snprintf(file.data(), file.size(), "%s_%03d.png", name, number);
        EXPECT_TRUE(write_png(folder_ / file.data(), plane));
    }
    Outcome run(Words words, bool filled = true) const {
        if (filled) words.insert(words.end(), {"--fill-from-motion", "on"});
        return run_touchable(words);
    }

    TemporaryFolder folder_;
};

TEST_F(RecordedTable, ReportsFilledHoles) {
    const Outcome told = run({"info", scene()});
    EXPECT_PRED2(says, told.out, filled_words);
    EXPECT_PRED2(says, told.out, "(of 20 frames)");
    EXPECT_EQ(run({"info", scene()}, false).out.find("filled from"), std::string::npos);
    EXPECT_FALSE(says(run_touchable({"info", scene(), "--fill-from-motion", "off"}).out, "filled from"));
    expect_failure({"info", scene(), "--fill-from-motion", "maybe"}, 2,
                   "maybe is not allowed; must be off or on");
}

TEST_F(RecordedTable, ReplaysWithRecordedFilling) {
    const Words words{scene(), "--seconds", "0.5", "--hand",
                      "press:x=0.42,y=0.42,depth=30,lift=5,period=0.4"};
    const auto touched = [&](const std::string& fill, const std::string& recording) {
        return force_hash(plus(words, {"--fill-from-motion", fill, "--record", recording}));
    };
    const std::string on = folder_ / "on.touch", off = folder_ / "off.touch";
    const std::string hash = touched("on", on);
    EXPECT_NE(touched("off", off), hash);
    const Outcome replayed = succeed({"touch", "--replay", on, "--verbose"});
    EXPECT_PRED2(says, replayed.out + replayed.err, filled_words) << replayed.out << replayed.err;
    succeed({"touch", "--replay", off});
    EXPECT_EQ(run({"touch", "--replay", off}).code, 2);
}

/// Its depth is stored anew, also where the clip could be copied; what was filled stays filled.
TEST_F(RecordedTable, ConversionStoresFilledDepth) {
    const std::string raw = folder_ / "raw.mkv", once = folder_ / "once.mkv";
    ASSERT_EQ(run({"convert", scene(), raw}, false).code, 0);
    const Outcome converted = run({"convert", raw, once});
    ASSERT_EQ(converted.code, 0) << converted.err;
    EXPECT_PRED2(says, converted.out + converted.err, filled_words) << converted.out << converted.err;
    auto opened = must(open_clip(raw));
    const auto filled_now = test::read_all(*filled(std::move(opened)));
    auto written = must(open_clip(once));
    const auto stored = must(test::read_all(*written));
    ASSERT_EQ(stored.size(), filled_now->size());
    for (std::size_t n = 0; n < stored.size(); ++n) {
        EXPECT_TRUE(same_samples(stored[n].depth, (*filled_now)[n].depth)) << n;
        EXPECT_FALSE(same_samples(stored[n].depth, StillScene{}.frame(static_cast<std::int64_t>(n)).depth))
            << n;
        EXPECT_EQ(stored[n].filled, nullptr);
    }
}

/// The clip's own view has a pixel for each pixel; the legend covers a corner.
TEST_F(RecordedTable, ShowsFilledPixels) {
    const std::string picture = folder_ / "validity.png";
    for (const std::string builder : {"cpu", "reference"}) {
        const Outcome drawn = run({"export", scene(), "--frame", "9", "--picture", picture, "--view", "own",
                                   "--show", "validity", "--picture-size", "640x480", "--painter", "cpu",
                                   "--builder", builder, "--overwrite"});
        ASSERT_EQ(drawn.code, 0) << drawn.err;
        const auto seen = must(read_image(picture));
        auto opened = must(open_clip(scene()));
        const auto clip = filled(std::move(opened));
        ASSERT_EQ(message(clip->seek(9)), "");
        const RawFrame frame = **clip->next();
        // Purple has more of red than of green, and of blue; depth that was measured there is blue.
        int purple = 0, marked = 0;
        for (int y = 3; y < 70; ++y)
            for (int x = 3; x < 150; ++x) {
                const std::uint8_t* rgb = seen.view().row(4 * y + 2) + 3 * (4 * x + 2);
                const bool is_purple = rgb[0] > rgb[1] + 30 && rgb[2] > rgb[1] + 15;
                purple += is_purple;
                marked += is_marked(frame, x, y);
            }
        EXPECT_GT(marked, 100);
        EXPECT_NEAR(purple, marked, 0.15 * marked) << builder;
    }
}

TEST_F(RecordedTable, RejectsFillingForCamera) {
    const std::string raw = folder_ / "raw.mkv";
    ASSERT_EQ(run({"convert", scene(), raw}, false).code, 0);
    const Outcome refused = run({"touch", "--live", "--camera", "replay:" + raw, "--seconds", "0.1"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_PRED2(says, refused.err,
                 "is touched as a camera, of which no later frame can tell what is behind a hole");
}

/// A wall at 1000 mm as a depth camera sees it, with a hole in it, and a finger that goes into the hole,
/// behind its left side, up and out again.
class Holes : public ::testing::Test {
protected:
    static constexpr int width = 96, height = 64, first = 40, last = 63;  // columns of the hole

    Holes() {
        std::vector<std::uint16_t> depths(width * height, 1000);
        for (int y = 20; y < 44; ++y)
            for (int x = first; x <= last; ++x) depths[static_cast<std::size_t>(y * width + x)] = 0;
        PlaneView view;
        view.data = reinterpret_cast<const std::uint8_t*>(depths.data());
        view.width = width;
        view.height = height;
        view.bytes_per_sample = 2;
        view.stride = 2 * width;
        EXPECT_TRUE(write_png(folder / "depth.png", view));
        std::ofstream(hand_file()) << "t_s,x,y,z\n0,20,0,-950\n0.2,20,0,-1030\n0.7,-80,0,-1030\n"
                                      "1.5,-80,10,-1030\n2,20,10,-1030\n2.2,20,10,-950\n";
    }
    /// `stiffness`: the scene's member, as it is written there.
    std::string scene(const std::string& stiffness = "") const {
        const std::string file = folder / ("scene" + stiffness + ".json");
        std::ofstream(file) << R"({"touchable_scene": 1, "width": 96, "height": 64,
            "camera": {"fx": 400, "fy": 400, "cx": 47.5, "cy": 31.5}, "device_metres_per_unit": 0.0005,
            "depth": {"coding": "metric", "scale": 1, "far": 1500, "invalid": [0]},)"
                            << (stiffness.empty() ? "" : "\"hole_stiffness\": " + stiffness + ",")
                            << R"("folder": {"depth": "depth.png"}})";
        return file;
    }
    std::string hand_file() const { return folder / "hand.csv"; }
    Words words(const std::string& scene_file, const Words& more = {}) const {
        return plus(
            {scene_file, "--hand", "csv:" + hand_file() + ":columns=x+y+z,space=scene", "--forces", csv()},
            more);
    }
    std::string csv() const { return folder / "forces.csv"; }

    TemporaryFolder folder;
};

TEST_F(Holes, ReportTimeFingersAreCaught) {
    const auto report = touch(words(scene()));
    // On the wall's triangles, between the last valid column and the first invalid one, or deeper in.
    std::int64_t caught = 0, limited = 0, contact = 0, row_length = 0, longest = 0;
    for (const ForcesRow& row : read_forces(csv())) {
        const bool in_hole = row["contact"] == 1 && row["pixel_x"] > first - 1 && row["pixel_x"] < last + 1;
        caught += in_hole;
        limited += in_hole && (static_cast<int>(row["guard"]) & 2) != 0;
        contact += row["contact"] == 1;
        row_length = in_hole ? row_length + 1 : 0;
        longest = std::max(longest, row_length);
    }
    ASSERT_GT(caught, 1000);
    ASSERT_GT(limited, 500);
    const auto& holes = report["hole_contact"];
    EXPECT_EQ(holes["finger_ticks"], caught);
    EXPECT_EQ(holes["longest_ticks"], longest);
    EXPECT_EQ(holes["force_limited_ticks"], limited);
    EXPECT_DOUBLE_EQ(holes["contact_pct"],
                     100.0 * static_cast<double>(caught) / static_cast<double>(contact));

    const std::string table =
        run_touchable(plus({"touch"}, words(scene(), {"--overwrite", "--verbose"}))).out;
    EXPECT_PRED2(says, table, "s behind walls of missing depth (");
    EXPECT_PRED2(says, table, "hole_stiffness in the scene file makes them soft");
}

TEST_F(Holes, SoftStiffnessLimitsForce) {
    const auto hard = touch(words(scene())), soft = touch(words(scene("0.1")));
    EXPECT_NEAR(hard["force_n"]["max"], 10, 1e-9);
    EXPECT_LT(soft["force_n"]["max"], 0.1 * 50);  // 100 units behind the wall are 50 mm
    EXPECT_EQ(soft["hole_contact"]["force_limited_ticks"], 0);
    EXPECT_EQ(soft["hole_contact"]["finger_ticks"], hard["hole_contact"]["finger_ticks"]);
    for (const auto& note : soft["notes"])
        EXPECT_EQ(note.get<std::string>().find("hole_stiffness"), std::string::npos) << note;
}

TEST_F(Holes, AreUnreportedWhenAbsent) {
    const std::string clip = folder / "bumps.mkv";
    make_clip("bumps", clip, {"--size", "72x48", "--frames", "2"});
    const auto holes = touch({clip, "--seconds", "0.6"})["hole_contact"];
    for (const char* figure : {"finger_ticks", "contact_pct", "longest_ticks", "force_limited_ticks"})
        EXPECT_EQ(holes[figure], 0) << figure;
    EXPECT_FALSE(says(run_touchable({"touch", clip, "--seconds", "0.6"}).out, "caught in holes"));
}

TEST_F(Holes, InfoReportsStiffness) {
    const Outcome said = run_touchable({"info", scene("0.1")}),
                  json = run_touchable({"info", scene("0.1"), "--json"});
    EXPECT_PRED2(says, said.out, "walls of missing depth have 0.1 N/mm");
    EXPECT_EQ(nlohmann::json::parse(json.out)["hole_stiffness_n_per_mm"], 0.1);
    EXPECT_EQ(run_touchable({"info", scene()}).out.find("missing depth"), std::string::npos);
}

TEST_F(Holes, RecordingKeepsStiffness) {
    const std::string file = folder / "run.rec";
    const auto recorded = touch(words(scene("0.1"), {"--record", file}));
    RecordingBytes raw(file_contents(file));
    auto facts = raw.facts();
    EXPECT_EQ(facts["scene"]["hole_stiffness"], 0.1);
    // The recording's stiffness counts, whatever the scene file says by now.
    scene();
    std::filesystem::rename(folder / "scene.json", folder / "scene0.1.json");
    const Outcome same = succeed({"touch", "--replay", file});
    EXPECT_PRED2(says, same.out, recorded["force_hash"].get<std::string>());
    facts["scene"].erase("hole_stiffness");
    raw.set_facts(facts.dump());
    std::ofstream(file, std::ios::binary) << raw.bytes();
    EXPECT_EQ(run_touchable({"touch", "--replay", file}).code, 6);
}

// The temporal filter makes a frame of all frames before it: a builder has to see them all, in order.

class TemporalFilter : public ::testing::Test {
protected:
    std::string clip() const { return folder / "clip.mkv"; }
    Words with(const Words& more) const {
        return plus({clip(), "--hand", "wander", "--fingers", "2", "--seconds", "0.6"}, more);
    }
    std::string hash(const Words& more) const { return force_hash(with(more)); }

    TemporaryFolder folder;
};

TEST_F(TemporalFilter, MatchesAcrossBuilders) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "12"});
    const std::string on = hash({"--temporal", "5"});
    EXPECT_NE(on, hash({}));
    EXPECT_EQ(hash({"--temporal", "off"}), hash({}));
    EXPECT_NE(on, hash({"--temporal", "2"}));
    EXPECT_NE(hash({"--temporal", "1,2e-6"}), hash({"--temporal", "1"})) << "a metre away: 3 and 1";
    EXPECT_EQ(on, hash({"--temporal", "5,0"}));
    for (const char* builder : {"reference", "vulkan"})
        EXPECT_EQ(hash({"--temporal", "5", "--builder", builder}), on) << builder;
}

TEST_F(TemporalFilter, KeepsStillClipUnchanged) {
    make_clip("bumps", clip(), {"--size", "64x48", "--frames", "12"});
    EXPECT_EQ(hash({"--temporal", "5"}), hash({}));
}

TEST_F(TemporalFilter, OptionOverridesSceneFile) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "12"});
    auto scene = scene_of(clip());
    scene["filter"]["temporal"] = "on";
    scene["filter"]["temporal_noise"] = {5, 0};
    std::ofstream(folder / "noisy.json") << scene;
    const std::string file = folder / "noisy.json";
    EXPECT_EQ(hash({"--scene", file}), hash({"--temporal", "5"}));
    EXPECT_EQ(hash({"--scene", file, "--temporal", "off"}), hash({}));
    EXPECT_EQ(hash({"--scene", file, "--temporal", "2"}), hash({"--temporal", "2"}));
    scene["filter"]["temporal"] = "off";
    std::ofstream(file) << scene;
    EXPECT_EQ(hash({"--scene", file, "--temporal", "on"}), hash({"--temporal", "5"}));
    const Outcome info = run_touchable({"info", clip(), "--scene", file});
    EXPECT_PRED2(says, info.out, "filters      none (stated)");
    const Outcome on = run_touchable({"info", clip(), "--scene", file, "--temporal", "on"});
    EXPECT_PRED2(says, on.out, "temporal for 5 mm (stated)");
}

TEST_F(TemporalFilter, LiveSessionReplays) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "12"});
    const auto live = touch(with({"--temporal", "5", "--live", "--record", folder / "live.rec"}));
    for (const char* builder : {"cpu", "reference"}) {
        const auto replay = touch({"--replay", folder / "live.rec", "--builder", builder});
        EXPECT_EQ(replay["force_hash"], live["force_hash"]) << builder;
    }
    expect_failure({"touch", "--replay", folder / "live.rec", "--builder", "lazy"}, 2);
}

TEST_F(TemporalFilter, ExportedFrameIncludesEarlierFrames) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "8"});
    const auto exported = [&](const char* frames, const char* which, const Words& more,
                              const std::string& out) {
        succeed(plus({"export", clip(), frames, which, "--out", folder / out}, more));
    };
    exported("--frames", "all", {"--temporal", "5"}, "all");
    exported("--frames", "5-6", {"--temporal", "5"}, "few");
    exported("--frame", "6", {"--temporal", "5"}, "one");
    exported("--frame", "6", {}, "off");
    const std::string all = file_contents(folder / "all/6/codes.png");
    EXPECT_EQ(file_contents(folder / "few/6/codes.png"), all);
    EXPECT_EQ(file_contents(folder / "one/codes.png"), all);
    EXPECT_NE(file_contents(folder / "off/codes.png"), all);
}

/// A motion that dips into the first frame's surface early on and is above it for the rest.
std::string lifted_hand(const std::string& file) {
    std::ofstream rows(file);  // tenths of a millimetre
    for (int k = 0; k < 100; ++k) rows << k % 2 << ",0," << (k == 10 ? 0 : 400) << '\n';
    return "csv:" + file + ":columns=1+2+3,rate=50,scale=0.0001,contact=0.01";
}

// Two clips that end alike. The finger is in the air by then, so that pictures show the surface alone.
TEST_F(TemporalFilter, PictureIncludesEarlierFrames) {
    make_clip("moving", clip(), {"--size", "64x48", "--frames", "8"});
    succeed({"export", clip(), "--frames", "all", "--out", folder / "all"});
    auto scene = scene_of(clip());
    scene["folder"] = {{"depth", "d_%d.png"}};
    const std::vector<std::string> moves{"6", "0", "0", "6"};
    for (const char* name : {"moves", "stands"}) {
        const fs::path to = folder.path() / name;
        fs::create_directory(to);
        for (std::size_t n = 0; n < moves.size(); ++n) {
            const std::string from = to.filename() == "moves" ? moves[n] : "6";
            fs::copy_file(folder / ("all/" + from + "/depth.png"), to / ("d_" + std::to_string(n) + ".png"));
        }
        std::ofstream(to / "scene.json") << scene;
    }
    const std::string hand = lifted_hand(folder / "hand.csv");
    const auto picture = [&](const std::string& name, const char* temporal) {
        succeed({"touch", folder / name, "--hand", hand, "--temporal", temporal, "--picture",
                 folder / "p.png", "--picture-size", "96x64", "--picture-at", "1.9", "--overwrite"});
        return file_contents(folder / "p.png");
    };
    EXPECT_EQ(picture("moves", "off"), picture("stands", "off"));
    EXPECT_NE(picture("moves", "9"), picture("stands", "9"));
    EXPECT_EQ(picture("stands", "9"), picture("stands", "off"));
}

// Filters that a clip leaves open are chosen by what its first frames tell, wherever it is touched.

constexpr int columns = 96, rows = 64;

/// Millimetres of a noisy camera, with specks.
void write_noisy_clip(const std::string& file) {
    Scene scene;
    scene.width = columns;
    scene.height = rows;
    scene.camera = {80, 80, 47.5, 31.5};
    scene.depth_bits = 16;
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 1;
    scene.depth.far = 1000;
    scene.depth.code_max = 65535;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    SceneDescription described(scene);
    described.unstated.filters = all_unstated;
    auto writer = must(create_clip(file, described));
    SplitMix64 random(5);
    for (int n = 0; n < 20; ++n) {
        auto codes = std::make_shared<std::vector<std::uint16_t>>();
        for (int y = 0; y < rows; ++y)
            for (int x = 0; x < columns; ++x) {
                const double noise = random.within(-4, 4) + random.within(-4, 4);
                const double depth = 400 + x + 0.5 * y + noise;
                codes->push_back(random.next() % 300 == 0 ? 0 : static_cast<std::uint16_t>(depth));
            }
        RawFrame frame;
        frame.number = n;
        frame.depth = {
            reinterpret_cast<const std::uint8_t*>(codes->data()), 2 * columns, columns, rows, 2, 1};
        frame.storage = codes;
        ASSERT_TRUE(writer->write(frame));
    }
    ASSERT_TRUE(writer->finish());
}

class Filters : public testing::Test {
protected:
    void SetUp() override { write_noisy_clip(clip()); }
    std::string clip() const { return folder / "noisy.mkv"; }
    nlohmann::json touched(const Words& more) const {
        return touch(plus({clip(), "--hand", "press", "--seconds", "0.7"}, more));
    }
    std::string hash(const Words& more) const { return touched(more)["force_hash"]; }

    TemporaryFolder folder;
};

TEST_F(Filters, AreChosenByFirstFrames) {
    const auto report = touched({});
    const auto& filters = report["filters"];
    EXPECT_EQ(filters["median"], 3);
    EXPECT_EQ(filters["fill_holes"], 2);
    EXPECT_EQ(filters["terraces"], true);
    EXPECT_EQ(filters["temporal"], true);
    EXPECT_EQ(filters["chosen"], (Words{"median", "fill_holes", "terraces", "temporal", "flying_pixels"}));
    const double sigma = filters["measured"]["noise_at_median"];
    EXPECT_NEAR(sigma, 3.27, 0.3) << "of two uniform numbers from -4 to 4";
    const std::string words = filters["in_words"];
    EXPECT_PRED2(says, words, "(noise 3.");
    const Outcome said = run_touchable({"touch", clip(), "--seconds", "0.1", "--verbose"});
    EXPECT_PRED2(says, said.out, "  filters ");
    EXPECT_PRED2(says, run_touchable({"info", clip()}).out, "median 3x3 (");
}

TEST_F(Filters, OneOptionSetsAll) {
    EXPECT_EQ(hash({"--filters", "auto"}), hash({}));
    const std::string off = hash({"--filters", "off"});
    EXPECT_NE(off, hash({}));
    EXPECT_EQ(off, hash({"--median", "0", "--fill-holes", "0", "--terraces", "off", "--temporal", "off"}));
    EXPECT_EQ(hash({"--filters", "median=3,holes,temporal=5+1e-6"}),
              hash({"--median", "3", "--fill-holes", "2", "--terraces", "off", "--temporal", "5,1e-6"}));
    EXPECT_EQ(hash({"--filters", "off", "--median", "5"}), hash({"--filters", "median"}))
        << "one by one counts last";
    EXPECT_FALSE(touched({"--filters", "off"})["filters"].contains("chosen")) << "nothing was measured";
    const auto info = run_touchable({"info", clip(), "--filters", "terraces", "--json"});
    EXPECT_EQ(nlohmann::json::parse(info.out)["filters"]["terraces"], true);
}

TEST_F(Filters, MatchAcrossBuilders) {
    const std::string chosen = hash({});
    for (const char* builder : {"cpu", "reference", "vulkan"})
        EXPECT_EQ(hash({"--builder", builder}), chosen) << builder;
    const auto lazy = touched({"--builder", "lazy"});
    EXPECT_EQ(lazy["force_hash"], chosen);
    EXPECT_EQ(lazy["builder"], "cpu") << "which can average over time";
    EXPECT_PRED2(says, lazy["builder_why"].get<std::string>(), "lazy");
}

TEST_F(Filters, RecordingKeepsChoice) {
    const std::string recording = folder / "run.rec";
    const std::string chosen = hash({"--record", recording});
    const Outcome again = succeed({"touch", "--replay", recording});
    EXPECT_PRED2(says, again.out, chosen);
}

TEST_F(Filters, ExportedFrameStatesChoice) {
    const Outcome run =
        succeed({"export", clip(), "--frame", "7", "--out", folder / "frame", "--builder", "cpu"});
    EXPECT_PRED2(says, run.err, "median 3x3 (");
    const auto filter = json_in(folder / "frame/scene.json")["filter"];
    EXPECT_EQ(filter["median"], 3);
    EXPECT_EQ(filter["fill_holes"], 2);
    EXPECT_EQ(filter["terraces"], "on");
    EXPECT_EQ(filter["temporal"], "on");
    EXPECT_FALSE(touch({folder / "frame", "--seconds", "0.1"})["filters"].contains("chosen"))
        << "measured once is enough";
}

TEST_F(Filters, GeneratedClipsLeaveThemOpen) {
    make_clip("globe", folder / "globe.mkv", {"--size", "48x32", "--frames", "2"});
    const auto report = touch({folder / "globe.mkv", "--seconds", "0.1"});
    EXPECT_EQ(report["filters"]["chosen"].size(), 5);
    EXPECT_PRED2(says, report["filters"]["in_words"].get<std::string>(), "none needed");
    EXPECT_EQ(report["force_hash"],
              force_hash({folder / "globe.mkv", "--seconds", "0.1", "--filters", "off"}));
}

}  // namespace
}  // namespace touchable::test
