#include "engine/scene/scene_file.hpp"
#include "engine/scene/terraces.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/scene/random.hpp"

namespace touchable {
namespace {

/// A depth camera's recording: metric, with holes, read from a folder.
constexpr const char* recording = R"({
  "touchable_scene": 1, "name": "castle", "width": 640, "height": 480, "rate": [30, 1], "metres_per_unit": 1,
  "camera": {"fx": 476.0, "fy": -476.5, "cx": 312.2, "cy": 240.6},
  "depth": {"coding": "metric", "scale": 0.000125, "near": 0.2, "far": 1.5, "invalid": [0, 65535]},
  "default_properties": {"stiffness": 0.4, "static_friction": 0.5, "dynamic_friction": 0.25},
  "hole_stiffness": 0.1, "filter": {"median": 5, "fill_holes": 2}, "interpolation": "hold", "device_metres_per_unit": 0.4,
  "folder": {"depth": "depth_%04d.png", "colour": "image_%04d.png", "first": 3, "count": 20}
})";

/// A generated clip in the paper's terms.
constexpr const char* globe = R"({
  "touchable_scene": 1, "name": "globe", "width": 720, "height": 480, "rate": [30000, 1001],
  "camera": {"focal_length": 4.7, "pixel_width": 0.0112},
  "depth": {"coding": "linear", "near": 40, "far": 180, "bits": 16},
  "height_map": {"max": 2.5, "units": "levels", "bits": 10},
  "haptic": {"stiffness": [0.1, 10], "static_friction": [0.2, 0.9], "dynamic_friction": [0.2, 0.8]}
})";

Scene parsed(const std::string& json) {
    auto scene = parse_scene(json, "test.json");
    EXPECT_TRUE(scene.ok()) << scene.error().message;
    return scene.ok() ? *scene : Scene{};
}

bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
bool same_bits(const PropertyRange& a, const PropertyRange& b) {
    return same_bits(a.min, b.min) && same_bits(a.max, b.max);
}

void expect_same(const Scene& a, const Scene& b) {
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.width, b.width);
    EXPECT_EQ(a.height, b.height);
    EXPECT_EQ(a.rate.num, b.rate.num);
    EXPECT_EQ(a.rate.den, b.rate.den);
    EXPECT_TRUE(same_bits(a.metres_per_unit, b.metres_per_unit));
    EXPECT_TRUE(same_bits(a.camera.fx, b.camera.fx));
    EXPECT_TRUE(same_bits(a.camera.fy, b.camera.fy));
    EXPECT_TRUE(same_bits(a.camera.cx, b.camera.cx));
    EXPECT_TRUE(same_bits(a.camera.cy, b.camera.cy));
    EXPECT_EQ(a.depth, b.depth);  // none of its doubles can be -0 or NaN
    EXPECT_EQ(a.depth_bits, b.depth_bits);
    EXPECT_TRUE(same_bits(a.height_coding.max_height, b.height_coding.max_height));
    EXPECT_EQ(a.height_coding.units, b.height_coding.units);
    EXPECT_EQ(a.height_coding.code_max, b.height_coding.code_max);
    EXPECT_TRUE(same_bits(a.haptic.stiffness, b.haptic.stiffness));
    EXPECT_TRUE(same_bits(a.haptic.static_friction, b.haptic.static_friction));
    EXPECT_TRUE(same_bits(a.haptic.dynamic_friction, b.haptic.dynamic_friction));
    EXPECT_TRUE(same_bits(a.default_properties.stiffness, b.default_properties.stiffness));
    EXPECT_TRUE(same_bits(a.default_properties.static_friction, b.default_properties.static_friction));
    EXPECT_TRUE(same_bits(a.default_properties.dynamic_friction, b.default_properties.dynamic_friction));
    ASSERT_EQ(a.hole_stiffness.has_value(), b.hole_stiffness.has_value());
    if (a.hole_stiffness) {
        EXPECT_TRUE(same_bits(*a.hole_stiffness, *b.hole_stiffness));
    }
    EXPECT_EQ(a.filter, b.filter);
    EXPECT_EQ(a.interpolation, b.interpolation);
    ASSERT_EQ(a.device_metres_per_unit.has_value(), b.device_metres_per_unit.has_value());
    if (a.device_metres_per_unit) {
        EXPECT_TRUE(same_bits(*a.device_metres_per_unit, *b.device_metres_per_unit));
    }
    EXPECT_EQ(a.far_from_frames, b.far_from_frames);
    ASSERT_EQ(a.folder.has_value(), b.folder.has_value());
    if (!a.folder) return;
    EXPECT_EQ(a.folder->depth, b.folder->depth);
    EXPECT_EQ(a.folder->colour, b.folder->colour);
    EXPECT_EQ(a.folder->haptic, b.folder->haptic);
    EXPECT_EQ(a.folder->height, b.folder->height);
    EXPECT_EQ(a.folder->first, b.folder->first);
    EXPECT_EQ(a.folder->count, b.folder->count);
    EXPECT_EQ(a.folder->step, b.folder->step);
    EXPECT_EQ(a.folder->colour_numbers, b.folder->colour_numbers);
    EXPECT_EQ(a.folder->haptic_numbers, b.folder->haptic_numbers);
    EXPECT_EQ(a.folder->height_numbers, b.folder->height_numbers);
}

