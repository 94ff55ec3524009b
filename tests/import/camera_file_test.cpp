// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <cmath>

#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/sidecar_text.hpp"
#include "engine/formats/source_description.hpp"
#include "engine/picture/image.hpp"
#include "tests/picture/results.hpp"

namespace touchable::test {
namespace {

using CameraFiles = FolderTest;

TEST_F(CameraFiles, RefuseTextWithoutCamera) {
    for (const char* text : {"",
                             "{",
                             "{}",
                             "[1, 2]",
                             "1 2 3",
                             "hello",
                             R"({"fx": -3, "fy": 2})",
                             R"({"fx": 1e300, "fy": 2})",
                             R"({"K": [1, 2]})",
                             "camera_matrix: nothing\n",
                             "camera_matrix:\ndata",
                             "1 PINHOLE 640 480 500\n",
                             "0 480 500 501 320 240",
                             "640 480 500 501 320",
                             "640 480 -500 501 320 240",
                             R"({"fx": "wide"})",
                             "0.8 -0.6 0\n0.6 0.8 0\n0 0 1\n",
                             "1 0 0\n0 1 0\n0 0 1\n",
                             "500 0 320\n0 500 240\n0 0 2\n",
                             "500 9 320\n0 500 240\n0 0 1\n",
                             R"({"K": [0.9, 0, 0.1, 0, 1, 0, -0.1, 0, 0.9]})"}) {
        write_bytes(folder / "camera.txt", text);
        EXPECT_TRUE(is_refused(read_intrinsics(folder / "camera.txt"), "has no camera")) << text;
        EXPECT_EQ(camera_beside({.folder = folder.path()}).camera, std::nullopt) << text;
    }
    write_bytes(folder / "camera.txt", "640 480 500 501 3200 240");
    EXPECT_TRUE(is_refused(read_intrinsics(folder / "camera.txt"), "principal point"));
    EXPECT_TRUE(is_refused(read_intrinsics(folder.path()), "is a folder; expected a camera's file"));
}

// Cameras, scales and rates under the names that programs give them, in files that lie beside pictures, above
// them, and within their own.

constexpr int across = 64, down = 48;

/// Two frames of codes from 8000 to 8255 in `folder`/depth.
void write_depth(const std::filesystem::path& folder, const char* first = "depth/0001.png",
                 const char* second = "depth/0002.png") {
    const Image image =
        made_image(across, down, 2, 1, [](int x, int y, int) { return 8000 + (across * y + x) % 251; });
    for (const char* name : {first, second}) write_in_folder(folder / name, image);
}

Scene guessed(const std::filesystem::path& folder) {
    return must(guess_folder(folder, {})).scene;
}

/// As guessed with one file beside the pictures.
Scene scene_by(const std::string& name, const std::string& text) {
    const TemporaryFolder folder;
    write_depth(folder.path());
    write_in_folder(folder / name, text);
    return guessed(folder.path());
}
Camera camera_by(const std::string& name, const std::string& text) {
    return scene_by(name, text).camera;
}

using CameraSpellings = FolderTest;

TEST_F(CameraSpellings, GiveTheSameCamera) {
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
        {"K.txt", "50 0 33.5\n0 52 21.25\n0 0 1\n"},
        {"K.txt", "50 0 33.5 0 52 21.25 0 0 1\n0.063\n"},
        {"pred_intrinsics.txt", "50 0 33.5 0 52 21.25 0 0 1\n50 0 33.5 0 52 21.25 0 0 1\n"},
        {"00000000_cam.txt",
         "extrinsic\n1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n\nintrinsic\n50 0 33.5\n0 52 21.25\n0 0 1\n\n0.5 "
         "0.01\n"},
        {"a_info.txt",
         "m_depthWidth = 64\nm_depthHeight = 48\nm_calibrationColorIntrinsic = 90 0 60 0 0 90 40 0 0 0 1 0 0 "
         "0 0 1\nm_calibrationDepthIntrinsic = 50 0 33.5 0 0 52 21.25 0 0 0 1 0 0 0 0 1\n"},
        {"l.txt", "[ 64x48  p[33.5 21.25]  f[50 52]  Brown Conrady [0 0 0 0 0] ]\n"},
        {"l.json", R"({"depth": "[ 64x48  p[33.5 21.25]  f[50 52]  None [0 0 0 0 0] ]"})"},
        {"m.json", R"({"cameraData": [[1, {"intrinsicMatrix": [[50, 0, 33.5], [0, 52, 21.25], [0, 0, 1]],
                                           "width": 64, "height": 48}]]})"},
        {"n.json", R"({"K_depth": [[50, 0, 33.5], [0, 52, 21.25], [0, 0, 1]],
                       "K_rgb": [[90, 0, 60], [0, 90, 40], [0, 0, 1]]})"},
        {"o.json", R"({"cam_intr": [50, 52, 33.5, 21.25]})"},
        {"p.json", R"({"focalLength": {"x": 50, "y": 52}, "principalPoint": {"x": 33.5, "y": 21.25}})"},
        {"q.json", R"({"fx": "50.0", "fy": "52", "cx": "33.5", "cy": "21.25"})"},
        {"r.jsonl", "{\"K\": [50, 0, 0, 0, 52, 0, 33.5, 21.25, 1]}\n{\"K\": []}\n"},
        {"s.xml",
         R"(<document><sensor label="a"><calibration class="adjusted"><resolution width="64" height="48"/>
                     <fx>50</fx><fy type="float">52</fy><cx>33.5</cx><cy>21.25</cy></calibration></sensor></document>)"},
        {"t.json", "\xef\xbb\xbf{\"fx\": 50, \"fy\": 52, \"ppx\": 33.5, \"ppy\": 21.25}"},
        {"w.json",
         R"({"color": {"width": 8}, "depth": {"intrinsics": {"width": 64, "height": 48, "fx": 50, "fy": 52,
             "cx": 33.5, "cy": 21.25}}})"},
        {"u.txt", "5e1 0 33.5 0\n0 52 21.25 0\n0 0 1 0\n0 0 0 1\n"},
        {"v.yaml",
         "%YAML:1.0\nK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [50, 0, 33.5, 0, 52, "
         "21.25, 0, 0, 1]\n"},
        {"undistorted_camera_parameters/a.conf",  // Matterport3D's
         "dataset matterport\nn_images 2\ndepth_directory depth\n\nintrinsics_matrix 50 0 33.5  0 52 21.25  "
         "0 0 1\nscan 0.png 0.jpg 1 0 0 1.5 0 1 0 2 0 0 1 3 0 0 0 1\n"},
        {"metadata", R"({"K": [50, 0, 0, 0, 52, 0, 33.5, 21.25, 1], "w": 64, "h": 48})"},
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
        {"visp.xml", R"(<?xml version="1.0"?><root><!--for the vpCameraParameters Class of ViSP--><camera>
<!--Name of the camera--><name>Camera</name><image_width>64</image_width><image_height>48</image_height>
<model><type>perspectiveProjWithDistortion</type>
<px>49</px><py>51</py><u0>30</u0><v0>20</v0><kud>-0.1</kud><kdu>0.1</kdu></model>
<model><type>perspectiveProjWithoutDistortion</type>
<px>50</px><py>52</py><u0>33.5</u0><v0>21.25</v0></model></camera></root>)"},
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
    };
    for (const auto& [name, text] : files) {
        const Scene scene = scene_by(name, text);
        EXPECT_EQ(scene.camera, (Camera{50, 52, 33.5, 21.25})) << name;
        EXPECT_TRUE(has_remark(scene, std::string("that of ") + name)) << name;
    }
    EXPECT_EQ(camera_by("cameras.txt", "1 SIMPLE_RADIAL 64 48 50 34 21.75 0.1\n"),
              (Camera{50, 50, 33.5, 21.25}));
}

