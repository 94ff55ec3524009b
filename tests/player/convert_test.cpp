// SPDX-License-Identifier: Apache-2.0
// Clips in other forms: the same to the touch, or the program reports the loss.

#include <gtest/gtest.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>
#include <tuple>
#include <utility>

#include "engine/clip/clip_file.hpp"
#include "engine/content/scenes.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "player/commands/commands.hpp"
#include "player/session/touch_setup.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

class ConvertCommand : public ::testing::Test {
protected:
    ConvertCommand() { fs::create_directory(folder / "out"); }
    std::string at(const std::string& name) const { return folder / name; }
    void make(const std::string& scene, const std::vector<std::string>& more = {}) const {
        make_clip(scene, at("clip.mkv"), plus({"--size", "64x48", "--frames", "6"}, more));
    }
    /// In this process, which takes a tenth of the time of a program's start.
    static Outcome run_convert(std::vector<std::string> words) {
        CLI::App app;
        Command command;
        add_convert_command(app, command);
        std::ostringstream out;
        std::streambuf* const usual = std::cout.rdbuf(out.rdbuf());
        words.insert(words.begin(), "convert");
        std::reverse(words.begin(), words.end());
        Outcome outcome{0, "", ""};
        try {
            app.parse(words);
            const auto done = command();
            if (!done) outcome = {exit_code(done.error().kind), "", done.error().message};
        } catch (const CLI::ParseError& error) {
            outcome = {2, "", error.what()};
        }
        std::cout.rdbuf(usual);
        outcome.out = out.str();
        return outcome;
    }
    static std::string convert(const std::vector<std::string>& words) {
        const Outcome run = run_convert(words);
        EXPECT_EQ(run.code, 0) << run.err;
        return run.out;
    }
    static std::string hash_of(const std::string& clip) {
        SessionOptions options;
        options.clip.file = clip;
        options.fingers = 2;
        options.ticks = 700;
        auto setup = setup_from_options(options);
        EXPECT_TRUE(setup) << setup.error().message;
        if (!setup) return "";
        TouchSetup& s = **setup;
        TouchFigures figures;
        std::array<TouchSink*, 1> sinks{&figures};
        EXPECT_TRUE(TouchSession(*s.feed, *s.hand, *s.solver, s.options).run(sinks));
        EXPECT_NE(figures.to_json().at("contact_ticks"), 0);
        return figures.force_hash();
    }
    /// There and back, by every way that keeps all.
    void expect_same_forces() const {
        const std::string before = hash_of(at("clip.mkv"));
        for (const Words& words : {Words{at("clip.mkv"), at("folder")},
                                   {at("folder"), at("small.mkv"), "--archive", "small"},
                                   {at("small.mkv"), at("fast.mkv"), "--exact-colour"},
                                   {at("fast.mkv"), at("again") + "/"}}) {
            convert(plus(words, {"--overwrite"}));
            EXPECT_EQ(hash_of(words[1]), before) << words[1];
        }
        EXPECT_EQ(hash_of(at("again/scene.json")), before);
    }
    void expect_refused(const std::vector<std::string>& words, const std::string& fragment,
                        int code = 2) const {
        const Outcome run = run_convert(words);
        EXPECT_EQ(run.code, code) << run.err;
        EXPECT_EQ(run.err.find('\n'), std::string::npos) << run.err;
        EXPECT_PRED2(says, run.err, fragment);
        EXPECT_TRUE(names_in(folder / "out").empty());
    }
    TemporaryFolder folder;
};

TEST_F(ConvertCommand, KeepsForcesAtAnyBitDepth) {
    for (const auto& [scene, bits] : {std::pair{"globe", "8"}, {"globe", "16"}, {"moving", "12"}}) {
        make(scene, {"--bits", bits, "--overwrite"});
        expect_same_forces();
    }
}

/// Depth as filters leave it feels as the clip does by them, in whatever form; only once is it filtered.
TEST_F(ConvertCommand, FilteredDepthFeelsTheSame) {
    make("globe", {"--bits", "8"});
    const std::string before = hash_of(at("clip.mkv"));
    for (const char* form : {"smooth.mkv", "smooth.mp4", "folder", "page"}) {
        Words words{at("clip.mkv"), at(form), "--filtered"};
        if (form == std::string("page")) words.push_back("--web");
        EXPECT_PRED2(says, convert(words), "note    depth was filtered: terraces (") << form;
        EXPECT_EQ(hash_of(at(form)), before) << form;
    }
    convert({at("clip.mkv"), at("stored.mkv"), "--filtered", "--filters", "off"});
    EXPECT_NE(hash_of(at("stored.mkv")), before);
    EXPECT_PRED2(says, convert({at("clip.mkv"), at("depth.npy"), "--filtered", "--allow-lossy"}),
                 "depth   metres as floats of 32 bits, NaN where there is no surface (npy)");
}

/// A clip for pages: all that is felt is settled, and kept.
TEST_F(ConvertCommand, KeepsForcesOfPageClip) {
    for (const char* scene : {"globe", "moving", "rough"}) {
        make(scene, {"--bits", "8", "--overwrite"});
        const std::string told = convert({at("clip.mkv"), at("page"), "--web", "--overwrite"});
        EXPECT_PRED2(says, told, "depth   every value kept (deflate)");
        EXPECT_FALSE(says(told, "--exact-colour")) << told;
        EXPECT_EQ(hash_of(at("page/clip.json")), hash_of(at("clip.mkv"))) << scene;
        EXPECT_EQ(hash_of(at("page")), hash_of(at("clip.mkv"))) << scene;
    }
    make_clip("globe", at("small.mkv"), {"--size", "16x12", "--frames", "24"});
    EXPECT_EQ(hash_of(TOUCHABLE_SOURCE_DIR "/web/tests/packed_1"), hash_of(at("small.mkv"))) << "version 1";
    expect_refused({at("clip.mkv"), at("out/clip.mkv"), "--web"}, "--web is for a folder");
    expect_refused({at("clip.mkv"), at("out/page"), "--web", "--archive", "small"}, "--archive");
    expect_refused({at("clip.mkv"), at("page"), "--web"}, "is there already");
}

