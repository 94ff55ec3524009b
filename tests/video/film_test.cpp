// SPDX-License-Identifier: Apache-2.0
#include <cmath>

#include "engine/picture/image.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/limits.hpp"
#include "tests/video/remuxed_clip.hpp"

namespace touchable::test {
namespace {

Image grey(int width, int height, int level) {
    return {width, height, 1, 3,
            std::vector<std::uint8_t>(static_cast<std::size_t>(3 * width * height),
                                      static_cast<std::uint8_t>(level))};
}

TEST(Film, ShowsPicturesFromTheirPlaces) {
    for (const char* name : {"film.mp4", "film.mkv"}) {
        const TemporaryFolder folder;
        auto film = must(FilmWriter::create(folder / name, Existing::keep));
        const auto dark = grey(65, 48, 0), light = grey(65, 48, 255), wide = grey(128, 48, 255);
        ASSERT_TRUE(film->add(dark.view(), 0));
        ASSERT_TRUE(film->add(light.view(), 5));
        ASSERT_TRUE(film->add(wide.view(), 7));
        EXPECT_FALSE(std::filesystem::exists(folder / name)) << "it has its name before it is complete";
        ASSERT_TRUE(film->finish(12));
        const auto seen = seen_in_film(folder / name);
        ASSERT_EQ(seen.size(), 12U) << name;
        for (std::size_t k = 0; k < seen.size(); ++k) {
            EXPECT_NEAR(seen[k].seconds, static_cast<double>(k) / 30, 0.001);
            EXPECT_EQ(seen[k].width, 64);
            EXPECT_EQ(seen[k].height, 48);
            EXPECT_NEAR(seen[k].at(32, 24), k < 5 ? 16 : 235, 6) << k;
            // The wide one is half as high, with black above and below; the others lose their odd column.
            for (const int row : {4, 47})
                EXPECT_NEAR(seen[k].at(32, row), k >= 5 && k < 7 ? 235 : 16, 6) << k << ' ' << row;
        }
    }
}

/// However far its sound is ahead, as of a window that draws quickly.
TEST(Film, KeepsPicturesAtAnyRate) {
    for (const int rate : {1, 7, 240}) {
        const TemporaryFolder folder;
        auto film = must(FilmWriter::create(folder / "film.mkv", Existing::keep, rate));
        const auto dark = grey(64, 48, 0), light = grey(64, 48, 255);
        ASSERT_TRUE(film->add(dark.view(), 0));
        ASSERT_TRUE(film->add_sound(0, tone(480, std::min(5.0, 5.0 / rate))));
        for (int place = 1; place < 6; ++place) ASSERT_TRUE(film->add(light.view(), place));
        ASSERT_TRUE(film->finish(6));
        const auto seen = seen_in_film(folder / "film.mkv");
        ASSERT_EQ(seen.size(), 6U) << rate;
        for (std::size_t k = 0; k < seen.size(); ++k) {
            EXPECT_NEAR(seen[k].seconds, static_cast<double>(k) / rate, 0.001) << rate;
            EXPECT_NEAR(seen[k].at(32, 24), k < 1 ? 16 : 235, 6) << rate << ' ' << k;
        }
    }
}

/// Root of the mean square of the left channel.
double loudness(SoundTrack& track, double from_s, double to_s) {
    const auto samples = heard_in(track, std::lround(from_s * SoundTrack::rate),
                                  static_cast<std::size_t>((to_s - from_s) * SoundTrack::rate));
    double sum = 0;
    for (const StereoSample& sample : samples) sum += static_cast<double>(sample.left * sample.left);
    return std::sqrt(sum / static_cast<double>(samples.size()));
}

TEST(Film, PlacesSoundIndependentlyOfPictures) {
    for (const char* name : {"film.mp4", "film.MKV"}) {
        const TemporaryFolder folder;
        auto film = must(FilmWriter::create(folder / name, Existing::keep));
        const auto sound = tone(458.4, 0.2);
        EXPECT_FALSE(film->add_sound(0, sound)) << "before its first picture";
        ASSERT_TRUE(film->add(grey(64, 48, 128).view(), 0));
        ASSERT_TRUE(film->add_sound(24'000, sound));
        ASSERT_TRUE(film->add_sound(14'400, sound)) << "is left out";
        ASSERT_TRUE(film->add_sound(48'000 * 6, sound));
        ASSERT_TRUE(film->finish(200));
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
        auto film = must(FilmWriter::create(folder / name, Existing::keep));
        Result<void> done;
        while (done) {
            ASSERT_LT(shown, 1000) << "the disk is larger than it is";
            done = film->add(noisy_picture(static_cast<int>(shown)).view(), shown);
            if (done && shown % 30 == 0) done = film->add_sound(shown * 1600, heard);
            ++shown;
        }
        EXPECT_TRUE(is_refused(done, "the disk is full"));
        EXPECT_FALSE(film->add(noisy_picture(0).view(), shown)) << "a picture behind one that is not there";
        const auto ended = film->finish(shown);
        EXPECT_TRUE(is_refused(ended, "", ErrorKind::input));
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

TEST(Film, IsKeptOnFullDisk) {
    // At any byte of a picture, of its sound, of what the muxer holds.
    for (const char* name : {"film.mp4", "film.mkv"})
        for (rlim_t room = 400'000; room < 700'000; room += 43'403)
            expect_plays_up_to_a_full_disk(name, room);
}

TEST(Film, IsRemovedWithoutAnyPicture) {
    const TemporaryFolder folder;
    const FullDisk full(1000);
    auto film = must(FilmWriter::create(folder / "film.mkv", Existing::keep));
    (void)film->add(noisy_picture(0).view(), 0);
    EXPECT_FALSE(film->finish(3));
    EXPECT_FALSE(std::filesystem::exists(folder / "film.mkv"));
}

TEST(Film, NumbersPicturesByPattern) {
    EXPECT_EQ(numbered_picture("a/shot-%03d.png", 7), "a/shot-007.png");
    EXPECT_EQ(numbered_picture("%d.PNG", 1234), "1234.PNG");
    for (const char* none :
         {"d.png", "shot.png", "shot-%.png", "shot-%d-%d.png", "shot-%0123d.png", "%d.jpg"})
        EXPECT_EQ(numbered_picture(none, 7), std::nullopt) << none;
}

TEST(Film, RejectsInvalidOutputs) {
    const TemporaryFolder folder;
    EXPECT_EQ(FilmWriter::create(folder / "film.avi", Existing::keep).error().kind, ErrorKind::usage);
    EXPECT_FALSE(FilmWriter::create(folder / "nowhere/film.mkv", Existing::keep));
    auto empty = FilmWriter::create(folder / "film.mkv", Existing::keep);
    ASSERT_TRUE(empty);
    EXPECT_FALSE((*empty)->finish(3));
    EXPECT_FALSE(std::filesystem::exists(folder / "film.mkv"));
}

// The sound a clip has beside its pictures.

class ClipSound : public ::testing::Test {
protected:
    std::filesystem::path file() const { return folder_ / "sound.mkv"; }
    /// `count` samples from `first` on.
    std::vector<StereoSample> heard(std::int64_t first, std::size_t count) const {
        const auto track = must(SoundTrack::open(file()));
        EXPECT_TRUE(track);
        return track ? heard_in(*track, first, count) : std::vector<StereoSample>(count);
    }
    /// A clip of 20 frames without sound.
    std::filesystem::path mute_clip() const {
        const auto pictures = folder_ / "clip.mkv";
        EXPECT_EQ(message(write_clip(pictures, small_scene(40, 30, 16), 20, {true, true, true, false})), "");
        return pictures;
    }
    static double difference(const std::vector<StereoSample>& heard, const std::vector<StereoSample>& wanted,
                             std::int64_t first) {
        double most = 0;
        for (std::size_t k = 0; k < heard.size(); ++k) {
            const std::int64_t at = first + static_cast<std::int64_t>(k);
            const bool is_there = at >= 0 && at < std::ssize(wanted);
            const StereoSample sample = is_there ? wanted[static_cast<std::size_t>(at)] : StereoSample{};
            most = std::max<double>(
                {most, std::abs(heard[k].left - sample.left), std::abs(heard[k].right - sample.right)});
        }
        return most;
    }
    TemporaryFolder folder_;
};

TEST_F(ClipSound, ReadsFromAnywhere) {
    const auto sound = tone(440, 1.5);
    write_sounding_clip(file(), sound);
    for (const std::int64_t first : {0, 30'000, 1, 999, 71'000, 60'123, 90'000, -500})
        EXPECT_EQ(difference(heard(first, 3000), sound, first), 0) << first;
}

TEST_F(ClipSound, ReadsOn) {
    const auto sound = tone(300, 1);
    write_sounding_clip(file(), sound);
    auto track = must(SoundTrack::open(file()));
    std::vector<StereoSample> samples(777);
    for (std::int64_t first = 0; first < 50'000; first += 777) {
        track->read(samples);
        ASSERT_EQ(difference(samples, sound, first), 0) << first;
    }
}

TEST_F(ClipSound, ResamplesOtherRates) {
    write_sounding_clip(file(), tone(440, 1, 44'100), {}, 44'100);
    EXPECT_LT(difference(heard(4800, 20'000), tone(440, 1), 4800), 0.01);
    EXPECT_LT(difference(heard(20'000, 20'000), tone(440, 1), 20'000), 0.01);
}

TEST_F(ClipSound, BeginsWithTheFirstPicture) {
    const auto pictures = mute_clip();
    const auto sound = tone(440, 0.6);
    write_sounding_clip(file(), sound, pictures, SoundTrack::rate, 100,
                        0);  // sound is a tenth of a second late
    EXPECT_EQ(difference(heard(0, 9600), sound, -4800), 0);
    write_sounding_clip(file(), sound, pictures, SoundTrack::rate, 0, 100);
    EXPECT_EQ(difference(heard(0, 9600), sound, 4800), 0);
    EXPECT_TRUE(open_clip(file())) << "a clip with sound is a clip";
}

TEST_F(ClipSound, DoesNotLengthenTheClip) {
    const auto pictures = mute_clip();
    write_sounding_clip(file(), tone(440, 2), pictures);
    auto reader = must(open_clip(file()));
    EXPECT_EQ(reader->frame_count(), 20);
    const auto frames = must(read_all(*reader));
    EXPECT_EQ(frames.size(), 20U);
}

TEST_F(ClipSound, IsOptional) {
    write_bytes(folder_ / "words.mkv", "this is no film");
    for (const auto& path : {mute_clip(), folder_ / "words.mkv", folder_ / "missing", folder_.path()}) {
        const auto track = SoundTrack::open(path);
        ASSERT_EQ(message(track), "") << path;
        EXPECT_EQ(*track, nullptr) << path;
    }
}

TEST_F(ClipSound, RejectsImpossibleRate) {
    std::string wav =
        read_bytes(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds/sound/s16.wav");
    const auto with_rate = [&](std::uint32_t rate) {
        std::memcpy(wav.data() + 24, &rate, sizeof rate);
        write_bytes(file(), wav);
        return message(SoundTrack::open(file()));
    };
    EXPECT_EQ(with_rate(768'000), "");
    EXPECT_TRUE(has_words(with_rate(100'000'007), "it has 100000007 samples a second"));
}

TEST_F(ClipSound, IsSilentWhereCut) {
    const auto sound = tone(440, 1);
    write_sounding_clip(file(), sound);
    std::filesystem::resize_file(file(), std::filesystem::file_size(file()) / 2);
    EXPECT_EQ(difference(heard(0, 10'000), sound, 0), 0);
    EXPECT_EQ(difference(heard(40'000, 8000), {}, 40'000), 0);
}

TEST_F(ClipSound, IgnoresDamageBeforeSeek) {
    write_sounding_film(file(), tone(440, 2));
    std::string bytes = read_bytes(file());
    std::vector<std::string> frames;
    for (const std::string& packet : packets(file()))
        if (packet.starts_with("\xff\xf8")) frames.push_back(packet);  // FLAC's
    ASSERT_GT(frames.size(), 5U);
    bytes.replace(bytes.find(frames[3]), frames[3].size(), frames[3].size(), '\0');
    write_bytes(file(), bytes);
    const auto track = must(SoundTrack::open(file()));
    heard_in(*track, 72'000, 9600);
    EXPECT_FALSE(track->is_damaged());
    heard_in(*track, 0, 48'000);
    EXPECT_TRUE(track->is_damaged());
}

// Sound that is kept as it is stored.

TEST(StoredSound, StaysInStepWithFrames) {
    const TemporaryFolder folder;
    const Scene scene = small_scene(16, 12);
    ASSERT_EQ(message(write_clip(folder / "mute.mkv", scene, 30, {})), "");
    const auto sound = tone(20, 1.0);
    write_sounding_clip(folder / "clip.mkv", sound, folder / "mute.mkv", SoundTrack::rate, 0, 0);
    const auto facts = sound_of(folder / "clip.mkv");
    ASSERT_TRUE(facts.has_value());
    EXPECT_TRUE(facts->storable);
    for (const auto& [first, last] : {std::pair{0, 29}, {12, 23}}) {
        const auto file = folder / ("part" + std::to_string(first) + ".mkv");
        const SoundPart part{folder / "clip.mkv", scene.rate.time_ns(first), scene.rate.time_ns(last + 1)};
        ASSERT_EQ(message(write_clip(file, scene, last - first + 1, {}, exact_clip, part)), "");
        EXPECT_EQ(std::ssize(must(read_clip(file))), last - first + 1) << "sound makes a clip no longer";
        auto track = must(SoundTrack::open(file));
        ASSERT_TRUE(track);
        // All but the packets at the ends, which begin before or end after.
        const auto count = static_cast<std::size_t>((last - first + 1) * SoundTrack::rate / 30);
        const auto wanted = std::span(sound).subspan(static_cast<std::size_t>(first * SoundTrack::rate / 30));
        constexpr std::size_t packet = 2048;
        const double largest = largest_difference(heard_in(*track, 0, count), wanted, packet, packet);
        // Matroska's times are whole milliseconds: half of one, of 20 Hz.
        EXPECT_LE(largest, 2 * 3.15 * 20 * 0.0005) << first;
    }
}

TEST(StoredSound, RejectsSilentClip) {
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
