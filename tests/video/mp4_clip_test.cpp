// SPDX-License-Identifier: Apache-2.0
// Clips in MP4: what was written comes back, by way of tags and an MPEG-4 scene, or of the scene alone.

#include <functional>

#include "engine/formats/formats_written.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/video/mp4_boxes.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

struct Mp4Clip : ::testing::Test {
    const TemporaryFolder folder;
};

TEST_F(Mp4Clip, RoundTripsBitsAndPlanes) {
    for (const int bits : {8, 9, 10, 12, 16})
        for (const int height_bits : {8, 16}) {
            const Scene scene = scene_with_heights(63, 47, bits, height_bits);
            expect_round_trip(folder / "clip.mp4", scene, 3, all_planes);
            expect_round_trip(folder / "clip.mp4", scene, 2, all_planes, {Archive::small, true});
        }
    for (int choice = 0; choice < 8; ++choice)
        expect_round_trip(folder / "clip.mp4", scene_with_heights(40, 30, 16, 8), 2,
                          {(choice & 1) != 0, (choice & 2) != 0, (choice & 4) != 0});
}

TEST_F(Mp4Clip, RoundTripsSizesOfH264) {
    constexpr int sizes[][2] = {{1, 1}, {1, 40}, {40, 1}, {2, 2}, {17, 16}, {16, 33}, {16384, 2}};
    for (const auto& [width, height] : sizes)
        expect_round_trip(folder / "clip.mp4", scene_with_heights(width, height, 12, 16), 2, all_planes);
    EXPECT_TRUE(is_refused(write_clip(folder / "wide.mp4", small_scene(16385, 1), 1, {}), "from 1 to 16384"));
    const Scene largest = small_scene(16384, 16384);
    const std::vector<std::uint8_t> row(16384, 77);
    RawFrame frame;
    frame.depth = {row.data(), 0, 16384, 16384, 1, 1};  // every row is the same one
    auto writer = must(create_clip(folder / "large.mp4", largest));
    EXPECT_TRUE(
        is_refused(writer->write(frame), "pictures of 16384x16384 cannot be stored", ErrorKind::usage));
    EXPECT_FALSE(writer->finish());
    EXPECT_FALSE(fs::exists(folder / "wide.mp4") || fs::exists(folder / "large.mp4"));
}

TEST_F(Mp4Clip, RoundTripsTheScene) {
    Scene scene = small_scene(40, 30, 12);
    scene.name = "gr\xc3\xbc\xc3\x9f \"Gott\"";
    scene.haptic.stiffness = {0.1, 1.0 / 3.0};
    scene.colour_camera.reset();
    scene.default_properties.stiffness = 321;
    scene.depth.near_is_high = false;
    scene.depth.invalid_codes[0] = 4095;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    expect_round_trip(folder / "clip.mp4", scene, 2, all_planes);
    scene = small_scene(40, 30, 16);
    scene.depth = {};
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 0.25;
    scene.depth.near = 100;
    scene.depth.far = 5000;
    scene.depth.code_max = 65535;
    derive_valid_range(scene.depth);
    scene.height_coding = {3, HeightUnits::world, 255};
    expect_round_trip(folder / "clip.mp4", scene, 2, all_planes);
}

/// Every frame, in an order that goes to and fro.
void expect_same_by_any_way(const fs::path& file, const Scene& scene, int frames) {
    auto reader = must(open_clip(file));
    const auto whole = test_frames(scene, frames, all_planes);
    std::vector<int> order(whole.size());
    Random numbers(11);
    for (std::size_t k = 0; k < order.size(); ++k) {
        order[k] = static_cast<int>(k);
        std::swap(order[k], order[static_cast<std::size_t>(numbers.below(static_cast<int>(k) + 1))]);
    }
    for (const int n : order) {
        EXPECT_EQ(reader->access_point(n), n - n % 15);
        expect_seek_to(*reader, n, whole);
    }
    ASSERT_EQ(message(reader->rewind()), "");
    EXPECT_EQ(std::ssize(must(read_all(*reader))), frames);
    EXPECT_TRUE(is_refused(reader->seek(frames + 1), "has no frame"));
}

