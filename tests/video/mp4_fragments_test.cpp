// Fragmented MP4: as others read it, as it comes back, and as ffmpeg makes it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "engine/clip/clip_file.hpp"
#include "engine/picture/sound.hpp"
#include "engine/scene/scene.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/full_disk.hpp"
#include "tests/sweep.hpp"
#include "tests/video/mp4_boxes.hpp"
#include "tests/video/sounding_clip.hpp"

namespace touchable::test {
namespace {

namespace fs = std::filesystem;

const ClipStorage in_fragments{.archive = Archive::fast, .exact_colour = true, .fragmented = true};

Scene fragment_scene(int width, int height, int depth_bits, int height_bits) {
    Scene scene = small_scene(width, height, depth_bits);
    scene.height_coding = {1.5, HeightUnits::levels, static_cast<std::uint16_t>((1 << height_bits) - 1)};
    return scene;
}

Result<void> write_fragments(const fs::path& file, const SceneDescription& described, int frames,
                             const Planes& planes = all_planes, const std::optional<SoundPart>& sound = {}) {
    auto writer = create_mp4_clip(file, described, in_fragments, Existing::replace, sound);
    if (!writer) return writer.error();
    for (int n = 0; n < frames; ++n)
        if (auto written = (*writer)->write(test_frame(described.scene, n, planes)); !written) return written;
    return (*writer)->finish();
}

void expect_fragments_are(const fs::path& file, const Scene& scene, int frames,
                          const Planes& planes = all_planes) {
    auto reader = open_clip(file);
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), frames);
    EXPECT_TRUE(!planes.haptic || (*reader)->notes().empty());
    EXPECT_EQ(scene_to_json((*reader)->scene()), scene_to_json(scene));
    for (const TrackInfo& track : (*reader)->tracks()) EXPECT_TRUE(track.lossless) << track.role;
    const auto read = read_all(**reader);
    ASSERT_EQ(message(read), "");
    ASSERT_EQ(read->size(), static_cast<std::size_t>(frames));
    for (int n = 0; n < frames; ++n)
        EXPECT_TRUE(same_frame((*read)[static_cast<std::size_t>(n)], test_frame(scene, n, planes)))
            << scene.depth_bits << " bits, frame " << n;
}

/// The movie box comes first, with everything that says what the file is; then fragments.
TEST(Mp4Fragments, BeginWithAMovieBoxThatMarksItsTracksAndHasItsTags) {
    const TemporaryFolder folder;
    const Scene scene = fragment_scene(30, 23, 12, 8);
    ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, 40)), "");
    const std::string file = read_bytes(folder / "clip.mp4");
    const auto boxes = boxes_of(file);
    ASSERT_GT(boxes.size(), 7U);
    EXPECT_EQ(boxes[0].type, "ftyp");
    EXPECT_EQ(boxes[1].type, "moov");
    for (std::size_t k = 2; k < 8; ++k) EXPECT_EQ(boxes[k].type, k % 2 == 0 ? "moof" : "mdat") << k;
    const std::string movie = bytes_in(file, boxes[1]);
    for (const char* tag : {"T3D_VERSION", "T3D_RATE", "T3D_SCENE"})
        EXPECT_NE(movie.find(tag), std::string::npos) << tag;
    EXPECT_TRUE(boxes_named(file, boxes[1], "iods").empty());
    const auto tracks = boxes_named(file, boxes[1], "trak");
    const char* names[] = {"colour", "depth", "haptic", "height", "depth_low"};
    ASSERT_EQ(tracks.size(), std::size(names));
    for (std::size_t k = 0; k < tracks.size(); ++k) {
        EXPECT_EQ(handler_of(file, tracks[k]), k == 0 ? "vide" : "auxv");
        EXPECT_NE(bytes_in(file, box_at(file, tracks[k], {"mdia", "hdlr"})).find(names[k]),
                  std::string::npos);
        EXPECT_EQ(boxes_named(file, tracks[k], "tref").empty(), k == 0);
        if (k > 0) {
            EXPECT_EQ(hex_digits(bytes_in(file, box_at(file, tracks[k], {"tref", "vdep"}))), "00000001");
        }
    }
}

