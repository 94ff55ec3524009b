// SPDX-License-Identifier: Apache-2.0
// Recordings of ROS 2 in MCAP, written from what mcap.dev/spec and OMG's CDR say.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <map>

#include "engine/formats/formats_read.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip_notes.hpp"
#include "tests/import/bag_bytes.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/limits.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

std::string ros2_mcap(const McapOptions& options = {}) {
    return mcap_file(ros2_recording(), options);
}

using Mcap = FolderTest;

TEST_F(Mcap, ReadsEveryPacking) {
    for (const McapOptions& options :
         {McapOptions{}, McapOptions{"lz4"}, McapOptions{"zstd"}, McapOptions{"", false},
          McapOptions{"zstd", true, false}, McapOptions{"lz4", true, true, false},
          McapOptions{"zstd", true, false, false}}) {
        SCOPED_TRACE(options.compression + (options.has_chunks ? " chunks" : "") +
                     (options.has_index ? " index" : "") + (options.has_summary ? " summary" : ""));
        write_bytes(folder / "x.mcap", ros2_mcap(options));
        const auto clip = must(open_clip(folder / "x.mcap"));
        expect_ros2_recording(*clip);
    }
}

TEST_F(Mcap, ReadsUpToCut) {
    const std::string whole = ros2_mcap();
    int opened = 0;
    for (std::size_t length = 8; length < whole.size(); length += 61) {
        write_bytes(folder / "x.mcap", whole.substr(0, length));
        const auto clip = open_clip(folder / "x.mcap");
        opened += bool(clip);
        if (!clip) {
            EXPECT_TRUE(is_refused(clip, "x.mcap"));
        }
    }
    EXPECT_GT(opened, 5);
    write_bytes(folder / "x.mcap", mcap_file({{"/tf", "tf2_msgs/msg/TFMessage", 1, "what"}}));
    EXPECT_TRUE(is_refused(open_clip(folder / "x.mcap"), "x.mcap"));
}

/// As a clip is that lost its first frame, and says so.
void expect_last_two_frames(const std::filesystem::path& file) {
    const auto clip = must(open_clip(file));
    expect_ros2_recording(*clip, 2);
    EXPECT_EQ(std::ranges::count_if(clip_notes(*clip),
                                    [](const std::string& note) {
                                        return note.find("a chunk is damaged") != std::string::npos;
                                    }),
              1);
}

TEST_F(Mcap, SkipsDamagedChunk) {
    const std::map<std::string, std::string> begins{{"lz4", "\x04\x22\x4d\x18"},
                                                    {"zstd", "\x28\xb5\x2f\xfd"}};
    for (const auto& [compression, begin] : begins)
        for (const bool has_index : {true, false})
            for (const bool has_summary : {true, false}) {
                SCOPED_TRACE(compression);
                std::string bytes = ros2_mcap({compression, true, has_index, has_summary});
                bytes[bytes.find(begin)] = 'x';  // of the first chunk
                write_bytes(folder / "x.mcap", bytes);
                expect_last_two_frames(folder / "x.mcap");
            }
    // A plain chunk, in which the first message of depth is none.
    std::string bytes = ros2_mcap();
    std::string time;
    put(time, ros2_recording().front().time_ns);
    const std::size_t op_and_length = 9, channel_and_number = 6;
    const auto at = bytes.find(time + time) - op_and_length - channel_and_number;
    ASSERT_EQ(bytes[at], 5);
    bytes[at] = 8;
    write_bytes(folder / "x.mcap", bytes);
    expect_last_two_frames(folder / "x.mcap");
}

/// Bytes that this process has read so far.
std::uint64_t bytes_read() {
    std::ifstream counters("/proc/self/io");
    std::string name;
    std::uint64_t bytes = 0;
    counters >> name >> bytes;
    EXPECT_EQ(name, "rchar:");
    return bytes;
}

