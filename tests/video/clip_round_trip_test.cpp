// SPDX-License-Identifier: Apache-2.0
#include <set>

#include "engine/clip/readers.hpp"
#include "engine/clip/track_codecs.hpp"
#include "engine/formats/formats_written.hpp"
#include "engine/picture/image.hpp"
#include "engine/scene/plane_memory.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/sweep.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

constexpr Planes depth_only{};

void expect_both(const TemporaryFolder& folder, const Scene& scene, int frames, const Planes& planes) {
    for (const Archive archive : {Archive::fast, Archive::small})
        expect_round_trip(folder / "clip.mkv", scene, frames, planes, {archive, true});
}

struct Clip : ::testing::Test {
    const TemporaryFolder folder;
};

TEST_F(Clip, RoundTripsEveryBitDepth) {
    for (int bits = 8; bits <= 16; ++bits) {
        const Scene scene = scene_with_heights(53, 37, bits, bits);
        expect_both(folder, scene, 3, depth_only);
        expect_both(folder, scene, 3, all_planes);
        expect_both(folder, scene, 2, {true, true, true, false});
    }
}

void expect_in_plane_memory(const PlaneView& plane, const std::string& which) {
    ASSERT_FALSE(plane.empty()) << which;
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(plane.data) % plane_alignment, 0U) << which;
    EXPECT_EQ(static_cast<std::size_t>(plane.stride) % plane_row_alignment, 0U) << which;
    EXPECT_NE(plane_block_of(plane.data, static_cast<std::size_t>(plane.stride * plane.height)), nullptr)
        << which;
}

TEST_F(Clip, KeepsPlanesInPlaneMemory) {
    const auto file = folder / "clip.mkv";
    std::set<std::string> codecs;
    for (const Archive archive : {Archive::fast, Archive::small})
        for (const int bits : {8, 16})
            for (const bool noisy : {true, false}) {
                const Planes planes{true, true, true, noisy};
                ASSERT_EQ(message(write_clip(file, small_scene(53, 37, bits), 2, planes, {archive, true})),
                          "");
                auto reader = must(open_clip(file));
                const auto read = must(read_all(*reader));
                for (const TrackInfo& track : reader->tracks()) codecs.insert(track.codec);
                for (const RawFrame& frame : read)
                    for (const PlaneRole role : all_roles)
                        expect_in_plane_memory(plane_of(frame, role), std::string(role_name(role)) + " of " +
                                                                          std::to_string(bits) + " bits");
            }
    EXPECT_EQ(codecs, (std::set<std::string>{"ffv1", "h264", "t3d2"}));
}

TEST_F(Clip, RoundTripsEverySize) {
    constexpr int sides[] = {2, 3, 4, 5, 7, 8, 15, 16, 17, 31, 32, 33, 65};
    for (const int width : sides)
        for (const int height : sides) {
            expect_round_trip(folder / "clip.mkv", small_scene(width, height, 16), 1, {false, true, true});
            if (width == 7 || height == 33)
                expect_round_trip(folder / "clip.mkv", small_scene(width, height, 10), 1, all_planes,
                                  {Archive::small, true});
        }
}

TEST_F(Clip, RoundTripsLongThinPictures) {
    expect_both(folder, small_scene(16384, 4, 12), 1, all_planes);
    expect_both(folder, small_scene(5, 16384, 16), 1, all_planes);
    expect_both(folder, small_scene(352, 2, 16), 1, all_planes);
    expect_both(folder, small_scene(3, 288, 10), 1, all_planes);
}

/// FFV1, as FFmpeg writes it, has no pictures of these sizes.
TEST_F(Clip, RoundTripsThinnestPictures) {
    constexpr int sizes[][2] = {{1, 1}, {1, 40}, {40, 1}, {3, 289}, {353, 3}, {16384, 2}};
    for (const auto& [width, height] : sizes) expect_both(folder, small_scene(width, height), 2, all_planes);
}

TEST_F(Clip, RoundTripsAnyPlanes) {
    for (int choice = 0; choice < 8; ++choice)
        expect_both(folder, small_scene(40, 30, 16), 2,
                    {(choice & 1) != 0, (choice & 2) != 0, (choice & 4) != 0});
}

TEST_F(Clip, TakesTimesFromItsScene) {
    for (const FrameRate& rate : {FrameRate{30000, 1001}, {24, 1}, {1000, 1}, {997, 1}, {1, 7}, {25, 2}}) {
        Scene scene = small_scene(8, 8);
        scene.rate = rate;
        expect_both(folder, scene, 70, depth_only);  // compares the times too
    }
}