/// Every fragment holds as many frames of every track as half a second has at most.
TEST(Mp4Fragments, AreHalfASecondLongAtMostAndHaveAllTracks) {
    const TemporaryFolder folder;
    Scene scene = fragment_scene(16, 12, 12, 8);
    struct Case {
        FrameRate rate;
        std::uint64_t most;
    };
    for (const Case& each :
         {Case{{30, 1}, 15}, Case{{30000, 1001}, 14}, Case{{8, 1}, 4}, Case{{1, 3}, 1}, Case{{100, 1}, 15}}) {
        scene.rate = each.rate;
        constexpr std::uint64_t frames = 32;
        ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, frames)), "");
        const std::string file = read_bytes(folder / "clip.mp4");
        std::uint64_t total = 0, fragments = 0;
        for (const FoundBox& box : boxes_of(file)) {
            if (box.type != "moof") continue;
            ++fragments;
            std::vector<std::uint64_t> counts;
            for (const FoundBox& track : boxes_named(file, box, "traf"))
                counts.push_back(number_in(file, box_at(file, track, {"trun"}).content + 4, 4));
            ASSERT_EQ(counts.size(), 5U);
            for (const std::uint64_t count : counts) EXPECT_EQ(count, counts[0]);
            EXPECT_LE(counts[0], each.most) << each.rate.num;
            total += counts[0];
        }
        EXPECT_EQ(total, frames);
        EXPECT_EQ(fragments, (frames + each.most - 1) / each.most);
        expect_fragments_are(folder / "clip.mp4", scene, frames);
    }
}

TEST(Mp4Fragments, EveryBitComesBack) {
    const TemporaryFolder folder;
    for (const int bits : {8, 10, 12, 16})
        for (const int height_bits : {8, 16}) {
            const Scene scene = fragment_scene(63, 47, bits, height_bits);
            ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, 17)), "");
            expect_fragments_are(folder / "clip.mp4", scene, 17);
        }
    const Scene scene = fragment_scene(40, 30, 16, 8);
    ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, 1, {})), "");
    expect_fragments_are(folder / "clip.mp4", scene, 1, {});
}

/// Of these frames, a file that was cut has the first few.
void expect_reads_from_any_frame(const fs::path& file, const Scene& scene, int frames, int interval) {
    auto reader = open_clip(file);
    ASSERT_EQ(message(reader), "");
    for (const int n : {frames - 1, 0, frames / 2, 3, frames / 2 + 1, 14, 1, frames - 2}) {
        EXPECT_EQ((*reader)->access_point(n), n - n % interval);
        ASSERT_EQ(message((*reader)->seek(n)), "") << n;
        for (int k = n; k < std::min(n + 2, frames); ++k) {
            const auto frame = (*reader)->next();
            ASSERT_EQ(message(frame), "") << k;
            ASSERT_TRUE(frame->has_value()) << k;
            EXPECT_TRUE(same_frame(**frame, test_frame(scene, k, all_planes))) << n << ' ' << k;
        }
        EXPECT_EQ((*reader)->access_point(n), n - n % interval) << "the index led there";
    }
    EXPECT_TRUE(is_refused((*reader)->seek(frames + 1), "has no frame"));
}

std::vector<std::int64_t> own_times(int frames) {
    std::vector<std::int64_t> times_ns;
    for (std::int64_t n = 0; n < frames; ++n) times_ns.push_back(7'000'001 * n + n * n * 777);
    return times_ns;
}

TEST(Mp4Fragments, AreReadFromAnyFrameAtAnyRate) {
    const TemporaryFolder folder;
    constexpr int frames = 40;
    Scene scene = fragment_scene(16, 12, 12, 16);
    for (const FrameRate& rate : {FrameRate{30, 1}, {1000, 1}, *rate_of_own_times(own_times(frames))}) {
        scene.rate = rate;
        ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, frames)), "");
        expect_fragments_are(folder / "clip.mp4", scene, frames);
        expect_reads_from_any_frame(folder / "clip.mp4", scene, frames, 15);
    }
}

