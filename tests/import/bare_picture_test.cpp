// SPDX-License-Identifier: Apache-2.0
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/magic.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <fstream>
#include <mutex>
#include <optional>
#include <set>
#include <stop_token>
#include <thread>

#include "engine/base/threads.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/import/foreign_video.hpp"
#include "tests/picture/results.hpp"
#include "tests/real_data.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

/// A picture of depth, 20 x 10, with a hole.
PlaneView write_picture(const std::filesystem::path& file, Samples& memory, int bytes = 2, int channels = 1) {
    const PlaneView plane = test_plane(memory, 20, 10, bytes, channels, bytes == 2 ? 3000 : 200, 5, true);
    memory[0] = memory[1] = 0;
    EXPECT_EQ(message(write_png(file, plane)), "");
    return plane;
}

SourceDescription camera_of(double fx, double fy, std::optional<double> unit) {
    SourceDescription known;
    known.intrinsics = Intrinsics{.fx = fx, .fy = fy};
    known.metres_per_code = unit;
    return known;
}

using BarePicture = FolderTest;

TEST_F(BarePicture, CameraMakesNoPictureOfNotes) {
    write_bytes(folder / "notes.bin", "Buy bread, milk and a haptic device.");
    EXPECT_TRUE(is_refused(open_clip(folder / "notes.bin", std::nullopt, camera_of(30, 31, 0.0005)),
                           "is of no kind that is known (touchable formats"));
}

/// RGB-D: colour in one half, nearness in the other, as of frame n.
Image rgbd(int n, bool is_beside = true, bool is_depth_first = false) {
    return made_image(is_beside ? 64 : 32, is_beside ? 24 : 48, 1, 3, [=](int x, int y, int c) {
        const bool is_second = is_beside ? x >= 32 : y >= 24;
        if (is_second != is_depth_first)
            return 3 * (is_beside ? x % 32 : x) + 2 * n + (is_beside ? y : y % 24);
        return c == 0 ? 90 + 3 * x : c == 1 ? 120 + n : 60 + 3 * y;
    });
}

void expect_halves(const RawFrame& frame, int n, bool is_exact = true) {
    const int colour_lost = is_exact ? 0 : 24, lost = is_exact ? 0 : 4;
    ASSERT_EQ(frame.depth.width, 32);
    ASSERT_EQ(frame.depth.height, 24);
    ASSERT_FALSE(frame.colour.empty());
    for (int y = 2; y < 22; ++y)
        for (int x = 2; x < 30; ++x) {
            ASSERT_NEAR(frame.depth.sample(x, y), 3 * x + 2 * n + y, lost) << x << ", " << y;
            ASSERT_NEAR(frame.colour.sample(x, y, 1), 120 + n, colour_lost) << x << ", " << y;
        }
}

TEST_F(BarePicture, HasDepthBesideColour) {
    for (const bool is_beside : {true, false})
        for (const bool is_first : {true, false}) {
            write_in_folder(folder / "a b.png", rgbd(0, is_beside, is_first));
            const auto [clip, frames] = must_read(open_clip(folder / "a b.png"));
            expect_halves(frames.at(0), 0);
            EXPECT_EQ(clip->scene().width, 32);
            EXPECT_TRUE(is_noted(*clip, std::string("depth is the ") +
                                            (is_beside  ? is_first ? "left" : "right"
                                             : is_first ? "upper"
                                                        : "lower") +
                                            " half, which is grey"));
            EXPECT_FALSE(is_noted(*clip, "squeezed"));
            EXPECT_TRUE(is_noted(*clip, "depth has no scale"));
        }
    const Image beside = rgbd(0);
    write_bytes(folder / "b.jpg", must(jpeg_bytes(beside.view())));
    const auto [clip, frames] = must_read(open_clip(folder / "b.jpg"));
    expect_halves(frames.at(0), 0, false);
    EXPECT_TRUE(is_noted(*clip, "depth is stored as mjpeg"));
    write_in_folder(folder / "half_sbs.png", made_image(32, 24, 1, 3, [&](int x, int y, int c) {
                        return beside.view().sample(2 * x, y, c);
                    }));
    EXPECT_TRUE(
        is_noted(*must(open_clip(folder / "half_sbs.png")), "the focal length across is half that down"));
}