TEST_F(Clip, StoresSceneWithoutItsFolder) {
    Scene scene = small_scene(40, 30, 12);
    scene.name = "gr\xc3\xbc\xc3\x9f \"Gott\"";
    scene.haptic.stiffness = {0.1, 1.0 / 3.0};
    scene.folder = FolderSource{"depth_%d.png", "", "", "", 0, 0};
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 1, depth_only)), "");
    auto reader = must(open_clip(folder / "clip.mkv"));
    scene.folder.reset();
    EXPECT_EQ(scene_to_json(reader->scene()), scene_to_json(scene));
}

// As a clip, as pictures, and as a part of either.
TEST_F(Clip, KeepsUnstatedFiltersUnstated) {
    const Scene scene = small_scene(40, 30, 12);
    SceneDescription described(scene);
    described.unstated.filters = {.median = true, .terraces = true};
    const auto frames = test_frames(scene, 3, depth_only);
    ASSERT_EQ(message(write_all(create_clip(folder / "clip.mkv", described), frames)), "");
    ASSERT_EQ(message(write_all(create_clip(folder / "clip.mp4", described), frames)), "");
    auto pictures = create_image_folder(folder / "clip", described, Existing::keep);
    ASSERT_EQ(message(write_all(std::move(pictures), frames)), "");
    for (const char* name : {"clip.mkv", "clip.mp4", "clip"}) {
        auto reader = must(open_clip(folder / name));
        EXPECT_EQ(reader->unstated_filters(), described.unstated.filters) << name;
        const auto part = must(part_of_clip(std::move(reader), {.first = 1}));
        EXPECT_EQ(part->described().unstated, described.unstated) << name;
    }
}

TEST_F(Clip, ListsItsTracks) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30, 12), 1, all_planes)), "");
    auto reader = must(open_clip(folder / "clip.mkv"));
    const auto& tracks = reader->tracks();
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
    EXPECT_TRUE(reader->notes().empty());
}

TEST_F(Clip, NotesDefaultsOfDepthAlone) {
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), 2, depth_only)), "");
    auto reader = must(open_clip(folder / "clip.mkv"));
    ASSERT_EQ(reader->notes().size(), 1U);
    EXPECT_EQ(reader->notes()[0], "no haptic plane: 0.6 N/mm everywhere, friction 0.4 static, 0.3 dynamic");
}

TEST_F(Clip, RewindsFromAnywhere) {
    const Scene scene = small_scene(20, 20, 16);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 6, all_planes)), "");
    auto reader = must(open_clip(folder / "clip.mkv"));
    for (int given = 0; given <= 7; ++given) {
        for (int n = 0; n < given; ++n) ASSERT_EQ(message(reader->next()), "");
        ASSERT_EQ(message(reader->rewind()), "");
    }
    EXPECT_TRUE(same_frames(must(read_all(*reader)), test_frames(scene, 6, all_planes)));
    EXPECT_FALSE(reader->next()->has_value());  // still the end
}

TEST_F(Clip, IsReproducible) {
    for (const std::string end : {".mkv", ".mp4"}) {
        for (const char* name : {"a", "b"})
            ASSERT_EQ(message(write_clip(folder / (name + end), small_scene(64, 48, 16), 5, all_planes)), "");
        const std::string first = read_bytes(folder / ("a" + end));
        EXPECT_GT(first.size(), 64U * 48U);
        EXPECT_EQ(first, read_bytes(folder / ("b" + end)));
    }
}

TEST_F(Clip, PrefersSceneFile) {
    Scene scene = small_scene(40, 30);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 2, depth_only)), "");
    scene.name = "another";
    scene.rate = {60, 1};
    auto reader = must(open_as(folder / "clip.mkv", scene));
    EXPECT_EQ(reader->scene().name, "another");
    ASSERT_FALSE(reader->notes().empty());
    EXPECT_TRUE(has_words(reader->notes()[0], "played at 60/1"));
    const auto frames = must(read_all(*reader));
    EXPECT_EQ(frames.at(1).time_ns, 16'666'666);
}

