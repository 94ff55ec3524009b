// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <tuple>

#include "engine/scene/filter_codes.hpp"
#include "engine/scene/scene.hpp"
#include "tests/must.hpp"
#include "tests/scene/scene_texts.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

Scene good_scene() {
    Scene scene;
    scene.width = 720;
    scene.height = 480;
    scene.camera = camera_from_focal_length(4.7, 0.0112, 720, 480);
    scene.depth.near = 40;
    scene.depth.far = 180;
    derive_valid_range(scene.depth);
    return scene;
}

Scene metric_scene() {
    Scene scene = good_scene();
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 0.001;
    scene.depth.near = 0;
    scene.depth.far = 5;
    scene.depth.code_max = 65535;
    scene.depth_bits = 16;
    derive_valid_range(scene.depth);
    return scene;
}

FolderSource folder_of(const std::string& depth) {
    FolderSource folder;
    folder.depth = depth;
    return folder;
}

/// validate() refuses the scene with a message that has all these parts.
void expect_refused(const Scene& scene, const std::vector<std::string>& parts) {
    const auto result = validate(scene);
    ASSERT_FALSE(result) << "accepted, expected a word on " << parts.front();
    EXPECT_EQ(result.error().kind, ErrorKind::input);
    EXPECT_EQ(result.error().message.find('\n'), std::string::npos);
    for (const std::string& part : parts)
        EXPECT_NE(result.error().message.find(part), std::string::npos)
            << "no " << part << " in: " << result.error().message;
}

TEST(HapticRanges, MatchEquation1) {
    const HapticRanges ranges{{0.01, 1.0}, {0.1, 1.0}, {0.1, 1.0}};
    EXPECT_NEAR(ranges.stiffness.at(70), 0.28176, 0.000005);  // N/mm, as printed
    EXPECT_NEAR(ranges.at(70, 0, 0).stiffness, 281.76, 0.005);
}

TEST(HapticRanges, MapChannelsToProperties) {
    const HapticRanges ranges{{0.1, 10.0}, {0.2, 0.9}, {0.3, 0.8}};
    const HapticProperties least = ranges.at(0, 0, 0), most = ranges.at(255, 255, 255);
    EXPECT_DOUBLE_EQ(least.stiffness, 100);
    EXPECT_DOUBLE_EQ(least.static_friction, 0.2);
    EXPECT_DOUBLE_EQ(least.dynamic_friction, 0.3);
    EXPECT_DOUBLE_EQ(most.stiffness, 10000);
    EXPECT_DOUBLE_EQ(most.static_friction, 0.9);
    EXPECT_DOUBLE_EQ(most.dynamic_friction, 0.8);
    EXPECT_DOUBLE_EQ(ranges.at(0, 255, 0).static_friction, 0.9);
    EXPECT_DOUBLE_EQ(ranges.at(0, 0, 255).dynamic_friction, 0.8);
}

TEST(Height, HasLevelsOrWorldUnits) {
    const Scene scene = good_scene();
    EXPECT_DOUBLE_EQ(largest_height({3.0, HeightUnits::levels, 255}, scene.depth), 3.0 * 140.0 / 255);
    EXPECT_DOUBLE_EQ(largest_height({3.0, HeightUnits::world, 255}, scene.depth), 3.0);
}

TEST(CameraPose, RotationIsNoMirror) {
    for (const double x : {-1, 0, 1})
        for (const double y : {-1, 0, 1})
            for (const double z : {-1, 0, 1})
                for (const double w : {0.5, -0.25}) {
                    const double length = std::sqrt(x * x + y * y + z * z + w * w);
                    auto matrix = rotation_of(x / length, y / length, z / length, w / length).value();
                    EXPECT_TRUE(is_rotation(matrix)) << x << y << z << w;
                    for (double& number : matrix) number = -number;
                    EXPECT_FALSE(is_rotation(matrix)) << x << y << z << w;
                }
}

TEST(FrameRate, FloorsTimesToNanoseconds) {
    const FrameRate film{30, 1}, ntsc{30000, 1001};
    EXPECT_EQ(film.time_ns(0), 0);
    EXPECT_EQ(film.time_ns(1), 33333333);
    EXPECT_EQ(film.time_ns(2), 66666666);
    EXPECT_EQ(film.time_ns(30), 1000000000);
    EXPECT_EQ(ntsc.time_ns(1), 33366666);
    EXPECT_EQ(ntsc.time_ns(30000), 1001000000000);
    EXPECT_EQ(film.time_ns(-1), -33333334);
}

