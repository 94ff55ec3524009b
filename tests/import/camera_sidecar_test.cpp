// SPDX-License-Identifier: Apache-2.0
// Files of cameras that lie beside pictures, as other programs write them: which is taken, and what it means.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "engine/clip/clip_file.hpp"
#include "engine/formats/camera_sidecar.hpp"
#include "engine/formats/formats_read.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/picture/results.hpp"

#ifdef TOUCHABLE_HAS_OPENCV
#include <opencv2/core.hpp>
#endif

namespace touchable::test {
namespace {

constexpr int seen_width = 64, seen_height = 48;
constexpr double seen_fx = 50, seen_fy = 52, seen_cx = 33.5, seen_cy = 21.25;

/// Pictures of the plane X + 2 Y + 4 Z = 4 m (X to the right, Y down, Z forward), millimetres, by the camera
/// above.
class CameraSidecar : public ::testing::Test {
protected:
    void SetUp() override {
        const Image image = made_image(seen_width, seen_height, 2, 1, [](int column, int row, int) {
            return std::lround(4000 / ((column - seen_cx) / seen_fx + 2 * (row - seen_cy) / seen_fy + 4));
        });
        for (const char* name : {"depth/0.png", "depth/1.png"}) write_in_folder(folder / name, image);
    }
    GuessedScene guess() const {
        auto guessed = must(guess_folder(folder.path(), {}));
        EXPECT_EQ(lost_kinds(guessed.scene.remarks), "");
        return guessed;
    }
    std::string said_of_camera() const {
        for (const Remark& remark : guess().scene.remarks)
            if (remark.what.starts_with("the camera ")) return remark.what;
        return "";
    }
    /// How far pixels are from the plane at most, metres, where they are unprojected as the clip says.
    double farthest_from_plane() const {
        const auto reader = must(open_clip(folder.path()));
        const auto frame = must(reader->next());
        const Scene& scene = reader->scene();
        double farthest = 0;
        for (int row = 0; row < seen_height; ++row)
            for (int column = 0; column < seen_width; ++column) {
                const double z = scene.depth.scale * frame->depth.sample(column, row);
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

TEST_F(CameraSidecar, TellsGuessedPrincipalPoint) {
    const std::string file = folder / "camera.json";
    const std::string words =
        "the principal point is the middle of the picture, 31.5, 23.5, as camera.json "
        "states none";
    write_bytes(file, R"({"fx": 50, "fy": 52})");
    SourceDescription known;
    known.file = file;
    known.intrinsics = must(read_intrinsics(file));
    for (const Scene& scene : {guess().scene, must(guess_folder(folder.path(), known)).scene}) {
        const auto said = std::ranges::find(scene.remarks, words, &Remark::what);
        ASSERT_NE(said, scene.remarks.end());
        EXPECT_TRUE(said->is_guess);
        EXPECT_EQ(said->hints.at(0).value, "FX,FY,CX,CY");
    }
    write_bytes(file, R"({"fx": 50, "fy": 52, "cx": 31.5, "cy": 23.5})");
    EXPECT_FALSE(has_remark(guess().scene, "the middle of the picture"));
}

#ifdef TOUCHABLE_HAS_OPENCV
TEST_F(CameraSidecar, ReadsOpenCvFiles) {
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

TEST_F(CameraSidecar, PrefersDepthAndMatchingSize) {
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
    EXPECT_TRUE(has_words(said_of_camera(), "camera.json (depth)"));
    std::filesystem::remove(folder / "camera.json");
    write_bytes(folder / "depth" / "K.txt", "50 0 33.5\n0 52 21.25\n0 0 1\n");
    EXPECT_EQ(guess().scene.camera.fx, 50) << "in depth's folder";
    EXPECT_TRUE(has_words(said_of_camera(), "depth/K.txt"));
}

TEST_F(CameraSidecar, NamesUnreadableFiles) {
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

TEST_F(CameraSidecar, NotesLensDistortion) {
    write_bytes(folder / "camera.yaml", "fx: 50\nfy: 52\ncx: 33.5\ncy: 21.25\nk1: -0.2\n");
    EXPECT_EQ(said_of_camera(), "the camera is that of camera.yaml; its lens's distortion is not undone");
    for (const char* terms : {"dist_coeff: [[-0.3, 0.1, 0, 0, 0]]\n", "radial_distortion: [-0.3, 0.1]\n"}) {
        write_bytes(folder / "camera.yaml", std::string("fx: 50\nfy: 52\ncx: 33.5\ncy: 21.25\n") + terms);
        EXPECT_EQ(said_of_camera(), "the camera is that of camera.yaml; its lens's distortion is not undone");
    }
}

/// A file that says another size than its numbers are of, or none.
TEST_F(CameraSidecar, CorrectsImpossibleSizes) {
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
    // The camera is of pictures ten times as large, but does not say so.
    std::string doubt;
    const Intrinsics of_large = trusted_intrinsics({500, 520, 322, 236}, seen_width, seen_height, doubt);
    EXPECT_NEAR(of_large.width, 640, 640 * 0.02);
    EXPECT_NEAR(of_large.height, 480, 480 * 0.02);
    EXPECT_NE(doubt, "");
    // Likely cameras stay unchanged: of pictures of another size, or with a middle that is off by a little.
    for (const Intrinsics& likely : {Intrinsics{500, 520, 319.5, 239.5, 640, 480}, Intrinsics{50, 52, 28, 26},
                                     Intrinsics{50, 52}, Intrinsics{50, 52, 200, 24.5}}) {
        doubt.clear();
        EXPECT_EQ(trusted_intrinsics(likely, seen_width, seen_height, doubt), likely);
        EXPECT_EQ(doubt, "");
    }
}

/// Each number by itself: shares beside pixels.
TEST_F(CameraSidecar, BringsSharesToPixels) {
    const char* const files[] = {R"({"fx": 50, "fy": 52, "cx": 0.53125, "cy": 0.453125})",
                                 R"({"fx": 0.78125, "fy": 1.0833333333333333, "cx": 33.5, "cy": 21.25})",
                                 R"({"K": [0.78125, 0, 33.5, 0, 1.0833333333333333, 21.25, 0, 0, 1]})",
                                 R"({"K": [50, 0, 0.53125, 0, 52, 0.453125, 0, 0, 1]})"};
    for (const char* text : files) {
        write_bytes(folder / "camera.json", text);
        EXPECT_LT(farthest_from_plane(), half_a_code) << text;
        EXPECT_EQ(said_of_camera(),
                  "the camera is that of camera.json, some of whose numbers are shares of a picture");
    }
    std::string doubt;
    const Intrinsics square = in_pixels({0.8, 0.8, 33.5, 21.25}, seen_width, seen_height, doubt);
    EXPECT_NEAR(square.fx, 0.8 * seen_width, 1e-9) << "one share is of the longer side";
    EXPECT_NEAR(square.fy, square.fx, 1e-9);
    // A principal point in a corner is none, nor is a focal length in millimetres one of pixels.
    write_bytes(folder / "camera.json", R"({"K": [50, 0, 0, 0, 52, 0, 0, 0, 1]})");
    EXPECT_EQ(guess().scene.camera.cx, 31.5);
    EXPECT_EQ(
        said_of_camera(),
        "the camera is that of camera.json, whose principal point is in a corner, so the middle is taken");
    write_bytes(folder / "camera.json", R"({"fx": 4.2, "fy": 4.2, "cx": 33.5, "cy": 21.25})");
    EXPECT_EQ(said_of_camera(),
              guessed_field_of_view(60) + "; not understood as a camera's file: camera.json");
    // What a person types goes the same way.
    const auto typed = must(guess_folder(
        folder.path(), stated(&SourceDescription::intrinsics, Intrinsics{50, 52, 0.53125, 0.453125})));
    EXPECT_NEAR(typed.scene.camera.cx, 33.5, 1e-9);
    EXPECT_TRUE(
        has_remark(typed.scene, "the camera is the one that was said, some of whose numbers are shares"));
}

/// NumPy's arrays beside pictures: by the file's name, by its numbers, and one for each frame.
TEST_F(CameraSidecar, ReadsArraysBesidePictures) {
    const std::vector<float> matrix{50, 0, 33.5, 0, 52, 21.25, 0, 0, 1};
    const std::string bytes = npy_bytes("3, 3", matrix), lens = npy_bytes("5,", {0.1F, 0, 0, 0, 0});
    const std::function<void()> makers[] = {
        [&] { write_bytes(folder / "intrinsics.npy", bytes); },
        [&] {
            write_bytes(folder / "cam_K.npy",
                        npy_bytes("4, 4", {50, 0, 33.5, 0, 0, 52, 21.25, 0, 0, 0, 1, 0, 0, 0, 0, 1}));
        },
        [&] {
            write_npz(folder / "calib.npz", {{"mtx", bytes}, {"dist", lens}});
        },
        [&] {
            write_npz(folder / "anno.npz",
                      {{"trajs_2d", npy_bytes("2, 7, 2", std::vector<float>(28, 1))}, {"intrinsics", bytes}});
        },
        [&] {
            std::filesystem::create_directory(folder / "camera");
            for (const char* name : {"camera/0.npz", "camera/1.npz"})
                write_npz(folder / name,
                          {{"pose", npy_bytes("4, 4", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1})},
                           {"intrinsics", bytes}});
        }};
    for (const auto& make : makers) {
        make();
        EXPECT_LT(farthest_from_plane(), half_a_code) << said_of_camera();
        for (const char* name : {"intrinsics.npy", "cam_K.npy", "calib.npz", "anno.npz", "camera"})
            std::filesystem::remove_all(folder / name);
    }
    write_npz(folder / "calib.npz", {{"mtx", bytes}, {"dist", lens}});
    EXPECT_EQ(said_of_camera(), "the camera is that of calib.npz; its lens's distortion is not undone");
    EXPECT_FALSE(has_remark(guess().scene, "not used"));
    write_npz(folder / "more.npz", {{"poses", npy_bytes("4,", {1, 2, 3, 4})}});
    EXPECT_FALSE(has_remark(guess().scene, "more.npz"));
}

TEST_F(CameraSidecar, GivesRateUnlessTimesDo) {
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
        EXPECT_EQ(std::ranges::count(guessed.inputs, folder / "metadata.json"), 1);
    }
    write_bytes(folder / "metadata.json", R"({"fps": -3})");
    EXPECT_EQ(guess().scene.rate.num, 30);
    write_bytes(folder / "metadata.json", R"({"fps": 59.85})");
    EXPECT_EQ(std::ranges::count(guess().inputs, folder / "metadata.json"), 1) << "of the rate alone";
    write_bytes(folder / "depth.txt", "1.0 depth/0.png\n1.1 depth/1.png\n");
    EXPECT_EQ(guess().scene.rate.num, 10) << "times of frames go first";
}

Scene scene_of(const std::filesystem::path& picture) {
    return must(open_clip(picture))->scene();
}

TEST_F(CameraSidecar, BelongsToItsPicture) {
    constexpr const char* names[][2] = {{"scan_N_depth.png", "scan_N.json"},
                                        {"vN_depth.png", "vN_meta.json"},
                                        {"depth_0000N.png", "frame_0000N.json"},
                                        {"000N_depth16.png", "000N.json"},
                                        {"depth/0000N.png", "cameras/0000N.json"}};
    const auto named = [](std::string name, char number) {
        name[name.find('N')] = number;
        return name;
    };
    for (const auto& [picture, sidecar] : names) {
        const TemporaryFolder here;
        for (const char n : {'1', '2', '3'}) {
            write_in_folder(here / named(picture, n), read_bytes(folder / "depth/0.png"));
            write_in_folder(here / named(sidecar, n),
                            std::string(R"({"fy": 52, "cx": 33.5, "cy": 21.25, "fx": 5)") + n +
                                R"(, "depth_scale": )" + n + "000}");
        }
        for (const char n : {'1', '2', '3'}) {
            const Scene scene = scene_of(here / named(picture, n));
            EXPECT_EQ(scene.camera.fx, 50 + n - '0') << picture;
            EXPECT_EQ(scene.depth.scale, 0.001 / (n - '0')) << picture;
        }
    }
}

TEST_F(CameraSidecar, ListsCamerasByPictureNumber) {
    const auto write = [&](const char* keyed) { write_bytes(folder / "scene_camera.json", keyed); };
    write(R"({"0": {"cam_K": [50, 0, 33, 0, 50, 21, 0, 0, 1], "depth_scale": 0.1},
              "1": {"cam_K": [80, 0, 33, 0, 80, 21, 0, 0, 1], "depth_scale": 0.5}})");
    EXPECT_EQ(scene_of(folder / "depth/0.png").camera.fx, 50);
    EXPECT_EQ(scene_of(folder / "depth/1.png").camera.fx, 80);
    EXPECT_EQ(scene_of(folder / "depth/1.png").depth.scale, 0.0005);
    // A rig's, which no frame has: not the mean of both.
    EXPECT_EQ(guess().scene.camera.fx, 50);
    EXPECT_TRUE(has_remark(guess().scene, "the camera is one of 2 that differ, scene_camera.json (0)"));
    std::filesystem::copy_file(folder / "depth/0.png", folder / "depth/2.png");
    EXPECT_TRUE(has_remark(scene_of(folder / "depth/1.png"), "one of 2 that differ"));
    std::filesystem::remove(folder / "scene_camera.json");
    write_bytes(folder / "cameras.json", R"([{"img_name": "0", "fx": 50, "fy": 50, "width": 64, "height": 48},
        {"img_name": "1", "fx": 51, "fy": 50}, {"img_name": "2", "fx": 52, "fy": 50}])");
    EXPECT_EQ(scene_of(folder / "depth/2.png").camera.fx, 52);
    EXPECT_EQ(guess().scene.camera.fx, 51);
}

TEST_F(CameraSidecar, ChoosesAmongDifferentCameras) {
    write_bytes(folder / "left.json", R"({"fx": 50, "fy": 50, "cx": 31, "cy": 23})");
    write_bytes(folder / "right.json", R"({"fx": 90, "fy": 90, "cx": 31, "cy": 23})");
    const Scene scene = guess().scene;
    EXPECT_EQ(scene.camera.fx, 50);
    const auto remark =
        std::ranges::find(scene.remarks, "the camera is one of 2 that differ, left.json", &Remark::what);
    ASSERT_NE(remark, scene.remarks.end());
    EXPECT_EQ(remark->kind, RemarkKind::camera);
    for (const char* middle : {R"("cx": 31, "cy": 40)", R"("cx": 50, "cy": 23)"}) {
        write_bytes(folder / "left.json", std::string(R"({"fx": 50, "fy": 50, )") + middle + '}');
        EXPECT_EQ(guess().scene.camera.fx, 90) << "not in the middle both ways: " << middle;
        EXPECT_FALSE(has_remark(guess().scene, "that differ"));
    }
    write_bytes(folder / "left.json", R"({"fx": 50, "fy": 50, "cx": 31, "cy": 23})");
    std::filesystem::rename(folder / "depth", folder / "depth_right");
    EXPECT_EQ(guess().scene.camera.fx, 90);
    EXPECT_FALSE(has_remark(guess().scene, "that differ"));
    for (const char* camera : {"cam0", "cam1"}) {
        std::filesystem::create_directories(folder / "rig" / camera);
        std::filesystem::copy(folder / "depth_right", folder / "rig" / camera / "depth",
                              std::filesystem::copy_options::recursive);
        write_bytes(folder / "rig" / (std::string(camera) + ".json"),
                    std::string(R"({"fx": 5)") + camera[3] + R"(, "fy": 50, "cx": 31, "cy": 23})");
    }
    EXPECT_EQ(scene_of(folder / "rig/cam0").camera.fx, 50);
    EXPECT_EQ(scene_of(folder / "rig/cam1").camera.fx, 51);
}

TEST_F(CameraSidecar, PrefersDepthToUsualName) {
    write_bytes(folder / "camera.json", R"({"fx": 90, "fy": 90, "cx": 31, "cy": 23})");
    write_bytes(folder / "depth_of_robot.json",
                R"({"width": 64, "height": 48, "fx": 50, "fy": 50, "cx": 31, "cy": 23})");
    EXPECT_EQ(guess().scene.camera.fx, 50);
    EXPECT_FALSE(has_remark(guess().scene, "that differ"));
}

TEST_F(CameraSidecar, DropsColourCameraAsGuess) {
    write_bytes(folder / "ir.json", R"({"fx": 90, "fy": 90, "cx": 31, "cy": 23})");
    write_bytes(folder / "rgb.json", R"({"fx": 50, "fy": 50, "cx": 31, "cy": 23})");
    EXPECT_EQ(guess().scene.camera.fx, 90);
    EXPECT_TRUE(has_remark(guess().scene, "the camera is one of 2 that differ, ir.json"));
}

TEST_F(CameraSidecar, TakesStrayAngleAsGuess) {
    write_bytes(folder / "settings.json", R"({"window": {"fov": 90}})");
    EXPECT_TRUE(has_remark(guess().scene, "the camera is an angle in settings.json"));
}

TEST_F(CameraSidecar, SkipsFileOfAnotherPicture) {
    for (const char* picture : {"chair_depth.png", "table_depth.png"})
        std::filesystem::copy_file(folder / "depth/0.png", folder / picture);
    write_bytes(folder / "chair_camera.json",
                R"({"fx": 50, "fy": 50, "cx": 31, "cy": 23, "depth_scale": 2000})");
    EXPECT_EQ(scene_of(folder / "chair_depth.png").camera.fx, 50);
    EXPECT_NE(scene_of(folder / "table_depth.png").camera.fx, 50);
    EXPECT_NE(scene_of(folder / "table_depth.png").depth.scale, 0.0005);
    for (const char* picture : {"chair_2_depth.png", "chair_2b_depth.png", "chair_20_depth.png"})
        std::filesystem::copy_file(folder / "depth/0.png", folder / picture);
    for (const char* camera : {"chair_2b_camera.json", "chair_20_camera.json"})
        write_bytes(folder / camera, R"({"fx": 70, "fy": 70, "cx": 31, "cy": 23})");
    EXPECT_EQ(scene_of(folder / "chair_2_depth.png").camera.fx, 50);
    EXPECT_EQ(scene_of(folder / "chair_2b_depth.png").camera.fx, 70);
}

TEST_F(CameraSidecar, ChoosesSizeOfPicture) {
    write_bytes(folder / "SN1.conf",
                "[LEFT_CAM_2K]\nfx=1060\nfy=1060\ncx=1110\ncy=620\n[LEFT_CAM_FHD]\nfx=1060\nfy=1060\ncx=965\n"
                "cy=540\n[LEFT_CAM_HD]\nfx=530\nfy=530\ncx=645\ncy=360\n[LEFT_CAM_VGA]\nfx=265\nfy=265\n"
                "cx=340\ncy=188\n");
    const std::pair<std::pair<int, int>, int> sizes[] = {
        {{2208, 1242}, 2208}, {{1920, 1080}, 1920}, {{1280, 720}, 1280}, {{672, 376}, 672}, {{168, 94}, 672}};
    for (const auto& [size, of] : sizes) {
        const auto beside =
            camera_beside({.folder = folder.path(), .width = size.first, .height = size.second});
        ASSERT_TRUE(beside.camera);
        EXPECT_EQ(beside.camera->intrinsics.width, of);
        EXPECT_TRUE(beside.guesses.empty());
    }
}

TEST_F(CameraSidecar, GuessesTurnOrCrop) {
    const auto beside = [&](const char* text) {
        write_bytes(folder / "camera.json", text);
        return camera_beside({.folder = folder.path(), .width = 64, .height = 48});
    };
    const auto turned = beside(R"({"width": 48, "height": 64, "fx": 50, "fy": 52, "cx": 20, "cy": 33})");
    ASSERT_EQ(turned.guesses.size(), 1U);
    EXPECT_TRUE(turned.guesses[0].starts_with("the camera is that of camera.json turned by a quarter"));
    EXPECT_EQ(turned.camera->intrinsics, (Intrinsics{52, 50, 33, 27, 64, 48}));
    const auto swapped = beside(R"({"width": 48, "height": 64, "fx": 50, "fy": 52, "cx": 33, "cy": 20})");
    ASSERT_EQ(swapped.guesses.size(), 1U);
    EXPECT_EQ(swapped.camera->intrinsics, (Intrinsics{50, 52, 33, 20, 64, 48}));
    const auto wide = beside(R"({"width": 1280, "height": 720, "fx": 900, "fy": 900, "cx": 640, "cy": 360})");
    ASSERT_EQ(wide.guesses.size(), 1U);
    EXPECT_TRUE(wide.guesses[0].ends_with("taken as cut to that and not stretched"));
    EXPECT_TRUE(beside(R"({"width": 640, "height": 480, "fx": 500, "fy": 500})").guesses.empty());
}

TEST_F(CameraSidecar, ReadsAzureKinectMode) {
    const std::string lens = "0, 0, 0, 0, 0, 0, 0, 0, 0, 0";
    write_bytes(folder / "calibration.json",
                R"({"CalibrationInformation": {"Cameras": [{"Purpose": "CALIBRATION_CameraPurposeDepth",
                "Intrinsics": {"ModelParameters": [0.5, 0.5, 0.49, 0.48, )" +
                    lens + R"(]}, "Rt": {"Rotation": [1,0,0,0,1,0,0,0,1], "Translation": [0,0,0]}}]}})");
    const auto beside = camera_beside({.folder = folder.path(), .width = 320, .height = 288});
    ASSERT_TRUE(beside.camera);
    EXPECT_EQ(beside.camera->intrinsics,
              (Intrinsics{0.49 * 512, 0.48 * 512, 256 - 96 - 0.5, 256 - 90 - 0.5}));
    EXPECT_FALSE(camera_beside({.folder = folder.path(), .width = 64, .height = 48}).camera);
}

TEST_F(CameraSidecar, IgnoresOtherNumbers) {
    const auto guessed_to_see = [](const Scene& scene) {
        return has_remark(scene, "the camera sees 60 degrees");
    };
    // Boxes around things.
    for (const char* name : {"depth/0.txt", "depth/1.txt"}) write_bytes(folder / name, "100 200 300 250\n");
    EXPECT_TRUE(guessed_to_see(guess().scene));
    // The angle of a window, beside a single picture.
    write_bytes(folder / "depth/settings.json", R"({"window": {"fov": 100}})");
    EXPECT_TRUE(guessed_to_see(scene_of(folder / "depth/0.png")));
    write_bytes(folder / "camera.json",
                "version https://git-lfs.github.com/spec/v1\noid sha256:4d\nsize 120\n");
    std::filesystem::remove(folder / "depth/settings.json");
    EXPECT_TRUE(has_remark(guess().scene, "camera.json, which is a Git LFS pointer"));
    const SmallArray nan[] = {{"fx", {1}, {std::nan("")}}, {"fy", {1}, {std::nan("")}}, {"cx", {1}, {30}}};
    EXPECT_TRUE(cameras_in_arrays(nan).cameras.empty());
}

TEST_F(CameraSidecar, TakesMedianOfAngles) {
    write_bytes(folder / "angles.csv", "frame,fov\n0,50\n1,52\n2,51\n");
    EXPECT_NEAR(guess().scene.camera.fx, 0.5 * seen_width / std::tan(51 * M_PI / 360), 1e-9);
}

// Frames with a camera each: brought onto the clip's, beside a plain twin and a plane in the world.

constexpr int wide = 96, high = 72;
constexpr double unit = 0.0001;  // metres a code

struct Lens4 {
    long double fx, fy, cx, cy;
};
constexpr Lens4 of_clip{80, 81, 46.5L, 36.25L};
constexpr Lens4 of_frames[] = {of_clip, {84, 83, 49.8L, 33.55L}, {77, 85, 44, 36.25L}};
/// A tilted plane: a point (x, y, z) of it has a x + b y + c z = 1.
constexpr long double plane_a = 0.21L, plane_b = -0.13L, plane_c = 0.55L;

using DepthAt = std::function<long double(long double, long double)>;  // of a ray (u, v, 1)

long double planar_at(long double u, long double v) {
    return 1 / (plane_a * u + plane_b * v + plane_c);
}
long double range_at(long double u, long double v) {
    return planar_at(u, v) * std::sqrt(u * u + v * v + 1);
}

/// How a lens shows the ray (u, v): k1 and k2 alone.
struct Bent {
    long double k1 = 0, k2 = 0;
    long double radial(long double u, long double v) const {
        const long double r2 = u * u + v * v;
        return 1 + r2 * (k1 + r2 * k2);
    }
};

/// The ray that is shown at (u, v), by trying.
std::pair<long double, long double> ray_shown_at(const Bent& lens, long double u, long double v) {
    long double x = u, y = v;
    for (int k = 0; k < 30; ++k) {
        const long double radial = lens.radial(x, y);
        x = u / radial;
        y = v / radial;
    }
    return {x, y};
}

std::uint16_t code_of(const Lens4& camera, const Bent& lens, const DepthAt& depth, int x, int y) {
    const auto [u, v] = ray_shown_at(lens, (x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy);
    return static_cast<std::uint16_t>(std::floor(depth(u, v) / unit + 0.5L));
}

std::string camera_json(const Lens4& camera) {
    char text[160];
    std::snprintf(text, sizeof text, R"({"fx": %.17Lg, "fy": %.17Lg, "cx": %.17Lg, "cy": %.17Lg})", camera.fx,
                  camera.fy, camera.cx, camera.cy);
    return text;
}

std::string scene_json(const std::string& camera, const std::string& semantics,
                       const std::string& more = "") {
    return R"({"touchable_scene": 1, "width": 96, "height": 72, "rate": [30, 1], "metres_per_unit": 1,)" +
           (camera.empty() ? std::string() : "\"camera\": " + camera + ",") +
           R"("depth": {"coding": "metric", "scale": 0.0001, "invalid": [0], "near": 0.1, "far": 6, "semantics": ")" +
           semantics + R"("}, "height_map": {"max": 0.01, "units": "world"},
           "folder": {"depth": "d%d.png", "colour": "c%d.png", "haptic": "t%d.png", "height": "h%d.png")" +
           more + "}}";
}

/// Pictures of the plane by the cameras of the frames; of others each pixel says which it is.
void write_plane(const TemporaryFolder& folder, const Bent& lens, const DepthAt& depth) {
    for (int n = 0; n < 3; ++n) {
        const Image codes = made_image(
                        wide, high, 2, 1,
                        [&](int x, int y, int) { return code_of(of_frames[n], lens, depth, x, y); }),
                    colour = made_image(wide, high, 1, 3,
                                        [&](int x, int y, int c) {
                                            return c == 0 ? x : c == 1 ? y : 200 + n;
                                        }),
                    height = made_image(wide, high, 1, 1, [](int x, int y, int) { return 7 * x + 11 * y; });
        const std::string number = std::to_string(n) + ".png";
        for (const auto& [name, image] :
             {std::pair{"d", &codes}, {"c", &colour}, {"t", &colour}, {"h", &height}})
            ASSERT_EQ(message(write_png(folder / (name + number), image->view())), "");
        write_bytes(folder / ("k" + std::to_string(n) + ".json"), camera_json(of_frames[n]));
    }
}

const std::string with_cameras = R"(, "cameras": "k%d.json")";

std::vector<std::string> notes_with(const ClipReader& reader, const std::string& words) {
    std::vector<std::string> found;
    for (const std::string& note : reader.notes())
        if (note.find(words) != std::string::npos) found.push_back(note);
    return found;
}

/// The place in the stored picture of a pixel of the clip.
std::pair<long double, long double> stored_place(const Lens4& camera, const Bent& lens, int x, int y) {
    const long double u = (x - of_clip.cx) / of_clip.fx, v = (y - of_clip.cy) / of_clip.fy;
    const long double radial = lens.radial(u, v);
    return {camera.fx * u * radial + camera.cx, camera.fy * v * radial + camera.cy};
}

void expect_twin(const std::vector<RawFrame>& frames, const Bent& lens, const DepthAt& depth) {
    int beyond = 0;
    for (int n = 0; n < 3; ++n)
        for (int y = 0; y < high; ++y)
            for (int x = 0; x < wide; ++x) {
                const RawFrame& frame = frames[static_cast<std::size_t>(n)];
                const auto [column, row] = stored_place(of_frames[n], lens, x, y);
                const long double sx = std::floor(column + 0.5L), sy = std::floor(row + 0.5L);
                const auto is_tie = [](long double at) {
                    return std::abs(at + 0.5L - std::round(at + 0.5L)) < 1e-9L;
                };
                if (is_tie(column) || is_tie(row)) continue;
                if (sx < 0 || sy < 0 || sx >= wide || sy >= high) {
                    ++beyond;
                    ASSERT_EQ(frame.depth.sample(x, y), 0) << n << ": " << x << ", " << y;
                    continue;
                }
                const int from_x = static_cast<int>(sx), from_y = static_cast<int>(sy);
                ASSERT_EQ(frame.depth.sample(x, y), code_of(of_frames[n], lens, depth, from_x, from_y))
                    << n << ": " << x << ", " << y;
                for (const PlaneView* plane : {&frame.colour, &frame.haptic}) {
                    ASSERT_EQ(plane->sample(x, y, 0), from_x);
                    ASSERT_EQ(plane->sample(x, y, 1), from_y);
                    ASSERT_EQ(plane->sample(x, y, 2), 200 + n);
                }
                ASSERT_EQ(frame.height.sample(x, y), (7 * from_x + 11 * from_y) & 255);
            }
    EXPECT_GT(beyond, 100) << "a wider view than what was stored";
}

using FrameCameras = FolderTest;

TEST_F(FrameCameras, MatchPlainTwin) {
    for (const bool is_range : {false, true})
        for (const Bent lens : {Bent{}, Bent{-0.2L, 0.05L}}) {
            const TemporaryFolder fresh;
            const DepthAt depth = is_range ? range_at : planar_at;
            write_plane(fresh, lens, depth);
            std::string camera = camera_json(of_clip);
            if (lens.k1 != 0) camera.insert(camera.size() - 1, R"(, "distortion": [-0.2, 0.05, 0, 0])");
            write_bytes(fresh / "scene.json",
                        scene_json(camera, is_range ? "range" : "planar", with_cameras));
            auto reader = must(open_clip(fresh.path()));
            EXPECT_EQ(reader->scene().camera, (Camera{80, 81, 46.5, 36.25}));
            const auto frames = must(read_all(*reader));
            ASSERT_EQ(frames.size(), 3U);
            expect_twin(frames, lens, depth);
            ASSERT_EQ(message(reader->seek(1)), "");
            const auto second = reader->next();
            ASSERT_TRUE(second && *second);
            EXPECT_TRUE(same_frame(**second, frames.at(1))) << "whatever frame came before";
        }
}

/// As far off the plane as half a stored pixel across and down is.
TEST_F(FrameCameras, KeepSurfaceWithinHalfPixel) {
    for (const bool is_range : {false, true}) {
        const TemporaryFolder fresh;
        const DepthAt depth = is_range ? range_at : planar_at;
        write_plane(fresh, {}, depth);
        write_bytes(fresh / "scene.json",
                    scene_json(camera_json(of_clip), is_range ? "range" : "planar", with_cameras));
        const auto frames = must(read_clip(fresh.path()));
        const auto u_of = [](const Lens4& camera, long double x) { return (x - camera.cx) / camera.fx; };
        const auto v_of = [](const Lens4& camera, long double y) { return (y - camera.cy) / camera.fy; };
        long double worst = 0, worst_unmoved = 0;
        for (int n = 1; n < 3; ++n)
            for (int y = 0; y < high; ++y)
                for (int x = 0; x < wide; ++x) {
                    const int code = frames.at(static_cast<std::size_t>(n)).depth.sample(x, y);
                    if (code == 0) continue;
                    const long double truth = depth(u_of(of_clip, x), v_of(of_clip, y));
                    const auto [column, row] = stored_place(of_frames[n], {}, x, y);
                    long double allowed = 0.5L * unit + 1e-9L;
                    for (const long double dx : {-0.5L, 0.5L})
                        for (const long double dy : {-0.5L, 0.5L})
                            allowed = std::max(allowed, 0.5L * unit + 1e-6L +
                                                            std::abs(depth(u_of(of_frames[n], column + dx),
                                                                           v_of(of_frames[n], row + dy)) -
                                                                     truth));
                    ASSERT_LE(std::abs(unit * code - truth), allowed) << n << ": " << x << ", " << y;
                    worst = std::max(worst, std::abs(unit * code - truth));
                    const long double stored = depth(u_of(of_frames[n], x), v_of(of_frames[n], y));
                    worst_unmoved = std::max(worst_unmoved, std::abs(stored - truth));
                }
        EXPECT_LT(4 * worst, worst_unmoved) << "it is worth it";
    }
}

TEST_F(FrameCameras, ChangeNothingIfEqual) {
    write_plane(folder, {}, planar_at);
    write_bytes(folder / "scene.json", scene_json(camera_json(of_clip), "planar"));
    const auto plain = must(read_clip(folder / "scene.json"));
    for (int n = 0; n < 3; ++n)
        write_bytes(folder / ("k" + std::to_string(n) + ".json"), camera_json(of_clip));
    for (const std::string& camera : {camera_json(of_clip), std::string()}) {
        write_bytes(folder / "scene.json", scene_json(camera, "planar", with_cameras));
        auto reader = must(open_clip(folder.path()));
        EXPECT_EQ(reader->scene().camera, (Camera{80, 81, 46.5, 36.25}));
        EXPECT_TRUE(notes_with(*reader, "cameras differ").empty());
        const auto frames = must(read_all(*reader));
        ASSERT_EQ(frames.size(), plain.size());
        for (std::size_t n = 0; n < frames.size(); ++n)
            EXPECT_TRUE(same_frame(frames.at(n), plain.at(n))) << n;
        const auto& inputs = reader->inputs();
        EXPECT_NE(std::find(inputs.begin(), inputs.end(), folder / "k2.json"), inputs.end())
            << "an output must not replace it";
    }
}

TEST_F(FrameCameras, NoteHowManyAndFar) {
    write_plane(folder, {}, planar_at);
    write_bytes(folder / "k1.json", camera_json({80, 81, 46.5L + 3, 36.25L - 4}));
    write_bytes(folder / "k2.json", camera_json({80, 81, 46.5L + 0.3L, 36.25L}));
    write_bytes(folder / "scene.json", scene_json(camera_json(of_clip), "planar", with_cameras));
    auto reader = must(open_clip(folder.path()));
    const auto said = notes_with(*reader, "cameras differ");
    ASSERT_EQ(said.size(), 1U);
    EXPECT_TRUE(
        has_words(said.front(), "1 of 3 frames are brought onto the clip's camera, by up to 5 pixels"));
    write_bytes(folder / "k1.json", camera_json(of_clip));
    reader = must(open_clip(folder.path()));
    EXPECT_EQ(notes_with(*reader, "cameras differ").at(0),
              "cameras differ by at most 0.3 pixels: every pixel stays where it is");
}

TEST_F(FrameCameras, GiveMedianAsSceneCamera) {
    write_plane(folder, {}, planar_at);
    write_bytes(folder / "scene.json", scene_json("", "planar", with_cameras));
    auto reader = must(open_clip(folder.path()));
    EXPECT_EQ(reader->scene().camera, (Camera{80, 83, 46.5, 36.25})) << "of each number alone";
    const std::vector<Camera> two{{1, 8, 3, 4}, {5, 6, 7, 2}};
    EXPECT_EQ(median_camera(two), (Camera{1, 6, 3, 2})) << "the lower";
}

TEST_F(FrameCameras, AreAppliedInConvertedClips) {
    write_plane(folder, {}, planar_at);
    write_bytes(folder / "scene.json", scene_json(camera_json(of_clip), "planar", with_cameras));
    const auto [reader, frames] = must_read(open_clip(folder.path()));
    const Scene& scene = reader->scene();
    write_frames(create_clip(folder / "packed.mkv", scene, exact_clip), frames);
    write_frames(create_image_folder(folder / "unpacked", scene, Existing::keep), frames);
    for (const char* name : {"packed.mkv", "unpacked"}) {
        auto again = must(open_clip(folder / name));
        EXPECT_TRUE(notes_with(*again, "cameras").empty()) << name;
        const auto back = must(read_all(*again));
        ASSERT_EQ(back.size(), 3U);
        for (std::size_t n = 0; n < 3; ++n) EXPECT_TRUE(same_frame(back.at(n), frames.at(n))) << name << n;
    }
}

TEST_F(FrameCameras, ArePairedByNearestTime) {
    write_plane(folder, {}, planar_at);
    for (const auto& [from, to] :
         {std::pair{"d0.png", "d1.10.png"}, {"d1.png", "d1.20.png"}, {"d2.png", "d1.30.png"}})
        std::filesystem::rename(folder / from, folder / to);
    std::filesystem::create_directory(folder / "k");
    for (int n = 0; n < 3; ++n)
        write_bytes(folder / ("k/x1." + std::to_string(11 + 10 * n) + ".pincam"),
                    "96 72 " + std::to_string(80 + n) + " 81 46.5 36.25\n");
    write_bytes(folder / "k/x1.16.pincam", "96 72 500 500 46.5 36.25\n");
    write_bytes(folder / "cameras.txt", "1.11 k/x1.11.pincam\n1.21 k/x1.21.pincam\n1.31 k/x1.31.pincam\n");
    for (const char* cameras : {"k/x*.pincam", "cameras.txt"}) {
        write_bytes(folder / "scene.json",
                    R"({"touchable_scene": 1, "width": 96, "height": 72, "metres_per_unit": 1,
                        "depth": {"coding": "metric", "scale": 0.0001, "invalid": [0]},
                        "folder": {"depth": "d*.png", "cameras": ")" +
                        std::string(cameras) + "\"}}");
        auto reader = must(open_clip(folder.path()));
        EXPECT_EQ(reader->scene().camera, (Camera{81, 81, 46.5, 36.25})) << "500 is of no frame's time";
    }
}

TEST_F(FrameCameras, RefuseInvalidInOneLine) {
    write_plane(folder, {}, planar_at);
    const auto refused = [&](const std::string& json) {
        write_bytes(folder / "scene.json", json);
        const std::string words = message(open_clip(folder.path()));
        EXPECT_EQ(words.find('\n'), std::string::npos) << words;
        return words;
    };
    const std::string camera = camera_json(of_clip);
    const auto with = [&](const std::string& cameras) {
        return scene_json(camera, "planar", R"(, "cameras": )" + cameras);
    };
    EXPECT_TRUE(
        has_words(refused(with(R"("k0.json")")), "folder.cameras is \"k0.json\": must be a file for each"));
    EXPECT_TRUE(has_words(refused(with(R"({"files": "k%d.json", "first": 1})")),
                          "k3.json (cameras, frame 2): is missing"));
    EXPECT_TRUE(has_words(refused(with(R"({"files": "k*.json", "step": 2})")), "folder.cameras.step is 2"));
    EXPECT_TRUE(has_words(refused(with("3")), "folder.cameras is 3: must be a string"));
    EXPECT_TRUE(has_words(refused(scene_json("", "planar")), "camera is missing"));
    std::string full = with(R"("k%d.json")");
    full.replace(full.find(R"("invalid": [0], "near": 0.1, "far": 6)"), 37,
                 R"("near_is": "high", "near": 1, "far": 6)");
    full.replace(full.find(R"("metric", "scale": 0.0001)"), 25, R"("linear", "bits": 16)");
    EXPECT_TRUE(has_words(refused(full), "depth.invalid is []: must have a code that means no depth"));
    write_bytes(folder / "k1.json", R"({"fx": "much"})");
    EXPECT_TRUE(has_words(refused(with(R"("k%d.json")")), "k1.json: has no camera"));
    EXPECT_TRUE(has_words(refused(with(R"("k%d.json")")), "(camera, frame 1)"));
    write_bytes(folder / "k1.json", R"({"fx": 90, "fy": 90, "cx": 1e9, "cy": 3})");
    EXPECT_TRUE(has_words(refused(with(R"("k%d.json")")), "k1.json (camera, frame 1): its cx and cy"));
    write_bytes(folder / "alone.json", scene_json("", "planar", with_cameras));
    EXPECT_TRUE(has_words(message(open_clip(folder / "d0.png", folder / "alone.json")), "camera is missing"));
}

TEST_F(FrameCameras, RefuseDisparities) {
    const auto scene = parse_scene(R"({"touchable_scene": 1, "width": 8, "height": 6,
        "camera": {"fx": 9, "fy": 9, "cx": 3, "cy": 2}, "depth": {"coding": "disparity", "baseline": 1},
        "folder": {"depth": "d%d.png", "cameras": "k%d.json"}})",
                                   "scene");
    EXPECT_TRUE(is_refused(scene, "must be left out, because depth.coding is disparity"));
}

TEST_F(FrameCameras, SurviveSceneFile) {
    auto scene =
        parse_scene(scene_json("", "range", R"(, "cameras": {"files": "k%d.json", "first": 5})"), "scene");
    ASSERT_EQ(message(scene), "");
    EXPECT_TRUE(scene->unstated.camera);
    const auto again = must(parse_scene(scene_to_json(*scene), "again"));
    EXPECT_TRUE(again.unstated.camera);
    EXPECT_EQ(again.scene.folder->cameras, "k%d.json");
    EXPECT_EQ(again.scene.folder->camera_numbers, (PictureNumbers{5, {}}));
}

}  // namespace
}  // namespace touchable::test