/// The scene file that init-scene writes for them finds the halves as well.
TEST_F(BarePicture, HasDepthBesideColourInFolders) {
    const std::filesystem::path takes = folder / "takes";
    for (int n = 0; n < 3; ++n) write_in_folder(takes / ("f" + std::to_string(n) + ".png"), rgbd(n));
    const auto check = [&] {
        const auto [clip, frames] = must_read(open_clip(takes, {}, {}, Colour::wanted, DepthAlignment::off));
        ASSERT_EQ(frames.size(), 3U);
        for (int n = 0; n < 3; ++n) expect_halves(frames[static_cast<std::size_t>(n)], n);
        EXPECT_TRUE(is_noted(*clip, "depth is the right half"));
    };
    check();
    write_bytes(takes / "scene.json", scene_to_json(must(guess_clip(takes, {}))));
    check();
}

TEST_F(BarePicture, OpensWithCameraAlone) {
    for (const int bytes : {1, 2}) {
        Samples memory;
        const PlaneView plane = write_picture(folder / "my.png", memory, bytes);
        auto reader = must(open_clip(folder / "my.png", std::nullopt, camera_of(30, 31, 0.0005)));
        const Scene& scene = reader->scene();
        EXPECT_EQ(scene.camera, (Camera{30, 31, 9.5, 4.5}));
        EXPECT_EQ(scene.metres_per_unit, 1);
        EXPECT_FALSE(scene.depth.is_valid(0));
        EXPECT_EQ(scene.depth.depth(1000), 0.5);
        EXPECT_FALSE(is_noted(*reader, "guessed"));
        const auto frames = must(read_all(*reader));
        ASSERT_EQ(frames.size(), 1U);
        EXPECT_TRUE(same_plane(frames.at(0).depth, plane));
        EXPECT_EQ(reader->inputs(), std::vector{folder / "my.png"});
    }
}

/// A least confidence may be stated beside a scene file, found or named, which states all else.
TEST_F(BarePicture, TakesLeastConfidenceBesideScene) {
    const std::vector<float> depth(12, 2.0F);
    std::vector<float> confidence(12, 5.0F);
    confidence[3] = 1;
    write_npz(folder / "my.npz",
              {{"depth", npy_bytes("3, 4", depth)}, {"conf", npy_bytes("3, 4", confidence)}});
    write_npz(folder / "none.npz", {{"depth", npy_bytes("3, 4", depth)}});
    const auto scene_of = [&](const std::string& picture) {
        std::ofstream(folder / (picture + ".json")) << R"({"touchable_scene": 1, "width": 4, "height": 3,
            "camera": {"fx": 77, "fy": 77, "cx": 1.5, "cy": 1}, "metres_per_unit": 1,
            "depth": {"coding": "metric", "scale": 1, "near": 0.5, "far": 8, "invalid": [0]},
            "folder": {"depth": ")" << picture << R"(.npz"}})";
        return folder / (picture + ".json");
    };
    SourceDescription known;
    const auto expect = [&](const Result<std::unique_ptr<ClipReader>>& clip, int without_depth) {
        ASSERT_EQ(message(clip), "");
        EXPECT_EQ((*clip)->scene().camera.fx, 77);
        const auto frame = must((*clip)->next());
        int holes = 0;
        for (int k = 0; k < 12; ++k) {
            const std::uint16_t code = stored_code(frame->depth, (*clip)->scene().depth, k % 4, k / 4);
            holes += (*clip)->scene().depth.is_valid(code) ? 0 : 1;
        }
        EXPECT_EQ(holes, without_depth);
    };
    const auto scene = scene_of("my");
    for (const auto& [least, holes] : {std::pair{0.5, 0}, {2.0, 1}, {6.0, 12}}) {
        known.least_confidence = least;
        expect(open_clip(folder / "my.npz", std::nullopt, known), holes);
        expect(open_clip(folder / "my.npz", scene, known), holes);
        expect(open_clip(scene, std::nullopt, known), holes);
    }
    EXPECT_TRUE(is_refused(open_clip(scene_of("none"), std::nullopt, known), "has no confidence"));
    known.metres_per_code = 1;  // which the scene file says
    EXPECT_TRUE(is_refused(open_clip(folder / "my.npz", scene, known), "a scene file describes it"));
}

