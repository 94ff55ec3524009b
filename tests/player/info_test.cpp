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
#include "player/commands/clip_facts.hpp"
#include "tests/limits.hpp"
#include "tests/player/program.hpp"
#include "tests/player/touched.hpp"

namespace touchable::test {
namespace {

nlohmann::json facts_of(const std::vector<std::string>& words) {
    const Outcome run = run_touchable(words);
    EXPECT_EQ(run.code, 0) << run.err;
    return nlohmann::json::parse(run.out, nullptr, false);
}

TEST(Info, GlobeHasPapersFov) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--frames", "2"}).code, 0);
    const auto facts = facts_of({"info", clip, "--json"});
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
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--frames", "1", "--bits", "8", "--plain"}).code, 0);
    const auto kappa = facts_of({"info", clip, "--json"})["kappa"];
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
        ASSERT_EQ(run_touchable({"make", "globe", clip, "--frames", "1", "--bits", bits, "--plain"}).code, 0);
        const auto facts = facts_of({"info", clip, "--json"});
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
        EXPECT_NE(run_touchable({"info", clip}).out.find(said), std::string::npos) << bits;
        const auto off = facts_of({"info", clip, "--filters", "off", "--json"});
        EXPECT_EQ(off["filters"]["terraces"], false) << bits;
        EXPECT_EQ(off["terraces"]["advised"], advised) << bits;
    }
}

TEST(Info, PrintsFactsAsText) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    ASSERT_EQ(run_touchable({"make", "plane", clip, "--size", "64x48", "--frames", "3"}).code, 0);
    const Outcome run = run_touchable({"info", clip});
    EXPECT_EQ(run.code, 0);
    for (const char* fact : {"64x48", "3 frames", "30 frames/s", "field of view", "16 bits", "kappa",
                             "t3d2 without loss", "filters      none needed"})
        EXPECT_NE(run.out.find(fact), std::string::npos) << fact << " is missing in\n" << run.out;
}

TEST(Info, ExplainsKappaStep) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--frames", "1", "--bits", "8", "--plain"}).code, 0);
    const Outcome plain = run_touchable({"info", clip});
    EXPECT_NE(plain.out.find("(depth of one code / width of a pixel)"), std::string::npos) << plain.out;
    EXPECT_NE(plain.out.find(" of a pixel's width, no sign of a camera)"), std::string::npos) << plain.out;
    const std::string file = folder / "levels.json";
    ASSERT_EQ(run_touchable({"init-scene", clip, "--out", file}).code, 0);
    auto scene = nlohmann::json::parse(file_contents(file));
    scene["filter"]["levels"] = {5, 0};
    std::ofstream(file) << scene.dump();
    const Outcome levels = run_touchable({"info", clip, "--scene", file});
    EXPECT_NE(levels.out.find("(distance of two levels / width of a pixel)"), std::string::npos)
        << levels.out << levels.err;
}

TEST(Info, EndsWithVerdict) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--frames", "1", "--bits", "8"}).code, 0);
    const auto verdict = [](const std::vector<std::string>& words) {
        return facts_of(words)["verdict"].get<std::string>();
    };
    EXPECT_EQ(verdict({"info", clip, "--json"}), "good to touch: touchable play " + clip);
    const std::string rough = verdict({"info", clip, "--json", "--terraces", "off"});
    EXPECT_TRUE(rough.starts_with("rough: smooth places lean ")) << rough;
    EXPECT_TRUE(rough.ends_with("with other filters: touchable play " + clip + " --filters auto")) << rough;
    // In a hand's terms, by the table of hand_thresholds.hpp: 18.4 degrees are just noticed.
    const auto tried = facts_of({"info", clip, "--json"})["filters"]["measured"]["tried"];
    ASSERT_FALSE(tried.empty());
    for (const auto& one : tried)
        EXPECT_NEAR(one["left_jnd"], one["left_degrees"].get<double>() / 18.4, 1e-12);
    const auto jnd = rough.find(" to and fro (");
    ASSERT_NE(jnd, std::string::npos) << rough;
    EXPECT_NEAR(std::stod(rough.substr(jnd + 13)),
                std::stod(rough.substr(std::string("rough: smooth places lean ").size())) / 18.4, 0.06);
    EXPECT_NE(rough.find(" of what a hand just notices where it sees the scene), and "), std::string::npos);
    const std::string text = run_touchable({"info", clip}).out;
    EXPECT_NE(text.find(" of what a hand just notices where it sees the scene), "), std::string::npos)
        << text;
    EXPECT_NE(text.find("\n  verdict      good to touch: touchable play " + clip + "\n"), std::string::npos);
    EXPECT_NE(text.find("; smooth places lean "), std::string::npos) << "what the filter did";
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
    EXPECT_NE(run.out.find(" m its force cannot be trusted\n"), std::string::npos) << run.out << run.err;
    auto as_json = words;
    as_json.emplace_back("--json");
    const auto filters = facts_of(as_json)["filters"];
    ASSERT_TRUE(filters.contains("trusted_to")) << filters;
    EXPECT_NEAR(filters["trusted_to"], 3.5, 0.4);
    EXPECT_FALSE(
        facts_of({"info", folder / "", "--depth-unit", "0.001", "--fov", "60", "--json"})["filters"].contains(
            "trusted_to"))
        << "pixels are three times as wide";
}