/// A hole in a file is zeros that cost nothing to write.
TEST_F(Mcap, PassesHolesCheaply) {
    const auto file = folder / "x.mcap";
    const std::string whole = ros2_mcap({"zstd"});
    const std::uintmax_t hole = std::uintmax_t{1} << 33U;
    const std::uint64_t before = bytes_read();
    write_bytes(file, whole);
    std::filesystem::resize_file(file, whole.size() + hole);
    {
        const auto clip = must(open_clip(file));
        expect_ros2_recording(*clip);
    }
    // An index, of a chunk that says to have 3 GiB of messages.
    std::string bytes = whole.substr(0, whole.rfind(mcap_record(15, std::string(4, '\0')))), chunk(16, '\0'),
                index;
    put(chunk, std::uint64_t{3} << 30U);
    put(chunk, std::uint32_t{0});
    chunk += mcap_text("zstd");
    put(chunk, std::uint64_t{1});
    bytes += mcap_record(6, chunk + "x") + '\7';
    const std::uint32_t pairs = 100'000'000;
    put(bytes, std::uint64_t{6 + 16 * std::uint64_t{pairs}});
    put(bytes, std::uint16_t{1});
    put(bytes, 16 * pairs);
    write_bytes(file, bytes);
    std::filesystem::resize_file(file, whole.size() + hole);
    const LimitedMemory limited(512);
    const auto clip = must(open_clip(file));
    expect_ros2_recording(*clip);
    EXPECT_LT(bytes_read() - before, 64'000'000);
}

// Recordings of the Azure Kinect: Matroska written here byte by byte, since FFmpeg names b16g wrongly.

/// An element of EBML: its name, its size in eight bytes, what is in it.
std::string element(std::uint32_t id, const std::string& content) {
    std::string bytes;
    for (int shift = 24; shift >= 0; shift -= 8)
        if ((id >> shift) != 0) bytes += static_cast<char>(id >> shift);
    bytes += '\x01';
    for (int shift = 48; shift >= 0; shift -= 8)
        bytes += static_cast<char>(static_cast<std::uint64_t>(content.size()) >> shift);
    return bytes + content;
}
std::string number(std::uint32_t id, std::uint64_t value) {
    std::string bytes;
    for (int shift = 56; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift);
    return element(id, bytes);
}

struct RecordedTrack {
    std::string name, four_letters;
    int width, height, bits;
};
std::string little(std::uint64_t value, int bytes) {
    std::string text;
    for (int k = 0; k < bytes; ++k) text += static_cast<char>(value >> 8 * k);
    return text;
}
std::string track_entry(const RecordedTrack& track, int place) {
    const auto width = static_cast<std::uint64_t>(track.width),
               height = static_cast<std::uint64_t>(track.height);
    const std::string bitmap = little(40, 4) + little(width, 4) + little(height, 4) + little(1, 2) +
                               little(static_cast<std::uint64_t>(track.bits), 2) + track.four_letters +
                               little(width * height * static_cast<std::uint64_t>(track.bits) / 8, 4) +
                               little(0, 16);
    const auto number_of = static_cast<std::uint64_t>(place);
    return element(0xAE, number(0xD7, number_of) + number(0x73C5, number_of) + number(0x83, 1) +
                             element(0x536E, track.name) + element(0x86, "V_MS/VFW/FOURCC") +
                             element(0x63A2, bitmap) +
                             element(0xE0, number(0xB0, width) + number(0xBA, height)));
}

struct RecordedPicture {
    int track;  ///< from 1
    int time_ms;
    std::string bytes;
};
std::string recording(const std::vector<RecordedTrack>& tracks, const std::vector<RecordedPicture>& pictures,
                      const std::string& calibration) {
    std::string entries, blocks;
    for (std::size_t k = 0; k < tracks.size(); ++k)
        entries += track_entry(tracks[k], static_cast<int>(k) + 1);
    for (const RecordedPicture& picture : pictures)
        blocks += element(0xA3, std::string(1, static_cast<char>(0x80 | picture.track)) +
                                    static_cast<char>(picture.time_ms >> 8) +
                                    static_cast<char>(picture.time_ms) + '\x80' + picture.bytes);
    const std::string attachment =
        element(0x61A7, element(0x466E, "calibration.json") + element(0x4660, "application/octet-stream") +
                            number(0x46AE, 77) + element(0x465C, calibration + '\0'));
    const std::string tag = element(
        0x7373, element(0x63C0, "") +
                    element(0x67C8, element(0x45A3, "K4A_DEPTH_MODE") + element(0x4487, "NFOV_2X2BINNED")));
    return element(0x1A45DFA3, element(0x4282, "matroska") + number(0x4287, 2) + number(0x4285, 2)) +
           element(0x18538067, element(0x1549A966, number(0x2AD7B1, 1'000'000)) +
                                   element(0x1654AE6B, entries) + element(0x1941A469, attachment) +
                                   element(0x1254C367, tag) + element(0x1F43B675, number(0xE7, 0) + blocks));
}

constexpr int depth_width = 320, depth_height = 288, colour_width = 1280, colour_height = 720;

