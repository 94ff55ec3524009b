// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/gpu/gpu_device.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "player/commands/reports.hpp"
#include "tests/limits.hpp"
#include "tests/must.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

TEST(Info, GlobeHasPapersFov) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    succeed({"make", "globe", clip, "--frames", "2"});
    const auto facts = json_of({"info", clip, "--json"});
    ASSERT_TRUE(facts.is_object());
    EXPECT_EQ(facts["width"], 720);
    EXPECT_EQ(facts["height"], 480);
    EXPECT_EQ(facts["frames"], 2);
    EXPECT_EQ(facts["rate"]["num"], 30);
    EXPECT_NEAR(facts["camera"]["fov_x_degrees"].get<double>(), 81.3, 0.05);
    EXPECT_NEAR(facts["camera"]["fov_y_degrees"].get<double>(), 59.5, 0.05);
    EXPECT_EQ(facts["depth"]["kind"], "linear");
    EXPECT_EQ(facts["depth"]["semantics"], "range");
    EXPECT_EQ(facts["depth"]["bits"], 16);
    EXPECT_EQ(facts["depth"]["code_max"], 65535);
    EXPECT_DOUBLE_EQ(facts["depth"]["near"].get<double>(), 40);
    EXPECT_DOUBLE_EQ(facts["depth"]["far"].get<double>(), 180);
    EXPECT_NEAR(facts["depth"]["far_mm"].get<double>(), 180 * facts["metres_per_unit"].get<double>() * 1000,
                1e-9);
    EXPECT_EQ(facts["tracks"].size(), 4U);
    EXPECT_TRUE(facts.contains("haptic"));
    EXPECT_TRUE(facts.contains("height_coding"));
}

// Preset B at 720x480: fx = 4.7/0.0112, so one pixel at depth d is d 0.0112/4.7 wide; one code is 140/255
// deep.
TEST(Info, KappaIsStepPerPixel) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    succeed({"make", "globe", clip, "--frames", "1", "--bits", "8", "--plain"});
    const auto kappa = json_of({"info", clip, "--json"})["kappa"];
    for (const auto& [where, depth] :
         {std::pair{"near", 40.0}, std::pair{"mid", 110.0}, std::pair{"far", 180.0}}) {
        EXPECT_DOUBLE_EQ(kappa[where]["depth"].get<double>(), depth);
        EXPECT_NEAR(kappa[where]["kappa"].get<double>(), 140.0 / 255.0 / (depth * 0.0112 / 4.7), 1e-9)
            << where;
    }
}

TEST(Info, AdvisesTerraceRemoval) {
    const TemporaryFolder folder;
    for (const auto& [bits, advised] : {std::pair{"8", true}, {"16", false}}) {
        const std::string clip = folder / (std::string(bits) + ".mkv");
        succeed({"make", "globe", clip, "--frames", "1", "--bits", bits, "--plain"});
        const auto facts = json_of({"info", clip, "--json"});
        EXPECT_EQ(facts["terraces"]["advised"], advised) << bits;
        EXPECT_EQ(facts["filters"]["terraces"], advised) << bits << ": the clip leaves it open";
        const double depth = facts["filters"]["measured"]["median_depth"];
        EXPECT_GT(depth, facts["first_frame"]["nearest"].get<double>()) << bits;
        EXPECT_LT(depth, 0.5 * facts["first_frame"]["farthest"].get<double>())
            << "of the globe, not of what is behind";
        const double step = 140.0 / (std::stoi(bits) == 8 ? 255 : 65535);
        EXPECT_NEAR(facts["filters"]["measured"]["level_distance"].get<double>(), step, 1e-9) << bits;
        EXPECT_NEAR(facts["filters"]["measured"]["kappa"].get<double>(), step / (depth * 0.0112 / 4.7), 1e-9)
            << bits;
        const std::string said = advised ? "terraces (levels" : "none needed (levels";
        EXPECT_PRED2(says, run_touchable({"info", clip}).out, said) << bits;
        const auto off = json_of({"info", clip, "--filters", "off", "--json"});
        EXPECT_EQ(off["filters"]["terraces"], false) << bits;
        EXPECT_EQ(off["terraces"]["advised"], advised) << bits;
    }
}

TEST(Info, PrintsFactsAsText) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    succeed({"make", "plane", clip, "--size", "64x48", "--frames", "3"});
    const Outcome run = succeed({"info", clip});
    for (const char* fact : {"64x48", "3 frames", "30 frames/s", "field of view", "16 bits", "kappa",
                             "t3d2 without loss", "filters      none needed"})
        EXPECT_PRED2(says, run.out, fact);
}

TEST(Info, ExplainsKappaStep) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    succeed({"make", "globe", clip, "--frames", "1", "--bits", "8", "--plain"});
    const Outcome plain = run_touchable({"info", clip});
    EXPECT_PRED2(says, plain.out, "(depth of one code / width of a pixel)");
    EXPECT_PRED2(says, plain.out, " of a pixel's width, no sign of a camera)");
    const std::string file = folder / "levels.json";
    succeed({"init-scene", clip, "--out", file});
    auto scene = json_in(file);
    scene["filter"]["levels"] = {5, 0};
    std::ofstream(file) << scene.dump();
    const Outcome levels = run_touchable({"info", clip, "--scene", file});
    EXPECT_PRED2(says, levels.out, "(distance of two levels / width of a pixel)");
}