TEST(Info, VerdictAsksForGuessedCamera) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", pictures = folder / "pictures";
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--frames", "1"}).code, 0);
    ASSERT_EQ(run_touchable({"convert", clip, pictures}).code, 0);
    std::filesystem::remove(std::filesystem::path(pictures) / "scene.json");
    const auto facts = facts_of({"info", pictures, "--json", "--depth-unit", "0.0002"});
    EXPECT_NE(facts["verdict"].get<std::string>().find("say what it sees"), std::string::npos)
        << facts["verdict"];
    const auto told = facts_of({"info", pictures, "--json", "--fov", "81"});
    EXPECT_EQ(told["verdict"].get<std::string>().find("say what it sees"), std::string::npos)
        << told["verdict"];
}

TEST(Info, NamesDefaultStiffnessOnce) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    ASSERT_EQ(run_touchable({"make", "plane", clip, "--size", "64x48", "--frames", "1"}).code, 0);
    const Outcome run = run_touchable({"info", clip});
    const std::size_t at = run.out.find("0.6 N/mm");
    ASSERT_NE(at, std::string::npos) << run.out;
    EXPECT_EQ(run.out.find("0.6 N/mm", at + 1), std::string::npos) << run.out;
}

// The example of docs/scene_file.md is what `make globe` writes.
TEST(Info, GlobeSceneMatchesDocumentation) {
    const std::string page = file_contents(TOUCHABLE_SOURCE_DIR "/docs/scene_file.md");
    const std::size_t chapter = page.find("## A generated clip"), begin = page.find('{', chapter);
    ASSERT_NE(chapter, std::string::npos);
    auto documented = parse_scene(page.substr(begin, page.find("```", begin) - begin), "scene_file.md");
    ASSERT_TRUE(documented) << documented.error().message;
    documented->unstated.rate = false;  // the clip states the default
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv";
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--frames", "1"}).code, 0);
    const auto reader = open_clip(clip);
    ASSERT_TRUE(reader);
    EXPECT_EQ(scene_to_json(*documented), scene_to_json((*reader)->described()));
}

TEST(Info, ReadsEveryScene) {
    const TemporaryFolder folder;
    for (const char* scene :
         {"globe", "bumps", "rough", "moving", "plane", "spheres", "step", "noise", "cliffs"}) {
        const std::string clip = folder / (std::string(scene) + ".mkv");
        ASSERT_EQ(
            run_touchable({"make", scene, clip, "--size", "64x48", "--frames", "1", "--bits", "12"}).code, 0)
            << scene;
        const auto facts = facts_of({"info", clip, "--json"});
        EXPECT_EQ(facts["depth"]["bits"], 12) << scene;
        EXPECT_LE(facts["first_frame"]["nearest"], facts["first_frame"]["farthest"]) << scene;
    }
}

