// The text of an MPEG-4 scene beside the pictures that it names.
#include "engine/formats/formats_read.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

#include "engine/formats/formats_written.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/picture/encoded_picture.hpp"

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

TEST_F(SceneTextClips, ThePapersFourPicturesOpen) {
    const std::string text = scene_with(R"(ImageTexture { url "depth.png" })");
    EXPECT_EQ(message(open("\xef\xbb\xbf" + text)), "") << "with a byte order mark";
    const auto clip = open(text);
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
    EXPECT_TRUE(is_noted(**clip, "haptic is stored as mjpeg"));
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
        ASSERT_NE(text.find(was), std::string::npos) << was;
        write_bytes(file, text.replace(text.find(was), was.size(), is));
    }
    TemporaryFolder folder;
    std::filesystem::path file = folder / "my scene.bt";
    Scene scene = small_scene(23, 14, 12);
};

TEST_F(WrittenSceneText, ComesBackWithAllThatNodesCannotSay) {
    ASSERT_EQ(write(), "");
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        names.push_back(entry.path().filename().string());
    std::ranges::sort(names);
    EXPECT_EQ(names, (std::vector<std::string>{"my scene.bt", "my scene_colour.png", "my scene_depth.png",
                                               "my scene_haptic.png", "my scene_height.png"}));
    const auto clip = open_clip(file);
    ASSERT_EQ(message(clip), "");
    EXPECT_FALSE(is_noted(**clip, "its nodes say another"));
    EXPECT_TRUE(is_noted(**clip, "guessed: the camera"));
    Scene read = (*clip)->scene();
    ASSERT_TRUE(read.folder);
    read.folder.reset();
    EXPECT_EQ(scene_to_json(read), scene_to_json(scene));
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 1U);
    EXPECT_TRUE(same_frame(frames->front(), test_frame(scene, 0, all_planes)));
}

TEST_F(WrittenSceneText, NothingThatIsThereIsReplacedUnasked) {
    write_bytes(folder / "my scene_height.png", "somebody's");
    EXPECT_NE(write().find("my scene_height.png"), std::string::npos);
    EXPECT_EQ(read_bytes(folder / "my scene_height.png"), "somebody's");
    EXPECT_FALSE(std::filesystem::exists(file) || std::filesystem::exists(folder / "my scene_depth.png"));
    EXPECT_EQ(write(Existing::replace), "");
    EXPECT_EQ(message(open_clip(file)), "");
    for (const char* name : {"a%d.bt", "a*.bt", "od:7.bt"}) {
        file = folder / name;
        EXPECT_NE(write(), "") << name;
        EXPECT_FALSE(std::filesystem::exists(file));
    }
}

TEST_F(WrittenSceneText, NodesThatWereEditedStandAndThatIsSaid) {
    ASSERT_EQ(write(), "");
    change("farPlane 200", "farPlane 300");  // of its prototype's values none is 200
    change("maxHeight 0", "maxHeight 2");
    const auto clip = open_clip(file);
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(
        **clip, "its nodes say another camera, other planes or ranges than its WorldInfo T3D_SCENE"));
    EXPECT_EQ((*clip)->scene().depth.far, 300);
    EXPECT_EQ((*clip)->scene().height_coding.max_height, 2);
    EXPECT_EQ((*clip)->scene().depth.semantics, DepthSemantics::planar);
    change("farPlane 300", "farPlane 5");
    EXPECT_TRUE(is_refused(open_clip(file), "my scene.bt: depth.near"));
}

TEST_F(WrittenSceneText, OnlyPicturesThatNodesNameAreRead) {
    ASSERT_EQ(write(), "");
    const std::string whole = read_bytes(file);
    change(R"("  \"interpolation)",
           R"("  \"video\": {\"depth\": \"../elsewhere.mkv\"}," "  \"interpolation)");
    const auto clip = open_clip(file);
    ASSERT_EQ(message(clip), "");
    EXPECT_FALSE((*clip)->scene().video);
    EXPECT_EQ((*clip)->scene().folder->depth, "my scene_depth.png");
    write_bytes(file, whole);
    change(R"(\"touchable_scene\": 1,)", R"(\"touchable_scene\": 99,)");
    EXPECT_TRUE(is_refused(open_clip(file), "my scene.bt: its WorldInfo T3D_SCENE: touchable_scene"));
}

TEST_F(WrittenSceneText, PicturesThatAreMissingOrOthersAreNamed) {
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

/// Grey in JPEG is read as depth, and what that does to it is said.
TEST_F(SceneTextClips, DepthInJpegIsReadAndSaid) {
    write_bytes(folder / "depth.jpg",
                encoded("mjpeg", AV_PIX_FMT_YUVJ420P, text_wide, text_high, [](AVFrame& frame) {
                    for (int plane = 0; plane < 3; ++plane)
                        for (int y = 0; y < text_high / (plane > 0 ? 2 : 1); ++y)
                            std::memset(frame.data[plane] + y * frame.linesize[plane], plane > 0 ? 128 : 100,
                                        text_wide / (plane > 0 ? 2 : 1));
                }));
    const auto clip = open(scene_with(R"(ImageTexture { url "depth.jpg" })"));
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "depth is stored as mjpeg, which changes values"));
    EXPECT_EQ(read_all(**clip)->front().depth.sample(3, 1), 100);
}

TEST_F(SceneTextClips, NothingOutsideItsFolderIsRead) {
    for (const std::string url :
         {"/etc/depth.png", "../depth.png", "a/../../depth.png", "http://example.org/depth.png", ""})
        EXPECT_TRUE(is_refused(open(scene_with("ImageTexture { url \"" + url + "\" }")),
                               "must be a file beside this text"))
            << url;
    EXPECT_TRUE(is_refused(open(scene_with("MovieTexture { url [11] }")), "is object 11 of an MP4 file"));
}

TEST_F(SceneTextClips, ErrorsNameFileLineAndColumn) {
    EXPECT_EQ(message(open("Shape {\n  appearance Nothing {} }")),
              (folder / "scene.bt").string() +
                  ": line 2, column 14: \"Nothing\" is no node that a touchable clip has");
    EXPECT_TRUE(is_refused(open(scene_with(R"(ImageTexture { url "none.png" })")), "none.png"));
    EXPECT_TRUE(
        is_refused(open(scene_with(R"(MovieTexture { url "depth.png" })")), "depth and colour must both be"));
}

}  // namespace
}  // namespace touchable::test
