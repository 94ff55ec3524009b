// Files of cameras that lie beside pictures, as other programs write them: which is taken, and what it means.
#include "engine/formats/camera_sidecar.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#ifdef TOUCHABLE_HAS_OPENCV
#include <opencv2/core.hpp>
#endif

#include "engine/formats/formats_read.hpp"
#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int seen_width = 64, seen_height = 48;
constexpr double seen_fx = 50, seen_fy = 52, seen_cx = 33.5, seen_cy = 21.25;

/// Pictures of the plane X + 2 Y + 4 Z = 4 m (X to the right, Y down, Z forward), millimetres, by the camera
/// above.
class CameraBesides : public ::testing::Test {
protected:
    void SetUp() override {
        Image image{seen_width, seen_height, 2, 1, {}};
        for (int row = 0; row < seen_height; ++row)
            for (int column = 0; column < seen_width; ++column) {
                const double metres = 4 / ((column - seen_cx) / seen_fx + 2 * (row - seen_cy) / seen_fy + 4);
                const auto code = static_cast<int>(std::lround(1000 * metres));
                image.samples.push_back(static_cast<std::uint8_t>(code & 255));
                image.samples.push_back(static_cast<std::uint8_t>(code >> 8));
            }
        std::filesystem::create_directories(folder / "depth");
        for (const char* name : {"depth/0.png", "depth/1.png"})
            ASSERT_EQ(message(write_png(folder / name, image.view())), "");
    }
    GuessedScene guess() const {
        auto guessed = guess_folder(folder.path(), {});
        EXPECT_EQ(message(guessed), "");
        return guessed ? *guessed : GuessedScene{};
    }
    std::string said_of_camera() const {
        for (const Remark& remark : guess().scene.remarks)
            if (remark.what.starts_with("the camera ")) return remark.what;
        return "";
    }
    /// How far pixels are from the plane at most, metres, where they are unprojected as the clip says.
    double farthest_from_plane() const {
        auto reader = open_clip(folder.path());
        EXPECT_EQ(message(reader), "");
        if (!reader) return 1e9;
        const auto frame = (*reader)->next();
        EXPECT_EQ(message(frame), "");
        if (!frame || !*frame) return 1e9;
        const Scene& scene = (*reader)->scene();
        double farthest = 0;
        for (int row = 0; row < seen_height; ++row)
            for (int column = 0; column < seen_width; ++column) {
                const double z = scene.depth.scale * (*frame)->depth.sample(column, row);
                const double x = z * (column - scene.camera.cx) / scene.camera.fx,
                             y = z * (row - scene.camera.cy) / scene.camera.fy;
                farthest = std::max(farthest, std::abs(x + 2 * y + 4 * z - 4) / std::sqrt(21.0));
            }
        return farthest;
    }
    TemporaryFolder folder;
};

/// Half a code, at most twice as far away as it is deep.
constexpr double half_a_code = 0.001;