TEST(Info, RejectsDamagedClip) {
    const TemporaryFolder folder;
    const std::string clip = folder / "globe.mkv", half = folder / "half.mkv", text = folder / "text.mkv";
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "72x48", "--frames", "2"}).code, 0);
    std::filesystem::copy_file(clip, half);
    std::filesystem::resize_file(half, 600);
    std::filesystem::copy_file(TOUCHABLE_SOURCE_DIR "/CMakeLists.txt", text);
    for (const std::string& damaged : {half, text, folder.path().string()}) {
        const Outcome run = run_touchable({"info", damaged});
        EXPECT_EQ(run.code, 3) << damaged;
        EXPECT_TRUE(run.one_line_of_error()) << run.err;
        EXPECT_NE(run.err.find(damaged), std::string::npos) << run.err;
    }
}

// A far plane that is not given is searched in up to 32 frames, which are large here.
TEST(Info, FarPlaneSearchIsInterruptible) {
    const TemporaryFolder folder;
    const std::string clip = folder / "clip.mkv";
    ASSERT_EQ(run_touchable({"make", "noise", clip, "--size", "2048x1536", "--frames", "1"}).code, 0);
    ASSERT_EQ(run_touchable({"export", clip, "--frame", "0", "--out", folder / "out"}).code, 0);
    for (int n = 0; n < 40; ++n)
        std::filesystem::create_symlink("depth.png", folder / ("out/d" + std::to_string(n) + ".png"));
    auto scene = nlohmann::json::parse(file_contents(folder / "out/scene.json"));
    scene["depth"] = {{"coding", "metric"}, {"bits", scene["depth"]["bits"]}, {"scale", 0.01}};
    scene["folder"] = {{"depth", "d%d.png"}};
    std::ofstream(folder / "out/scene.json") << scene;
    const Outcome run = run_interrupted_at_once({"info", folder / "out"});
    EXPECT_EQ(run.code, 130) << run.err;
    EXPECT_TRUE(run.one_line_of_error()) << run.err;
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
    EXPECT_GT(nlohmann::json::parse(file_contents(report))["contact_ticks"], 100);
    const Outcome replayed = run_touchable({"touch", "--replay", recording});
    EXPECT_EQ(replayed.code, 0) << replayed.err;
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
    const Outcome replayed = run_touchable({"touch", "--replay", recording});
    EXPECT_EQ(replayed.code, 0) << replayed.err;
    for (const char* word : {"range", "planar"}) {
        const Outcome exported =
            run({"export", picture(), "--frame", "0", "--depth", word, "--out", out + word}, camera);
        ASSERT_EQ(exported.code, 0) << exported.err;
        const auto codes = nlohmann::json::parse(file_contents(out + word + "/codes.json"));
        EXPECT_EQ(codes["depth"]["semantics"], word);
    }
    EXPECT_EQ(run({"info", picture(), "--depth", "sideways"}, camera).code, 2);
}

TEST_F(BarePicture, GuessesMissingCamera) {
    const std::string recording = folder / "run.rec";
    const Outcome touched = run_touchable({"touch", picture(), "--seconds", "0.1", "--record", recording});
    ASSERT_EQ(touched.code, 0) << touched.err;
    EXPECT_NE(touched.out.find(" guessed of the clip (touchable info says which)"), std::string::npos)
        << touched.out;
    EXPECT_NE(run_touchable({"touch", picture(), "--seconds", "0.1", "--verbose"})
                  .out.find("guessed: the camera sees 60 degrees"),
              std::string::npos);
    EXPECT_EQ(run_touchable({"touch", "--replay", recording}).code, 0);
    const Outcome wide = run_touchable({"touch", picture(), "--seconds", "0.1", "--fov", "90", "--preset",
                                        "realsense", "--record", recording, "--overwrite"});
    ASSERT_EQ(wide.code, 0) << wide.err;
    EXPECT_EQ(run_touchable({"touch", "--replay", recording}).code, 0);
    EXPECT_EQ(run_touchable({"info", picture(), "--preset", "none"}).code, 2);
}

