// Clips as folders of pictures.
#include "engine/formats/formats_written.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "engine/picture/image.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"

namespace touchable::test {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> names_of(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// Frames of which some planes begin to change with a later frame, or never do.
std::vector<RawFrame> changing_frames(const Scene& scene) {
    std::vector<RawFrame> frames;
    const RawFrame first = test_frame(scene, 0, all_planes), later = test_frame(scene, 9, all_planes);
    for (int n = 0; n < 4; ++n) {
        RawFrame frame = test_frame(scene, n, all_planes);
        frame.haptic = first.haptic;
        frame.height = n < 2 ? first.height : later.height;
        struct Both {
            std::shared_ptr<const void> a, b, c;
        };
        frame.storage = std::make_shared<Both>(Both{frame.storage, first.storage, later.storage});
        frames.push_back(std::move(frame));
    }
    return frames;
}

Result<void> write_pictures(const fs::path& folder, const Scene& scene, const std::vector<RawFrame>& frames,
                            Existing existing = Existing::keep) {
    auto writer = create_image_folder(folder, scene, existing);
    if (!writer) return writer.error();
    for (const RawFrame& frame : frames)
        if (auto written = (*writer)->write(frame); !written) return written;
    return (*writer)->finish();
}

TEST(ImageFolderWriter, OpensAsItIsWithEveryValueAndStillsOnce) {
    for (const int bits : {8, 12, 16}) {
        const TemporaryFolder folder;
        Scene scene = small_scene(23, 14, bits);
        scene.rate = {30000, 1001};
        scene.name = "two words";
        const std::vector<RawFrame> frames = changing_frames(scene);
        ASSERT_EQ(message(write_pictures(folder / "clip", scene, frames)), "");
        EXPECT_EQ(names_of(folder.path()), std::vector<std::string>{"clip"});
        EXPECT_EQ(names_of(folder / "clip"),
                  (std::vector<std::string>{"colour_000000.png", "colour_000001.png", "colour_000002.png",
                                            "colour_000003.png", "depth_000000.png", "depth_000001.png",
                                            "depth_000002.png", "depth_000003.png", "haptic.png",
                                            "height_000000.png", "height_000001.png", "height_000002.png",
                                            "height_000003.png", "scene.json"}));
        const auto read = read_clip(folder / "clip");
        ASSERT_EQ(message(read), "");
        ASSERT_EQ(read->size(), frames.size());
        for (std::size_t n = 0; n < frames.size(); ++n) EXPECT_TRUE(same_frame((*read)[n], frames[n])) << n;
        auto again = read_scene_file(folder / "clip/scene.json");
        ASSERT_EQ(message(again), "");
        EXPECT_EQ(again->scene.folder->count, 4);
        again->scene.folder.reset();
        EXPECT_EQ(scene_to_json(*again), scene_to_json(scene));
    }
}

TEST(ImageFolderWriter, CanBeOpenedBeforeItHasItsNameAndLeavesNothingWithoutOne) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(9, 8);
    {
        auto writer = create_image_folder(folder / "clip", scene, Existing::keep);
        ASSERT_EQ(message(writer), "");
        ASSERT_EQ(message((*writer)->write(test_frame(scene, 0, {}))), "");
        const auto place = (*writer)->complete();
        ASSERT_EQ(message(place), "");
        const auto frames = read_clip(*place);
        ASSERT_EQ(message(frames), "");
        EXPECT_EQ(frames->size(), 1U);
        EXPECT_FALSE(fs::exists(folder / "clip"));
    }
    EXPECT_TRUE(names_of(folder.path()).empty());
}

TEST(ImageFolderWriter, ReplacesOnlyAFolderLikeItAndOnlyWhereItMay) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(9, 8);
    const std::vector<RawFrame> two{test_frame(scene, 0, {}), test_frame(scene, 1, {})}, one{two.front()};
    fs::create_directory(folder / "clip");  // an empty one is as good as none
    ASSERT_EQ(message(write_pictures(folder / "clip", scene, two)), "");
    EXPECT_NE(message(write_pictures(folder / "clip", scene, one)), "");
    EXPECT_EQ(read_clip(folder / "clip")->size(), 2U);
    EXPECT_TRUE(is_image_folder(folder / "clip"));
    ASSERT_EQ(message(write_pictures(folder / "clip", scene, one, Existing::replace)), "");
    EXPECT_EQ(names_of(folder / "clip"), (std::vector<std::string>{"depth_000000.png", "scene.json"}));
    for (const char* name :
         {"depth_1.png", "notes.txt", "depth_00000x.png", "depth.jpg", "depth_000000.png.bak"}) {
        write_bytes(folder / ("clip/" + std::string(name)), "x");
        EXPECT_FALSE(is_image_folder(folder / "clip")) << name;
        EXPECT_NE(message(write_pictures(folder / "clip", scene, two, Existing::replace)), "");
        fs::remove(folder / ("clip/" + std::string(name)));
    }
    fs::create_directory(folder / "clip/depth.png");
    EXPECT_FALSE(is_image_folder(folder / "clip"));
    fs::remove(folder / "clip/depth.png");
    // By a link, the folder that it leads to.
    fs::create_directory_symlink(folder / "clip", folder / "link");
    ASSERT_EQ(message(write_pictures(folder / "link", scene, two, Existing::replace)), "");
    EXPECT_TRUE(fs::is_symlink(folder / "link"));
    EXPECT_EQ(read_clip(folder / "clip")->size(), 2U);
    EXPECT_EQ(names_of(folder.path()), (std::vector<std::string>{"clip", "link"}));
    EXPECT_TRUE(is_refused(write_pictures(folder / "none/clip", scene, one), "there is no folder"));
}