PropertyRange random_range(Random& random) {
    const double least = random.between(0, 5);
    return {least, least + random.between(0, 5)};
}

Scene random_scene(Random& random) {
    Scene scene;
    scene.name = random.below(2) ? "globe \"twice\" \u00e9\u4e16\n" : "";
    scene.width = 1 + static_cast<int>(random.below(16384));
    scene.height = 1 + static_cast<int>(random.below(16384));
    scene.rate = {1 + static_cast<std::int64_t>(random.below(100000)),
                  1 + static_cast<std::int64_t>(random.below(2000))};
    scene.metres_per_unit = random.between(1e-6, 2);
    scene.camera = {random.between(1, 5000), random.between(1, 5000), random.between(-100, 9000),
                    random.between(-100, 9000)};
    scene.depth.kind = static_cast<DepthCodingKind>(random.below(4));
    scene.depth.semantics = static_cast<DepthSemantics>(random.below(2));
    scene.depth.near = random.between(0.3, 50);
    scene.depth.far = scene.depth.near + random.between(1, 100);
    const bool hue = scene.depth.kind == DepthCodingKind::hue;
    if (hue) scene.depth.least_sum = static_cast<int>(random.below(766));
    scene.depth_bits = hue ? 8 : 8 + static_cast<int>(random.below(9));
    scene.depth.code_max = static_cast<std::uint16_t>((hue ? 1536 : (1 << scene.depth_bits) - 1) -
                                                      static_cast<int>(random.below(20)));
    if (scene.depth.kind == DepthCodingKind::metric) {
        scene.depth.scale = 2 * scene.depth.far / scene.depth.code_max;
        scene.far_from_frames = random.below(2);
        if (scene.far_from_frames) scene.depth.far = scene.depth.scale * scene.depth.code_max;
    } else {
        scene.depth.near_is_high = random.below(2);
    }
    scene.depth.invalid_code_count = static_cast<int>(random.below(5));
    for (int k = 0; k < scene.depth.invalid_code_count; ++k)
        scene.depth.invalid_codes[static_cast<std::size_t>(k)] =
            static_cast<std::uint16_t>(random.below(scene.depth.code_max));
    derive_valid_range(scene.depth);
    scene.height_coding.code_max = static_cast<std::uint16_t>((1 << (8 + random.below(9))) - 1);
    scene.height_coding.units = static_cast<HeightUnits>(random.below(2));
    if (scene.depth.kind == DepthCodingKind::linear) scene.height_coding.max_height = random.between(0, 0.29);
    scene.haptic = {random_range(random), random_range(random), random_range(random)};
    const double static_friction = random.between(0, 2);
    scene.default_properties = {random.between(1, 5000), static_friction,
                                static_friction * random.between(0, 1)};
    scene.filter = {random.below(2) ? 3 : 5, static_cast<int>(random.below(17))};
    scene.filter.terraces = static_cast<TerraceRemoval>(random.below(3));
    if (!scene.far_from_frames && !terrace_scale(scene) && scene.filter.terraces == TerraceRemoval::on)
        scene.filter.terraces = TerraceRemoval::off;
    if (random.below(2)) scene.filter.terrace_noise = random.between(0, 4);
    if (random.below(2)) scene.filter.temporal_noise = {random.between(0.1, 9), random.between(0, 1e-3)};
    scene.filter.temporal = scene.filter.temporal_noise.constant > 0 && random.below(2);
    scene.interpolation = static_cast<FrameInterpolation>(random.below(2));
    if (random.below(2)) scene.device_metres_per_unit = random.between(1e-6, 1);
    if (random.below(2))
        scene.folder = FolderSource{"d_%04d.png", "", "h%d.png", "", static_cast<int>(random.below(99)), 5};
    if (scene.folder && random.below(2)) {
        scene.folder->step = 1 + static_cast<int>(random.below(9));
        if (random.below(2)) scene.folder->haptic_numbers.first = static_cast<int>(random.below(999));
        if (random.below(2)) scene.folder->haptic_numbers.step = 1 + static_cast<int>(random.below(9));
    }
    return scene;
}

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
    EXPECT_FALSE(scene.far_from_frames);
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
    const Scene scene = parsed(R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1}, "depth": {"coding": "metric", "scale": 0.001}})");
    EXPECT_TRUE(scene.far_from_frames);
    EXPECT_EQ(scene.depth.valid_min, 1);  // until the frames are known every code but depth 0 may occur
    EXPECT_EQ(scene.depth.valid_max, 65535);
}