/// The paper's static scene: text and pictures feel as the clip that they were, to the bit.
TEST_F(ConvertCommand, KeepsForcesOfStaticScene) {
    for (const char* bits : {"8", "12", "16"}) {
        make_clip("globe", at("still.mkv"), {"--size", "64x48", "--frames", "1", "--bits", bits});
        const std::string before = hash_of(at("still.mkv")), text = at("s" + std::string(bits) + ".bt");
        const std::string told = convert({at("still.mkv"), text});
        EXPECT_EQ(told.find(text + ": its MPEG-4 scene cannot say: "), 0U) << told;
        EXPECT_EQ(says(told, "largest number of its 16 bits"), bits == std::string("12")) << told;
        EXPECT_PRED2(says, told, "haptic  every value kept (png)");
        EXPECT_PRED2(says, told, text + " describes it, and is what opens it");
        EXPECT_EQ(hash_of(text), before) << bits;
        convert({text, at("back.mkv"), "--exact-colour", "--overwrite"});
        EXPECT_EQ(hash_of(at("back.mkv")), before) << bits;
        // The same in one MP4.
        const std::string one = at("s" + std::string(bits) + ".mp4");
        EXPECT_PRED2(says, convert({at("still.mkv"), one, "--still"}), "colour  every value kept (png)");
        EXPECT_EQ(hash_of(one), before) << bits;
        convert({one, at("back.mkv"), "--exact-colour", "--overwrite"});
        EXPECT_EQ(hash_of(at("back.mkv")), before) << bits;
        fs::remove(at("still.mkv"));
    }
}

TEST_F(ConvertCommand, StaticSceneTakesOneFrame) {
    make("moving");
    const std::string text = at("out/scene.bt");
    expect_refused(
        {at("clip.mkv"), text},
        "is a scene of one frame, but the clip has 6: --from says which one; NAME.mp4 holds them all");
    expect_refused({at("clip.mkv"), at("out/s.mp4"), "--still"},
                   "--from says which one; NAME.mp4 without --still holds them all");
    expect_refused({at("clip.mkv"), at("out/s.mkv"), "--still"}, "--still is for NAME.mp4");
    expect_refused({at("clip.mkv"), at("out/s.mp4"), "--still", "--every", "2"}, "are one frame");
    expect_refused({at("clip.mkv"), text, "--from", "2", "--to", "3"}, "NAME.bt and --still are one frame");
    expect_refused({at("clip.mkv"), text, "--from", "2", "--archive", "small"}, "pictures keep every value");
    convert({at("clip.mkv"), text, "--from", "2"});
    convert({at("clip.mkv"), at("frame.png"), "--from", "2"});
    EXPECT_EQ(hash_of(text), hash_of(at("frame.json")));
    const std::string depth = file_contents(at("out/scene_depth.png"));
    fs::remove(text);
    const Outcome refused = run_convert({at("clip.mkv"), text, "--from", "4"});
    EXPECT_EQ(refused.code, 2);
    EXPECT_PRED2(says, refused.err, "scene_depth.png");
    EXPECT_EQ(file_contents(at("out/scene_depth.png")), depth);
    EXPECT_FALSE(fs::exists(text));
    convert({at("clip.mkv"), text, "--from", "4", "--overwrite"});
    EXPECT_NE(file_contents(at("out/scene_depth.png")), depth);
}

TEST_F(ConvertCommand, KeepsForcesOfHueDepth) {
    Scene scene;
    scene.width = 64;
    scene.height = 48;
    scene.camera = {60, 60, 31.5, 23.5};
    scene.depth.kind = DepthCodingKind::hue;
    scene.depth.near_is_high = false;
    scene.depth.near = 100;
    scene.depth.far = 900;
    scene.depth.code_max = DepthCoding::hue_circle;
    derive_valid_range(scene.depth);
    auto writer = must(create_clip(at("clip.mkv"), scene));
    std::vector<std::uint8_t> rgb(64 * 48 * 3);
    for (int n = 0; n < 3; ++n) {
        for (int k = 0; k < 64 * 48; ++k) {  // between red and yellow, rolling
            const auto pixel = static_cast<std::size_t>(3 * k);
            rgb[pixel] = 255;
            rgb[pixel + 1] = static_cast<std::uint8_t>(60 + k / 64 + k % 64 + 5 * n);
        }
        RawFrame frame;
        frame.number = n;
        frame.depth = {rgb.data(), 64 * 3, 64, 48, 1, 3};
        ASSERT_TRUE(writer->write(frame));
    }
    ASSERT_TRUE(writer->finish());
    writer.reset();
    expect_same_forces();
}

TEST_F(ConvertCommand, PacksFolderWithOneMap) {
    make("moving");
    convert({at("clip.mkv"), at("folder")});
    // A painted stiffness map.
    std::vector<std::uint8_t> grey(64 * 48);
    for (std::size_t k = 0; k < grey.size(); ++k) grey[k] = static_cast<std::uint8_t>(k % 64 * 4);
    ASSERT_TRUE(write_png(at("folder/haptic.png"), PlaneView{grey.data(), 64, 64, 48, 1, 1}));
    auto scene = json_in(at("folder/scene.json"));
    EXPECT_TRUE(scene.at("filter").empty()) << "what the clip leaves open stays open";
    scene["folder"]["haptic"] = "haptic.png";
    std::ofstream(at("folder/scene.json")) << scene;
    const std::string hash = hash_of(at("folder"));
    EXPECT_NE(hash, hash_of(at("clip.mkv")));
    const std::string told = convert({at("folder"), at("packed.mkv")});
    EXPECT_PRED2(says, told, "haptic is grey: stiffness alone");
    EXPECT_EQ(hash_of(at("packed.mkv")), hash);
    EXPECT_PRED2(says, convert({at("packed.mkv"), at("unpacked")}), "one picture for all frames");
    EXPECT_EQ(hash_of(at("unpacked")), hash);
}

std::vector<std::string> remarks_of(const std::string& clip) {
    const auto reader = open_clip(clip);
    EXPECT_TRUE(reader) << reader.error().message;
    std::vector<std::string> texts;
    if (reader)
        for (const Remark& remark : (*reader)->scene().remarks) texts.push_back(remark_text(remark));
    return texts;
}