TEST_F(Mp4Clip, SeeksAtAnyRate) {
    constexpr int frames = 40;
    Scene scene = scene_with_heights(16, 12, 12, 16);
    for (const FrameRate& rate :
         {FrameRate{30000, 1001}, {1, 7}, {1000, 1}, *rate_of_own_times(uneven_times(frames))}) {
        scene.rate = rate;
        expect_round_trip(folder / "clip.mp4", scene, frames, all_planes);  // compares the times too
        expect_same_by_any_way(folder / "clip.mp4", scene, frames);
    }
    scene.rate = {30, 1};
    scene.width = 320;  // on a thread for each track
    scene.height = 160;
    expect_round_trip(folder / "clip.mp4", scene, 17, all_planes);
    expect_same_by_any_way(folder / "clip.mp4", scene, 17);
    scene.rate = {1001, 1};
    EXPECT_TRUE(is_refused(write_clip(folder / "fast.mp4", scene, 1, {}), "a clip has at most 1000"));
}

TEST_F(Mp4Clip, MayHaveOneFrame) {
    const Scene scene = scene_with_heights(16, 12, 16, 8);
    expect_round_trip(folder / "clip.mp4", scene, 1, all_planes);
    expect_same_by_any_way(folder / "clip.mp4", scene, 1);
    EXPECT_TRUE(is_refused(write_clip(folder / "none.mp4", scene, 0, {}), "no frame was given"));
    EXPECT_FALSE(fs::exists(folder / "none.mp4"));
}

TEST_F(Mp4Clip, GivesStoredColour) {
    const Scene scene = small_scene(63, 47, 16);
    const Planes ramps{true, true, true, false};
    auto writer = must(create_clip(folder / "clip.mp4", scene, {Archive::fast, false, true}));
    const auto exact = test_frames(scene, 4, ramps);
    std::vector<std::string> given;
    for (const RawFrame& frame : exact) {
        ASSERT_EQ(message(writer->write(frame)), "");
        const PlaneView colour = writer->stored_colour();
        ASSERT_FALSE(colour.empty());
        std::string& bytes = given.emplace_back();
        for (int y = 0; y < colour.height; ++y)
            bytes.append(reinterpret_cast<const char*>(colour.row(y)),
                         static_cast<std::size_t>(3 * colour.width));
    }
    ASSERT_EQ(message(writer->finish()), "");
    auto reader = must(open_clip(folder / "clip.mp4"));
    for (const TrackInfo& track : reader->tracks()) EXPECT_EQ(track.lossless, track.role != "colour");
    const auto frames = must(read_all(*reader));
    ASSERT_EQ(frames.size(), 4U);
    for (std::size_t n = 0; n < 4; ++n) {
        const PlaneView& colour = frames[n].colour;
        for (std::size_t y = 0; y < 47; ++y)
            EXPECT_EQ(std::memcmp(colour.row(static_cast<int>(y)), given[n].data() + 3 * 63 * y, 3 * 63), 0);
        EXPECT_LT(mean_difference(colour, exact[n].colour), 4) << n;
        EXPECT_TRUE(same_plane(frames[n].depth, exact[n].depth));
    }
}

constexpr mpeg4::BifsConfig config_of_clips{.node_id_bits = 1, .prototype_id_bits = 2};

/// The file with another scene in place of its own, which `change` makes of that.
std::string with_scene(std::string file, const std::function<mpeg4::Bytes(const mpeg4::Bytes&)>& change) {
    const auto tracks = tracks_in(file);
    const auto scene = std::ranges::find_if(
        tracks, [&](const FoundBox& track) { return handler_of(file, track) == "sdsm"; });
    EXPECT_NE(scene, tracks.end());
    const std::string sample = sample_of(file, *scene);
    mpeg4::Bytes bytes = change(mpeg4::Bytes(sample.begin(), sample.end()));
    EXPECT_LE(bytes.size(), sample.size());
    bytes.resize(sample.size());
    return file.replace(file.find(sample), sample.size(), std::string(bytes.begin(), bytes.end()));
}

