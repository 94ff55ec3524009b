// The sound a clip has beside its pictures.
#include "engine/picture/sound.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <vector>

#include "engine/clip/clip_file.hpp"
#include "tests/clip/clip_fixture.hpp"
#include "tests/video/sounding_clip.hpp"

namespace touchable::test {
namespace {

class Sounding : public ::testing::Test {
protected:
    std::filesystem::path file() const { return folder_ / "sound.mkv"; }
    /// `count` samples from `first` on.
    std::vector<StereoSample> heard(std::int64_t first, std::size_t count) {
        auto track = SoundTrack::open(file());
        EXPECT_EQ(message(track), "");
        std::vector<StereoSample> samples(count);
        if (!track || !*track) return samples;
        (*track)->seek(first);
        (*track)->read(samples);
        return samples;
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

TEST_F(Sounding, IsTheSameFromAnywhereSilentBeforeAndAfter) {
    const auto sound = tone(440, 1.5);
    write_sounding_clip(file(), sound);
    for (const std::int64_t first : {0, 30'000, 1, 999, 71'000, 60'123, 90'000, -500})
        EXPECT_EQ(difference(heard(first, 3000), sound, first), 0) << first;
}

TEST_F(Sounding, GoesOnWhereItWasRead) {
    const auto sound = tone(300, 1);
    write_sounding_clip(file(), sound);
    auto track = SoundTrack::open(file());
    ASSERT_EQ(message(track), "");
    std::vector<StereoSample> samples(777);
    for (std::int64_t first = 0; first < 50'000; first += 777) {
        (*track)->read(samples);
        ASSERT_EQ(difference(samples, sound, first), 0) << first;
    }
}

TEST_F(Sounding, OfAnotherRateIsResampled) {
    write_sounding_clip(file(), tone(440, 1, 44'100), {}, 44'100);
    EXPECT_LT(difference(heard(4800, 20'000), tone(440, 1), 4800), 0.01);
    EXPECT_LT(difference(heard(20'000, 20'000), tone(440, 1), 20'000), 0.01);
}

TEST_F(Sounding, BeginsWithTheFirstPicture) {
    const auto pictures = folder_ / "clip.mkv";
    ASSERT_EQ(message(write_clip(pictures, small_scene(40, 30, 16), 20, {true, true, true, false},
                                 {Archive::fast, true})),
              "");
    const auto sound = tone(440, 0.6);
    write_sounding_clip(file(), sound, pictures, SoundTrack::rate, 100,
                        0);  // sound is a tenth of a second late
    EXPECT_EQ(difference(heard(0, 9600), sound, -4800), 0);
    write_sounding_clip(file(), sound, pictures, SoundTrack::rate, 0, 100);
    EXPECT_EQ(difference(heard(0, 9600), sound, 4800), 0);
    EXPECT_TRUE(open_clip(file())) << "a clip with sound is a clip";
}

TEST_F(Sounding, LongerThanThePicturesMakesAClipNoLonger) {
    const auto pictures = folder_ / "clip.mkv";
    ASSERT_EQ(message(write_clip(pictures, small_scene(40, 30, 16), 20, {true, true, true, false},
                                 {Archive::fast, true})),
              "");
    write_sounding_clip(file(), tone(440, 2), pictures);
    auto reader = open_clip(file());
    ASSERT_EQ(message(reader), "");
    EXPECT_EQ((*reader)->frame_count(), 20);
    const auto frames = read_all(**reader);
    ASSERT_EQ(message(frames), "");
    EXPECT_EQ(frames->size(), 20U);
}

TEST_F(Sounding, IsNotThereWhereThereIsNone) {
    ASSERT_EQ(message(write_clip(file(), small_scene(40, 30, 16), 2, {true, true, true, false},
                                 {Archive::fast, true})),
              "");
    std::ofstream(folder_ / "words.mkv") << "this is no film";
    for (const auto& path : {file(), folder_ / "words.mkv", folder_ / "missing", folder_.path()}) {
        const auto track = SoundTrack::open(path);
        ASSERT_EQ(message(track), "") << path;
        EXPECT_EQ(*track, nullptr) << path;
    }
}

TEST_F(Sounding, OfAnImpossibleRateIsRefusedBeforeItTakesMemory) {
    std::string wav =
        read_bytes(std::filesystem::path(TOUCHABLE_SOURCE_DIR) / "tests/fuzz/seeds/sound/s16.wav");
    const auto with_rate = [&](std::uint32_t rate) {
        std::memcpy(wav.data() + 24, &rate, sizeof rate);
        std::ofstream(file(), std::ios::binary) << wav;
        return message(SoundTrack::open(file()));
    };
    EXPECT_EQ(with_rate(768'000), "");
    EXPECT_NE(with_rate(100'000'007).find("it has 100000007 samples a second"), std::string::npos);
}

TEST_F(Sounding, ThatIsCutIsSilentFromThere) {
    const auto sound = tone(440, 1);
    write_sounding_clip(file(), sound);
    std::filesystem::resize_file(file(), std::filesystem::file_size(file()) / 2);
    EXPECT_EQ(difference(heard(0, 10'000), sound, 0), 0);
    EXPECT_EQ(difference(heard(40'000, 8000), {}, 40'000), 0);
}

}  // namespace
}  // namespace touchable::test