TEST_F(ConvertCommand, KeepsGuessesMarked) {
    Image depth{64, 48, 2, 1, {}};
    for (int k = 0; k < 64 * 48; ++k) {
        const unsigned code = k % 64 < 20 ? 700 : k % 64 < 44 ? 720 : 740;
        depth.samples.push_back(static_cast<std::uint8_t>(code & 255U));
        depth.samples.push_back(static_cast<std::uint8_t>(code >> 8U));
    }
    fs::create_directory(at("bare"));
    for (const char* name : {"bare/depth_0.png", "bare/depth_1.png"})
        ASSERT_TRUE(write_png(at(name), depth.view()));
    const auto guesses = remarks_of(at("bare"));
    const auto is_guessed = [&](const std::string& text) {
        return std::count(guesses.begin(), guesses.end(), "guessed: " + text);
    };
    EXPECT_EQ(
        is_guessed(
            "the camera sees 60 degrees from left to right; if it sees 70, all shapes are 18 % too narrow"),
        1);
    EXPECT_EQ(is_guessed("depth codes are millimetres: their median, 720, would be 0.72 m"), 1);
    EXPECT_EQ(is_guessed("30 frames a second"), 1);
    convert({at("bare"), at("a.mkv")});
    convert({at("a.mkv"), at("b")});
    convert({at("b"), at("c.mkv")});
    for (const char* packed : {"a.mkv", "b", "c.mkv"}) EXPECT_EQ(remarks_of(at(packed)), guesses) << packed;
    EXPECT_EQ(hash_of(at("c.mkv")), hash_of(at("bare")));
    const std::string told = run_touchable({"info", at("c.mkv")}).out;
    EXPECT_TRUE(says(told, "guessed: 30 frames a second (--scene FILE says otherwise)\n")) << told;
    EXPECT_TRUE(says(run_touchable({"info", at("bare")}).out, "18 % too narrow (--fov DEGREES or --intr"));
}

TEST_F(ConvertCommand, KeepsFrameTimes) {
    make("moving");
    const std::string evenly = hash_of(at("clip.mkv"));
    convert({at("clip.mkv"), at("listed")});
    const std::array<const char*, 6> seconds{"0.000000", "0.030000", "0.110500",
                                             "0.1501",   "0.3",      "0.333333333"};
    std::ofstream list(at("listed/depth.txt"));
    for (std::size_t n = 0; n < seconds.size(); ++n)
        list << "17" << seconds[n] + 1 << " depth_00000" << n << ".png\n";
    list.close();
    auto scene = json_in(at("listed/scene.json"));
    scene.erase("rate");
    scene["folder"]["depth"] = "depth.txt";
    scene["folder"].erase("count");
    std::ofstream(at("listed/scene.json")) << scene;
    const std::string own = hash_of(at("listed"));
    EXPECT_NE(own, evenly);
    EXPECT_PRED2(says, convert({at("listed"), at("packed.mkv")}),
                 "each at its own time, 15 frames/s on average");
    EXPECT_EQ(hash_of(at("packed.mkv")), own);
    convert({at("packed.mkv"), at("unpacked")});
    EXPECT_EQ(hash_of(at("unpacked")), own);
    convert({at("unpacked"), at("part.mkv"), "--from", "1", "--to", "5", "--every", "2"});
    const auto part = must(open_clip(at("part.mkv")));
    ASSERT_TRUE(part->scene().rate.own_times);
    EXPECT_EQ(*part->scene().rate.own_times, (std::vector<std::int64_t>{0, 120'100'000, 303'333'333}));
    scene["rate"] = {30, 1};
    std::ofstream(at("listed/scene.json")) << scene;
    EXPECT_EQ(hash_of(at("listed")), evenly);
}

/// Nearly even, two, and as close as they may be.
TEST_F(ConvertCommand, KeepsNearlyEvenFrameTimes) {
    make("moving");
    auto whole = must(open_clip(at("clip.mkv")));
    Scene scene = whole->scene();
    std::vector<RawFrame> frames;
    for (int n = 0; n < 6; ++n) {
        auto frame = whole->next();
        ASSERT_TRUE(frame && *frame);
        frames.push_back(**frame);
    }
    constexpr std::int64_t ms = 1'000'000;
    const std::vector<std::vector<std::int64_t>> all{
        {0, 34 * ms, 66 * ms, 100 * ms, 133 * ms, 167 * ms}, {0, 400 * ms}, {0, ms, 2 * ms, 400 * ms}};
    for (const auto& times_ns : all) {
        scene.rate = *rate_of_own_times(times_ns);
        auto writer = must(create_clip(at("own.mkv"), scene));
        for (std::size_t n = 0; n < times_ns.size(); ++n) ASSERT_TRUE(writer->write(frames[n]));
        ASSERT_TRUE(writer->finish());
        convert({at("own.mkv"), at("own"), "--overwrite"});
        const auto listed = must(open_clip(at("own")));
        ASSERT_TRUE(listed->scene().rate.own_times);
        EXPECT_EQ(*listed->scene().rate.own_times, times_ns);
    }
}

/// Depth words of a camera's file in swapped byte order come out as plain codes.
TEST_F(ConvertCommand, UnswapsDepthBytesOnce) {
    make("moving", {"--bits", "16"});
    convert({at("clip.mkv"), at("folder")});
    for (int n = 0; n < 6; ++n) {
        const std::string file = at("folder/depth_00000" + std::to_string(n) + ".png");
        auto picture = must(read_image(file));
        for (std::size_t k = 0; k < picture.samples.size(); k += 2)
            std::swap(picture.samples[k], picture.samples[k + 1]);
        ASSERT_TRUE(write_png(file, picture.view()));
    }
    auto scene = json_in(at("folder/scene.json"));
    scene["depth"]["bytes"] = "swapped";
    std::ofstream(at("folder/scene.json")) << scene;
    const std::string before = hash_of(at("clip.mkv"));
    EXPECT_EQ(hash_of(at("folder")), before);
    convert({at("folder"), at("packed.mkv")});
    EXPECT_EQ(hash_of(at("packed.mkv")), before);
    convert({at("folder"), at("pictures")});
    EXPECT_EQ(hash_of(at("pictures")), before);
}