/// The values of its MPEG-4 scene, changed in place: other values of numbers take as many bits.
std::string with_nodes_changed(const std::string& file,
                               const std::function<void(mpeg4::ClipNodes&)>& change) {
    return with_scene(file, [&](const mpeg4::Bytes& before) {
        const auto tree = must(mpeg4::decode_scene(before, config_of_clips));
        auto nodes = must(mpeg4::clip_nodes_of(tree));
        change(nodes);
        auto changed = must(mpeg4::encode_scene(mpeg4::scene_of(nodes, 40, 30), config_of_clips));
        EXPECT_EQ(changed.size() + 1, before.size());
        return changed;
    });
}

TEST_F(Mp4Clip, PrefersEditedSceneOverTag) {
    Scene scene = scene_with_heights(40, 30, 12, 8);
    scene.haptic.dynamic_friction = {0, 0.5};  // not as a scene has it that says nothing
    ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 2, all_planes)), "");
    const std::string bytes = read_bytes(folder / "clip.mp4");
    const auto opened = [&](const std::function<void(mpeg4::ClipNodes&)>& change) {
        write_bytes(folder / "edited.mp4", with_nodes_changed(bytes, change));
        return open_clip(folder / "edited.mp4");
    };
    const auto unchanged = must(opened([](mpeg4::ClipNodes&) {}));
    EXPECT_TRUE(unchanged->notes().empty());
    const auto edited = must(opened([](mpeg4::ClipNodes& nodes) {
        nodes.max_height = 2.5;
        nodes.far = 150;
        nodes.focal_length *= 2;
        nodes.ranges.dynamic_friction = {0, 0.25};
    }));
    ASSERT_EQ(edited->notes().size(), 1U);
    EXPECT_TRUE(has_words(edited->notes()[0], "the scene stands"));
    scene.height_coding.max_height = 2.5;
    scene.depth.far = 150;
    scene.camera.fx = scene.camera.fy = 100;
    scene.haptic.dynamic_friction = {0, 0.25};
    derive_valid_range(scene.depth);
    EXPECT_EQ(scene_to_json(edited->scene()), scene_to_json(scene));
    EXPECT_TRUE(same_plane(next_of(*edited).depth, test_frame(scene, 0, all_planes).depth))
        << "with its low bits";
    const std::pair<void (*)(mpeg4::ClipNodes&), const char*> faults[] = {
        {[](auto& nodes) { nodes.far = 5; }, "edited.mp4: its MPEG-4 scene: depth.near"},
        {[](auto& nodes) { nodes.pixel_width = 0; }, "focalLength and pixelWidth must be above 0"},
        {[](auto& nodes) { nodes.haptic = nodes.colour; }, "its haptic is the same track as its colour"},
        {[](auto& nodes) { nodes.haptic->url.object = 77; }, "haptic is object 77, which is no track"}};
    for (const auto& [change, words] : faults) EXPECT_TRUE(is_refused(opened(change), words));
}

TEST_F(Mp4Clip, AppliesSceneFile) {
    Scene scene = scene_with_heights(40, 30, 12, 16);
    ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 2, all_planes)), "");
    scene.name = "another";
    auto reader = must(open_as(folder / "clip.mp4", scene));
    EXPECT_EQ(reader->scene().name, "another");
    EXPECT_TRUE(same_frame(next_of(*reader), test_frame(scene, 0, all_planes)));
    scene.depth_bits = 16;
    scene.depth.code_max = 65535;
    derive_valid_range(scene.depth);
    EXPECT_TRUE(is_refused(open_as(folder / "clip.mp4", scene), "is 12-bit grey"));
}