TEST_F(BarePicture, CameraFileReplacesGuess) {
    std::ofstream(folder / "camera.json")
        << R"({"width": 120, "height": 80, "fx": 100, "fy": 100, "cx": 59.5, "cy": 39.5})";
    const std::string own = "the camera is that of camera.json (--intrinsics FX,FY,CX,CY says otherwise)\n",
                      scaled =
                          "camera.json is of 120x80 pixels and is scaled to these pictures (--intrinsics";
    const Outcome told = run_touchable({"info", picture()});
    EXPECT_NE(told.out.find("  note         " + own), std::string::npos) << told.out;
    EXPECT_NE(told.out.find("  note         " + scaled), std::string::npos) << told.out;
    EXPECT_NE(told.out.find("verdict      good to touch if the unit is right (depth codes are millimetres: "),
              std::string::npos)
        << told.out;
    EXPECT_NE(run({"info", picture()}, {"--depth-unit", "0.001"})
                  .out.find("verdict      good to touch: touchable play "),
              std::string::npos);
    const Outcome window = run_touchable(
        {"play", picture(), "--headless", "--seconds", "0.1", "--painter", "cpu", "--builder", "cpu"});
    ASSERT_EQ(window.code, 0) << window.err;
    EXPECT_NE(window.err.find("touchable: " + own), std::string::npos) << window.err;
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

TEST_F(BarePicture, VerdictSuggestsSceneFile) {
    const std::string clip = folder / "clip.mkv";
    ASSERT_EQ(run({"convert", picture(), clip}, {"--depth-unit", "0.001"}).code, 0);
    const auto told = nlohmann::json::parse(run_touchable({"info", clip, "--json"}).out, nullptr, false);
    EXPECT_EQ(
        told["verdict"],
        "good to touch if the camera is right (the camera sees 60 degrees from left to right; if it sees 70, "
        "all shapes are 18 % too narrow): touchable init-scene " +
            clip + " writes a scene file to say it in");
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
    EXPECT_NE(touched.out.find("the median depth is 418 km" + doubt + mend), std::string::npos)
        << touched.out << touched.err;
    // Packed, or with a scene file of its own, it has no --depth-unit.
    const std::string clip = folder / "packed.mkv", scene = folder / "far.json";
    ASSERT_EQ(run({"convert", picture(), clip}, with_unit("1000")).code, 0);
    EXPECT_TRUE(
        verdict_begins(nlohmann::json::parse(run_touchable({"info", clip, "--json"}).out, nullptr, false),
                       "the median depth is 418 km: the unit "));
    ASSERT_EQ(run({"init-scene", picture(), "--out", scene}, with_unit("0.001")).code, 0);
    auto described = nlohmann::json::parse(file_contents(scene));
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
    const Outcome written = run_touchable({"init-scene", picture(), "--fov", "70"});
    ASSERT_EQ(written.code, 0) << written.err;
    EXPECT_NE(written.out.find("my.json"), std::string::npos);
    EXPECT_NE(file_contents(folder / "my.json").find("guessed: depth codes are millimetres"),
              std::string::npos);
    EXPECT_EQ(run_touchable({"info", folder / "my.json"}).code, 0);
    EXPECT_EQ(run_touchable({"init-scene", picture()}).code, 2) << "it is there already";
    EXPECT_EQ(run_touchable({"init-scene", picture(), "--overwrite"}).code, 0);
    std::filesystem::create_directory(folder / "else");
    const std::string other = folder / "else/other.json";
    const Outcome elsewhere = run_touchable({"init-scene", picture(), "--out", other});
    EXPECT_NE(elsewhere.out.find("touchable play " + picture() + " --scene " + other), std::string::npos)
        << elsewhere.out;
    EXPECT_EQ(run_touchable({"info", picture(), "--scene", other}).code, 0);
    EXPECT_EQ(run_touchable({"init-scene", picture(), "--out", picture(), "--overwrite"}).code, 2);
    EXPECT_EQ(run_touchable({"init-scene", folder / "nothing"}).code, 3);
    EXPECT_NE(run_touchable({"formats"}).out.find("--preset NAME"), std::string::npos);
}

TEST_F(BarePicture, InitSceneDescribesPackedClip) {
    const std::string clip = folder / "my clip.mkv";
    const std::string as_typed = "'" + clip + "'";
    ASSERT_EQ(run_touchable({"convert", picture(), clip}).code, 0);
    const Outcome told = run({"info", clip}, camera);
    EXPECT_EQ(told.code, 2);
    EXPECT_NE(told.err.find("touchable init-scene " + as_typed), std::string::npos) << told.err;
    EXPECT_EQ(run({"init-scene", clip}, camera).code, 2);
    const Outcome written = run_touchable({"init-scene", clip});
    ASSERT_EQ(written.code, 0) << written.err;
    const std::string file = folder / "my clip.json";
    EXPECT_NE(written.out.find("touchable play " + as_typed + " --scene '" + file + "'"), std::string::npos)
        << written.out;
    EXPECT_NE(written.out.find("guessed: depth codes are millimetres"), std::string::npos) << written.out;
    auto scene = nlohmann::json::parse(file_contents(file));
    EXPECT_FALSE(scene.contains("folder"));
    const auto forces = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{"touch", clip, "--seconds", "0.1", "--json", "-"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome touched = run_touchable(words);
        EXPECT_EQ(touched.code, 0) << touched.err;
        return touched.code == 0 ? nlohmann::json::parse(touched.out)["force_hash"] : nlohmann::json();
    };
    EXPECT_EQ(forces({}), forces({"--scene", file})) << "the same scene";
    scene["camera"]["fx"] = 77;
    std::ofstream(file) << scene.dump();
    const Outcome changed = run_touchable({"info", clip, "--scene", file, "--json"});
    ASSERT_EQ(changed.code, 0) << changed.err;
    EXPECT_EQ(nlohmann::json::parse(changed.out)["camera"]["fx"], 77);
}

TEST_F(BarePicture, InitSceneReportsFullDisk) {
    const Outcome full = run_on_full_disk({"init-scene", picture()}, 0);
    EXPECT_EQ(full.code, 3);
    EXPECT_NE(full.err.find("my.json: cannot be written: File too large"), std::string::npos) << full.err;
    EXPECT_FALSE(std::filesystem::exists(folder / "my.json"));
}

TEST_F(BarePicture, RejectsDecimalCommasInCamera) {
    for (const char* text : {"525,5,525,5", "525,5", "5,525", "525,-200"}) {
        const Outcome told = run_touchable({"info", picture(), "--intrinsics", text});
        EXPECT_EQ(told.code, 2) << text;
        EXPECT_NE(told.err.find("one more than twice the other"), std::string::npos) << told.err;
    }
    const std::string file = folder / "camera.json";
    std::ofstream(file) << R"({"fx": 525, "fy": 5})";
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", file}).code, 2);
    std::filesystem::remove(folder / "camera.json");
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", "52,104"}).code, 0);
    const Outcome far = run_touchable({"info", picture(), "--intrinsics", "50,50,-40,5"});
    EXPECT_NE(far.out.find("the principal point that was said, -40, 5, is far beside the picture"),
              std::string::npos)
        << far.out;
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", "50,50,8,5"}).out.find("far beside"),
              std::string::npos);
}