TEST_F(BarePicture, OpensStackThatBeginsBlank) {
    std::vector<float> depth(24, 0.0F);
    const SourceDescription known = stated(&SourceDescription::fov, 60);
    write_npz(folder / "blank.npz", {{"depth", npy_bytes("2, 3, 4", depth)}});
    EXPECT_TRUE(is_refused(open_clip(folder / "blank.npz", std::nullopt, known), "has no depth"));
    std::fill(depth.begin() + 12, depth.end(), 2.5F);
    write_npz(folder / "my.npz", {{"depth", npy_bytes("2, 3, 4", depth)}});
    const auto [clip, frames] = must_read(open_clip(folder / "my.npz", std::nullopt, known));
    const DepthCoding& coding = clip->scene().depth;
    EXPECT_FALSE(coding.is_valid(stored_code(frames.at(0).depth, coding, 1, 1)));
    EXPECT_NEAR(coding.depth(stored_code(frames.at(1).depth, coding, 1, 1)), 2.5, 0.001);
}

/// PFM of 32 bits, or NumPy's array of 16, of a ball from 4 to 6 before a background.
std::string ball_file(bool is_pfm, float background) {
    const auto value = [=](int x, int y) {
        const bool is_ball = x >= 5 && x < 12 && y >= 8 && y < 15;
        return is_ball ? (x == 8 && y == 11 ? 4.0F : 6.0F) : background;
    };
    if (is_pfm) return pfm_of(20, 20, value);
    std::string bytes = npy_header("<f2", "20, 20");
    for (int k = 0; k < 400; ++k) {
        const float at = value(k % 20, k / 20);
        const std::uint16_t half = at > 6 ? 0x7bff : at == 4 ? 0x4400 : 0x4600;
        bytes.append(reinterpret_cast<const char*>(&half), sizeof half);
    }
    return bytes;
}

/// Distances along rays and depth along the camera's axis differ most at the corners.
TEST_F(BarePicture, TakesPlanarityFromName) {
    const std::string pfm =
        pfm_of(4, 3, [](int x, int y) { return 1 + 0.0371 * std::pow(4 * (2 - y) + x, 2); });
    for (const char* name : {"a.pfm", "range_1.pfm", "arrange.pfm", "frame.0000.depth_meters.pfm",
                             "distance_to_camera_0000.pfm", "distance_to_image_plane_0000.pfm"})
        write_bytes(folder / name, pfm);
    const auto semantics = [&](const char* name, const SourceDescription& known, const std::string& note) {
        auto clip = open_clip(folder / name, std::nullopt, known);
        EXPECT_EQ(message(clip), "") << name;
        if (!clip) return DepthSemantics::planar;
        EXPECT_TRUE(note.empty() || is_noted(**clip, note)) << name;
        EXPECT_EQ(note.empty(), !is_noted(**clip, "depth goes along")) << name;
        return (*clip)->scene().depth.semantics;
    };
    EXPECT_EQ(semantics("a.pfm", {}, "if it goes along each pixel's ray, the corners are"),
              DepthSemantics::planar);
    EXPECT_EQ(semantics("arrange.pfm", {}, "along the camera's axis"), DepthSemantics::planar);
    EXPECT_EQ(semantics("range_1.pfm", {}, "ray, as the name says"), DepthSemantics::range);
    EXPECT_EQ(semantics("frame.0000.depth_meters.pfm", {}, "ray, as the name says"), DepthSemantics::range);
    EXPECT_EQ(semantics("distance_to_camera_0000.pfm", {}, "ray, as the name says"), DepthSemantics::range);
    EXPECT_EQ(semantics("distance_to_image_plane_0000.pfm", {}, "camera's axis"), DepthSemantics::planar);
    SourceDescription known;
    known.semantics = DepthSemantics::range;
    EXPECT_EQ(semantics("a.pfm", known, ""), DepthSemantics::range);
    known.semantics = DepthSemantics::planar;
    EXPECT_EQ(semantics("range_1.pfm", known, ""), DepthSemantics::planar);
}