std::string calibration(const std::string& terms) {
    const auto camera = [&](const char* purpose, const char* model, const char* pose) {
        return R"({"Purpose": "CALIBRATION_CameraPurpose)" + std::string(purpose) +
               R"(", "Intrinsics": {"ModelParameterCount": 14, "ModelParameters": [)" + model +
               R"(], "ModelType": "CALIBRATION_LensDistortionModelBrownConrady"}, "Rt": )" + pose + "}";
    };
    return R"({"CalibrationInformation": {"Cameras": [)" +
           camera("Depth", ("0.5, 0.5, 0.49, 0.49, " + terms).c_str(),
                  R"({"Rotation": [1,0,0, 0,1,0, 0,0,1], "Translation": [0,0,0]})") +
           ", " +
           camera("PhotoVideo", "0.5, 0.5, 0.48, 0.64, 0,0,0,0,0,0, 0,0, 0,0",
                  R"({"Rotation": [1,0,0, 0,1,0, 0,0,1], "Translation": [-0.032, -0.002, 0.004]})") +
           R"(], "InertialSensors": []}})";
}
constexpr const char* no_distortion = "0,0,0,0,0,0, 0,0, 0,0";

std::uint16_t depth_code(int n, int x, int y) {
    return x < 3 ? 0 : static_cast<std::uint16_t>(900 + 50 * n + x + 2 * y);
}
std::string depth_bytes(int n) {
    std::string bytes;
    for (int y = 0; y < depth_height; ++y)
        for (int x = 0; x < depth_width; ++x) {
            const std::uint16_t code = depth_code(n, x, y);
            bytes += static_cast<char>(code >> 8);
            bytes += static_cast<char>(code);
        }
    return bytes;
}
/// YUY2: luma rises from left to right, one for each four pixels, and with the picture's number.
int luma(int n, int x) {
    return 30 + 5 * n + x / 8;
}
std::string colour_bytes(int n) {
    std::string bytes;
    for (int y = 0; y < colour_height; ++y)
        for (int x = 0; x < colour_width; ++x) {
            bytes += static_cast<char>(luma(n, x));
            bytes += '\x80';
        }
    return bytes;
}

/// Colour comes first, and 20 ms later than depth.
std::string small_recording(const std::string& terms) {
    return recording({{"COLOR", "YUY2", colour_width, colour_height, 16},
                      {"DEPTH", "b16g", depth_width, depth_height, 16},
                      {"IR", "b16g", depth_width, depth_height, 16}},
                     {{2, 5, depth_bytes(0)},
                      {3, 5, depth_bytes(7)},
                      {1, 25, colour_bytes(0)},
                      {2, 38, depth_bytes(1)},
                      {1, 58, colour_bytes(1)},
                      {2, 72, depth_bytes(2)},
                      {1, 92, colour_bytes(2)}},
                     calibration(terms));
}

TEST(AzureKinect, ReadsRecording) {
    const TemporaryFolder folder;
    write_bytes(folder / "k.mkv", small_recording(no_distortion));
    const auto [reader, frames] = must_read(open_clip(folder / "k.mkv"));
    ASSERT_EQ(frames.size(), 3U);
    const Scene& scene = reader->scene();
    EXPECT_EQ(scene.rate.num, 30);
    EXPECT_FALSE(scene.colour_camera);
    const double f = 0.49 * 512, cx = 0.5 * 512 - 96 - 0.5, cy = 0.5 * 512 - 90 - 0.5;
    const double colour_f = 0.48 * 1280, colour_cx = 0.5 * 1280 - 0.5;
    // The nearest colour: depth is 33, 33 and 34 ms apart, colour 20 ms.
    const int nearest[] = {0, 0, 1};
    for (int n = 0; n < 3; ++n) {
        const RawFrame& frame = frames.at(static_cast<std::size_t>(n));
        for (int y = 0; y < depth_height; y += 5)
            for (int x = 0; x < depth_width; x += 3) {
                const std::uint16_t code = frame.depth.sample(x, y);
                ASSERT_EQ(code, depth_code(n, x, y));
                if (!scene.depth.is_valid(code)) continue;
                const double z = 0.001 * depth_code(n, x, y), px = (x - cx) / f * z, py = (y - cy) / f * z;
                ASSERT_TRUE(is_at(scene, code, {f, f, cx, cy}, x, y, z, 1e-6));
                const double column = colour_f * (px - 0.032) / (z + 0.004) + colour_cx;
                const double row = 0.64 * 960 * (py - 0.002) / (z + 0.004) + 0.5 * 960 - 120 - 0.5;
                if (std::abs(row + 0.5) < 0.1 || std::abs(row - 719.5) < 0.1) continue;
                if (row < -0.5 || row > 719.5) {
                    ASSERT_EQ(frame.colour.sample(x, y, 1), 128) << "beyond its picture's edge";
                    continue;
                }
                const double grey =
                    (luma(nearest[n], static_cast<int>(std::lround(column))) - 16) * 255. / 219;
                ASSERT_NEAR(frame.colour.sample(x, y, 1), grey, 2.5) << n << ": " << x << ", " << y;
            }
    }
    ASSERT_EQ(message(reader->seek(2)), "");
    const auto last = must(reader->next());
    EXPECT_TRUE(same_frame(*last, frames.at(2)));
}

