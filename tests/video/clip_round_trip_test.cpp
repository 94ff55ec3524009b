#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <set>

#include "engine/clip/clip_file.hpp"
#include "engine/clip/readers.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/scene/plane_memory.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

constexpr Planes depth_only{};

void expect_round_trip_as(Archive archive, const TemporaryFolder& folder, const Scene& scene, int frames,
                          const Planes& planes) {
    const auto file = folder / "clip.mkv";
    ASSERT_EQ(message(write_clip(file, scene, frames, planes, {archive, true})), "");
    auto reader = open_clip(file);
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), frames);
    const auto read = read_all(**reader);
    ASSERT_EQ(message(read), "");
    ASSERT_EQ(read->size(), static_cast<std::size_t>(frames));
    reader->reset();  // the frames' storage keeps their planes
    for (int n = 0; n < frames; ++n)
        EXPECT_TRUE(same_frame((*read)[static_cast<std::size_t>(n)], test_frame(scene, n, planes)))
            << scene.width << "x" << scene.height << ", " << scene.depth_bits << " bits, frame " << n;
}

void expect_round_trip(const TemporaryFolder& folder, const Scene& scene, int frames, const Planes& planes) {
    for (const Archive archive : {Archive::fast, Archive::small})
        expect_round_trip_as(archive, folder, scene, frames, planes);
}

TEST(Clip, EveryBitDepthComesBackExactly) {
    const TemporaryFolder folder;
    for (int bits = 8; bits <= 16; ++bits) {
        expect_round_trip(folder, small_scene(53, 37, bits), 3, depth_only);
        expect_round_trip(folder, small_scene(53, 37, bits), 3, all_planes);
        expect_round_trip(folder, small_scene(53, 37, bits), 2, {true, true, true, false});
    }
}

void expect_in_plane_memory(const PlaneView& plane, const std::string& which) {
    ASSERT_FALSE(plane.empty()) << which;
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(plane.data) % plane_alignment, 0U) << which;
    EXPECT_EQ(static_cast<std::size_t>(plane.stride) % plane_row_alignment, 0U) << which;
    EXPECT_NE(plane_block_of(plane.data, static_cast<std::size_t>(plane.stride * plane.height)), nullptr)
        << which;
}

TEST(Clip, PlanesLieInPlaneMemory) {
    const TemporaryFolder folder;
    const auto file = folder / "clip.mkv";
    std::set<std::string> codecs;
    for (const Archive archive : {Archive::fast, Archive::small})
        for (const int bits : {8, 16})
            for (const bool noisy : {true, false}) {
                const Planes planes{true, true, true, noisy};
                ASSERT_EQ(message(write_clip(file, small_scene(53, 37, bits), 2, planes, {archive, true})),
                          "");
                auto reader = open_clip(file);
                ASSERT_EQ(message(reader), "");
                const auto read = read_all(**reader);
                ASSERT_EQ(message(read), "");
                for (const TrackInfo& track : (*reader)->tracks()) codecs.insert(track.codec);
                for (const RawFrame& frame : *read)
                    for (const PlaneRole role : all_roles)
                        expect_in_plane_memory(plane_of(frame, role), std::string(role_name(role)) + " of " +
                                                                          std::to_string(bits) + " bits");
            }
    EXPECT_EQ(codecs, (std::set<std::string>{"ffv1", "h264", "t3d2"}));
}

TEST(Clip, EverySizeComesBackExactly) {
    const TemporaryFolder folder;
    constexpr int sides[] = {2, 3, 4, 5, 7, 8, 15, 16, 17, 31, 32, 33, 65};
    for (const int width : sides)
        for (const int height : sides) {
            expect_round_trip_as(Archive::fast, folder, small_scene(width, height, 16), 1,
                                 {false, true, true});
            if (width == 7 || height == 33)
                expect_round_trip_as(Archive::small, folder, small_scene(width, height, 10), 1, all_planes);
        }
}

TEST(Clip, LongAndThinPicturesComeBackExactly) {
    const TemporaryFolder folder;
    expect_round_trip(folder, small_scene(16384, 4, 12), 1, all_planes);
    expect_round_trip(folder, small_scene(5, 16384, 16), 1, all_planes);
    expect_round_trip(folder, small_scene(352, 2, 16), 1, all_planes);
    expect_round_trip(folder, small_scene(3, 288, 10), 1, all_planes);
}

/// Of which FFV1, as FFmpeg writes it, has no pictures.
TEST(Clip, ThinnestPicturesComeBackExactly) {
    const TemporaryFolder folder;
    constexpr int sizes[][2] = {{1, 1}, {1, 40}, {40, 1}, {3, 289}, {353, 3}, {16384, 2}};
    for (const auto& [width, height] : sizes)
        expect_round_trip(folder, small_scene(width, height), 2, all_planes);
}

