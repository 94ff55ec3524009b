// Recordings of the Azure Kinect: Matroska written here byte by byte, since FFmpeg names b16g wrongly.
#include <gtest/gtest.h>

#include <cmath>

#include "engine/formats/formats_read.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limited_memory.hpp"

namespace touchable::test {
namespace {

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

TEST(AzureKinect, ARecordingIsAsItWasRecorded) {
    const TemporaryFolder folder;
    write_bytes(folder / "k.mkv", small_recording(no_distortion));
    auto reader = open_clip(folder / "k.mkv");
    ASSERT_EQ(message(reader), "");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    const Scene& scene = (*reader)->scene();
    EXPECT_EQ(scene.rate.num, 30);
    EXPECT_FALSE(scene.colour_camera);
    const double f = 0.49 * 512, cx = 0.5 * 512 - 96 - 0.5, cy = 0.5 * 512 - 90 - 0.5;
    const double colour_f = 0.48 * 1280, colour_cx = 0.5 * 1280 - 0.5;
    // Of 33, 33 and 34 ms, and 20 ms between them, the nearest colour.
    const int nearest[] = {0, 0, 1};
    for (int n = 0; n < 3; ++n) {
        const RawFrame& frame = frames->at(static_cast<std::size_t>(n));
        for (int y = 0; y < depth_height; y += 5)
            for (int x = 0; x < depth_width; x += 3) {
                const std::uint16_t code = frame.depth.sample(x, y);
                ASSERT_EQ(code, depth_code(n, x, y));
                if (!scene.depth.is_valid(code)) continue;
                const double z = 0.001 * depth_code(n, x, y), px = (x - cx) / f * z, py = (y - cy) / f * z;
                const auto point = unproject(scene.camera, x, y, scene.depth.depth(code));
                ASSERT_NEAR(point.x, px, 1e-6);
                ASSERT_NEAR(point.y, -py, 1e-6);
                ASSERT_NEAR(point.z, -z, 1e-6);
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
    ASSERT_EQ(message((*reader)->seek(2)), "");
    const auto last = (*reader)->next();
    ASSERT_EQ(message(last), "");
    EXPECT_TRUE(same_frame(**last, frames->at(2)));
}

TEST(AzureKinect, ItsLensIsUndoneAndItsSceneDescribesIt) {
    const TemporaryFolder folder;
    write_bytes(folder / "k.mkv", small_recording("0.9, 0.2, 0.01, 1.2, 0.4, 0.05, 0,0, 0.0001,-0.0002"));
    const auto guessed = guess_clip(folder / "k.mkv", {});
    ASSERT_EQ(message(guessed), "");
    const LensDistortion lens{{0.9, 0.2, -0.0002, 0.0001, 0.01, 1.2, 0.4, 0.05}};
    EXPECT_EQ(guessed->scene.lens, lens);
    EXPECT_EQ(guessed->scene.colour_camera->from_depth.translation, (std::array{-0.032, -0.002, 0.004}));
    EXPECT_EQ(guessed->scene.colour_camera->camera.cy, 0.5 * 960 - 120 - 0.5);
    write_bytes(folder / "k.json", scene_to_json(*guessed));
    auto itself = open_clip(folder / "k.mkv"), described = open_clip(folder / "k.json");
    ASSERT_EQ(message(itself), "");
    ASSERT_EQ(message(described), "");
    EXPECT_FALSE((*itself)->scene().lens.any());
    const auto frames = read_all(**itself), again = read_all(**described);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(message(again), "");
    EXPECT_TRUE(same_frame(frames->at(1), again->at(1)));
    // Where the pinhole's pixel 40, 30 was stored.
    const Camera& camera = guessed->scene.camera;
    const double x = (40 - camera.cx) / camera.fx, y = (30 - camera.cy) / camera.fy, r2 = x * x + y * y;
    const double radial =
        (1 + r2 * (0.9 + r2 * (0.2 + r2 * 0.01))) / (1 + r2 * (1.2 + r2 * (0.4 + r2 * 0.05)));
    const double column = camera.fx * (x * radial - 0.0004 * x * y + 0.0001 * (r2 + 2 * x * x)) + camera.cx;
    const double row = camera.fy * (y * radial - 0.0002 * (r2 + 2 * y * y) + 0.0002 * x * y) + camera.cy;
    EXPECT_EQ(frames->at(0).depth.sample(40, 30),
              depth_code(0, static_cast<int>(std::lround(column)), static_cast<int>(std::lround(row))));
}

TEST(AzureKinect, ACalibrationThatIsDamagedIsRefused) {
    const std::string whole = calibration(no_distortion);
    const LimitedMemory limit(512);
    const auto parsed = [](const std::string& text) {
        return parse_azure_kinect_calibration(text, {640, 576}, PictureSize{1920, 1080}, "k.mkv");
    };
    ASSERT_EQ(message(parsed(whole)), "");
    for (std::size_t length = 0; length < whole.size(); ++length)
        ASSERT_NE(message(parsed(whole.substr(0, length))), "") << length;
    Numbers numbers(3);
    for (int trial = 0; trial < 2000; ++trial) {
        std::string changed = whole;
        changed[static_cast<std::size_t>(numbers.below(static_cast<int>(whole.size())))] =
            static_cast<char>(numbers.below(256));
        EXPECT_EQ(message(parsed(changed)).find('\n'), std::string::npos);
    }
    EXPECT_TRUE(
        is_refused(parse_azure_kinect_calibration(whole, {640, 480}, {}, "k.mkv"), "depth of 640x480"));
}

}  // namespace
}  // namespace touchable::test
