// A clip that was written as a glTF scene comes back; so does what other programs could have written.
#include <algorithm>

#include "engine/scene/scene.hpp"
#include "tests/gltf/gltf_fixture.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

void expect_comes_back(const fs::path& file, const Scene& scene, int frames, const Planes& planes) {
    ASSERT_EQ(message(write_gltf(file, scene, frames, planes, Existing::replace)), "");
    auto reader = open_clip(file);
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), frames);
    Scene read_scene = (*reader)->scene();
    read_scene.folder.reset();
    EXPECT_EQ(scene_to_json(read_scene), scene_to_json(scene));
    const auto read = read_all(**reader);
    ASSERT_EQ(message(read), "");
    ASSERT_EQ(read->size(), static_cast<std::size_t>(frames));
    for (int n = 0; n < frames; ++n)
        EXPECT_TRUE(same_frame((*read)[static_cast<std::size_t>(n)], test_frame(scene, n, planes)))
            << scene.depth_bits << " bits, frame " << n << " of " << frames;
}

Scene scene_of_bits(int depth_bits, int height_bits) {
    Scene scene = small_scene(63, 47, depth_bits);
    scene.height_coding = {1.5, HeightUnits::levels, static_cast<std::uint16_t>((1 << height_bits) - 1)};
    return scene;
}

TEST(GltfClip, EveryBitComesBackAsVideoAndAsPictures) {
    const TemporaryFolder folder;
    for (const int frames : {1, 3})
        for (const int bits : {8, 10, 12, 16})
            expect_comes_back(folder / "a clip é.gltf", scene_of_bits(bits, bits == 12 ? 16 : 8), frames,
                              all_planes);
}

TEST(GltfClip, AnyOfItsOtherPlanesMayBeMissing) {
    const TemporaryFolder folder;
    for (const int frames : {1, 2})
        for (int choice = 0; choice < 8; ++choice)
            expect_comes_back(folder / "clip.gltf", scene_of_bits(16, 8), frames,
                              {(choice & 1) != 0, (choice & 2) != 0, (choice & 4) != 0});
}

TEST_F(GltfClipTest, FilesAppearTogetherOrNotAtAll) {
    write(2);
    const auto files = [this] {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder.path()))
            names.push_back(entry.path().filename());
        std::sort(names.begin(), names.end());
        return names;
    };
    EXPECT_EQ(files(), (std::vector<std::string>{"clip.bin", "clip.gltf", "clip.mp4", "clip.png"}));
    for (const char* name : {"clip.gltf", "clip.png"}) fs::remove(folder / name);
    const std::string before = read_bytes(folder / "clip.mp4");
    const auto again = write_gltf(file, scene, 3, all_planes, Existing::keep);
    EXPECT_TRUE(is_refused(again, "cannot be written: File exists"));
    EXPECT_EQ(files(), (std::vector<std::string>{"clip.bin", "clip.mp4"}));
    EXPECT_EQ(read_bytes(folder / "clip.mp4"), before);
    EXPECT_EQ(message(write_gltf(file, scene, 3, all_planes, Existing::replace)), "");
    EXPECT_EQ(message(open_clip(file)), "");
}

/// Also what only other programs show.
TEST_F(GltfClipTest, NamesEveryFileThatBelongsToIt) {
    write(2);
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    const auto& inputs = (*clip)->inputs();
    for (const char* name : {"clip.mp4", "clip.gltf", "clip.bin", "clip.png"})
        EXPECT_NE(std::find(inputs.begin(), inputs.end(), folder / name), inputs.end()) << name;
    EXPECT_EQ(sound_file_of(**clip), folder / "clip.mp4");
}

TEST_F(GltfClipTest, RangesBesideATextureCount) {
    write(2);
    auto& stiffness = gltf["extensions"]["MPEG_haptic_material"]["materials"][0]["stiffness"][0];
    stiffness["extras"]["touchable_range"] = {0.5, 0.75};
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().haptic.stiffness.min, 0.5);
    EXPECT_EQ((*clip)->scene().haptic.stiffness.max, 0.75);
    EXPECT_TRUE(is_noted(**clip, "the material's stand"));
}

/// What of it is only ours.
void forget_extras(nlohmann::json& node) {
    if (node.is_object()) node.erase("extras");
    for (auto& child : node)
        if (child.is_structured()) forget_extras(child);
}

