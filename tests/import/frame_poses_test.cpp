// SPDX-License-Identifier: Apache-2.0
// Poses of the camera beside frames, by the layouts of those who write them, against a wall that stands
// still.

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/picture/results.hpp"
#include "tests/temporary_files.hpp"

namespace touchable::test {
namespace {

using Numbers3 = std::array<double, 3>;

constexpr int wall_frames = 4, wall_width = 32, wall_height = 24;
constexpr double wall_focal = 30, wall_cx = 15, wall_cy = 12.5;
/// Points of the wall: their product with this is 2 m.
constexpr Numbers3 wall_normal{0.2, -0.3, 1};
constexpr double wall_distance = 2;

/// The camera of a frame: turned about x by b, then about y by a, and moved.
struct Stand {
    double a, b;
    Numbers3 place;
};
Stand stand_of(int frame) {
    return {0.1 * frame - 0.15, 0.07 * frame, {0.05 * frame, 0.02, -0.1 * frame}};
}
/// The rotation about y times that about x, row by row.
std::array<double, 9> matrix_of(const Stand& s) {
    const double c = std::cos(s.a), m = std::sin(s.a), d = std::cos(s.b), e = std::sin(s.b);
    return {c, m * e, m * d, 0, d, -e, -m, c * e, c * d};
}
/// The same as x, y, z, w.
std::array<double, 4> quaternion_of(const Stand& s) {
    const double ca = std::cos(s.a / 2), sa = std::sin(s.a / 2), cb = std::cos(s.b / 2),
                 sb = std::sin(s.b / 2);
    return {ca * sb, sa * cb, -sa * sb, ca * cb};
}
/// R (x, y, z) + t.
Numbers3 moved(const std::array<double, 9>& r, const Numbers3& t, const Numbers3& p) {
    Numbers3 q{};
    for (std::size_t k = 0; k < 3; ++k)
        q[k] = r[3 * k] * p[0] + r[3 * k + 1] * p[1] + r[3 * k + 2] * p[2] + t[k];
    return q;
}
double on_wall(const Numbers3& p) {
    return wall_normal[0] * p[0] + wall_normal[1] * p[1] + wall_normal[2] * p[2];
}

class FramePoses : public ::testing::Test {
protected:
    void SetUp() override {
        write_bytes(folder / "intrinsics.json", R"({"fx": 30, "fy": 30, "cx": 15, "cy": 12.5})");
        for (int frame = 0; frame < wall_frames; ++frame) {
            const auto r = matrix_of(stand_of(frame));
            const double ahead = wall_distance - on_wall(stand_of(frame).place);
            write_in_folder(
                folder / picture(frame),
                made_image(wall_width, wall_height, 2, 1, [&](int column, int row, int) {
                    const Numbers3 ray{(column - wall_cx) / wall_focal, (row - wall_cy) / wall_focal, 1};
                    return std::lround(1000 * ahead / on_wall(moved(r, {}, ray)));
                }));
        }
    }
    static std::string picture(int frame) { return "depth/" + std::to_string(frame) + ".png"; }