/// As whoever came later to what is sent has it.
TEST(Mp4Fragments, WithoutTheFirstOnesAreReadFromThereOn) {
    const TemporaryFolder folder;
    const Scene scene = fragment_scene(16, 12, 12, 8);
    ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, 40)), "");
    std::string file = read_bytes(folder / "clip.mp4");
    const auto boxes = boxes_of(file);
    ASSERT_EQ(boxes[2].type, "moof");
    file.erase(boxes[2].at, boxes[4].at - boxes[2].at);
    write_bytes(folder / "later.mp4", file);
    auto reader = open_clip(folder / "later.mp4");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), 25);
    for (const int n : {24, 0, 15}) {
        ASSERT_EQ(message((*reader)->seek(n)), "") << n;
        const auto frame = (*reader)->next();
        ASSERT_EQ(message(frame), "") << n;
        const RawFrame exact = test_frame(scene, 15 + n, all_planes);
        EXPECT_TRUE(same_plane((*frame)->depth, exact.depth) && same_plane((*frame)->haptic, exact.haptic))
            << n;
    }
}

TEST(Mp4Fragments, TheSameFramesGiveTheSameFileAndMatroskaHasNone) {
    const TemporaryFolder folder;
    const Scene scene = fragment_scene(40, 30, 16, 8);
    for (const char* name : {"a.mp4", "b.mp4"})
        ASSERT_EQ(message(write_fragments(folder / name, scene, 17)), "");
    EXPECT_EQ(read_bytes(folder / "a.mp4"), read_bytes(folder / "b.mp4"));
    const auto refused = create_named_clip(folder / "clip.mkv", scene, in_fragments);
    EXPECT_TRUE(is_refused(refused, "only MP4 is written in fragments"));
}