TEST_F(Mp4Clip, FallsBackToMpeg4Scene) {
    Scene scene = scene_with_heights(40, 30, 12, 16);
    scene.rate = {30000, 1001};
    scene.camera = camera_from_focal_length(50, 1, 40, 30);
    scene.haptic.static_friction = {0.2, 0.9};
    ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 20, all_planes)), "");
    write_bytes(folder / "bare.mp4", without_in_movie(read_bytes(folder / "clip.mp4"), {"udta", "meta"}));
    auto reader = must(open_clip(folder / "bare.mp4"));
    const Scene& found = reader->scene();
    EXPECT_EQ(found.depth_bits, 8);
    EXPECT_EQ(reader->access_point(14), 0);
    EXPECT_EQ(reader->access_point(17), 15) << "by its own index";
    for (const TrackInfo& track : reader->tracks()) EXPECT_TRUE(track.lossless) << track.role;
    EXPECT_EQ(found.depth.near, 10);
    EXPECT_EQ(found.depth.far, 200);
    EXPECT_NEAR(found.camera.fx, 50, 1e-5);
    EXPECT_EQ(found.camera.cx, scene.camera.cx);
    EXPECT_EQ(found.haptic.static_friction.max, 0.9);
    EXPECT_EQ(found.height_coding.max_height, 1.5);
    EXPECT_EQ(found.rate.num, 30000);
    EXPECT_EQ(found.rate.den, 1001);
    ASSERT_EQ(reader->notes().size(), 2U);
    EXPECT_EQ(
        reader->notes()[0],
        "the low bits of depth, in its track depth_low, are left out: no tag T3D_SCENE says what they are");
    EXPECT_TRUE(has_words(reader->notes()[1], "the low bits of height"));
    const auto frames = must(read_all(*reader));
    ASSERT_EQ(frames.size(), 20U);
    const RawFrame &read = frames[17], exact = test_frame(scene, 17, all_planes);
    EXPECT_TRUE(same_plane(read.haptic, exact.haptic));
    EXPECT_TRUE(same_plane(read.colour, exact.colour));
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) {
            ASSERT_EQ(read.depth.sample(x, y), exact.depth.sample(x, y) >> 4);
            ASSERT_EQ(read.height.sample(x, y), exact.height.sample(x, y) >> 8);
        }
    // A scene file says what the tag did.
    auto told = must(open_as(folder / "bare.mp4", scene));
    EXPECT_TRUE(told->notes().empty()) << told->notes()[0];
    EXPECT_TRUE(same_frame(**told->next(), test_frame(scene, 0, all_planes)));
}

TEST_F(Mp4Clip, FallsBackToTags) {
    const Scene scene = scene_with_heights(40, 30, 12, 16);
    ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 3, all_planes)), "");
    std::string bytes = read_bytes(folder / "clip.mp4");
    for (const char* handler : {"sdsm", "odsm"}) {
        const auto at = bytes.find(handler);
        ASSERT_NE(at, std::string::npos);
        bytes.replace(at, 4, "none");
    }
    write_bytes(folder / "bare.mp4", bytes);
    EXPECT_TRUE(same_frames(must(read_clip(folder / "bare.mp4")), test_frames(scene, 3, all_planes)));
}

/// Another scene in place of the file's own; "": bytes that are none.
std::string with_scene_text(const std::string& file, const std::string& text) {
    return with_scene(file, [&](const mpeg4::Bytes& before) {
        if (text.empty()) return mpeg4::Bytes(before.size(), 0xFF);
        return must(mpeg4::encode_scene(must(mpeg4::parse_scene_text(text)), config_of_clips));
    });
}

TEST_F(Mp4Clip, NeedsSceneFileForForeign) {
    const Scene scene = small_scene(40, 30);
    ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 3, {})), "");
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const std::string tagged = read_bytes(folder / "clip.mp4"),
                      bare = without_in_movie(tagged, {"udta", "meta"});
    const auto opened = [&](const std::string& bytes, bool is_described) {
        write_bytes(folder / "foreign.mp4", bytes);
        return is_described ? open_clip(folder / "foreign.mp4", folder / "scene.json")
                            : open_clip(folder / "foreign.mp4");
    };
    for (const char* other : {"Group { children [ Shape { geometry Rectangle {} } ] }", ""}) {
        const auto described = must(opened(with_scene_text(bare, other), true));
        const auto frames = must(read_all(*described));
        ASSERT_EQ(frames.size(), 3U);
        EXPECT_TRUE(same_plane(frames[2].depth, test_frame(scene, 2, {}).depth));
        // A clip of ours has tags, by which a scene file is enough.
        EXPECT_EQ(message(opened(with_scene_text(tagged, other), true)), "");
        EXPECT_TRUE(
            is_refused(opened(with_scene_text(tagged, other), false), "describe it with a scene file"));
    }
    EXPECT_TRUE(is_refused(opened(with_scene_text(bare, ""), false), "its MPEG-4 scene is damaged"));
}