    static std::string tum_line(const std::string& time, int frame) {
        const Stand stand = stand_of(frame);
        std::string line = time;
        for (const double number : stand.place) line += ' ' + std::to_string(number);
        for (const double number : quaternion_of(stand)) line += ' ' + std::to_string(number);
        return line + '\n';
    }
    std::unique_ptr<ClipReader> opened(const std::filesystem::path& clip) const {
        return must(open_clip(clip));
    }
    /// The largest distance from the wall of all pixels with depth, unprojected to the world, metres.
    static double farthest_from_wall(ClipReader& reader) {
        const Scene& scene = reader.scene();
        const auto frames = must(read_all(reader));
        EXPECT_TRUE(scene.path);
        if (!scene.path) return 1e9;
        double farthest = 0;
        for (std::size_t n = 0; n < frames.size(); ++n) {
            if (n >= scene.path->poses.size() || !scene.path->poses[n]) continue;
            const CameraPose& pose = *scene.path->poses[n];
            for (int row = 0; row < wall_height; ++row)
                for (int column = 0; column < wall_width; ++column) {
                    const double z =
                        scene.depth.depth(frames[n].depth.sample(column, row)) * scene.metres_per_unit;
                    const Numbers3 seen{z * (column - wall_cx) / wall_focal, z * (row - wall_cy) / wall_focal,
                                        z};
                    Numbers3 place{};
                    for (std::size_t k = 0; k < 3; ++k)
                        place[k] = pose.translation[k] * scene.metres_per_unit;
                    const double off = on_wall(moved(pose.rotation, place, seen)) - wall_distance;
                    farthest = std::max(farthest, std::abs(off));
                }
        }
        return farthest;
    }
    /// The clip in the folder has so many poses, and they lead to the wall.
    void expect_wall(std::size_t known) {
        const auto reader = opened(folder.path());
        EXPECT_LT(farthest_from_wall(*reader), a_code);
        ASSERT_TRUE(reader->scene().path);
        EXPECT_EQ(reader->scene().path->known(), known);
    }
    std::string note() const {
        const auto reader = opened(folder.path());
        for (const std::string& each : reader ? reader->notes() : std::vector<ClipNote>())
            if (each.find("camera stood") != std::string::npos || each.find("poses") != std::string::npos)
                return each;
        return "";
    }
    /// Half of one, and six digits of a pose.
    static constexpr double a_code = 0.001;
    TemporaryFolder folder;
};

TEST_F(FramePoses, TakeNearestTumTime) {
    std::string list, poses = "# ground truth trajectory\n# timestamp tx ty tz qx qy qz qw\n";
    for (int frame = 0; frame < wall_frames; ++frame) {
        const double time = 1305031102.175304 + frame / 30.0;
        list += std::to_string(time) + ' ' + picture(frame) + '\n';
        poses += tum_line(std::to_string(time - 0.015), 0);
        if (frame != 2) poses += tum_line(std::to_string(time - 0.004), frame);
    }
    write_bytes(folder / "depth.txt", list);
    // A unit is said, as such lists are taken for TUM's 0.2 mm.
    write_bytes(folder / "intrinsics.json",
                R"({"fx": 30, "fy": 30, "cx": 15, "cy": 12.5, "depth_scale": 1000})");
    write_bytes(folder / "groundtruth.txt", poses);
    const auto reader = opened(folder.path());
    ASSERT_TRUE(reader && reader->scene().path);
    const CameraPath& path = *reader->scene().path;
    ASSERT_EQ(path.known(), 4U);
    for (const std::size_t frame : {0U, 1U, 3U})
        EXPECT_NEAR(path.poses[frame]->translation[2], -0.1 * static_cast<double>(frame), 1e-9);
    EXPECT_EQ(path.poses[2]->translation[2], 0) << "15 ms before, as there is none nearer";
    EXPECT_EQ(note(), "where the camera stood is known of 4 of 4 frames, by groundtruth.txt");
}

TEST_F(FramePoses, ReadTum) {
    std::string by_time, counted, few;
    for (int frame = 0; frame < wall_frames; ++frame) {
        by_time += tum_line(std::to_string(frame / 30.0 + 0.005), frame);
        counted += tum_line(std::to_string(1000 + frame), frame);
        if (frame != 1) few += tum_line(std::to_string(frame / 30.0), frame);
    }
    for (const auto& [text, known] : {std::pair{by_time, 4U}, {counted, 4U}, {few, 3U}}) {
        write_bytes(folder / "groundtruth.txt", text);
        expect_wall(known);
    }
}

TEST_F(FramePoses, ReadRedwood) {
    std::string log;
    for (int frame = 0; frame < wall_frames; ++frame) {
        const auto r = matrix_of(stand_of(frame));
        const Numbers3 t = stand_of(frame).place;
        log += std::to_string(frame) + ' ' + std::to_string(frame) + ' ' + std::to_string(frame + 1) + '\n';
        for (std::size_t row = 0; row < 3; ++row)
            log += std::to_string(r[3 * row]) + ' ' + std::to_string(r[3 * row + 1]) + ' ' +
                   std::to_string(r[3 * row + 2]) + ' ' + std::to_string(t[row]) + '\n';
        log += "0 0 0 1\n";
    }
    write_bytes(folder / "trajectory.log", log);
    expect_wall(4);
}

/// Its cameras look along -z with y up: another half turn about x comes first.
TEST_F(FramePoses, ReadRecord3d) {
    std::string poses;
    for (int frame = 0; frame < wall_frames; ++frame) {
        const auto [x, y, z, w] = quaternion_of(stand_of(frame));
        poses += frame > 0 ? ", [" : "[";
        for (const double number : {w, z, -y, -x}) poses += std::to_string(number) + ", ";
        const Numbers3 t = stand_of(frame).place;
        poses += std::to_string(t[0]) + ", " + std::to_string(t[1]) + ", " + std::to_string(t[2]) + ']';
    }
    std::filesystem::remove(folder / "intrinsics.json");
    write_bytes(folder / "metadata.json",
                R"({"h": 24, "w": 32, "fps": 59.85, "K": [30, 0, 0, 0, 30, 0, 15, 12.5, 1], "poses": [)" +
                    poses + "]}");
    expect_wall(4);
}

TEST_F(FramePoses, SurviveEveryKindOfClip) {
    std::string poses;
    for (int frame = 0; frame < wall_frames; ++frame)
        if (frame != 2) poses += tum_line(std::to_string(frame / 30.0), frame);
    write_bytes(folder / "groundtruth.txt", poses);
    const TemporaryFolder output;
    const auto first = opened(folder.path());
    ASSERT_TRUE(first && first->scene().path);
    std::filesystem::path from = folder.path();
    for (const char* name : {"clip.mkv", "clip.mp4", "pictures", "again.mkv"}) {
        const auto reader = opened(from);
        ASSERT_TRUE(reader);
        const auto to = output / name;
        auto writer =
            must(to.extension() == ".mkv"   ? create_clip(to, reader->described(), exact_clip)
                 : to.extension() == ".mp4" ? create_clip(to, reader->described())
                                            : create_image_folder(to, reader->described(), Existing::keep));
        const auto frames = must(read_all(*reader));
        for (const RawFrame& frame : frames) ASSERT_EQ(message(writer->write(frame)), "");
        ASSERT_EQ(message(writer->finish()), "");
        const auto back = opened(to);
        ASSERT_TRUE(back && back->scene().path) << name;
        EXPECT_LT(farthest_from_wall(*back), a_code) << name;
        const CameraPath &kept = *back->scene().path, &was = *first->scene().path;
        ASSERT_EQ(kept.known(), 3U) << name;
        for (std::size_t n : {0U, 1U, 3U})
            for (std::size_t k = 0; k < 9; ++k)
                EXPECT_NEAR(kept.poses[n]->rotation[k], was.poses[n]->rotation[k], 1e-12) << name;
        EXPECT_NEAR(kept.length(), was.length(), 1e-12);
        from = to;
    }
    auto part = must(part_of_clip(opened(output / "clip.mkv"), {.first = 1, .last = 3, .every = 2}));
    ASSERT_TRUE(part->scene().path);
    EXPECT_EQ(part->scene().path->poses.size(), 2U);
    EXPECT_LT(farthest_from_wall(*part), a_code);
}

TEST_F(FramePoses, SkipUnreadableFilesWithNote) {
    const std::pair<const char*, const char*> files[] = {
        {"0 0 0 0 0 0 0 1\n1 2 3\n", "line 2: is \"1 2 3\": must be a time and a camera's pose"},
        {"0 0 0 0 0 0 0 2\n", "line 1: its qx qy qz qw must be a rotation"},
        {"1 0 0 0 0 0 0 1\n0 0 0 0 0 0 0 1\n", "line 2: its time must not be before"},
        {"0 0 1e300 0 0 0 0 1\n", "line 1: its tx ty tz must be metres"},
        {"# none\n", "has no poses"},
        {"100 0 0 0 0 0 0 1\n", "none of its 1 poses is at the time of a frame"}};
    for (const auto& [text, why] : files) {
        write_bytes(folder / "groundtruth.txt", text);
        EXPECT_TRUE(note().starts_with("poses of the camera are not read: groundtruth.txt")) << note();
        EXPECT_TRUE(has_words(note(), why));
        EXPECT_FALSE(opened(folder.path())->scene().path);
    }
    std::filesystem::remove(folder / "groundtruth.txt");
    for (const char* text :
         {"0 0 1\n1 0 0 0\n0 1 0 0\n0 0 1 0\n", "0 0 1\n2 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n",
          "-1 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "", "frames\n"}) {
        write_bytes(folder / "trajectory.log", text);
        EXPECT_TRUE(note().starts_with("poses of the camera are not read: trajectory.log")) << text << note();
    }
    std::filesystem::remove(folder / "trajectory.log");
    write_bytes(folder / "metadata.json", R"({"poses": [[0, 0, 0, 1, 0, 0]]})");
    EXPECT_TRUE(note().starts_with("poses of the camera are not read: metadata.json: poses[0] must be"))
        << note();
    write_bytes(folder / "metadata.json", R"({"fps": 30})");
    EXPECT_EQ(note(), "");
}

// Renderings as clips: a file, or a numbered folder of files, with depth, colour and material indices in them
// (tests/picture/blender/render_seeds.py made the files).

class Rendering : public ::testing::Test {
protected:
    /// `count` files r_0001.exr and on, all alike.
    void render(int count, const std::string& seed = "layers_half.exr") const {
        const std::string bytes =
            read_bytes(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds/exr_layers" / seed);
        for (int n = 1; n <= count; ++n) write_bytes(folder / ("r_000" + std::to_string(n) + ".exr"), bytes);
    }
    /// Metres, of these files, with what stands in `haptic` and the planes that `planes` names.
    std::string scene_of(const std::string& haptic, const std::string& planes,
                         const std::string& pattern = "r_%04d.exr") const {
        return R"({"touchable_scene": 1, "width": 16, "height": 12, "metres_per_unit": 1,
                   "camera": {"fx": 20, "fy": 20, "cx": 7.5, "cy": 5.5},
                   "depth": {"coding": "metric", "scale": 1, "near": 5, "far": 20}, "haptic": )" +
               haptic + R"(, "folder": {"first": 1, "depth": ")" + pattern + '"' + planes + "}}";
    }
    Result<std::unique_ptr<ClipReader>> open_described(const std::string& scene) const {
        write_bytes(folder / "scene.json", scene);
        return open_clip(folder.path());
    }
    /// Left, right and the box: docs beside the script.
    static void expect_seen(const RawFrame& frame, const Scene& scene) {
        const auto depth = [&](int x, int y) { return scene.depth.depth(frame.depth.sample(x, y)); };
        EXPECT_NEAR(depth(4, 9), 10, 1e-3);
        EXPECT_NEAR(depth(12, 4), 10, 1e-3);
        EXPECT_NEAR(depth(4, 3), 8, 1e-3);
        EXPECT_FALSE(scene.depth.is_valid(frame.depth.sample(0, 0)));
        ASSERT_FALSE(frame.colour.empty());
        const auto is = [&](int x, int y, std::array<int, 3> rgb) {
            const std::uint8_t* at = frame.colour.row(y) + 3 * x;
            return at[0] == rgb[0] && at[1] == rgb[1] && at[2] == rgb[2];
        };
        EXPECT_TRUE(is(4, 9, {188, 137, 99}));
        EXPECT_TRUE(is(12, 4, {0, 0, 255}));
        EXPECT_TRUE(is(4, 3, {255, 71, 0}));
    }
    TemporaryFolder folder;
};

TEST_F(Rendering, OpensDepthAndColour) {
    for (const char* seed : {"layers_half.exr", "layers_float.exr", "two_layers.exr", "z_half.exr"}) {
        SCOPED_TRACE(seed);
        render(1, seed);
        const auto [reader, frames] = must_read(open_clip(folder / "r_0001.exr"));
        ASSERT_EQ(frames.size(), 1U);
        expect_seen(frames.at(0), reader->scene());
        EXPECT_TRUE(is_noted(*reader, "linear light shown as sRGB"));
        EXPECT_TRUE(is_noted(*reader, "values are metres"));
        EXPECT_FALSE(reader->unstated_filters().median || reader->unstated_filters().temporal)
            << "a rendering has no noise";
        EXPECT_TRUE(reader->unstated_filters().terraces);
        EXPECT_EQ(is_noted(*reader, "nothing says what they feel like"), std::string(seed) != "z_half.exr");
    }
    auto reader = open_clip(folder / "r_0001.exr");
    EXPECT_TRUE(is_noted(**reader, "depth is channel Z, colour is R, G, B beside it"));
    render(1, "two_layers.exr");
    reader = open_clip(folder / "r_0001.exr");
    EXPECT_TRUE(is_noted(**reader, "depth is channel b.Depth.Z, colour is b.Combined beside it"));
    EXPECT_TRUE(is_noted(**reader, "the files have material indices (b.IndexMA.X: 0, 2, 5)"));
}

TEST_F(Rendering, ReadsEachFileOnce) {
    render(9);
    for (const bool is_described : {false, true}) {
        if (is_described) write_bytes(folder / "scene.json", scene_of("{}", R"(, "colour": "r_%04d.exr")"));
        OpenedFiles opened(folder.path());
        const auto [reader, frames] = must_read(open_clip(folder.path()));
        ASSERT_EQ(frames.size(), 9U);
        for (const RawFrame& frame : frames) expect_seen(frame, reader->scene());
        // The first is read once more, for its colour: the range of depth is searched in between.
        for (const auto& [name, count] : opened.counts())
            EXPECT_LE(count, name.find("0001") != std::string::npos ? 2 : 1) << name;
        EXPECT_EQ(reader->inputs().size(), is_described ? 10U : 9U);
    }
}

TEST_F(Rendering, MapsMaterialsToProperties) {
    render(2);
    const std::string planes = R"(, "colour": "r_%04d.exr", "haptic": "r_%04d.exr")";
    auto reader =
        must(open_described(scene_of(R"({"materials": {"2": {"stiffness": 2, "static_friction": 0.9},
                                                           "5": {"stiffness": 0.3, "dynamic_friction": 0.1}}})",
                                     planes)));
    EXPECT_TRUE(is_noted(*reader, "haptic is that of 2 materials"));
    const Scene& scene = reader->scene();
    const auto frames = must(read_all(*reader));
    for (const RawFrame& frame : frames) {
        expect_seen(frame, scene);
        ASSERT_FALSE(frame.haptic.empty());
        const auto at = [&](int x, int y) {
            const std::uint8_t* rgb = frame.haptic.row(y) + 3 * x;
            return scene.haptic.at(rgb[0], rgb[1], rgb[2]);
        };
        const auto expect = [&](int x, int y, const HapticProperties& wanted) {
            EXPECT_NEAR(at(x, y).stiffness, wanted.stiffness, 1e-9 + 0.5 * 1700 / 255);
            EXPECT_NEAR(at(x, y).static_friction, wanted.static_friction, 1e-9 + 0.5 * 0.5 / 255);
            EXPECT_NEAR(at(x, y).dynamic_friction, wanted.dynamic_friction, 1e-9 + 0.5 * 0.2 / 255);
        };
        expect(4, 9, {600, 0.4, 0.3});  // the default ones: 0 is not in the table
        expect(12, 4, {2000, 0.9, 0.3});
        expect(4, 3, {300, 0.4, 0.1});
        EXPECT_EQ(at(12, 4).stiffness, 2000);  // ends of a range are exact
        EXPECT_EQ(at(4, 3).stiffness, 300);
    }
    // The file itself, as the same scene describes it.
    reader = must(open_clip(folder / "r_0002.exr", folder / "scene.json"));
    const auto one = must(read_all(*reader));
    expect_seen(one.at(0), reader->scene());
    EXPECT_TRUE(same_plane(one.at(0).haptic, frames.at(0).haptic));
}