TEST_F(GltfClipTest, AFileOfOthersIsOpenedAndSaysWhatItAssumes) {
    write(2);
    forget_extras(gltf);
    auto& material = gltf["extensions"]["MPEG_haptic_material"]["materials"][0];
    material.erase("friction");
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    const Scene& found = (*clip)->scene();
    EXPECT_EQ(found.depth.near, 0.5);
    EXPECT_EQ(found.depth.far, 1.5);
    EXPECT_FALSE(found.depth.near_is_high);
    EXPECT_EQ(found.haptic.static_friction.min, found.default_properties.static_friction);
    EXPECT_EQ(found.haptic.static_friction.max, found.default_properties.static_friction);
    for (const char* words : {"states no units", "0.5 m, black, to 1.5 m", "60 degrees"})
        EXPECT_TRUE(is_noted(**clip, words)) << words;
    const auto frame = (*clip)->next();
    ASSERT_EQ(message(frame), "");
    const RawFrame whole = test_frame(scene, 0, all_planes);
    EXPECT_TRUE(same_plane((*frame)->depth, whole.depth));
    EXPECT_TRUE(same_plane((*frame)->colour, whole.colour));
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 24; ++x)
            ASSERT_EQ((*frame)->haptic.sample(x, y, 0), whole.haptic.sample(x, y, 0)) << x << ' ' << y;
    EXPECT_TRUE((*frame)->height.empty());
}

TEST_F(GltfClipTest, HeightsHaveTheLengthBesideTheirTexture) {
    write(2);
    auto& height = gltf["extensions"]["MPEG_haptic_material"]["materials"][0]["custom"][0];
    height["extras"]["touchable_range"] = {0, 0.002};
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    EXPECT_NEAR(largest_height((*clip)->scene().height_coding, (*clip)->scene().depth), 2.0, 1e-12);
    EXPECT_TRUE(is_noted(**clip, "the material's stand"));
}

TEST_F(GltfClipTest, WhatOfAMaterialIsNotUsedIsSaid) {
    write(2);
    auto& material = gltf["extensions"]["MPEG_haptic_material"]["materials"][0];
    material["vibration"] = nlohmann::json::array();
    material["stiffness"][0]["texture"]["extensions"] = {{"KHR_texture_transform", {{"scale", {2, 2}}}}};
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    for (const char* words : {"vibration of ", "KHR_texture_transform of "})
        EXPECT_TRUE(is_noted(**clip, words)) << words;
}

TEST_F(GltfClipTest, SlidingFrictionMayStandAlone) {
    write(2);
    auto& material = gltf["extensions"]["MPEG_haptic_material"]["materials"][0];
    material.erase("stiffness");
    material["friction"].erase(0);
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    EXPECT_EQ((*clip)->scene().haptic.dynamic_friction.max, scene.haptic.dynamic_friction.max);
    EXPECT_EQ((*clip)->scene().haptic.static_friction.min, scene.default_properties.static_friction);
}

/// As the standard has it: a texture each, one friction, no "extras". Here they are the videos of haptic and
/// height, which have 3 and 1 channels.
TEST_F(GltfClipTest, StiffnessAndFrictionMayBeVideosOfTheirOwn) {
    write(3);
    forget_extras(gltf);
    gltf["extensions"]["MPEG_haptic_material"]["materials"][0] = {
        {"stiffness", {{{"texture", {{"index", 3}}}, {"type", "High_Resolution"}}}},
        {"friction", {{{"texture", {{"index", 2}}}, {"type", "High_Resolution"}}}}};
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    for (const char* words : {"states no units", "is static and dynamic friction alike", "frame by frame"})
        EXPECT_TRUE(is_noted(**clip, words)) << words;
    EXPECT_FALSE(is_noted(**clip, "no haptic plane"));
    const auto expect_frame = [&](const RawFrame& frame, int n) {
        const RawFrame whole = test_frame(scene, n, all_planes);
        EXPECT_TRUE(same_plane(frame.depth, whole.depth));
        for (int y = 0; y < 16; ++y)
            for (int x = 0; x < 24; ++x) {
                ASSERT_EQ(frame.haptic.sample(x, y, 0), whole.height.sample(x, y))
                    << n << ' ' << x << ' ' << y;
                ASSERT_EQ(frame.haptic.sample(x, y, 1), whole.haptic.sample(x, y, 0));
                ASSERT_EQ(frame.haptic.sample(x, y, 2), whole.haptic.sample(x, y, 0));
            }
    };
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    for (int n = 0; n < 3; ++n) expect_frame((*frames)[static_cast<std::size_t>(n)], n);
    ASSERT_EQ(message((*clip)->seek(1)), "");
    const auto again = (*clip)->next();
    ASSERT_EQ(message(again), "");
    expect_frame(**again, 1);
}

