#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

nlohmann::json facts_of(const std::vector<std::string>& words) {
    const Outcome run = run_touchable(words);
    EXPECT_EQ(run.code, 0) << run.err;
    return nlohmann::json::parse(run.out, nullptr, false);
}

TEST(Info, GlobeOfPresetBHasThePapersFieldsOfView) {
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
TEST(Info, KappaIsTheStepOfOneCodeOverTheWidthOfAPixel) {
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

TEST(Info, AdvisesTerraceRemovalWhereStepsAreSteep) {
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

TEST(Info, TellsAPersonTheSame) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    ASSERT_EQ(run_touchable({"make", "plane", clip, "--size", "64x48", "--frames", "3"}).code, 0);
    const Outcome run = run_touchable({"info", clip});
    EXPECT_EQ(run.code, 0);
    for (const char* fact : {"64x48", "3 frames", "30 frames/s", "field of view", "16 bits", "kappa",
                             "t3d2 without loss", "filters      none needed"})
        EXPECT_NE(run.out.find(fact), std::string::npos) << fact << " is missing in\n" << run.out;
}

TEST(Info, SaysOfWhichStepKappaIsAndWhatDecidesOnAMedian) {
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

TEST(Info, EndsWithAVerdict) {
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
    const std::string text = run_touchable({"info", clip}).out;
    EXPECT_NE(text.find("\n  verdict      good to touch: touchable play " + clip + "\n"), std::string::npos);
    EXPECT_NE(text.find("; smooth places lean "), std::string::npos) << "what the filter did";
}

TEST(Info, OfAGuessedCameraTheVerdictIsToSayWhatItSees) {
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

TEST(Info, TellsOnceWhatStandsForAHapticPlane) {
    const TemporaryFolder folder;
    const std::string clip = folder / "plane.mkv";
    ASSERT_EQ(run_touchable({"make", "plane", clip, "--size", "64x48", "--frames", "1"}).code, 0);
    const Outcome run = run_touchable({"info", clip});
    const std::size_t at = run.out.find("0.6 N/mm");
    ASSERT_NE(at, std::string::npos) << run.out;
    EXPECT_EQ(run.out.find("0.6 N/mm", at + 1), std::string::npos) << run.out;
}

// The example of docs/scene_file.md is what `make globe` writes.
TEST(Info, GlobesSceneIsTheOneDocumented) {
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

TEST(Info, DamagedClipIsCode3) {
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
TEST(Info, InterruptedWhileTheFarPlaneIsSearchedIsCode130) {
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

}  // namespace
}  // namespace touchable::test