TEST(Info, EndsWithVerdict) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    succeed({"make", "globe", clip, "--frames", "1", "--bits", "8"});
    const auto verdict = [](const std::vector<std::string>& words) {
        return json_of(words)["verdict"].get<std::string>();
    };
    EXPECT_EQ(verdict({"info", clip, "--json"}), "good to touch: touchable play " + clip);
    const std::string rough = verdict({"info", clip, "--json", "--terraces", "off"});
    EXPECT_TRUE(rough.starts_with("rough: smooth places lean ")) << rough;
    EXPECT_TRUE(rough.ends_with("with other filters: touchable play " + clip + " --filters auto")) << rough;
    // In a hand's terms, by the table of hand_thresholds.hpp: 18.4 degrees are just noticed.
    const auto tried = json_of({"info", clip, "--json"})["filters"]["measured"]["tried"];
    ASSERT_FALSE(tried.empty());
    for (const auto& one : tried)
        EXPECT_NEAR(one["left_jnd"], one["left_degrees"].get<double>() / 18.4, 1e-12);
    const auto jnd = rough.find(" to and fro (");
    ASSERT_NE(jnd, std::string::npos) << rough;
    EXPECT_NEAR(std::stod(rough.substr(jnd + 13)),
                std::stod(rough.substr(std::string("rough: smooth places lean ").size())) / 18.4, 0.06);
    EXPECT_PRED2(says, rough, " of what a hand just notices where it sees the scene), and ");
    const std::string text = run_touchable({"info", clip}).out;
    EXPECT_PRED2(says, text, " of what a hand just notices where it sees the scene), ");
    EXPECT_PRED2(says, text, "\n  verdict      good to touch: touchable play " + clip + "\n");
    EXPECT_PRED2(says, text, "; smooth places lean ") << "what the filter did";
    succeed({"make", "bumps", folder / "smooth.mkv", "--frames", "1"});
    const std::string smooth = run_touchable({"info", folder / "smooth.mkv"}).out;
    EXPECT_PRED2(says, smooth, "good to touch") << "bends are no errors";
    EXPECT_FALSE(says(smooth, "err by less")) << smooth;
}

/// A noisy slope in one picture: the filters that the program chooses leave little, others much.
TEST(Info, VerdictFollowsErrorBars) {
    const TemporaryFolder folder;
    Random random(7);
    std::vector<std::uint16_t> depths;
    for (int k = 0; k < 320 * 240; ++k) {
        double noise = -6;
        for (int n = 0; n < 12; ++n) noise += random.between(0, 1);
        depths.push_back(static_cast<std::uint16_t>(1000 + 0.3 * (k % 320) + 8 * noise));
    }
    const std::string picture = folder / "slope.png";
    ASSERT_TRUE(write_png(picture, plane_of_codes(depths.data(), 320, 240)));
    const std::vector<std::string> words{"info", picture, "--json", "--depth-unit", "0.001", "--fov", "60"};
    const auto chosen = json_of(words), rough = json_of(plus(words, {"--median", "3", "--terraces", "off"}));
    EXPECT_LT(chosen["error_degrees"]["half"], 18);
    EXPECT_LT(chosen["error_degrees"]["tenth"], chosen["error_degrees"]["half"]);
    const auto verdict = [](const auto& facts) { return facts["verdict"].template get<std::string>(); };
    EXPECT_TRUE(verdict(chosen).starts_with("good to touch: ")) << verdict(chosen);
    EXPECT_GT(rough["error_degrees"]["tenth"], 26);
    EXPECT_TRUE(verdict(rough).starts_with("rough: at nine of ten places ")) << verdict(rough);
}

// Levels of 6e-6 depth^2 mm are ten pixels' widths, each 0.0022 depth, 3.7 m away.
TEST(Info, NamesDepthOfNoTrust) {
    const TemporaryFolder folder;
    constexpr int width = 160, height = 120;
    constexpr double step = 6e-6;
    SplitMix64 random(1);
    for (int n = 0; n < 8; ++n) {
        std::ofstream out(folder / ("depth_" + std::to_string(n) + ".pgm"), std::ios::binary);
        out << "P5 " << width << ' ' << height << " 65535\n";
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) {  // of a floor from 1.5 m away to 8 m
                const double inverse = 1.0 / 1500 + (1.0 / 8000 - 1.0 / 1500) * y / (height - 1);
                const double level = std::round((inverse + random.within(-4e-6, 4e-6)) / step) * step;
                const int mm = static_cast<int>(1 / level + 0.5);
                out << static_cast<char>(mm >> 8) << static_cast<char>(mm & 255);
            }
    }
    const std::vector<std::string> words{"info", folder / "", "--depth-unit", "0.001", "--fov", "20"};
    const Outcome run = run_touchable(words);
    EXPECT_PRED2(says, run.out, " m its force cannot be trusted\n");
    const auto filters = json_of(plus(words, {"--json"}))["filters"];
    ASSERT_TRUE(filters.contains("trusted_to")) << filters;
    EXPECT_NEAR(filters["trusted_to"], 3.5, 0.4);
    EXPECT_FALSE(
        json_of({"info", folder / "", "--depth-unit", "0.001", "--fov", "60", "--json"})["filters"].contains(
            "trusted_to"))
        << "pixels are three times as wide";
    EXPECT_FALSE(json_of(plus(words, {"--json", "--terraces", "off"})).contains("error_degrees"))
        << "trusted nowhere";
}

