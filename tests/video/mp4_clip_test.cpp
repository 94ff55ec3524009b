// Clips in MP4: what was written comes back, by way of tags and an MPEG-4 scene, or of the scene alone.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "engine/clip/clip_file.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/mpeg4/boxes.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/picture/sound.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/full_disk.hpp"
#include "tests/video/mp4_boxes.hpp"
#include "tests/video/sounding_clip.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

Result<void> write_mp4(const fs::path& file, const SceneDescription& described, int frames,
                       const Planes& planes, const ClipStorage& storage = exact_clip,
                       const std::optional<SoundPart>& sound = {}) {
    auto writer = create_mp4_clip(file, described, storage, Existing::replace, sound);
    if (!writer) return writer.error();
    for (int n = 0; n < frames; ++n)
        if (auto written = (*writer)->write(test_frame(described.scene, n, planes)); !written) return written;
    return (*writer)->finish();
}

Scene scene_of_bits(int width, int height, int depth_bits, int height_bits) {
    Scene scene = small_scene(width, height, depth_bits);
    scene.height_coding = {1.5, HeightUnits::levels, static_cast<std::uint16_t>((1 << height_bits) - 1)};
    return scene;
}

void expect_mp4_comes_back(const fs::path& file, const Scene& scene, int frames, const Planes& planes,
                           const ClipStorage& storage = exact_clip) {
    ASSERT_EQ(message(write_mp4(file, scene, frames, planes, storage)), "");
    auto reader = open_clip(file);
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), frames);
    EXPECT_EQ(scene_to_json((*reader)->scene()), scene_to_json(scene));
    for (const TrackInfo& track : (*reader)->tracks()) EXPECT_TRUE(track.lossless) << track.role;
    const auto read = read_all(**reader);
    ASSERT_EQ(message(read), "");
    ASSERT_EQ(read->size(), static_cast<std::size_t>(frames));
    reader->reset();  // the frames' storage keeps their planes
    for (int n = 0; n < frames; ++n)
        EXPECT_TRUE(same_frame((*read)[static_cast<std::size_t>(n)], test_frame(scene, n, planes)))
            << scene.width << 'x' << scene.height << ", " << scene.depth_bits << " bits, frame " << n;
}

TEST(Mp4Clip, EveryBitComesBackWithOrWithoutItsOtherPlanes) {
    const TemporaryFolder folder;
    for (const int bits : {8, 9, 10, 12, 16})
        for (const int height_bits : {8, 16}) {
            const Scene scene = scene_of_bits(63, 47, bits, height_bits);
            expect_mp4_comes_back(folder / "clip.mp4", scene, 3, all_planes);
            expect_mp4_comes_back(folder / "clip.mp4", scene, 2, all_planes, {Archive::small, true});
        }
    for (int choice = 0; choice < 8; ++choice)
        expect_mp4_comes_back(folder / "clip.mp4", scene_of_bits(40, 30, 16, 8), 2,
                              {(choice & 1) != 0, (choice & 2) != 0, (choice & 4) != 0});
}

TEST(Mp4Clip, AnySizeComesBackAndWhatH264HasNotIsRefused) {
    const TemporaryFolder folder;
    constexpr int sizes[][2] = {{1, 1}, {1, 40}, {40, 1}, {2, 2}, {17, 16}, {16, 33}, {16384, 2}};
    for (const auto& [width, height] : sizes)
        expect_mp4_comes_back(folder / "clip.mp4", scene_of_bits(width, height, 12, 16), 2, all_planes);
    EXPECT_TRUE(is_refused(write_mp4(folder / "wide.mp4", small_scene(16385, 1), 1, {}), "from 1 to 16384"));
    const Scene largest = small_scene(16384, 16384);
    const std::vector<std::uint8_t> row(16384, 77);
    RawFrame frame;
    frame.depth = {row.data(), 0, 16384, 16384, 1, 1};  // every row is the same one
    auto writer = create_mp4_clip(folder / "large.mp4", largest);
    ASSERT_EQ(message(writer), "");
    const auto refused = (*writer)->write(frame);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    EXPECT_NE(refused.error().message.find("pictures of 16384x16384 cannot be stored"), std::string::npos)
        << refused.error().message;
    EXPECT_FALSE((*writer)->finish());
    EXPECT_FALSE(fs::exists(folder / "wide.mp4") || fs::exists(folder / "large.mp4"));
}