TEST_F(CameraBesides, OfEveryProgramLeadsToTheSamePlane) {
    const std::pair<const char*, const char*> files[] = {
        // librealsense's and Open3D's JSON; Open3D's matrix goes column by column.
        {"intrinsics.json", R"({"width": 64, "height": 48, "fx": 50, "fy": 52, "ppx": 33.5, "ppy": 21.25})"},
        {"camera.json",
         R"({"width": 64, "height": 48, "depth_scale": 1000,
             "intrinsic_matrix": [50, 0, 0, 0, 52, 0, 33.5, 21.25, 1]})"},
        {"trajectory_camera.json",
         R"({"class_name": "PinholeCameraTrajectory", "parameters": [{"extrinsic": [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],
             "intrinsic": {"height": 48, "width": 64, "intrinsic_matrix": [50, 0, 0, 0, 52, 0, 33.5, 21.25, 1]}}]})"},
        // ViSP: vpCameraParameters as JSON, vpXmlParserCamera, and its trackers' configuration.
        {"visp.json",
         R"({"model": "perspectiveWithoutDistortion", "px": 50, "py": 52, "u0": 33.5, "v0": 21.25})"},
        {"visp.xml", R"(<?xml version="1.0"?>
<root>
  <!--This file stores intrinsic camera parameters used in the vpCameraParameters Class of ViSP-->
  <camera>
    <!--Name of the camera-->
    <name>Camera</name>
    <image_width>64</image_width>
    <image_height>48</image_height>
    <model>
      <type>perspectiveProjWithDistortion</type>
      <px>49</px><py>51</py><u0>30</u0><v0>20</v0><kud>-0.1</kud><kdu>0.1</kdu>
    </model>
    <model>
      <type>perspectiveProjWithoutDistortion</type>
      <px>50</px>
      <py>52</py>
      <u0>33.5</u0>
      <v0>21.25</v0>
    </model>
  </camera>
</root>)"},
        {"tracker.xml",
         "<conf>\n<face><near_clipping>0.1</near_clipping></face>\n<camera><width>64</width><height>48</"
         "height>"
         "<u0>33.5</u0><v0>21.25</v0><px>50</px><py>52</py></camera>\n</conf>\n"},
        // Flat YAML, by hand and of ORB-SLAM.
        {"depth_camera.yaml", "# pixels\nfx: 50\nfy: 52.0\ncx: 33.5\ncy: 21.25  # down\n"},
        {"TUM1.yaml",
         "%YAML:1.0\n\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\nCamera.fx: 50.0\nCamera.fy: 52.0\n"
         "Camera.cx: 33.5\nCamera.cy: 21.25\nCamera.width: 64\nCamera.height: 48\nCamera.fps: 30\n"
         "DepthMapFactor: 1000.0\n"},
        // rostopic echo, and what camera_calibration writes.
        {"camera_info.yaml",
         "header: \n  seq: 0\n  stamp: \n    secs: 1\n  frame_id: \"camera\"\nheight: 48\nwidth: 64\n"
         "distortion_model: \"plumb_bob\"\nD: [0.0, 0.0, 0.0, 0.0, 0.0]\n"
         "K: [50.0, 0.0, 33.5, 0.0, 52.0, 21.25, 0.0, 0.0, 1.0]\nR: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, "
         "1.0]\nP: [50.0, 0.0, 33.5, 0.0, 0.0, 52.0, 21.25, 0.0, 0.0, 0.0, 1.0, 0.0]\n---\n"},
        {"head_camera.yaml",
         "image_width: 64\nimage_height: 48\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n  "
         "data: "
         "[50, 0, 33.5,\n    0, 52, 21.25, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n"
         "  rows: 1\n  cols: 5\n  data: [0, 0, 0, 0, 0]\n"},
        {"camchain.yaml",
         "cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n  distortion_coeffs: [0.0, 0.0, 0.0, 0.0]\n"
         "  distortion_model: radtan\n  intrinsics: [50.0, 52.0, 33.5, 21.25]\n  resolution: [64, 48]\n"
         "  rostopic: /depth\ncam1:\n  T_cn_cnm1:\n  - [1.0, 0.0, 0.0, 0.1]\n  - [0.0, 1.0, 0.0, 0.0]\n"
         "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n  camera_model: pinhole\n"
         "  intrinsics: [99.0, 99.0, 64, 48]\n  resolution: [128, 96]\n  rostopic: /cam1\n"},
        // COLMAP: pixel centres are at a half.
        {"cameras.txt",
         "# Camera list with one line of data per camera:\n#   CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n"
         "# Number of cameras: 2\n1 SIMPLE_RADIAL 640 480 500 320 240 0.01\n2 PINHOLE 64 48 50 52 34 "
         "21.75\n"},
        // nerfstudio's
        {"transforms.json",
         R"({"w": 64, "h": 48, "fl_x": 50, "fl_y": 52, "cx": 33.5, "cy": 21.25, "camera_model": "OPENCV",
             "frames": [{"file_path": "a.png", "transform_matrix": [[1,0,0,0],[0,1,0,0],[0,0,1,0],[0,0,0,1]]}]})"},
    };
    for (const auto& [name, text] : files) {
        write_bytes(folder / name, text);
        EXPECT_LT(farthest_from_plane(), half_a_code) << name;
        EXPECT_NE(said_of_camera().find(std::string("that of ") + name), std::string::npos)
            << said_of_camera();
        std::filesystem::remove(folder / name);
    }
    EXPECT_GT(farthest_from_plane(), 10 * half_a_code) << "or this would show nothing";
}