TEST_F(CameraSpellings, ConvertFieldOfView) {
    const double focal = 0.5 * across / std::tan(50 * M_PI / 360);
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
    // From top to bottom where another name beside it tells, and not where it says across.
    for (const char* text :
         {R"({"fieldOfView": 38.5517})", R"({"fov": 38.5517, "aspect": 1.3333})",
          R"({"fov": 38.5517, "nearVal": 0.1, "farVal": 9})", R"({"fov": 38.5517, "nearClipPlane": 0.3})",
          R"({"object": {"type": "PerspectiveCamera", "fov": 38.5517})"
          "}",
          R"({"fov": 38.5517, "keep_aspect": "KEEP_HEIGHT"})", R"({"fov": 50, "keep_aspect": "KEEP_WIDTH"})",
          R"({"fov": 50, "image_size_x": "64", "aspect": 1.3333})"}) {
        const Scene scene = scene_by("camera.json", text);
        EXPECT_NEAR(scene.camera.fx, focal, 0.001 * focal) << text;
        EXPECT_FALSE(has_remark(scene, "gives one angle")) << text;
    }
    EXPECT_NE(camera_by("a.json", R"({"fov": 0.0001})").fx, focal);
    const Camera tall = scaled_camera({.fov_y = 50}, across, down);
    EXPECT_NEAR(tall.fy, 0.5 * down / std::tan(50 * M_PI / 360), 1e-9);
    EXPECT_EQ(tall.fx, tall.fy);
}