TEST(Mp4Clip, AScenesOwnWordsComeBack) {
    const TemporaryFolder folder;
    Scene scene = small_scene(40, 30, 12);
    scene.name = "gr\xc3\xbc\xc3\x9f \"Gott\"";
    scene.haptic.stiffness = {0.1, 1.0 / 3.0};
    scene.colour_camera.reset();
    scene.default_properties.stiffness = 321;
    scene.depth.near_is_high = false;
    scene.depth.invalid_codes[0] = 4095;
    scene.depth.invalid_code_count = 1;
    derive_valid_range(scene.depth);
    expect_mp4_comes_back(folder / "clip.mp4", scene, 2, all_planes);
    scene = small_scene(40, 30, 16);
    scene.depth = {};
    scene.depth.kind = DepthCodingKind::metric;
    scene.depth.scale = 0.25;
    scene.depth.near = 100;
    scene.depth.far = 5000;
    scene.depth.code_max = 65535;
    derive_valid_range(scene.depth);
    scene.height_coding = {3, HeightUnits::world, 255};
    expect_mp4_comes_back(folder / "clip.mp4", scene, 2, all_planes);
}

TEST(Mp4Clip, FiltersThatAreLeftOpenStayOpen) {
    const TemporaryFolder folder;
    SceneDescription described(small_scene(40, 30, 12));
    described.unstated.filters = {.median = true, .terraces = true};
    ASSERT_EQ(message(write_mp4(folder / "clip.mp4", described, 1, {})), "");
    const auto reader = open_clip(folder / "clip.mp4");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->unstated_filters(), described.unstated.filters);
}

std::vector<std::int64_t> uneven_times(int frames) {
    std::vector<std::int64_t> times_ns;
    for (std::int64_t n = 0; n < frames; ++n)
        times_ns.push_back(1'000'001 * n + 300'000'000 * (n / 7) + n * n * 777);
    return times_ns;
}

/// Every frame, in an order that goes to and fro.
void expect_same_by_any_way(const fs::path& file, const Scene& scene, int frames) {
    auto reader = open_clip(file);
    ASSERT_EQ(message(reader), "");
    std::vector<int> order(static_cast<std::size_t>(frames));
    Numbers numbers(11);
    for (std::size_t k = 0; k < order.size(); ++k) {
        order[k] = static_cast<int>(k);
        std::swap(order[k], order[static_cast<std::size_t>(numbers.below(static_cast<int>(k) + 1))]);
    }
    for (const int n : order) {
        EXPECT_EQ((*reader)->access_point(n), n - n % 15);
        ASSERT_EQ(message((*reader)->seek(n)), "") << n;
        for (int k = n; k < std::min(n + 2, frames); ++k) {
            const auto frame = (*reader)->next();
            ASSERT_EQ(message(frame), "") << k;
            ASSERT_TRUE(frame->has_value()) << k;
            EXPECT_TRUE(same_frame(**frame, test_frame(scene, k, all_planes))) << n << ' ' << k;
        }
    }
    ASSERT_EQ(message((*reader)->rewind()), "");
    const auto again = read_all(**reader);
    ASSERT_EQ(message(again), "");
    EXPECT_EQ(again->size(), static_cast<std::size_t>(frames));
    EXPECT_TRUE(is_refused((*reader)->seek(frames + 1), "has no frame"));
}