TEST(AzureKinect, UndoesLens) {
    const TemporaryFolder folder;
    write_bytes(folder / "k.mkv", small_recording("0.9, 0.2, 0.01, 1.2, 0.4, 0.05, 0,0, 0.0001,-0.0002"));
    const auto guessed = must(guess_clip(folder / "k.mkv", {}));
    const LensDistortion lens{{0.9, 0.2, -0.0002, 0.0001, 0.01, 1.2, 0.4, 0.05}};
    EXPECT_EQ(guessed.scene.lens, lens);
    EXPECT_EQ(guessed.scene.colour_camera->from_depth.translation, (std::array{-0.032, -0.002, 0.004}));
    EXPECT_EQ(guessed.scene.colour_camera->camera.cy, 0.5 * 960 - 120 - 0.5);
    write_bytes(folder / "k.json", scene_to_json(guessed));
    const auto itself = must(open_clip(folder / "k.mkv")), described = must(open_clip(folder / "k.json"));
    EXPECT_FALSE(itself->scene().lens.any());
    const auto frames = must(read_all(*itself)), again = must(read_all(*described));
    EXPECT_TRUE(same_frame(frames.at(1), again.at(1)));
    // The stored place of the pinhole's pixel 40, 30.
    const Camera& camera = guessed.scene.camera;
    const double x = (40 - camera.cx) / camera.fx, y = (30 - camera.cy) / camera.fy, r2 = x * x + y * y;
    const double radial =
        (1 + r2 * (0.9 + r2 * (0.2 + r2 * 0.01))) / (1 + r2 * (1.2 + r2 * (0.4 + r2 * 0.05)));
    const double column = camera.fx * (x * radial - 0.0004 * x * y + 0.0001 * (r2 + 2 * x * x)) + camera.cx;
    const double row = camera.fy * (y * radial - 0.0002 * (r2 + 2 * y * y) + 0.0002 * x * y) + camera.cy;
    EXPECT_EQ(frames.at(0).depth.sample(40, 30),
              depth_code(0, static_cast<int>(std::lround(column)), static_cast<int>(std::lround(row))));
}

TEST(AzureKinect, RefusesDamagedCalibration) {
    const std::string whole = calibration(no_distortion);
    const LimitedMemory limit(512);
    const auto parsed = [](const std::string& text) {
        return parse_azure_kinect_calibration(text, {640, 576}, PictureSize{1920, 1080}, "k.mkv");
    };
    ASSERT_EQ(message(parsed(whole)), "");
    for (std::size_t length = 0; length < whole.size(); ++length)
        ASSERT_NE(message(parsed(whole.substr(0, length))), "") << length;
    EXPECT_TRUE(
        is_refused(parse_azure_kinect_calibration(whole, {640, 480}, {}, "k.mkv"), "depth of 640x480"));
}

/// LeRobot's depth (lerobot 0.6, datasets/depth_utils.py), encoded by x265 in FFmpeg's MP4 as LeRobot does.

constexpr int robot_width = 64, robot_height = 48, robot_frames = 5;

/// Metres: two planes that lean, and a corner without depth.
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
        fill_plane(frame, 0, [&](int x, int y) { return by.code(robot_metres(x, y, n)); });
    });
}