TEST_F(Clip, FindsMissingFarPlane) {
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
    auto reader = must(open_as(folder / "clip.mkv", without_far));
    const auto frames = must(read_all(*reader));
    ASSERT_EQ(frames.size(), 3U);  // all of them still to be had
    int deepest = 0;
    for (const RawFrame& frame : frames)
        for (int y = 0; y < 30; ++y)
            for (int x = 0; x < 40; ++x)
                if (frame.depth.sample(x, y) != 4095)
                    deepest = std::max<int>(deepest, frame.depth.sample(x, y));
    const Scene& found = reader->scene();
    EXPECT_DOUBLE_EQ(found.depth.far, deepest * 0.5 * 1.05);
    EXPECT_TRUE(found.depth.is_valid(static_cast<std::uint16_t>(deepest)));
}

TEST_F(Clip, ReadsLossyColour) {
    const Scene scene = small_scene(64, 48, 16);
    const Planes ramps{true, true, true, false};
    ASSERT_EQ(message(write_clip(folder / "exact.mkv", scene, 4, ramps)), "");
    for (const char* codec : {"mjpeg", "mpeg4"}) {
        remux(folder / "exact.mkv", folder / "lossy.mkv", {.transcoded = {{"colour", codec}}});
        const auto frames = must(read_clip(folder / "lossy.mkv"));
        ASSERT_EQ(frames.size(), 4U);
        const RawFrame &lossy = frames.at(3), exact = test_frame(scene, 3, ramps);
        EXPECT_TRUE(same_plane(lossy.depth, exact.depth));
        EXPECT_TRUE(same_plane(lossy.haptic, exact.haptic));
        const double error = mean_difference(lossy.colour, exact.colour);
        EXPECT_LT(error, 4.0) << codec;  // the ramp is nearly grey; range and channels are right
        EXPECT_GT(error, 0.0) << codec;
    }
}

// Depth as hue in the project's own clips and in folders of images.

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

TEST(HueClip, RoundTrips) {
    const TemporaryFolder folder;
    const Scene scene = hue_scene(37, 18);
    const std::vector<RawFrame> frames{hue_frame(scene, 0), hue_frame(scene, 1), hue_frame(scene, 2)};
    ASSERT_EQ(message(write_all(create_clip(folder / "clip.mkv", scene), frames)), "");
    expect_clip(folder / "clip.mkv", scene, frames);
    EXPECT_EQ(must(open_clip(folder / "clip.mkv"))->scene().depth, scene.depth);
}

TEST(HueClip, ReadsPngsAsStored) {
    const TemporaryFolder folder;
    Scene scene = hue_scene(20, 10);
    scene.folder = FolderSource{"d%d.png", "", "", "", 0, 0};
    write_bytes(folder / "scene.json", scene_to_json(scene));
    const RawFrame written = hue_frame(scene, 0);
    ASSERT_EQ(message(write_png(folder / "d0.png", written.depth)), "");
    const auto frames = must(read_clip(folder / "scene.json"));
    EXPECT_TRUE(same_plane(frames.front().depth, written.depth));
}

TEST(HueClip, RejectsDepthOfOtherKind) {
    const TemporaryFolder folder;
    const Scene hue = hue_scene(20, 10), grey = small_scene(20, 10);
    const std::pair<const Scene&, RawFrame> wrong[] = {{hue, test_frame(grey, 0, {})},
                                                       {grey, hue_frame(hue, 0)}};
    for (const auto& [scene, frame] : wrong) {
        EXPECT_TRUE(is_refused(write_all(create_clip(folder / "clip.mkv", scene), {frame}), "needs 8-bit"));
    }
}

// Colour that is not shown is not decoded, and all else stays as it is.

Result<std::vector<RawFrame>> read_without_colour(const std::filesystem::path& file, bool twice = false) {
    auto reader = open_clip(file);
    if (!reader) return reader.error();
    (*reader)->leave_out_colour();
    if (twice) {
        if (auto first = read_all(**reader); !first) return first;
        if (auto back = (*reader)->rewind(); !back) return back.error();
    }
    return read_all(**reader);
}

TEST(LeftOutColour, KeepsOtherPlanes) {
    const TemporaryFolder folder;
    const auto file = folder / "clip.mkv";
    ASSERT_EQ(message(write_clip(file, small_scene(40, 30, 16), 6, all_planes)), "");
    const auto whole = must(read_clip(file));
    for (const bool twice : {false, true}) {
        const auto less = must(read_without_colour(file, twice));
        ASSERT_EQ(less.size(), whole.size());
        for (std::size_t n = 0; n < whole.size(); ++n) {
            RawFrame expected = whole[n], frame = less[n];
            EXPECT_EQ(frame.colour.empty(), n > 0 || twice) << "the first frame tells what there is";
            expected.colour = frame.colour = {};
            EXPECT_TRUE(same_frame(expected, frame)) << n;
        }
    }
}