#ifdef TOUCHABLE_HAS_OPENCV
TEST_F(CameraBesides, ThatOpenCvWroteAreRead) {
    const cv::Matx33d matrix{seen_fx, 0, seen_cx, 0, seen_fy, seen_cy, 0, 0, 1};
    for (const char* name : {"calib.yml", "calib.xml", "calib.json"}) {
        for (const char* member : {"camera_matrix", "K", "cameraMatrix"}) {
            {
                cv::FileStorage file((folder / name).string(), cv::FileStorage::WRITE);
                file << "calibration_time"
                     << "Mon"
                     << "image_width" << seen_width << "image_height" << seen_height << member
                     << cv::Mat(matrix) << "distortion_coefficients" << cv::Mat::zeros(5, 1, CV_64F);
            }
            EXPECT_LT(farthest_from_plane(), half_a_code) << name << ' ' << member;
            EXPECT_EQ(said_of_camera(), std::string("the camera is that of ") + name);
        }
        std::filesystem::remove(folder / name);
    }
}
#endif

TEST_F(CameraBesides, OfDepthAndOfThisSizeGoFirst) {
    const std::string right = R"({"fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25})",
                      wrong = R"({"fx": 70, "fy": 70, "cx": 33.5, "cy": 21.25})";
    write_bytes(folder / "camera_a.json", wrong);
    write_bytes(folder / "camera_depth.json", right);
    EXPECT_EQ(guess().scene.camera.fx, 50) << "by its name";
    std::filesystem::remove(folder / "camera_depth.json");
    write_bytes(folder / "camera_color.json",
                R"({"width": 64, "height": 48, "fx": 70, "fy": 70, "cx": 33.5, "cy": 21.25})");
    write_bytes(folder / "camera_z.json",
                R"({"width": 64, "height": 48, "fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25})");
    EXPECT_EQ(guess().scene.camera.fx, 50) << "by its size, and as it is not of colour";
    std::filesystem::remove(folder / "camera_z.json");
    std::filesystem::remove(folder / "camera_color.json");
    std::filesystem::remove(folder / "camera_a.json");
    write_bytes(folder / "camera.json", R"({"color": )" + wrong + R"(, "depth": )" + right + "}");
    EXPECT_EQ(guess().scene.camera.fx, 50) << "by its member";
    EXPECT_NE(said_of_camera().find("camera.json (depth)"), std::string::npos) << said_of_camera();
    std::filesystem::remove(folder / "camera.json");
    write_bytes(folder / "depth" / "K.txt", "50 0 33.5\n0 52 21.25\n0 0 1\n");
    EXPECT_EQ(guess().scene.camera.fx, 50) << "in depth's folder";
    EXPECT_NE(said_of_camera().find("depth/K.txt"), std::string::npos) << said_of_camera();
}

TEST_F(CameraBesides, ThatAreNotUnderstoodAreNamed) {
    write_bytes(folder / "camera.bin", std::string("\x01\0\0\0\0\0\0\0", 8));
    write_bytes(folder / "calib.cal", "{\xff\xfe: [\xff, {\xff: 1, 2: [}\n- \xff: \n  - : [\n");
    write_bytes(folder / "calibration.toml", "[lens]\nwide = true\n");
    write_bytes(folder / "labels.json", R"({"fx": "none"})");
    write_bytes(folder / "camera_poses.txt", "1 2 3\n");
    EXPECT_EQ(said_of_camera(), guessed_field_of_view(60) +
                                    "; not understood as a camera's file: "
                                    "calib.cal, calibration.toml, camera.bin");
    write_bytes(folder / "intrinsics.json", R"({"fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25})");
    EXPECT_EQ(said_of_camera(),
              "the camera is that of intrinsics.json; not understood as a camera's file: calib.cal, "
              "calibration.toml, camera.bin");
}

