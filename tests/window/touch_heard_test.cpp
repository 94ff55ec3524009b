// What is heard of a finger on a surface: from the pointer to the file and to the loudspeakers.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <thread>
#include <vector>

#include "player/audio/window_sound.hpp"
#include "tests/player/program.hpp"
#include "tests/temporary_folder.hpp"
#include "tests/video/sounding_clip.hpp"
#include "tests/window/fingers_over_globe.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

std::vector<char> bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

/// Samples of the left channel, by milliseconds.
class Wav {
public:
    explicit Wav(const std::filesystem::path& file) {
        const std::vector<char> bytes = bytes_of(file);
        EXPECT_GE(bytes.size(), 44U);
        if (bytes.size() < 44) return;
        EXPECT_EQ(std::string(bytes.data(), 4), "RIFF");
        EXPECT_EQ(std::string(bytes.data() + 8, 8), "WAVEfmt ");
        EXPECT_EQ(number(bytes, 4, 4), bytes.size() - 8);
        EXPECT_EQ(number(bytes, 22, 2), 2U);
        EXPECT_EQ(number(bytes, 24, 4), 48000U);
        EXPECT_EQ(number(bytes, 40, 4), bytes.size() - 44);
        for (std::size_t at = 44; at + 4 <= bytes.size(); at += 4)
            samples_.push_back(static_cast<std::int16_t>(number(bytes, at, 2)) / 32767.0);
    }
    std::size_t milliseconds() const { return samples_.size() / 48; }
    double loudness(std::size_t from_ms, std::size_t to_ms) const {
        double sum = 0;
        for (std::size_t k = from_ms * 48; k < to_ms * 48 && k < samples_.size(); ++k)
            sum += samples_[k] * samples_[k];
        return std::sqrt(sum / static_cast<double>((to_ms - from_ms) * 48));
    }

private:
    static std::size_t number(const std::vector<char>& bytes, std::size_t at, std::size_t count) {
        std::size_t value = 0;
        for (std::size_t k = 0; k < count; ++k)
            value |= static_cast<std::size_t>(static_cast<unsigned char>(bytes[at + k])) << (8 * k);
        return value;
    }
    std::vector<double> samples_;
};

/// A pointer over the globe, in a time of its own.
class HeardGlobe : public FingersOverGlobe {
protected:
    HeardGlobe() : FingersOverGlobe({320, 240}, {640, 480}) {}
    // Of the picture, pixels: sea, and mountains.
    static constexpr glm::dvec2 sea{220, 250}, land{250, 120};

    void SetUp() override {
        const Scene& scene = shown_->scene;
        auto solver = TouchSolver::create(scene, {.metres_per_scene_unit = workspace_.metres_per_scene_unit});
        ASSERT_TRUE(solver);
        solver_.emplace(std::move(*solver));
        step_.emplace(*solver_, GuardSettings{}, PointerFingers::most);
        auto sound = WindowSound::create(false, file(), Existing::keep);
        ASSERT_TRUE(sound);
        sound_ = std::move(*sound);
        listener_.emplace(*sound_, scene.width);
        listener_->begin(PlaybackClock(scene.rate), 0);
    }
    std::filesystem::path file() const { return folder_ / "heard.wav"; }
    void go_on(int ticks) {
        for (int k = 0; k < ticks; ++k, ++tick_) {
            if (tick_ % 16 == 0) fingers_->intend(field(), camera());
            ASSERT_TRUE(device_.read_positions(step_->goals()));
            for (glm::dvec3& goal : step_->goals()) goal = workspace_.to_scene(goal);
            const TouchTick done = step_->run(tick_, tick_ * 1'000'000, shown_->scene, shown_->pair());
            ASSERT_TRUE(listener_->take(done));
        }
    }
    /// Over the picture, pressed, and then to the right for 600 ms.
    void stroke(const glm::dvec2& from, int pixels) {
        fingers_->set_pointer(from);
        go_on(300);
        fingers_->press(true);
        go_on(300);
        for (int k = 0; k < 40; ++k) {
            fingers_->set_pointer(from + glm::dvec2(pixels * k / 40.0, 0));
            go_on(15);
        }
        fingers_->press(false);
        fingers_->set_pointer({});
    }
    Wav heard() {
        EXPECT_TRUE(sound_->finish());
        return Wav(file());
    }

    TemporaryFolder folder_;
    std::optional<TouchSolver> solver_;
    std::optional<TouchStep> step_;
    std::unique_ptr<WindowSound> sound_;
    std::optional<TouchListener> listener_;
    std::int64_t tick_ = 0;
};

TEST_F(HeardGlobe, RoughLandIsLouderThanTheSmoothSea) {
    stroke(sea, 90);
    go_on(300);
    stroke(land, 90);
    const Wav wav = heard();
    ASSERT_EQ(wav.milliseconds(), 2700U);
    EXPECT_EQ(wav.loudness(0, 300), 0) << "over the surface";
    EXPECT_GT(wav.loudness(300, 500), 0.002) << "no tap";
    EXPECT_GT(wav.loudness(700, 1200), 0.002) << "the sea is not heard";
    EXPECT_EQ(wav.loudness(1450, 1500), 0) << "away";
    EXPECT_GT(wav.loudness(2200, 2700), 1.5 * wav.loudness(700, 1200));
}

