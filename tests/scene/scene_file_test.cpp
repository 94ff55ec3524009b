#include "engine/scene/scene.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/scene/scene_texts.hpp"

namespace touchable {
namespace {

TEST(SceneFile, PlanesHaveNumbersOfTheirOwn) {
    const std::string plain = R"("folder": {"depth": "depth_%04d.png", "colour": "image_%04d.png", )";
    std::string json = recording;
    const auto place = json.find(plain);
    ASSERT_NE(place, std::string::npos);
    json.replace(place, plain.size(),
                 R"("folder": {"depth": {"files": "d%d.png", "step": 3}, "haptic": {"files": "h%d.png"},
                     "colour": {"files": "rgb/%06d.png", "first": 100, "step": 2}, )");
    const FolderSource folder = *parsed(json).folder;
    EXPECT_EQ(folder.depth, "d%d.png");
    EXPECT_EQ(folder.first, 3) << "that of the folder";
    EXPECT_EQ(folder.step, 3);
    EXPECT_EQ(folder.colour, "rgb/%06d.png");
    EXPECT_EQ(folder.colour_numbers, (PictureNumbers{100, 2}));
    EXPECT_EQ(folder.haptic, "h%d.png");
    EXPECT_FALSE(folder.haptic_numbers.any());
}

/// Sessions that were recorded before there was a reach state removal and no reach.
TEST(SceneFile, StatedTerraceRemovalHasTheReachThatItHadUnlessTheFileSaysMore) {
    const auto with = [](const std::string& members) {
        std::string json = recording;
        const std::string plain = R"("fill_holes": 2)";
        return described(json.replace(json.find(plain), plain.size(), plain + members));
    };
    for (const char* const word : {"on", "off"}) {
        const SceneDescription stated = with(std::string(R"(, "terraces": ")") + word + '"');
        EXPECT_EQ(stated.scene.filter.terrace_reach, 16) << word;
        EXPECT_FALSE(stated.unstated.filters.terrace_reach) << word;
    }
    const SceneDescription wide = with(R"(, "terraces": "on", "terrace_reach": 64)");
    EXPECT_EQ(wide.scene.filter.terrace_reach, 64);
    EXPECT_NE(scene_to_json(wide).find("\"terrace_reach\": 64"), std::string::npos);
    EXPECT_TRUE(with("").unstated.filters.terrace_reach);
    EXPECT_FALSE(with(R"(, "terrace_reach": 16)").unstated.filters.terrace_reach);
    EXPECT_TRUE(with(R"(, "terraces": "auto")").unstated.filters.terrace_reach);
    EXPECT_FALSE(with(R"(, "terraces": "auto", "terrace_reach": 16)").unstated.filters.terrace_reach);
}

TEST(SceneFile, RecordingIsReadAsWritten) {
    const Scene scene = parsed(recording);
    EXPECT_EQ(scene.name, "castle");
    EXPECT_EQ(scene.width, 640);
    EXPECT_EQ(scene.height, 480);
    EXPECT_EQ(scene.metres_per_unit, 1.0);
    EXPECT_EQ(scene.camera.fx, 476.0);
    EXPECT_EQ(scene.camera.fy, 476.5);  // negative in the file
    EXPECT_EQ(scene.camera.cx, 312.2);
    EXPECT_EQ(scene.camera.cy, 240.6);
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::metric);
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::planar);
    EXPECT_EQ(scene.depth.scale, 0.000125);
    EXPECT_EQ(scene.depth.valid_min, 1600);
    EXPECT_EQ(scene.depth.valid_max, 12000);
    EXPECT_EQ(scene.depth.invalid_code_count, 2);
    EXPECT_EQ(scene.depth.invalid_codes[1], 65535);
    EXPECT_EQ(scene.depth_bits, 16);
    EXPECT_EQ(scene.depth.code_max, 65535);
    EXPECT_FALSE(described(recording).unstated.far);
    EXPECT_DOUBLE_EQ(scene.default_properties.stiffness, 400);  // N/mm in the file
    EXPECT_EQ(scene.hole_stiffness, 0.1);
    EXPECT_EQ(scene.default_properties.static_friction, 0.5);
    EXPECT_EQ(scene.default_properties.dynamic_friction, 0.25);
    EXPECT_EQ(scene.filter, (FilterSettings{5, 2}));
    EXPECT_EQ(scene.interpolation, FrameInterpolation::hold);
    EXPECT_EQ(scene.device_metres_per_unit, 0.4);
    ASSERT_TRUE(scene.folder);
    EXPECT_EQ(scene.folder->depth, "depth_%04d.png");
    EXPECT_EQ(scene.folder->colour, "image_%04d.png");
    EXPECT_EQ(scene.folder->haptic, "");
    EXPECT_EQ(scene.folder->first, 3);
    EXPECT_EQ(scene.folder->count, 20);
}

TEST(SceneFile, GlobeIsReadAsWritten) {
    const Scene scene = parsed(globe);
    EXPECT_DOUBLE_EQ(scene.camera.fx, 4.7 / 0.0112);
    EXPECT_EQ(scene.camera.fy, scene.camera.fx);
    EXPECT_EQ(scene.camera.cx, 360);
    EXPECT_EQ(scene.camera.cy, 239);
    EXPECT_EQ(scene.rate.num, 30000);
    EXPECT_EQ(scene.rate.den, 1001);
    EXPECT_EQ(scene.depth.kind, DepthCodingKind::linear);
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::range);
    EXPECT_TRUE(scene.depth.near_is_high);
    EXPECT_EQ(scene.depth.code_max, 65535);
    EXPECT_EQ(scene.height_coding.max_height, 2.5);
    EXPECT_EQ(scene.height_coding.units, HeightUnits::levels);
    EXPECT_EQ(scene.height_coding.code_max, 1023);
    EXPECT_EQ(scene.haptic.static_friction.max, 0.9);
    EXPECT_EQ(scene.haptic.dynamic_friction.max, 0.8);
    EXPECT_FALSE(scene.folder);
    EXPECT_FALSE(scene.device_metres_per_unit);
}