/// 2 arctan(64/48 tan(25 degrees)) is 63.74 degrees.
TEST_F(CameraSpellings, GuessDirectionOfBareAngle) {
    write_depth(folder.path());
    write_in_folder(folder / "camera.json", R"({"fov": 50, "near": 0.1, "width": 64, "height": 48})");
    const Scene scene = guessed(folder.path());
    EXPECT_TRUE(has_remark(scene, "the camera sees 50 degrees from left to right, as camera.json gives one"));
    EXPECT_TRUE(has_remark(scene, "from top to bottom, it sees 63.74"));
    EXPECT_TRUE(std::ranges::any_of(scene.remarks, [](const Remark& remark) {
        return remark.is_guess && remark.kind == RemarkKind::camera;
    }));
    write_in_folder(folder / "depth/0001.png", made_image(48, 48, 2, 1, [](int, int, int) { return 800; }));
    EXPECT_FALSE(has_remark(must(open_clip(folder / "depth/0001.png"))->scene(), "gives one angle"));
}

/// Half the shorter side is 24 pixels, and y goes up.
TEST_F(CameraSpellings, ReadNormalisedCoordinates) {
    for (const char* size : {"", R"(, "image_size": [[48, 64]])"}) {
        const Camera camera = camera_by("camera.json", std::string(R"({"in_ndc": true,
            "focal_length": [[2.5, 2.25]], "principal_point": [[-0.125, 0.0625]])") +
                                                           size + "}");
        EXPECT_EQ(camera, (Camera{60, 54, 34.5, 22})) << size;
    }
}

TEST_F(CameraSpellings, GivePlanes) {
    for (const char* text :
         {R"({"camera": {"nearClipPlane": 0.25, "farClipPlane": 40}})", R"({"clipping_range": [0.25, 40]})",
          R"({"znear": 0.025, "zfar": 4, "extent": 10})"}) {
        write_bytes(folder / "camera.json", text);
        const CameraText said = must(read_camera_text(folder / "camera.json"));
        EXPECT_EQ(said.near, 0.25) << text;
        EXPECT_EQ(said.far, 40) << text;
    }
}

TEST_F(CameraSpellings, SayWhereScalesDiffer) {
    write_depth(folder.path());
    const auto says = [&](const char* second) {
        write_in_folder(folder / "scene_camera.json",
                        R"({"1": {"cam_K": [50, 0, 33, 0, 50, 21, 0, 0, 1], "depth_scale": 0.1},
                            "2": {"cam_K": [50, 0, 33, 0, 50, 21, 0, 0, 1], "depth_scale": )" +
                            std::string(second) + "}}");
        return has_remark(guessed(folder.path()), "in all frames, though scene_camera.json gives some");
    };
    EXPECT_TRUE(says("0.2"));
    EXPECT_TRUE(has_remark(guessed(folder.path()), "guessed: a code is "));
    EXPECT_FALSE(says("0.1"));
}