// The example of docs/scene_file.md is what `make globe` writes.
TEST(Info, GlobeSceneMatchesDocumentation) {
    const std::string page = file_contents(TOUCHABLE_SOURCE_DIR "/docs/scene_file.md");
    const std::size_t chapter = page.find("## A generated clip"), begin = page.find('{', chapter);
    ASSERT_NE(chapter, std::string::npos);
    auto documented = must(parse_scene(page.substr(begin, page.find("```", begin) - begin), "scene_file.md"));
    documented.unstated.rate = false;  // the clip states the default
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    succeed({"make", "globe", clip, "--frames", "1"});
    const auto reader = must(open_clip(clip));
    EXPECT_EQ(scene_to_json(documented), scene_to_json(reader->described()));
}

TEST(Info, ReadsEveryScene) {
    const TemporaryFolder folder;
    for (const char* scene :
         {"globe", "bumps", "rough", "moving", "plane", "spheres", "step", "noise", "cliffs"}) {
        const std::string clip = folder / (std::string(scene) + ".mkv");
        succeed({"make", scene, clip, "--size", "64x48", "--frames", "1", "--bits", "12"});
        const auto facts = json_of({"info", clip, "--json"});
        EXPECT_EQ(facts["depth"]["bits"], 12) << scene;
        EXPECT_LE(facts["first_frame"]["nearest"], facts["first_frame"]["farthest"]) << scene;
    }
}

TEST(Info, RejectsDamagedClip) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", half = folder / "half.mkv", text = folder / "text.mkv";
    succeed({"make", "globe", clip, "--size", "72x48", "--frames", "2"});
    std::filesystem::copy_file(clip, half);
    std::filesystem::resize_file(half, 600);
    std::filesystem::copy_file(TOUCHABLE_SOURCE_DIR "/CMakeLists.txt", text);
    for (const std::string& damaged : {half, text, folder.path().string()}) {
        expect_failure({"info", damaged}, 3, damaged);
    }
}

// A far plane that is not given is searched in up to 32 frames, which are large here.
TEST(Info, FarPlaneSearchIsInterruptible) {
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
    succeed({"make", "noise", clip, "--size", "2048x1536", "--frames", "1"});
    succeed({"export", clip, "--frame", "0", "--out", folder / "out"});
    for (int n = 0; n < 40; ++n)
        std::filesystem::create_symlink("depth.png", folder / ("out/d" + std::to_string(n) + ".png"));
    auto scene = json_in(folder / "out/scene.json");
    scene["depth"] = {{"coding", "metric"}, {"bits", scene["depth"]["bits"]}, {"scale", 0.01}};
    scene["folder"] = {{"depth", "d%d.png"}};
    std::ofstream(folder / "out/scene.json") << scene;
    const Outcome run = expect_failure(run_interrupted_at_once({"info", folder / "out"}), 130);
    EXPECT_EQ(run.out, "");
}

/// A bowl of millimetres, 60 x 40, beside which nothing lies.
class BarePicture : public ::testing::Test {
protected:
    BarePicture() {
        Image image{60, 40, 2, 1, {}};
        for (int y = 0; y < 40; ++y)
            for (int x = 0; x < 60; ++x) {
                const int depth = 400 + (x - 30) * (x - 30) / 20 + (y - 20) * (y - 20) / 20;
                image.samples.push_back(static_cast<std::uint8_t>(depth & 255));
                image.samples.push_back(static_cast<std::uint8_t>(depth >> 8));
            }
        EXPECT_TRUE(write_png(folder / "my.png", image.view()));
    }
    std::string picture() const { return folder / "my.png"; }
    const Words camera{"--intrinsics", "50,50", "--depth-unit", "0.001"};
    Outcome run(Words words, const Words& more) const {
        words.insert(words.end(), more.begin(), more.end());
        return run_touchable(words);
    }
    TemporaryFolder folder;
};

TEST_F(BarePicture, WorksWithGivenCamera) {
    const std::string recording = folder / "run.rec", report = folder / "report.json";
    const Outcome touched =
        run({"touch", picture(), "--seconds", "0.5", "--record", recording, "--json", report}, camera);
    ASSERT_EQ(touched.code, 0) << touched.err;
    EXPECT_GT(json_in(report)["contact_ticks"], 100);
    succeed({"touch", "--replay", recording});
    EXPECT_EQ(run({"touch", "--replay", recording}, camera).code, 2);
    const Outcome told = run({"info", picture(), "--json"}, camera);
    ASSERT_EQ(told.code, 0) << told.err;
    EXPECT_EQ(nlohmann::json::parse(told.out)["first_frame"]["nearest"], 0.4);
    const Outcome exported = run({"export", picture(), "--frame", "0", "--out", folder / "out"}, camera);
    EXPECT_EQ(exported.code, 0) << exported.err;
}

/// A recording keeps the typed option: depth along rays is replayed as such.
TEST_F(BarePicture, DepthOptionSelectsRayDepth) {
    const std::string recording = folder / "run.rec", out = folder / "out";
    const Outcome touched =
        run({"touch", picture(), "--seconds", "0.1", "--depth", "range", "--record", recording}, camera);
    ASSERT_EQ(touched.code, 0) << touched.err;
    succeed({"touch", "--replay", recording});
    for (const char* word : {"range", "planar"}) {
        const Outcome exported =
            run({"export", picture(), "--frame", "0", "--depth", word, "--out", out + word}, camera);
        ASSERT_EQ(exported.code, 0) << exported.err;
        const auto codes = json_in(out + word + "/codes.json");
        EXPECT_EQ(codes["depth"]["semantics"], word);
    }
    EXPECT_EQ(run({"info", picture(), "--depth", "sideways"}, camera).code, 2);
}

