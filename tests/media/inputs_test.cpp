#include <gtest/gtest.h>

#include <set>

#include "engine/media/image_file.hpp"
#include "engine/scene/scene_file.hpp"
#include "tests/media/clip_fixture.hpp"
#include "tests/real_data.hpp"

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

TEST(Inputs, WhatLiesBesideADepthkitVideo) {
    const std::filesystem::path data = real_data("depthkit_typing");
    TOUCHABLE_NEEDS_DATA(data);
    EXPECT_EQ(inputs_of(open_clip(data / "Test.mov")),
              (Paths{data / "Test.mov", data / "Test.Metadata.asset"}));
}

}  // namespace
}  // namespace touchable::test
