// The text of an MPEG-4 scene beside the pictures that it names.
#include "engine/import/scene_text_clip.hpp"

#include <gtest/gtest.h>

#include <cstdint>

#include "engine/frame/stored_code.hpp"
#include "engine/import/open_clip.hpp"
#include "engine/picture/image_file.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {

constexpr int text_wide = 12, text_high = 8;

Image painted(int channels, int factor) {
    Image image{text_wide, text_high, 1, channels, {}};
    for (int k = 0; k < text_wide * text_high * channels; ++k)
        image.samples.push_back(static_cast<std::uint8_t>(k * factor));
    return image;
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
        ASSERT_TRUE(write_png(folder / "depth.png", painted(1, 2).view()).ok());
        ASSERT_TRUE(write_png(folder / "colour.png", painted(3, 3).view()).ok());
        ASSERT_TRUE(write_png(folder / "haptic.png", painted(3, 5).view()).ok());
        ASSERT_TRUE(write_png(folder / "height.png", painted(1, 7).view()).ok());
    }
    Result<std::unique_ptr<ClipReader>> open(const std::string& text) {
        write_bytes(folder / "scene.bt", text);
        return open_clip(folder / "scene.bt");
    }
    TemporaryFolder folder;
};

TEST_F(SceneTextClips, ThePapersFourPicturesOpen) {
    const auto clip = open(scene_with(R"(ImageTexture { url "depth.png" })"));
    ASSERT_EQ(message(clip), "");
    const Scene& scene = (*clip)->scene();
    EXPECT_EQ(scene.camera, camera_from_focal_length(6.983, 0.5, text_wide, text_high));
    EXPECT_EQ(scene.depth.near, 10);
    EXPECT_EQ(scene.depth.far, 200);
    EXPECT_TRUE(scene.depth.near_is_high);
    EXPECT_EQ(scene.haptic.static_friction.min, 0.2);
    EXPECT_EQ(scene.height_coding.max_height, 1);
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 1);
    const RawFrame& frame = frames->front();
    EXPECT_EQ(frame.depth.sample(3, 1), painted(1, 2).view().sample(3, 1));
    EXPECT_EQ(frame.height.sample(5, 2), painted(1, 7).view().sample(5, 2));
    EXPECT_EQ(frame.haptic.row(2)[7], painted(3, 5).view().row(2)[7]);
    EXPECT_EQ(frame.colour.row(2)[7], painted(3, 3).view().row(2)[7]);
    EXPECT_EQ((*clip)->inputs().back(), folder / "scene.bt");
}

/// The paper's example has its haptic picture in JPEG.
TEST_F(SceneTextClips, AHapticPictureInJpegIsReadAndSaid) {
    std::filesystem::copy_file(
        std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds/jpeg_depth/gdepth.jpg",
        folder / "haptic.jpg");
    const auto clip = open(scene_with(R"(ImageTexture { url "depth.png" })", "haptic.jpg"));
    ASSERT_EQ(message(clip), "");
    bool is_said = false;
    for (const std::string& note : clip_notes(**clip))
        is_said = is_said || note.find("haptic is stored as mjpeg") != std::string::npos;
    EXPECT_TRUE(is_said);
    EXPECT_EQ(message(read_all(**clip)), "");
}

/// The pictures that a text names are pictures like any other to a scene file.
TEST_F(SceneTextClips, ASceneFileMayCallItsDepthDisparities) {
    write_bytes(folder / "scene.bt", scene_with(R"(ImageTexture { url "depth.png" })"));
    write_bytes(folder / "other.json", R"({"touchable_scene": 1, "width": 12, "height": 8,
        "camera": {"fx": 9, "fy": 9, "cx": 5.5, "cy": 3.5},
        "depth": {"coding": "disparity", "baseline": 100, "invalid": [0]}})");
    const auto clip = open_clip(folder / "scene.bt", folder / "other.json");
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    const DepthCoding& depth = (*clip)->scene().depth;
    const int stored = painted(1, 2).view().sample(3, 1);
    EXPECT_NEAR(depth.depth(stored_code(frames->front().depth, depth, 3, 1)), 9.0 * 100 / stored, 1e-9);
    ASSERT_FALSE(frames->front().haptic.empty()) << "its other pictures stay";
    // Of a video it is refused by what is true of one.
    write_bytes(folder / "video.mkv", "");
    auto writer = create_clip(folder / "video.mkv", small_scene(text_wide, text_high), exact_clip);
    ASSERT_EQ(message(writer), "");
    ASSERT_EQ(message((*writer)->write(test_frame(small_scene(text_wide, text_high), 0, {}))), "");
    ASSERT_EQ(message((*writer)->finish()), "");
    write_bytes(folder / "scene.bt",
                R"(Shape { geometry Depth { texture MovieTexture { url "video.mkv" } } })");
    EXPECT_NE(message(open_clip(folder / "scene.bt", folder / "other.json"))
                  .find("video.mkv: depth.coding disparity"),
              std::string::npos)
        << message(open_clip(folder / "scene.bt", folder / "other.json"));
}

TEST_F(SceneTextClips, NothingOutsideItsFolderIsRead) {
    for (const std::string url :
         {"/etc/depth.png", "../depth.png", "a/../../depth.png", "http://example.org/depth.png", ""})
        EXPECT_NE(message(open(scene_with("ImageTexture { url \"" + url + "\" }")))
                      .find("must be a file beside this text"),
                  std::string::npos)
            << url;
    EXPECT_NE(message(open(scene_with("MovieTexture { url [11] }"))).find("is object 11 of an MP4 file"),
              std::string::npos);
}

TEST_F(SceneTextClips, ErrorsNameFileLineAndColumn) {
    EXPECT_EQ(message(open("Shape {\n  appearance Nothing {} }")),
              (folder / "scene.bt").string() +
                  ": line 2, column 14: \"Nothing\" is no node that a touchable clip has");
    EXPECT_NE(message(open(scene_with(R"(ImageTexture { url "none.png" })"))).find("none.png"),
              std::string::npos);
    EXPECT_NE(message(open(scene_with(R"(MovieTexture { url "depth.png" })")))
                  .find("depth and colour must both be"),
              std::string::npos);
}

}  // namespace
}  // namespace touchable::test