TEST_F(BarePicture, GuessesMissingCamera) {
    const std::string recording = folder / "run.rec";
    const Outcome touched = succeed({"touch", picture(), "--seconds", "0.1", "--record", recording});
    EXPECT_PRED2(says, touched.out, " guessed of the clip (touchable info says which)");
    EXPECT_PRED2(says, run_touchable({"touch", picture(), "--seconds", "0.1", "--verbose"}).out,
                 "guessed: the camera sees 60 degrees");
    succeed({"touch", "--replay", recording});
    succeed({"touch", picture(), "--seconds", "0.1", "--fov", "90", "--preset", "realsense", "--record",
             recording, "--overwrite"});
    succeed({"touch", "--replay", recording});
    EXPECT_EQ(run_touchable({"info", picture(), "--preset", "none"}).code, 2);
}

TEST_F(BarePicture, CameraFileReplacesGuess) {
    std::ofstream(folder / "camera.json")
        << R"({"width": 120, "height": 80, "fx": 100, "fy": 100, "cx": 59.5, "cy": 39.5})";
    const std::string own = "the camera is that of camera.json (--intrinsics FX,FY,CX,CY says otherwise)\n",
                      scaled =
                          "camera.json is of 120x80 pixels and is scaled to these pictures (--intrinsics";
    const Outcome told = run_touchable({"info", picture()});
    EXPECT_PRED2(says, told.out, "  note         " + own);
    EXPECT_PRED2(says, told.out, "  note         " + scaled);
    EXPECT_PRED2(says, told.out,
                 "verdict      good to touch if the unit is right (depth codes are millimetres: ");
    EXPECT_PRED2(says, run({"info", picture()}, {"--depth-unit", "0.001"}).out,
                 "verdict      good to touch: touchable play ");
    const Outcome window = succeed(
        {"play", picture(), "--headless", "--seconds", "0.1", "--painter", "cpu", "--builder", "cpu"});
    EXPECT_PRED2(says, window.err, "touchable: " + own);
    const Outcome typed = run_touchable({"info", picture(), "--intrinsics", "100,100,59.5,39.5"});
    EXPECT_EQ(typed.out.find("guessed: the camera"), std::string::npos) << typed.out << typed.err;
}

/// The guess that matters most comes first, with what says otherwise; none that matters, and it is good.
TEST_F(BarePicture, VerdictWeighsEveryGuess) {
    const auto verdict = [&](const std::string& clip, const Words& more) {
        return nlohmann::json::parse(run({"info", clip, "--json"}, more).out, nullptr, false)["verdict"]
            .get<std::string>();
    };
    const auto begins = [](const std::string& told, const std::string& words) {
        EXPECT_EQ(told.substr(0, words.size()), words) << told;
    };
    const auto ends = [](const std::string& told, const std::string& words) {
        EXPECT_TRUE(told.ends_with(words)) << told;
    };
    // 0.418 m, and 1.6 m if 256 codes are a metre.
    begins(verdict(picture(), {}),
           "good to touch if the unit is right (depth codes are millimetres: their median, "
           "418, would be 0.418 m; 1.63 m if 256 codes");
    ends(verdict(picture(), {}), " --depth-unit METRES; guessed too: the camera, range or planar");
    ends(verdict(picture(), {"--depth-unit", "0.001"}), " --fov DEGREES");
    begins(verdict(picture(), camera), "good to touch: ");
    // Floats: where the lower third is larger they may be 1/depth; what goes along a ray is not said.
    const auto write_floats = [&](const std::string& file, double lower, double noise) {
        std::string bytes = "Pf\n60 40\n-1\n";
        for (int y = 39; y >= 0; --y)  // a PFM begins with its lowest row
            for (int x = 0; x < 60; ++x) {
                const auto value =
                    static_cast<float>((2 + 2 * lower * y / 39.0) * ((x + y) % 2 == 0 ? 1 : noise));
                bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
            }
        std::ofstream(file, std::ios::binary) << bytes;
    };
    const std::string floats = folder / "floats.pfm";
    write_floats(floats, -0.4, 1);
    const std::string plain = verdict(floats, {"--intrinsics", "50,50"});
    begins(plain, "good to touch if the unit is right (values are metres: ");
    ends(plain, "; guessed too: range or planar");
    ends(verdict(floats, {"--intrinsics", "50,50", "--depth-unit", "1"}),
         " --depth planar, or --depth range");
    begins(verdict(floats, {"--intrinsics", "50,50", "--depth-unit", "1", "--depth", "planar"}),
           "good to touch: ");
    begins(verdict(floats, {"--intrinsics", "500,500", "--depth-unit", "1"}), "good to touch: ");
    write_floats(floats, 2, 1);
    const std::string turned = verdict(floats, {"--depth", "planar"});
    begins(turned, "may be inside out (values are lengths, though they are larger in the lower third");
    ends(turned, " --preset relative-inverse; guessed too: the camera, the unit");
    // With every second pixel three times as deep there is no surface.
    write_floats(floats, 0, 3);
    begins(verdict(floats, {}),
           "hardly depth: 100 % of neighbouring pixels differ by more than a factor of two");
}