TEST_F(BarePicture, RejectsInvalidCamera) {
    for (const char* text : {"", "50", "50,50,3", "50,fifty", "50,50,1,2,3", "50,nan", "0,50", "50,50,"})
        EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", text}).code, 2) << text;
    EXPECT_EQ(run_touchable({"info", picture(), "--fov", "180"}).code, 2);
    EXPECT_EQ(run({"info", picture(), "--scene", picture()}, camera).code, 2);
    EXPECT_EQ(run_touchable({"info", picture(), "--intrinsics", "50,50", "--depth-unit", "0"}).code, 2);
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
    const Outcome converted = run_touchable(convert);
    ASSERT_EQ(converted.code, 0) << converted.err;
    EXPECT_EQ(hash(folder / "out.mkv"), felt);
    EXPECT_EQ(run_touchable({"convert", clip(), folder / "out"}).code, 0);
    auto scene = nlohmann::json::parse(file_contents(folder / "out/scene.json"));
    scene["folder"]["haptic"] = "../m.x3d";
    std::ofstream(folder / "out/scene.json") << scene;
    EXPECT_EQ(hash(folder / "out"), felt);
}

TEST_F(StillMap, IsKeptInRecording) {
    const std::string recording = folder / "run.rec";
    const std::vector<std::string> maps{"--haptic", map(), "--height", folder / "s.png"};
    EXPECT_NE(hash(clip(), {"--height", folder / "s.png"}), hash(clip()));
    std::vector<std::string> words{"touch", clip(), "--seconds", "0.3", "--record", recording};
    words.insert(words.end(), maps.begin(), maps.end());
    const Outcome touched = run_touchable(words);
    ASSERT_EQ(touched.code, 0) << touched.err;
    const Outcome replayed = run_touchable({"touch", "--replay", recording});
    EXPECT_EQ(replayed.code, 0) << replayed.err;
    EXPECT_EQ(replayed.out.find("are not the recorded ones"), std::string::npos);
    std::filesystem::rename(folder / "m.x3d", folder / "moved.x3d");
    const Outcome gone = run_touchable({"touch", "--replay", recording});
    EXPECT_NE(gone.err.find("--haptic FILE"), std::string::npos) << gone.err;
    EXPECT_EQ(run_touchable({"touch", "--replay", recording, "--haptic", folder / "moved.x3d"}).code, 0);
    const Outcome over =
        run_touchable({"convert", clip(), folder / "s.png", "--overwrite", "--haptic", folder / "moved.x3d"});
    EXPECT_EQ(over.code, 2);
    EXPECT_TRUE(over.one_line_of_error()) << over.err;
    EXPECT_EQ(run_touchable({"info", clip(), "--haptic", folder / "gone.x3d"}).code, 3);
}

