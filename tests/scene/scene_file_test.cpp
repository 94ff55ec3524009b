// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "engine/scene/scene.hpp"
#include "tests/must.hpp"
#include "tests/scene/scene_texts.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

TEST(SceneFile, NumbersPlanesSeparately) {
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
TEST(SceneFile, KeepsReachOfStatedRemoval) {
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

TEST(SceneFile, KeepsDetail) {
    const auto with = [](const std::string& detail) {
        std::string json = recording;
        const std::string plain = R"("fill_holes": 2)";
        return parse_scene(json.replace(json.find(plain), plain.size(), plain + R"(, "detail": )" + detail),
                           "here");
    };
    const auto stated = with("0.25");
    ASSERT_TRUE(stated) << stated.error().message;
    EXPECT_EQ(stated->unstated.filters.detail, 0.25);
    EXPECT_NE(scene_to_json(*stated).find("\"detail\": 0.25"), std::string::npos);
    EXPECT_EQ(described(recording).unstated.filters.detail, std::nullopt);
    for (const char* const wrong : {"-0.1", "1.5", "\"on\"", "1, \"levels\": [1, 0]"})
        EXPECT_FALSE(with(wrong)) << wrong;
}

TEST(SceneFile, ReadsRecording) {
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

TEST(SceneFile, ReadsGlobe) {
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

/// A scene of 4x3 pixels with these members of depth.
SceneDescription described_depth(const std::string& members) {
    return described(R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1}, "depth": {)" +
                     members + "}}");
}

TEST(SceneFile, ReadsLogFromZero) {
    const DepthCoding log =
        described_depth(
            R"("coding": "log", "near": 0, "far": 10, "shift": 3.5, "bits": 12, "near_is": "low")")
            .scene.depth;
    EXPECT_EQ(log.kind, DepthCodingKind::log);
    EXPECT_EQ(log.semantics, DepthSemantics::planar);
    EXPECT_EQ(log.shift, 3.5);
    EXPECT_EQ(log.code_max, 4095);
    EXPECT_EQ(log.valid_min, 1);
    EXPECT_EQ(log.depth(4095), 10);
    EXPECT_NEAR(log.depth(1), 3.5 * std::expm1(std::log(13.5 / 3.5) / 4095), 1e-14);
}

TEST(SceneFile, ReadsHueDefaults) {
    const std::string members = R"("coding": "hue", "near": 1, "far": 10)";
    const DepthCoding usual = described_depth(members).scene.depth;
    EXPECT_EQ(usual.kind, DepthCodingKind::hue);
    EXPECT_EQ(usual.semantics, DepthSemantics::planar);
    EXPECT_FALSE(usual.near_is_high);
    EXPECT_EQ(usual.code_max, 1536);
    EXPECT_EQ(usual.valid_max, 1536);
    EXPECT_EQ(usual.least_sum, 0);
    EXPECT_EQ(usual.depth(0), 1);
    EXPECT_EQ(usual.depth(768), 5.5);

    const std::string more = R"(, "near_is": "high", "code_max": 1280, "least_sum": 77, "invalid": [1279])";
    const DepthCoding other = described_depth(members + more).scene.depth;
    EXPECT_EQ(other.depth(1280), 1);
    EXPECT_EQ(other.least_sum, 77);
    EXPECT_FALSE(other.is_valid(1279));
    EXPECT_FALSE(other.is_valid(1281));
}

TEST(SceneFile, FillsInDefaults) {
    const Scene scene = described_depth(R"("coding": "inverse", "near": 1, "far": 10)").scene;
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

TEST(SceneFile, ReadsStatedCoding) {
    const Scene scene = described_depth(R"("coding": "linear", "semantics": "planar",
        "near": 1, "far": 10, "near_is": "low", "bits": 16, "code_max": 1023)")
                            .scene;
    EXPECT_EQ(scene.depth.semantics, DepthSemantics::planar);
    EXPECT_FALSE(scene.depth.near_is_high);
    EXPECT_EQ(scene.depth_bits, 16);
    EXPECT_EQ(scene.depth.code_max, 1023);
    EXPECT_EQ(scene.depth.valid_max, 1023);
}

TEST(SceneFile, LeavesMetricFarToFrames) {
    const SceneDescription open = described_depth(R"("coding": "metric", "scale": 0.001)");
    EXPECT_TRUE(open.unstated.far);
    const Scene& scene = open.scene;
    EXPECT_EQ(scene.depth.valid_min, 1);  // until the frames are known every code but depth 0 may occur
    EXPECT_EQ(scene.depth.valid_max, 65535);
}

std::string with_remarks(const std::string& remarks) {
    std::string json = recording;
    return json.replace(json.find("\"name\""), 0, "\"remarks\": " + remarks + ", ");
}

TEST(SceneFile, KeepsRemarks) {
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

/// In the words of each release, as scene files keep them.
TEST(SceneFile, KnowsKindsOfRemarks) {
    const std::pair<const char*, RemarkKind> cases[] = {
        {"the median depth is 0.2 mm: the unit may be wrong", RemarkKind::unit_doubt},
        {"guessed: values are lengths, though they are larger in the lower third", RemarkKind::direction},
        {"guessed: depth has no scale: its nearest is taken for 0.5 m", RemarkKind::scale},
        {"guessed: red is 0.5 m and the whole circle of hues goes to 1.5 m", RemarkKind::scale},
        {"guessed: depth goes from 0.5 m, black, to 1.5 m, white", RemarkKind::scale},
        {"guessed: depth is as LeRobot usually stores it, as it is HEVC of 12 bits", RemarkKind::scale},
        {"guessed: the camera sees 60 degrees from left to right", RemarkKind::camera},
        {"guessed: the camera is one of 2 that differ, left.json", RemarkKind::camera},
        {"guessed: a code is 1 mm, as their median is 418", RemarkKind::unit},
        {"guessed: depth codes are millimetres: their median, 418, would be 0.418 m", RemarkKind::unit},
        {"guessed: values are metres: their median, 2, would be 2 m", RemarkKind::unit},
        {"guessed: lengths are metres", RemarkKind::unit},
        {"guessed: its disparities are 1/metres, as Apple writes them", RemarkKind::unit},
        {"guessed: it is as preset realsense has it, of 1 mm a code", RemarkKind::unit},
        {"guessed: depth is as preset unreal has it", RemarkKind::storage},
        {"guessed: depth is disparities, as the name says", RemarkKind::storage},
        {"guessed: depth goes along the camera's axis (planar)", RemarkKind::axis},
        {"guessed: depth goes along each pixel's ray, as the name says", RemarkKind::axis},
        {"guessed: colour lies on depth's pixels, though calib.txt is of another camera",
         RemarkKind::colour_place},
        {"guessed: depth is depth_%d.png, there is no colour", RemarkKind::other},
        {"a code is 1 mm, as the RealSense Viewer writes it", RemarkKind::other},
        {"", RemarkKind::other}};
    for (const auto& [text, kind] : cases) {
        const Scene scene = parsed(with_remarks(nlohmann::json{text}.dump()));
        EXPECT_EQ(scene.remarks.at(0).kind, kind) << text;
        EXPECT_EQ(remark_text(scene.remarks.at(0)), text);
    }
}

TEST(SceneFile, LimitsRemarks) {
    const auto texts = [](std::size_t count, std::size_t length) {
        return nlohmann::json(std::vector<std::string>(count, std::string(length, 'a'))).dump();
    };
    EXPECT_EQ(parsed(with_remarks(texts(100, 2000))).remarks.size(), 100U);
    expect_error(parse_scene(with_remarks(texts(101, 1)), "test.json"),
                 "must be an array of at most 100 texts");
    const auto lengthy = parse_scene(with_remarks(texts(1, 2001)), "test.json");
    expect_error(lengthy, "remarks[0] is ");
    EXPECT_NE(lengthy.error().message.find("must be a text of at most 2000 bytes"), std::string::npos);
}

TEST(SceneFile, AddsEachRemarkOnce) {
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

TEST(SceneFile, AcceptsDocumentedExamples) {
    std::ifstream page(std::string(TOUCHABLE_SOURCE_DIR) + "/docs/scene_file.md");
    std::string line, example;
    bool inside = false;
    int examples = 0;
    while (std::getline(page, line)) {
        if (inside && line == "```") {
            must(parse_scene(example, "scene_file.md"));
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
    std::filesystem::path write(const std::string& name, const std::string& text) const {
        std::ofstream(folder_ / name, std::ios::binary) << text;
        return folder_ / name;
    }
    const TemporaryFolder folder_;
};

TEST_F(SceneFileOnDisk, IsReadByPath) {
    const auto scene = must(read_scene_file(write("scene.json", std::string("\xef\xbb\xbf") + globe + "\n")));
    EXPECT_EQ(scene.scene.name, "globe");
}

TEST_F(SceneFileOnDisk, RejectsEmptyOrHugeFiles) {
    expect_error(read_scene_file(write("empty.json", "")), "empty.json: line 1");
    expect_error(read_scene_file(write("long.json", std::string(3 << 20, ' '))), "larger than 1 MiB");
}

// Faults that a scene file may have, none of which does harm.

/// Every member the format knows, but for those that exclude each other.
constexpr const char* full = R"({
  "touchable_scene": 1, "name": "all", "width": 640, "height": 480, "rate": [30, 1], "metres_per_unit": 0.001,
  "camera": {"fx": 476.0, "fy": 477.5, "cx": 312.25, "cy": 240.5},
  "depth": {"coding": "linear", "semantics": "range", "near": 40, "far": 180, "bits": 10, "code_max": 1000,
            "near_is": "high", "invalid": [0, 1023]},
  "height_map": {"max": 2.5, "units": "levels", "bits": 8},
  "haptic": {"stiffness": [0.1, 10], "static_friction": [0.2, 0.9], "dynamic_friction": [0.2, 0.8]},
  "default_properties": {"stiffness": 0.6, "static_friction": 0.4, "dynamic_friction": 0.3},
  "filter": {"median": 3, "fill_holes": 1}, "interpolation": "linear", "device_metres_per_unit": 0.0005,
  "folder": {"depth": "d_%04d.png", "colour": "c%d.png", "haptic": "t%d.png", "height": "h%d.png",
             "first": 0, "count": 7}
})";

std::string with(const std::string& old_text, const std::string& new_text) {
    std::string json = full;
    const std::size_t at = json.find(old_text);
    EXPECT_NE(at, std::string::npos) << old_text;
    return json.replace(at, old_text.size(), new_text);
}

void expect_refused(const std::string& json, const std::vector<std::string>& parts) {
    const auto scene = parse_scene(json, "scene.json");
    ASSERT_FALSE(scene) << "accepted, expected a word on " << parts.front();
    EXPECT_EQ(scene.error().kind, ErrorKind::input);
    const std::string& message = scene.error().message;
    EXPECT_TRUE(message.starts_with("scene.json: ")) << message;
    EXPECT_NE(message.find("must be"), std::string::npos) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
    for (const std::string& part : parts)
        EXPECT_NE(message.find(part), std::string::npos) << "no " << part << " in: " << message;
}

struct Change {
    const char *old_text, *new_text;
    std::vector<std::string> parts;
};

void expect_refused(const std::vector<Change>& changes) {
    for (const Change& change : changes) {
        SCOPED_TRACE(std::string(change.old_text) + " to " + change.new_text);
        expect_refused(with(change.old_text, change.new_text), change.parts);
    }
}

// Its stiffness, height and depth each stand in two objects, which is no repetition.
TEST(SceneRefusal, AcceptsFullScene) {
    must(parse_scene(full, "full"));
}

TEST(SceneRefusal, NamesMissingAndNewerVersions) {
    expect_refused(with("\"touchable_scene\": 1, ", ""), {"touchable_scene is missing"});
    expect_refused(with("\"touchable_scene\": 1", "\"touchable_scene\": 2"),
                   {"touchable_scene is 2", "at most 1"});
    expect_refused(with("\"touchable_scene\": 1", "\"touchable_scene\": 2, \"later\": 0"),
                   {"touchable_scene is 2"});
    expect_refused(with("\"touchable_scene\": 1", "\"touchable_scene\": 0"), {"touchable_scene is 0"});
    expect_refused(with("\"touchable_scene\": 1", "\"touchable_scene\": \"1\""),
                   {"touchable_scene is \"1\""});
}

TEST(SceneRefusal, NamesUnknownMembers) {
    expect_refused({
        {"\"name\"", "\"nmae\"", {"\"nmae\"", "metres_per_unit", "folder"}},
        {"\"fx\"", "\"fz\"", {"\"camera.fz\"", "fx", "focal_length"}},
        {"\"near\"", "\"nera\"", {"\"depth.nera\"", "near", "semantics"}},
        {"\"max\"", "\"maximum\"", {"\"height_map.maximum\"", "max, units, bits"}},
        {"\"stiffness\": [", "\"hardness\": [", {"\"haptic.hardness\"", "static_friction"}},
        {"\"stiffness\": 0.6", "\"hardness\": 0.6", {"\"default_properties.hardness\"", "stiffness"}},
        {"\"median\"", "\"medain\"", {"\"filter.medain\"", "median, fill_holes"}},
        {"\"fill_holes\": 1", "\"teraces\": \"on\"", {"\"filter.teraces\"", "terraces, terrace_noise"}},
        {"\"colour\"", "\"color\"", {"\"folder.color\"", "colour"}},
        {"\"name\"", "\"a\\nb\"", {"\"a\\nb\""}},
    });
}

TEST(SceneRefusal, NamesMissingMembers) {
    expect_refused({
        {"\"width\": 640, ", "", {"width is missing"}},
        {"\"height\": 480, ", "", {"height is missing"}},
        {"\"fx\": 476.0, ", "", {"camera.fx is missing"}},
        {"\"fx\": 476.0, \"fy\": 477.5, \"cx\": 312.25, \"cy\": 240.5",
         "\"focal_length\": 4",
         {"camera.pixel_width"}},
        {"\"coding\": \"linear\", ", "", {"depth.coding is missing"}},
        {"\"near\": 40, ", "", {"depth.near is missing"}},
        {"\"far\": 180, ", "", {"depth.far is missing"}},
        {"\"max\": 2.5, ", "", {"height_map.max is missing"}},
        {"\"depth\": \"d_%04d.png\", ", "", {"folder.depth is missing"}},
    });
    std::string unscaled = with("\"linear\", \"semantics\"", "\"metric\", \"semantics\"");
    unscaled.erase(unscaled.find("\"near_is\": \"high\", "), 19);
    expect_refused(unscaled, {"depth.scale is missing"});
    unscaled.replace(unscaled.find("\"metric\","), 9, R"("metric", "scale": 1, "float_scale": 1e9,)");
    expect_refused(unscaled, {"depth.float_scale is 1e+09", "so fine"});
}

TEST(SceneRefusal, NamesWrongValuesByPath) {
    expect_refused({
        {"\"all\"", "5", {"name is 5", "a string"}},
        {"640", "640.0", {"width is 640.0", "a whole number"}},
        {"640", "\"640\"", {"width is \"640\"", "a whole number"}},
        {"640", "0", {"width is 0", "16384"}},
        {"640", "99999999999999999999", {"width is", "a whole number"}},
        {"640", "18446744073709551615", {"width is 18446744073709551615", "a whole number"}},
        {"[30, 1]", "30", {"rate is 30", "[30000, 1001]"}},
        {"[30, 1]", "[30]", {"rate is [30]"}},
        {"[30, 1]", "[29.97, 1]", {"rate[0] is 29.97", "a whole number"}},
        {"\"metres_per_unit\": 0.001", "\"metres_per_unit\": true", {"metres_per_unit is true", "a number"}},
        {"{\"fx\": 476.0, \"fy\": 477.5, \"cx\": 312.25, \"cy\": 240.5}", "7", {"camera is 7", "an object"}},
        {"{\"fx\": 476.0, \"fy\": 477.5, \"cx\": 312.25, \"cy\": 240.5}",
         "{\"focal_length\": 4.7, \"pixel_width\": 0}",
         {"camera.pixel_width is 0", "greater than 0"}},
        {"\"cy\": 240.5", "\"cy\": 240.5, \"pixel_width\": 0.01", {"camera.c", "focal_length, pixel_width"}},
        {"476.0", "null", {"camera.fx is null", "a number"}},
        {"\"coding\": \"linear\"",
         "\"coding\": \"logarithm\"",
         {"depth.coding is \"logarithm\"", "\"linear\", \"inverse\", \"metric\", \"hue\""}},
        {"\"coding\": \"linear\"", "\"coding\": \"hue\"", {"depth.bits is 10", "8, of each of red"}},
        {"\"linear\", \"semantics\": \"range\", \"near\": 40, \"far\": 180, \"bits\": 10, \"code_max\": 1000",
         "\"hue\", \"near\": 40, \"far\": 180, \"code_max\": 1537",
         {"depth.code_max is 1537", "1 to 1536"}},
        {"\"linear\", \"semantics\": \"range\", \"near\": 40, \"far\": 180, \"bits\": 10, \"code_max\": 1000",
         "\"hue\", \"near\": 40, \"far\": 180, \"least_sum\": 766",
         {"depth.least_sum is 766", "0 to 765"}},
        {"\"linear\", \"semantics\": \"range\", \"near\": 40",
         "\"log\", \"shift\": -40, \"near\": 40",
         {"depth.shift is -40", "greater than -depth.near, which is -40"}},
        {"\"linear\", \"semantics\": \"range\", \"near\": 40",
         "\"log\", \"shift\": 1e13, \"near\": 40",
         {"depth.shift is 1e+13", "from -1e+12 to 1e+12"}},
        {"\"near\": 40", "\"shift\": 1, \"near\": 40", {"depth.shift is 1", "left out"}},
        {"\"near\": 40", "\"least_sum\": 77, \"near\": 40", {"depth.least_sum is 77", "left out"}},
        {"\"coding\": \"linear\"", "\"coding\": 1", {"depth.coding is 1", "\"inverse\""}},
        {"\"range\"", "\"z\"", {"depth.semantics is \"z\"", "\"range\", \"planar\""}},
        {"\"near\": 40", "\"near\": \"40\"", {"depth.near is \"40\"", "a number"}},
        {"\"near\": 40", "\"scale\": 1, \"near\": 40", {"depth.scale is 1", "left out"}},
        {"\"near\": 40", "\"float_scale\": 1, \"near\": 40", {"depth.float_scale is 1", "left out"}},
        {"\"coding\": \"linear\"", "\"coding\": \"metric\"", {"depth.near_is is \"high\"", "left out"}},
        {"\"bits\": 10", "\"bits\": 7", {"depth.bits is 7", "8 to 16"}},
        {"\"code_max\": 1000", "\"code_max\": 1024", {"depth.code_max is 1024", "1 to 1023"}},
        {"\"high\"", "\"near\"", {"depth.near_is is \"near\"", "\"high\", \"low\""}},
        {"[0, 1023]", "[0, 1024]", {"depth.invalid[1] is 1024", "0 to 1023"}},
        {"[0, 1023]", "[0, -1]", {"depth.invalid[1] is -1"}},
        {"[0, 1023]", "[1, 2, 3, 4, 5]", {"depth.invalid is [1,2,3,4,5]", "at most 4"}},
        {"[0, 1023]", "0", {"depth.invalid is 0", "an array"}},
        {"\"levels\"", "\"mm\"", {"height_map.units is \"mm\"", "\"levels\", \"world\""}},
        {"\"units\": \"levels\", \"bits\": 8", "\"bits\": 17", {"height_map.bits is 17", "8 to 16"}},
        {"[0.1, 10]", "[0.1]", {"haptic.stiffness is [0.1]", "[minimum, maximum]"}},
        {"[0.1, 10]", "[0.1, \"a\"]", {"haptic.stiffness[1] is \"a\"", "a number"}},
        {"[0.2, 0.8]", "{}", {"haptic.dynamic_friction is {}"}},
        {"\"stiffness\": 0.6",
         "\"stiffness\": 0.6, \"stiffness_n_per_m\": 600",
         {"stiffness_n_per_m", "left out"}},
        {"\"default_properties\"",
         "\"hole_stiffness\": \"soft\", \"default_properties\"",
         {"hole_stiffness is \"soft\"", "a number"}},
        {"\"median\": 3", "\"median\": 7", {"filter.median is 7", "0 (off), 3 or 5"}},
        {"\"median\": 3", "\"median\": \"3x3\"", {"filter.median is \"3x3\""}},
        {"\"fill_holes\": 1", "\"terraces\": true", {"filter.terraces is true"}},
        {"\"fill_holes\": 1",
         "\"terraces\": \"some\"",
         {"filter.terraces is \"some\"", "\"off\", \"on\", \"auto\""}},
        {"\"fill_holes\": 1", "\"terrace_noise\": 5", {"filter.terrace_noise is 5", "0 to 4"}},
        {"\"fill_holes\": 1", "\"terrace_reach\": 48", {"filter.terrace_reach is 48", "16, 32, 64 or 128"}},
        {"\"fill_holes\": 1", "\"terrace_reach\": 256", {"filter.terrace_reach is 256"}},
        {"\"fill_holes\": 1", "\"terrace_reach\": -128", {"filter.terrace_reach is -128"}},
        {"\"fill_holes\": 1", "\"temporal\": true", {"filter.temporal is true", "\"off\", \"on\""}},
        {"\"fill_holes\": 1",
         "\"temporal_noise\": 2",
         {"filter.temporal_noise is 2", "[constant, quadratic]"}},
        {"\"fill_holes\": 1", "\"temporal_noise\": [1, -2]", {"filter.temporal_noise's quadratic is -2"}},
        {"\"fill_holes\": 1", "\"temporal_noise\": [-1, 2]", {"filter.temporal_noise's constant is -1"}},
        {"\"fill_holes\": 1", "\"fill_holes\": 99", {"filter.fill_holes is 99", "16"}},
        {"\"interpolation\": \"linear\"",
         "\"interpolation\": \"cubic\"",
         {"interpolation is \"cubic\"", "\"hold\""}},
        {"t%d.png", "\\u0000%d", {"folder.haptic", "control"}},
        {"t%d.png", "\\u007f%d", {"folder.haptic", "control"}},
        {"\"c%d.png\"", "{\"first\": 4}", {"folder.colour.files is missing"}},
        {"\"c%d.png\"", "{\"files\": \"c%d.png\", \"fist\": 4}", {"folder.colour.fist", "first"}},
        {"\"c%d.png\"", "{\"files\": \"c%d.png\", \"step\": 0}", {"folder.colour.step is 0", "from 1"}},
        {"\"c%d.png\"", "{\"files\": \"c%d.png\", \"first\": -4}", {"folder.colour.first is -4"}},
        {"\"c%d.png\"", "{\"files\": \"c%d.png\", \"step\": 2.5}", {"folder.colour.step is 2.5"}},
        {"\"c%d.png\"",
         "{\"files\": \"c*.png\", \"first\": 4}",
         {"folder.colour.first is 4", "left out", "c*.png", "%06d"}},
        {"\"c%d.png\"", "{\"files\": \"c.png\", \"step\": 4}", {"folder.colour.step is 4", "left out"}},
        {"\"c%d.png\"", "{\"files\": \"\", \"step\": 4}", {"folder.colour is \"\""}},
        {"\"d_%04d.png\"",
         "{\"files\": \"d_%04d.png\", \"first\": 1}",
         {"folder.first is 0", "left out where folder.depth.first is given"}},
        {"\"d_%04d.png\"",
         "{\"files\": \"d_%04d.png\", \"step\": 200000000}",
         {"folder.count is 7", "from 0 to 4"}},
        {"\"d_%04d.png\"", "{\"files\": \"d_*.png\", \"step\": 2}", {"folder.depth.step is 2", "left out"}},
        {"\"count\": 7", "\"count\": 1.5", {"folder.count is 1.5", "a whole number"}},
    });
}

TEST(SceneRefusal, NeedsAnObject) {
    for (const char* json : {"[]", "1", "null", "\"touchable_scene\"", "[{\"touchable_scene\": 1}]"})
        expect_refused(json, {"an object"});
}

TEST(SceneRefusal, LocatesRepeatedMembers) {
    expect_refused("{\"touchable_scene\": 1,\n \"width\": 4,\n \"width\": 5}",
                   {"line 3, byte 44", "\"width\"", "twice"});
    expect_refused(with("\"near\": 40", "\"near\": 40, \"near\": 41"), {"line 4", "\"near\"", "twice"});
}

TEST(SceneRefusal, LocatesBrokenJson) {
    expect_refused("", {"line 1, byte 0", "JSON"});
    expect_refused("\x89PNG\r\n", {"is no JSON text: must begin with {"});
    expect_refused("{\n  \"width\": 4,,\n}", {"line 2, byte 16", "JSON"});
    expect_refused(std::string(full) + "{}", {"line 12", "JSON"});
    expect_refused(with("\"all\"", "\"\xff\xfe\""), {"line 2", "JSON"});
    expect_refused(with("640", "NaN"), {"line 2", "JSON"});
    expect_refused(with("476.0", "1e999"), {"line 3", "1e999"});
}

TEST(SceneRefusal, LimitsNesting) {
    expect_refused(std::string(900000, '['), {"line 1, byte 18", "nested too deeply"});
    expect_refused(std::string(500000, '[') + std::string(500000, ']'), {"nested too deeply", "16 deep"});
    std::string objects;
    for (int k = 0; k < 100000; ++k) objects += "{\"a\":";
    expect_refused(objects, {"line 1", "nested too deeply"});
}

TEST(SceneRefusal, NamesImpossibleMaterials) {
    const auto with_materials = [](const std::string& materials) {
        return with("\"haptic\": {", ("\"haptic\": {\"materials\": " + materials + ", ").c_str());
    };
    EXPECT_TRUE(parse_scene(with_materials(R"({"0": {}, "65535": {"stiffness": 3}})"), "full"));
    const std::pair<const char*, std::vector<std::string>> refused[] = {
        {"[]", {"haptic.materials is []", "an object"}},
        {"{}", {"haptic.materials is {}", "1 to 256"}},
        {R"({"65536": {}})", {"haptic.materials", "0 to 65535", "\"65536\""}},
        {R"({"-1": {}})", {"0 to 65535", "\"-1\""}},
        {R"({"01": {}})", {"\"01\""}},
        {R"({"1.0": {}})", {"\"1.0\""}},
        {R"({"1\u0000": {}})", {"haptic.materials", "and not"}},
        {R"({"wood": {}})", {"\"wood\""}},
        {R"({"1": 5})", {"haptic.materials.1 is 5", "an object"}},
        {R"({"1": {"hardness": 5}})", {"haptic.materials.1.hardness", "stiffness"}},
        {R"({"1": {"stiffness": 0}})", {"haptic.materials.1 is", "above 0"}},
        {R"({"1": {"stiffness": 1e300}})", {"haptic.materials.1 is", "at most 1e6"}},
        {R"({"1": {"dynamic_friction": -0.1}})", {"haptic.materials.1 is", "0 or more"}},
        {R"({"1": {"static_friction": 0.3, "dynamic_friction": 0.4}})", {"static_friction (0.3)", "(0.4)"}},
        {R"({"1": {"stiffness": 11}})", {"haptic.stiffness is [0.1,10]", "a range that holds 11"}},
        {R"({"1": {}, "1": {}})", {"\"1\"", "twice"}},
    };
    for (const auto& [materials, parts] : refused) {
        SCOPED_TRACE(materials);
        const auto scene = parse_scene(with_materials(materials), "scene.json");
        ASSERT_FALSE(scene);
        for (const std::string& part : parts)
            EXPECT_NE(scene.error().message.find(part), std::string::npos) << scene.error().message;
        EXPECT_EQ(scene.error().message.find('\n'), std::string::npos);
    }
    std::string many = "{\"0\": {}";
    for (int k = 1; k < 257; ++k) many += ", \"" + std::to_string(k) + "\": {}";
    expect_refused(with_materials(many + "}"), {"haptic.materials", "1 to 256"});
}

}  // namespace
}  // namespace touchable::test