TEST(SceneFile, LogMayBeginAtDepthZero) {
    const char* text = R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1},
        "depth": {"coding": "log", "near": 0, "far": 10, "shift": 3.5, "bits": 12, "near_is": "low"}})";
    const DepthCoding log = parsed(text).depth;
    EXPECT_EQ(log.kind, DepthCodingKind::log);
    EXPECT_EQ(log.semantics, DepthSemantics::planar);
    EXPECT_EQ(log.shift, 3.5);
    EXPECT_EQ(log.code_max, 4095);
    EXPECT_EQ(log.valid_min, 1);
    EXPECT_EQ(log.depth(4095), 10);
    EXPECT_NEAR(log.depth(1), 3.5 * std::expm1(std::log(13.5 / 3.5) / 4095), 1e-14);
}

TEST(SceneFile, HueHasDefaultsOfItsOwn) {
    const char* text = R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1}, "depth": {"coding": "hue", "near": 1, "far": 10}})";
    const DepthCoding usual = parsed(text).depth;
    EXPECT_EQ(usual.kind, DepthCodingKind::hue);
    EXPECT_EQ(usual.semantics, DepthSemantics::planar);
    EXPECT_FALSE(usual.near_is_high);
    EXPECT_EQ(usual.code_max, 1536);
    EXPECT_EQ(usual.valid_max, 1536);
    EXPECT_EQ(usual.least_sum, 0);
    EXPECT_EQ(usual.depth(0), 1);
    EXPECT_EQ(usual.depth(768), 5.5);

    std::string given = text;
    given.replace(given.find("\"near\""), 0,
                  R"("near_is": "high", "code_max": 1280, "least_sum": 77, "invalid": [1279], )");
    const DepthCoding other = parsed(given.c_str()).depth;
    EXPECT_EQ(other.depth(1280), 1);
    EXPECT_EQ(other.least_sum, 77);
    EXPECT_FALSE(other.is_valid(1279));
    EXPECT_FALSE(other.is_valid(1281));
}

