// Cameras, scales and rates under the names that programs give them, in files that lie beside pictures, above
// them, and within their own.
#include <gtest/gtest.h>

#include <algorithm>

#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/sidecar_text.hpp"
#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/npy_bytes.hpp"

namespace touchable::test {
namespace {

constexpr int across = 64, down = 48;

/// Two frames of codes from 8000 to 8255 in `folder`/depth.
void write_depth(const std::filesystem::path& folder, const char* first = "depth/0001.png",
                 const char* second = "depth/0002.png") {
    Image image{across, down, 2, 1, {}};
    for (int k = 0; k < across * down; ++k) {
        const int code = 8000 + k % 251;
        image.samples.push_back(static_cast<std::uint8_t>(code & 255));
        image.samples.push_back(static_cast<std::uint8_t>(code >> 8));
    }
    for (const char* name : {first, second}) {
        std::filesystem::create_directories((folder / name).parent_path());
        ASSERT_EQ(message(write_png(folder / name, image.view())), "");
    }
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::filesystem::create_directories(file.parent_path());
    write_bytes(file, text);
}

Scene guessed(const std::filesystem::path& folder) {
    auto scene = guess_folder(folder, {});
    EXPECT_EQ(message(scene), "");
    return scene ? scene->scene : Scene{};
}

bool says(const Scene& scene, const std::string& words) {
    return std::ranges::any_of(
        scene.remarks, [&](const Remark& remark) { return remark.what.find(words) != std::string::npos; });
}

Camera camera_by(const std::string& name, const std::string& text) {
    const TemporaryFolder folder;
    write_depth(folder.path());
    write_text(folder / name, text);
    return guessed(folder.path()).camera;
}

TEST(CameraSpellings, LeadToTheSameCamera) {
    const std::pair<const char*, const char*> files[] = {
        {"a.yaml", "%YAML:1.0\n---\nf_u: 50.0\nf_v: 52.0\npp_x: 33.5\npp_y: 21.25\n"},
        {"b.json", R"({"focal_length": [50, 52], "principal_point": [33.5, 21.25]})"},
        {"c.json", R"({"intrinsics": [[50, 0, 33.5], [0, 52, 21.25], [0, 0, 1]]})"},
        {"d.json", R"({"camera_intrinsics": [50, 0, 33.5, 0, 52, 21.25, 0, 0, 1]})"},
        {"e.txt", "fx_depth = 50\nfy_depth = 52\nmx_depth = 33.5\nmy_depth = 21.25\n"},
        {"f.conf", "[LEFT]\nfx=50\nfy=52\ncx=33.5\ncy=21.25\n"},
        {"g.txt", "frame cameraID K[0,0] K[1,1] K[0,2] K[1,2]\n0 0 50 52 33.5 21.25\n1 0 50 52 33.5 21.25\n"},
        {"h.csv", "frame,fx,fy,cx,cy\n0,50,52,33.5,21.25\n"},
        {"i.csv", "50.0, 0.0, 33.5\n0.0, 52.0, 21.25\n0.0, 0.0, 1.0\n"},
        {"j.txt", "P0: 50 0 33.5 0 0 52 21.25 0 0 0 1 0\n"},
        {"k.json", R"({"0": {"cam_K": [50, 0, 33.5, 0, 52, 21.25, 0, 0, 1]},
                       "1": {"cam_K": [50, 0, 33.5, 0, 52, 21.25, 0, 0, 1]}})"},
        {"calib.txt", "50 52 33.5 21.25\n"},
        {"K.txt", "50 0 33.5\n0 52 21.25\n0 0 1\n"}};
    for (const auto& [name, text] : files) {
        const Camera camera = camera_by(name, text);
        EXPECT_EQ(camera.fx, 50) << name;
        EXPECT_EQ(camera.fy, 52) << name;
        EXPECT_EQ(camera.cx, 33.5) << name;
        EXPECT_EQ(camera.cy, 21.25) << name;
    }
}

TEST(CameraSpellings, FieldOfViewGivesFocalLength) {
    const double focal = camera_of_fov(50, across, down).fx;
    const std::pair<const char*, const char*> files[] = {
        {"fov.json", R"({"fov_x": 50.0, "fov_y": 38.55})"},
        {"a.json", R"({"fov": 50})"},
        {"b.json", R"({"camera_angle_x": 0.8726646259971648})"},
        {"c.json", R"({"sensor_width": 36, "lens": 38.601124})"},
        {"d.json", R"({"cameraFocalLength": 24, "cameraAperture": [22.382765, 16]})"}};
    for (const auto& [name, text] : files) {
        const Camera camera = camera_by(name, text);
        EXPECT_NEAR(camera.fx, focal, 0.001 * focal) << name;
        EXPECT_NEAR(camera.fy, focal, 0.001 * focal) << name;
        EXPECT_EQ(camera.cx, 0.5 * (across - 1)) << name;
    }
    EXPECT_NE(camera_by("a.json", R"({"fov": 0.0001})").fx, focal);
    const Camera tall = scaled_camera({.fov_y = 50}, across, down);
    EXPECT_NEAR(tall.fy, camera_of_fov(50, down, across).fx, 1e-9);
    EXPECT_EQ(tall.fx, tall.fy);
}

TEST(CameraSpellings, ScaleOfDepthIsRead) {
    const std::string camera = R"("fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25)";
    const std::string matrix = R"("cam_K": [50, 0, 33.5, 0, 52, 21.25, 0, 0, 1])";
    const std::tuple<const char*, std::string, double> files[] = {
        {"scene_camera.json",
         R"({"0": {)" + matrix + R"(, "depth_scale": 0.1}, "1": {)" + matrix + R"(, "depth_scale": 0.1}})",
         0.0001},
        {"a.json", R"({"7": {)" + matrix + R"(, "depth_scale": 1.0}})", 0.001},
        {"transforms.json", "{" + camera + R"(, "integer_depth_scale": 0.0002, "frames": []})", 0.0002},
        {"b.json", "{" + camera + R"(, "depth_unit_scale_factor": 0.00025})", 0.00025},
        {"c.json", R"({"camera": {)" + camera + R"(, "scale": 6553.5}})", 1 / 6553.5},
        {"d.txt", "m_depthShift = 4000\n", 0.00025},
        {"e.yaml", "cam:\n  png_depth_scale: 5000\n", 0.0002}};
    for (const auto& [name, text, metres] : files) {
        const TemporaryFolder folder;
        write_depth(folder.path());
        write_text(folder / name, text);
        const Scene scene = guessed(folder.path());
        EXPECT_NEAR(scene.depth.scale, metres, 1e-9 * metres) << name;
        EXPECT_TRUE(says(scene, std::string(name) + " says")) << name;
    }
}