TEST_F(BarePicture, ReportsAlternatingFrames) {
    std::filesystem::create_directory(folder / "mixed");
    for (int n = 0; n < 4; ++n) {
        Image image{60, 40, 2, 1, {}};
        for (int k = 0; k < 60 * 40; ++k) {
            const int depth = (n % 2 == 0 ? 500 : 1100) + k % 60;
            image.samples.push_back(static_cast<std::uint8_t>(depth & 255));
            image.samples.push_back(static_cast<std::uint8_t>(depth >> 8));
        }
        ASSERT_TRUE(write_png(folder / ("mixed/" + std::to_string(n) + ".png"), image.view()));
    }
    const auto told =
        nlohmann::json::parse(run({"info", folder / "mixed", "--json"}, camera).out, nullptr, false);
    EXPECT_TRUE(told["verdict"].get<std::string>().starts_with("frames of two kinds take turns, one 2."))
        << told["verdict"];
}

TEST(Verdict, NamesEachKindOfGuess) {
    ClipFacts facts;
    facts.clip = "a.mkv";
    facts.nearest = 1;
    facts.farthest = 2;
    facts.scene.width = facts.scene.height = 100;
    facts.scene.camera = {50, 50, 49.5, 49.5};  // wide: the corners change with range or planar
    std::set<std::string> verdicts;
    for (int k = 0; k <= static_cast<int>(RemarkKind::other); ++k) {
        const auto kind = static_cast<RemarkKind>(k);
        const bool is_fact = kind == RemarkKind::unit_doubt || kind == RemarkKind::other;
        facts.scene.remarks = {{"it is so", !is_fact, "", {{Setting::depth_unit}}, kind}};
        const std::string verdict = verdict_on(facts, nullptr);
        EXPECT_EQ(verdict.find("(it is so)") != std::string::npos, !is_fact) << k << ": " << verdict;
        verdicts.insert(verdict);
        facts.scene.remarks.insert(facts.scene.remarks.begin(),
                                   {"inside out", true, "", {}, RemarkKind::direction});
        const bool is_named_once = is_fact || kind == RemarkKind::direction;
        EXPECT_EQ(verdict_on(facts, nullptr).find("guessed too: ") == std::string::npos, is_named_once) << k;
    }
    EXPECT_EQ(verdicts.size(), static_cast<std::size_t>(RemarkKind::other) - 1)
        << "two facts have one, and a unit one whether it is clear or not";
    facts.scene.remarks = {{"0.5 m, black", true, "", {{Setting::scene_file, "FILE"}}, RemarkKind::scale}};
    EXPECT_TRUE(verdict_on(facts, nullptr).ends_with("init-scene a.mkv writes a scene file to say it in"));
    facts.unit_doubt = "the unit may be wrong";
    EXPECT_EQ(verdict_on(facts, nullptr), facts.unit_doubt);
}

TEST_F(BarePicture, ImplausibleUnitIsDoubted) {
    const auto facts = [&](const Words& more) {
        return nlohmann::json::parse(run({"info", picture(), "--json"}, more).out, nullptr, false);
    };
    const auto verdict_begins = [](const nlohmann::json& given, const std::string& words) {
        return given["verdict"].get<std::string>().starts_with(words);
    };
    const std::string doubt = ": the unit may be wrong (",
                      mend = "0.418 m if values are millimetres: --depth-unit 0.001)";
    const auto with_unit = [&](const char* unit) { return Words{"--fov", "60", "--depth-unit", unit}; };
    for (const auto& [unit, depth] :
         {std::pair{"1000", "418 km"}, {"1", "418 m"}, {"0.000001", "0.418 mm"}}) {
        const auto told = facts(with_unit(unit));
        EXPECT_EQ(told["verdict"], std::string("the median depth is ") + depth + doubt + mend);
        EXPECT_EQ(std::count(told["notes"].begin(), told["notes"].end(), told["verdict"]), 1)
            << told["notes"];
    }
    for (const char* plausible : {"0.001", "0.0001", "0.1"})
        EXPECT_TRUE(verdict_begins(facts(with_unit(plausible)), "good to touch: ")) << plausible;
    const Outcome touched = run({"touch", picture(), "--seconds", "0.05"}, with_unit("1000"));
    EXPECT_PRED2(says, touched.out, "the median depth is 418 km" + doubt + mend);
    // Packed, or with a scene file of its own, it has no --depth-unit.
    const std::string clip = folder / "packed.mkv", scene = folder / "far.json";
    ASSERT_EQ(run({"convert", picture(), clip}, with_unit("1000")).code, 0);
    EXPECT_TRUE(verdict_begins(json_of({"info", clip, "--json"}), "the median depth is 418 km: the unit "));
    ASSERT_EQ(run({"init-scene", picture(), "--out", scene}, with_unit("0.001")).code, 0);
    auto described = json_in(scene);
    described["metres_per_unit"] = 1000;
    std::ofstream(scene) << described.dump();
    EXPECT_EQ(facts({"--scene", scene})["verdict"],
              "the median depth is 418 m" + doubt +
                  "a scene file's metres_per_unit and depth say otherwise: --scene FILE)");
}