namespace fs = std::filesystem;

/// `touch --picture` and `export --picture` over a small globe.
class Picture : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_EQ(run_touchable({"make", "globe", clip(), "--size", "72x48", "--frames", "6"}).code, 0);
    }
    std::string clip() const { return folder / "clip.mkv"; }
    std::string file() const { return folder / "scene.png"; }
    Outcome touch(const std::vector<std::string>& more) const {
        std::vector<std::string> words{"touch", clip(),      "--seconds", "0.5",        "--fingers",
                                       "3",     "--picture", file(),      "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        return run_touchable(words);
    }
    Outcome draw(const std::vector<std::string>& more) const {
        std::vector<std::string> words{"export", clip(), "--frame", "3", "--picture", file(), "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        return run_touchable(words);
    }
    Image image() const {
        auto read = read_image(file());
        EXPECT_TRUE(read);
        return read ? *read : Image{};
    }
    /// Nothing was drawn, and one line says why.
    void expect_refused(const Outcome& outcome, int code, const std::string& why) const {
        EXPECT_EQ(outcome.code, code) << outcome.err;
        EXPECT_TRUE(outcome.one_line_of_error()) << outcome.err;
        EXPECT_NE(outcome.err.find(why), std::string::npos) << outcome.err;
        EXPECT_EQ(names_in(folder.path()), std::vector<std::string>{"clip.mkv"});
    }

    TemporaryFolder folder;
};

TEST_F(Picture, HasRequestedSize) {
    const Outcome done = touch({"--picture-size", "96x54", "--verbose"});
    EXPECT_EQ(done.code, 0) << done.err;
    EXPECT_EQ(image().width, 96);
    EXPECT_EQ(image().height, 54);
    EXPECT_NE(done.out.find("picture: " + file()), std::string::npos) << done.out;
}

TEST_F(Picture, IsRepeatable) {
    ASSERT_EQ(touch({"--picture-size", "96x54", "--record", folder / "run.rec"}).code, 0);
    const std::string first = file_contents(file());
    ASSERT_EQ(touch({"--picture-size", "96x54"}).code, 0);
    EXPECT_EQ(file_contents(file()), first);
    ASSERT_EQ(run_touchable({"touch", "--replay", folder / "run.rec", "--picture", file(), "--picture-size",
                             "96x54", "--overwrite"})
                  .code,
              0);
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
    const auto gpus = list_gpus();
    ASSERT_TRUE(gpus);
    EXPECT_NE(done.out.find("by the raster painter on " + gpus->at(0).name), std::string::npos) << done.out;
    const auto report =
        test::touch({clip(), "--seconds", "0.5", "--picture", file(), "--painter", "raster", "--gpu", "0"});
    EXPECT_EQ(report["painter"], "raster");
    EXPECT_EQ(report["painter_device_name"], gpus->at(0).name);
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
                             "normals", "tiles", "validity"}) {
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

TEST_F(Picture, RejectsMomentAfterEnd) {
    expect_refused(touch({"--picture-at", "0.5"}), 2, "beyond the run's end");
}

}  // namespace
}  // namespace touchable::test
