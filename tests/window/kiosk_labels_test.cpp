// A kiosk's labels and texts, by the program as a person starts it: what is seen, and what is heard.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <string>
#include <vector>

#include "engine/picture/image.hpp"
#include "engine/picture/sound.hpp"
#include "player/audio/heard_sound.hpp"
#include "player/audio/window_sound.hpp"
#include "tests/player/program.hpp"
#include "tests/video/sounding_clip.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/two_surfaces.hpp"

namespace touchable::test {
namespace {

constexpr double label_hertz = 3000;

class KioskLabels : public ::testing::Test {
protected:
    void SetUp() override {
        clip_ = (folder_ / "still.mkv").string();
        ASSERT_EQ(run_touchable({"make", "globe", clip_, "--size", "160x120", "--frames", "1"}).code, 0);
        write_sounding_clip(folder_ / "bell.wav", tone(label_hertz, 0.4));
    }
    /// The finger comes to the middle of a window of 320x240, and stays.
    Outcome play(const std::string& labels, const std::vector<std::string>& more = {},
                 const std::string& script = "0 move 160 110\n0.1 press left\n", const char* at_s = "2",
                 const char* bar = "off") {
        std::ofstream(folder_ / "labels.json") << "{\"touchable_labels\": 1, \"labels\": [" << labels << "]}";
        std::filesystem::remove(folder_ / "heard.wav");
        std::filesystem::remove(folder_ / "shot.png");
        std::vector<std::string> words{
            clip_,          "--kiosk",   "--kiosk-bar", bar,
            "--sound",      "heard.wav", "--labels",    (folder_ / "labels.json").string(),
            "--screenshot", "shot.png",  "--at",        at_s};
        words.insert(words.end(), more.begin(), more.end());
        return run_scripted(words, script, folder_.path());
    }
    /// How much of the label's tone is in a stretch of what was heard, seconds: its amplitude.
    double tone_between(double from_s, double to_s) const {
        const auto track = SoundTrack::open(folder_ / "heard.wav");
        EXPECT_TRUE(track && *track);
        if (!track || !*track) return -1;
        std::vector<StereoSample> heard(static_cast<std::size_t>(to_s * SoundTrack::rate));
        (*track)->read(heard);
        double sine = 0, cosine = 0;
        const auto from = static_cast<std::size_t>(from_s * SoundTrack::rate);
        for (std::size_t k = from; k < heard.size(); ++k) {
            const double angle =
                2 * std::numbers::pi * label_hertz * static_cast<double>(k) / SoundTrack::rate;
            sine += static_cast<double>(heard[k].left) * std::sin(angle);
            cosine += static_cast<double>(heard[k].left) * std::cos(angle);
        }
        return 2 * std::hypot(sine, cosine) / static_cast<double>(heard.size() - from);
    }
    /// Bright pixels where captions are; above the bar where there is one.
    int written(int from = 200, int to = 236, int left = 20, int right = 300) const {
        const auto shot = read_image(folder_ / "shot.png");
        EXPECT_TRUE(shot);
        if (!shot) return -1;
        int count = 0;
        for (int y = from; y < to; ++y)
            for (int x = left; x < right; ++x) {
                const auto* const rgb = &shot->samples[static_cast<std::size_t>((y * shot->width + x) * 3)];
                count += rgb[0] > 200 && rgb[1] > 200 && rgb[2] > 200;
            }
        return count;
    }

