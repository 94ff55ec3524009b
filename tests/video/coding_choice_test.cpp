// Which coding a track takes, and that each gives back every sample, from any frame, or says that it is
// damaged.
#include <gtest/gtest.h>

#include <functional>

#include "engine/clip/clip_file.hpp"
#include "engine/clip/track_codecs.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/clip_remux.hpp"

namespace touchable::test {
namespace {

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
    return Numbers(static_cast<std::uint64_t>((n * 1000 + y) * 1000 + x)).below(limit);
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
    {"ffv1", "gray16le", Archive::small,
     [](int x, int y, int n) { return 100 + 3 * x + random_below(4, x, y, n) + random_below(4, x, y, -n); }},
};

TEST(CodingChoice, GoesByBytesAndEveryCodingIsExact) {
    constexpr int frames = 18;
    for (const CodingCase& one : coding_cases)
        for (const int bits : bits_of_scene) {
            const TemporaryFolder folder;
            Scene scene = small_scene(61, 43, bits);
            scene.height_coding.code_max = 1023;
            auto writer = create_clip(folder / "clip.mkv", scene, {one.archive});
            ASSERT_EQ(message(writer), "");
            for (int n = 0; n < frames; ++n)
                ASSERT_EQ(message((*writer)->write(frame_of(scene, n, one.value))), "");
            ASSERT_EQ(message((*writer)->finish()), "");
            auto reader = open_clip(folder / "clip.mkv");
            ASSERT_EQ(message(reader), "");
            for (const TrackInfo& track : (*reader)->tracks()) {
                EXPECT_EQ(track.codec, one.codec) << track.role << ", " << bits;
                EXPECT_EQ(track.pixel_format == one.format || bits < 16, true) << track.pixel_format;
                EXPECT_EQ(track.width, 61);
                EXPECT_EQ(track.height, 43);
                EXPECT_TRUE(track.lossless);
            }
            const auto all = read_all(**reader);
            ASSERT_EQ(message(all), "");
            ASSERT_EQ(all->size(), static_cast<std::size_t>(frames));
            for (int n = 0; n < frames; ++n)
                ASSERT_TRUE(same_frame((*all)[static_cast<std::size_t>(n)], frame_of(scene, n, one.value)))
                    << one.codec << ", " << bits << " bits, frame " << n;
            for (const int n : {16, 3, 15}) {
                ASSERT_EQ(message((*reader)->seek(n)), "");
                ASSERT_TRUE(same_frame(**(*reader)->next(), frame_of(scene, n, one.value))) << n;
            }
        }
}

/// Depth whose pictures all are on their own, beside colour whose are not.
TEST(CodingChoice, ASeekPassesOverWhatLiesBeforeTheAccessPoint) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(64, 48, 16);
    ASSERT_EQ(message(write_clip(folder / "clip.mkv", scene, 40, {true})), "");
    std::string bytes = read_bytes(folder / "clip.mkv");
    const auto payloads = packets(folder / "clip.mkv");  // depth and colour in turn
    const auto at = bytes.find(payloads[20]);
    ASSERT_NE(at, std::string::npos);
    bytes[at + payloads[20].size() / 2] ^= 0x10;
    write_bytes(folder / "damaged.mkv", bytes);
    auto reader = open_clip(folder / "damaged.mkv");
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->tracks()[0].codec, "t3d2");
    EXPECT_EQ((*reader)->tracks()[1].codec, "h264");
    ASSERT_EQ(message((*reader)->seek(25)), "");
    EXPECT_TRUE(same_frame(**(*reader)->next(), test_frame(scene, 25, {true})));
    EXPECT_TRUE(is_refused((*reader)->seek(12), "track depth, frame 10: is damaged"));
}

/// A player that goes from one to the other may keep those of the first, as VLC does.
TEST(Codings, BothQualitiesOfColourHaveTheSameParameterSets) {
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