void write_robot_colour(const std::filesystem::path& file, int count) {
    std::filesystem::create_directories(file.parent_path());
    write_video(
        file, {"libx264", AV_PIX_FMT_YUV420P, robot_width, robot_height, count}, [](AVFrame& frame, int n) {
            for (int plane = 0; plane < 3; ++plane)
                fill_plane(frame, plane, [&](int x, int) { return plane ? 60 + 4 * x : 40 + 2 * x + n; });
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
    write_in_folder(data_set / "meta" / "info.json",
                    R"({"codebase_version": "v3.0", "fps": 30, "features": {)" + features + "}}");
}

constexpr const char* robot_depth = "videos/observation.images.wrist_depth/chunk-000/file-000.mp4";
constexpr const char* robot_colour = "videos/observation.images.wrist/chunk-000/file-000.mp4";

/// Codes as they were stored, each within one code of the truth, every point where an unprojection written
/// here has it, and holes where nothing was seen.
void expect_robot_depth(ClipReader& clip, const Published& by) {
    const Scene& scene = clip.scene();
    const auto read = must(read_all(clip));
    ASSERT_EQ(read.size(), static_cast<std::size_t>(robot_frames));
    for (int n = 0; n < robot_frames; ++n)
        for (int y = 0; y < robot_height; ++y)
            for (int x = 0; x < robot_width; ++x) {
                const double truth = robot_metres(x, y, n);
                const auto code =
                    static_cast<std::uint16_t>(read[static_cast<std::size_t>(n)].depth.sample(x, y));
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

using LeRobot = FolderTest;

TEST_F(LeRobot, AssumesUsualDescriptionWithNote) {
    write_robot_depth(folder / "a.mp4");
    auto clip = must(open_clip(folder / "a.mp4"));
    EXPECT_TRUE(is_noted(*clip, "guessed: depth is as LeRobot usually stores it"));
    expect_robot_depth(*clip, {});
    clip = must(open_clip(folder / "a.mp4", {}, stated(&SourceDescription::metres_per_code, 0.001)));
    EXPECT_EQ(clip->scene().depth.depth(1677), 1.677);
}

TEST_F(LeRobot, TakesOtherNumbersAndWords) {
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
        const TemporaryFolder fresh;
        write_robot_depth(fresh / robot_depth, each.by);
        write_robot_info(fresh.path(), each.features);
        auto clip = must(open_clip(fresh / robot_depth));
        EXPECT_EQ(clip->scene().depth.kind == DepthCodingKind::log, each.by.is_log);
        EXPECT_TRUE(is_noted(*clip, "depth is LeRobot's, as info.json says"));
        EXPECT_FALSE(is_noted(*clip, "changes values"));
        expect_robot_depth(*clip, each.by);
    }
}

TEST_F(LeRobot, JoinsEpisodes) {
    write_robot_depth(folder / robot_depth);
    write_robot_colour(folder / robot_colour, robot_frames - 2);
    write_robot_info(folder.path(), robot_feature("") + ", " + robot_colour_feature);
    auto clip = must(open_clip(folder / robot_depth));
    EXPECT_TRUE(is_noted(*clip, "has 3 frames and depth 5: it is left out"));
    EXPECT_EQ(clip->tracks().size(), 1U);
    expect_robot_depth(*clip, {});
    // The colour itself is no depth.
    EXPECT_TRUE(is_refused(open_clip(folder / robot_colour), "in which no depth was found"));
}

TEST_F(LeRobot, RefusesContradictions) {
    write_robot_colour(folder / robot_depth, robot_frames);
    write_robot_info(folder.path(), robot_feature(""));
    EXPECT_TRUE(is_refused(open_clip(folder / robot_depth), "it was encoded anew"));
    write_robot_depth(folder / robot_depth);
    for (const char* wrong :
         {R"(, "video.depth_min": 3, "video.depth_max": 2)",
          R"(, "video.depth_min": 0.1, "video.shift": -0.1)", R"(, "video.depth_max": "10")"}) {
        write_robot_info(folder.path(), robot_feature(wrong));
        const std::string said = message(open_clip(folder / robot_depth));
        EXPECT_TRUE(has_words(said, "must be"));
        EXPECT_TRUE(has_words(said, "wrist_depth"));
    }
    write_robot_info(folder.path(), robot_feature(""));
    write_robot_depth(folder / "videos/observation.images.wrist_depth/chunk-000/file-001.mp4");
    EXPECT_TRUE(is_refused(open_clip(folder.path()), "with 2 videos of depth"));
}

// Snapshots of the RealSense Viewer: codes without a head, and a table of their size and camera.

const std::string snapshot_table =
    "Frame Info: \nType,Depth\nFormat,Z16\nFrame Number,141\nTimestamp (ms),1700000000000.00\n"
    "Resolution x,16\nResolution y,12\nBytes per pixel,2\n\nIntrinsic:,\nFx,20.5\nFy,21\nPPx,7.25\nPPy,5.75\n"
    "Distorsion,Brown Conrady\n";

std::string without(std::string text, const std::string& words, const std::string& instead = "") {
    return text.replace(text.find(words), words.size(), instead);
}

class RealsenseRaw : public ::testing::Test {
protected:
    RealsenseRaw() {
        std::string codes;
        for (int k = 0; k < 16 * 12; ++k) {
            const int code = k == 0 ? 0 : 800 + k;
            codes += static_cast<char>(code & 255);
            codes += static_cast<char>(code >> 8);
        }
        write_bytes(folder / "snap_Depth.raw", codes);
        write_bytes(folder / "snap_Depth_metadata.csv", snapshot_table);
        for (const auto& [name, red] : {std::pair{"snap_Color.png", 200}, {"snap_Depth.png", 50}}) {
            write_in_folder(folder / name, made_image(16, 12, 1, 3, [red = red](int x, int y, int c) {
                                return c == 0 ? red : c == 1 ? 10 : 16 * y + x;
                            }));
        }
    }
    TemporaryFolder folder;
};

TEST_F(RealsenseRaw, OpensWithCameraAndColour) {
    for (const auto& path : {folder / "snap_Depth.raw", folder.path()}) {
        SCOPED_TRACE(path);
        auto reader = must(open_clip(path));
        const Scene scene = reader->scene();
        EXPECT_EQ(scene.camera, (Camera{20.5, 21, 7.25, 5.75}));
        EXPECT_TRUE(is_noted(*reader, "the camera is that of snap_Depth_metadata.csv"));
        const auto frames = must(read_all(*reader));
        ASSERT_EQ(frames.size(), 1U);
        const RawFrame& frame = frames.front();
        EXPECT_NEAR(scene.depth.depth(frame.depth.sample(3, 1)) * scene.metres_per_unit, 0.819, 1e-9);
        EXPECT_FALSE(scene.depth.is_valid(frame.depth.sample(0, 0)));
        ASSERT_FALSE(frame.colour.empty());
        EXPECT_EQ(frame.colour.row(1)[0], 200);
        EXPECT_EQ(std::ranges::count(reader->inputs(), folder / "snap_Depth_metadata.csv"), 1);
        EXPECT_EQ(message(guess_clip(path, {})), "");
    }
    const auto reader = must(open_clip(folder / "snap_Depth.raw", {}, stated(&SourceDescription::fov, 60)));
    EXPECT_NE(reader->scene().camera.fx, 20.5);
}

TEST_F(RealsenseRaw, GivesWayToRecording) {
    for (const char* name : {"depth/1.png", "depth/2.png"})
        write_in_folder(folder / name, even_image(16, 12, 2, 1, 771));
    auto reader = must(open_clip(folder.path()));
    EXPECT_EQ(reader->frame_count(), 2);
}

TEST_F(RealsenseRaw, RefusesMisfitTable) {
    const auto refusal = [&](const std::string& table) {
        write_bytes(folder / "snap_Depth_metadata.csv", table);
        return message(open_clip(folder / "snap_Depth.raw"));
    };
    EXPECT_EQ(refusal(without(snapshot_table, "Fx,20.5", "Fx,20.5\r")), "");
    for (const auto& [table, words] :
         {std::pair{without(snapshot_table, "Z16", "RGB8"),
                    "must have a row \"Format,Z16\", as depth has, not \"RGB8\""},
          {std::string("Type,Depth\n"), "must have a row \"Format,Z16\", as depth has"},
          {without(snapshot_table, "Fx,20.5\n"), "has no row \"Fx,NUMBER\""},
          {without(snapshot_table, "Fx,20.5", "Fx,nan"), "has no row \"Fx,NUMBER\""},
          {without(snapshot_table, "Fx,20.5", "Fx,-1"), "must be above 0"},
          {without(snapshot_table, "x,16", "x,1e300"), "is 1000000x12 pixels: must be"},
          {without(snapshot_table, "x,16", "x,-5"), "is 0x12 pixels: must be"},
          {without(snapshot_table, "x,16", "x,17"),
           "has 384 bytes: must be 408 for the 17x12 pixels of 16 bits that snap_Depth_metadata.csv states"}})
        EXPECT_TRUE(has_words(refusal(table), words));
    std::filesystem::remove(folder / "snap_Depth_metadata.csv");
    EXPECT_TRUE(
        is_refused(open_clip(folder / "snap_Depth.raw"), "is raw numbers without a header, 384 bytes"));
}

}  // namespace
}  // namespace touchable::test