TEST(FrameRate, NeitherOverflowsNorDrifts) {
    const FrameRate fast{1000, 1}, odd{999999937, 1000003};
    const std::int64_t last = std::int64_t{1} << 40;
    EXPECT_EQ(fast.time_ns(last), last * 1000000);
    // floor(n k / m) is the one t with t m <= n k < (t + 1) m; whole turns of m frames are k each.
    EXPECT_EQ(odd.time_ns(999999937 * std::int64_t{100}), std::int64_t{1000003} * 1000000000 * 100);
    EXPECT_EQ((FrameRate{1, 1000000000}).time_ns(last), std::numeric_limits<std::int64_t>::max());
}

TEST(FrameRate, FindsLastFrameByTime) {
    for (const FrameRate& rate : {FrameRate{30, 1}, FrameRate{30000, 1001}, FrameRate{999999937, 1000003}})
        for (const std::int64_t frame : {-3LL, 0LL, 1LL, 2LL, 12345LL, 1LL << 30}) {
            EXPECT_EQ(rate.frame_at(rate.time_ns(frame)), frame);
            EXPECT_EQ(rate.frame_at(rate.time_ns(frame) - 1), frame - 1);
            EXPECT_EQ(rate.frame_at(rate.time_ns(frame + 1) - 1), frame);
        }
}

TEST(Validation, AcceptsPossibleScenes) {
    EXPECT_TRUE(validate(good_scene()));
    EXPECT_TRUE(validate(metric_scene()));
    Scene scene = good_scene();
    scene.width = scene.height = 16384;
    scene.depth_bits = 16;
    scene.depth.code_max = 65535;
    derive_valid_range(scene.depth);
    scene.height_coding.max_height = 72;
    scene.filter = {5, 16};
    scene.haptic.dynamic_friction = {0.5, 2.0};  // above the static one: a map may have reasons
    scene.folder = folder_of("depth/frame_%04d.png");
    scene.folder->colour = "%d.jpg";
    EXPECT_TRUE(validate(scene)) << validate(scene).error().message;
}

struct Refused {
    std::function<void(Scene&)> spoil;
    std::vector<std::string> parts;
};
const double nan = std::numeric_limits<double>::quiet_NaN(),
             infinity = std::numeric_limits<double>::infinity();

template <class Member, class Value>
std::function<void(Scene&)> with_folder(const char* depth, Member FolderSource::*member, Value value) {
    return [=](Scene& scene) {
        scene.folder = folder_of(depth);
        (*scene.folder).*member = value;
    };
}
std::function<void(Scene&)> with_world_height(double height) {
    return [=](Scene& scene) { scene.height_coding = HeightCoding{height, HeightUnits::world, 255}; };
}

/// Each of these, spoiling a scene, is named by validate().
void expect_all_refused(const Scene& good, const std::vector<Refused>& cases) {
    for (const Refused& refused : cases) {
        SCOPED_TRACE(refused.parts.front());
        Scene scene = good;
        refused.spoil(scene);
        expect_refused(scene, refused.parts);
    }
}