TEST_F(ConvertCommand, ReportsColourLossOnly) {
    make("globe", {"--exact-colour"});
    const std::string told = convert({at("clip.mkv"), at("out/seen.mkv")});
    EXPECT_PRED2(says, told, "depth   every value kept");
    EXPECT_PRED2(says, told, "haptic  every value kept");
    EXPECT_PRED2(says, told, "height  every value kept");
    EXPECT_PRED2(says, told, "colour  as good as the eye can tell");
    EXPECT_PRED2(says, convert({at("clip.mkv"), at("out/exact.mkv"), "--exact-colour"}),
                 "colour  every value kept");
    EXPECT_PRED2(says, convert({at("clip.mkv"), at("out/pictures")}), "colour  every value kept");
}

TEST_F(ConvertCommand, ResizingNeedsAllowLossy) {
    make("globe");
    expect_refused({at("clip.mkv"), at("out/half.mkv"), "--size", "32x24"}, "--allow-lossy");
    const std::string told =
        convert({at("clip.mkv"), at("out/half.mkv"), "--size", "32x24", "--allow-lossy"});
    EXPECT_PRED2(says, told, "depth   LOST");
    EXPECT_PRED2(says, told, "haptic  LOST: of the pixels before, ");
    EXPECT_PRED2(says, told, "degrees off on average");
    EXPECT_PRED2(says, told, " N, at most ");
    // The same size is no change and needs no --allow-lossy.
    convert({at("clip.mkv"), at("out/whole.mkv"), "--size", "64x48"});
    EXPECT_EQ(hash_of(at("out/whole.mkv")), hash_of(at("clip.mkv")));
}

TEST_F(ConvertCommand, ReadsSourceOnce) {
    make("globe");
    convert({at("clip.mkv"), at("folder")});
    for (const std::vector<std::string>& how :
         {std::vector<std::string>{}, {"--exact-colour"}, {"--size", "32x24", "--allow-lossy"}}) {
        OpenedFiles opened(at("folder"));
        EXPECT_TRUE(says(convert(plus({at("folder"), at("again.mkv"), "--overwrite"}, how)), "  colour  "));
        EXPECT_EQ(opened.counts().size(), 25U);  // 6 of each of four planes, and the scene
        for (const auto& [name, count] : opened.counts()) EXPECT_EQ(count, 1) << name;
    }
}

/// By quantize_depth of lerobot's datasets/depth_utils.py, of what the clip's pixels are along the axis.
TEST_F(ConvertCommand, LeRobotDepthFollowsFormula) {
    make("globe", {"--bits", "16"});
    expect_refused({at("clip.mkv"), at("robot.mp4"), "--lerobot"}, "--allow-lossy");
    const std::string said = convert({at("clip.mkv"), at("robot.mp4"), "--lerobot", "--allow-lossy"});
    EXPECT_PRED2(says, said, "LOST: stored as other codes; depths by ");
    EXPECT_PRED2(says, said, "on a standard stroke");
    EXPECT_PRED2(says, said, "robot.info.json says what its codes are");

    std::ifstream info_file(at("robot.info.json"));
    const auto feature = nlohmann::json::parse(info_file)["features"]["observation.images.depth"];
    EXPECT_EQ(feature["shape"], (std::vector<int>{48, 64, 1}));
    const auto& info = feature["info"];
    EXPECT_EQ(info["is_depth_map"], true);
    EXPECT_EQ(info["video.pix_fmt"], "gray12le");
    const double near = info["video.depth_min"], far = info["video.depth_max"], shift = info["video.shift"];
    const auto source = open_clip(at("clip.mkv")), robot = open_clip(at("robot.mp4"));
    ASSERT_TRUE(source && robot);
    const Scene &was = (*source)->scene(), &is = (*robot)->scene();
    EXPECT_EQ(is.depth.kind, DepthCodingKind::log);
    EXPECT_NEAR(is.camera.fx, was.camera.fx, 1e-9);
    EXPECT_NEAR(is.camera.cy, was.camera.cy, 1e-9);
    int holes = 0;
    for (int n = 0; n < 6; ++n) {
        const auto before = (*source)->next(), now = (*robot)->next();
        ASSERT_TRUE(before && now && *before && *now);
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x) {
                const std::uint16_t stored = (*before)->depth.sample(x, y), code = (*now)->depth.sample(x, y);
                ASSERT_EQ(is.depth.is_valid(code), was.depth.is_valid(stored));
                holes += code == 0;
                if (code == 0) continue;
                const double right = (x - was.camera.cx) / was.camera.fx,
                             down = (y - was.camera.cy) / was.camera.fy;
                const double z =
                    was.depth.depth(stored) * was.metres_per_unit /
                    (was.depth.semantics == DepthSemantics::range ? std::sqrt(1 + right * right + down * down)
                                                                  : 1);
                const double published =
                    std::log((z + shift) / (near + shift)) / std::log((far + shift) / (near + shift)) * 4095;
                ASSERT_NEAR(code, published, 0.501) << x << "," << y;
            }
    }
    EXPECT_LT(holes, 6 * 48 * 64 / 2);
    const std::string forces = hash_of(at("robot.mp4"));
    EXPECT_PRED2(says, convert({at("robot.mp4"), at("again.mp4"), "--lerobot"}), "every value kept");
    EXPECT_EQ(hash_of(at("again.mp4")), forces);
    std::ifstream first(at("robot.info.json")), second(at("again.info.json"));
    EXPECT_EQ(nlohmann::json::parse(first), nlohmann::json::parse(second));
    EXPECT_PRED2(says, convert({at("robot.mp4"), at("robot.mkv")}), "every value kept");
    EXPECT_EQ(hash_of(at("robot.mkv")), forces);
    expect_refused({at("robot.mkv"), at("robot.mkv"), "--lerobot"}, "--lerobot is for NAME.mp4");
}

/// Depth of LeRobot's usual numbers, whose frames are told apart by their codes.
int episode_code(int n, int x, int y) {
    return (x + y) % 7 == 0 ? 0 : 300 + 200 * n + 3 * x + 5 * y;
}