TEST_F(HeardGlobe, SurfaceThatIsAnotherAllAtOnceIsNoTap) {
    fingers_->set_pointer(sea);
    go_on(300);
    fingers_->press(true);
    go_on(800);
    listener_.emplace(*sound_, shown_->scene.width);  // other settings, with the finger where it was
    listener_->begin(PlaybackClock(shown_->scene.rate), 0);
    tick_ = 0;
    go_on(200);
    fingers_->press(false);
    go_on(300);
    fingers_->press(true);
    go_on(300);
    const Wav wav = heard();
    EXPECT_GT(wav.loudness(300, 500), 0.002) << "no tap";
    EXPECT_LT(wav.loudness(1100, 1300), 1e-4);
    EXPECT_GT(wav.loudness(1600, 1900), 0.002) << "no tap";
}

TEST_F(HeardGlobe, IsSilentWhileMuted) {
    sound_->set_muted(true);
    EXPECT_EQ(sound_->state(), "sound off");
    stroke(sea, 90);
    sound_->set_muted(false);
    stroke(sea, 90);
    const Wav wav = heard();
    EXPECT_EQ(wav.loudness(0, 1200), 0);
    EXPECT_GT(wav.loudness(1500, 2400), 0.002);
}

TEST(Sound, OfTheWindowIsKept) {
    const TemporaryFolder folder;
    const std::string clip = (folder / "globe.mkv").string(), wav = (folder / "heard.wav").string();
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "160x120", "--frames", "2"}).code, 0);
    const auto play = [&] {
        return run_scripted({clip, "--seconds", "0.6", "--sound", wav}, "0 move 160 130\n0.2 press left\n",
                            folder.path());
    };
    const auto played = play();
    ASSERT_EQ(played.code, 0) << played.err;
    const Wav heard(wav);
    EXPECT_GT(heard.milliseconds(), 400U);
    EXPECT_GT(heard.loudness(0, heard.milliseconds()), 0.001);
    const auto again = play();
    EXPECT_EQ(again.code, 2);
    EXPECT_NE(again.err.find("--overwrite"), std::string::npos) << again.err;
}

/// A visitor has stopped forces: the next one presses, and feels.
TEST(Sound, OfAKioskIsThereAgainForWhoeverPresses) {
    const TemporaryFolder folder;
    const std::string clip = (folder / "globe.mkv").string(), wav = (folder / "heard.wav").string();
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "160x120", "--frames", "2"}).code, 0);
    const auto played = run_scripted({clip, "--kiosk", "--seconds", "1.5", "--sound", wav},
                                     "0 move 160 130\n0 key f\n0.3 press left\n", folder.path());
    ASSERT_EQ(played.code, 0) << played.err;
    const Wav heard(wav);
    EXPECT_GT(heard.loudness(0, heard.milliseconds()), 0.001);
}

TEST(Sound, OfTheClipIsKeptWithItsTouch) {
    const TemporaryFolder folder;
    const std::string clip = (folder / "globe.mkv").string(), wav = (folder / "heard.wav").string();
    ASSERT_EQ(run_touchable({"make", "globe", clip, "--size", "64x48", "--frames", "60"}).code, 0);
    std::vector<StereoSample> sound = tone(480, 1.8);
    std::fill_n(sound.begin(), 24'000, StereoSample{});  // for half a second it is silent
    write_sounding_clip(folder / "sounding.mkv", sound, clip);
    const auto played = run_touchable({"play", (folder / "sounding.mkv").string(), "--headless", "--size",
                                       "160x120", "--seconds", "1.2", "--sound", wav});
    ASSERT_EQ(played.code, 0) << played.err;
    const Wav heard(wav);
    ASSERT_GT(heard.milliseconds(), 1000U);
    EXPECT_EQ(heard.loudness(0, 300), 0);
    EXPECT_GT(heard.loudness(700, 1000), 0.3);
}

/// ALSA as those lines configure it.
class Loudspeakers : public ::testing::Test {
protected:
    void configure(const std::string& lines) {
        std::ofstream(folder_ / "asound.conf") << lines;
        ASSERT_EQ(setenv("ALSA_CONFIG_PATH", (folder_ / "asound.conf").c_str(), 1), 0);
    }
    void TearDown() override { unsetenv("ALSA_CONFIG_PATH"); }
    /// Whether it came to be in ten seconds, far longer than any machine takes.
    template <class What>
    static bool comes_true(What what) {
        for (int k = 0; k < 10000 && !what(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return what();
    }
    TemporaryFolder folder_;
};

TEST_F(Loudspeakers, ThatAreMissingAreNoError) {
    configure("");
    auto sound = WindowSound::create(true, {}, Existing::keep);
    ASSERT_TRUE(sound);
    testing::internal::CaptureStderr();
    EXPECT_TRUE(comes_true([&] { return (*sound)->state().starts_with("no sound: "); })) << (*sound)->state();
    (*sound)->take({}, 1);
    EXPECT_TRUE((*sound)->finish());
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_F(Loudspeakers, GetWhatIsTouched) {
#ifndef TOUCHABLE_HAS_ALSA
    GTEST_SKIP() << "built without ALSA";
#endif
    const std::string file = (folder_ / "raw").string();
    configure("pcm.!default {\n type file\n file \"" + file +
              "\"\n format raw\n slave.pcm { type null }\n}\n");
    auto sound = WindowSound::create(true, {}, Existing::keep);
    ASSERT_TRUE(sound);
    ASSERT_TRUE(comes_true([&] { return (*sound)->state() == "sound on"; })) << (*sound)->state();
    HeardTick tick;
    tick.fingers[0] = {.touching = true, .newtons = 2, .slip = 0.1F, .stiffness = 1000};
    const bool heard = comes_true([&] {
        (*sound)->take(tick, 1);
        const std::vector<char> bytes = bytes_of(file);
        return std::any_of(bytes.begin(), bytes.end(), [](char byte) { return byte != 0; });
    });
    EXPECT_TRUE(heard);
}

}  // namespace
}  // namespace touchable::test
