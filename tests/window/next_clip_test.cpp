// Pressed while the next clip is being opened: pause, which means the clip that comes.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "player/window/play_window.hpp"
#include "tests/player/program.hpp"
#include "tests/window/scripted_window.hpp"

namespace touchable::test {
namespace {

/// The second of two clips, a globe that turns, is opened only once there is a picture of 1.5 s, so that
/// earlier keys come while it is being opened.
class NextClip : public ::testing::Test {
protected:
    void SetUp() override {
        // 30 s, in which any machine has taken the last picture: at a clip's end the button says play.
        for (const auto& [scene, clip] : {std::pair("bumps", first_), {"globe", second_}}) {
            const auto made = run_touchable(
                {"make", scene, clip.string(), "--size", "160x120", "--frames", "120", "--rate", "4"});
            ASSERT_EQ(made.code, 0) << made.err;
        }
    }
    struct Seen {
        Image before, first, later;  ///< the clip that was there; the one that came, and again
    };
    /// What is seen where so is done meanwhile.
    Seen seen(const std::string& script) {
        PlayOptions options;
        options.session.builder.name = "cpu";
        options.session.clip.file = first_;
        options.next_clips.emplace_back().file = second_;
        const std::string taken = picture("taken");
        std::filesystem::remove(taken);
        options.session.late_playback = [taken, openings = std::make_shared<int>(0)] {
            if ((*openings)++ == 1)
                for (int k = 0; k < 60'000 && !std::filesystem::exists(taken); ++k)
                    std::this_thread::sleep_for(std::chrono::milliseconds(1));
            return std::vector<PlaybackCommand>();
        };
        options.painter = "cpu";
        options.headless = true;
        options.existing = Existing::replace;
        options.screen.width = 320;
        options.screen.height = 240;
        options.kiosk = kiosk_;
        std::ofstream(folder_ / "script")
            << script << "1.5 screenshot " << taken << "\n3.5 screenshot " << picture("first")
            << "\n4.0 screenshot " << picture("later") << "\n4.1 quit\n";
        auto inputs = read_window_script(folder_ / "script");
        EXPECT_TRUE(inputs);
        options.script = std::move(*inputs);
        const auto played = play_in_window(options);
        EXPECT_TRUE(played) << played.error().message;
        return {image("before"), image("first"), image("later")};
    }
    std::string picture(const std::string& name) const { return (folder_ / name).string() + ".png"; }
    Image image(const std::string& name) const {
        auto read = read_image(picture(name));
        if (!read) return {};
        return std::move(*read);
    }
    static constexpr PicturePart middle{60, 40, 260, 180};
    const TemporaryFolder folder_;
    std::filesystem::path first_ = folder_ / "bumps.mkv", second_ = folder_ / "globe.mkv";
    std::optional<KioskOptions> kiosk_;
};

TEST_F(NextClip, ComesPausedWhereItIsPausedMeanwhile) {
    const Seen paused = seen("0.3 next\n0.6 key space\n0.9 screenshot " + picture("before") + "\n");
    EXPECT_GT(differences(paused.before, paused.first, middle), 3000) << "no other clip came";
    EXPECT_EQ(differences(paused.first, paused.later, middle), 0);
}

TEST_F(NextClip, PlaysWhereNobodyOrSomebodyTwicePressesPause) {
    for (const char* const script :
         {"0.3 next\n", "0.3 next\n0.6 key space\n0.9 key space\n", "0.2 key space\n0.3 next\n",
          "0.2 key space\n0.3 next\n0.6 key space\n", "0.1 seek 29.9\n1.4 key space\n"}) {
        const Seen playing = seen(script);
        EXPECT_GT(differences(image("taken"), playing.first, middle), 3000)
            << script << "brought no other clip";
        EXPECT_GT(differences(playing.first, playing.later, middle), 500) << script;
    }
}

TEST_F(NextClip, PlaysForTheNextVisitorOfAKioskWhoComesMeanwhile) {
    std::swap(first_, second_);
    kiosk_.emplace().times = {.invite_s = 20, .reset_s = 0.8};
    const Seen playing = seen("0.2 next\n0.3 next\n0.5 key space\n");
    EXPECT_GT(differences(playing.first, playing.later, middle), 500);
}

}  // namespace
}  // namespace touchable::test