/// Codes from 8000 to 8250 would be 31.3 m and more; 1/8 of that, 3.9 m.
TEST_F(CameraSpellings, TakeKittiCodesBesideItsCalibration) {
    write_depth(folder.path());
    const char* const words = "P_rect_02: 50 0 33.5 0 0 52 21.25 0 0 0 1 0\n";
    write_in_folder(folder / "calib_cam_to_cam.txt", words);
    EXPECT_EQ(guessed(folder.path()).depth.scale, 0.001) << "too far for a street";
    for (const char* name : {"depth/0001.png", "depth/0002.png"})
        write_in_folder(folder / name, made_image(across, down, 2, 1, [](int x, int y, int) {
                            return 1000 + (across * y + x) % 251;
                        }));
    const Scene scene = guessed(folder.path());
    EXPECT_EQ(scene.depth.scale, 1.0 / 256);
    EXPECT_EQ(scene.camera.fx, 50);
    EXPECT_TRUE(has_remark(scene, "guessed: depth is as preset kitti has it"));
    std::filesystem::rename(folder / "calib_cam_to_cam.txt", folder / "calib.txt");
    EXPECT_EQ(guessed(folder.path()).depth.scale, 0.001);
}

TEST_F(CameraSpellings, GiveDepthScale) {
    const std::string camera = R"("fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25)";
    const std::string matrix = R"("cam_K": [50, 0, 33.5, 0, 52, 21.25, 0, 0, 1])";
    const std::tuple<const char*, std::string, double> files[] = {
        {"scene_camera.json",
         R"({"0": {)" + matrix + R"(, "depth_scale": 0.1}, "1": {)" + matrix + R"(, "depth_scale": 0.1}})",
         0.0001},
        {"a.json", R"({"7": {)" + matrix + R"(, "depth_scale": 1.0}})", 0.001},
        {"a.json", R"({"7": {)" + matrix + R"(, "depth_scale": 0.001}})", 0.001},
        {"f.json", "{" + camera + R"(, "scale_factor": 5000})", 0.0002},
        {"g.json", R"({"depth_scaling_factor": 5000})", 0.0002},
        {"g.json", R"({"depth_multiplier": 5000})", 0.0002},
        {"g.json", R"({"depth_unit_in_meters": 0.0002})", 0.0002},
        {"g.json", R"({"depth_to_meters": 0.0002})", 0.0002},
        {"g.json", R"({"meters_per_unit": 0.0002})", 0.0002},
        {"g.json", R"({"depth_scale_mm": 0.2})", 0.0002},
        {"g.json", R"({"depth_scale": "1/5000"})", 0.0002},
        {"g.json", R"({"depth_unit": "cm"})", 0.01},
        {"g.json", R"({"depth_units": "Millimetres"})", 0.001},
        {"g.json", R"({"depth": {"unit": "0.1 mm"}})", 0.0001},
        {"transforms.json", "{" + camera + R"(, "integer_depth_scale": 0.0002, "frames": []})", 0.0002},
        {"b.json", "{" + camera + R"(, "depth_unit_scale_factor": 0.00025})", 0.00025},
        {"c.json", R"({"camera": {)" + camera + R"(, "scale": 6553.5}})", 1 / 6553.5},
        {"d.txt", "m_depthShift = 4000\n", 0.00025},
        {"e.yaml", "cam:\n  png_depth_scale: 5000\n", 0.0002}};
    for (const auto& [name, text, metres] : files) {
        const Scene scene = scene_by(name, text);
        EXPECT_NEAR(scene.depth.scale, metres, 1e-9 * metres) << name;
        EXPECT_TRUE(has_remark(scene, std::string(name) + " says")) << name;
    }
}

TEST_F(CameraSpellings, IgnoreOtherUnits) {
    for (const char* text : {R"({"unit": "cm"})", R"({"depth_unit": "m"})", R"({"depth_unit": "1/0 m"})",
                             R"({"metersPerSceneUnit": 0.01})", R"({"depth_scale": "/"})"}) {
        EXPECT_EQ(scene_by("a.json", text).depth.scale, 0.001) << text;
    }
}

TEST_F(CameraSpellings, GiveUnitOfFloats) {
    write_bytes(folder / "depth.npy", npy_bytes("48, 64", std::vector<float>(across * down, 150)));
    write_in_folder(folder / "camera.json", R"({"fov": 50, "metersPerSceneUnit": 0.01})");
    const Scene scene = guessed(folder.path());
    EXPECT_EQ(scene.depth.scale, 0.01);
    EXPECT_TRUE(has_remark(scene, "a value of 1 is 10 mm, as camera.json says"));
}