TEST(Validation, NamesMemberAndNumber) {
    const std::vector<Refused> cases = {
        {[](Scene& s) { s.width = 0; }, {"width is 0", "1 to 16384"}},
        {[](Scene& s) { s.width = 16385; }, {"width is 16385", "16384"}},
        {[](Scene& s) { s.height = -3; }, {"height is -3", "16384"}},
        {[](Scene& s) { s.rate.num = 0; }, {"rate", "is 0", "1 to"}},
        {[](Scene& s) { s.rate.den = -1; }, {"rate", "is -1"}},
        {[](Scene& s) { s.metres_per_unit = 0; }, {"metres_per_unit is 0", "greater than 0"}},
        {[](Scene& s) { s.metres_per_unit = nan; }, {"metres_per_unit is nan"}},
        {[](Scene& s) { s.camera.fx = 0; }, {"camera.fx is 0", "greater than 0"}},
        {[](Scene& s) { s.camera.fx = infinity; }, {"camera.fx is inf"}},
        {[](Scene& s) { s.camera.fy = -525.5; }, {"camera.fy is -525.5"}},
        {[](Scene& s) { s.camera.cx = nan; }, {"camera.cx is nan"}},
        {[](Scene& s) { s.camera.cy = -infinity; }, {"camera.cy is -inf"}},
        {[](Scene& s) { s.depth.near = 0; }, {"depth.near is 0", "greater than 0"}},
        {[](Scene& s) { s.depth.near = -2.5; }, {"depth.near is -2.5"}},
        {[](Scene& s) { s.depth.near = nan; }, {"depth.near is nan"}},
        {[](Scene& s) { s.depth.far = infinity; }, {"depth.far is inf"}},
        {[](Scene& s) { std::swap(s.depth.near, s.depth.far); }, {"depth.near is 180", "depth.far", "40"}},
        {[](Scene& s) { s.depth.far = 40; }, {"depth.near is 40", "less than depth.far"}},
        {[](Scene& s) { s.depth_bits = 7; }, {"depth.bits is 7", "8 to 16"}},
        {[](Scene& s) { s.depth_bits = 17; }, {"depth.bits is 17"}},
        {[](Scene& s) { s.depth.code_max = 0; }, {"depth.code_max is 0", "1 to 255"}},
        {[](Scene& s) { s.depth.code_max = 1023; }, {"depth.code_max is 1023", "255"}},
        {[](Scene& s) { s.depth.invalid_code_count = 5; }, {"depth.invalid", "is 5", "4"}},
        {[](Scene& s) { s.height_coding.max_height = -1; }, {"height_map.max is -1", "0"}},
        {[](Scene& s) { s.height_coding.max_height = nan; }, {"height_map.max is nan"}},
        {[](Scene& s) { s.height_coding.code_max = 1000; }, {"height", "1000", "bits"}},
        {[](Scene& s) { s.height_coding.max_height = 73; },
         {"height_map.max is 73", "at most 72.78428", "a thousandth"}},
        {[](Scene& s) { s.depth.near = 1e-4; },
         {"depth.near is 0.0001", "at least 0.00018, a millionth of the deepest valid depth, which is 180"}},
        {[](Scene& s) {
             s.depth.near = 0.001;
             s.height_coding = {0.0009, HeightUnits::world, 255};
         },
         {"height_map.max is 0.0009", "at most 0.00082",
          "0.00018, a millionth of the deepest, has to be left"}},
        {with_world_height(40), {"height_map.max is 40", "at most 39.96 scene units"}},
        {[](Scene& s) {
             s.haptic.stiffness = PropertyRange{2, 1};
         },
         {"haptic.stiffness", "is 1", "2"}},
        {[](Scene& s) { s.haptic.static_friction.min = -0.5; }, {"haptic.static_friction", "-0.5"}},
        {[](Scene& s) { s.haptic.dynamic_friction.max = nan; }, {"haptic.dynamic_friction", "nan"}},
        {[](Scene& s) { s.haptic.stiffness.max = infinity; }, {"haptic.stiffness", "inf"}},
        {[](Scene& s) { s.default_properties.stiffness = 0; }, {"default_properties.stiffness", "is 0"}},
        {[](Scene& s) { s.hole_stiffness = -0.1; }, {"hole_stiffness is -0.1", "from 0"}},
        {[](Scene& s) { s.hole_stiffness = nan; }, {"hole_stiffness is nan"}},
        {[](Scene& s) { s.default_properties.static_friction = -1; }, {"static_friction is -1"}},
        {[](Scene& s) { s.default_properties.dynamic_friction = -1; }, {"dynamic_friction is -1"}},
        {[](Scene& s) { s.default_properties.dynamic_friction = 0.75; },
         {"default_properties.dynamic_friction is 0.75", "static_friction, which is 0.4"}},
        {[](Scene& s) { s.filter.median = 4; }, {"filter.median is 4", "3 or 5"}},
        {[](Scene& s) { s.filter.fill_holes = 17; }, {"filter.fill_holes is 17", "16"}},
        {[](Scene& s) { s.filter.terrace_noise = -1; }, {"filter.terrace_noise is -1", "4 codes"}},
        {[](Scene& s) { s.filter.terrace_noise = 4.5; }, {"filter.terrace_noise is 4.5"}},
        {[](Scene& s) { s.filter.terrace_noise = nan; }, {"filter.terrace_noise is nan"}},
        {[](Scene& s) {
             s.filter.terraces = TerraceRemoval::on;
             s.filter.levels = {1e6, 0};
         },
         {"filter.terraces is on", "filter.levels"}},
        {[](Scene& s) { s.filter.temporal_noise.constant = nan; },
         {"filter.temporal_noise's constant is nan"}},
        {[](Scene& s) { s.filter.temporal = true; },
         {"filter.temporal is on", "filter.temporal_noise is [0, 0]"}},
        {[](Scene& s) { s.filter.fill_holes = -1; }, {"filter.fill_holes is -1"}},
        {[](Scene& s) { s.device_metres_per_unit = 0.0; }, {"device_metres_per_unit is 0"}},
        {[](Scene& s) { s.device_metres_per_unit = nan; }, {"device_metres_per_unit is nan"}},
        {with_folder("%d", &FolderSource::first, -1), {"folder.first is -1"}},
        {with_folder("%d", &FolderSource::count, -2), {"folder.count is -2"}},
        {with_folder("d.png", &FolderSource::colour, "c%d.png"), {"folder.colour", "c%d.png", "d.png"}},
        {with_folder("%d", &FolderSource::haptic, "%s"), {"folder.haptic", "%s"}},
        {with_folder("%d", &FolderSource::height, "%n"), {"folder.height", "%n"}},
    };
    expect_all_refused(good_scene(), cases);
}