TEST(LeftOutColour, StillFindsDamage) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "whole.mkv", small_scene(8, 8, 12), 2, {true})), "");
    const std::string bytes = read_bytes(folder / "whole.mkv");
    std::size_t refused = 0;
    for (std::size_t at = 0; at < bytes.size(); at += 3 * sweep_step()) {
        std::string damaged = bytes;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x10);
        write_anew(folder / "damaged.mkv", damaged);
        const std::string error = message(read_clip(folder / "damaged.mkv"));
        EXPECT_EQ(message(read_without_colour(folder / "damaged.mkv")), error) << "byte " << at;
        refused += !error.empty();
    }
    EXPECT_GT(refused, 50 / sweep_step());
}

// A picture that does not change is stored once, and given again at no cost.

constexpr Planes still_planes{true, true, true, false};

/// Depth changes in every frame, colour in every fifth, haptic at frame 7, height never.
RawFrame partly_still(const Scene& scene, std::int64_t number) {
    RawFrame frame = test_frame(scene, number, still_planes);
    const auto still = [&](PlaneView RawFrame::*plane, std::int64_t since) {
        const RawFrame other = test_frame(scene, since, still_planes);
        frame.*plane = other.*plane;
        frame.storage = std::make_shared<std::pair<std::shared_ptr<const void>, std::shared_ptr<const void>>>(
            frame.storage, other.storage);
    };
    still(&RawFrame::colour, number - number % 5);
    still(&RawFrame::haptic, number < 7 ? 0 : 7);
    still(&RawFrame::height, 0);
    return frame;
}

constexpr int still_frames = 37;

std::vector<RawFrame> partly_still_frames(const Scene& scene) {
    std::vector<RawFrame> frames;
    for (int n = 0; n < still_frames; ++n) frames.push_back(partly_still(scene, n));
    return frames;
}

std::filesystem::path partly_still_clip(const TemporaryFolder& folder, const Scene& scene, Archive archive) {
    const auto file = folder / "still.mkv";
    EXPECT_EQ(message(write_all(create_clip(file, scene, {archive, true}), partly_still_frames(scene))), "");
    return file;
}

TEST(UnchangedPictures, RoundTripFromAnyFrame) {
    for (const Archive archive : {Archive::fast, Archive::small})
        for (const int width : {24, 320}) {
            const TemporaryFolder folder;
            const Scene scene = small_scene(width, 160, 16);
            const auto file = partly_still_clip(folder, scene, archive);
            const auto frames = partly_still_frames(scene);
            expect_clip(file, scene, frames);
            auto reader = must(open_clip(file));
            for (const int n : {36, 9, 6, 15, 21, 29}) expect_seek_to(*reader, n, frames);
        }
}

/// Each stored picture stands for its frames there, too.
TEST(UnchangedPictures, CutClipCountsTheirFrames) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(24, 160, 16);
    const std::string whole = read_bytes(partly_still_clip(folder, scene, Archive::fast));
    std::int64_t before = 0;
    for (const double share : {0.6, 0.8, 0.9, 0.97}) {
        const auto cut = folder / "cut.mkv";
        write_bytes(cut,
                    whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size()))));
        auto reader = open_clip(cut);
        ASSERT_EQ(message(reader), "");
        const std::int64_t count = (*reader)->frame_count().value();
        EXPECT_GT(count, 0.5 * share * still_frames) << "of a cluster at most is lost";
        EXPECT_GE(count, before);
        EXPECT_FALSE((*reader)->scene().rate.own_times);
        before = count;
        for (std::int64_t n = 0; n < count; ++n) {
            const auto frame = (*reader)->next();
            ASSERT_EQ(message(frame), "") << share << ": " << n;
            ASSERT_TRUE(*frame && same_frame(**frame, partly_still(scene, n))) << share << ": " << n;
        }
        EXPECT_FALSE((*reader)->next()->has_value());
    }
}