TEST_F(CameraSpellings, CentreMetashapePrincipalPoint) {
    const Camera camera =
        camera_by("cameras.xml",
                  R"(<document><sensor id="0" type="frame"><calibration><resolution width="64" height="48"/>
                          <f>50</f><cx>2</cx><cy>-2.75</cy></calibration></sensor></document>)");
    EXPECT_EQ(camera, (Camera{50, 50, 33.5, 20.75}));
}

TEST_F(CameraSpellings, TakeScaleFromNamedFile) {
    write_depth(folder.path());
    write_in_folder(folder / "else/a.json",
                    R"({"fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25, "scale": 6553.5})");
    SourceDescription known;
    known.file = folder / "else/a.json";
    auto read = must(read_intrinsics(known.file));
    known.intrinsics = read;
    const auto scene = must(guess_folder(folder.path(), known));
    EXPECT_NEAR(scene.scene.depth.scale, 1 / 6553.5, 1e-12);
}

TEST_F(CameraSpellings, AreFoundInNeighbouringFolders) {
    const std::string camera = R"({"fx": 100, "fy": 104, "cx": 67.5, "cy": 43, "width": 128, "height": 96})";
    for (const char* where : {"cameras/0001.json", "poses/frame_0001.json", "intrinsic/a.json"}) {
        const TemporaryFolder fresh;
        write_depth(fresh.path());
        write_in_folder(fresh / where, camera);
        write_in_folder((fresh / where).parent_path() / "frame_2.json", camera);
        for (const auto& opened : {fresh.path(), fresh / "depth"}) {
            EXPECT_EQ(guessed(opened).camera.fx, 50) << where << ' ' << opened;
            EXPECT_EQ(guessed(opened).camera.cx, 33.5) << where;
        }
    }
    write_depth(folder / "run/frames/depth/Camera_0", "0001.png", "0002.png");
    write_in_folder(folder / "run/intrinsic.txt", "frame K[0,0] K[1,1] K[0,2] K[1,2]\n0 50 52 33.5 21.25\n");
    EXPECT_EQ(guessed(folder / "run/frames/depth/Camera_0").camera.fx, 50);
    EXPECT_EQ(guessed(folder / "run/frames/depth").camera.fx, 50);
}

TEST_F(CameraSpellings, AreFoundInCameraFolders) {
    const std::string matrix = "50 0 33.5\n0 52 21.25\n0 0 1\n", bare = "64 48 50 52 33.5 21.25 0 0 0 0 0\n";
    for (const auto& [where, text] : {std::pair<const char*, std::string>{"cams", matrix},
                                      {"K", matrix},
                                      {"rtabmap_calib", matrix},
                                      {"matterport_camera_intrinsics", bare}}) {
        const TemporaryFolder fresh;
        write_depth(fresh.path());
        for (const char* name : {"0001.txt", "0002.txt"}) write_in_folder(fresh / where / name, text);
        EXPECT_EQ(guessed(fresh.path()).camera.fx, 50) << where;
    }
}

TEST_F(CameraSpellings, AreFoundInFoldersAbove) {
    const std::string camera =
        R"({"camera": {"fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25, "scale": 6553.5}})";
    for (const char* name : {"cam_params.json", "camK.json", "meta.json", "dataset.yaml"}) {
        const TemporaryFolder fresh;
        write_depth(fresh.path(), "set/room0/results/depth0001.png", "set/room0/results/depth0002.png");
        write_in_folder(fresh / "set" / name, camera);
        for (const char* opened : {"set/room0", "set/room0/results"}) {
            const Scene scene = guessed(fresh / opened);
            EXPECT_EQ(scene.camera.fx, 50) << name;
            EXPECT_NEAR(scene.depth.scale, 1 / 6553.5, 1e-12) << name;
        }
    }
    // Files without a camera, or of another folder there, are ignored.
    write_depth(folder / "a");
    write_in_folder(folder / "settings.json", R"({"fov": 30, "depth_scale": 5000})");
    write_in_folder(folder / "b.json", camera);
    std::filesystem::create_directories(folder / "b");
    const Scene scene = guessed(folder / "a");
    EXPECT_TRUE(has_remark(scene, "the camera sees 60 degrees"));
    EXPECT_EQ(scene.depth.scale, 0.001);
}