TEST_F(Rendering, ReadsPlanesFromSeparateFiles) {
    render(1);
    write_bytes(folder / "c.exr", read_bytes(folder / "r_0001.exr"));
    write_bytes(folder / "m.exr", read_bytes(folder / "r_0001.exr"));
    const auto [reader, frames] = must_read(open_described(
        scene_of(R"({"materials": {"5": {"stiffness": 2}}})", R"(, "colour": "c.exr", "haptic": "m.exr")")));
    expect_seen(frames.at(0), reader->scene());
    EXPECT_EQ(frames.at(0).haptic.row(3)[3 * 4], 255);
    EXPECT_EQ(frames.at(0).haptic.row(4)[3 * 12], 0);
}

TEST_F(Rendering, NamesMissingParts) {
    render(1);
    const std::string file = (folder / "r_0001.exr").string();
    EXPECT_EQ(message(open_described(scene_of("{}", R"(, "haptic": "r_%04d.exr")"))),
              file +
                  " (haptic, frame 0): is of material indices: the scene file's haptic.materials must say "
                  "what they feel like");
    render(1, "z_half.exr");
    EXPECT_EQ(message(open_described(scene_of(R"({"materials": {"5": {}}})", R"(, "haptic": "r_%04d.exr")"))),
              file +
                  ": has no material indices: must have a layer IndexMA of each pixel, but has A, B, G, R, Z "
                  "(haptic, frame 0)");
    EXPECT_TRUE(is_refused(open_described(scene_of(R"({"materials": {"5": {}}})", "")), "folder.haptic"));
}