/// Most of the picture is background: the ball has to be the surface, and not the hole in one.
TEST_F(BarePicture, MakesRendererBackgroundAHole) {
    for (const auto& [name, background] : {std::pair{"a.pfm", 1e10F},
                                           {"b.pfm", 65504.0F},
                                           {"c.pfm", -1e30F},
                                           {"d.npy", 65504.0F},
                                           {"e.pfm", 1e9F},
                                           {"f.pfm", -65504.0F},
                                           {"g.pfm", INFINITY},
                                           {"h.pfm", -INFINITY}}) {
        SCOPED_TRACE(name);
        const TemporaryFolder own;
        write_bytes(own / name, ball_file(std::string(name).ends_with("pfm"), background));
        auto reader = must(open_clip(own / name));
        const Scene& scene = reader->scene();
        EXPECT_TRUE(is_noted(*reader, "values are metres: their median, 6"));
        EXPECT_TRUE(is_noted(*reader, "% of the pixels are background"));
        EXPECT_NEAR(scene.depth.near, 4, 1e-9);
        EXPECT_NEAR(scene.depth.far, 6.3, 1e-6);
        const auto frames = must(read_all(*reader));
        const PlaneView& depth = frames.at(0).depth;
        EXPECT_FALSE(scene.depth.is_valid(depth.sample(0, 0)));
        EXPECT_NEAR(scene.depth.depth(depth.sample(6, 10)), 6, 1e-4);
    }
    write_bytes(folder / "a.pfm", "Pf\n1 1\n-1\n" + std::string("\xf9\x02\x15\x50", 4));
    EXPECT_EQ(message(open_clip(folder / "a.pfm")),
              (folder / "a.pfm").string() +
                  ": has no depth: all values are 0 or a renderer's background (1e9 and beyond, 65504)");
}

/// By FFmpeg: 1/depth, brighter to the right, but for what JPEG does to it.
TEST_F(BarePicture, ReadsGreyJpegWithNote) {
    constexpr int width = 96, height = 64;
    write_bytes(folder / "depth.jpg",
                jpeg_of(width, height, [](int x, int, int plane) { return plane == 0 ? 20 + 2 * x : 128; }));
    auto reader = must(open_clip(folder / "depth.jpg"));
    EXPECT_TRUE(is_noted(*reader, "depth is a JPEG, and has lost what is finer than 256 levels"));
    const auto frame = must(reader->next());
    const Scene& scene = reader->scene();
    const double f = width / 2.0 / std::tan(M_PI / 6);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double z = 1 / (1 / 1.5 + x / 95.0 * (1 / 0.5 - 1 / 1.5)), near = 0.03 * z;
            const std::uint16_t code = stored_code((*frame).depth, scene.depth, x, y);
            ASSERT_TRUE(is_at(scene, code, {f, f, 47.5, 31.5}, x, y, z, near));
        }
}

TEST_F(BarePicture, GuessesCameraAndUnit) {
    Samples memory;
    const PlaneView plane = write_picture(folder / "my.png", memory);
    auto reader = must(open_clip(folder / "my.png"));
    const Scene& scene = reader->scene();
    EXPECT_NEAR(scene.camera.fx, 10 / std::tan(M_PI / 6), 1e-12);
    EXPECT_EQ(scene.depth.depth(1000), 1);
    EXPECT_TRUE(is_noted(*reader, "sees 60 degrees from left to right"));
    EXPECT_TRUE(is_noted(*reader, "depth codes are millimetres: their median, "));
    EXPECT_TRUE(is_noted(*reader, "0 and 65535 are no depth"));
    EXPECT_TRUE(same_plane(read_all(*reader)->at(0).depth, plane));
    reader = must(open_clip(folder / "my.png", std::nullopt, stated(&SourceDescription::fov, 90)));
    EXPECT_NEAR(reader->scene().camera.fx, 10, 1e-12);
    EXPECT_FALSE(is_noted(*reader, "degrees from left to right"));
}

TEST_F(BarePicture, FindsColourBesideIt) {
    for (const auto& [depth, colour] : {std::pair{"room_depth.png", "room_color.png"},
                                        {"room_depth.png", "room.png"},
                                        {"d/my.png", "d/my.jpg"}}) {
        const TemporaryFolder own;
        std::filesystem::create_directories(own / "d");
        Samples memory;
        write_picture(own / depth, memory);
        const PlaneView picture = write_picture(own / colour, memory, 1, 3);  // PNG under any name
        auto reader = must(open_clip(own / depth));
        EXPECT_TRUE(same_plane(read_all(*reader)->at(0).colour, picture));
        EXPECT_TRUE(is_noted(*reader, "colour is"));
    }
}