    const TemporaryFolder folder_;
    std::string clip_;
};

TEST_F(KioskLabels, AreShownAndHeardWhereAFingerRestsAndNowhereElse) {
    const std::string middle =
        R"({"caption": "Indian Ocean", "sound": "bell.wav", "rectangle": [60, 40, 100, 70]})";
    const auto rested = play(middle);
    ASSERT_EQ(rested.code, 0) << rested.err;
    EXPECT_GT(written(), 100) << "no caption";
    EXPECT_LT(tone_between(0, 0.5), 0.01) << "the finger had not rested yet";
    EXPECT_GT(tone_between(0.5, 2), 0.08) << "no sound";
    const std::string other =
                          R"({"caption": "Indian Ocean", "sound": "bell.wav", "rectangle": [0, 0, 50, 119]})",
                      press = "0 move 160 110\n0.1 press left\n";
    const auto beside = play(other);
    ASSERT_EQ(beside.code, 0) << beside.err;
    EXPECT_LT(written(), 20);
    ASSERT_EQ(play(middle, {}, press, "2", "on").code, 0);
    EXPECT_GT(written(135, 160), 60) << "the bar is over it";
    ASSERT_EQ(play(other, {}, press, "2", "on").code, 0);
    EXPECT_LT(written(135, 160), 20);
    EXPECT_LT(tone_between(0.5, 2), 0.01);
    const auto above = play(middle, {}, "0 move 160 110\n");
    ASSERT_EQ(above.code, 0) << above.err;
    EXPECT_LT(written(), 20) << "the finger touched nothing";
    const auto muted = play(middle, {}, "0 move 160 110\n0 mute\n0.1 press left\n");
    ASSERT_EQ(muted.code, 0) << muted.err;
    EXPECT_LT(tone_between(0.5, 2), 0.01) << "M silences all";
}

TEST_F(KioskLabels, OfSegmentsAreFoundByTheirNames) {
    ASSERT_NO_FATAL_FAILURE(write_two_surfaces(folder_ / "wall.mkv", 1));
    clip_ = (folder_ / "wall.mkv").string();
    std::ofstream(folder_ / "segments.json")
        << R"({"touchable_segments": 1, "segments": [{"name": "the wall", "material": "wood", "at": [20, 20, 0]}]})";
    const std::string label = R"({"caption": "the wall", "sound": "bell.wav", "segment": "the wall"})";
    const auto refused = play(label);
    EXPECT_EQ(refused.code, 3);
    EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
    EXPECT_NE(refused.err.find("--segments"), std::string::npos) << refused.err;
    const std::vector<std::string> segments{"--segments", (folder_ / "segments.json").string()};
    const auto rested = play(label, segments, "0 move 80 120\n0.3 press left\n", "4");
    ASSERT_EQ(rested.code, 0) << rested.err;
    EXPECT_GT(written(), 40);
    const auto beside = play(label, segments, "0 move 250 120\n0.3 press left\n", "4");
    ASSERT_EQ(beside.code, 0) << beside.err;
    EXPECT_LT(written(), 20);
}

TEST_F(KioskLabels, ThatDoNotGoWithTheClipOrHaveNoSoundAreOneLine) {
    for (const auto& [label, words] :
         {std::pair{R"({"caption": "a", "rectangle": [0, 0, 160, 10]})", "160x120"},
          {R"({"caption": "a", "rectangle": [0, 0, 1, 1], "sound": "none.wav"})", "none.wav"},
          {R"({"caption": "a", "rectangle": [0, 0, 1, 1], "sound": "labels.json"})", "WAV"}}) {
        const auto refused = play(label);
        EXPECT_EQ(refused.code, 3) << label;
        EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
        EXPECT_NE(refused.err.find(words), std::string::npos) << refused.err;
    }
}

/// Each of them once, and each of the languages that come with the program.
TEST_F(KioskLabels, TextsAreOfTheLanguageThatIsAskedForOrOfAFile) {
    const auto bright = [&](const std::vector<std::string>& more, const char* language = nullptr) {
        if (language) setenv("LC_ALL", language, 1);
        std::vector<std::string> words{"play",
                                       clip_,
                                       "--kiosk",
                                       "--headless",
                                       "--size",
                                       "320x240",
                                       "--idle",
                                       "0.1",
                                       "9",
                                       "--screenshot",
                                       (folder_ / "shot.png").string(),
                                       "--at",
                                       "1.6",
                                       "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        const auto played = run_touchable(words);
        EXPECT_EQ(played.code, 0) << played.err;
        if (language) unsetenv("LC_ALL");
        return written();
    };
    const int english = bright({"--kiosk-texts", "en"}), german = bright({"--kiosk-texts", "de"});
    EXPECT_GT(english, 100);
    EXPECT_NE(english, german);
    EXPECT_EQ(bright({}, "de_AT.UTF-8"), german);
    EXPECT_EQ(bright({}, "C"), english);
    EXPECT_EQ(bright({}, "xx_XX"), english) << "a language without texts";
    std::ofstream(folder_ / "texts.json")
        << R"({"touchable_kiosk_texts": 1, "language": "de", "how_by_mouse": "I", "how_by_touch_screen": "I"})";
    EXPECT_LT(bright({"--kiosk-texts", (folder_ / "texts.json").string()}), english * 3 / 4);
    const auto none =
        run_touchable({"play", clip_, "--kiosk", "--headless", "--seconds", "0.2", "--kiosk-texts", "xx"});
    EXPECT_EQ(none.code, 2);
    EXPECT_TRUE(none.one_line_of_error()) << none.err;
    EXPECT_NE(none.err.find("de, en"), std::string::npos) << none.err;
}

TEST_F(KioskLabels, ALongTextHasSeveralLines) {
    std::string words;
    while (words.size() < 190) words += "Etna ";
    std::ofstream(folder_ / "texts.json")
        << R"({"touchable_kiosk_texts": 1, "language": "en", "invitation": ")" << words << R"("})";
    const auto played = run_touchable({"play", clip_, "--kiosk", "--headless", "--size", "320x240", "--idle",
                                       "0.1", "9", "--kiosk-texts", (folder_ / "texts.json").string(),
                                       "--screenshot", (folder_ / "shot.png").string(), "--at", "1.6"});
    ASSERT_EQ(played.code, 0) << played.err;
    EXPECT_EQ(written(115, 240, 0, 5), 0) << "cut off on the left";
    EXPECT_EQ(written(115, 240, 315, 320), 0) << "cut off on the right";
    EXPECT_GT(written(130, 155), 60) << "one of its lines";
    EXPECT_GT(written(180, 200), 60) << "another one";
}

TEST_F(KioskLabels, NoSettingLiftsAForceAboveTheMostThatWasAskedFor) {
    const std::string record = (folder_ / "hand.touch").string();
    std::ofstream(folder_ / "script")
        << "0 max-force 10\n0.3 move 160 110\n0.4 press left\n1.4 reset\n1.6 wheel -9\n";
    const auto most_felt = [&](const std::vector<std::string>& more) {
        std::vector<std::string> words{"play",     clip_,      "--headless",
                                       "--size",   "320x240",  "--seconds",
                                       "2.4",      "--script", (folder_ / "script").string(),
                                       "--record", record,     "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        const auto played = run_touchable(words);
        EXPECT_EQ(played.code, 0) << played.err;
        const auto again = run_touchable({"touch", "--replay", record, "--json", "-"});
        EXPECT_EQ(again.code, 0) << again.err;
        const std::size_t at = again.out.find("\"max\":", again.out.find("\"force_n\""));
        return at == std::string::npos ? -1 : std::atof(again.out.c_str() + at + 6);
    };
    EXPECT_GT(most_felt({}), 0.5);
    const double limited = most_felt({"--max-force", "0.3"});
    EXPECT_GT(limited, 0.2);
    EXPECT_LE(limited, 0.3);
}

TEST(SpokenSound, IsReadWholeAndSaidOnceWhileOthersAreSofter) {
    const TemporaryFolder folder;
    write_sounding_clip(folder / "tone.wav", tone(1000, 0.05));
    const auto sound = SpokenSound::read(folder / "tone.wav");
    ASSERT_TRUE(sound) << sound.error().message;
    EXPECT_NEAR(static_cast<double>((*sound)->samples.size()), 0.05 * 48000, 60);
    SpokenVoice voice;
    double said = 0, beside = 1, after = 0;
    for (int ms = 0; ms < 200; ++ms) {
        ContactSound::Samples samples{};
        for (StereoSample& sample : samples) sample.right = sample.left = 0.1F;
        voice.add(ms < 10 ? nullptr : sound->get(), ms < 10 ? 0 : 7, false, samples);
        for (const StereoSample& sample : samples) {
            if (ms < 10) {
                EXPECT_EQ(sample.left, 0.1F);
            }
            said = std::max(said, std::abs(static_cast<double>(sample.left)));
            if (ms == 199) after = static_cast<double>(sample.left);
        }
        double sum = 0;
        for (const StereoSample& sample : samples) sum += static_cast<double>(sample.left) / 48;
        if (ms == 55) beside = sum;  // 1 kHz is 0 over a millisecond
    }
    EXPECT_GT(said, 0.3);
    EXPECT_LT(beside, 0.06);
    EXPECT_NEAR(after, 0.1, 1e-6) << "as loud as before, and it is not said again";
}

TEST(SpokenSound, OfMoreThanAMinuteOrOfNothingIsRefused) {
    const TemporaryFolder folder;
    write_sounding_clip(folder / "long.wav", tone(100, 61));
    write_sounding_clip(folder / "silent.wav", std::vector<StereoSample>(4800));
    for (const char* name : {"long.wav", "silent.wav", "missing.wav"}) {
        const auto refused = SpokenSound::read(folder / name);
        ASSERT_FALSE(refused) << name;
        EXPECT_NE(refused.error().message.find(name), std::string::npos) << refused.error().message;
    }
}

}  // namespace
}  // namespace touchable::test
