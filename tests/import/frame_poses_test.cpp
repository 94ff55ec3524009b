// Poses of the camera beside frames, by the layouts of those who write them, against a wall that stands
// still.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

using Numbers3 = std::array<double, 3>;

constexpr int wall_frames = 4, wall_width = 32, wall_height = 24;
constexpr double wall_focal = 30, wall_cx = 15, wall_cy = 12.5;
/// Points of the wall: their product with this is 2 m.
constexpr Numbers3 wall_normal{0.2, -0.3, 1};
constexpr double wall_distance = 2;

/// Of a frame: turned about x by b, then about y by a, and moved.
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
        std::filesystem::create_directories(folder / "depth");
        write_bytes(folder / "intrinsics.json", R"({"fx": 30, "fy": 30, "cx": 15, "cy": 12.5})");
        for (int frame = 0; frame < wall_frames; ++frame) {
            const auto r = matrix_of(stand_of(frame));
            Image image{wall_width, wall_height, 2, 1, {}};
            for (int row = 0; row < wall_height; ++row)
                for (int column = 0; column < wall_width; ++column) {
                    const Numbers3 ray{(column - wall_cx) / wall_focal, (row - wall_cy) / wall_focal, 1};
                    const double metres =
                        (wall_distance - on_wall(stand_of(frame).place)) / on_wall(moved(r, {}, ray));
                    const auto code = static_cast<int>(std::lround(1000 * metres));
                    image.samples.push_back(static_cast<std::uint8_t>(code & 255));
                    image.samples.push_back(static_cast<std::uint8_t>(code >> 8));
                }
            ASSERT_EQ(message(write_png(folder / picture(frame), image.view())), "");
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
        auto reader = open_clip(clip);
        EXPECT_EQ(message(reader), "");
        return reader ? std::move(*reader) : nullptr;
    }
    /// Of all pixels with depth, unprojected and moved to the world: how far from the wall at most, metres.
    static double farthest_from_wall(ClipReader& reader) {
        const Scene& scene = reader.scene();
        const auto frames = read_all(reader);
        EXPECT_EQ(message(frames), "");
        EXPECT_TRUE(scene.path);
        if (!frames || !scene.path) return 1e9;
        double farthest = 0;
        for (std::size_t n = 0; n < frames->size(); ++n) {
            if (n >= scene.path->poses.size() || !scene.path->poses[n]) continue;
            const CameraPose& pose = *scene.path->poses[n];
            for (int row = 0; row < wall_height; ++row)
                for (int column = 0; column < wall_width; ++column) {
                    const double z =
                        scene.depth.depth((*frames)[n].depth.sample(column, row)) * scene.metres_per_unit;
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
    /// Of the clip in the folder: the poses that it has, which lead to the wall.
    void expect_wall(std::size_t known) {
        const auto reader = opened(folder.path());
        ASSERT_TRUE(reader);
        EXPECT_LT(farthest_from_wall(*reader), a_code);
        ASSERT_TRUE(reader->scene().path);
        EXPECT_EQ(reader->scene().path->known(), known);
    }
    std::string note() const {
        const auto reader = opened(folder.path());
        for (const std::string& each : reader ? reader->notes() : std::vector<std::string>())
            if (each.find("camera stood") != std::string::npos || each.find("poses") != std::string::npos)
                return each;
        return "";
    }
    /// Half of one, and six digits of a pose.
    static constexpr double a_code = 0.001;
    TemporaryFolder folder;
};

TEST_F(FramePoses, OfTumAreThoseNearestInTime) {
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

TEST_F(FramePoses, OfTumLeadToTheWall) {
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

TEST_F(FramePoses, OfRedwoodLeadToTheWall) {
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

/// Whose cameras look along -z with y up: another half turn about x comes first.
TEST_F(FramePoses, OfRecord3dLeadToTheWall) {
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

TEST_F(FramePoses, AreKeptByEveryKindOfClip) {
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
        auto writer = to.extension() == ".mkv" ? create_clip(to, reader->described(), exact_clip)
                      : to.extension() == ".mp4"
                          ? create_mp4_clip(to, reader->described(), {})
                          : create_image_folder(to, reader->described(), Existing::keep);
        ASSERT_EQ(message(writer), "");
        const auto frames = read_all(*reader);
        ASSERT_EQ(message(frames), "");
        for (const RawFrame& frame : *frames) ASSERT_EQ(message((*writer)->write(frame)), "");
        ASSERT_EQ(message((*writer)->finish()), "");
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
    auto part = part_of_clip(opened(output / "clip.mkv"), {.first = 1, .last = 3, .every = 2});
    ASSERT_EQ(message(part), "");
    ASSERT_TRUE((*part)->scene().path);
    EXPECT_EQ((*part)->scene().path->poses.size(), 2U);
    EXPECT_LT(farthest_from_wall(**part), a_code);
}

TEST_F(FramePoses, ThatCannotBeReadAreSaidAndLeftOut) {
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
        EXPECT_NE(note().find(why), std::string::npos) << note();
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

}  // namespace
}  // namespace touchable::test
