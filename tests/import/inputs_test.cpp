#include <gtest/gtest.h>

#include <set>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/real_data.hpp"
#include "tests/video/quicktime.hpp"

namespace touchable::test {
namespace {

using Paths = std::set<std::filesystem::path>;

Paths inputs_of(const Result<std::unique_ptr<ClipReader>>& reader) {
    EXPECT_EQ(message(reader), "");
    if (!reader) return {};
    return {(*reader)->inputs().begin(), (*reader)->inputs().end()};
}

TEST(Inputs, AClipAndTheSceneFileThatDescribesIt) {
    const TemporaryFolder folder;
    const auto clip = folder / "clip.mkv", described = folder / "scene.json";
    ASSERT_EQ(message(write_clip(clip, small_scene(40, 30), 2, {})), "");
    write_bytes(described, scene_to_json(small_scene(40, 30)));
    EXPECT_EQ(inputs_of(open_clip(clip)), Paths{clip});
    EXPECT_EQ(inputs_of(open_clip(clip, described)), (Paths{clip, described}));
}

TEST(Inputs, EveryPictureOfAFolderHoweverItIsOpened) {
    const TemporaryFolder folder;
    Scene scene = small_scene(8, 6);
    scene.folder = FolderSource{.depth = "d%d.png", .colour = "c%d.png", .haptic = "", .height = ""};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    Paths all{folder / "scene.json"};
    Samples memory;
    for (int n = 0; n < 3; ++n)
        for (const auto& [name, channels] : {std::pair{"d", 1}, {"c", 3}}) {
            const auto file = folder / (name + std::to_string(n) + ".png");
            const PlaneView plane = test_plane(memory, 8, 6, 1, channels, 255, 1, true);
            ASSERT_EQ(message(write_png(file, plane)), "");
            all.insert(file);
        }
    EXPECT_EQ(inputs_of(open_clip(folder.path())), all);
    EXPECT_EQ(inputs_of(open_clip(folder / "scene.json")), all);
    EXPECT_EQ(inputs_of(open_clip(folder.path(), folder / "scene.json")), all);
}

TEST(Inputs, WhatLiesBesideAVideoOfDepthkit) {
    const TemporaryFolder folder;
    Image picture{8, 12, 1, 3, std::vector<std::uint8_t>(8 * 12 * 3, 90)};
    write_quicktime(folder / "Take 1.mov", {picture, picture}, {24, 1});
    write_bytes(folder / "Take 1.Metadata.asset",
                "format: perpixel\ntextureWidth: 8\ntextureHeight: 12\nperspectives:\n- depthImageSize: {x: "
                "8, y: 6}\n"
                "  depthPrincipalPoint: {x: 4, y: 3}\n  depthFocalLength: {x: 7, y: 7}\n  farClip: 1.5\n"
                "  nearClip: 0.5\n  crop: {x: 0, y: 0, z: 1, w: 1}\n");
    EXPECT_EQ(inputs_of(open_clip(folder / "Take 1.mov")),
              (Paths{folder / "Take 1.mov", folder / "Take 1.Metadata.asset"}));
}

TEST(Inputs, WhatLiesBesideADepthkitVideo) {
    const std::filesystem::path data = real_data("depthkit_typing");
    TOUCHABLE_NEEDS_DATA(data);
    EXPECT_EQ(inputs_of(open_clip(data / "Test.mov")),
              (Paths{data / "Test.mov", data / "Test.Metadata.asset"}));
}

}  // namespace
}  // namespace touchable::test