TEST(SceneFile, EverythingThatMayBeLeftOutHasItsDefault) {
    const Scene scene = parsed(R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1}, "depth": {"coding": "inverse", "near": 1, "far": 10}})");
    EXPECT_EQ(scene.name, "");
    EXPECT_EQ(scene.rate.num, 30);
    EXPECT_EQ(scene.rate.den, 1);
    EXPECT_EQ(scene.metres_per_unit, 0.001);
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::planar);
    EXPECT_TRUE(scene.depth.near_is_high);
    EXPECT_EQ(scene.depth_bits, 8);
    EXPECT_EQ(scene.depth.code_max, 255);
    EXPECT_EQ(scene.depth.invalid_code_count, 0);
    EXPECT_EQ(scene.height_coding.max_height, 0);
    EXPECT_EQ(scene.default_properties.stiffness, 600);
    EXPECT_EQ(scene.default_properties.static_friction, 0.4);
    EXPECT_EQ(scene.default_properties.dynamic_friction, 0.3);
    EXPECT_FALSE(scene.hole_stiffness);
    EXPECT_EQ(scene.filter, (FilterSettings{0, 0, TerraceRemoval::off, 0}));
    EXPECT_EQ(scene.interpolation, FrameInterpolation::linear);
}

TEST(SceneFile, SemanticsPolarityAndCodeMaxCanBeGiven) {
    const Scene scene = parsed(R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1}, "depth": {"coding": "linear", "semantics": "planar",
        "near": 1, "far": 10, "near_is": "low", "bits": 16, "code_max": 1023}})");
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::planar);
    EXPECT_FALSE(scene.depth.near_is_high);
    EXPECT_EQ(scene.depth_bits, 16);
    EXPECT_EQ(scene.depth.code_max, 1023);
    EXPECT_EQ(scene.depth.valid_max, 1023);
}

TEST(SceneFile, MetricWithoutFarLeavesItToTheFrames) {
    const SceneDescription open = described(R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1}, "depth": {"coding": "metric", "scale": 0.001}})");
    EXPECT_TRUE(open.unstated.far);
    const Scene& scene = open.scene;
    EXPECT_EQ(scene.depth.valid_min, 1);  // until the frames are known every code but depth 0 may occur
    EXPECT_EQ(scene.depth.valid_max, 65535);
}

std::string with_remarks(const std::string& remarks) {
    std::string json = recording;
    return json.replace(json.find("\"name\""), 0, "\"remarks\": " + remarks + ", ");
}

TEST(SceneFile, RemarksAreKeptAsTheyAre) {
    const Scene scene = parsed(with_remarks(R"(["guessed: a code is 1 mm", "by hand\n", "guessed:no"])"));
    ASSERT_EQ(scene.remarks.size(), 3U);
    EXPECT_TRUE(scene.remarks[0].is_guess);
    EXPECT_EQ(scene.remarks[0].what, "a code is 1 mm");
    EXPECT_EQ(remark_in_words(scene.remarks[0]), "guessed: a code is 1 mm (a scene file says otherwise)");
    EXPECT_FALSE(scene.remarks[1].is_guess);
    EXPECT_EQ(remark_in_words(scene.remarks[1]), "by hand\\n");
    EXPECT_FALSE(scene.remarks[2].is_guess);
    const auto written = nlohmann::json::parse(scene_to_json(scene));
    EXPECT_EQ(written["remarks"],
              nlohmann::json::parse(R"(["guessed: a code is 1 mm", "by hand\n", "guessed:no"])"));
    EXPECT_EQ(scene_to_json(parsed(scene_to_json(scene))), scene_to_json(scene));
    EXPECT_EQ(nlohmann::json::parse(scene_to_json(parsed(recording))).count("remarks"), 0U);
}

