// What is written is read again as it was, to the last bit and byte.
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <string>

#include "engine/scene/filter_codes.hpp"
#include "engine/scene/scene.hpp"
#include "tests/scene/random.hpp"
#include "tests/scene/scene_texts.hpp"
#include "tests/sweep.hpp"

namespace touchable {
namespace {

bool same_bits(double a, double b) {
    return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b);
}
bool same_bits(const PropertyRange& a, const PropertyRange& b) {
    return same_bits(a.min, b.min) && same_bits(a.max, b.max);
}

void expect_same(const SceneDescription& one, const SceneDescription& other) {
    const Scene &a = one.scene, &b = other.scene;
    EXPECT_EQ(one.unstated, other.unstated);
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
    ASSERT_EQ(one.materials.size(), other.materials.size());
    for (std::size_t k = 0; k < one.materials.size(); ++k) {
        const HapticProperties &p = one.materials[k].properties, &q = other.materials[k].properties;
        EXPECT_EQ(one.materials[k].index, other.materials[k].index);
        EXPECT_TRUE(same_bits(p.stiffness, q.stiffness) && same_bits(p.static_friction, q.static_friction) &&
                    same_bits(p.dynamic_friction, q.dynamic_friction));
    }
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

SceneDescription random_description(Random& random) {
    SceneDescription described;
    Scene& scene = described.scene;
    SceneDescription::Unstated& open = described.unstated;
    scene.name = random.below(2) ? "globe \"twice\" \u00e9\u4e16\n" : "";
    scene.width = 1 + static_cast<int>(random.below(16384));
    scene.height = 1 + static_cast<int>(random.below(16384));
    scene.rate = {1 + static_cast<std::int64_t>(random.below(100000)),
                  1 + static_cast<std::int64_t>(random.below(2000))};
    scene.metres_per_unit = random.between(1e-6, 2);
    scene.camera = {random.between(1, 5000), random.between(1, 5000), random.between(-100, 9000),
                    random.between(-100, 9000)};
    scene.depth.kind = static_cast<DepthCodingKind>(random.below(5));
    scene.depth.semantics = static_cast<DepthSemantics>(random.below(2));
    scene.depth.near = random.between(0.3, 50);
    scene.depth.far = scene.depth.near + random.between(1, 100);
    const bool hue = scene.depth.kind == DepthCodingKind::hue;
    if (scene.depth.kind == DepthCodingKind::log)
        scene.depth.shift = random.between(-0.9 * scene.depth.near, 50);
    if (hue) scene.depth.least_sum = static_cast<int>(random.below(766));
    scene.depth_bits = hue ? 8 : 8 + static_cast<int>(random.below(9));
    scene.depth.code_max = static_cast<std::uint16_t>((hue ? 1536 : (1 << scene.depth_bits) - 1) -
                                                      static_cast<int>(random.below(20)));
    if (scene.depth.kind == DepthCodingKind::metric) {
        scene.depth.scale = 2 * scene.depth.far / scene.depth.code_max;
        open.far = random.below(2);
        if (open.far) scene.depth.far = scene.depth.scale * scene.depth.code_max;
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
    if (!open.far && !has_working_codes(scene) && scene.filter.terraces == TerraceRemoval::on)
        scene.filter.terraces = TerraceRemoval::off;
    if (random.below(2)) scene.filter.terrace_noise = random.between(0, 4);
    if (random.below(2)) scene.filter.temporal_noise = {random.between(0.1, 9), random.between(0, 1e-3)};
    scene.filter.temporal = scene.filter.temporal_noise.constant > 0 && random.below(2);
    open.rate = random.below(2);
    if (open.rate) scene.rate = {};
    open.filters = {random.below(2) > 0, random.below(2) > 0, random.below(2) > 0, random.below(2) > 0,
                    random.below(2) > 0};
    open.filters.terrace_reach = open.filters.terraces && random.below(2);
    if (!open.filters.terrace_reach) scene.filter.terrace_reach = 16 << random.below(4);
    if (open.filters.median) scene.filter.median = 0;
    if (open.filters.fill_holes) scene.filter.fill_holes = 0;
    if (open.filters.terraces) scene.filter.terraces = TerraceRemoval::off;
    if (open.filters.temporal) scene.filter.temporal = false;
    scene.interpolation = static_cast<FrameInterpolation>(random.below(2));
    if (random.below(2)) scene.device_metres_per_unit = random.between(1e-6, 1);
    if (random.below(2))
        scene.folder = FolderSource{"d_%04d.png", "", "h%d.png", "", static_cast<int>(random.below(99)), 5};
    if (scene.folder && random.below(2)) {
        scene.folder->step = 1 + static_cast<int>(random.below(9));
        if (random.below(2)) scene.folder->haptic_numbers.first = static_cast<int>(random.below(999));
        if (random.below(2)) scene.folder->haptic_numbers.step = 1 + static_cast<int>(random.below(9));
    }
    return described;
}

TEST(SceneFile, RandomScenesComeBackToTheLastBit) {
    Random random(41);
    for (std::size_t k = 0; k < 3000; k += test::sweep_step()) {
        const SceneDescription random_one = random_description(random);
        ASSERT_TRUE(validate(random_one)) << validate(random_one).error().message;
        const std::string json = scene_to_json(random_one);
        const auto again = parse_scene(json, "again");
        ASSERT_TRUE(again) << again.error().message << "\n" << json;
        expect_same(random_one, *again);
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
    EXPECT_EQ(scene_to_json(described(text)), text);
}

TEST(SceneFile, TextIsReadTheSameWayTwice) {
    for (const char* json : {recording, globe}) {
        const SceneDescription once = described(json);
        expect_same(once, described(scene_to_json(once)));
    }
}

TEST(SceneFile, NameThatIsNoUnicodeStillGivesJson) {
    Scene scene = parsed(globe);
    scene.name =
        "a\xff"
        "b";
    EXPECT_TRUE(parse_scene(scene_to_json(scene), "t"));
}

TEST(SceneWriting, MaterialsAndTheRangesThatHoldThem) {
    const char* const text = R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1}, "depth": {"coding": "metric", "scale": 1},
        "default_properties": {"stiffness": 0.5},
        "haptic": {"static_friction": [0, 1], "materials": {
            "10": {"stiffness_n_per_m": 777.7}, "2": {"stiffness": 2, "dynamic_friction": 0.05}, "0": {}}},
        "folder": {"depth": "d%d.exr", "haptic": "d%d.exr"}})";
    const auto read = parse_scene(text, "text");
    ASSERT_TRUE(read) << read.error().message;
    ASSERT_EQ(read->materials.size(), 3U);
    EXPECT_EQ(read->materials[0].index, 0);
    EXPECT_EQ(read->materials[0].properties.stiffness, 500);
    EXPECT_EQ(read->materials[1].index, 2);
    EXPECT_EQ(read->materials[1].properties.static_friction, 0.4);
    EXPECT_EQ(read->materials[2].properties.stiffness, 777.7);
    const HapticRanges& ranges = read->scene.haptic;
    EXPECT_EQ(ranges.stiffness.min, 0.5);
    EXPECT_EQ(ranges.stiffness.max, 2);
    EXPECT_EQ(ranges.static_friction.min, 0);
    EXPECT_EQ(ranges.static_friction.max, 1);
    EXPECT_EQ(ranges.dynamic_friction.min, 0.05);
    EXPECT_EQ(ranges.dynamic_friction.max, 0.3);
    const auto again = parse_scene(scene_to_json(*read), "written");
    ASSERT_TRUE(again) << again.error().message;
    expect_same(*read, *again);
}

}  // namespace
}  // namespace touchable