TEST(Validation, NamesMemberOfMetricScenes) {
    const std::vector<Refused> cases = {
        {[](Scene& s) { s.depth.scale = 0; }, {"depth.scale is 0", "greater than 0"}},
        {[](Scene& s) { s.depth.scale = nan; }, {"depth.scale is nan"}},
        {[](Scene& s) { s.depth.near = -1; }, {"depth.near is -1"}},
        {[](Scene& s) { s.depth.far = 0; }, {"depth.far is 0", "greater than 0"}},
        {[](Scene& s) { s.depth.far = infinity; }, {"depth.far is inf"}},
        {[](Scene& s) { s.depth.near = 6; }, {"depth.near is 6", "depth.far", "5"}},
        {[](Scene& s) { s.depth.far = 0.0005; }, {"depth.far is 0.0005", "at least one code"}},
        {[](Scene& s) { s.height_coding.max_height = 1; }, {"height_map.units is levels", "world"}},
        {with_world_height(0.01), {"height_map.max is 0.01", "at most 0.000995"}},
    };
    expect_all_refused(metric_scene(), cases);
}

TEST(Validation, ComparesHeightWithNearestCode) {
    Scene scene = metric_scene();
    scene.height_coding = {0.01, HeightUnits::world, 255};
    scene.depth.near = 0.02;
    derive_valid_range(scene.depth);
    EXPECT_TRUE(validate(scene));

    scene = good_scene();  // code 255 stands for 40; without it, the nearest is a level further
    scene.height_coding = {40.2, HeightUnits::world, 255};
    EXPECT_FALSE(validate(scene));
    scene.depth.invalid_codes[0] = 255;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    EXPECT_TRUE(validate(scene));
}

TEST(Validation, NeedsDerivedRange) {
    Scene scene = good_scene();
    scene.depth.invalid_codes[0] = 255;
    scene.depth.invalid_code_count = 1;
    expect_refused(scene, {"depth.valid_max is 255", "must be 254"});
    derive_valid_range(scene.depth);
    EXPECT_TRUE(validate(scene));
    scene.depth.valid_min = 3;
    expect_refused(scene, {"depth.valid_min is 3", "must be 0"});
    scene.depth.invalid_code_count = 99;  // must not be read as far as that
    derive_valid_range(scene.depth);
    expect_refused(scene, {"depth.invalid", "is 99"});
}

TEST(Validation, LeavesAThousandthOfDepth) {
    Random random(31);
    int accepted = 0;
    for (int k = 0; k < 5000; ++k) {
        Scene scene = good_scene();
        scene.depth.near_is_high = random.below(2);
        scene.height_coding.max_height = random.between(70, 76);
        if (!validate(scene)) continue;
        ++accepted;
        double nearest = infinity;
        for (int code = 0; code < 256; ++code)
            nearest = std::min(nearest, scene.depth.depth(static_cast<std::uint16_t>(code)));
        ASSERT_GE(nearest - largest_height(scene.height_coding, scene.depth), 1e-3 * nearest);
    }
    EXPECT_GT(accepted, 1000);
    EXPECT_LT(accepted, 4000);
}