TEST(Clip, AnyChoiceOfPlanesComesBackExactly) {
    const TemporaryFolder folder;
    for (int choice = 0; choice < 8; ++choice)
        expect_round_trip(folder, small_scene(40, 30, 16), 2,
                          {(choice & 1) != 0, (choice & 2) != 0, (choice & 4) != 0});
}

TEST(Clip, SixteenBitHeightsComeBackExactly) {
    const TemporaryFolder folder;
    Scene scene = small_scene(40, 30, 16);
    scene.height_coding.code_max = 65535;
    expect_round_trip(folder, scene, 2, {false, false, true});
}

TEST(Clip, TimesAreTheScenesWhateverMatroskaRounds) {
    const TemporaryFolder folder;
    for (const FrameRate& rate : {FrameRate{30000, 1001}, {24, 1}, {1000, 1}, {997, 1}, {1, 7}, {25, 2}}) {
        Scene scene = small_scene(8, 8);
        scene.rate = rate;
        expect_round_trip(folder, scene, 70, depth_only);  // compares the times too
    }
}

TEST(Clip, SceneComesBackWithoutItsFolder) {
    const TemporaryFolder folder;
    Scene scene = small_scene(40, 30, 12);
    scene.name = "gr\xc3\xbc\xc3\x9f \"Gott\"";
    scene.haptic.stiffness = {0.1, 1.0 / 3.0};
    scene.folder = FolderSource{"depth_%d.png", "", "", "", 0, 0};
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 1, depth_only)), "");
    auto reader = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(reader), "");
    scene.folder.reset();
    EXPECT_EQ(scene_to_json((*reader)->scene()), scene_to_json(scene));
}

// As a clip, as pictures, and as a part of either.
TEST(Clip, FiltersThatAreLeftOpenStayOpen) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(40, 30, 12);
    SceneDescription described(scene);
    described.unstated.filters = {.median = true, .terraces = true};
    const auto write = [&](Result<std::unique_ptr<ClipWriter>> writer) {
        ASSERT_EQ(message(writer), "");
        for (int n = 0; n < 3; ++n)
            ASSERT_EQ(message((*writer)->write(test_frame(scene, n, depth_only))), "");
        ASSERT_EQ(message((*writer)->finish()), "");
    };
    write(create_clip(folder / "clip.mkv", described));
    write(create_image_folder(folder / "clip", described, Existing::keep));
    for (const char* name : {"clip.mkv", "clip"}) {
        auto reader = open_clip(folder / name);
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ((*reader)->unstated_filters(), described.unstated.filters) << name;
        const auto part = part_of_clip(std::move(*reader), {.first = 1});
        ASSERT_EQ(message(part), "");
        EXPECT_EQ((*part)->described().unstated, described.unstated) << name;
    }
}

TEST(Clip, TracksSayWhatIsStored) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30, 12), 1, all_planes)), "");
    auto reader = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(reader), "");
    const auto& tracks = (*reader)->tracks();
    ASSERT_EQ(tracks.size(), 4U);
    const char* expected[][3] = {{"depth", "t3d2", "12 bits"},
                                 {"colour", "h264", "gbrp"},
                                 {"haptic", "h264", "gbrp"},
                                 {"height", "h264", "yuvj420p"}};  // FFmpeg's H.264 has no grey
    for (std::size_t k = 0; k < 4; ++k) {
        EXPECT_EQ(tracks[k].role, expected[k][0]);
        EXPECT_EQ(tracks[k].codec, expected[k][1]);
        EXPECT_EQ(tracks[k].pixel_format, expected[k][2]);
        EXPECT_EQ(tracks[k].width, 40);
        EXPECT_EQ(tracks[k].height, 30);
        EXPECT_TRUE(tracks[k].lossless);
    }
    EXPECT_TRUE((*reader)->notes().empty());
}

TEST(Clip, DepthAloneIsTouchableAndSaysWithWhatProperties) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 2, depth_only)), "");
    auto reader = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(reader), "");
    ASSERT_EQ((*reader)->notes().size(), 1U);
    EXPECT_EQ((*reader)->notes()[0],
              "no haptic plane: 0.6 N/mm everywhere, friction 0.4 static, 0.3 dynamic");
}

TEST(Clip, RewindStartsAgainFromAnywhere) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(20, 20, 16);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 6, all_planes)), "");
    auto reader = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(reader), "");
    for (int given = 0; given <= 7; ++given) {
        for (int n = 0; n < given; ++n) ASSERT_EQ(message((*reader)->next()), "");
        ASSERT_EQ(message((*reader)->rewind()), "");
    }
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 6U);
    for (int n = 0; n < 6; ++n)
        EXPECT_TRUE(same_frame((*frames)[static_cast<std::size_t>(n)], test_frame(scene, n, all_planes)));
    EXPECT_FALSE((*reader)->next()->has_value());  // still the end
}