TEST_F(CameraSpellings, ScaleOrRefuseNamedFile) {
    write_depth(folder.path());
    write_in_folder(folder / "else/m.csv", "500.5, 0.0, 317\n0.0, 500.5, 239.75\n0.0, 0.0, 1.0\n");
    write_in_folder(folder / "else/n.csv", "500.5, 0.0, 317\n0.0, 500.5, 20\n0.0, 0.0, 1.0\n");
    SourceDescription known;
    const auto guess_by = [&](const char* name) {
        known.file = folder / "else" / name;
        auto read = read_intrinsics(known.file);
        EXPECT_EQ(message(read), "");
        if (read) known.intrinsics = *read;
        return guess_folder(folder.path(), known);
    };
    const auto scaled = must(guess_by("m.csv"));
    EXPECT_NEAR(scaled.scene.camera.fx, 50.05, 1e-9);
    EXPECT_TRUE(has_remark(scaled.scene, "times as large"));
    EXPECT_TRUE(is_refused(guess_by("n.csv"), "is of other pictures"));
    write_in_folder(folder / "else/fov.json", R"({"fov_x": 50})");
    const auto seen = must(guess_by("fov.json"));
    EXPECT_NEAR(seen.scene.camera.fx, 0.5 * across / std::tan(50 * M_PI / 360), 1e-9);
}

TEST_F(CameraSpellings, GiveRateByTimes) {
    const std::tuple<const char*, const char*, double> files[] = {
        {"timestamps.txt", "10.00\n10.05\n", 20},
        {"times.txt", "0 10.00\n1 10.05\n", 20},
        {"depth_timestamps.json", "[10.0, 10.05]", 20},
        {"fps.txt", "20\n", 20},
        {"a.jsonl", "{\"fx\": 50, \"cx\": 33, \"cy\": 21, \"time\": 1}\n{\"fx\": 50, \"time\": 1.05}\n", 20},
        // Times of other frames.
        {"timestamps.txt", "10.00\n10.05\n10.1\n", 30},
        {"imu_times.txt", "10.00\n10.05\n", 30}};
    for (const auto& [name, text, rate] : files)
        EXPECT_NEAR(scene_by(name, text).rate.per_second(), rate, 0.01) << name << text;
    write_bytes(folder / "depth.npy", npy_bytes("2, 48, 64", std::vector<float>(2 * across * down, 1.5F)));
    write_in_folder(folder / "intrinsics.json",
                    R"({"fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25, "fps": 12})");
    const auto clip = must(open_clip(folder / "depth.npy"));
    EXPECT_EQ(clip->scene().rate.per_second(), 12);
    EXPECT_FALSE(has_remark(clip->scene(), "guessed: 12 frames a second"));
}

TEST_F(CameraSpellings, GiveRateByTimesInArrays) {
    const std::string depth = npy_bytes("3, 48, 64", std::vector<float>(3 * across * down, 1.5F));
    const auto scene = [&](const char* name, const std::string& times) {
        write_npz(folder / "a.npz", {{"depth", depth}, {name, times}});
        const Scene opened = must(open_clip(folder / "a.npz"))->scene();
        EXPECT_EQ(guessed(folder.path()).rate.per_second(), opened.rate.per_second()) << name;
        return opened;
    };
    const std::string three = npy_bytes("3,", {10, 10.25F, 10.5F});
    for (const char* name : {"timestamps", "timestamp", "depth_timestamps", "times"})
        EXPECT_EQ(scene(name, three).rate.per_second(), 4) << name;
    EXPECT_EQ(scene("control_freq", npy_bytes("1,", {20})).rate.per_second(), 20);
    // Times of others: the rate is a guess.
    EXPECT_TRUE(has_remark(scene("imu_times", three), "guessed: 30 frames a second"));
    EXPECT_TRUE(has_remark(scene("timestamps", npy_bytes("4,", {0, 1, 2, 3})), "guessed: 30 frames"));
}