TEST(Validation, NeedsOneDigitField) {
    for (const char* pattern :
         {"%d", "%d.png", "depth_%04d.png", "a/b/%09d_raw.png", "../x/%01d", "/data/%d", "depth.png"}) {
        Scene scene = good_scene();
        scene.folder = folder_of(pattern);
        EXPECT_TRUE(validate(scene)) << pattern;
    }
    for (const char* pattern : {"", "%", "%4d", "%00d", "%010d", "%0d", "%s", "%n", "%d%d", "%d%%", "%%",
                                "%04", "%-4d", "%+d", "%ld", "%04d_%s.png", "%x", "%*d", "a\n%d"}) {
        Scene scene = good_scene();
        scene.folder = folder_of(pattern);
        expect_refused(scene, {"folder.depth", "%0Nd"});
    }
}

// Written scenes are read again unchanged, to the last bit and byte.

std::array<double, 6> ends_of(const HapticRanges& of) {
    return {of.stiffness.min,       of.stiffness.max,        of.static_friction.min,
            of.static_friction.max, of.dynamic_friction.min, of.dynamic_friction.max};
}

/// None of its doubles can be -0 or NaN.
void expect_same(const SceneDescription& one, const SceneDescription& other) {
    const auto sizes_and_codings = [](const Scene& s) {
        return std::tuple(s.name, s.width, s.height, s.rate.num, s.rate.den, s.metres_per_unit, s.camera,
                          s.depth, s.depth_bits, s.height_coding.max_height, s.height_coding.units,
                          s.height_coding.code_max);
    };
    const auto touch = [](const Scene& s) {
        return std::tuple(ends_of(s.haptic), s.default_properties, s.hole_stiffness, s.filter,
                          s.interpolation, s.device_metres_per_unit);
    };
    const auto files = [](const FolderSource& of) {
        return std::tuple(of.depth, of.colour, of.haptic, of.height, of.first, of.count, of.step,
                          of.colour_numbers, of.haptic_numbers, of.height_numbers);
    };
    const Scene &a = one.scene, &b = other.scene;
    EXPECT_EQ(one.unstated, other.unstated);
    EXPECT_EQ(sizes_and_codings(a), sizes_and_codings(b));
    EXPECT_EQ(touch(a), touch(b));
    EXPECT_EQ(a.folder.has_value(), b.folder.has_value());
    EXPECT_EQ(files(a.folder.value_or(FolderSource())), files(b.folder.value_or(FolderSource())));
    ASSERT_EQ(one.materials.size(), other.materials.size());
    for (std::size_t k = 0; k < one.materials.size(); ++k) {
        EXPECT_EQ(one.materials[k].index, other.materials[k].index);
        EXPECT_EQ(one.materials[k].properties, other.materials[k].properties);
    }
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
    scene.width = 1 + random.below(16384);
    scene.height = 1 + random.below(16384);
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
    if (hue) scene.depth.least_sum = random.below(766);
    scene.depth_bits = hue ? 8 : 8 + random.below(9);
    scene.depth.code_max =
        static_cast<std::uint16_t>((hue ? 1536 : (1 << scene.depth_bits) - 1) - random.below(20));
    if (scene.depth.kind == DepthCodingKind::metric) {
        scene.depth.scale = 2 * scene.depth.far / scene.depth.code_max;
        open.far = random.below(2);
        if (open.far) scene.depth.far = scene.depth.scale * scene.depth.code_max;
    } else {
        scene.depth.near_is_high = random.below(2);
    }
    scene.depth.invalid_code_count = random.below(5);
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
    scene.filter = {random.below(2) ? 3 : 5, random.below(17)};
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
    if (random.below(2)) scene.folder = FolderSource{"d_%04d.png", "", "h%d.png", "", random.below(99), 5};
    if (scene.folder && random.below(2)) {
        scene.folder->step = 1 + random.below(9);
        if (random.below(2)) scene.folder->haptic_numbers.first = random.below(999);
        if (random.below(2)) scene.folder->haptic_numbers.step = 1 + random.below(9);
    }
    return described;
}

TEST(SceneFile, RestoresRandomScenesExactly) {
    Random random(41);
    for (std::size_t k = 0; k < 3000; k += sweep_step()) {
        const SceneDescription random_one = random_description(random);
        ASSERT_TRUE(validate(random_one)) << validate(random_one).error().message;
        const std::string json = scene_to_json(random_one);
        SCOPED_TRACE(json);
        const auto again = must(parse_scene(json, "again"));
        expect_same(random_one, again);
        ASSERT_EQ(scene_to_json(again), json);
        if (HasFailure()) return;
    }
}