/// Its episode tables name an episode's ends by seconds, of which frames of 30 a second have no whole number.
TEST_F(ConvertCommand, CutsLeRobotEpisode) {
    constexpr int width = 64, height = 48;
    ForeignVideo video{"libx265", AV_PIX_FMT_GRAY12, width, height, 8};
    video.tag = MKTAG('h', 'v', 'c', '1');
    video.interval = 2;
    write_video(at("episodes.mp4"), video, [&](AVFrame& frame, int n) {
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) set_sample(frame, 0, x, y, episode_code(n, x, y));
    });
    struct Episode {
        const char *from, *to;
        int first, count;
    };
    const std::vector<Episode> episodes{{"0.0s", "0.06666666666666667s", 0, 2},
                                        {"0.06666666666666667s", "0.16666666666666666s", 2, 3},
                                        {"0.0667s", "0.1667s", 2, 3},
                                        {"0.0666s", "0.1666s", 2, 3},
                                        {"0.16666666666666666s", "0.26666666666666666s", 5, 3}};
    for (const Episode& episode : episodes)
        for (const std::string name : {"cut.mkv", "cut.mp4"}) {
            SCOPED_TRACE(std::string(episode.from) + " " + name);
            std::vector<std::string> words{at("episodes.mp4"), at(name),     "--from", episode.from, "--to",
                                           episode.to,         "--overwrite"};
            if (name == "cut.mp4") words.emplace_back("--lerobot");
            EXPECT_PRED2(says, convert(words), "every value kept");
            auto cut = must(open_clip(at(name)));
            EXPECT_EQ(cut->scene().depth.kind, DepthCodingKind::log);
            for (int n = 0; n < episode.count; ++n) {
                const auto frame = cut->next();
                ASSERT_TRUE(frame && *frame);
                ASSERT_EQ((*frame)->number, n);
                ASSERT_EQ((*frame)->time_ns, 1'000'000'000LL * n / 30);
                for (int y = 0; y < height; ++y)
                    for (int x = 0; x < width; ++x)
                        ASSERT_EQ((*frame)->depth.sample(x, y), episode_code(episode.first + n, x, y));
            }
            const auto end = cut->next();
            EXPECT_TRUE(end && !*end);
        }
}

/// Codes of so many metres as 16-bit pictures; the step is LeRobot's own formula's.
TEST_F(ConvertCommand, LeRobotRefusalNamesStep) {
    Image image{64, 48, 2, 1, {}};
    for (int k = 0; k < 64 * 48; ++k)
        for (const int byte : {(1000 + 10 * k) & 255, (1000 + 10 * k) >> 8})
            image.samples.push_back(static_cast<std::uint8_t>(byte));
    ASSERT_TRUE(write_png(at("depth.png"), image.view()));
    const auto words = [this](const std::string& unit) {
        return std::vector<std::string>{at("depth.png"), at("robot.mp4"), "--fov", "60", "--depth-unit", unit,
                                        "--lerobot"};
    };
    for (const auto& [unit, at_least] : {std::pair("0.0001", 1.4), std::pair("0.1", 6.0)}) {
        convert(plus(words(unit), {"--allow-lossy", "--overwrite"}));
        std::ifstream info_file(at("robot.info.json"));
        const auto info = nlohmann::json::parse(info_file)["features"]["observation.images.depth"]["info"];
        const double near = info["video.depth_min"], far = info["video.depth_max"],
                     shift = info["video.shift"];
        const double step = 1000 * (1 + shift) * std::log((far + shift) / (near + shift)) / 4095;
        EXPECT_GE(step, at_least);
        std::array<char, 32> said{};
        std::snprintf(said.data(), said.size(), "%.2g mm wide at 1 m", step);
        expect_refused(plus(words(unit), {"--overwrite"}), said.data());
    }
    expect_refused(plus(words("100"), {"--overwrite"}), "must be less than 1000000 m");
}

TEST_F(ConvertCommand, ConvertsRequestedPart) {
    make("moving");
    const auto frames_of = [](const std::string& clip) {
        auto reader = open_clip(clip);
        EXPECT_TRUE(reader);
        return reader ? (*reader)->frame_count() : std::nullopt;
    };
    convert({at("clip.mkv"), at("numbers"), "--from", "1", "--to", "4"});
    EXPECT_EQ(frames_of(at("numbers")), 4);
    convert(
        {at("clip.mkv"), at("seconds"), "--from", "0.04s", "--to", "0.1s"});  // frames 1 and 2: 0.033, 0.067
    EXPECT_EQ(frames_of(at("seconds")), 2);
    EXPECT_EQ(file_contents(at("seconds/depth_000000.png")), file_contents(at("numbers/depth_000000.png")));
    convert({at("clip.mkv"), at("sparse.mkv"), "--every", "4", "--crop", "8,6,32x30", "--to", "60s"});
    EXPECT_EQ(frames_of(at("sparse.mkv")), 2);
    const auto scene = (*open_clip(at("sparse.mkv")))->scene();
    EXPECT_EQ(scene.rate.num * 4, scene.rate.den * 30);
    EXPECT_EQ(scene.width, 32);
    const std::string told = convert({at("clip.mkv"), at("one.png"), "--from", "5"});
    EXPECT_PRED2(says, told, "one.json describes it");
    EXPECT_EQ(frames_of(at("one.json")), 1);
    EXPECT_EQ(file_contents(at("one.png")), file_contents([&] {
                  convert({at("clip.mkv"), at("all")});
                  return at("all/depth_000005.png");
              }()));
}

/// As a file manager copies it.
TEST_F(ConvertCommand, TakesFileUrls) {
    make("globe");
    fs::rename(at("clip.mkv"), at("my clip.mkv"));
    const std::string url = "file://" + at("my%20clip.mkv");
    convert({url, "file://localhost" + at("out/a%20b.mkv")});
    EXPECT_TRUE(fs::exists(at("out/a b.mkv")));
    succeed({"info", url});
    succeed({"init-scene", url, "--out", at("out/s.json")});
}