TEST(Mp4Clip, IsReadFromAnyFrameAtAnyRate) {
    const TemporaryFolder folder;
    constexpr int frames = 40;
    Scene scene = scene_of_bits(16, 12, 12, 16);
    for (const FrameRate& rate :
         {FrameRate{30000, 1001}, {1, 7}, {1000, 1}, *rate_of_own_times(uneven_times(frames))}) {
        scene.rate = rate;
        expect_mp4_comes_back(folder / "clip.mp4", scene, frames, all_planes);  // compares the times too
        expect_same_by_any_way(folder / "clip.mp4", scene, frames);
    }
    scene.rate = {30, 1};
    scene.width = 320;  // on a thread for each track
    scene.height = 160;
    expect_mp4_comes_back(folder / "clip.mp4", scene, 17, all_planes);
    expect_same_by_any_way(folder / "clip.mp4", scene, 17);
    scene.rate = {1001, 1};
    EXPECT_TRUE(is_refused(write_mp4(folder / "fast.mp4", scene, 1, {}), "a clip has at most 1000"));
}

TEST(Mp4Clip, OneFrameIsAClip) {
    const TemporaryFolder folder;
    const Scene scene = scene_of_bits(16, 12, 16, 8);
    expect_mp4_comes_back(folder / "clip.mp4", scene, 1, all_planes);
    expect_same_by_any_way(folder / "clip.mp4", scene, 1);
    EXPECT_TRUE(is_refused(write_mp4(folder / "none.mp4", scene, 0, {}), "no frame was given"));
    EXPECT_FALSE(fs::exists(folder / "none.mp4"));
}

TEST(Mp4Clip, TheSameFramesGiveTheSameFile) {
    const TemporaryFolder folder;
    for (const char* name : {"a.mp4", "b.mp4"})
        ASSERT_EQ(message(write_mp4(folder / name, small_scene(40, 30, 16), 5, all_planes)), "");
    EXPECT_EQ(read_bytes(folder / "a.mp4"), read_bytes(folder / "b.mp4"));
}

TEST(Mp4Clip, ColourThatIsSeenIsNearAndIsWhatTheWriterGives) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(63, 47, 16);
    const Planes ramps{true, true, true, false};
    auto writer = create_mp4_clip(folder / "clip.mp4", scene, {Archive::fast, false, true});
    ASSERT_EQ(message(writer), "");
    std::vector<std::string> given;
    for (int n = 0; n < 4; ++n) {
        ASSERT_EQ(message((*writer)->write(test_frame(scene, n, ramps))), "");
        const PlaneView colour = (*writer)->stored_colour();
        ASSERT_FALSE(colour.empty());
        std::string& bytes = given.emplace_back();
        for (int y = 0; y < colour.height; ++y)
            bytes.append(reinterpret_cast<const char*>(colour.row(y)),
                         static_cast<std::size_t>(3 * colour.width));
    }
    ASSERT_EQ(message((*writer)->finish()), "");
    auto reader = open_clip(folder / "clip.mp4");
    ASSERT_EQ(message(reader), "");
    for (const TrackInfo& track : (*reader)->tracks()) EXPECT_EQ(track.lossless, track.role != "colour");
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 4U);
    for (std::size_t n = 0; n < 4; ++n) {
        const PlaneView& colour = (*frames)[n].colour;
        double error = 0;
        const RawFrame exact = test_frame(scene, static_cast<std::int64_t>(n), ramps);
        for (int y = 0; y < colour.height; ++y) {
            EXPECT_EQ(
                std::memcmp(colour.row(y),
                            given[n].data() + std::size_t{3} * 63 * static_cast<std::size_t>(y), 3 * 63),
                0);
            for (int x = 0; x < 63; ++x)
                for (int c = 0; c < 3; ++c)
                    error += std::abs(colour.sample(x, y, c) - exact.colour.sample(x, y, c));
        }
        EXPECT_LT(error / (63 * 47 * 3), 4) << n;
        EXPECT_TRUE(same_plane((*frames)[n].depth, exact.depth));
    }
}