/// A packed clip has the same bytes on every machine, now and later.
TEST(SceneFile, WritesSameBytes) {
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

TEST(SceneFile, ReadsItsOwnText) {
    for (const char* json : {recording, globe}) {
        const SceneDescription once = described(json);
        expect_same(once, described(scene_to_json(once)));
    }
}

TEST(SceneFile, WritesJsonDespiteBrokenName) {
    Scene scene = parsed(globe);
    scene.name =
        "a\xff"
        "b";
    EXPECT_TRUE(parse_scene(scene_to_json(scene), "t"));
}

TEST(SceneFile, WritesMaterialsAndRanges) {
    const char* const text = R"({"touchable_scene": 1, "width": 4, "height": 3,
        "camera": {"fx": 4, "fy": 4, "cx": 2, "cy": 1}, "depth": {"coding": "metric", "scale": 1},
        "default_properties": {"stiffness": 0.5},
        "haptic": {"static_friction": [0, 1], "materials": {
            "10": {"stiffness_n_per_m": 777.7}, "2": {"stiffness": 2, "dynamic_friction": 0.05}, "0": {}}},
        "folder": {"depth": "d%d.exr", "haptic": "d%d.exr"}})";
    const auto read = must(parse_scene(text, "text"));
    ASSERT_EQ(read.materials.size(), 3U);
    EXPECT_EQ(read.materials[0].index, 0);
    EXPECT_EQ(read.materials[0].properties.stiffness, 500);
    EXPECT_EQ(read.materials[1].index, 2);
    EXPECT_EQ(read.materials[1].properties.static_friction, 0.4);
    EXPECT_EQ(read.materials[2].properties.stiffness, 777.7);
    EXPECT_EQ(ends_of(read.scene.haptic), (std::array{0.5, 2., 0., 1., 0.05, 0.3}));
    expect_same(read, described(scene_to_json(read)));
}

SceneDescription of_millimetres(const std::string& more = {}) {
    return described(R"({"touchable_scene": 1, "width": 4, "height": 3,
        "depth": {"coding": "metric", "scale": 0.001}, "folder": {"depth": "d%d.png", "cameras": "k%d.json"})" +
                     more + "}");
}

SceneDescription::FoundInClip all_found() {
    return {.rate = FrameRate{25, 1}, .camera = Camera{5, 6, 1, 2}, .far = 2.5};
}

TEST(SceneDescription, TakesOpenMembersFromClip) {
    const SceneDescription open = of_millimetres();
    EXPECT_EQ(open.unstated, (SceneDescription::Unstated{true, true, true, all_unstated}));
    const auto scene = must(settle(open, all_found()));
    EXPECT_EQ(scene.rate.num, 25);
    EXPECT_EQ(scene.camera, (Camera{5, 6, 1, 2}));
    EXPECT_EQ(scene.depth.far, 2.5);
    EXPECT_EQ(scene.depth.valid_max, 2500) << "what lies beyond is no depth";
    EXPECT_TRUE(validate(scene));
}

TEST(SceneDescription, KeepsStatedMembers) {
    SceneDescription stated = parsed(recording);
    EXPECT_EQ(stated.unstated, SceneDescription::Unstated{});
    const auto scene = must(settle(stated, all_found()));
    EXPECT_EQ(scene_to_json(scene), scene_to_json(stated));
}

TEST(SceneDescription, HasNoDefaultCamera) {
    SceneDescription::FoundInClip camera_alone;
    camera_alone.camera = Camera{5, 6, 1, 2};
    const auto scene = must(settle(of_millimetres(), camera_alone));
    EXPECT_EQ(scene.rate.num, 30);
    EXPECT_EQ(scene.depth.valid_max, 65535);
    expect_error(settle(of_millimetres(), {.rate = FrameRate{25, 1}, .far = 2.5}),
                 "camera is missing: must be given");
}

// Whether levels leave room for finer codes is known with the far plane.
TEST(SceneDescription, JudgesRemovalWithFarPlane) {
    const SceneDescription open = of_millimetres(R"(, "filter": {"terraces": "on", "levels": [0, 30]})");
    SceneDescription::FoundInClip found = all_found();
    EXPECT_TRUE(settle(open, found));
    found.far = 60;
    expect_error(settle(open, found), "filter.terraces is on");
    found.far = 1e-9;
    EXPECT_FALSE(settle(open, found)) << "no code is so near";
}

}  // namespace
}  // namespace touchable::test
