#include "engine/scene/scene.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "tests/scene/random.hpp"

namespace touchable {
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

TEST(HapticRanges, WorkedExampleOfEquation1) {
    const HapticRanges ranges{{0.01, 1.0}, {0.1, 1.0}, {0.1, 1.0}};
    EXPECT_NEAR(ranges.stiffness.at(70), 0.28176, 0.000005);  // N/mm, as printed
    EXPECT_NEAR(ranges.at(70, 0, 0).stiffness, 281.76, 0.005);
}

TEST(HapticRanges, ChannelsAreStiffnessStaticAndDynamicFriction) {
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

TEST(Height, LevelsAreGreyLevelsOfTheDepthRangeAndWorldIsALength) {
    const Scene scene = good_scene();
    EXPECT_DOUBLE_EQ(largest_height({3.0, HeightUnits::levels, 255}, scene.depth), 3.0 * 140.0 / 255);
    EXPECT_DOUBLE_EQ(largest_height({3.0, HeightUnits::world, 255}, scene.depth), 3.0);
}

TEST(FrameRate, FrameTimesAreFlooredNanoseconds) {
    const FrameRate film{30, 1}, ntsc{30000, 1001};
    EXPECT_EQ(film.time_ns(0), 0);
    EXPECT_EQ(film.time_ns(1), 33333333);
    EXPECT_EQ(film.time_ns(2), 66666666);
    EXPECT_EQ(film.time_ns(30), 1000000000);
    EXPECT_EQ(ntsc.time_ns(1), 33366666);
    EXPECT_EQ(ntsc.time_ns(30000), 1001000000000);
    EXPECT_EQ(film.time_ns(-1), -33333334);
}

TEST(FrameRate, FarFramesNeitherOverflowNorDrift) {
    const FrameRate fast{1000, 1}, odd{999999937, 1000003};
    const std::int64_t last = std::int64_t{1} << 40;
    EXPECT_EQ(fast.time_ns(last), last * 1000000);
    // floor(n k / m) is the one t with t m <= n k < (t + 1) m; whole turns of m frames are k each.
    EXPECT_EQ(odd.time_ns(999999937 * std::int64_t{100}), std::int64_t{1000003} * 1000000000 * 100);
    EXPECT_EQ((FrameRate{1, 1000000000}).time_ns(last), std::numeric_limits<std::int64_t>::max());
}

TEST(FrameRate, TheFrameAtATimeIsTheLastThatIsNotLater) {
    for (const FrameRate& rate : {FrameRate{30, 1}, FrameRate{30000, 1001}, FrameRate{999999937, 1000003}})
        for (const std::int64_t frame : {-3LL, 0LL, 1LL, 2LL, 12345LL, 1LL << 30}) {
            EXPECT_EQ(rate.frame_at(rate.time_ns(frame)), frame);
            EXPECT_EQ(rate.frame_at(rate.time_ns(frame) - 1), frame - 1);
            EXPECT_EQ(rate.frame_at(rate.time_ns(frame + 1) - 1), frame);
        }
}

TEST(Validate, AcceptsWhatIsPossible) {
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
    const char* name;
    std::function<void(Scene&)> spoil;
    std::vector<std::string> parts;
};
const double nan = std::numeric_limits<double>::quiet_NaN(),
             infinity = std::numeric_limits<double>::infinity();

TEST(Validate, NamesTheMemberAndTheNumber) {
    const Refused cases[] = {
        {"width 0", [](Scene& s) { s.width = 0; }, {"width is 0", "1 to 16384"}},
        {"width", [](Scene& s) { s.width = 16385; }, {"width is 16385", "16384"}},
        {"height", [](Scene& s) { s.height = -3; }, {"height is -3", "16384"}},
        {"rate 0", [](Scene& s) { s.rate.num = 0; }, {"rate", "is 0", "1 to"}},
        {"rate -", [](Scene& s) { s.rate.den = -1; }, {"rate", "is -1"}},
        {"unit 0", [](Scene& s) { s.metres_per_unit = 0; }, {"metres_per_unit is 0", "greater than 0"}},
        {"unit nan", [](Scene& s) { s.metres_per_unit = nan; }, {"metres_per_unit is nan"}},
        {"fx", [](Scene& s) { s.camera.fx = 0; }, {"camera.fx is 0", "greater than 0"}},
        {"fx inf", [](Scene& s) { s.camera.fx = infinity; }, {"camera.fx is inf"}},
        {"fy", [](Scene& s) { s.camera.fy = -525.5; }, {"camera.fy is -525.5"}},
        {"cx", [](Scene& s) { s.camera.cx = nan; }, {"camera.cx is nan"}},
        {"cy", [](Scene& s) { s.camera.cy = -infinity; }, {"camera.cy is -inf"}},
        {"near 0", [](Scene& s) { s.depth.near = 0; }, {"depth.near is 0", "greater than 0"}},
        {"near -", [](Scene& s) { s.depth.near = -2.5; }, {"depth.near is -2.5"}},
        {"near nan", [](Scene& s) { s.depth.near = nan; }, {"depth.near is nan"}},
        {"far inf", [](Scene& s) { s.depth.far = infinity; }, {"depth.far is inf"}},
        {"swapped",
         [](Scene& s) { std::swap(s.depth.near, s.depth.far); },
         {"depth.near is 180", "depth.far", "40"}},
        {"equal", [](Scene& s) { s.depth.far = 40; }, {"depth.near is 40", "less than depth.far"}},
        {"bits 7", [](Scene& s) { s.depth_bits = 7; }, {"depth.bits is 7", "8 to 16"}},
        {"bits 17", [](Scene& s) { s.depth_bits = 17; }, {"depth.bits is 17"}},
        {"code_max 0", [](Scene& s) { s.depth.code_max = 0; }, {"depth.code_max is 0", "1 to 255"}},
        {"code_max", [](Scene& s) { s.depth.code_max = 1023; }, {"depth.code_max is 1023", "255"}},
        {"invalid", [](Scene& s) { s.depth.invalid_code_count = 5; }, {"depth.invalid", "is 5", "4"}},
        {"height -", [](Scene& s) { s.height_coding.max_height = -1; }, {"height_map.max is -1", "0"}},
        {"height nan", [](Scene& s) { s.height_coding.max_height = nan; }, {"height_map.max is nan"}},
        {"height code", [](Scene& s) { s.height_coding.code_max = 1000; }, {"height", "1000", "bits"}},
        {"too high",
         [](Scene& s) { s.height_coding.max_height = 73; },
         {"height_map.max is 73", "at most 72.78428", "a thousandth"}},
        {"too near",
         [](Scene& s) { s.depth.near = 1e-4; },
         {"depth.near is 0.0001", "at least 0.00018, a millionth of the deepest valid depth, which is 180"}},
        {"too high beside the far plane",
         [](Scene& s) {
             s.depth.near = 0.001;
             s.height_coding = {0.0009, HeightUnits::world, 255};
         },
         {"height_map.max is 0.0009", "at most 0.00082",
          "0.00018, a millionth of the deepest, has to be left"}},
        {"world high",
         [](Scene& s) {
             s.height_coding = {40, HeightUnits::world, 255};
         },
         {"height_map.max is 40", "at most 39.96 scene units"}},
        {"stiffness range",
         [](Scene& s) {
             s.haptic.stiffness = {2, 1};
         },
         {"haptic.stiffness", "is 1", "2"}},
        {"range -",
         [](Scene& s) { s.haptic.static_friction.min = -0.5; },
         {"haptic.static_friction", "-0.5"}},
        {"range nan",
         [](Scene& s) { s.haptic.dynamic_friction.max = nan; },
         {"haptic.dynamic_friction", "nan"}},
        {"range inf", [](Scene& s) { s.haptic.stiffness.max = infinity; }, {"haptic.stiffness", "inf"}},
        {"stiffness",
         [](Scene& s) { s.default_properties.stiffness = 0; },
         {"default_properties.stiffness", "is 0"}},
        {"hole -", [](Scene& s) { s.hole_stiffness = -0.1; }, {"hole_stiffness is -0.1", "from 0"}},
        {"hole nan", [](Scene& s) { s.hole_stiffness = nan; }, {"hole_stiffness is nan"}},
        {"static -", [](Scene& s) { s.default_properties.static_friction = -1; }, {"static_friction is -1"}},
        {"dynamic -",
         [](Scene& s) { s.default_properties.dynamic_friction = -1; },
         {"dynamic_friction is -1"}},
        {"dynamic over static",
         [](Scene& s) { s.default_properties.dynamic_friction = 0.75; },
         {"default_properties.dynamic_friction is 0.75", "static_friction, which is 0.4"}},
        {"median", [](Scene& s) { s.filter.median = 4; }, {"filter.median is 4", "3 or 5"}},
        {"fill", [](Scene& s) { s.filter.fill_holes = 17; }, {"filter.fill_holes is 17", "16"}},
        {"noise -", [](Scene& s) { s.filter.terrace_noise = -1; }, {"filter.terrace_noise is -1", "4 codes"}},
        {"noise", [](Scene& s) { s.filter.terrace_noise = 4.5; }, {"filter.terrace_noise is 4.5"}},
        {"noise nan", [](Scene& s) { s.filter.terrace_noise = nan; }, {"filter.terrace_noise is nan"}},
        {"terraces",
         [](Scene& s) {
             s.filter.terraces = TerraceRemoval::on;
             s.filter.levels = {1e6, 0};
         },
         {"filter.terraces is on", "filter.levels"}},
        {"temporal noise nan",
         [](Scene& s) { s.filter.temporal_noise.constant = nan; },
         {"filter.temporal_noise's constant is nan"}},
        {"temporal",
         [](Scene& s) { s.filter.temporal = true; },
         {"filter.temporal is on", "filter.temporal_noise is [0, 0]"}},
        {"fill -", [](Scene& s) { s.filter.fill_holes = -1; }, {"filter.fill_holes is -1"}},
        {"device scale", [](Scene& s) { s.device_metres_per_unit = 0.0; }, {"device_metres_per_unit is 0"}},
        {"device nan", [](Scene& s) { s.device_metres_per_unit = nan; }, {"device_metres_per_unit is nan"}},
        {"first",
         [](Scene& s) {
             s.folder = folder_of("%d");
             s.folder->first = -1;
         },
         {"folder.first is -1"}},
        {"count",
         [](Scene& s) {
             s.folder = folder_of("%d");
             s.folder->count = -2;
         },
         {"folder.count is -2"}},
        {"colour",
         [](Scene& s) {
             s.folder = folder_of("d.png");
             s.folder->colour = "c%d.png";
         },
         {"folder.colour", "c%d.png", "d.png"}},
        {"haptic",
         [](Scene& s) {
             s.folder = folder_of("%d");
             s.folder->haptic = "%s";
         },
         {"folder.haptic", "%s"}},
        {"height",
         [](Scene& s) {
             s.folder = folder_of("%d");
             s.folder->height = "%n";
         },
         {"folder.height", "%n"}},
    };
    for (const Refused& refused : cases) {
        SCOPED_TRACE(refused.name);
        Scene scene = good_scene();
        refused.spoil(scene);
        expect_refused(scene, refused.parts);
    }
}

TEST(Validate, NamesTheMemberAndTheNumberOfMetricScenes) {
    const Refused cases[] = {
        {"scale 0", [](Scene& s) { s.depth.scale = 0; }, {"depth.scale is 0", "greater than 0"}},
        {"scale nan", [](Scene& s) { s.depth.scale = nan; }, {"depth.scale is nan"}},
        {"near -", [](Scene& s) { s.depth.near = -1; }, {"depth.near is -1"}},
        {"far 0", [](Scene& s) { s.depth.far = 0; }, {"depth.far is 0", "greater than 0"}},
        {"far inf", [](Scene& s) { s.depth.far = infinity; }, {"depth.far is inf"}},
        {"near >= far", [](Scene& s) { s.depth.near = 6; }, {"depth.near is 6", "depth.far", "5"}},
        {"no code", [](Scene& s) { s.depth.far = 0.0005; }, {"depth.far is 0.0005", "at least one code"}},
        {"levels", [](Scene& s) { s.height_coding.max_height = 1; }, {"height_map.units is levels", "world"}},
        {"height over nearest code",
         [](Scene& s) {
             s.height_coding = {0.01, HeightUnits::world, 255};
         },
         {"height_map.max is 0.01", "at most 0.000995"}},
    };
    for (const Refused& refused : cases) {
        SCOPED_TRACE(refused.name);
        Scene scene = metric_scene();
        refused.spoil(scene);
        expect_refused(scene, refused.parts);
    }
}

TEST(Validate, HeightIsMeasuredAgainstTheNearestCodeThatCanOccur) {
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

TEST(Validate, TheValidRangeIsTheDerivedOne) {
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

TEST(Validate, HeightThatJustFitsLeavesAThousandthOfEveryDepth) {
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

TEST(Validate, FilePatternsHaveOneFieldOfDigitsAndNothingElse) {
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

}  // namespace
}  // namespace touchable
