// Sound that is kept as it is stored.
#include "engine/picture/sound.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "engine/clip/clip_file.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/sounding_clip.hpp"

namespace touchable::test {
namespace {

/// Frames `first` to `last` of a sounding clip of 30, with their sound.
void write_stretch(const std::filesystem::path& from, const std::filesystem::path& to, std::int64_t first,
                   std::int64_t last) {
    const auto frames = read_clip(from);
    ASSERT_EQ(message(frames), "");
    auto reader = open_clip(from);
    const Scene scene = (*reader)->scene();
    const SoundPart sound{from, scene.rate.time_ns(first), scene.rate.time_ns(last + 1)};
    auto writer = create_clip(to, scene, exact_clip, Existing::keep, sound);
    ASSERT_EQ(message(writer), "");
    for (std::int64_t n = first; n <= last; ++n) {
        RawFrame frame = (*frames)[static_cast<std::size_t>(n)];
        frame.number = n - first;
        ASSERT_EQ(message((*writer)->write(frame)), "");
    }
    ASSERT_EQ(message((*writer)->finish()), "");
}

TEST(StoredSound, IsHeardWithTheSameFrames) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(16, 12);
    ASSERT_EQ(message(write_clip(folder / "mute.mkv", scene, 30, {})), "");
    const auto sound = tone(20, 1.0);
    write_sounding_clip(folder / "clip.mkv", sound, folder / "mute.mkv", SoundTrack::rate, 0, 0);
    const auto facts = sound_of(folder / "clip.mkv");
    ASSERT_TRUE(facts.has_value());
    EXPECT_TRUE(facts->storable);
    for (const auto& [first, last] : {std::pair<std::int64_t, std::int64_t>{0, 29}, {12, 23}}) {
        const auto file = folder / ("part" + std::to_string(first) + ".mkv");
        write_stretch(folder / "clip.mkv", file, first, last);
        const auto frames = read_clip(file);
        ASSERT_EQ(message(frames), "");
        EXPECT_EQ(std::ssize(*frames), last - first + 1);
        auto track = SoundTrack::open(file);
        ASSERT_EQ(message(track), "");
        ASSERT_TRUE(*track);
        // All but the packets at the ends, which begin before or end after.
        const std::int64_t offset = first * SoundTrack::rate / 30;
        std::vector<StereoSample> heard(static_cast<std::size_t>((last - first + 1) * SoundTrack::rate / 30));
        (*track)->read(heard);
        double largest = 0;
        constexpr std::size_t packet = 2048;
        for (std::size_t k = packet; k + packet < heard.size(); ++k)
            largest = std::max<double>(
                largest, std::abs(heard[k].left - sound[k + static_cast<std::size_t>(offset)].left));
        // Matroska's times are whole milliseconds: half of one, of 20 Hz.
        EXPECT_LE(largest, 2 * 3.15 * 20 * 0.0005) << first;
    }
}

TEST(StoredSound, IsRefusedWhereThereIsNone) {
    const TemporaryFolder folder;
    ASSERT_EQ(message(write_clip(folder / "mute.mkv", small_scene(16, 12), 2, {})), "");
    EXPECT_FALSE(sound_of(folder / "mute.mkv").has_value());
    EXPECT_FALSE(sound_of(folder.path()).has_value());
    EXPECT_NE(message(create_clip(folder / "out.mkv", small_scene(16, 12), {}, Existing::keep,
                                  SoundPart{folder / "mute.mkv", 0, 1'000'000'000})),
              "");
}

}  // namespace
}  // namespace touchable::test