TEST_F(ConvertCommand, RejectsInvalidOptions) {
    make("globe");
    const std::string clip = at("clip.mkv");
    expect_refused({clip, at("out/a.avi")}, "is not allowed; must be NAME.mkv");
    expect_refused({clip, at("out/a"), "--archive", "small"}, "--archive is for clips");
    expect_refused({clip, at("out/a.png"), "--exact-colour"}, "--exact-colour is for clips");
    expect_refused({clip, at("out/a.png"), "--to", "3"}, "--to is for");
    expect_refused({clip, at("out/a.png"), "--every", "3"}, "--every is for");
    expect_refused({clip, at("out/a.exr"), "--allow-lossy", "--to", "3"}, "--to is for");
    expect_refused({clip, at("out/a.npy")}, "leaves out haptic and height pictures");
    expect_refused({clip, at("out/a"), "--median", "3"}, "filters are for --filtered");
    for (const char* wrong : {"x", "", "1.5", "-1", "s", "nans", "1e99s", "infs"})
        expect_refused({clip, at("out/a"), "--from", wrong}, "--from");
    for (const char* wrong : {"1", "1,2", "1,2,3", "a,b,3x3", "1,2,0x3", "-1,2,3x3", "1,2,3x3,4"})
        expect_refused({clip, at("out/a"), std::string("--crop=") + wrong}, "--crop");
    expect_refused({clip, at("out/a"), "--crop", "60,0,5x5"}, "not within the clip's 64x48");
    expect_refused({clip, at("out/a"), "--from", "6"}, "it has 6 frames, 0 to 5");
    expect_refused({clip, at("out/a"), "--to", "6"}, "it has 6 frames, 0 to 5");
    expect_refused({clip, at("out/a"), "--from", "3", "--to", "2"}, "begin before it ends");
    expect_refused({clip, at("out/a"), "--every", "0"}, "--every");
    expect_refused({clip, at("out/none/a")}, "there is no folder", 3);
    expect_refused({at("none.mkv"), at("out/a")}, "does not exist", 3);
    for (const char* small : {"1x1", "3x3"})  // FFV1 and H.264 have limits of their own, folders have none
        convert({clip, at(std::string("s") + small), "--crop", std::string("30,20,") + small});
}

TEST_F(ConvertCommand, NeverReplacesItsInput) {
    make("globe");
    const std::string clip = at("clip.mkv"), bytes = file_contents(clip);
    fs::create_hard_link(clip, at("hard.mkv"));
    fs::create_symlink(clip, at("soft.mkv"));
    fs::create_directory_symlink(folder.path(), at("elsewhere"));
    for (const std::string& name :
         {clip, at("hard.mkv"), at("soft.mkv"), at("out/../clip.mkv"), at("elsewhere/clip.mkv")})
        expect_refused({clip, name, "--overwrite"}, "which it would replace");
    EXPECT_EQ(file_contents(clip), bytes);

    convert({clip, at("folder")});
    const auto names = names_in(folder / "folder");
    fs::create_directory_symlink(folder / "folder", at("link"));
    for (const std::string& name : {at("folder"), at("folder/"), at("link"), at("out/../folder/")})
        for (const std::string& input : {at("folder"), at("folder/scene.json")})
            expect_refused({input, name, "--overwrite"}, "which it would replace");
    for (const char* name : {"folder/depth_000000.png", "folder/haptic_000003.png"})
        expect_refused({at("folder"), at(name), "--overwrite"}, "which it would replace");
    EXPECT_EQ(names_in(folder / "folder"), names);
    EXPECT_EQ(hash_of(at("folder")), hash_of(clip));
    // Nor a scene file that describes it from elsewhere.
    fs::copy_file(folder / "folder/scene.json", folder / "one.json");
    expect_refused({at("folder"), at("one.png"), "--scene", at("one.json"), "--overwrite"},
                   "which it would replace");
}

TEST_F(ConvertCommand, ReplacesNothingButItsOwn) {
    make("globe");
    convert({at("clip.mkv"), at("a")});
    convert({at("clip.mkv"), at("a"), "--overwrite", "--from", "2"});
    EXPECT_FALSE(fs::exists(at("a/depth_000004.png")));  // there are four frames now
    std::ofstream(at("a/notes.txt")) << "mine";
    expect_refused({at("clip.mkv"), at("a"), "--overwrite"}, "holds other files");
    std::ofstream(at("file")) << "mine";
    expect_refused({at("clip.mkv"), at("file"), "--overwrite"}, "no folder");
}

// What other commands make of a clip.
using ClipForms = ConvertCommand;

TEST_F(ClipForms, SceneTextHasPictureSize) {
    make("globe");
    EXPECT_PRED2(says, run_touchable({"info", at("clip.mkv"), "--scene-text"}).out, "size 64 48\n");
}

TEST_F(ClipForms, SegmentsReportRequestsOfViewer) {
    make("globe");
    succeed({"serve", at("clip.mkv"), "--hls", at("web"), "--json", at("r.json")});
    const auto hls = json_in(at("r.json")).at("hls");
    EXPECT_EQ(hls["segments"], 1);
    EXPECT_NEAR(hls["requests_per_second"].get<double>() * hls["seconds"].get<double>(), 2, 1e-6)
        << "one for colour, one for touch";
}

TEST(MakeCommand, SameOptionsGiveSameBytes) {
    const TemporaryFolder folder;
    for (const char* name : {"one.mkv", "two.mkv"})
        succeed({"make", "globe", folder / name, "--size", "72x48", "--frames", "3"});
    EXPECT_FALSE(file_contents(folder / "one.mkv").empty());
    EXPECT_EQ(file_contents(folder / "one.mkv"), file_contents(folder / "two.mkv"));
}

TEST(MakeCommand, ShowsProgressOnTerminal) {
    const TemporaryFolder folder;
    const Outcome run =
        run_on_terminal({"make", "plane", folder / "p.mkv", "--size", "16x12", "--frames", "3"},
                        [](const std::string&) { return false; });
    EXPECT_EQ(run.code, 0);
    EXPECT_PRED2(says, run.err, "making frame 1 of 3");
}

TEST(MakeCommand, StoresGeneratedFrames) {
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
    const auto noise = must(make_scene("noise", {.width = 128, .height = 128, .bits = 10, .seed = 7}));
    for (const char* archive : {"fast", "small"}) {
        make_clip("noise", clip, {"--frames", "3", "--bits", "10", "--seed", "7", "--archive", archive});
        const auto reader = must(open_clip(clip));
        for (std::int64_t n = 0; n < 3; ++n)
            EXPECT_TRUE(same_samples(must(reader->next())->depth, noise->frame(n).depth)) << n;
        EXPECT_FALSE(must(reader->next()));
    }
    const auto globe = must(make_scene("globe", {.width = 72, .height = 48, .properties = true}));
    make_clip("globe", clip, {"--size", "72x48", "--frames", "1", "--exact-colour"});
    EXPECT_TRUE(same_samples(must(must(open_clip(clip))->next())->colour, globe->frame(0).colour));
}