/// What its MPEG-4 scene says, changed in place: other values of numbers take as many bits.
std::string with_nodes_changed(std::string file, const std::function<void(mpeg4::ClipNodes&)>& change) {
    const auto tracks = tracks_in(file);
    const auto scene = std::find_if(tracks.begin(), tracks.end(),
                                    [&](const FoundBox& track) { return handler_of(file, track) == "sdsm"; });
    EXPECT_NE(scene, tracks.end());
    const std::string sample = sample_of(file, *scene);
    const mpeg4::Bytes bytes(sample.begin(), sample.end());
    const mpeg4::BifsConfig config{.node_id_bits = 1, .prototype_id_bits = 2};
    const auto tree = mpeg4::decode_scene(bytes, config);
    EXPECT_EQ(message(tree), "");
    auto nodes = mpeg4::clip_nodes_of(*tree);
    EXPECT_EQ(message(nodes), "");
    change(*nodes);
    auto changed = mpeg4::encode_scene(mpeg4::scene_of(*nodes, 40, 30), config);
    EXPECT_EQ(message(changed), "");
    changed->push_back(0);
    EXPECT_EQ(changed->size(), sample.size());
    file.replace(file.find(sample), sample.size(), std::string(changed->begin(), changed->end()));
    return file;
}

TEST(Mp4Clip, ASceneThatWasEditedStandsOverItsTagAndSaysSo) {
    const TemporaryFolder folder;
    Scene scene = scene_of_bits(40, 30, 12, 8);
    scene.haptic.dynamic_friction = {0, 0.5};  // not as a scene has it that says nothing
    ASSERT_EQ(message(write_mp4(folder / "clip.mp4", scene, 2, all_planes)), "");
    const std::string bytes = read_bytes(folder / "clip.mp4");
    const auto opened = [&](const std::function<void(mpeg4::ClipNodes&)>& change) {
        write_bytes(folder / "edited.mp4", with_nodes_changed(bytes, change));
        return open_clip(folder / "edited.mp4");
    };
    const auto unchanged = opened([](mpeg4::ClipNodes&) {});
    ASSERT_EQ(message(unchanged), "");
    EXPECT_TRUE((*unchanged)->notes().empty());
    const auto edited = opened([](mpeg4::ClipNodes& nodes) {
        nodes.max_height = 2.5;
        nodes.far = 150;
        nodes.focal_length *= 2;
        nodes.ranges.dynamic_friction = {0, 0.25};
    });
    ASSERT_EQ(message(edited), "");
    ASSERT_EQ((*edited)->notes().size(), 1U);
    EXPECT_NE((*edited)->notes()[0].find("the scene stands"), std::string::npos);
    scene.height_coding.max_height = 2.5;
    scene.depth.far = 150;
    scene.camera.fx = scene.camera.fy = 100;
    scene.haptic.dynamic_friction = {0, 0.25};
    derive_valid_range(scene.depth);
    EXPECT_EQ(scene_to_json((*edited)->scene()), scene_to_json(scene));
    const auto frame = (*edited)->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_TRUE(same_plane((*frame)->depth, test_frame(scene, 0, all_planes).depth)) << "with its low bits";
    const auto far = opened([](mpeg4::ClipNodes& nodes) { nodes.far = 5; });
    EXPECT_TRUE(is_refused(far, "edited.mp4: its MPEG-4 scene: depth.near"));
    const auto flat = opened([](mpeg4::ClipNodes& nodes) { nodes.pixel_width = 0; });
    EXPECT_TRUE(is_refused(flat, "focalLength and pixelWidth must be above 0"));
    const auto shared = opened([](mpeg4::ClipNodes& nodes) { nodes.haptic = nodes.colour; });
    EXPECT_TRUE(is_refused(shared, "its haptic is the same track as its colour"));
    const auto missing = opened([](mpeg4::ClipNodes& nodes) { nodes.haptic->url.object = 77; });
    EXPECT_TRUE(is_refused(missing, "haptic is object 77, which is no track"));
}

