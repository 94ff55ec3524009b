#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "engine/clip/clip_file.hpp"
#include "engine/picture/image.hpp"
#include "engine/picture/sound.hpp"
#include "tests/full_disk.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/video/film_reader.hpp"

namespace touchable::test {
namespace {

Image grey(int width, int height, int level) {
    return {width, height, 1, 3,
            std::vector<std::uint8_t>(static_cast<std::size_t>(3 * width * height),
                                      static_cast<std::uint8_t>(level))};
}

TEST(Film, ShowsEachPictureFromItsPlaceOnAtThirtyASecond) {
    for (const char* name : {"film.mp4", "film.mkv"}) {
        const TemporaryFolder folder;
        auto film = FilmWriter::create(folder / name, Existing::keep);
        ASSERT_TRUE(film) << film.error().message;
        const auto dark = grey(65, 48, 0), light = grey(65, 48, 255), wide = grey(128, 48, 255);
        ASSERT_TRUE((*film)->add(dark.view(), 0));
        ASSERT_TRUE((*film)->add(light.view(), 5));
        ASSERT_TRUE((*film)->add(wide.view(), 7));
        EXPECT_FALSE(std::filesystem::exists(folder / name)) << "it has its name before it is complete";
        ASSERT_TRUE((*film)->finish(12));
        const auto seen = seen_in_film(folder / name);
        ASSERT_EQ(seen.size(), 12U) << name;
        for (std::size_t k = 0; k < seen.size(); ++k) {
            EXPECT_NEAR(seen[k].seconds, static_cast<double>(k) / 30, 0.001);
            EXPECT_EQ(seen[k].width, 64);
            EXPECT_EQ(seen[k].height, 48);
            EXPECT_NEAR(seen[k].at(32, 24), k < 5 ? 16 : 235, 6) << k;
            // The wide one is half as high, with black above and below.
            EXPECT_NEAR(seen[k].at(32, 4), k >= 5 && k < 7 ? 235 : 16, 6) << k;
        }
    }
}

/// Root of the mean square of the left channel.
double loudness(SoundTrack& track, double from_s, double to_s) {
    std::vector<StereoSample> samples(static_cast<std::size_t>((to_s - from_s) * SoundTrack::rate));
    track.seek(std::lround(from_s * SoundTrack::rate));
    track.read(samples);
    double sum = 0;
    for (const StereoSample& sample : samples) sum += static_cast<double>(sample.left * sample.left);
    return std::sqrt(sum / static_cast<double>(samples.size()));
}

TEST(Film, SoundsWhereItsSoundWasPlacedHoweverLatePicturesAre) {
    for (const char* name : {"film.mp4", "film.MKV"}) {
        const TemporaryFolder folder;
        auto film = FilmWriter::create(folder / name, Existing::keep);
        ASSERT_TRUE(film) << film.error().message;
        std::vector<StereoSample> tone(9600);  // 0.2 s
        for (std::size_t k = 0; k < tone.size(); ++k)
            tone[k].left = tone[k].right = 0.5F * static_cast<float>(std::sin(0.06 * static_cast<double>(k)));
        EXPECT_FALSE((*film)->add_sound(0, tone)) << "before its first picture";
        ASSERT_TRUE((*film)->add(grey(64, 48, 128).view(), 0));
        ASSERT_TRUE((*film)->add_sound(24'000, tone));
        ASSERT_TRUE((*film)->add_sound(14'400, tone)) << "is left out";
        ASSERT_TRUE((*film)->add_sound(48'000 * 6, tone));
        ASSERT_TRUE((*film)->finish(200));
        EXPECT_EQ(seen_in_film(folder / name).size(), 200U);
        auto track = SoundTrack::open(folder / name);
        ASSERT_TRUE(track && *track) << name;
        EXPECT_LT(loudness(**track, 0, 0.48), 0.002) << name;
        EXPECT_NEAR(loudness(**track, 0.51, 0.69), 0.354, 0.02) << name;
        EXPECT_LT(loudness(**track, 0.72, 5.98), 0.002) << name;
        EXPECT_NEAR(loudness(**track, 6.01, 6.19), 0.354, 0.02) << name;
    }
}

/// Like no other, so that it takes room.
Image noisy_picture(int seed) {
    Image picture = grey(160, 120, 0);
    auto state = static_cast<std::uint32_t>(seed) * 2654435761U + 1U;
    for (std::uint8_t& sample : picture.samples) {
        state = state * 1664525U + 1013904223U;
        sample = static_cast<std::uint8_t>(state >> 24U);
    }
    return picture;
}

/// A film of pictures and sound that both take room, on a disk with so much of it.
void expect_plays_up_to_a_full_disk(const std::string& name, rlim_t room) {
    const TemporaryFolder folder;
    std::int64_t shown = 0;
    std::vector<StereoSample> heard(SoundTrack::rate / 4);
    for (std::size_t k = 0; k < heard.size(); ++k)
        heard[k].left = heard[k].right = static_cast<float>(k * k % 1009) / 1009.0F;
    {
        const FullDisk full(room);
        auto film = FilmWriter::create(folder / name, Existing::keep);
        ASSERT_TRUE(film) << film.error().message;
        Result<void> done;
        while (done) {
            ASSERT_LT(shown, 1000) << "the disk is larger than it is";
            done = (*film)->add(noisy_picture(static_cast<int>(shown)).view(), shown);
            if (done && shown % 30 == 0) done = (*film)->add_sound(shown * 1600, heard);
            ++shown;
        }
        EXPECT_NE(done.error().message.find("the disk is full"), std::string::npos) << done.error().message;
        EXPECT_FALSE((*film)->add(noisy_picture(0).view(), shown))
            << "a picture behind one that is not there";
        const auto ended = (*film)->finish(shown);
        ASSERT_FALSE(ended);
        EXPECT_EQ(ended.error().kind, ErrorKind::input);
        EXPECT_TRUE(ended.error().message.ends_with("the disk is full; it is kept up to there"))
            << ended.error().message;
    }
    ASSERT_TRUE(std::filesystem::exists(folder / name)) << name << " of " << room;
    EXPECT_LE(std::filesystem::file_size(folder / name), room);
    const auto seen = seen_in_film(folder / name);
    EXPECT_GE(std::ssize(seen) + 3, shown) << name << ": all but those that found no room";
    EXPECT_LE(std::ssize(seen), shown);
    auto track = SoundTrack::open(folder / name);
    EXPECT_TRUE(track && *track) << name;
}

TEST(Film, IsKeptUpToWhereItsDiskBecameFull) {
    // At any byte of a picture, of its sound, of what the muxer holds.
    for (const char* name : {"film.mp4", "film.mkv"})
        for (rlim_t room = 400'000; room < 700'000; room += 43'403)
            expect_plays_up_to_a_full_disk(name, room);
}

TEST(Film, WithRoomForNoPictureIsNotKept) {
    const TemporaryFolder folder;
    const FullDisk full(1000);
    auto film = FilmWriter::create(folder / "film.mkv", Existing::keep);
    ASSERT_TRUE(film) << film.error().message;
    (void)(*film)->add(noisy_picture(0).view(), 0);
    EXPECT_FALSE((*film)->finish(3));
    EXPECT_FALSE(std::filesystem::exists(folder / "film.mkv"));
}

TEST(Film, IsRefusedUnderOtherNamesAndWhereOneIs) {
    const TemporaryFolder folder;
    EXPECT_EQ(FilmWriter::create(folder / "film.avi", Existing::keep).error().kind, ErrorKind::usage);
    EXPECT_FALSE(FilmWriter::create(folder / "nowhere/film.mkv", Existing::keep));
    auto empty = FilmWriter::create(folder / "film.mkv", Existing::keep);
    ASSERT_TRUE(empty);
    EXPECT_FALSE((*empty)->finish(3));
    EXPECT_FALSE(std::filesystem::exists(folder / "film.mkv"));
}

}  // namespace
}  // namespace touchable::test