TEST(MakeCommand, RateIsStoredExactly) {
    const TemporaryFolder folder;
    const std::vector<std::tuple<const char*, std::int64_t, std::int64_t>> rates{
        {"30000/1001", 30000, 1001}, {"29.97", 2997, 100}, {"24", 24, 1}, {"0.5", 1, 2}, {"60.0", 60, 1}};
    for (const char* name : {"clip.mkv", "clip.mp4"})
        for (const auto& [rate, num, den] : rates) {
            succeed({"make", "moving", folder / name, "--size", "32x24", "--frames", "3", "--rate", rate,
                     "--overwrite"});
            auto reader = must(open_clip(folder / name));
            EXPECT_EQ(reader->scene().rate.num, num) << name << " " << rate;
            EXPECT_EQ(reader->scene().rate.den, den) << name << " " << rate;
        }
    for (const char* wrong : {"0", "-30", "1001", "30/0", "", "30,5", ".", "30.", ".5", "30/1001/2", "1/1001",
                              "1e2", "12345678901"}) {
        expect_failure({"make", "moving", folder / "no.mkv", "--rate", wrong}, 2, "--rate");
    }
}

TEST(MakeCommand, PlainGlobeHasNoHaptics) {
    const TemporaryFolder folder;
    succeed({"make", "globe", folder / "show.mkv", "--size", "72x48", "--frames", "1"});
    succeed({"make", "globe", folder / "plain.mkv", "--size", "72x48", "--frames", "1", "--plain"});
    const auto has_haptics = [&](const char* name) {
        auto reader = open_clip(folder / name);
        return reader && !(*reader)->next()->value().haptic.empty();
    };
    EXPECT_TRUE(has_haptics("show.mkv"));
    EXPECT_FALSE(has_haptics("plain.mkv"));
}

TEST(MakeCommand, RejectsInvalidOptions) {
    expect_failure({"make", "plane", "/no-such-folder/out.mkv", "--size", "16x12", "--frames", "1"}, 3);
    const TemporaryFolder folder;
    const std::string out = folder / "out.mkv";
    const std::vector<std::vector<std::string>> wrong{
        {"make", "teapot", out},
        {"make", "plane", out, "--size", "720"},
        {"make", "plane", out, "--size", "720x"},
        {"make", "plane", out, "--size", "0x10"},
        {"make", "plane", out, "--size", "99999x10"},
        {"make", "plane", out, "--bits", "7"},
        {"make", "plane", out, "--bits", "17"},
        {"make", "plane", out, "--frames", "0"},
        {"make", "plane", out, "--frames", "1000001"},
        {"make", "noise", out, "--seed", "-1"},
        {"make", "noise", out, "--seed", "18446744073709551616"},
        {"make", "noise", out, "--seed", ""},
        {"make", "plane", out, "--size", ""},
        {"make", "globe", out, "--preset", ""},
        {"make", "plane", out, "--tilt", "75"},
        {"make", "globe", out, "--preset", "C"},
        {"make", "globe", out, "--plain", "--properties"}};
    for (const auto& words : wrong) {
        expect_failure(words, 2);
        EXPECT_TRUE(names_in(folder.path()).empty()) << words.back();
    }
    EXPECT_PRED2(says, run_touchable({"make", "teapot", out}).err, "globe");
}

TEST(MakeCommand, RejectsOptionsWithoutEffect) {
    const TemporaryFolder folder;
    for (const auto& [scene, option] : std::vector<std::pair<std::string, std::vector<std::string>>>{
             {"bumps", {"--preset", "A"}},
             {"bumps", {"--plain"}},
             {"globe", {"--tilt", "10"}},
             {"globe", {"--plain", "--seed", "3"}}}) {
        expect_failure(plus({"make", scene, folder / "out.mkv"}, option), 2,
                       option.size() > 2 ? option[1] : option[0]);
    }
}

TEST(MakeCommand, RejectsOtherFileExtensions) {
    const TemporaryFolder folder;
    for (const char* name : {"clip.avi", "clip", "clip.mkv.png", "mkv", "mp4"}) {
        expect_failure({"make", "plane", folder / name, "--size", "16x12", "--frames", "1"}, 2,
                       "does not end in .mkv (Matroska) or .mp4");
    }
    for (const char* name : {"CLIP.MKV", "CLIP.Mp4"})
        succeed({"make", "plane", folder / name, "--size", "16x12", "--frames", "1"});
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"CLIP.MKV", "CLIP.Mp4"}));
}

TEST(MakeCommand, ReportsInsufficientMemory) {
#ifdef TOUCHABLE_SANITIZED
    GTEST_SKIP() << "sanitizers take more address space than this test leaves";
#endif
    const TemporaryFolder folder;
    expect_failure(
        run_in_memory({"make", "plane", folder / "out.mkv", "--size", "16384x8192", "--frames", "1"}, 1024),
        3, "memory does not suffice for frames of 16384x8192");
    EXPECT_TRUE(names_in(folder.path()).empty());
}

// What all commands do that write files.

class Writing : public ::testing::Test {
protected:
    Writing() {
        fs::create_directory(folder / "out");
        make_clip("noise", clip, {"--frames", "3"});
    }
    static std::string out(const std::string& name) { return "out/" + name; }
    Outcome run(const Words& words) const { return run_in_folder(words, folder.path()); }
    /// Of all files there.
    Words contents() const {
        Words all;
        for (const auto& entry : fs::recursive_directory_iterator(folder / "out"))
            if (entry.is_regular_file()) all.push_back(entry.path().string() + file_contents(entry.path()));
        return all;
    }
    void expect_nothing(const Words& words) const {
        EXPECT_EQ(contents(), Words{}) << words[0] << words.back();
    }

    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
};