TEST(Mp4Clip, AnotherSceneThanItsOwnIsReadWithAllBits) {
    const TemporaryFolder folder;
    Scene scene = scene_of_bits(40, 30, 12, 16);
    ASSERT_EQ(message(write_mp4(folder / "clip.mp4", scene, 2, all_planes)), "");
    scene.name = "another";
    write_bytes(folder / "scene.json", scene_to_json(scene));
    auto reader = open_clip(folder / "clip.mp4", folder / "scene.json");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->scene().name, "another");
    const auto frame = (*reader)->next();
    ASSERT_EQ(message(frame), "");
    EXPECT_TRUE(same_frame(**frame, test_frame(scene, 0, all_planes)));
    scene.depth_bits = 16;
    scene.depth.code_max = 65535;
    derive_valid_range(scene.depth);
    write_bytes(folder / "scene.json", scene_to_json(scene));
    EXPECT_TRUE(is_refused(open_clip(folder / "clip.mp4", folder / "scene.json"), "is 12-bit grey"));
}

TEST(Mp4Clip, WithoutTagsItsSceneDescribesItAndLowBitsAreSaidToBeLeftOut) {
    const TemporaryFolder folder;
    Scene scene = scene_of_bits(40, 30, 12, 16);
    scene.rate = {30000, 1001};
    scene.camera = camera_from_focal_length(50, 1, 40, 30);
    scene.haptic.static_friction = {0.2, 0.9};
    ASSERT_EQ(message(write_mp4(folder / "clip.mp4", scene, 20, all_planes)), "");
    write_bytes(folder / "bare.mp4", without_in_movie(read_bytes(folder / "clip.mp4"), {"udta", "meta"}));
    auto reader = open_clip(folder / "bare.mp4");
    ASSERT_EQ(message(reader), "");
    const Scene& found = (*reader)->scene();
    EXPECT_EQ(found.depth_bits, 8);
    EXPECT_EQ((*reader)->access_point(14), 0);
    EXPECT_EQ((*reader)->access_point(17), 15) << "by its own index";
    for (const TrackInfo& track : (*reader)->tracks()) EXPECT_TRUE(track.lossless) << track.role;
    EXPECT_EQ(found.depth.near, 10);
    EXPECT_EQ(found.depth.far, 200);
    EXPECT_NEAR(found.camera.fx, 50, 1e-5);
    EXPECT_EQ(found.camera.cx, scene.camera.cx);
    EXPECT_EQ(found.haptic.static_friction.max, 0.9);
    EXPECT_EQ(found.height_coding.max_height, 1.5);
    EXPECT_EQ(found.rate.num, 30000);
    EXPECT_EQ(found.rate.den, 1001);
    ASSERT_EQ((*reader)->notes().size(), 2U);
    EXPECT_EQ(
        (*reader)->notes()[0],
        "the low bits of depth, in its track depth_low, are left out: no tag T3D_SCENE says what they are");
    EXPECT_NE((*reader)->notes()[1].find("the low bits of height"), std::string::npos);
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 20U);
    const RawFrame &read = (*frames)[17], exact = test_frame(scene, 17, all_planes);
    EXPECT_TRUE(same_plane(read.haptic, exact.haptic));
    EXPECT_TRUE(same_plane(read.colour, exact.colour));
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) {
            ASSERT_EQ(read.depth.sample(x, y), exact.depth.sample(x, y) >> 4);
            ASSERT_EQ(read.height.sample(x, y), exact.height.sample(x, y) >> 8);
        }
    // A scene file says what the tag did.
    write_bytes(folder / "scene.json", scene_to_json(scene));
    auto told = open_clip(folder / "bare.mp4", folder / "scene.json");
    ASSERT_EQ(message(told), "");
    EXPECT_TRUE((*told)->notes().empty()) << (*told)->notes()[0];
    EXPECT_TRUE(same_frame(**(*told)->next(), test_frame(scene, 0, all_planes)));
}

TEST(Mp4Clip, WithoutASceneItsTagsAndNamesDescribeIt) {
    const TemporaryFolder folder;
    const Scene scene = scene_of_bits(40, 30, 12, 16);
    ASSERT_EQ(message(write_mp4(folder / "clip.mp4", scene, 3, all_planes)), "");
    std::string bytes = read_bytes(folder / "clip.mp4");
    for (const char* handler : {"sdsm", "odsm"}) {
        const auto at = bytes.find(handler);
        ASSERT_NE(at, std::string::npos);
        bytes.replace(at, 4, "none");
    }
    write_bytes(folder / "bare.mp4", bytes);
    const auto frames = read_clip(folder / "bare.mp4");
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    EXPECT_TRUE(same_frame(frames->at(2), test_frame(scene, 2, all_planes)));
}