TEST_F(BarePicture, OpensByAnySceneFile) {
    Samples memory;
    const PlaneView plane = write_picture(folder / "my.png", memory);
    Scene scene = small_scene(20, 10, 16);
    for (const bool speaks : {false, true}) {
        if (speaks) scene.folder = FolderSource{.depth = "d%d.png", .colour = "", .haptic = "", .height = ""};
        write_bytes(folder / "scene.json", scene_to_json(scene));
        auto reader = must(open_clip(folder / "my.png", folder / "scene.json"));
        EXPECT_TRUE(same_plane(read_all(*reader)->at(0).depth, plane));
    }
}

TEST_F(BarePicture, IsDescribedBySceneOfItsName) {
    Samples memory;
    write_picture(folder / "my.png", memory);
    write_bytes(folder / "my.json", scene_to_json(must(guess_picture(folder / "my.png", {}))));
    EXPECT_TRUE(is_noted(*must(open_clip(folder / "my.png")), "described by my.json"));
    std::filesystem::remove(folder / "my.json");
    EXPECT_FALSE(is_noted(*must(open_clip(folder / "my.png")), "described by"));
}

TEST_F(BarePicture, AveragesNearlyGrey) {
    // Grey as codecs leave it in three channels.
    const auto grey = [](int x, int y) { return 20 + 5 * x + 3 * y; };
    const Image picture = made_image(
        32, 16, 1, 3, [&](int x, int y, int c) { return grey(x, y) + (x * 5 + y * 3 + c * 7) % 10; });
    std::filesystem::create_directory(folder / "clip");
    for (const char* name : {"a.png", "clip/depth_1.png", "clip/depth_2.png"})
        ASSERT_EQ(message(write_png(folder / name, picture.view())), "");
    for (const char* name : {"a.png", "clip"}) {
        auto clip = must(open_clip(folder / name, {}, stated(&SourceDescription::metres_per_code, 0.01)));
        EXPECT_TRUE(is_noted(*clip, "depth is nearly grey, and a value is the mean of its colours"));
        EXPECT_EQ(clip->tracks().size(), 1U);
        const auto frame = must(clip->next());
        int sum = 1;
        for (const int c : {0, 7, 14}) sum += grey(9, 4) + (9 * 5 + 4 * 3 + c) % 10;
        EXPECT_EQ((*frame).depth.sample(9, 4), sum / 3);
    }
}

TEST_F(BarePicture, RefusesInvalidDescriptions) {
    Samples memory;
    write_picture(folder / "my.png", memory);
    write_picture(folder / "colour.png", memory, 1, 3);
    write_picture(folder / "100%.png", memory);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(8, 8), 1, {})), "");
    const auto with = [&](const char* name, double fx, double unit) {
        return message(open_clip(folder / name, std::nullopt, camera_of(fx, 30, unit)));
    };
    EXPECT_TRUE(has_words(with("my.png", 0, 0.001), "camera.fx is 0"));
    EXPECT_TRUE(has_words(with("my.png", 30, -1), "depth.scale is -1"));
    EXPECT_TRUE(has_words(with("colour.png", 30, 0.001), "is in colour"));
    EXPECT_TRUE(is_refused(open_clip(folder / "colour.png"), "is in colour"));
    EXPECT_TRUE(has_words(with("100%.png", 30, 0.001), "rename it"));
    EXPECT_TRUE(has_words(with("clip.mkv", 30, 0.001), "has its scene in it"));
    EXPECT_TRUE(
        is_refused(open_clip(folder / "my.png", std::nullopt, stated(&SourceDescription::preset, "kinekt")),
                   "must be one of tum, redwood"));
    Samples nothing(400, 0);
    ASSERT_EQ(message(write_png(folder / "empty.png", {nothing.data(), 40, 20, 10, 2, 1})), "");
    EXPECT_TRUE(is_refused(open_clip(folder / "empty.png"), "has no depth"));
}

using Paths = std::set<std::filesystem::path>;

Paths inputs_of(const Result<std::unique_ptr<ClipReader>>& reader) {
    EXPECT_EQ(message(reader), "");
    if (!reader) return {};
    return {(*reader)->inputs().begin(), (*reader)->inputs().end()};
}