TEST(ImageFolderWriter, HapticPicturesOfFewMaterialsAreIndexedAndOthersNot) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(40, 30);
    std::vector<RawFrame> frames{test_frame(scene, 0, all_planes), test_frame(scene, 1, all_planes),
                                 test_frame(scene, 2, all_planes)};
    Samples materials(3 * 40 * 30);  // the middle picture has more than 256 colours, these have three
    for (std::size_t k = 0; k < materials.size(); ++k)
        materials[k] = static_cast<std::uint8_t>(k % 3 * 40 + k / 3 / 40 % 3);
    for (const std::size_t n : {std::size_t{0}, std::size_t{2}})
        frames[n].haptic = frames[n].colour = {materials.data(), 3 * 40, 40, 30, 1, 3};
    ASSERT_EQ(message(write_pictures(folder / "clip", scene, frames)), "");
    const auto format = [&](const char* name) {
        const auto stored = read_stored_image(folder / (std::string("clip/") + name));
        return stored ? stored->pixel_format : stored.error().message;
    };
    EXPECT_EQ(format("haptic_000000.png"), "pal8");
    EXPECT_EQ(format("haptic_000001.png"), "rgb24");
    EXPECT_EQ(format("haptic_000002.png"), "pal8");
    EXPECT_EQ(format("colour_000000.png"), "rgb24") << "as every program reads it";
    const auto read = read_clip(folder / "clip");
    ASSERT_EQ(message(read), "");
    ASSERT_EQ(read->size(), 3U);
    for (std::size_t n = 0; n < 3; ++n) EXPECT_TRUE(same_frame((*read)[n], frames[n])) << n;
}

TEST(ImageFolderWriter, AStillIsAPictureWithItsSceneFile) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(9, 8, 16);
    const RawFrame frame = test_frame(scene, 0, {false, true, true});
    auto writer = create_still(folder / "one.png", scene, Existing::keep);
    ASSERT_EQ(message(writer), "");
    ASSERT_EQ(message((*writer)->write(frame)), "");
    ASSERT_EQ(message((*writer)->finish()), "");
    EXPECT_EQ(names_of(folder.path()),
              (std::vector<std::string>{"one.json", "one.png", "one_haptic.png", "one_height.png"}));
    const auto read = read_clip(folder / "one.json");
    ASSERT_EQ(message(read), "");
    EXPECT_TRUE(same_frame(read->front(), frame));
    // Where one of its files has come to be there meanwhile, none of the others stays.
    const TemporaryFolder taken;
    auto second = create_still(taken / "one.png", scene, Existing::keep);
    ASSERT_EQ(message((*second)->write(frame)), "");
    write_bytes(taken / "one_height.png", "somebody's");
    EXPECT_NE(message((*second)->finish()), "");
    second->reset();
    EXPECT_EQ(names_of(taken.path()), std::vector<std::string>{"one_height.png"});
}

}  // namespace
}  // namespace touchable::test
