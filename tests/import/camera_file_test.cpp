#include "engine/formats/source_description.hpp"

#include <gtest/gtest.h>

#include "engine/formats/camera_sidecar.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

CameraFile read(const TemporaryFolder& folder, const std::string& text) {
    write_bytes(folder / "camera.txt", text);
    const auto found = read_camera_file(folder / "camera.txt");
    EXPECT_EQ(message(found), "") << text;
    return found ? *found : CameraFile{};
}

TEST(CameraFiles, AreReadAsProgramsWriteThem) {
    const TemporaryFolder folder;
    const Intrinsics wanted{500, 501, 320.5, 240.25};
    const std::pair<const char*, Intrinsics> files[] = {
        {R"({"fx": 500, "fy": 501, "ppx": 320.5, "ppy": 240.25, "model": "brown"})", wanted},
        {R"({"color": {"width": 8}, "depth": {"intrinsics": {"width": 640, "height": 480, "fx": 500, "fy": 501, "cx": 320.5, "cy": 240.25}}})",
         {500, 501, 320.5, 240.25, 640, 480}},
        {R"({"width": 640, "height": 480, "intrinsic_matrix": [500, 0, 0, 0, 501, 0, 320.5, 240.25, 1]})",
         {500, 501, 320.5, 240.25, 640, 480}},
        {R"({"K": [500, 0, 320.5, 0, 501, 240.25, 0, 0, 1]})", wanted},
        {R"({"K": [[500, 0, 320.5], [0, 501, 240.25], [0, 0, 1]], "w": 640, "h": 480})",
         {500, 501, 320.5, 240.25, 640, 480}},
        {"image_width: 640\nimage_height: 480\ncamera_name: head\ncamera_matrix:\n  rows: 3\n  cols: 3\n  "
         "data: [500, 0, "
         "320.5, 0, 501, 240.25, 0, 0, 1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  rows: "
         "1\n  data: [1, 2, 3]\n",
         {500, 501, 320.5, 240.25, 640, 480}},
        {"header:\n  seq: 0\nheight: 480\nwidth: 640\nK: [500.0, 0.0, 320.5, 0.0, 501.0, 240.25, 0.0, 0.0, "
         "1.0]\nR: [1.0]\n",
         {500, 501, 320.5, 240.25, 640, 480}},
        {"%YAML:1.0\nK: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n   data: [500, 0, 320.5, 0, 501, "
         "240.25, 0, 0, 1]\n",
         wanted},
        {"\xef\xbb\xbf{\"fx\": 500, \"fy\": 501}", {500, 501}},
        {"500 0 320.5\n0 501 240.25\n0 0 1\n", wanted},
        {"5e2 0 320.5 0\n0 501 240.25 0\n0 0 1 0\n0 0 0 1\n", wanted},
        {"640 480 500 501 320.5 240.25\n", {500, 501, 320.5, 240.25, 640, 480}},
        {"# Camera list\n1 PINHOLE 640 480 500 501 321 240.75\n", {500, 501, 320.5, 240.25, 640, 480}},
        {"1 SIMPLE_RADIAL 640 480 500 321 240.75 0.1\n", {500, 500, 320.5, 240.25, 640, 480}}};
    for (const auto& [text, intrinsics] : files) EXPECT_EQ(read(folder, text).intrinsics, intrinsics) << text;
    const CameraFile stereo = read(folder,
                                   "cam0=[500 0 320.5; 0 501 240.25; 0 0 1]\ncam1=[1 0 2; 0 1 3; 0 0 1]\n"
                                   "doffs=12.5\nbaseline=193.001\nwidth=640\nheight=480\nndisp=290\n");
    EXPECT_EQ(stereo.intrinsics, (Intrinsics{500, 501, 320.5, 240.25, 640, 480}));
    EXPECT_EQ(stereo.baseline, 0.193001);
    EXPECT_EQ(stereo.offset, 12.5);
}

TEST(CameraFiles, WithoutACameraAreRefused) {
    const TemporaryFolder folder;
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
        EXPECT_TRUE(is_refused(read_camera_file(folder / "camera.txt"), "has no camera")) << text;
        EXPECT_EQ(camera_beside({.folder = folder.path()}).camera, std::nullopt);
    }
    write_bytes(folder / "camera.txt", "640 480 500 501 3200 240");
    EXPECT_TRUE(is_refused(read_camera_file(folder / "camera.txt"), "principal point"));
    EXPECT_TRUE(is_refused(read_camera_file(folder.path()), "is a folder; right would be a camera's file"));
}

TEST(CameraFiles, ThatOfDepthIsTakenBeforeOthers) {
    const TemporaryFolder folder;
    write_bytes(folder / "camera_colour.json", R"({"fx": 1, "fy": 1})");
    write_bytes(folder / "intrinsics_depth.txt", "500 0 320.5\n0 501 240.25\n0 0 1\n");
    write_bytes(folder / "groundtruth.txt", "1 0 1\n0 1 1\n0 0 1\n");
    EXPECT_EQ(camera_beside({.folder = folder.path()}).file, folder / "intrinsics_depth.txt");
}

}  // namespace
}  // namespace touchable::test