TEST_F(Writing, OverwritesOnlyWithPermission) {
    for (const Words& words : {Words{"make", "plane", out("m.mkv"), "--size", "16x12", "--frames", "1"},
                               {"convert", clip, out("c.mkv")},
                               {"convert", clip, out("c.png")},
                               {"convert", clip, out("c")},
                               {"export", clip, "--frame", "1", "--out", out("e")},
                               {"export", clip, "--frames", "0-1", "--out", out("es")},
                               {"export", clip, "--frame", "1", "--picture", out("e.png")},
                               {"init-scene", clip, "--out", out("scene.json")},
                               {"touch", clip, "--seconds", "0.1", "--json", out("t.json")},
                               {"touch", clip, "--seconds", "0.1", "--forces", out("t.csv")},
                               {"touch", clip, "--seconds", "0.1", "--record", out("t.rec")}}) {
        EXPECT_EQ(run(words).code, 0) << words[0];
        const Words before = contents();
        expect_failure(run(words), 2, "--overwrite");
        EXPECT_TRUE(contents() == before) << words[0];
        // Nothing but a scene is replaced by a scene.
        for (const auto& entry : fs::recursive_directory_iterator(folder / "out"))
            if (entry.is_regular_file() && entry.path().filename() != "scene.json")
                std::ofstream(entry.path()) << "earlier\n";
        EXPECT_EQ(run(plus(words, {"--overwrite"})).code, 0) << words[0];
        EXPECT_TRUE(words[0] == "touch" || contents() == before) << words[0];
        for (const std::string& file : contents()) EXPECT_FALSE(says(file, "earlier\n")) << words[0];
        fs::remove_all(folder / "out");
        fs::create_directory(folder / "out");
    }
}

/// One file that is there keeps all from being written.
TEST_F(Writing, AsksForEveryOutputFirst) {
    const Words names{"t.csv", "t.json", "t.rec"};
    const Words words{"touch",       clip,       "--seconds",  "0.1",      "--json",
                      out("t.json"), "--forces", out("t.csv"), "--record", out("t.rec")};
    for (const std::string& name : names) {
        std::ofstream(folder / out(name)) << "earlier\n";
        expect_failure(run(words), 2, "--overwrite");
        EXPECT_EQ(names_in(folder / "out"), Words{name});
        EXPECT_EQ(file_contents(folder / out(name)), "earlier\n");
        fs::remove(folder / out(name));
    }
    EXPECT_EQ(run(words).code, 0);
    EXPECT_EQ(names_in(folder / "out"), names);
}

/// A limit on the size of files stands in for a full disk: writing fails half-way, or at the very end, for
/// files so small that nothing is written before they are closed.
TEST_F(Writing, FullDiskLeavesNothing) {
    const std::string file = folder / "out/file";
    struct Case {
        int kibibytes;
        Words words;
        const char* says = "";
    };
    std::vector<Case> cases{{0, {"touch", clip, "--seconds", "0.1", "--picture", file + ".png"}},
                            {0, {"init-scene", clip, "--out", file}, "cannot be written: File too large"},
                            {0, {"make", "noise", file + ".mkv", "--frames", "20"}},
                            {40, {"make", "noise", file + ".mkv", "--frames", "20"}}};
    cases.push_back({64, {"touch", clip, "--seconds", "3", "--forces", file}, "--forces"});
    for (const char* option : {"--forces", "--record", "--json"})
        cases.push_back({0, {"touch", clip, "--seconds", "0.002", option, file}, option});
    for (const int kibibytes : {0, 2}) {
        cases.push_back({kibibytes, {"export", clip, "--frame", "0", "--out", file}});
        cases.push_back({kibibytes, {"export", clip, "--frame", "0", "--picture", file + ".png"}});
    }
    for (const char* ending : {"", ".mkv", ".png"}) {
        cases.push_back({4, {"convert", clip, file + ending}});
        cases.push_back({4, {"convert", clip, file + ending, "--size", "200x150", "--allow-lossy"}});
    }
    for (const Case& one : cases) {
        const Outcome run = expect_failure(run_on_full_disk(one.words, one.kibibytes), 3, one.says);
        EXPECT_FALSE(says(run.err, ".png/") || says(run.out, "--forces FILE")) << run.err << run.out;
        expect_nothing(one.words);
    }
}

/// As docs/touch.md promises; its clip's name is no UTF-8.
TEST_F(Writing, FullDiskKeepsRecording) {
    const std::string file = folder / "out/file", other = folder / "\xff clip.mkv";
    fs::rename(clip, other);
    const Outcome run = expect_failure(
        run_on_full_disk({"touch", other, "--seconds", "3", "--record", file}, 64), 3, "--record");
    EXPECT_PRED2(says, run.err, "; it is kept, and replays, up to ");
    succeed({"touch", "--replay", file});
}

TEST_F(Writing, LossyDiskIsAnError) {
    const std::string at = folder / "out";
    for (const Words& words : {Words{"convert", clip, at + "/c"},
                               {"convert", clip, at + "/c.png"},
                               {"convert", clip, at + "/c.gltf"},
                               {"convert", clip, at + "/w", "--web"},
                               {"export", clip, "--frame", "0", "--out", at + "/e"},
                               {"touch", clip, "--seconds", "0.1", "--record", at + "/r"}})
        expect_failure(run_on_lossy_disk(words), 3, "cannot be written: Input/output error");
}

/// An incomplete file has no name, so that not even a kill leaves anything; a folder has one.
TEST_F(Writing, StoppedRunLeavesNothing) {
    // A clip of many frames that is quickly made: all are one picture.
    succeed({"convert", clip, folder / "long", "--to", "0"});
    for (int n = 1; n < 2000; ++n)
        fs::create_hard_link(folder / "long/depth_000000.png",
                             folder / ("long/depth_" + std::to_string(1'000'000 + n).substr(1) + ".png"));
    auto scene = json_in(folder / "long/scene.json");
    scene["folder"]["count"] = 0;
    std::ofstream(folder / "long/scene.json") << scene;
    const std::string file = folder / "out/file";
    for (const Words& words :
         {Words{"convert", folder / "long", file},
          {"convert", folder / "long", file + ".mkv"},
          {"materials", folder / "long", file + ".mkv", "--otherwise", "wood", "--save", file + ".json"},
          {"make", "noise", file + ".mkv", "--frames", "100000"},
          {"touch", clip, "--seconds", "100000", "--json", file, "--forces", file + ".csv", "--record",
           file + ".rec", "--picture", file + ".png"}})
        for (const int signal : {SIGINT, SIGKILL}) {
            if (signal == SIGKILL && words.back() == file) continue;
            EXPECT_EQ(run_interrupted(words, folder / "out", signal).code, signal == SIGINT ? 130 : -SIGKILL);
            expect_nothing(words);
        }
}

}  // namespace
}  // namespace touchable::test