/// The note is there for a scene without a table too, but not beside a still haptic map.
TEST_F(Rendering, NotesUnusedMaterials) {
    render(3);
    auto reader = must(open_described(scene_of("{}", "")));
    EXPECT_TRUE(is_noted(
        *reader, "haptic is not there: the files have material indices (ViewLayer.IndexMA.X: 0, 2, 5)"));
    const auto scene = reader->scene();
    for (const Remark& remark : scene.remarks) EXPECT_EQ(remark.what.find("indices"), std::string::npos);
    Image map{1, 1, 1, 3, {255, 128, 128}};
    ASSERT_EQ(message(write_png(folder / "map.png", map.view())), "");
    reader = must(open_described(scene_of("{}", R"(, "haptic": "map.png")")));
    EXPECT_FALSE(is_noted(*reader, "material indices"));
    // Whatever the file is called.
    for (const std::string name : {"DEPTH_%04d.EXR", "depth_%04d"}) {
        std::filesystem::copy_file(folder / "r_0001.exr",
                                   folder / std::string(name).replace(name.find('%'), 4, "0001"));
        reader = must(open_described(scene_of("{}", "", name)));
        EXPECT_TRUE(is_noted(*reader, "the files have material indices (ViewLayer.IndexMA.X: 0, 2, 5)"))
            << name;
    }
}