// As much as the pixels of one frame need, twice as much to be touched.
TEST_F(BarePicture, MemoryScalesWithPixels) {
    constexpr int side = 6000;
    [[maybe_unused]] constexpr double mebibytes = 128 + 5.0 * side * side / (1 << 20);
    Image image{side, side, 2, 1, {}};
    image.samples.resize(std::size_t{2} * side * side);
    for (std::size_t k = 0; k < image.samples.size(); k += 2) {
        const std::size_t depth = 1500 + k / 2 % side / 6;
        image.samples[k] = static_cast<std::uint8_t>(depth & 255);
        image.samples[k + 1] = static_cast<std::uint8_t>(depth >> 8);
    }
    ASSERT_TRUE(write_png_to(picture(), image.view(), picture(), PngEffort::quick));
    image = {};
    const Outcome told = run({"info", picture()}, camera);
    EXPECT_EQ(told.code, 0) << told.err;
    const Outcome touched = run({"touch", picture(), "--seconds", "0.02"}, camera);
    EXPECT_EQ(touched.code, 0) << touched.err;
#ifndef TOUCHABLE_SANITIZED
    EXPECT_LE(told.peak_mebibytes, mebibytes);
    EXPECT_LE(touched.peak_mebibytes, 2 * mebibytes);
#endif
}

TEST_F(BarePicture, InitSceneWritesSceneFile) {
    const Outcome written = succeed({"init-scene", picture(), "--fov", "70"});
    EXPECT_PRED2(says, written.out, "my.json");
    EXPECT_PRED2(says, file_contents(folder / "my.json"), "guessed: depth codes are millimetres");
    succeed({"info", folder / "my.json"});
    EXPECT_EQ(run_touchable({"init-scene", picture()}).code, 2) << "it is there already";
    succeed({"init-scene", picture(), "--overwrite"});
    std::filesystem::create_directory(folder / "else");
    const std::string other = folder / "else/other.json";
    const Outcome elsewhere = run_touchable({"init-scene", picture(), "--out", other});
    EXPECT_PRED2(says, elsewhere.out, "touchable play " + picture() + " --scene " + other);
    succeed({"info", picture(), "--scene", other});
    EXPECT_EQ(run_touchable({"init-scene", picture(), "--out", picture(), "--overwrite"}).code, 2);
    EXPECT_EQ(run_touchable({"init-scene", folder / "nothing"}).code, 3);
    EXPECT_PRED2(says, run_touchable({"formats"}).out, "--preset NAME");
}

TEST_F(BarePicture, InitSceneDescribesPackedClip) {
    const std::string clip = folder / "my clip.mkv";
    const std::string as_typed = "'" + clip + "'";
    succeed({"convert", picture(), clip});
    const Outcome told = run({"info", clip}, camera);
    EXPECT_EQ(told.code, 2);
    EXPECT_PRED2(says, told.err, "touchable init-scene " + as_typed);
    EXPECT_EQ(run({"init-scene", clip}, camera).code, 2);
    const Outcome written = succeed({"init-scene", clip});
    const std::string file = folder / "my clip.json";
    EXPECT_PRED2(says, written.out, "touchable play " + as_typed + " --scene '" + file + "'");
    EXPECT_PRED2(says, written.out, "guessed: depth codes are millimetres");
    auto scene = json_in(file);
    EXPECT_FALSE(scene.contains("folder"));
    const auto forces = [&](const std::vector<std::string>& more) {
        const Outcome touched = succeed(plus({"touch", clip, "--seconds", "0.1", "--json", "-"}, more));
        return touched.code == 0 ? nlohmann::json::parse(touched.out)["force_hash"] : nlohmann::json();
    };
    EXPECT_EQ(forces({}), forces({"--scene", file})) << "the same scene";
    scene["camera"]["fx"] = 77;
    std::ofstream(file) << scene.dump();
    const Outcome changed = succeed({"info", clip, "--scene", file, "--json"});
    EXPECT_EQ(nlohmann::json::parse(changed.out)["camera"]["fx"], 77);
}

TEST_F(BarePicture, RejectsInvalidCamera) {
    for (const char* text : {"525,5,525,5", "525,5", "5,525", "525,-200"}) {
        expect_failure({"info", picture(), "--intrinsics", text}, 2, "one more than twice the other");
    }
    const std::string file = folder / "camera.json";
    std::ofstream(file) << R"({"fx": 525, "fy": 5})";
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", file}).code, 2);
    std::filesystem::remove(folder / "camera.json");
    succeed({"info", picture(), "--intrinsics", "52,104"});
    const Outcome far = run_touchable({"info", picture(), "--intrinsics", "50,50,-40,5"});
    EXPECT_PRED2(says, far.out, "the principal point that was said, -40, 5, is far beside the picture");
    EXPECT_FALSE(says(run_touchable({"info", picture(), "--intrinsics", "50,50,8,5"}).out, "far beside"));
    for (const char* text : {"", "50", "50,50,3", "50,fifty", "50,50,1,2,3", "50,nan", "0,50", "50,50,"})
        EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", text}).code, 2) << text;
    for (const Words& more : {Words{"--fov", "180"},
                              {"--intrinsics", "50,50", "--scene", picture()},
                              {"--intrinsics", "50,50", "--depth-unit", "0"}})
        EXPECT_EQ(run({"info", picture()}, more).code, 2) << more.back();
}

// A map of touch for a whole clip, from the command line: the same forces by every way it comes in.