TEST(UnchangedPictures, AreStoredOncePerGroup) {
    const TemporaryFolder folder;
    const auto file = partly_still_clip(folder, small_scene(24, 16, 16), Archive::fast);
    // Frames 0, 15 and 30 have all; beyond them depth 34, colour 5, 10, 20, 25 and 35, haptic 7.
    EXPECT_EQ(packets(file).size(), 3U * 4U + 34U + 5U + 1U);
}

/// A comparison of frames need compare no sample.
TEST(UnchangedPictures, AreTheSameMemory) {
    const TemporaryFolder folder;
    const auto all = must(read_clip(partly_still_clip(folder, small_scene(24, 16, 16), Archive::fast)));
    for (std::size_t n = 1; n < all.size(); ++n) {
        const RawFrame &before = all[n - 1], &now = all[n];
        EXPECT_EQ(now.height.data, before.height.data) << n;
        EXPECT_EQ(now.haptic.data == before.haptic.data, n != 7) << n;
        EXPECT_EQ(now.colour.data == before.colour.data, n % 5 != 0) << n;
        EXPECT_NE(now.depth.data, before.depth.data) << n;
    }
}

/// A block that is lost is missed, though gaps belong to the format.
TEST(UnchangedPictures, RejectLostPicture) {
    const TemporaryFolder folder;
    const auto file = partly_still_clip(folder, small_scene(24, 16, 16), Archive::fast);
    Remux changes;
    changes.drop = [](const std::string& role, int number) { return role == "colour" && number == 2; };
    remux(file, folder / "lost.mkv", changes);
    EXPECT_TRUE(is_refused(read_clip(folder / "lost.mkv"), "track colour, frame 10: is missing"));
}

// Which coding a track takes, and that each gives back every sample, from any frame, or says that it is
// damaged.

/// Depth and height of more than 8 bits, of which each frame has the samples `value(x, y, frame)`.
using Value = std::function<int(int x, int y, int n)>;

struct Depths {
    Samples depth, height;
};

RawFrame frame_of(const Scene& scene, int n, const Value& value) {
    auto memory = std::make_shared<Depths>();
    RawFrame frame;
    frame.number = n;
    frame.time_ns = scene.rate.time_ns(n);
    const auto fill = [&](Samples& samples) {
        for (int y = 0; y < scene.height; ++y)
            for (int x = 0; x < scene.width; ++x) {
                const int sample = value(x, y, n);
                samples.push_back(static_cast<std::uint8_t>(sample & 0xFF));
                samples.push_back(static_cast<std::uint8_t>(sample >> 8));
            }
        return PlaneView{samples.data(), std::ptrdiff_t{2} * scene.width, scene.width, scene.height, 2, 1};
    };
    frame.depth = fill(memory->depth);
    frame.height = fill(memory->height);
    frame.storage = std::move(memory);
    return frame;
}

int random_below(int limit, int x, int y, int n) {
    return Random(static_cast<std::uint64_t>((n * 1000 + y) * 1000 + x)).below(limit);
}

constexpr int bits_of_scene[] = {9, 10, 12, 13, 16};

struct CodingCase {
    const char* codec;
    const char* format;  // of samples of 16 bits
    Archive archive;
    Value value;
};

const CodingCase coding_cases[] = {
    {"t3d2", "16 bits", Archive::fast, [](int x, int y, int n) { return random_below(512, x, y, n); }},
    {"t3d2", "16 bits", Archive::small, [](int x, int y, int n) { return 2 * x + y + 7 * n; }},
    {"h264", "16 bits in two halves", Archive::fast,
     [](int x, int y, int n) { return random_below(512, x, y, y < 2 ? n : 0); }},
    {"h264", "16 bits in two halves", Archive::small,
     [](int x, int y, int n) { return random_below(512, x, y, y < 2 ? n : 0); }},
    {"t3d2", "16 bits", Archive::small,
     [](int x, int y, int n) { return 100 + 3 * x + random_below(4, x, y, n) + random_below(4, x, y, -n); }},
};

TEST(CodingChoice, IsSmallestAndExact) {
    for (const CodingCase& one : coding_cases)
        for (const int bits : bits_of_scene) {
            const TemporaryFolder folder;
            Scene scene = small_scene(61, 43, bits);
            scene.height_coding.code_max = 1023;
            std::vector<RawFrame> frames;
            for (int n = 0; n < 18; ++n) frames.push_back(frame_of(scene, n, one.value));
            ASSERT_EQ(message(write_all(create_clip(folder / "clip.mkv", scene, {one.archive}), frames)), "");
            SCOPED_TRACE(one.codec);
            expect_clip(folder / "clip.mkv", scene, frames);
            auto reader = must(open_clip(folder / "clip.mkv"));
            for (const TrackInfo& track : reader->tracks()) {
                EXPECT_EQ(track.codec, one.codec) << track.role << ", " << bits;
                EXPECT_EQ(track.pixel_format == one.format || bits < 16, true) << track.pixel_format;
                EXPECT_EQ(track.width, 61);
                EXPECT_EQ(track.height, 43);
            }
            for (const int n : {16, 3, 15}) expect_seek_to(*reader, n, frames);
        }
}