using Inputs = FolderTest;

TEST_F(Inputs, ListClipAndSceneFile) {
    const auto clip = folder / "clip.mkv", described = folder / "scene.json";
    ASSERT_EQ(message(write_clip(clip, small_scene(40, 30), 2, {})), "");
    write_bytes(described, scene_to_json(small_scene(40, 30)));
    EXPECT_EQ(inputs_of(open_clip(clip)), Paths{clip});
    EXPECT_EQ(inputs_of(open_clip(clip, described)), (Paths{clip, described}));
}

TEST_F(Inputs, ListEveryPictureOfFolder) {
    Scene scene = small_scene(8, 6);
    scene.folder = FolderSource{.depth = "d%d.png", .colour = "c%d.png", .haptic = "", .height = ""};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    Paths all{folder / "scene.json"};
    Samples memory;
    for (int n = 0; n < 3; ++n)
        for (const auto& [name, channels] : {std::pair{"d", 1}, {"c", 3}}) {
            const auto file = folder / (name + std::to_string(n) + ".png");
            const PlaneView plane = test_plane(memory, 8, 6, 1, channels, 255, 1, true);
            ASSERT_EQ(message(write_png(file, plane)), "");
            all.insert(file);
        }
    EXPECT_EQ(inputs_of(open_clip(folder.path())), all);
    EXPECT_EQ(inputs_of(open_clip(folder / "scene.json")), all);
    EXPECT_EQ(inputs_of(open_clip(folder.path(), folder / "scene.json")), all);
}

TEST_F(Inputs, ListDepthkitMetadata) {
    Image picture{8, 12, 1, 3, std::vector<std::uint8_t>(8 * 12 * 3, 90)};
    write_quicktime(folder / "Take 1.mov", {picture, picture}, {24, 1});
    write_bytes(folder / "Take 1.Metadata.asset",
                "format: perpixel\ntextureWidth: 8\ntextureHeight: 12\nperspectives:\n- depthImageSize: {x: "
                "8, y: 6}\n"
                "  depthPrincipalPoint: {x: 4, y: 3}\n  depthFocalLength: {x: 7, y: 7}\n  farClip: 1.5\n"
                "  nearClip: 0.5\n  crop: {x: 0, y: 0, z: 1, w: 1}\n");
    EXPECT_EQ(inputs_of(open_clip(folder / "Take 1.mov")),
              (Paths{folder / "Take 1.mov", folder / "Take 1.Metadata.asset"}));
}

// Opening that is given up ends at once, though a disk does not answer.

/// As long as it lives, reads that may wait are answered so many times, and then wait for its end.
class SilentDisk {
public:
    explicit SilentDisk(int answers) {
        const std::lock_guard lock(mutex);
        left = answers;
    }
    ~SilentDisk() {
        const std::lock_guard lock(mutex);
        left.reset();
        changed.notify_all();
    }
    SilentDisk(const SilentDisk&) = delete;
    SilentDisk& operator=(const SilentDisk&) = delete;

    /// Returns when a read waits; false if `over` came first.
    bool await_silence(std::stop_token over) {
        std::unique_lock lock(mutex);
        return changed.wait(lock, std::move(over), [] { return left && *left < 0; });
    }

    static bool is_there() {
        const std::lock_guard lock(mutex);
        return left.has_value();
    }
    static void read() {
        std::unique_lock lock(mutex);
        if (!left || --*left >= 0) return;
        changed.notify_all();
        changed.wait(lock, [] { return !left; });
    }

private:
    static inline std::mutex mutex;
    static inline std::condition_variable_any changed;
    static inline std::optional<int> left;
};

}  // namespace
}  // namespace touchable::test

// In place of the C library's for this program: nothing is in memory already.
extern "C" ssize_t preadv2(int file, const iovec* to, int count, off_t at, int flags) {
    using touchable::test::SilentDisk;
    if (SilentDisk::is_there()) {
        if (flags == RWF_NOWAIT) {
            errno = EAGAIN;
            return -1;
        }
        SilentDisk::read();
    }
    return syscall(SYS_preadv2, file, to, count, at, 0, flags);
}
extern "C" int fstatfs(int file, struct statfs* about) noexcept {
    const auto status = static_cast<int>(syscall(SYS_fstatfs, file, about));
    if (about->f_type == TMPFS_MAGIC) about->f_type = EXT4_SUPER_MAGIC;
    return status;
}