/// A picture of friction under every frame, beside a video of stiffness.
TEST_F(GltfClipTest, OnePropertyMayBeAPicture) {
    write(2);
    forget_extras(gltf);
    const Image slippery{12, 8, 1, 1, std::vector<std::uint8_t>(12 * 8, 77)};
    ASSERT_TRUE(write_png(folder / "slippery.png", slippery.view()));
    gltf["images"].push_back({{"uri", "slippery.png"}});
    gltf["textures"].push_back({{"source", 1}});
    auto& material = gltf["extensions"]["MPEG_haptic_material"]["materials"][0];
    material["friction"] = {{{"texture", {{"index", 4}}}, {"type", "High_Resolution"}}};
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    EXPECT_TRUE(is_noted(**clip, "haptic is 12x8: resampled to the nearest pixel of depth's 24x16"));
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    for (std::size_t n = 0; n < 2; ++n) {
        const RawFrame whole = test_frame(scene, static_cast<int>(n), all_planes);
        EXPECT_EQ((*frames)[n].haptic.sample(7, 5, 0), whole.haptic.sample(7, 5, 0));
        EXPECT_EQ((*frames)[n].haptic.sample(7, 5, 1), 77);
        EXPECT_EQ((*frames)[n].haptic.sample(7, 5, 2), 77);
    }
}

/// A track that is not there, and a file that is none.
TEST_F(GltfClipTest, VideosOfTouchMustBeThere) {
    write(2);
    forget_extras(gltf);
    auto& material = gltf["extensions"]["MPEG_haptic_material"]["materials"][0];
    material.erase("friction");
    auto& media = gltf["extensions"]["MPEG_media"]["media"];
    media[0]["alternatives"][0]["tracks"][2]["track"] = "#track_ID=77";
    auto refused = open();
    ASSERT_FALSE(refused);
    EXPECT_NE(refused.error().message.find("has no pictures in track 77"), std::string::npos)
        << refused.error().message;
    gltf["buffers"][3]["extensions"]["MPEG_buffer_circular"]["tracks"] = {1, 2};
    refused = open();
    EXPECT_TRUE(is_refused(refused, "a texture of touch is 2 tracks"));
}

/// As .glb files have it.
TEST_F(GltfClipTest, APictureOfColourBesideAVideoIsNotLookedAt) {
    write(2);
    forget_extras(gltf);
    gltf["extensions"]["MPEG_haptic_material"]["materials"][0].erase("friction");
    gltf["images"][0] = {{"bufferView", 0}};
    gltf["textures"][0].erase("extensions");
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    const auto frame = (*clip)->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_TRUE((*frame)->colour.empty());
}

TEST_F(GltfClipTest, ItsSceneCanBeWrittenToAFile) {
    write(2, 12);
    const auto own = guess_clip(file, {});
    ASSERT_EQ(message(own), "");
    EXPECT_EQ(own->scene.depth_bits, 12);
    write_bytes(folder / "scene.json", scene_to_json(*own));
    EXPECT_EQ(message(open_clip(file, folder / "scene.json")), "");
    forget_extras(gltf);
    gltf["extensions"]["MPEG_haptic_material"]["materials"][0].erase("friction");
    ASSERT_FALSE(open());  // nothing says how many bits its two tracks have
    EXPECT_EQ(message(open_clip(file, folder / "scene.json")), "");
}

TEST_F(GltfClipTest, NamesOfTheDraftAreReadAsWell) {
    write(2);
    auto& all = gltf["extensions"];
    all["MPEG_material_haptic"] = all["MPEG_haptic_material"]["materials"];
    all.erase("MPEG_haptic_material");
    auto& mesh = gltf["meshes"][0]["extensions"];
    mesh = {{"MPEG_material_haptic", 0}};
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    const auto frame = (*clip)->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_FALSE((*frame)->haptic.empty());
}

/// Stiffness and friction as pictures of their own, under every frame of a video.
TEST_F(GltfClipTest, PicturesOfTouchServeAllFramesOfAVideo) {
    write(3);
    const Image stiff{24, 16, 1, 1, std::vector<std::uint8_t>(24 * 16, 51)};
    ASSERT_TRUE(write_png(folder / "stiff.png", stiff.view()));
    gltf["images"].push_back({{"uri", "stiff.png"}});
    gltf["textures"].push_back({{"source", 1}});
    auto& material = gltf["extensions"]["MPEG_haptic_material"]["materials"][0];
    material.erase("friction");
    material["stiffness"][0]["texture"]["index"] = 4;
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    for (const RawFrame& frame : *frames) {
        EXPECT_EQ(frame.haptic.sample(5, 5, 0), 51);
        EXPECT_FALSE(frame.height.empty());
    }
}

/// A file for each plane, without a list of tracks.
TEST_F(GltfClipTest, DepthMayBeAVideoOfItsOwn) {
    write(2, 8, {.noisy = false});
    gltf["extensions"]["MPEG_media"]["media"][0]["alternatives"][0].erase("tracks");
    for (auto& buffer : gltf["buffers"])
        if (buffer.contains("extensions")) buffer["extensions"]["MPEG_buffer_circular"].erase("tracks");
    const auto clip = open();
    ASSERT_EQ(message(clip), "");
    const auto frames = read_all(**clip);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 2U);
    EXPECT_TRUE(same_plane((*frames)[1].depth, test_frame(scene, 1, {.noisy = false}).depth));
}

}  // namespace
}  // namespace touchable::test