class StillMap : public ::testing::Test {
protected:
    StillMap() {
        make_clip("globe", clip(), {"--size", "64x48", "--frames", "4"});
        Image grey{32, 24, 1, 1, {}};
        for (int k = 0; k < 32 * 24; ++k) grey.samples.push_back(static_cast<std::uint8_t>(k * 7 % 256));
        EXPECT_TRUE(write_png(folder / "s.png", grey.view()));
        std::ofstream(folder / "m.x3d")
            << "<X3D><Scene><HapticTexturesSurface useRelativeValues='false' minStiffness='300' "
               "maxStiffness='900' "
               "staticFriction='0.5' dynamicFriction='0.2'><ImageTexture containerField='stiffnessMap' "
               "url='s.png'/></HapticTexturesSurface></Scene></X3D>";
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string map() const { return folder / "m.x3d"; }
    std::string hash(const std::string& of, std::vector<std::string> more = {}) const {
        more.insert(more.begin(), {of, "--seconds", "0.5"});
        return force_hash(more);
    }
    TemporaryFolder folder;
};

TEST_F(StillMap, GivesSameForcesEverywhere) {
    const std::string plain = hash(clip()), felt = hash(clip(), {"--haptic", map()});
    EXPECT_NE(plain, felt);
    const std::vector<std::string> convert{"convert", clip(), folder / "out.mkv", "--haptic", map()};
    succeed(convert);
    EXPECT_EQ(hash(folder / "out.mkv"), felt);
    succeed({"convert", clip(), folder / "out"});
    auto scene = json_in(folder / "out/scene.json");
    scene["folder"]["haptic"] = "../m.x3d";
    std::ofstream(folder / "out/scene.json") << scene;
    EXPECT_EQ(hash(folder / "out"), felt);
}

TEST_F(StillMap, IsKeptInRecording) {
    const std::string recording = folder / "run.rec";
    const std::vector<std::string> maps{"--haptic", map(), "--height", folder / "s.png"};
    EXPECT_NE(hash(clip(), {"--height", folder / "s.png"}), hash(clip()));
    succeed(plus({"touch", clip(), "--seconds", "0.3", "--record", recording}, maps));
    const Outcome replayed = succeed({"touch", "--replay", recording});
    EXPECT_EQ(replayed.out.find("are not the recorded ones"), std::string::npos);
    std::filesystem::rename(folder / "m.x3d", folder / "moved.x3d");
    const Outcome gone = run_touchable({"touch", "--replay", recording});
    EXPECT_PRED2(says, gone.err, "--haptic FILE");
    succeed({"touch", "--replay", recording, "--haptic", folder / "moved.x3d"});
    expect_failure({"convert", clip(), folder / "s.png", "--overwrite", "--haptic", folder / "moved.x3d"}, 2);
    EXPECT_EQ(run_touchable({"info", clip(), "--haptic", folder / "gone.x3d"}).code, 3);
}

namespace fs = std::filesystem;

/// `touch --picture` and `export --picture` over a small globe.
class Picture : public ::testing::Test {
protected:
    void SetUp() override { succeed({"make", "globe", clip(), "--size", "72x48", "--frames", "6"}); }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string file() const { return folder / "scene.png"; }
    Outcome touch(const std::vector<std::string>& more) const {
        return run_touchable(
            plus({"touch", clip(), "--seconds", "0.5", "--fingers", "3", "--picture", file(), "--overwrite"},
                 more));
    }
    Outcome draw(const std::vector<std::string>& more) const {
        return run_touchable(
            plus({"export", clip(), "--frame", "3", "--picture", file(), "--overwrite"}, more));
    }
    Image image() const {
        auto read = read_image(file());
        EXPECT_TRUE(read);
        return read ? *read : Image{};
    }
    /// Nothing was drawn, and one line says why.
    void expect_refused(const Outcome& outcome, int code, const std::string& why) const {
        expect_failure(outcome, code, why);
        EXPECT_EQ(names_in(folder.path()), Words{"clip.mkv"});
    }