/// Another scene in place of the file's own.
std::string with_scene(std::string file, const std::string& text) {
    const auto tracks = tracks_in(file);
    const auto scene = std::find_if(tracks.begin(), tracks.end(),
                                    [&](const FoundBox& track) { return handler_of(file, track) == "sdsm"; });
    const std::string sample = sample_of(file, *scene);
    mpeg4::Bytes bytes(sample.size(), 0xFF);
    if (!text.empty()) {
        const auto tree = mpeg4::parse_scene_text(text);
        EXPECT_EQ(message(tree), "");
        auto encoded = mpeg4::encode_scene(*tree, {.node_id_bits = 1, .prototype_id_bits = 2});
        EXPECT_EQ(message(encoded), "");
        bytes = std::move(*encoded);
        EXPECT_LE(bytes.size(), sample.size());
        bytes.resize(sample.size());
    }
    return file.replace(file.find(sample), sample.size(), std::string(bytes.begin(), bytes.end()));
}

TEST(Mp4Clip, AForeignFileWithAnotherSceneIsAVideoToWhoeverDescribesIt) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(40, 30);
    ASSERT_EQ(message(write_mp4(folder / "clip.mp4", scene, 3, {})), "");
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const std::string tagged = read_bytes(folder / "clip.mp4"),
                      bare = without_in_movie(tagged, {"udta", "meta"});
    const auto opened = [&](const std::string& bytes, bool is_described) {
        write_bytes(folder / "foreign.mp4", bytes);
        return is_described ? open_clip(folder / "foreign.mp4", folder / "scene.json")
                            : open_clip(folder / "foreign.mp4");
    };
    for (const char* other : {"Group { children [ Shape { geometry Rectangle {} } ] }", ""}) {
        auto described = opened(with_scene(bare, other), true);
        ASSERT_EQ(message(described), "") << other;
        const auto frames = read_all(**described);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 3U);
        EXPECT_TRUE(same_plane((*frames)[2].depth, test_frame(scene, 2, {}).depth));
        // A clip of ours has tags, by which a scene file is enough.
        EXPECT_EQ(message(opened(with_scene(tagged, other), true)), "");
        EXPECT_TRUE(is_refused(opened(with_scene(tagged, other), false), "describe it with a scene file"));
    }
    const auto unknown = opened(with_scene(bare, ""), false);
    EXPECT_TRUE(is_refused(unknown, "its MPEG-4 scene is damaged"));
}

TEST(Mp4Clip, TimesThatAreTooFewAreToldByTheNameOfTheirTag) {
    const TemporaryFolder folder;
    Scene scene = small_scene(16, 12, 10);
    scene.rate = *rate_of_own_times(uneven_times(4));
    ASSERT_EQ(message(write_mp4(folder / "clip.mp4", scene, 10, {})), "");
    const std::string refused = message(open_clip(folder / "clip.mp4"));
    EXPECT_NE(refused.find("its tag T3D_TIMES has the times of 4 frames, but depth has 10 pictures"),
              std::string::npos)
        << refused;
}

/// As hours of many tracks have: their tables are no reason to refuse the file.
TEST(Mp4Clip, AMovieBoxOfAnyLengthIsRead) {
    const TemporaryFolder folder;
    const Scene scene = scene_of_bits(40, 30, 12, 16);
    ASSERT_EQ(message(write_mp4(folder / "clip.mp4", scene, 3, all_planes)), "");
    std::string file = read_bytes(folder / "clip.mp4");
    const FoundBox movie = boxes_of(file).back();
    constexpr std::size_t more = std::size_t{65} << 20;
    const auto put_size = [&file](std::size_t at, std::size_t size) {
        for (const int shift : {24, 16, 8, 0}) file[at++] = static_cast<char>(size >> shift);
    };
    put_size(movie.at, movie.end - movie.at + more);
    const std::size_t at = file.size();
    file += "....free";
    put_size(at, more);
    file.resize(at + more);
    write_bytes(folder / "long.mp4", file);
    const auto frames = read_clip(folder / "long.mp4");
    ASSERT_EQ(message(frames), "");
    ASSERT_EQ(frames->size(), 3U);
    EXPECT_TRUE(same_frame(frames->at(2), test_frame(scene, 2, all_planes)));
}

