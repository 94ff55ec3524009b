#include <gtest/gtest.h>

#include "engine/media/image_file.hpp"
#include "engine/scene/scene_file.hpp"
#include "tests/media/clip_fixture.hpp"

namespace touchable::test {
namespace {

/// A picture of depth, 20 x 10, with a hole.
PlaneView write_picture(const std::filesystem::path& file, Samples& memory, int bytes = 2, int channels = 1) {
    const PlaneView plane = test_plane(memory, 20, 10, bytes, channels, bytes == 2 ? 3000 : 200, 5, true);
    memory[0] = memory[1] = 0;
    EXPECT_EQ(message(write_png(file, plane)), "");
    return plane;
}

TEST(BarePicture, ACameraIsEnough) {
    const TemporaryFolder folder;
    for (const int bytes : {1, 2}) {
        Samples memory;
        const PlaneView plane = write_picture(folder / "my.png", memory, bytes);
        const PictureCamera camera{.fx = 30, .fy = 31, .cx = {}, .cy = {}, .metres_per_code = 0.0005};
        auto reader = open_clip(folder / "my.png", std::nullopt, camera);
        ASSERT_EQ(message(reader), "");
        const Scene& scene = (*reader)->scene();
        EXPECT_EQ(scene.camera.fx, 30);
        EXPECT_EQ(scene.camera.fy, 31);
        EXPECT_EQ(scene.camera.cx, 9.5);
        EXPECT_EQ(scene.camera.cy, 4.5);
        EXPECT_EQ(scene.metres_per_unit, 1);
        EXPECT_FALSE(scene.depth.is_valid(0));
        EXPECT_EQ(scene.depth.depth(1000), 0.5);
        EXPECT_FALSE(scene.far_from_frames);
        const auto frames = read_all(**reader);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 1U);
        EXPECT_TRUE(same_plane(frames->at(0).depth, plane));
        EXPECT_EQ((*reader)->inputs(), std::vector{folder / "my.png"});
    }
}

TEST(BarePicture, ASceneFileDescribesItWhateverFolderItSpeaksOf) {
    const TemporaryFolder folder;
    Samples memory;
    const PlaneView plane = write_picture(folder / "my.png", memory);
    Scene scene = small_scene(20, 10, 16);
    for (const bool speaks : {false, true}) {
        if (speaks) scene.folder = FolderSource{.depth = "d%d.png", .colour = "", .haptic = "", .height = ""};
        write_bytes(folder / "scene.json", scene_to_json(scene));
        auto reader = open_clip(folder / "my.png", folder / "scene.json");
        ASSERT_EQ(message(reader), "");
        EXPECT_TRUE(same_plane(read_all(**reader)->at(0).depth, plane));
    }
}

TEST(BarePicture, WithoutAnyTheTemplateThatIsPrintedWorks) {
    const TemporaryFolder folder;
    Samples memory;
    write_picture(folder / "my.png", memory);
    const std::string error = message(open_clip(folder / "my.png"));
    EXPECT_NE(error.find("my.png: is a picture without a scene file: give --intrinsics"), std::string::npos);
    EXPECT_EQ(error.find('\n'), std::string::npos);
    const auto begin = error.find('{');
    ASSERT_NE(begin, std::string::npos) << error;
    write_bytes(folder / "scene.json", error.substr(begin));
    EXPECT_EQ(message(open_clip(folder.path())), "");
    EXPECT_EQ(message(open_clip(folder / "my.png", folder / "scene.json")), "");
}

TEST(BarePicture, WhatMakesNoSenseIsRefused) {
    const TemporaryFolder folder;
    Samples memory;
    write_picture(folder / "my.png", memory);
    write_picture(folder / "colour.png", memory, 1, 3);
    write_picture(folder / "100%.png", memory);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(8, 8), 1, {})), "");
    const auto with = [&](const char* name, double fx, double unit) {
        const PictureCamera camera{.fx = fx, .fy = 30, .cx = {}, .cy = {}, .metres_per_code = unit};
        return message(open_clip(folder / name, std::nullopt, camera));
    };
    EXPECT_NE(with("my.png", 0, 0.001).find("--intrinsics, --depth-unit: camera.fx is 0"), std::string::npos);
    EXPECT_NE(with("my.png", 30, -1).find("depth.scale is -1"), std::string::npos);
    EXPECT_NE(with("colour.png", 30, 0.001).find("is in colour"), std::string::npos);
    EXPECT_NE(message(open_clip(folder / "colour.png")).find("is in colour"), std::string::npos);
    EXPECT_NE(with("100%.png", 30, 0.001).find("rename it"), std::string::npos);
    EXPECT_NE(with("clip.mkv", 30, 0.001).find("is no PNG or JPEG"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