/// As Unreal's Movie Render Queue writes them: colour, and the pass WorldDepth, in halves.
void write_unreals(const std::filesystem::path& file, float centimetres) {
    Imf::Header header(16, 12);
    std::vector<half> depth(16 * 12, half(centimetres)), light(16 * 12, half(0.5F));
    depth[0] = half(65504.0F);  // the sky
    Imf::FrameBuffer frame;
    for (const std::string layer : {"", "FinalImageMovieRenderQueue_WorldDepth."})
        for (const char* own : {"R", "G", "B", "A"}) {
            header.channels().insert(layer + own, Imf::Channel(Imf::HALF));
            half* const from = layer.empty() || *own == 'A' ? light.data() : depth.data();
            frame.insert(layer + own, Imf::Slice(Imf::HALF, reinterpret_cast<char*>(from), sizeof(half),
                                                 16 * sizeof(half)));
        }
    Imf::OutputFile output(file.c_str(), header);
    output.setFrameBuffer(frame);
    output.writePixels(12);
}

TEST_F(Rendering, ReadsUnrealCentimetres) {
    write_unreals(folder / "Shot.0001.exr", 150);
    for (const char* name : {"shots", "pictures"}) std::filesystem::create_directories(folder / name);
    for (const char* name : {"Shot.0001.exr", "Shot.0002.exr"})
        std::filesystem::copy_file(folder / "Shot.0001.exr", folder / "shots" / name);
    for (const char* name : {"Shot.0001.exr", "shots"}) {
        SCOPED_TRACE(name);
        auto reader = must(open_clip(folder / name));
        EXPECT_TRUE(is_noted(*reader, "Unreal's WorldDepth: centimetres"));
        const auto frame = must(reader->next());
        ASSERT_TRUE(frame.has_value());
        const Scene& scene = reader->scene();
        EXPECT_NEAR(scene.depth.depth(frame->depth.sample(7, 5)) * scene.metres_per_unit, 1.5, 1e-3);
        EXPECT_FALSE(scene.depth.is_valid(frame->depth.sample(0, 0)));
        EXPECT_FALSE(frame->colour.empty());
    }
    // A channel or a layer by name, for which a scene file may say the rest.
    SourceDescription named;
    for (const char* channel : {"A", "finalimagemovierenderqueue_worlddepth", "G"}) {
        named.channel = channel;
        const auto reader = must(open_clip(folder / "Shot.0001.exr", {}, named));
        EXPECT_EQ(bool(is_noted(*reader, "centimetres")), named.channel.size() > 1) << channel;
    }
    named.channel = "Z";
    for (const char* name : {"Shot.0001.exr", "shots"})
        EXPECT_TRUE(is_refused(open_clip(folder / name, {}, named), "has no channel \"Z\", but A, B, "))
            << name;
    Samples memory(2 * 16 * 12, 3);
    ASSERT_EQ(message(write_png(folder / "pictures/depth_1.png", PlaneView{memory.data(), 32, 16, 12, 2, 1})),
              "");
    for (const char* name : {"pictures/depth_1.png", "pictures"})
        EXPECT_TRUE(is_refused(open_clip(folder / name, {}, named), "is no OpenEXR file")) << name;
    const auto metres =
        must(open_clip(folder / "Shot.0001.exr", {}, stated(&SourceDescription::metres_per_code, 1)));
    EXPECT_FALSE(is_noted(*metres, "centimetres"));
}