TEST(CameraSpellings, OneFolderUpOrBesideIsFound) {
    const std::string camera = R"({"fx": 100, "fy": 104, "cx": 67.5, "cy": 43, "width": 128, "height": 96})";
    for (const char* where : {"cameras/0001.json", "poses/frame_0001.json", "intrinsic/a.json"}) {
        const TemporaryFolder folder;
        write_depth(folder.path());
        write_text(folder / where, camera);
        write_text((folder / where).parent_path() / "frame_2.json", camera);
        for (const auto& opened : {folder.path(), folder / "depth"}) {
            EXPECT_EQ(guessed(opened).camera.fx, 50) << where << ' ' << opened;
            EXPECT_EQ(guessed(opened).camera.cx, 33.5) << where;
        }
    }
    const TemporaryFolder folder;
    write_depth(folder / "run/frames/depth/Camera_0", "0001.png", "0002.png");
    write_text(folder / "run/intrinsic.txt", "frame K[0,0] K[1,1] K[0,2] K[1,2]\n0 50 52 33.5 21.25\n");
    EXPECT_EQ(guessed(folder / "run/frames/depth/Camera_0").camera.fx, 50);
    EXPECT_EQ(guessed(folder / "run/frames/depth").camera.fx, 50);
}

TEST(CameraSpellings, CamerasThatDifferAreThoseOfFrames) {
    const TemporaryFolder folder;
    write_depth(folder.path());
    write_text(folder / "cameras/0001.json", R"({"fx": 50, "fy": 50, "cx": 31.5, "cy": 23.5})");
    write_text(folder / "cameras/0002.json", R"({"fx": 54, "fy": 54, "cx": 31.5, "cy": 23.5})");
    const auto clip = open_clip(folder.path());
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(says((*clip)->scene(), "the camera is that of cameras/*.json"));
    EXPECT_TRUE(says((*clip)->scene(), "median of those of 2 frames"));
}

TEST(CameraSpellings, MatrixOfLargerPicturesIsScaled) {
    const Camera camera =
        camera_by("camera_matrix.csv", "500.5, 0.0, 317\n0.0, 500.5, 239.75\n0.0, 0.0, 1.0\n");
    EXPECT_NEAR(camera.fx, 50.05, 1e-9);
    EXPECT_NEAR(camera.cx, (317 - 319.5) / 10 + 31.5, 1e-9);
}