    TemporaryFolder folder;
};

TEST_F(Picture, HasRequestedSize) {
    const Outcome done = touch({"--picture-size", "96x54", "--verbose"});
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(image().width, 96);
    EXPECT_EQ(image().height, 54);
    EXPECT_PRED2(says, done.out, "picture: " + file());
}

TEST_F(Picture, IsRepeatable) {
    ASSERT_EQ(touch({"--picture-size", "96x54", "--record", folder / "run.rec"}).code, 0);
    const std::string first = file_contents(file());
    ASSERT_EQ(touch({"--picture-size", "96x54"}).code, 0);
    EXPECT_EQ(file_contents(file()), first);
    succeed({"touch", "--replay", folder / "run.rec", "--picture", file(), "--picture-size", "96x54",
             "--overwrite"});
    EXPECT_EQ(file_contents(file()), first);
}

TEST_F(Picture, MatchesAcrossPainters) {
    ASSERT_EQ(draw({"--painter", "cpu", "--picture-size", "96x54"}).code, 0);
    const Image cpu = image();
    for (const char* painter : {"raster", "mesh"}) {
        ASSERT_EQ(draw({"--painter", painter, "--picture-size", "96x54"}).code, 0);
        const Image other = image();
        int far_off = 0;
        for (std::size_t k = 0; k < cpu.samples.size(); ++k)
            far_off += std::abs(int{cpu.samples[k]} - int{other.samples[k]}) > 4;
        EXPECT_LE(far_off, 96 * 54 * 3 / 500) << painter;
    }
}

TEST_F(Picture, MatchesWithFramesOnGpu) {
    const std::vector<std::string> uploaded{"--painter", "raster"};
    const std::vector<std::string> there{"--painter", "raster", "--builder", "vulkan"};
    ASSERT_EQ(touch(uploaded).code, 0);
    const std::string touched = file_contents(file());
    ASSERT_EQ(touch(there).code, 0);
    EXPECT_EQ(file_contents(file()), touched);
    ASSERT_EQ(draw(uploaded).code, 0);
    const std::string drawn = file_contents(file());
    ASSERT_EQ(draw(there).code, 0);
    EXPECT_EQ(file_contents(file()), drawn);
}

TEST_F(Picture, UsesRequestedGpu) {
    const Outcome done = touch({"--painter", "raster", "--gpu", "0", "--verbose"});
    EXPECT_EQ(done.code, 0) << done.err;
    const auto gpus = must(list_gpus());
    EXPECT_PRED2(says, done.out, "by the raster painter on " + gpus.at(0).name);
    const auto report =
        test::touch({clip(), "--seconds", "0.5", "--picture", file(), "--painter", "raster", "--gpu", "0"});
    EXPECT_EQ(report["painter"], "raster");
    EXPECT_EQ(report["painter_device_name"], gpus.at(0).name);
    EXPECT_EQ(report["device_name"], report["cpu_name"]);
    EXPECT_EQ(touch({"--painter", "cpu", "--builder", "cpu", "--gpu", "0"}).code, 2);  // for what?
    fs::remove(file());
    for (const char* painter : {"auto", "raster", "mesh"})
        expect_refused(touch({"--painter", painter, "--gpu", "no such device"}), 4, "no such device");
}

TEST_F(Picture, ShowsRequestedMoment) {
    ASSERT_EQ(touch({"--picture-at", "0.3"}).code, 0);
    const std::string usual_moment = file_contents(file());  // 60 % of half a second
    ASSERT_EQ(touch({}).code, 0);
    EXPECT_EQ(file_contents(file()), usual_moment);
    ASSERT_EQ(touch({"--picture-at", "0.45"}).code, 0);
    EXPECT_NE(file_contents(file()), usual_moment);
}

TEST_F(Picture, ShowsRequestedView) {
    ASSERT_EQ(draw({}).code, 0);
    const std::string usual = file_contents(file());
    ASSERT_EQ(draw({"--view", "own"}).code, 0);
    EXPECT_NE(file_contents(file()), usual);
}

TEST_F(Picture, ShowsEveryOverlay) {
    std::set<std::string> pictures;
    for (const char* what : {"colour", "depth", "stiffness", "friction", "dynamic-friction", "height",
                             "normals", "errors", "tiles", "validity"}) {
        ASSERT_EQ(draw({"--show", what, "--painter", "cpu", "--picture-size", "96x54"}).code, 0) << what;
        EXPECT_TRUE(pictures.insert(file_contents(file())).second) << what << " looks like another";
    }
    ASSERT_EQ(draw({"--painter", "cpu", "--picture-size", "96x54"}).code, 0);
    EXPECT_TRUE(pictures.contains(file_contents(file()))) << "colour is the default";
    EXPECT_EQ(touch({"--show", "depth"}).code, 0);
}

TEST_F(Picture, ExportNeedsNoFolder) {
    ASSERT_EQ(draw({}).code, 0);
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"clip.mkv", "scene.png"}));
    ASSERT_EQ(draw({"--out", folder / "out"}).code, 0);
    EXPECT_EQ(names_in(folder.path()), (std::vector<std::string>{"clip.mkv", "out", "scene.png"}));
}

TEST_F(Picture, RejectsSeveralFrames) {
    for (const std::vector<std::string>& words :
         {std::vector<std::string>{"export", clip(), "--frames", "0-2", "--picture", file()},
          std::vector<std::string>{"export", clip(), "--picture", file()}})
        expect_refused(run_touchable(words), 2, "use --frame N");
    expect_refused(run_touchable({"export", clip(), "--frame", "0"}), 2, "--out FOLDER, or --picture FILE");
}

TEST_F(Picture, RejectsInvalidOptionsBeforeRun) {
    expect_refused(touch({"--picture-at", "0.5"}), 2, "beyond the run's end");
    expect_refused(touch({"--view", "above"}), 2,
                   "--view 'above' is not allowed; must be own, or orbit such");
    expect_refused(touch({"--view", "orbit:az=1,el=2,az=3"}), 2, "az is given twice");
    expect_refused(touch({"--view", "orbit:zoom=99"}), 2, "zoom must be a number from 0.1 to 20");
    for (const char* size : {"10", "0x10", "10x", "10x9000", "1e2x10", "-5x5"})
        expect_refused(touch({"--picture-size", size}), 2, std::string("--picture-size: ") + size);
    expect_refused(run_touchable({"touch", clip(), "--seconds", "0.1", "--picture", folder / "no/where.png"}),
                   3, "--picture");
    const TemporaryFolder elsewhere;
    fs::create_directory(elsewhere / "folder.png");
    expect_refused(
        run_touchable({"touch", clip(), "--seconds", "0.1", "--picture", elsewhere / "folder.png"}), 3,
        "--picture");
    EXPECT_EQ(touch({"--painter", "oils"}).code, 2);
    EXPECT_EQ(run_touchable({"touch", clip(), "--view", "own"}).code, 2);  // of what?
    EXPECT_EQ(run_touchable({"touch", clip(), "--show", "depth"}).code, 2);
    expect_refused(
        touch({"--show", "smell"}), 2,
        "unknown overlay 'smell'; must be one of colour, depth, depth-linear, stiffness, friction,");
    EXPECT_EQ(run_touchable({"touch", clip(), "--picture-at", "1"}).code, 2);
}

}  // namespace
}  // namespace touchable::test