// The text of an MPEG-4 scene beside the pictures that it names.

constexpr int text_wide = 12, text_high = 8;

Image painted(int channels, int factor) {
    return made_image(text_wide, text_high, 1, channels,
                      [&](int x, int y, int c) { return factor * (channels * (text_wide * y + x) + c); });
}

std::string scene_with(const std::string& depth, const std::string& haptic = "haptic.png") {
    return R"(# as the paper's Fig. 13
Shape {
  appearance Appearance {
    texture ImageTexture { url "colour.png" }
    hapticSurface HapticTextureSurface {
      stiffnessRange 0.1 10 staticFrictionRange 0.2 0.9 dynamicFrictionRange 0.2 0.9 maxHeight 1.0
      hapticTexture ImageTexture { url ")" +
           haptic + R"(" } heightTexture ImageTexture { url "height.png" } } }
  geometry Depth { focalLength 6.983 pixelWidth 0.5 nearPlane 10 farPlane 200 texture )" +
           depth + R"( }
})";
}

class SceneTextClips : public ::testing::Test {
protected:
    void SetUp() override {
        ASSERT_TRUE(write_png(folder / "depth.png", painted(1, 2).view()));
        ASSERT_TRUE(write_png(folder / "colour.png", painted(3, 3).view()));
        ASSERT_TRUE(write_png(folder / "haptic.png", painted(3, 5).view()));
        ASSERT_TRUE(write_png(folder / "height.png", painted(1, 7).view()));
    }
    Result<std::unique_ptr<ClipReader>> open(const std::string& text) {
        write_bytes(folder / "scene.bt", text);
        return open_clip(folder / "scene.bt");
    }
    TemporaryFolder folder;
};