TEST(Mp4Fragments, HaveTheirSoundInStep) {
    const TemporaryFolder folder;
    const auto sound = tone(20, 3.0);
    {
        auto film = FilmWriter::create(folder / "film.mp4", Existing::keep);
        ASSERT_EQ(message(film), "");
        const std::vector<std::uint8_t> grey(3 * 64 * 48, 99);
        ASSERT_EQ(message((*film)->add({grey.data(), 3 * 64, 64, 48, 1, 3}, 0)), "");
        ASSERT_EQ(message((*film)->add_sound(0, sound)), "");
        ASSERT_EQ(message((*film)->finish(90)), "");
    }
    const Scene scene = small_scene(16, 12, 12);
    ASSERT_EQ(message(write_fragments(folder / "clip.mp4", scene, 60, {},
                                      SoundPart{folder / "film.mp4", 0, 2'000'000'000})),
              "");
    expect_fragments_are(folder / "clip.mp4", scene, 60, {});
    auto track = SoundTrack::open(folder / "clip.mp4");
    auto source = SoundTrack::open(folder / "film.mp4");
    ASSERT_EQ(message(track), "");
    ASSERT_EQ(message(source), "");
    ASSERT_TRUE(*track && *source);
    for (const std::int64_t from : {std::int64_t{0}, std::int64_t{60'000}, std::int64_t{10'000}}) {
        std::vector<StereoSample> heard(SoundTrack::rate / 2), wanted(SoundTrack::rate / 2);
        (*track)->seek(from);
        (*track)->read(heard);
        (*source)->seek(from);
        (*source)->read(wanted);
        double largest = 0;
        constexpr std::size_t packet = 2048;  // at the beginning: one is missing before
        for (std::size_t k = packet; k < heard.size(); ++k)
            largest = std::max<double>(largest, std::abs(heard[k].left - wanted[k].left));
        EXPECT_LE(largest, 0.5 * 2 * 3.15 * 20 * 0.001) << from;
    }
}

TEST(Mp4Fragments, ThatStopWhenTheirDiskIsFullAreWholeUpToThere) {
    const TemporaryFolder folder;
    constexpr std::uintmax_t room = 1'500'000;
    const Scene scene = small_scene(64, 48, 16);
    std::int64_t written = 0;
    {
        const FullDisk full(room);
        const auto clip = create_mp4_clip(folder / "clip.mp4", scene, in_fragments);
        ASSERT_EQ(message(clip), "");
        while (!(*clip)->is_full()) {
            ASSERT_EQ(message((*clip)->write(test_frame(scene, written, {}))), "") << written;
            ASSERT_LT(++written, 1000) << "the disk is larger than it is";
        }
        ASSERT_EQ(message((*clip)->finish()), "");
    }
    EXPECT_GT(fs::file_size(folder / "clip.mp4"), room / 2) << "most of the room is for pictures";
    const auto frames = read_clip(folder / "clip.mp4");
    ASSERT_EQ(message(frames), "");
    EXPECT_EQ(std::ssize(*frames), written);
}

/// Four tracks with handler names, of an encoder that reorders pictures, as ffmpeg's program makes them.
struct MadeByFfmpeg : ::testing::Test {
    static constexpr int frames = 40;
    const TemporaryFolder folder;
    Scene scene = fragment_scene(64, 48, 8, 8);

    void SetUp() override {
        if (std::system("command -v ffmpeg >/dev/null") != 0)
            GTEST_SKIP() << "there is no program ffmpeg here (Debian: ffmpeg)";
        std::string colour, depth, haptic, height;
        const auto add = [](std::string& to, const PlaneView& plane) {
            for (int y = 0; y < plane.height; ++y)
                to.append(reinterpret_cast<const char*>(plane.row(y)),
                          static_cast<std::size_t>(plane.width * plane.channels));
        };
        for (int n = 0; n < frames; ++n) {
            const RawFrame frame = made(n);
            add(colour, frame.colour);
            add(depth, frame.depth);
            add(haptic, frame.haptic);
            add(height, frame.height);
        }
        write_bytes(folder / "colour", colour);
        write_bytes(folder / "depth", depth);
        write_bytes(folder / "haptic", haptic);
        write_bytes(folder / "height", height);
        write_bytes(folder / "scene.json", scene_to_json(scene));
    }
    RawFrame made(int n) const { return test_frame(scene, n, {true, true, true, false}); }
    /// `options`: of all tracks.
    void make(const std::string& options) const {
        std::string command = "cd '" + (folder / "").string() + "' && ffmpeg -y -loglevel error", tracks;
        const char* names[] = {"colour", "depth", "haptic", "height"};
        for (int k = 0; k < 4; ++k) {
            const bool is_grey = k % 2 == 1;
            const std::string track = std::to_string(k);
            command += std::string(" -f rawvideo -s 64x48 -r 30 -pix_fmt ") + (is_grey ? "gray" : "rgb24") +
                       " -i " + names[k];
            tracks += " -map " + track + ":v -c:v:" + track + (is_grey ? " libx264" : " libx264rgb") +
                      " -metadata:s:v:" + track + " handler_name=" + names[k];
        }
        command +=
            tracks + " -qp 0 -bf 2 -g 10 -sc_threshold 0 -color_range pc " + options + " out.mp4 >log 2>&1";
        ASSERT_EQ(std::system(command.c_str()), 0) << read_bytes(folder / "log");
    }
    std::vector<RawFrame> read_clip_described() const {
        auto reader = open_clip(folder / "out.mp4", folder / "scene.json");
        EXPECT_EQ(message(reader), "");
        auto read = reader ? read_all(**reader) : Result<std::vector<RawFrame>>(std::vector<RawFrame>());
        EXPECT_EQ(message(read), "");
        return read ? std::move(*read) : std::vector<RawFrame>();
    }
    void expect_comes_back(int wanted) const {
        auto reader = open_clip(folder / "out.mp4", folder / "scene.json");
        ASSERT_EQ(message(reader), "");
        EXPECT_EQ((*reader)->frame_count(), wanted);
        const auto read = read_all(**reader);
        ASSERT_EQ(message(read), "");
        ASSERT_EQ(std::ssize(*read), wanted);
        for (int n = 0; n < wanted; ++n)
            EXPECT_TRUE(same_frame((*read)[static_cast<std::size_t>(n)], made(n))) << n;
    }
};

TEST_F(MadeByFfmpeg, FragmentsWithNamedTracksAreReadByASceneFile) {
    for (const char* flags :
         {"frag_keyframe+empty_moov+default_base_moof", "frag_keyframe", "frag_keyframe+empty_moov",
          "frag_keyframe+delay_moov", "frag_keyframe+empty_moov+default_base_moof+dash+global_sidx"}) {
        make(std::string("-movflags ") + flags);
        EXPECT_NE(read_bytes(folder / "out.mp4").find("moof"), std::string::npos);
        expect_comes_back(frames);
        if (HasFailure()) FAIL() << flags;
    }
    EXPECT_TRUE(is_refused(open_clip(folder / "out.mp4"), "describe it with a scene file"));
}

TEST_F(MadeByFfmpeg, FragmentsWithTagsDescribeThemselves) {
    std::string json = scene_to_json(scene);
    std::erase(json, '\n');
    make(
        "-movflags frag_keyframe+empty_moov+default_base_moof+use_metadata_tags -metadata T3D_VERSION=2 "
        "-metadata T3D_RATE=30/1 -metadata T3D_SCENE='" +
        json + "'");
    const auto frames_read = read_clip(folder / "out.mp4");
    ASSERT_EQ(message(frames_read), "");
    ASSERT_EQ(std::ssize(*frames_read), frames);
    EXPECT_TRUE(same_frame(frames_read->back(), made(frames - 1)));
}

/// Its tracks end at different frames where it is cut: those that all have are there.
TEST_F(MadeByFfmpeg, FragmentsThatAreCutHaveTheFramesThatAllTracksHave) {
    make("-movflags frag_keyframe+empty_moov+default_base_moof");
    const std::string whole = read_bytes(folder / "out.mp4");
    std::int64_t most = 0;
    int readable = 0;
    for (std::size_t length = whole.size() / 40; length < whole.size(); length += whole.size() / 20) {
        fs::remove(folder / "out.mp4");
        write_bytes(folder / "out.mp4", whole.substr(0, length));
        auto reader = open_clip(folder / "out.mp4", folder / "scene.json");
        if (!reader) {
            EXPECT_EQ(most, 0) << "where a shorter one was read: " << message(reader);
            continue;
        }
        ++readable;
        const auto read = read_all(**reader);
        ASSERT_EQ(message(read), "") << length;
        EXPECT_GE(std::ssize(*read), most) << length;
        most = std::ssize(*read);
        EXPECT_TRUE(same_frame(read->back(), made(static_cast<int>(most) - 1)));
    }
    EXPECT_GE(readable, 8);
    EXPECT_GE(most, frames / 2);
}

/// Pictures are decoded before those that are shown first, and each track has key pictures of its own.
TEST_F(MadeByFfmpeg, ReorderedPicturesAreFoundByTheirIndexInFragmentsAndWithout) {
    for (const char* options :
         {"-movflags frag_keyframe+empty_moov+default_base_moof", "", "-g:v:0 15 -bf:v:3 0"}) {
        make(std::string("-qp 2 -b_strategy 0 ") + options);  // what keeps every value is not reordered
        auto reader = open_clip(folder / "out.mp4", folder / "scene.json");
        ASSERT_EQ(message(reader), "");
        const auto in_order = read_clip_described();
        ASSERT_EQ(std::ssize(in_order), frames);
        const bool is_mixed = std::string_view(options).starts_with("-g");
        for (const int n : {9, 39, 8, 19, 21, 29, 1, 38, 10, 11, 30, 0}) {
            const int key = is_mixed ? n - n % 30 : n - n % 10;
            EXPECT_EQ((*reader)->access_point(n), key) << options << ' ' << n;
            ASSERT_EQ(message((*reader)->seek(n)), "") << options << ' ' << n;
            const auto frame = (*reader)->next();
            ASSERT_EQ(message(frame), "") << options << ' ' << n;
            EXPECT_TRUE(same_frame(**frame, in_order[static_cast<std::size_t>(n)])) << options << ' ' << n;
            EXPECT_EQ((*reader)->access_point(n), key) << options << ": the index led to " << n;
        }
    }
}

/// Whole fragments that end within a file of so many bytes, and the frames in them.
int whole_frames(const std::string& file, std::size_t length) {
    int frames = 0;
    const auto boxes = boxes_of(file);
    for (std::size_t k = 0; k + 1 < boxes.size(); ++k)
        if (boxes[k].type == "moof" && boxes[k + 1].end <= length)
            frames += static_cast<int>(number_in(
                file, box_at(file, boxes_named(file, boxes[k], "traf")[0], {"trun"}).content + 4, 4));
    return frames;
}

TEST(Mp4Fragments, ThatAreCutHaveTheFramesOfTheWholeOnesOrOneLine) {
    const TemporaryFolder folder;
    Scene scene = small_scene(8, 8, 12);
    scene.rate = *rate_of_own_times({0, 200'000'000, 500'000'000, 700'000'000, 1'600'000'000});
    constexpr int frames = 5;
    ASSERT_EQ(message(write_fragments(folder / "whole.mp4", scene, frames, {})), "");
    const std::string whole = read_bytes(folder / "whole.mp4");
    ASSERT_EQ(whole_frames(whole, whole.size()), frames);
    int tried = 0, readable = 0;
    for (std::size_t length = 0; length < whole.size(); length += 5 * sweep_step()) {
        fs::remove(folder / "cut.mp4");
        write_bytes(folder / "cut.mp4", whole.substr(0, length));
        const int there = whole_frames(whole, length);
        ++tried;
        auto reader = open_clip(folder / "cut.mp4");
        if (there == 0) {
            ASSERT_FALSE(reader) << length;
            EXPECT_EQ(reader.error().message.find('\n'), std::string::npos);
            EXPECT_EQ(reader.error().message.find((folder / "cut.mp4").string() + ": "), 0U)
                << reader.error().message;
            continue;
        }
        ASSERT_EQ(message(reader), "") << length;
        ++readable;
        EXPECT_EQ((*reader)->frame_count(), there);
        const auto read = read_all(**reader);
        ASSERT_EQ(message(read), "") << length;
        ASSERT_EQ(std::ssize(*read), there) << length;
        EXPECT_TRUE(same_frame(read->back(), test_frame(scene, there - 1, {}))) << length;
        const bool ends_with_a_box =
            std::ranges::any_of(boxes_of(whole), [length](const FoundBox& box) { return box.end == length; });
        const auto& notes = (*reader)->notes();
        const bool says_so = std::ranges::any_of(
            notes, [](const std::string& note) { return note.find("is cut") != std::string::npos; });
        EXPECT_NE(says_so, ends_with_a_box) << length;
    }
    EXPECT_GT(4 * readable, tried) << "most of the file is fragments";
}

TEST(Mp4Fragments, AChangedByteOfTheirBoxesIsAnErrorOrLeavesFrames) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(8, 8, 12);
    ASSERT_EQ(message(write_fragments(folder / "whole.mp4", scene, 20, {false, true})), "");
    const std::string whole = read_bytes(folder / "whole.mp4");
    int tried = 0, other = 0;
    for (const FoundBox& box : boxes_of(whole)) {
        if (box.type != "moof") continue;
        for (const int change : {0x01, 0x80, 0xFF})
            for (std::size_t at = box.at + static_cast<std::size_t>(change % 3); at < box.end;
                 at += 3 * sweep_step()) {
                std::string damaged = whole;
                damaged[at] = static_cast<char>(damaged[at] ^ change);
                fs::remove(folder / "damaged.mp4");
                write_bytes(folder / "damaged.mp4", damaged);
                const auto read = read_clip(folder / "damaged.mp4");
                ++tried;
                if (read) {
                    EXPECT_LE(read->size(), 20U) << at;
                    other += read->size() == 20 ? 0 : 1;
                    continue;
                }
                ++other;
                EXPECT_EQ(read.error().message.find('\n'), std::string::npos) << read.error().message;
                EXPECT_EQ(read.error().message.find((folder / "damaged.mp4").string() + ": "), 0U)
                    << read.error().message;
            }
    }
    EXPECT_GT(2 * other, tried) << "most of a fragment's head matters";
}

}  // namespace
}  // namespace touchable::test