TEST(Clip, SameFramesGiveTheSameFile) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "a.mkv", small_scene(64, 48, 16), 5, all_planes)), "");
    ASSERT_EQ(message(write_clip(folder / "b.mkv", small_scene(64, 48, 16), 5, all_planes)), "");
    const std::string first = read_bytes(folder / "a.mkv");
    EXPECT_GT(first.size(), 64U * 48U);
    EXPECT_EQ(first, read_bytes(folder / "b.mkv"));
}

TEST(Clip, AnotherSceneFileReplacesTheAttachedOne) {
    const TemporaryFolder folder;
    Scene scene = small_scene(40, 30);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 2, depth_only)), "");
    scene.name = "another";
    scene.rate = {60, 1};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    auto reader = open_clip(folder / "clip.mkv", folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->scene().name, "another");
    ASSERT_FALSE((*reader)->notes().empty());
    EXPECT_NE((*reader)->notes()[0].find("played at 60/1"), std::string::npos);
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    EXPECT_EQ(frames->at(1).time_ns, 16'666'666);
}

TEST(Clip, FarPlaneMissingFromTheSceneIsFoundInTheFrames) {
    const TemporaryFolder folder;
    Scene scene = small_scene(40, 30, 12);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 3, depth_only)), "");
    scene.depth = DepthCoding{};
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.semantics = DepthSemantics::planar;
    scene.depth.scale = 0.5;
    scene.depth.code_max = 4095;
    scene.depth.invalid_codes[0] = 4095;
    scene.depth.invalid_code_count = 1;
    SceneDescription without_far(scene);
    without_far.unstated.far = true;
    write_bytes(folder / "scene.json", scene_to_json(without_far));
    auto reader = open_clip(folder / "clip.mkv", folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);  // all of them still to be had
    int deepest = 0;
    for (const RawFrame& frame : *frames)
        for (int y = 0; y < 30; ++y)
            for (int x = 0; x < 40; ++x)
                if (frame.depth.sample(x, y) != 4095)
                    deepest = std::max<int>(deepest, frame.depth.sample(x, y));
    const Scene& found = (*reader)->scene();
    EXPECT_DOUBLE_EQ(found.depth.far, deepest * 0.5 * 1.05);
    EXPECT_TRUE(found.depth.is_valid(static_cast<std::uint16_t>(deepest)));
}

TEST(Clip, ColourMayBeLossy) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(64, 48, 16);
    const Planes ramps{true, true, true, false};
    ASSERT_EQ(message(write_clip(folder / "exact.mkv", scene, 4, ramps)), "");
    for (const char* codec : {"mjpeg", "mpeg4"}) {
        Remux changes;
        changes.transcoded["colour"] = codec;
        remux(folder / "exact.mkv", folder / "lossy.mkv", changes);
        const auto frames = read_clip(folder / "lossy.mkv");
        ASSERT_EQ(message(frames), "") << codec;
        ASSERT_EQ(frames->size(), 4U);
        const RawFrame &lossy = frames->at(3), exact = test_frame(scene, 3, ramps);
        EXPECT_TRUE(same_plane(lossy.depth, exact.depth));
        EXPECT_TRUE(same_plane(lossy.haptic, exact.haptic));
        double error = 0;
        for (int y = 0; y < 48; ++y)
            for (int x = 0; x < 64; ++x)
                for (int c = 0; c < 3; ++c)
                    error += std::abs(lossy.colour.sample(x, y, c) - exact.colour.sample(x, y, c));
        EXPECT_LT(error / (48 * 64 * 3), 4.0)
            << codec;  // the ramp is nearly grey; range and channels are right
        EXPECT_GT(error, 0.0) << codec;
    }
}

TEST(Clip, ColourOfAnotherSizeIsResampledAndSaysSo) {
    const TemporaryFolder folder;
    ASSERT_EQ(
        message(write_clip(folder / "exact.mkv", small_scene(64, 48, 16), 2, {true, true, true, false})), "");
    Remux changes;
    changes.transcoded["colour"] = "mjpeg";
    changes.transcoded_scale = 2;
    remux(folder / "exact.mkv", folder / "large.mkv", changes);
    auto reader = open_clip(folder / "large.mkv");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->tracks()[1].width, 128);
    ASSERT_EQ((*reader)->notes().size(), 1U);
    EXPECT_EQ((*reader)->notes()[0], "colour is 128x96: resampled to the nearest pixel of depth's 64x48");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 2U);
    EXPECT_EQ(frames->at(1).colour.width, 64);
    EXPECT_EQ(frames->at(1).colour.height, 48);
}

}  // namespace
}  // namespace touchable::test