TEST_F(SceneTextClips, OpenFourPictures) {
    const std::string text = scene_with(R"(ImageTexture { url "depth.png" })");
    EXPECT_EQ(message(open("\xef\xbb\xbf" + text)), "") << "with a byte order mark";
    const auto clip = must(open(text));
    const Scene& scene = clip->scene();
    EXPECT_EQ(scene.camera, camera_from_focal_length(6.983, 0.5, text_wide, text_high));
    EXPECT_EQ(scene.depth.near, 10);
    EXPECT_EQ(scene.depth.far, 200);
    EXPECT_TRUE(scene.depth.near_is_high);
    EXPECT_EQ(scene.haptic.static_friction.min, 0.2);
    EXPECT_EQ(scene.height_coding.max_height, 1);
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 1);
    const RawFrame& frame = frames.front();
    EXPECT_EQ(frame.depth.sample(3, 1), painted(1, 2).view().sample(3, 1));
    EXPECT_EQ(frame.height.sample(5, 2), painted(1, 7).view().sample(5, 2));
    EXPECT_EQ(frame.haptic.row(2)[7], painted(3, 5).view().row(2)[7]);
    EXPECT_EQ(frame.colour.row(2)[7], painted(3, 3).view().row(2)[7]);
    EXPECT_EQ(clip->inputs().back(), folder / "scene.bt");
}

/// The paper's example has its haptic picture in JPEG.
TEST_F(SceneTextClips, ReadHapticJpegWithNote) {
    std::filesystem::copy_file(
        std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds/jpeg_depth/gdepth.jpg",
        folder / "haptic.jpg");
    const auto clip = must(open(scene_with(R"(ImageTexture { url "depth.png" })", "haptic.jpg")));
    EXPECT_TRUE(is_noted(*clip, "haptic is stored as mjpeg"));
    EXPECT_EQ(message(read_all(*clip)), "");
}

/// The pictures that a text names are pictures like any other to a scene file.
TEST_F(SceneTextClips, TakeDisparitiesFromSceneFile) {
    write_bytes(folder / "scene.bt", scene_with(R"(ImageTexture { url "depth.png" })"));
    write_bytes(folder / "other.json", R"({"touchable_scene": 1, "width": 12, "height": 8,
        "camera": {"fx": 9, "fy": 9, "cx": 5.5, "cy": 3.5},
        "depth": {"coding": "disparity", "baseline": 100, "invalid": [0]}})");
    const auto [clip, frames] = must_read(open_clip(folder / "scene.bt", folder / "other.json"));
    const DepthCoding& depth = clip->scene().depth;
    const int stored = painted(1, 2).view().sample(3, 1);
    EXPECT_NEAR(depth.depth(stored_code(frames.front().depth, depth, 3, 1)), 9.0 * 100 / stored, 1e-9);
    ASSERT_FALSE(frames.front().haptic.empty()) << "its other pictures stay";
    // For a video, the message speaks of videos.
    ASSERT_EQ(message(write_clip(folder / "video.mkv", small_scene(text_wide, text_high), 1, {})), "");
    write_bytes(folder / "scene.bt",
                R"(Shape { geometry Depth { texture MovieTexture { url "video.mkv" } } })");
    EXPECT_TRUE(is_refused(open_clip(folder / "scene.bt", folder / "other.json"),
                           "video.mkv: depth.coding disparity"));
}

/// A clip whose nodes cannot say all: cut short, of 12 bits, with holes.
class WrittenSceneText : public ::testing::Test {
protected:
    void SetUp() override {
        scene.depth.semantics = DepthSemantics::planar;
        scene.depth.invalid_codes[0] = 0;
        scene.depth.invalid_code_count = 1;
        derive_valid_range(scene.depth);
        scene.remarks = {{"guessed: the camera"}};
    }
    std::string write(Existing existing = Existing::keep) const {
        auto writer = create_scene_text(file, scene, existing);
        if (!writer) return writer.error().message;
        if (auto written = (*writer)->write(test_frame(scene, 0, all_planes)); !written)
            return written.error().message;
        return message((*writer)->finish());
    }
    void change(const std::string& was, const std::string& is) const {
        std::string text = read_bytes(file);
        ASSERT_TRUE(has_words(text, was)) << was;
        write_bytes(file, text.replace(text.find(was), was.size(), is));
    }
    TemporaryFolder folder;
    std::filesystem::path file = folder / "my scene.bt";
    Scene scene = small_scene(23, 14, 12);
};

TEST_F(WrittenSceneText, KeepsWhatNodesCannotHold) {
    ASSERT_EQ(write(), "");
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    EXPECT_EQ(names, (std::vector<std::string>{"my scene.bt", "my scene_colour.png", "my scene_depth.png",
                                               "my scene_haptic.png", "my scene_height.png"}));
    const auto clip = must(open_clip(file));
    EXPECT_FALSE(is_noted(*clip, "its nodes say another"));
    EXPECT_TRUE(is_noted(*clip, "guessed: the camera"));
    Scene read = clip->scene();
    ASSERT_TRUE(read.folder);
    read.folder.reset();
    EXPECT_EQ(scene_to_json(read), scene_to_json(scene));
    const auto frames = must(read_all(*clip));
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_TRUE(same_frame(frames.front(), test_frame(scene, 0, all_planes)));
}