TEST_F(Mp4Clip, NamesTagOfMissingTimes) {
    Scene scene = small_scene(16, 12, 10);
    scene.rate = *rate_of_own_times(uneven_times(4));
    ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 10, {})), "");
    EXPECT_TRUE(is_refused(open_clip(folder / "clip.mp4"),
                           "its tag T3D_TIMES has the times of 4 frames, but depth has 10 pictures"));
}

/// As hours of many tracks have: their tables are no reason to refuse the file.
TEST_F(Mp4Clip, ReadsLongMovieBox) {
    const Scene scene = scene_with_heights(40, 30, 12, 16);
    ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 3, all_planes)), "");
    std::string file = read_bytes(folder / "clip.mp4");
    const FoundBox movie = boxes_of(file).back();
    constexpr std::size_t more = std::size_t{65} << 20;
    file.replace(movie.at, 4, word(movie.end - movie.at + more));
    const std::size_t whole = file.size() + more;
    file += word(more) + "free";
    file.resize(whole);
    write_bytes(folder / "long.mp4", file);
    EXPECT_TRUE(same_frames(must(read_clip(folder / "long.mp4")), test_frames(scene, 3, all_planes)));
}

TEST_F(Mp4Clip, KeepsSoundInStep) {
    write_sounding_film(folder / "film.mp4", tone(20, 2.0));
    const auto source = must(SoundTrack::open(folder / "film.mp4"));
    ASSERT_TRUE(source);
    const Scene scene = small_scene(16, 12, 12);
    for (const std::int64_t first : {0, 24}) {  // the film from there on
        const std::int64_t from_ns = scene.rate.time_ns(first);
        const SoundPart part{folder / "film.mp4", from_ns, from_ns + 1'000'000'000};
        ASSERT_EQ(message(write_clip(folder / "clip.mp4", scene, 30, {}, exact_clip, part)), "");
        const auto frames = must(read_clip(folder / "clip.mp4"));
        EXPECT_EQ(frames.size(), 30U) << "sound makes a clip no longer";
        const auto track = must(SoundTrack::open(folder / "clip.mp4"));
        ASSERT_TRUE(track);
        const auto heard = heard_in(*track, 0, SoundTrack::rate);
        const auto wanted = heard_in(*source, first * SoundTrack::rate / 30, SoundTrack::rate);
        constexpr std::size_t packets = 4096;  // at the ends: they begin before, or end after
        // Times are whole milliseconds: one of them, of 20 Hz.
        EXPECT_LE(largest_difference(heard, wanted, packets, packets), 0.5 * 2 * 3.15 * 20 * 0.001) << first;
    }
    write_sounding_clip(folder / "floats.mkv", tone(440, 0.5));
    const std::string of_floats = message(create_clip(folder / "out.mp4", scene, {}, Existing::keep,
                                                      SoundPart{folder / "floats.mkv", 0, 1'000'000'000}));
#if LIBAVFORMAT_VERSION_MAJOR >= 61
    EXPECT_EQ(of_floats, "") << "FFmpeg 7 puts floats into MP4";
#else
    EXPECT_TRUE(has_words(of_floats, "cannot hold sound of codec pcm_f32le"));
#endif
}

TEST_F(Mp4Clip, LeavesNothingOnFullDisk) {
    const Scene scene = small_scene(64, 48, 16);
    ASSERT_EQ(message(write_clip(folder / "whole.mp4", scene, 6, {})), "");
    const auto whole = fs::file_size(folder / "whole.mp4");
    for (std::uintmax_t room = 0; room < whole; room += whole / 40) {
        const FullDisk full(room);
        EXPECT_TRUE(
            is_refused(write_clip(folder / "clip.mp4", scene, 6, {}), "cannot be written", ErrorKind::input))
            << room;
        EXPECT_FALSE(fs::exists(folder / "clip.mp4"));
    }
    const FullDisk full(whole - 1);
    EXPECT_FALSE(write_clip(folder / "clip.mp4", scene, 6, {})) << "without the scene's last byte";
}

// A static MPEG-4 scene in one MP4 file, as it is written.

Result<void> write_still(const fs::path& file, const Scene& scene, const Planes& planes,
                         Existing existing = Existing::keep) {
    return write_all(create_mp4_stills(file, scene, existing), test_frames(scene, 1, planes));
}

/// A track of pictures says by object type 0x6D that they are PNG, and is auxiliary to the first.
TEST(Mp4StillsWriter, WritesPngTrackPerPlane) {
    const TemporaryFolder folder;
    for (const bool has_colour : {true, false}) {
        const fs::path file = folder / (has_colour ? "all.mp4" : "some.mp4");
        const Scene scene = small_scene(24, 16, 16);
        const Planes planes{has_colour, true, has_colour};
        ASSERT_EQ(message(write_still(file, scene, planes)), "");
        const std::string bytes = read_bytes(file);
        const auto tracks = tracks_in(bytes);
        const std::size_t pictures = has_colour ? 4 : 2;
        ASSERT_EQ(tracks.size(), pictures + 2);
        for (std::size_t k = 0; k < pictures; ++k) {
            EXPECT_EQ(handler_of(bytes, tracks[k]), k == 0 ? "vide" : "auxv");
            EXPECT_EQ(id_of(bytes, tracks[k]), k + 1);
            const std::string track = bytes_in(bytes, tracks[k]);
            const std::size_t config = track.find("esds");
            ASSERT_NE(config, std::string::npos);
            const std::size_t png = track.find('\x6d', config), visual = track.find('\x11', config);
            EXPECT_EQ(visual, png + 1) << "a visual stream, of PNG";
            EXPECT_EQ(track.find("vdep") == std::string::npos, k == 0);
        }
        EXPECT_EQ(handler_of(bytes, tracks[pictures]), "sdsm");
        EXPECT_EQ(handler_of(bytes, tracks[pictures + 1]), "odsm");
        EXPECT_TRUE(same_frames(must(read_clip(file)), test_frames(scene, 1, planes)));
    }
}

TEST(Mp4StillsWriter, WritesOneFrameOnly) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(24, 16);
    for (const char* name : {"a.mp4", "b.mp4"}) ASSERT_EQ(message(write_still(folder / name, scene, {})), "");
    const std::string bytes = read_bytes(folder / "a.mp4");
    EXPECT_EQ(bytes, read_bytes(folder / "b.mp4"));
    EXPECT_NE(message(write_still(folder / "a.mp4", scene, all_planes)), "");
    EXPECT_EQ(read_bytes(folder / "a.mp4"), bytes);
    EXPECT_EQ(message(write_still(folder / "a.mp4", scene, all_planes, Existing::replace)), "");
    EXPECT_NE(read_bytes(folder / "a.mp4"), bytes);
    auto writer = must(create_mp4_stills(folder / "none.mp4", scene, Existing::keep));
    EXPECT_TRUE(is_refused(writer->finish(), "no frame was given"));
    writer.reset();  // frees the name
    writer = must(create_mp4_stills(folder / "none.mp4", scene, Existing::keep));
    ASSERT_EQ(message(writer->write(test_frame(scene, 0, {}))), "");
    EXPECT_NE(message(writer->write(test_frame(scene, 1, {}))), "");
    writer.reset();
    EXPECT_FALSE(fs::exists(folder / "none.mp4"));
}

}  // namespace
}  // namespace touchable::test
