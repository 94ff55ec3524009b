#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "engine/scene/frames.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/import/foreign_video.hpp"

/// LeRobot's depth (lerobot 0.6, datasets/depth_utils.py), encoded by x265 in FFmpeg's MP4 as LeRobot does.
namespace touchable::test {
namespace {

constexpr int robot_width = 64, robot_height = 48, robot_frames = 5;

/// Metres: two planes that lean, and a corner that nobody saw.
double robot_metres(int x, int y, int n) {
    if (x < 4 && y < 4) return 0;
    return (x < 30 ? 0.4 + 0.004 * x : 2.5 + 0.02 * y) + 0.01 * n;
}

/// quantize_depth and dequantize_depth as published; 0 metres becomes 0.
struct Published {
    double near = 0.01, far = 10, shift = 3.5;
    bool is_log = true;
    int code(double z) const {
        const double low = std::log(near + shift), top = std::log(far + shift);
        const double share = is_log ? (std::log(z + shift) - low) / (top - low) : (z - near) / (far - near);
        return static_cast<int>(std::clamp(std::rint(share * 4095), 0.0, 4095.0));
    }
    double metres(int code) const {
        const double low = std::log(near + shift), top = std::log(far + shift);
        return is_log ? std::exp(code * (top - low) / 4095 + low) - shift : near + code * (far - near) / 4095;
    }
};

void write_robot_depth(const std::filesystem::path& file, const Published& by = {},
                       int count = robot_frames) {
    ForeignVideo video{"libx265", AV_PIX_FMT_GRAY12, robot_width, robot_height, count};
    video.tag = MKTAG('h', 'v', 'c', '1');
    video.interval = 2;
    std::filesystem::create_directories(file.parent_path());
    write_video(file, video, [&](AVFrame& frame, int n) {
        for (int y = 0; y < robot_height; ++y)
            for (int x = 0; x < robot_width; ++x) set_sample(frame, 0, x, y, by.code(robot_metres(x, y, n)));
    });
}

void write_robot_colour(const std::filesystem::path& file, int count) {
    std::filesystem::create_directories(file.parent_path());
    write_video(file, {"libx264", AV_PIX_FMT_YUV420P, robot_width, robot_height, count},
                [](AVFrame& frame, int n) {
                    for (int plane = 0; plane < 3; ++plane)
                        for (int y = 0; y < robot_height / (plane ? 2 : 1); ++y)
                            for (int x = 0; x < robot_width / (plane ? 2 : 1); ++x)
                                set_sample(frame, plane, x, y, plane ? 60 + 4 * x : 40 + 2 * x + n);
                });
}

std::string robot_feature(const std::string& info) {
    return R"("observation.images.wrist_depth": {"dtype": "video", "shape": [48, 64, 1],
        "names": ["height", "width", "channels"], "info": {"is_depth_map": true, "video.codec": "hevc",
        "video.pix_fmt": "gray12le", "video.fps": 30)" +
           info + "}}";
}
constexpr const char* robot_colour_feature =
    R"("observation.images.wrist": {"dtype": "video", "shape": [48, 64, 3],
    "info": {"is_depth_map": false, "video.codec": "h264", "video.pix_fmt": "yuv420p"}})";

void write_robot_info(const std::filesystem::path& data_set, const std::string& features) {
    std::filesystem::create_directories(data_set / "meta");
    write_bytes(data_set / "meta" / "info.json",
                R"({"codebase_version": "v3.0", "fps": 30, "features": {)" + features + "}}");
}

constexpr const char* robot_depth = "videos/observation.images.wrist_depth/chunk-000/file-000.mp4";
constexpr const char* robot_colour = "videos/observation.images.wrist/chunk-000/file-000.mp4";

/// Codes as they were stored, each within one code of the truth, every point where an unprojection written
/// here has it, and holes where nothing was seen.
void expect_robot_depth(ClipReader& clip, const Published& by) {
    const Scene& scene = clip.scene();
    const auto read = read_all(clip);
    ASSERT_EQ(message(read), "");
    ASSERT_EQ(read->size(), static_cast<std::size_t>(robot_frames));
    for (int n = 0; n < robot_frames; ++n)
        for (int y = 0; y < robot_height; ++y)
            for (int x = 0; x < robot_width; ++x) {
                const double truth = robot_metres(x, y, n);
                const auto code =
                    static_cast<std::uint16_t>((*read)[static_cast<std::size_t>(n)].depth.sample(x, y));
                ASSERT_EQ(code, by.code(truth));
                ASSERT_EQ(scene.depth.is_valid(code), truth > 0) << x << "," << y;
                if (!(truth > 0)) continue;
                const double z = by.metres(code), step = by.metres(code + 1) - z;
                ASSERT_NEAR(z, truth, step);
                const auto point =
                    unproject(scene.camera, x, y, scene.depth.depth(code)) * scene.metres_per_unit;
                ASSERT_NEAR(point.x, (x - scene.camera.cx) / scene.camera.fx * z, 1e-12);
                ASSERT_NEAR(std::abs(point.y), std::abs((y - scene.camera.cy) / scene.camera.fy * z), 1e-12);
                ASSERT_NEAR(std::abs(point.z), z, 1e-12);
            }
}