TEST_F(WrittenSceneText, ReplacesNothingUnasked) {
    write_bytes(folder / "my scene_height.png", "another's");
    EXPECT_TRUE(has_words(write(), "my scene_height.png"));
    EXPECT_EQ(read_bytes(folder / "my scene_height.png"), "another's");
    EXPECT_FALSE(std::filesystem::exists(file) || std::filesystem::exists(folder / "my scene_depth.png"));
    EXPECT_EQ(write(Existing::replace), "");
    EXPECT_EQ(message(open_clip(file)), "");
    for (const char* name : {"a%d.bt", "a*.bt", "od:7.bt"}) {
        file = folder / name;
        EXPECT_NE(write(), "") << name;
        EXPECT_FALSE(std::filesystem::exists(file));
    }
}

TEST_F(WrittenSceneText, PrefersEditedNodesWithNote) {
    ASSERT_EQ(write(), "");
    change("farPlane 200", "farPlane 300");  // of its prototype's values none is 200
    change("maxHeight 0", "maxHeight 2");
    const auto clip = must(open_clip(file));
    EXPECT_TRUE(
        is_noted(*clip, "its nodes say another camera, other planes or ranges than its WorldInfo T3D_SCENE"));
    EXPECT_EQ(clip->scene().depth.far, 300);
    EXPECT_EQ(clip->scene().height_coding.max_height, 2);
    EXPECT_EQ(clip->scene().depth.semantics, DepthSemantics::planar);
    change("farPlane 300", "farPlane 5");
    EXPECT_TRUE(is_refused(open_clip(file), "my scene.bt: depth.near"));
}

TEST_F(WrittenSceneText, ReadsOnlyNamedPictures) {
    ASSERT_EQ(write(), "");
    const std::string whole = read_bytes(file);
    change(R"("  \"interpolation)",
           R"("  \"video\": {\"depth\": \"../elsewhere.mkv\"}," "  \"interpolation)");
    const auto clip = must(open_clip(file));
    EXPECT_FALSE(clip->scene().video);
    EXPECT_EQ(clip->scene().folder->depth, "my scene_depth.png");
    write_bytes(file, whole);
    change(R"(\"touchable_scene\": 1,)", R"(\"touchable_scene\": 99,)");
    EXPECT_TRUE(is_refused(open_clip(file), "my scene.bt: its WorldInfo T3D_SCENE: touchable_scene"));
}

TEST_F(WrittenSceneText, NamesMissingOrForeignPictures) {
    ASSERT_EQ(write(), "");
    const auto picture = [&](const char* role) {
        return folder / ("my scene_" + std::string(role) + ".png");
    };
    for (const char* role : {"depth", "haptic", "height", "colour"}) {
        std::filesystem::rename(picture(role), folder / "aside");
        EXPECT_TRUE(is_refused(open_clip(file), "my scene_" + std::string(role) + ".png")) << role;
        std::filesystem::rename(folder / "aside", picture(role));
    }
    const Image other{7, 5, 1, 3, Samples(105, 9)};
    ASSERT_TRUE(write_png(picture("haptic"), other.view()));
    EXPECT_TRUE(is_noted(**open_clip(file), "haptic is 7x5: resampled"));
    const Image small{7, 5, 2, 1, Samples(70, 1)};
    ASSERT_TRUE(write_png(picture("depth"), small.view()));
    EXPECT_TRUE(is_refused(open_clip(file), "is 7x5, but the scene is 23x14"));
}

TEST_F(SceneTextClips, StayInTheirFolder) {
    for (const std::string url :
         {"/etc/depth.png", "../depth.png", "a/../../depth.png", "http://example.org/depth.png", ""})
        EXPECT_TRUE(is_refused(open(scene_with("ImageTexture { url \"" + url + "\" }")),
                               "must be a file beside this text"))
            << url;
    EXPECT_TRUE(is_refused(open(scene_with("MovieTexture { url [11] }")), "is object 11 of an MP4 file"));
}

TEST_F(SceneTextClips, NameLineAndColumn) {
    EXPECT_EQ(message(open("Shape {\n  appearance Nothing {} }")),
              (folder / "scene.bt").string() +
                  ": line 2, column 14: \"Nothing\" is no node that a touchable clip has");
    EXPECT_TRUE(is_refused(open(scene_with(R"(ImageTexture { url "none.png" })")), "none.png"));
    EXPECT_TRUE(
        is_refused(open(scene_with(R"(MovieTexture { url "depth.png" })")), "depth and colour must both be"));
}

}  // namespace
}  // namespace touchable::test
