// The clip's own sound in the window: at the clip's moments, whatever is done to its time.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "engine/clip/clip_file.hpp"
#include "engine/picture/image.hpp"
#include "player/audio/heard_sound.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/video/sounding_clip.hpp"

namespace touchable::test {
namespace {

class ClipHeard : public ::testing::Test {
protected:
    void SetUp() override { begin(tone(480, 3)); }
    void begin(std::vector<StereoSample> sound) {
        sound_ = std::move(sound);
        const auto file = folder_ / (std::to_string(++files_) + ".mkv");
        write_sounding_clip(file, sound_);
        clip_.open(file);
        wait_for(0);
    }
    /// Until a second and a half from there has been decoded.
    void wait_for(double seconds) {
        std::vector<StereoSample> samples(72'000);
        for (int k = 0; k < 10'000; ++k) {
            if (clip_.read(static_cast<std::int64_t>(seconds * SoundTrack::rate) - 1, samples)) return;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        FAIL() << "nothing is decoded at " << seconds << " s";
    }
    /// Ticks from a moment on, at a speed.
    std::vector<StereoSample> hear(double from_s, int ticks, float speed = 1, std::uint64_t epoch = 0) {
        std::vector<StereoSample> heard;
        ContactSound::Samples samples{};
        for (int k = 0; k < ticks; ++k) {
            HeardTick tick;
            tick.clip = {true, static_cast<std::int64_t>(1e9 * from_s + 1e6 * speed * k), epoch, speed};
            voice_.render(tick, clip_, samples);
            heard.insert(heard.end(), samples.begin(), samples.end());
        }
        return heard;
    }
    std::vector<StereoSample> hear_nothing(int ticks) {
        std::vector<StereoSample> heard;
        ContactSound::Samples samples{};
        for (int k = 0; k < ticks; ++k) {
            voice_.render(HeardTick{}, clip_, samples);
            heard.insert(heard.end(), samples.begin(), samples.end());
        }
        return heard;
    }
    static int zero_crossings(const std::vector<StereoSample>& heard) {
        int count = 0;
        for (std::size_t k = 1; k < heard.size(); ++k)
            if ((heard[k - 1].left < 0) != (heard[k].left < 0)) ++count;
        return count;
    }
    static double largest_step(const std::vector<StereoSample>& heard) {
        double most = 0;
        for (std::size_t k = 1; k < heard.size(); ++k)
            most = std::max<double>(most, std::abs(heard[k].left - heard[k - 1].left));
        return most;
    }

    TemporaryFolder folder_;
    int files_ = 0;
    std::vector<StereoSample> sound_;
    ClipSound clip_;
    HeardSound voice_;
};

TEST_F(ClipHeard, IsTheTracksOwnAtItsOwnSpeed) {
    wait_for(0.2);
    const auto heard = hear(0.5, 200);
    for (std::size_t k = 48; k < heard.size(); ++k) {  // after it has risen
        ASSERT_NEAR(heard[k].left, sound_[24'000 + k].left, 1e-5) << k;
        ASSERT_NEAR(heard[k].right, sound_[24'000 + k].right, 1e-5) << k;
    }
}

TEST_F(ClipHeard, IsHigherWhereTheClipIsFaster) {
    wait_for(0.2);
    const int once = zero_crossings(hear(0.5, 200));
    EXPECT_NEAR(zero_crossings(hear(0.5, 200, 2, 1)), 2 * once, 3);
    EXPECT_NEAR(zero_crossings(hear(0.5, 200, 0.5F, 2)), once / 2, 3);
}

TEST_F(ClipHeard, HasNoJumpsWhereTheClipJumpsPausesAndEnds) {
    wait_for(0.2);
    const double step = 1.3 * largest_step(sound_);
    auto heard = hear(0.5, 50);
    for (const auto& part :
         {hear(1.0012, 50, 1, 1), hear_nothing(20), hear(0.2507, 50, 1, 1), hear(0.9, 50, 1, 1)})
        heard.insert(heard.end(), part.begin(), part.end());
    EXPECT_LT(largest_step(heard), step + 0.5 / 48);
}

/// What comes last takes the place of what came first: a block is there, and the one behind it is not yet.
TEST_F(ClipHeard, HasNoJumpsWhereItIsNotDecodedInTime) {
    const double step = 1.3 * largest_step(sound_);
    for (std::uint64_t go = 0; go < 20; ++go) {
        wait_for(1.4);
        for (const double from_s : {0.16, 0.0, 0.08}) {
            const auto heard = hear(from_s, 300, 4, 3 * go + static_cast<std::uint64_t>(100 * from_s));
            ASSERT_LT(largest_step(heard), 4 * step + 0.5 / 48) << go;
        }
    }
}

TEST_F(ClipHeard, IsSilentWhileNothingPlays) {
    hear(0.5, 50);
    hear_nothing(2);
    for (const StereoSample& sample : hear_nothing(50)) ASSERT_EQ(sample.left, 0);
}

TEST_F(ClipHeard, FollowsTicksThatComeTooFast) {
    // A hundredth of a percent is what clocks differ by; a tenth is far more.
    wait_for(0.1);
    std::vector<StereoSample> heard;
    ContactSound::Samples samples{};
    HeardTick tick;
    for (int k = 0; k < 1000; ++k) {
        tick.clip = {true, static_cast<std::int64_t>(200'000'000 + 1'001'000.0 * k), 0, 1};
        voice_.render(tick, clip_, samples);
        heard.insert(heard.end(), samples.begin(), samples.end());
    }
    EXPECT_LT(largest_step(heard), 1.1 * largest_step(sound_));
    EXPECT_GT(zero_crossings(heard), 2 * 480 - 3);
}

TEST_F(ClipHeard, OfAnotherFileIsAnother) {
    hear(0.1, 20);
    begin(tone(960, 1));
    hear_nothing(2);
    const auto heard = hear(0, 100);
    EXPECT_NEAR(zero_crossings(heard), 192, 4);
    clip_.open(folder_ / "missing.mkv");
    hear_nothing(2);
    for (const StereoSample& sample : hear(0, 50)) ASSERT_EQ(sample.left, 0);
    EXPECT_EQ(clip_.fault(), "");
}

TEST_F(ClipHeard, OfAFileThatWasReplacedIsTheNewOnes) {
    hear(0.1, 20);
    std::filesystem::remove(folder_ / "1.mkv");
    files_ = 0;
    begin(tone(960, 1));
    hear_nothing(2);
    EXPECT_NEAR(zero_crossings(hear(0, 100)), 192, 4);
}

TEST_F(ClipHeard, IsFoundWhereverTheClipGoes) {
    begin(tone(480, 20));
    for (const double moment : {15.0, 3.0, 19.5, 0.0, 7.77}) wait_for(moment);
    wait_for(7.77);
    const auto heard = hear(7.77, 20);
    for (std::size_t k = 48; k < heard.size(); ++k)
        ASSERT_NEAR(heard[k].left, sound_[372'960 + k].left, 1e-4) << k;
}

TEST(ClipSound, SaysThatATrackIsDamagedOnceItMeetsThePlace) {
    const TemporaryFolder folder;
    const std::filesystem::path file = folder / "film.mkv";
    auto film = FilmWriter::create(file, Existing::keep);
    ASSERT_TRUE(film);
    const Image grey{64, 48, 1, 3, std::vector<std::uint8_t>(64 * 48 * 3, 128)};
    ASSERT_TRUE((*film)->add(grey.view(), 0));
    ASSERT_TRUE((*film)->add_sound(0, tone(480, 1.5)));  // FLAC, which knows when it is not whole
    ASSERT_TRUE((*film)->finish(45));
    const auto fault_of = [](const std::filesystem::path& clip) {
        ClipSound sound;
        sound.open(clip);
        std::vector<StereoSample> samples(60'000);
        for (int k = 0; k < 10'000 && !sound.read(0, samples); ++k)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return sound.fault();
    };
    EXPECT_EQ(fault_of(file), "");
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekp(static_cast<std::streamoff>(std::filesystem::file_size(file) / 2));
    bytes << std::string(6000, '\xAA');
    bytes.close();
    EXPECT_NE(fault_of(file).find("film.mkv: its sound is damaged"), std::string::npos);
}

}  // namespace
}  // namespace touchable::test