TEST(SceneFile, RandomScenesComeBackToTheLastBit) {
    Random random(41);
    for (int k = 0; k < 3000; ++k) {
        const Scene scene = random_scene(random);
        ASSERT_TRUE(validate(scene).ok()) << validate(scene).error().message;
        const std::string json = scene_to_json(scene);
        const auto again = parse_scene(json, "again");
        ASSERT_TRUE(again.ok()) << again.error().message << "\n" << json;
        expect_same(scene, *again);
        if (HasFailure()) FAIL() << json;
        ASSERT_EQ(scene_to_json(*again), json);
    }
}

/// A clip that was packed is the same bytes whoever packs it, now and later.
TEST(SceneFile, IsWrittenTheSameToTheByte) {
    const std::string text = R"({
  "touchable_scene": 1,
  "name": "globe",
  "width": 64,
  "height": 48,
  "rate": [
    30,
    1
  ],
  "metres_per_unit": 0.001,
  "camera": {
    "fx": 37.301587301587304,
    "fy": 37.301587301587304,
    "cx": 32.0,
    "cy": 23.0
  },
  "depth": {
    "coding": "linear",
    "semantics": "range",
    "near": 40.0,
    "far": 180.0,
    "bits": 16,
    "code_max": 65535,
    "near_is": "high",
    "invalid": []
  },
  "height_map": {
    "max": 1.0,
    "units": "levels",
    "bits": 8
  },
  "haptic": {
    "stiffness": [
      0.1,
      2.0
    ],
    "static_friction": [
      0.0,
      1.0
    ],
    "dynamic_friction": [
      0.0,
      1.0
    ]
  },
  "default_properties": {
    "stiffness": 1.0,
    "static_friction": 0.0,
    "dynamic_friction": 0.0
  },
  "filter": {},
  "interpolation": "linear",
  "device_metres_per_unit": 0.0006356504689253938,
  "folder": {
    "depth": "depth_%06d.png",
    "colour": "colour_%06d.png",
    "haptic": "haptic_%06d.png",
    "height": "height_%06d.png",
    "first": 0,
    "count": 2
  }
}
)";
    EXPECT_EQ(scene_to_json(parsed(text)), text);
}

TEST(SceneFile, TextIsReadTheSameWayTwice) {
    for (const char* json : {recording, globe}) {
        const Scene scene = parsed(json);
        expect_same(scene, parsed(scene_to_json(scene)));
    }
}

TEST(SceneFile, NameThatIsNoUnicodeStillGivesJson) {
    Scene scene = parsed(globe);
    scene.name =
        "a\xff"
        "b";
    EXPECT_TRUE(parse_scene(scene_to_json(scene), "t").ok());
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
    ASSERT_FALSE(many.ok());
    EXPECT_NE(many.error().message.find("must be an array of at most 100 texts"), std::string::npos);
    const auto lengthy = parse_scene(with_remarks(texts(1, 2001)), "test.json");
    ASSERT_FALSE(lengthy.ok());
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
                   {std::to_string(n) + std::string(5000, '\xff'), true, "--fov says otherwise"});
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
            EXPECT_TRUE(scene.ok()) << scene.error().message;
            ++examples;
            inside = false;
        } else if (line == "```json") {
            inside = true;
            example.clear();
        } else if (inside) {
            example += line + "\n";
        }
    }
    EXPECT_EQ(examples, 6);
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
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    EXPECT_EQ(scene->name, "globe");
}

TEST_F(SceneFileOnDisk, ThatCannotBeReadIsRefusedByItsName) {
    for (const auto& file : {folder_ / "absent.json", folder_}) {
        const auto scene = read_scene_file(file);
        ASSERT_FALSE(scene.ok());
        EXPECT_EQ(scene.error().kind, ErrorKind::input);
        EXPECT_NE(scene.error().message.find(file.string()), std::string::npos);
        EXPECT_NE(scene.error().message.find("cannot be read"), std::string::npos);
    }
}

TEST_F(SceneFileOnDisk, ThatIsEmptyOrEndlessIsRefused) {
    EXPECT_NE(read_scene_file(write("empty.json", "")).error().message.find("empty.json: line 1"),
              std::string::npos);
    EXPECT_NE(
        read_scene_file(write("long.json", std::string(3 << 20, ' '))).error().message.find("1048576 bytes"),
        std::string::npos);
}

}  // namespace
}  // namespace touchable