TEST(Mp4Clip, ItsSoundIsHeardWithTheSameFrames) {
    const TemporaryFolder folder;
    const auto sound = tone(20, 2.0);
    {
        auto film = FilmWriter::create(folder / "film.mp4", Existing::keep);
        ASSERT_EQ(message(film), "");
        const std::vector<std::uint8_t> grey(3 * 64 * 48, 99);
        ASSERT_EQ(message((*film)->add({grey.data(), 3 * 64, 64, 48, 1, 3}, 0)), "");
        ASSERT_EQ(message((*film)->add_sound(0, sound)), "");
        ASSERT_EQ(message((*film)->finish(60)), "");
    }
    auto source = SoundTrack::open(folder / "film.mp4");
    ASSERT_EQ(message(source), "");
    ASSERT_TRUE(*source);
    const Scene scene = small_scene(16, 12, 12);
    for (const std::int64_t first : {0, 24}) {  // the film from there on
        const std::int64_t from_ns = scene.rate.time_ns(first);
        ASSERT_EQ(message(write_mp4(folder / "clip.mp4", scene, 30, {}, exact_clip,
                                    SoundPart{folder / "film.mp4", from_ns, from_ns + 1'000'000'000})),
                  "");
        const auto frames = read_clip(folder / "clip.mp4");
        ASSERT_EQ(message(frames), "");
        EXPECT_EQ(frames->size(), 30U) << "sound makes a clip no longer";
        auto track = SoundTrack::open(folder / "clip.mp4");
        ASSERT_EQ(message(track), "");
        ASSERT_TRUE(*track);
        std::vector<StereoSample> heard(SoundTrack::rate), wanted(SoundTrack::rate);
        (*track)->read(heard);
        (*source)->seek(first * SoundTrack::rate / 30);
        (*source)->read(wanted);
        double largest = 0;
        constexpr std::size_t packets = 4096;  // at the ends: they begin before, or end after
        for (std::size_t k = packets; k + packets < heard.size(); ++k)
            largest = std::max<double>(largest, std::abs(heard[k].left - wanted[k].left));
        // Times are whole milliseconds: one of them, of 20 Hz.
        EXPECT_LE(largest, 0.5 * 2 * 3.15 * 20 * 0.001) << first;
    }
    write_sounding_clip(folder / "floats.mkv", tone(440, 0.5));
    const std::string of_floats = message(create_mp4_clip(
        folder / "out.mp4", scene, {}, Existing::keep, SoundPart{folder / "floats.mkv", 0, 1'000'000'000}));
#if LIBAVFORMAT_VERSION_MAJOR >= 61
    EXPECT_EQ(of_floats, "") << "FFmpeg 7 puts floats into MP4";
#else
    EXPECT_NE(of_floats.find("cannot hold sound of codec pcm_f32le"), std::string::npos) << of_floats;
#endif
}

TEST(Mp4Clip, ThatStopsWhenItsDiskIsFullIsWholeUpToThere) {
    const TemporaryFolder folder;
    constexpr std::uintmax_t room = 600'000;
    const Scene scene = small_scene(64, 48, 16);
    std::int64_t written = 0;
    {
        const FullDisk full(room);
        const auto clip = create_mp4_clip(folder / "clip.mp4", scene);
        ASSERT_EQ(message(clip), "");
        while (!(*clip)->is_full()) {
            ASSERT_EQ(message((*clip)->write(test_frame(scene, written, {}))), "") << written;
            ASSERT_LT(++written, 1000) << "the disk is larger than it is";
        }
        ASSERT_EQ(message((*clip)->finish()), "");
    }
    EXPECT_LE(fs::file_size(folder / "clip.mp4"), room);
    EXPECT_GT(fs::file_size(folder / "clip.mp4"), room / 2) << "most of the room is for pictures";
    const auto frames = read_clip(folder / "clip.mp4");
    ASSERT_EQ(message(frames), "");
    EXPECT_EQ(std::ssize(*frames), written);
}

TEST(Mp4Clip, AFullDiskIsOneErrorAndLeavesNothing) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(64, 48, 16);
    ASSERT_EQ(message(write_mp4(folder / "whole.mp4", scene, 6, {})), "");
    const auto whole = fs::file_size(folder / "whole.mp4");
    for (std::uintmax_t room = 0; room < whole; room += whole / 40) {
        const FullDisk full(room);
        const auto failed = write_mp4(folder / "clip.mp4", scene, 6, {});
        ASSERT_FALSE(failed) << room;
        EXPECT_EQ(failed.error().kind, ErrorKind::input) << failed.error().message;
        EXPECT_NE(failed.error().message.find("cannot be written"), std::string::npos)
            << failed.error().message;
        EXPECT_FALSE(fs::exists(folder / "clip.mp4"));
    }
    const FullDisk full(whole - 1);
    EXPECT_FALSE(write_mp4(folder / "clip.mp4", scene, 6, {})) << "without the scene's last byte";
}

// A static MPEG-4 scene in one MP4 file, as it is written.

std::string write_stills(const std::filesystem::path& file, const Scene& scene, const Planes& planes,
                         Existing existing = Existing::keep) {
    auto writer = create_mp4_stills(file, scene, existing);
    if (!writer) return writer.error().message;
    if (auto written = (*writer)->write(test_frame(scene, 0, planes)); !written)
        return written.error().message;
    return message((*writer)->finish());
}

/// A track of pictures says by object type 0x6D that they are PNG, and is auxiliary to the first.
TEST(Mp4StillsWriter, EachPlaneIsATrackOfOnePng) {
    const TemporaryFolder folder;
    for (const bool has_colour : {true, false}) {
        const std::filesystem::path file = folder / (has_colour ? "all.mp4" : "some.mp4");
        const Scene scene = small_scene(24, 16, 16);
        const Planes planes{has_colour, true, has_colour};
        ASSERT_EQ(write_stills(file, scene, planes), "");
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
        const auto frames = read_clip(file);
        ASSERT_EQ(message(frames), "");
        ASSERT_EQ(frames->size(), 1U);
        EXPECT_TRUE(same_frame(frames->front(), test_frame(scene, 0, planes)));
    }
}

TEST(Mp4StillsWriter, IsOfOneFrameAndReplacesNothingUnasked) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(24, 16);
    ASSERT_EQ(write_stills(folder / "a.mp4", scene, {}), "");
    ASSERT_EQ(write_stills(folder / "b.mp4", scene, {}), "");
    const std::string bytes = read_bytes(folder / "a.mp4");
    EXPECT_EQ(bytes, read_bytes(folder / "b.mp4"));
    EXPECT_NE(write_stills(folder / "a.mp4", scene, all_planes), "");
    EXPECT_EQ(read_bytes(folder / "a.mp4"), bytes);
    EXPECT_EQ(write_stills(folder / "a.mp4", scene, all_planes, Existing::replace), "");
    EXPECT_NE(read_bytes(folder / "a.mp4"), bytes);
    auto writer = create_mp4_stills(folder / "none.mp4", scene, Existing::keep);
    ASSERT_EQ(message(writer), "");
    EXPECT_TRUE(is_refused((*writer)->finish(), "no frame was given"));
    ASSERT_EQ(message((*writer)->write(test_frame(scene, 0, {}))), "");
    EXPECT_NE(message((*writer)->write(test_frame(scene, 1, {}))), "");
    writer->reset();
    EXPECT_FALSE(std::filesystem::exists(folder / "none.mp4"));
}

}  // namespace
}  // namespace touchable::test