TEST(CameraSpellings, NamedFileIsScaledOrRefused) {
    const TemporaryFolder folder;
    write_depth(folder.path());
    write_text(folder / "else/m.csv", "500.5, 0.0, 317\n0.0, 500.5, 239.75\n0.0, 0.0, 1.0\n");
    write_text(folder / "else/n.csv", "500.5, 0.0, 317\n0.0, 500.5, 20\n0.0, 0.0, 1.0\n");
    SourceDescription known;
    const auto guess_by = [&](const char* name) {
        known.file = folder / "else" / name;
        auto read = read_intrinsics(known.file);
        EXPECT_EQ(message(read), "");
        if (read) known.intrinsics = *read;
        return guess_folder(folder.path(), known);
    };
    const auto scaled = guess_by("m.csv");
    ASSERT_EQ(message(scaled), "");
    EXPECT_NEAR(scaled->scene.camera.fx, 50.05, 1e-9);
    EXPECT_TRUE(says(scaled->scene, "times as large"));
    EXPECT_TRUE(is_refused(guess_by("n.csv"), "is of other pictures"));
    write_text(folder / "else/fov.json", R"({"fov_x": 50})");
    const auto seen = guess_by("fov.json");
    ASSERT_EQ(message(seen), "");
    EXPECT_NEAR(seen->scene.camera.fx, camera_of_fov(50, across, down).fx, 1e-9);
}

TEST(CameraSpellings, OdometryGivesTheRate) {
    const TemporaryFolder folder;
    write_depth(folder.path());
    write_text(
        folder / "odometry.csv",
        "timestamp, frame, x, y, z, qx, qy, qz, qw\n7300.500000, 000000, 0.0, 0, 0, 0, 0, 0, 1\n"
        "7300.516667, 000001, 0.001, 0, 0, 0, 0, 0, 1\n7300.533333, 000002, 0.001, 0, 0, 0, 0, 0, 1\n");
    write_text(folder / "imu.csv", "timestamp, a_x, a_y\n7300.5, 0, 9.8\n7300.51, 0, 9.8\n");
    const Scene scene = guessed(folder.path());
    EXPECT_NEAR(scene.rate.per_second(), 60, 0.01);
    EXPECT_TRUE(says(scene, "as odometry.csv says"));
    EXPECT_TRUE(says(scene, "not used: imu.csv"));
}

TEST(CameraSpellings, FilesThatAreNotUsedAreNamed) {
    const TemporaryFolder folder;
    write_depth(folder.path());
    write_text(folder / "mesh_info.json", R"({"alignment": [1, 0, 0, 0]})");
    write_text(folder / "words.txt", "no numbers\n");
    write_text(folder / "._notes.json", "{\"fx\": 3}");
    write_text(folder / "calib_lens.json", R"({"radius": 3})");
    const Scene scene = guessed(folder.path());
    EXPECT_TRUE(says(scene, "beside the pictures, and not used: mesh_info.json"));
    EXPECT_TRUE(says(scene, "not understood as a camera's file: calib_lens.json"));
    EXPECT_FALSE(says(scene, "words.txt"));
    EXPECT_FALSE(says(scene, "._notes"));
}

TEST(CameraSpellings, ArraysBesideDepthAreItsCamera) {
    const TemporaryFolder folder;
    const std::vector<float> depth(2 * across * down, 1.5F);
    const std::vector<float> one{50, 0, 33.5, 0, 52, 21.25, 0, 0, 1};
    std::vector<float> two = one;
    two.insert(two.end(), one.begin(), one.end());
    const std::string depth_bytes = npy_bytes("2, 48, 64", depth);
    for (const auto& [name, bytes] :
         {std::pair<const char*, std::string>{"intrinsics", npy_bytes("2, 3, 3", two)},
          {"K", npy_bytes("3, 3", one)},
          {"intrinsic", npy_bytes("4,", {50, 52, 33.5, 21.25})}}) {
        write_npz(folder / "a.npz",
                  {{"depth", depth_bytes}, {name, bytes}, {"extrinsics", npy_bytes("3,", {1, 2, 3})}});
        const auto clip = open_clip(folder / "a.npz");
        ASSERT_EQ(message(clip), "");
        const Scene& scene = (*clip)->scene();
        EXPECT_EQ(scene.camera.fx, 50) << name;
        EXPECT_EQ(scene.camera.fy, 52) << name;
        EXPECT_EQ(scene.camera.cx, 33.5) << name;
        EXPECT_TRUE(says(scene, std::string("that of a.npz (") + name + ")"));
        EXPECT_TRUE(says(scene, "not used: extrinsics in a.npz"));
        EXPECT_EQ(guessed(folder.path()).camera.fx, 50) << name;
    }
}

TEST(NumberTables, AreReadByTheirHeadLine) {
    const NumberTable table = table_in("# time, f_x, K[0,2]\n1.5, 2, 3\n\nwords\n4, 5, 6\n");
    EXPECT_EQ(table.names, (std::vector<std::string>{"time", "fx", "k02"}));
    EXPECT_EQ(table.rows, (std::vector<std::vector<double>>{{1.5, 2, 3}, {4, 5, 6}}));
    EXPECT_EQ(table.column({"t", "time"}), 0);
    EXPECT_EQ(table.column({"t"}), -1);
    for (const char* none : {"", "1 2\n3 4\n", "a b\n", "a b\nc d\n", "a b\n1\n", "{\"a\": 1}\n1 2\n"})
        EXPECT_TRUE(table_in(none).rows.empty()) << none;
}

}  // namespace
}  // namespace touchable::test