TEST(SceneFile, RemarksBeyondALimitAreRefused) {
    const auto texts = [](std::size_t count, std::size_t length) {
        return nlohmann::json(std::vector<std::string>(count, std::string(length, 'a'))).dump();
    };
    EXPECT_EQ(parsed(with_remarks(texts(100, 2000))).remarks.size(), 100U);
    const auto many = parse_scene(with_remarks(texts(101, 1)), "test.json");
    ASSERT_FALSE(many);
    EXPECT_NE(many.error().message.find("must be an array of at most 100 texts"), std::string::npos);
    const auto lengthy = parse_scene(with_remarks(texts(1, 2001)), "test.json");
    ASSERT_FALSE(lengthy);
    EXPECT_NE(lengthy.error().message.find("remarks[0] is "), std::string::npos);
    EXPECT_NE(lengthy.error().message.find("must be a text of at most 2000 bytes"), std::string::npos);
}

TEST(SceneFile, AddedRemarksAreOneEachAndCanBeReadAgain) {
    Scene scene = parsed(recording);
    for (const char* what : {"a", "b", "a"}) add_remark(scene.remarks, {what, true});
    add_remark(scene.remarks, {"a"});  // no guess, and so another
    EXPECT_EQ(scene.remarks.size(), 3U);
    for (int n = 0; n < 200; ++n)  // of bytes that are no text
        add_remark(scene.remarks,
                   {std::to_string(n) + std::string(5000, '\xff'), true, "a wider view says otherwise"});
    EXPECT_EQ(scene.remarks.size(), 100U);
    EXPECT_EQ(parsed(scene_to_json(scene)).remarks.size(), 100U);
}

TEST(SceneFile, ExamplesOfTheDocumentationAreScenes) {
    std::ifstream page(std::string(TOUCHABLE_SOURCE_DIR) + "/docs/scene_file.md");
    std::string line, example;
    bool inside = false;
    int examples = 0;
    while (std::getline(page, line)) {
        if (inside && line == "```") {
            const auto scene = parse_scene(example, "scene_file.md");
            EXPECT_TRUE(scene) << scene.error().message;
            ++examples;
            inside = false;
        } else if (line == "```json") {
            inside = true;
            example.clear();
        } else if (inside) {
            example += line + "\n";
        }
    }
    EXPECT_EQ(examples, 7);
}

class SceneFileOnDisk : public testing::Test {
protected:
    void SetUp() override { std::filesystem::create_directories(folder_); }
    void TearDown() override { std::filesystem::remove_all(folder_); }
    std::filesystem::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    const std::filesystem::path folder_ =
        std::filesystem::path(testing::TempDir()) /
        (std::string("touchable_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(SceneFileOnDisk, IsReadFromItsPath) {
    const auto scene = read_scene_file(write("scene.json", std::string("\xef\xbb\xbf") + globe + "\n"));
    ASSERT_TRUE(scene) << scene.error().message;
    EXPECT_EQ(scene->scene.name, "globe");
}

TEST_F(SceneFileOnDisk, ThatCannotBeReadIsRefusedByItsName) {
    const std::pair<std::filesystem::path, std::string> files[] = {{folder_ / "absent.json", "is not there"},
                                                                   {folder_, "is a folder"}};
    for (const auto& [file, why] : files) {
        const auto scene = read_scene_file(file);
        ASSERT_FALSE(scene);
        EXPECT_EQ(scene.error().kind, ErrorKind::input);
        EXPECT_EQ(scene.error().message,
                  file.string() + ": " + why + "; right would be a scene file (JSON, docs/scene_file.md)");
    }
}

TEST_F(SceneFileOnDisk, ThatIsEmptyOrEndlessIsRefused) {
    EXPECT_NE(read_scene_file(write("empty.json", "")).error().message.find("empty.json: line 1"),
              std::string::npos);
    EXPECT_NE(read_scene_file(write("long.json", std::string(3 << 20, ' ')))
                  .error()
                  .message.find("larger than 1 MiB"),
              std::string::npos);
}

}  // namespace
}  // namespace touchable
