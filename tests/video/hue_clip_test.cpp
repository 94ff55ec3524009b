#include <gtest/gtest.h>

#include "engine/clip/clip_file.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"

// Depth as hue in the project's own clips and in folders of images.
namespace touchable::test {
namespace {

Scene hue_scene(int width, int height) {
    Scene scene = small_scene(width, height);
    scene.depth.kind = DepthCodingKind::hue;
    scene.depth.near_is_high = false;
    scene.depth.code_max = DepthCoding::hue_circle;
    scene.depth.least_sum = 77;
    derive_valid_range(scene.depth);
    return scene;
}

RawFrame hue_frame(const Scene& scene, std::int64_t number) {
    auto memory = std::make_shared<Samples>();
    RawFrame frame;
    frame.number = number;
    frame.time_ns = scene.rate.time_ns(number);
    frame.depth = test_plane(*memory, scene.width, scene.height, 1, 3, 255,
                             static_cast<std::uint64_t>(number) + 1, true);
    frame.storage = std::move(memory);
    return frame;
}

TEST(HueClip, ComesBackExactly) {
    const TemporaryFolder folder;
    const Scene scene = hue_scene(37, 18);
    auto writer = create_clip(folder / "clip.mkv", scene);
    ASSERT_EQ(message(writer), "");
    for (int n = 0; n < 3; ++n) ASSERT_EQ(message((*writer)->write(hue_frame(scene, n))), "");
    ASSERT_EQ(message((*writer)->finish()), "");
    auto reader = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->scene().depth, scene.depth);
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    for (int n = 0; n < 3; ++n)
        EXPECT_TRUE(same_frame((*frames)[static_cast<std::size_t>(n)], hue_frame(scene, n)));
}

TEST(HueClip, OfPngsIsReadAsStored) {
    const TemporaryFolder folder;
    Scene scene = hue_scene(20, 10);
    scene.folder = FolderSource{"d%d.png", "", "", "", 0, 0};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const RawFrame written = hue_frame(scene, 0);
    ASSERT_EQ(message(write_png(folder / "d0.png", written.depth)), "");
    const auto frames = read_clip(folder / "scene.json");
    ASSERT_EQ(message(frames), "");
    EXPECT_TRUE(same_plane(frames->front().depth, written.depth));
}

TEST(HueClip, GreyDepthIsRefusedForHueAndRgbForAnyOther) {
    const TemporaryFolder folder;
    const Scene hue = hue_scene(20, 10), grey = small_scene(20, 10);
    const std::pair<const Scene&, RawFrame> wrong[] = {{hue, test_frame(grey, 0, {})},
                                                       {grey, hue_frame(hue, 0)}};
    for (const auto& [scene, frame] : wrong) {
        auto writer = create_clip(folder / "clip.mkv", scene);
        ASSERT_EQ(message(writer), "");
        const std::string refusal = message((*writer)->write(frame));
        EXPECT_NE(refusal.find("needs 8-bit"), std::string::npos) << refusal;
    }
}

}  // namespace
}  // namespace touchable::test