TEST(LeRobot, ADataSetOpensByItsVideoAndByItsFolder) {
    const TemporaryFolder folder;
    write_robot_depth(folder / robot_depth);
    write_robot_colour(folder / robot_colour, robot_frames);
    write_robot_info(folder.path(),
                     robot_feature(R"(, "video.depth_min": 0.01, "video.depth_max": 10.0, "video.shift": 3.5,
        "video.use_log": true)") +
                         ", " + robot_colour_feature);
    for (const std::filesystem::path& named : {folder / robot_depth, folder.path()}) {
        auto clip = open_clip(named);
        ASSERT_EQ(message(clip), "");
        EXPECT_EQ((*clip)->scene().depth.kind, DepthCodingKind::log);
        EXPECT_TRUE(is_noted(**clip, "depth is LeRobot's, as info.json says"));
        EXPECT_TRUE(is_noted(**clip, "colour is ../../observation.images.wrist/chunk-000/file-000.mp4"));
        EXPECT_FALSE(is_noted(**clip, "changes values"));
        EXPECT_FALSE(is_noted(**clip, "a code is"));
        const auto first = (*clip)->next();
        ASSERT_EQ(message(first), "");
        EXPECT_FALSE((*first)->colour.empty());
        ASSERT_EQ(message((*clip)->rewind()), "");
        expect_robot_depth(**clip, {});
    }
}

TEST(LeRobot, WithoutItsDescriptionTheUsualIsAssumedAndSaid) {
    const TemporaryFolder folder;
    write_robot_depth(folder / "a.mp4");
    auto clip = open_clip(folder / "a.mp4");
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "guessed: depth is as LeRobot usually stores it"));
    expect_robot_depth(**clip, {});
    SourceDescription known;
    known.metres_per_code = 0.001;
    clip = open_clip(folder / "a.mp4", {}, known);
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().depth.depth(1677), 1.677);
}

TEST(LeRobot, OtherNumbersStandAndOlderWordsToo) {
    struct Case {
        Published by;
        std::string features;
    };
    const Case cases[] = {
        {{0.0, 4, 1, true},
         robot_feature(
             R"(, "video.depth_min": 0.0, "video.depth_max": 4, "video.shift": 1, "video.use_log": true)")},
        {{0.2, 6, 0, false},
         robot_feature(
             R"(, "video.depth_min": 0.2, "video.depth_max": 6, "video.shift": 3.5, "video.use_log": false)")},
        {{0.0, 8, 0, false},
         robot_feature(R"(, "video.depth_min": 0, "video.depth_max": 8, "video.use_log": false)")},
        {{0.3, 5, 2, true},
         R"("observation.images.wrist_depth": {"dtype": "video", "video_info": {"video.is_depth_map": true,
            "video.depth_min": 0.3, "video.depth_max": 5, "video.shift": 2}})"}};
    for (const Case& each : cases) {
        const TemporaryFolder folder;
        write_robot_depth(folder / robot_depth, each.by);
        write_robot_info(folder.path(), each.features);
        auto clip = open_clip(folder / robot_depth);
        ASSERT_EQ(message(clip), "");
        expect_robot_depth(**clip, each.by);
    }
}

TEST(LeRobot, EpisodesAreOneClipAndColourOfOthersIsLeftOut) {
    const TemporaryFolder folder;
    write_robot_depth(folder / robot_depth);
    write_robot_colour(folder / robot_colour, robot_frames - 2);
    write_robot_info(folder.path(), robot_feature("") + ", " + robot_colour_feature);
    auto clip = open_clip(folder / robot_depth);
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "has 3 frames and depth 5: it is left out"));
    EXPECT_EQ((*clip)->tracks().size(), 1U);
    expect_robot_depth(**clip, {});
    // The colour itself is no depth.
    EXPECT_TRUE(is_refused(open_clip(folder / robot_colour), "in which no depth was found"));
}

TEST(LeRobot, WhatIsNotAsItSaysIsRefused) {
    const TemporaryFolder folder;
    write_robot_colour(folder / robot_depth, robot_frames);
    write_robot_info(folder.path(), robot_feature(""));
    EXPECT_TRUE(is_refused(open_clip(folder / robot_depth), "it was encoded anew"));
    write_robot_depth(folder / robot_depth);
    for (const char* wrong :
         {R"(, "video.depth_min": 3, "video.depth_max": 2)",
          R"(, "video.depth_min": 0.1, "video.shift": -0.1)", R"(, "video.depth_max": "10")"}) {
        write_robot_info(folder.path(), robot_feature(wrong));
        const std::string said = message(open_clip(folder / robot_depth));
        EXPECT_NE(said.find("must be"), std::string::npos) << said;
        EXPECT_NE(said.find("wrist_depth"), std::string::npos) << said;
    }
    write_robot_info(folder.path(), robot_feature(""));
    write_robot_depth(folder / "videos/observation.images.wrist_depth/chunk-000/file-001.mp4");
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "with 2 videos of depth"));
}

}  // namespace
}  // namespace touchable::test