TEST_F(CameraSpellings, NameUnusedFiles) {
    write_depth(folder.path());
    write_in_folder(folder / "mesh_info.json", R"({"alignment": [1, 0, 0, 0]})");
    write_in_folder(folder / "words.txt", "no numbers\n");
    write_in_folder(folder / "._notes.json", "{\"fx\": 3}");
    write_in_folder(folder / "calib_lens.json", R"({"radius": 3})");
    const Scene scene = guessed(folder.path());
    EXPECT_TRUE(has_remark(scene, "beside the pictures, and not used: mesh_info.json"));
    EXPECT_TRUE(has_remark(scene, "not understood as a camera's file: calib_lens.json"));
    EXPECT_FALSE(has_remark(scene, "words.txt"));
    EXPECT_FALSE(has_remark(scene, "._notes"));
}

TEST_F(CameraSpellings, AreReadFromArrays) {
    const std::vector<float> depth(2 * across * down, 1.5F);
    const std::vector<float> one{50, 0, 33.5, 0, 52, 21.25, 0, 0, 1};
    std::vector<float> two = one;
    two.insert(two.end(), one.begin(), one.end());
    const std::string depth_bytes = npy_bytes("2, 48, 64", depth);
    // What numpy.save makes of a transposed matrix.
    std::string turned = npy_bytes("3, 3", {50, 0, 0, 0, 52, 0, 33.5, 21.25, 1});
    turned.replace(turned.find("False"), 5, "True ");
    for (const auto& [name, bytes] :
         {std::pair<const char*, std::string>{"intrinsics", npy_bytes("2, 3, 3", two)},
          {"K", npy_bytes("3, 3", one)},
          {"cam_K", turned},
          {"intrinsic", npy_bytes("4,", {50, 52, 33.5, 21.25})}}) {
        write_npz(folder / "a.npz",
                  {{"depth", depth_bytes}, {name, bytes}, {"extrinsics", npy_bytes("3,", {1, 2, 3})}});
        const auto clip = must(open_clip(folder / "a.npz"));
        const Scene& scene = clip->scene();
        EXPECT_EQ(scene.camera.fx, 50) << name;
        EXPECT_EQ(scene.camera.fy, 52) << name;
        EXPECT_EQ(scene.camera.cx, 33.5) << name;
        EXPECT_TRUE(has_remark(scene, std::string("that of a.npz (") + name + ")"));
        EXPECT_TRUE(has_remark(scene, "not used: extrinsics in a.npz"));
        EXPECT_EQ(guessed(folder.path()).camera.fx, 50) << name;
    }
}

/// KITTI's calibration of the camera, OpenCV's matrices of a pair, and what is said.
TEST_F(CameraSpellings, SayBaselineOfPair) {
    const std::pair<const char*, double> files[] = {
        {"calib_time: 01-Jan-2012 00:00:00\nP_rect_02: 50 0 33.5 8.9712 0 52 21.25 0.043 0 0 1 0.0027\n"
         "P_rect_03: 50 0 33.5 -18.0288 0 52 21.25 0.043 0 0 1 0.0027\n",
         0.54},
        {"P0: 50 0 33.5 0 0 52 21.25 0 0 0 1 0\nP1: 50 0 33.5 -27 0 52 21.25 0 0 0 1 0\n", 0.54},
        {R"({"P1": [[50, 0, 33.5, 0], [0, 52, 21.25, 0], [0, 0, 1, 0]],
             "P2": [[50, 0, 33.5, -6000], [0, 52, 21.25, 0], [0, 0, 1, 0]]})",
         0.12},
        {R"({"fx": 50, "fy": 52, "cx": 33.5, "cy": 21.25, "baseline": 0.063})", 0.063},
        {R"({"P1": [50, 0, 33.5, 0, 0, 52, 21.25, 0, 0, 0, 1, 0],
             "P2": [50, 0, 33.5, -250, 0, 52, 21.25, 0, 0, 0, 1, 0]})",
         0}};  // 5 m, 5 cm or 5 mm
    for (const auto& [text, metres] : files) {
        write_bytes(folder / "calib.txt", text);
        const CameraFile read = must(read_camera_file(folder / "calib.txt"));
        EXPECT_NEAR(read.intrinsics.fx, 50, 1e-9) << text;
        EXPECT_NEAR(read.baseline, metres, 1e-9) << text;
    }
}

TEST(NumberTable, ReadsHeadLineAndRows) {
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
