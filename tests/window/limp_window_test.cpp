// What a window leaves in the hand while something is opened that never answers: by order of events, which
// the test itself releases.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <fstream>
#include <functional>
#include <memory>
#include <thread>

#include "engine/base/threads.hpp"
#include "player/window/play_window.hpp"
#include "tests/player/program.hpp"
#include "tests/window/fake_hand.hpp"
#include "tests/window/wrapped_screen.hpp"

namespace touchable::test {
namespace {

/// A hand that goes into the globe and out again, over and over, by its ticks, in a window whose second clip
/// is never there.
class UnpoweredWindow : public ::testing::Test {
protected:
    static constexpr std::int64_t there_and_back = 400;  // ticks

    void SetUp() override {
        ASSERT_EQ(run_touchable({"make", "globe", clip_.string(), "--size", "64x48", "--frames", "60"}).code,
                  0);
        fake_->motion = [](std::int64_t tick) {
            return glm::dvec3(0, 0, tick % there_and_back < there_and_back / 2 ? 0.12 : -0.04);
        };
    }
    /// The window, with forces on and the other clip asked for, led by a script.
    Result<PlayFigures> play(const std::string& script, double seconds) {
        PlayOptions options;
        options.hand = std::make_shared<PersistentDevice>(fake_);
        options.session.builder.name = "cpu";
        options.session.clip.file = clip_;
        options.session.late_playback = [this, openings = std::make_shared<int>(0)] {
            if ((*openings)++ > 0) wait_for_release();
            return std::vector<PlaybackCommand>();
        };
        options.painter = "cpu";
        options.headless = true;
        options.make_screen = make_screen_;
        options.screen.width = 320;
        options.screen.height = 240;
        options.seconds = seconds;
        std::ofstream(folder_ / "script") << "0.0 key f\n0.1 open " + clip_.string() + "\n" + script;
        auto inputs = read_window_script(folder_ / "script");
        EXPECT_TRUE(inputs);
        options.script = std::move(*inputs);
        return play_in_window(options);
    }
    void wait_for_release() {
        is_opening_ = true;
        while (!is_released_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    /// Whether it came to be, in far longer than any machine takes.
    static bool comes_true(const std::function<bool()>& what) {
        for (int k = 0; k < 20'000 && !what(); ++k) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return what();
    }
    /// Waits for so many ticks without `what`, or, of a session that has ended, for a while without any.
    /// False: it never comes to that.
    bool goes_on(std::int64_t ticks, const std::function<bool()>& what) {
        std::int64_t since = fake_->reads, newest = since;
        int still = 0;
        return comes_true([&] {
            const std::int64_t now = fake_->reads;
            still = now == newest ? still + 1 : 0;
            newest = now;
            if (what()) {
                since = now;
                still = 0;
            }
            return now > since + ticks || still > 1000;
        });
    }
    /// Looks at the hand, asks for forces again, and releases the clip.
    void look_on(const std::function<void()>& end = [] {}) {
        const auto is_felt = [this] { return fake_->newtons > 0.1; };
        felt_ = comes_true([&] { return is_opening_ && is_felt(); });
        end();
        was_unpowered_ = goes_on(2 * there_and_back, [this] { return fake_->newtons > 0; });
        fake_->pressed = 0;
        goes_on(20, [] { return false; });
        fake_->pressed = 1;
        goes_on(4 * there_and_back, [&] {
            came_back_ = came_back_ || is_felt();
            return false;
        });
        is_released_ = true;
    }

    const TemporaryFolder folder_;
    const std::filesystem::path clip_ = folder_ / "globe.mkv";
    const std::shared_ptr<FakeHand> fake_ = std::make_shared<FakeHand>();
    std::function<std::unique_ptr<Screen>(const ScreenOptions&)> make_screen_;
    std::atomic<bool> is_opening_{false}, is_released_{false};
    bool felt_ = false, was_unpowered_ = false, came_back_ = false;
};

TEST_F(UnpoweredWindow, WhenItIsClosedWhateverIsOpenedMeanwhile) {
    std::thread looks_on([this] { look_on(); });
    EXPECT_TRUE(play("2.5 quit\n", 60));
    looks_on.join();
    EXPECT_TRUE(felt_);
    EXPECT_TRUE(was_unpowered_) << "before what it opens was done";
    EXPECT_FALSE(came_back_) << "its button asked for a force that nobody sees";
}

TEST_F(UnpoweredWindow, AfterFWhateverIsOpenedMeanwhile) {
    std::thread looks_on([this] { look_on(); });
    EXPECT_TRUE(play("2.5 key f\n", 8));
    looks_on.join();
    EXPECT_TRUE(felt_);
    EXPECT_TRUE(was_unpowered_);
    EXPECT_TRUE(came_back_) << "it was not F, but the window's end";
    EXPECT_EQ(fake_->newtons, 0) << "in the end";
}

/// A screen whose main thread stands still for as long as a test likes, as over a picture that takes long.
class StandingScreen final : public WrappedScreen {
public:
    struct Hold {
        std::atomic<bool> is_wanted{false}, is_standing{false};
        std::function<void(InputEvent&)> at_once;  // known once it stands
        InputEvent key{.kind = InputEvent::Kind::key, .word = "f"};
    };
    StandingScreen(const ScreenOptions& options, Hold& hold) : WrappedScreen(options), hold_(hold) {
        hold_.at_once = options.at_once;
    }
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        if (!hold_.is_wanted) return WrappedScreen::poll(longest);
        hold_.is_standing = true;
        while (hold_.is_wanted) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return {hold_.key};
    }

private:
    Hold& hold_;
};

TEST_F(UnpoweredWindow, StopsByFWhileMainThreadStands) {
    StandingScreen::Hold hold;
    make_screen_ = [&](const ScreenOptions& options) {
        return std::make_unique<StandingScreen>(options, hold);
    };
    bool has_felt = false, is_off = false, stays_off = false;
    std::thread looks_on([&] {
        has_felt = comes_true([&] { return fake_->newtons > 0.1; });
        hold.is_wanted = true;
        if (comes_true([&] { return hold.is_standing.load(); })) hold.at_once(hold.key);
        is_off = goes_on(2 * there_and_back, [&] { return fake_->newtons > 0; });
        hold.is_wanted = false;
        stays_off = goes_on(2 * there_and_back, [&] { return fake_->newtons > 0; });
        is_released_ = true;
    });
    EXPECT_TRUE(play("20 quit\n", 8));
    looks_on.join();
    EXPECT_TRUE(has_felt);
    EXPECT_TRUE(hold.key.stopped_force);
    EXPECT_TRUE(is_off) << "before the main thread goes on";
    EXPECT_TRUE(stays_off) << "the main thread has it as a key that asks for forces";
}

/// (In a process of its own: it is asked to stop once and for all.)
TEST_F(UnpoweredWindow, AtCtrlCWhateverIsOpenedMeanwhile) {
    GTEST_FLAG_SET(death_test_style, "threadsafe");
    const auto is_as_it_should_be = [this] {
        std::signal(SIGINT, [](int) { request_stop(); });
        std::thread looks_on([this] { look_on([] { std::raise(SIGINT); }); });
        const auto played = play("", 60);
        looks_on.join();
        return felt_ && was_unpowered_ && !came_back_ && !played &&
               played.error().kind == ErrorKind::interrupted;
    };
    EXPECT_EXIT(_exit(is_as_it_should_be() ? 0 : 1), testing::ExitedWithCode(0), "");
}

}  // namespace
}  // namespace touchable::test