/// As a camera that measures disparities sees a slope.
int sloping_disparity(int x, int y, int n) {
    return 90'000 / (100 + x / 20 + y / 13 + random_below(2, x, y, n));
}

TEST(CodingChoice, SmallPacksDepthHarder) {
    const TemporaryFolder folder;
    Scene scene = small_scene(160, 120, 16);
    scene.height_coding.code_max = 1023;
    std::size_t bytes[2] = {};
    for (const Archive archive : {Archive::fast, Archive::small}) {
        std::vector<RawFrame> frames;
        for (int n = 0; n < 16; ++n) frames.push_back(frame_of(scene, n, sloping_disparity));
        const auto file = folder / "clip.mkv";
        ASSERT_EQ(message(write_all(create_clip(file, scene, {archive}, Existing::replace), frames)), "");
        expect_clip(file, scene, frames);
        for (const std::string& packet : packets(file)) bytes[static_cast<int>(archive)] += packet.size();
    }
    EXPECT_LT(bytes[1], bytes[0] * 9 / 10) << bytes[0];
}

/// As version 0.2.0 wrote `small`: FFV1 of 16 bits.
TEST(CodingChoice, ReadsSmallOfEarlierVersions) {
    auto reader = must(open_clip(TOUCHABLE_SOURCE_DIR "/tests/data/clip_ffv1.mkv"));
    EXPECT_EQ(reader->tracks().at(0).codec, "ffv1");
    EXPECT_EQ(reader->tracks().at(0).pixel_format, "gray16le");
    const auto frame = must(reader->next());
    ASSERT_TRUE(frame);
    ASSERT_EQ(frame->depth.height, 30);
    std::uint32_t noise = 1;
    for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) {
            noise = noise * 1'664'525 + 1'013'904'223;
            const std::uint32_t bell = (noise >> 30) + (noise >> 28 & 3) + (noise >> 26 & 3);
            ASSERT_EQ(frame->depth.sample(x, y), 1000 + 3 * x + static_cast<int>(bell)) << x << ", " << y;
        }
}

/// Depth whose pictures all are on their own, beside colour whose are not.
TEST(CodingChoice, SeekSkipsEarlierDamage) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(64, 48, 16);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 40, {true})), "");
    std::string bytes = read_bytes(folder / "clip.mkv");
    const auto payloads = packets(folder / "clip.mkv");  // depth and colour in turn
    const auto at = bytes.find(payloads[20]);
    ASSERT_NE(at, std::string::npos);
    bytes[at + payloads[20].size() / 2] ^= 0x10;
    write_bytes(folder / "damaged.mkv", bytes);
    auto reader = must(open_clip(folder / "damaged.mkv"));
    EXPECT_EQ(reader->tracks()[0].codec, "t3d2");
    EXPECT_EQ(reader->tracks()[1].codec, "h264");
    ASSERT_EQ(message(reader->seek(25)), "");
    EXPECT_TRUE(same_frame(**reader->next(), test_frame(scene, 25, {true})));
    EXPECT_TRUE(is_refused(reader->seek(12), "track depth, frame 10: is damaged"));
}

/// A player that goes from one to the other may keep those of the first, as VLC does.
TEST(TrackCoding, ColourQualitiesShareParameterSets) {
    const auto sets = [](TrackCoding coding) {
        const auto encoder = open_encoder(coding, AV_PIX_FMT_YUV420P, 64, 48, {30, 1});
        EXPECT_TRUE(encoder);
        return encoder
                   ? std::string((*encoder)->extradata, (*encoder)->extradata + (*encoder)->extradata_size)
                   : std::string();
    };
    EXPECT_FALSE(sets(TrackCoding::h264_visual).empty());
    EXPECT_EQ(sets(TrackCoding::h264_visual), sets(TrackCoding::h264_reduced));
}

}  // namespace
}  // namespace touchable::test