namespace touchable::test {
namespace {

using Clock = std::chrono::steady_clock;

struct Ending {
    bool was_silent = false;
    std::chrono::duration<double> took{};  // from when it was given up
};

/// Opens a clip on a disk that falls silent after so many answers, and then cancels opening.
Ending open_on(const std::filesystem::path& clip, int answers) {
    SilentDisk disk(answers);
    std::stop_source given_up, over;
    Clock::time_point asked;
    bool was_silent = false;
    std::thread person([&] {
        was_silent = disk.await_silence(over.get_token());
        asked = Clock::now();
        given_up.request_stop();
    });
    const auto reader = work_until(given_up.get_token(), [&] { return open_clip(clip); });
    const auto ended = Clock::now();
    over.request_stop();
    person.join();
    if (was_silent) {
        EXPECT_FALSE(reader) << "opened, though it was given up";
        EXPECT_TRUE(reader || reader.error().kind == ErrorKind::interrupted) << message(reader);
    } else {
        EXPECT_EQ(message(reader), "");
    }
    return {was_silent, ended - asked};
}

/// A clip of each kind of file, among the seeds of the fuzzer.
const std::array<std::string, 16> kept_clips{
    "clip/small.mkv",         "bag/realsense_lz4.bag", "bag/tum_bz2.bag",       "bag/depth_plain.bag",
    "k4a/with_colour.mkv",    "video/v.mp4",           "video/v.webm",          "video/v.avi",
    "depthkit_video/png.mov", "heic/portrait.heic",    "jpeg_depth/gdepth.jpg", "npy_stack/stack.npy",
    "npy_stack/stack.npz",    "png/grey16.png",        "tiff/float.tif",        "stream/depth.ts"};

/// Copies one to `folder`, with the files that it needs beside it.
std::filesystem::path copied_clip(const std::string& kept, const std::filesystem::path& folder) {
    namespace fs = std::filesystem;
    const fs::path seeds = fs::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds",
                   clip = folder / fs::path(kept).filename();
    fs::copy_file(seeds / kept, clip, fs::copy_options::overwrite_existing);
    if (kept.starts_with("depthkit_video/"))
        fs::copy_file(seeds / "depthkit/one.asset", folder / (clip.stem().string() + ".Metadata.asset"),
                      fs::copy_options::overwrite_existing);
    return clip;
}

/// Wherever the disk falls silent.
void expect_given_up_at_once(const std::filesystem::path& clip) {
    std::chrono::duration<double> quickest{1e9};
    int silent = 0;
    for (int answers = 0;; ++answers) {
        SCOPED_TRACE(answers);
        const Ending ending = open_on(clip, answers);
        if (!ending.was_silent) break;
        ++silent;
        quickest = std::min(quickest, ending.took);
        ASSERT_FALSE(::testing::Test::HasFailure());
    }
    EXPECT_GT(silent, 0);
    EXPECT_LT(quickest.count(), 0.05);
}

TEST(CancelledOpening, EndsForEveryKind) {
    const TemporaryFolder folder;
    for (const std::string& kept : kept_clips) {
        SCOPED_TRACE(kept);
        expect_given_up_at_once(copied_clip(kept, folder.path()));
        if (::testing::Test::HasFailure()) return;
    }
}

TEST(CancelledOpening, EndsForFolder) {
    const TemporaryFolder folder;
    for (int n = 0; n < 5; ++n) {
        const auto number = std::to_string(n);
        write_in_folder(folder / ("depth_" + number + ".png"), even_image(8, 6, 2, 1, 257 * (3 + n)));
        write_in_folder(
            folder / ("image_" + number + ".png"),
            made_image(8, 6, 1, 3, [&](int x, int y, int c) { return x + y + c == 0 ? 200 : n; }));
    }
    expect_given_up_at_once(folder.path());
}

TEST(CancelledOpening, ReachesNestedWork) {
    std::stop_source around, within;
    EXPECT_FALSE(stop_requested());
    {
        const StopScope outer(around.get_token());
        {
            const StopScope inner(within.get_token());
            EXPECT_FALSE(stop_requested());
            around.request_stop();
            EXPECT_TRUE(stop_requested()) << "who gives up all gives up each part";
            const StopScope* const of_this_thread = StopScope::current();
            std::thread([&] {
                EXPECT_FALSE(stop_requested()) << "of this thread alone";
                {
                    const StopScope part(of_this_thread);
                    EXPECT_TRUE(stop_requested()) << "but for what it does a part of";
                }
                EXPECT_FALSE(stop_requested());
            }).join();
        }
        EXPECT_TRUE(stop_requested());
    }
    EXPECT_FALSE(stop_requested());
    {
        within.request_stop();
        const StopScope inner(within.get_token());
        EXPECT_TRUE(stop_requested());
    }
}

// Detection and playback together open each file of a clip once.

class FileAccess : public ::testing::Test {
protected:
    void write_pictures(const std::string& name, int count, int bytes, int channels) const {
        for (int n = 0; n < count; ++n) {
            // The high byte of two is 3: a depth of about 0.8 m.
            write_in_folder(folder / (name + std::to_string(100 + n) + ".png"),
                            made_image(16, 12, bytes, channels, [&](int x, int y, int c) {
                                const int k = bytes * channels * (16 * y + x) + c;
                                return bytes == 2 ? 768 + ((7 * n + k) & 255) : 7 * n + k;
                            }));
        }
    }
    void write_floats(const std::string& name, int count) const {
        for (int n = 0; n < count; ++n)
            write_bytes(folder / (name + std::to_string(100 + n) + ".pfm"),
                        pfm_of(16, 12, [&](int x, int y) { return 1 + 0.01 * (16 * (11 - y) + x + n); }));
    }
    std::map<std::string, int> counts_of(const std::filesystem::path& clip) const {
        OpenedFiles opened(folder.path());
        auto reader = open_clip(clip);
        EXPECT_EQ(message(reader), "") << clip;
        if (!reader) return {};
        EXPECT_EQ(message(read_all(**reader)), "") << clip;
        return opened.counts();
    }
    /// Some of the frames are read again in search of the far plane.
    void expect_folder_read_once(int frames, const std::vector<std::string>& planes) const {
        const auto counts = counts_of(folder.path());
        EXPECT_EQ(counts.size(), planes.size() * static_cast<std::size_t>(frames));
        for (const std::string& plane : planes) {
            int again = 0;
            for (int n = 0; n < frames; ++n) {
                const auto found = std::find_if(counts.begin(), counts.end(), [&](const auto& each) {
                    return each.first.starts_with(plane + std::to_string(100 + n));
                });
                ASSERT_NE(found, counts.end());
                EXPECT_LE(found->second, n < 16 ? 1 : 2) << found->first;
                again += found->second - 1;
            }
            EXPECT_LE(again, 16) << plane;
        }
    }
    TemporaryFolder folder;
};

TEST_F(FileAccess, OpensGuessedFolderPicturesOnce) {
    write_pictures("depth_", 40, 2, 1);
    write_pictures("image_", 40, 1, 3);
    expect_folder_read_once(40, {"depth_", "image_"});
}

TEST_F(FileAccess, OpensSearchedPicturesOnce) {
    write_floats("depth_", 40);
    expect_folder_read_once(40, {"depth_"});
}

TEST_F(FileAccess, OpensEveryKindOnce) {
    for (const std::string& kept : kept_clips) {
        SCOPED_TRACE(kept);
        for (const auto& [name, count] : counts_of(copied_clip(kept, folder.path())))
            EXPECT_EQ(count, 1) << name;
    }
}

TEST_F(FileAccess, RewindsWithoutOpeningAgain) {
    for (const std::string& kept : kept_clips) {
        if (kept.ends_with(".png") || kept.ends_with(".tif")) continue;  // pictures are not kept open
        SCOPED_TRACE(kept);
        const auto clip = copied_clip(kept, folder.path());
        OpenedFiles opened(folder.path());
        auto reader = must(open_clip(clip));
        for (int round = 0; round < 2; ++round) {
            ASSERT_EQ(message(read_all(*reader)), "");
            ASSERT_EQ(message(reader->rewind()), "");
        }
        for (const auto& [name, count] : opened.counts()) EXPECT_EQ(count, 1) << name;
    }
}

}  // namespace
}  // namespace touchable::test