TEST_F(CameraBesides, WithALensThatBendsSaySo) {
    write_bytes(folder / "camera.yaml", "fx: 50\nfy: 52\ncx: 33.5\ncy: 21.25\nk1: -0.2\n");
    EXPECT_EQ(said_of_camera(), "the camera is that of camera.yaml; its lens's distortion is not undone");
}

/// A file that says another size than its numbers are of, or none.
TEST_F(CameraBesides, WhoseSizesCannotBeAreTakenByTheirMiddle) {
    const std::pair<const char*, const char*> files[] = {
        {R"({"width": 640, "height": 480, "fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25})",
         "which says that its pictures have 640x480 pixels, but whose principal point is the middle of "
         "these"},
        {R"({"fx": 0.78125, "fy": 1.0833333333333333, "cx": 0.53125, "cy": 0.453125})",
         "whose numbers are shares of a picture"}};
    for (const auto& [text, doubt] : files) {
        write_bytes(folder / "camera.json", text);
        EXPECT_LT(farthest_from_plane(), half_a_code) << text;
        EXPECT_EQ(said_of_camera(), std::string("the camera is that of camera.json, ") + doubt);
    }
    // Of pictures ten times as large, which it does not say.
    std::string doubt;
    const Intrinsics of_large = trusted_intrinsics({500, 520, 322, 236}, seen_width, seen_height, doubt);
    EXPECT_NEAR(of_large.width, 640, 640 * 0.02);
    EXPECT_NEAR(of_large.height, 480, 480 * 0.02);
    EXPECT_NE(doubt, "");
    // What is likely as it is stays as it is: pictures of another size, and a middle that is off by a little.
    for (const Intrinsics& likely : {Intrinsics{500, 520, 319.5, 239.5, 640, 480}, Intrinsics{50, 52, 28, 26},
                                     Intrinsics{50, 52}, Intrinsics{50, 52, 200, 24.5}}) {
        doubt.clear();
        EXPECT_EQ(trusted_intrinsics(likely, seen_width, seen_height, doubt), likely);
        EXPECT_EQ(doubt, "");
    }
}

TEST_F(CameraBesides, SayTheRateWhereNoTimesDo) {
    const std::pair<const char*, FrameRate> rates[] = {
        {"59.85", {1197, 20}}, {"29.97", {30000, 1001}}, {"60", {60, 1}}, {"7.5", {15, 2}}};
    for (const auto& [number, rate] : rates) {
        // As Record3D's metadata has it, in which matrices go column by column.
        write_bytes(folder / "metadata.json",
                    std::string(R"({"h": 48, "w": 64, "K": [50, 0, 0, 0, 52, 0, 33.5, 21.25, 1], "fps": )") +
                        number + "}");
        const GuessedScene guessed = guess();
        EXPECT_EQ(guessed.scene.rate.num, rate.num);
        EXPECT_EQ(guessed.scene.rate.den, rate.den);
        EXPECT_EQ(guessed.scene.camera.cx, seen_cx);
        const auto says = [&](const Remark& remark) {
            return remark.what.ends_with(" frames a second, as metadata.json says");
        };
        EXPECT_EQ(std::count_if(guessed.scene.remarks.begin(), guessed.scene.remarks.end(), says), 1);
        EXPECT_NE(std::find(guessed.inputs.begin(), guessed.inputs.end(), folder / "metadata.json"),
                  guessed.inputs.end());
    }
    write_bytes(folder / "metadata.json", R"({"fps": -3})");
    EXPECT_EQ(guess().scene.rate.num, 30);
    write_bytes(folder / "metadata.json", R"({"fps": 59.85})");
    write_bytes(folder / "depth.txt", "1.0 depth/0.png\n1.1 depth/1.png\n");
    EXPECT_EQ(guess().scene.rate.num, 10) << "times of frames go first";
}

}  // namespace
}  // namespace touchable::test
