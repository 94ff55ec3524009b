// A clip read from any frame gives what reading up to there gives.
#include <gtest/gtest.h>

#include "engine/clip/clip_file.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

constexpr int seek_frames = 40;

/// Reads two frames from each of many places, in an order that goes to and fro; the last place is the end.
void expect_same_from_everywhere(const std::filesystem::path& file) {
    auto reader = open_clip(file);
    ASSERT_EQ(message(reader), "");
    const auto whole = read_all(**reader);
    ASSERT_EQ(message(whole), "");
    ASSERT_EQ(whole->size(), static_cast<std::size_t>(seek_frames));
    for (const std::int64_t from : {7, 0, 1, 14, 15, 39, 16, 30, 29, 31, 3, 38}) {
        ASSERT_EQ(message((*reader)->seek(from)), "") << from;
        for (std::int64_t n = from; n < std::min<std::int64_t>(from + 2, seek_frames); ++n) {
            const auto frame = (*reader)->next();
            ASSERT_EQ(message(frame), "") << n;
            ASSERT_TRUE(frame->has_value()) << n;
            EXPECT_TRUE(same_frame(**frame, (*whole)[static_cast<std::size_t>(n)])) << from << " " << n;
        }
    }
    ASSERT_EQ(message((*reader)->next()), "");
    EXPECT_FALSE((*reader)->next()->has_value());  // after 38 and 39 the end
}

TEST(Seek, IsExactInBothArchives) {
    const TemporaryFolder folder;
    for (const Archive archive : {Archive::fast, Archive::small})
        for (const int width : {40, 320}) {  // on the caller's thread, and on one for each track
            const auto file = folder / "clip.mkv";
            ASSERT_EQ(message(write_clip(file, small_scene(width, 160, 16), seek_frames,
                                         {true, true, true, false}, {archive, true})),
                      "");
            expect_same_from_everywhere(file);
        }
}

TEST(Seek, IsExactAtRatesThatMatroskaRounds) {
    const TemporaryFolder folder;
    for (const FrameRate& rate : {FrameRate{30000, 1001}, {997, 1}, {1, 7}}) {
        Scene scene = small_scene(16, 16, 10);
        scene.rate = rate;
        ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, seek_frames, all_planes)), "");
        expect_same_from_everywhere(folder / "clip.mkv");
    }
}

/// Frames from one to several milliseconds apart, at no whole ones.
TEST(Seek, IsExactWhereEachFrameHasItsOwnTime) {
    const TemporaryFolder folder;
    std::vector<std::int64_t> times_ns;
    for (std::int64_t n = 0; n < seek_frames; ++n)
        times_ns.push_back(1'000'001 * n + 300'000'000 * (n / 7) + n * n * 777);
    Scene scene = small_scene(16, 16, 10);
    scene.rate = *rate_of_own_times(times_ns);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, seek_frames, all_planes)), "");
    expect_same_from_everywhere(folder / "clip.mkv");
    auto reader = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ(*(*reader)->scene().rate.own_times, times_ns);
    EXPECT_EQ((*reader)->frame_count(), seek_frames);
    EXPECT_EQ(read_all(**reader)->back().time_ns, times_ns.back());
}

/// As the first version of the format had it: every picture on its own, no additions.
TEST(Seek, IsExactWithoutAccessPoints) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30), seek_frames, {true})), "");
    remux(folder / "clip.mkv", folder / "mjpeg.mkv",
          {.transcoded = {{"depth", "mjpeg"}, {"colour", "mjpeg"}}});
    expect_same_from_everywhere(folder / "mjpeg.mkv");
}

/// The index becomes an element that readers pass over.
std::string without_index(std::string bytes) {
    const auto cues = bytes.rfind("\x1C\x53\xBB\x6B");
    EXPECT_NE(cues, std::string::npos);
    const std::size_t rest = bytes.size() - cues;  // the index is the file's end
    constexpr std::size_t head = 9;                // an identifier of one byte and a size of eight
    bytes[cues] = '\xEC';
    bytes[cues + 1] = '\x01';
    for (std::size_t k = 0; k < 7; ++k)
        bytes[cues + 2 + k] = static_cast<char>((rest - head) >> (8 * (6 - k)) & 0xFF);
    return bytes;
}

TEST(Seek, NeedsNoIndex) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(40, 30, 16), seek_frames, all_planes)), "");
    write_bytes(folder / "bare.mkv", without_index(read_bytes(folder / "clip.mkv")));
    expect_same_from_everywhere(folder / "bare.mkv");
}

TEST(Seek, BeyondTheClipIsRefused) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(16, 16), 20, all_planes)), "");
    auto reader = open_clip(folder / "clip.mkv");
    ASSERT_EQ(message(reader), "");
    EXPECT_TRUE(is_refused((*reader)->seek(21), "has no frame 21: its last is 19"));
    EXPECT_TRUE(is_refused((*reader)->seek(-1), "frame -1 is before the clip's first"));
    ASSERT_EQ(message((*reader)->seek(19)), "");
    EXPECT_EQ((*(*reader)->next())->number, 19);
}

/// What lies before the place, or far behind it, does not matter; damage at the place is told.
TEST(Seek, PassesOverDamageElsewhere) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", small_scene(64, 48), seek_frames, {})), "");
    const auto payloads = packets(folder / "clip.mkv");
    std::string bytes = read_bytes(folder / "clip.mkv");
    const auto at = bytes.find(payloads[20]);
    ASSERT_NE(at, std::string::npos);
    bytes[at + payloads[20].size() / 2] ^= 0x10;
    write_bytes(folder / "damaged.mkv", bytes);
    auto reader = open_clip(folder / "damaged.mkv");
    ASSERT_EQ(message(reader), "");
    for (const std::int64_t whole : {19, 30, 2, 39}) {
        ASSERT_EQ(message((*reader)->seek(whole)), "") << whole;
        EXPECT_EQ((*(*reader)->next())->number, whole);
    }
    EXPECT_TRUE(is_refused((*reader)->seek(25), "track depth, frame 20: is damaged"));
    EXPECT_EQ(message((*reader)->seek(5)), "");
}

}  // namespace
}  // namespace touchable::test
