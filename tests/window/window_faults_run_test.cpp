// SPDX-License-Identifier: Apache-2.0
// What a window leaves in the hand while something is opened that never answers: by order of events, which
// the test itself releases.

#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <future>
#include <iostream>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/base/threads.hpp"
#include "engine/picture/image.hpp"
#include "player/run/run_files.hpp"
#include "player/session/touch_setup.hpp"
#include "player/window/play_window.hpp"
#include "tests/gpu/gpu_fixture.hpp"
#include "tests/player/program.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/window_rig.hpp"

namespace touchable::test {
namespace {

using namespace std::chrono_literals;

/// A hand that goes into the globe and out again, over and over, by its ticks, in a window whose second clip
/// is never there.
class DevicePowerOff : public ::testing::Test {
protected:
    static constexpr std::int64_t there_and_back = 400;  // ticks

    void SetUp() override {
        make_clip(clip_, "globe", 60);
        fake_->motion = [](std::int64_t tick) {
            return glm::dvec3(0, 0, tick % there_and_back < there_and_back / 2 ? 0.12 : -0.04);
        };
    }
    /// The window, with forces on and the other clip asked for, led by a script.
    Result<PlayFigures> play(const std::string& script, double seconds) {
        PlayOptions options = headless_by_cpu(clip_);
        options.hand = std::make_shared<PersistentDevice>(fake_);
        options.session.late_playback = [this, openings = std::make_shared<int>(0)] {
            if ((*openings)++ > 0) wait_for_release();
            return std::vector<PlaybackCommand>();
        };
        options.make_screen = make_screen_;
        options.seconds = seconds;
        options.script = inputs_of("0.0 key f\n0.1 open " + clip_.string() + "\n" + script);
        return play_in_window(options);
    }
    void wait_for_release() {
        is_opening_ = true;
        while (!is_released_) std::this_thread::sleep_for(1ms);
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

TEST_F(DevicePowerOff, ClosesDuringOpening) {
    std::thread looks_on([this] { look_on(); });
    EXPECT_TRUE(play("2.5 quit\n", 60));
    looks_on.join();
    EXPECT_TRUE(felt_);
    EXPECT_TRUE(was_unpowered_) << "before what it opens was done";
    EXPECT_FALSE(came_back_) << "its button asked for a force without a window";
}

TEST_F(DevicePowerOff, StopsByFDuringOpening) {
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
        while (hold_.is_wanted) std::this_thread::sleep_for(1ms);
        return {hold_.key};
    }

private:
    Hold& hold_;
};

TEST_F(DevicePowerOff, StopsByFDuringStandstill) {
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
TEST_F(DevicePowerOff, StopsByInterruptDuringOpening) {
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

// A window whose GPU, display or clip is lost.

class LostWindow : public ::testing::Test {
protected:
    void SetUp() override {
        options_.session.clip.file = folder_ / "globe.mkv";
        make_clip(options_.session.clip.file, "globe", 40, "160x120");
        options_.session.builder.name = "cpu";
        options_.gpu = gpu_;
        options_.headless = true;
        options_.screen = {320, 200, false};
        options_.record = folder_ / "hand.touch";
        options_.painter = "raster";
        options_.seconds = 1.2;
        options_.screenshot = folder_ / "shot.png";
        options_.script = {{0.1, WindowCommand{WindowVerb::screenshot, 0, first_picture().string()}}};
    }
    std::filesystem::path first_picture() const { return folder_ / "first.png"; }
    /// Loses something once the window shows pictures, and plays to the end.
    Result<PlayFigures> play(const std::function<void()>& lose) {
        auto loss = std::async(std::launch::async, [&] {
            while (!has_ended_ && !std::filesystem::exists(first_picture()))
                std::this_thread::sleep_for(10ms);
            lose();
        });
        auto played = play_in_window(options_);
        has_ended_ = true;
        loss.get();
        return played;
    }
    std::shared_ptr<GpuDevice> device() { return *gpu_->open(); }
    /// The time of the last tick in the recording.
    double last_tick_s() const {
        const auto recording = read_recording(folder_ / "hand.touch");
        if (!recording || recording->empty() || recording->back().ticks.empty()) return 0;
        return 1e-9 * static_cast<double>(recording->back().ticks.back().time_ns);
    }

    const TemporaryFolder folder_;
    const std::shared_ptr<RunGpu> gpu_ = std::make_shared<RunGpu>("auto");
    PlayOptions options_;
    std::atomic<bool> has_ended_{false};
};

TEST_F(LostWindow, ReopensLostGpu) {
    const auto first = device();
    const auto played = play([&] { first->lose(); });
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_EQ(played->painter, "raster");
    EXPECT_GT(last_tick_s(), 1.1);
    const auto shot = read_image(folder_ / "shot.png");
    ASSERT_TRUE(shot) << shot.error().message;
    EXPECT_EQ(shot->width, 320);
}

TEST_F(LostWindow, AbandonsHungGpu) {
    std::optional<Blockade> blockade;
    const auto first = device();
    const auto played = play([&] {
        first->set_patience(50ms);
        blockade.emplace(*first);
    });
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_TRUE(first->lost());
    EXPECT_TRUE(read_image(folder_ / "shot.png"));
    EXPECT_GT(last_tick_s(), 1.1);
}

TEST_F(LostWindow, EndsAfterRepeatedGpuLoss) {
    options_.seconds = 9;
    const auto played = play([&] {
        // It is opened anew by the first thread that needs it, and lost before or after the window has drawn
        // on it.
        for (; !has_ended_; std::this_thread::sleep_for(100ms)) device()->lose();
    });
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().kind, ErrorKind::gpu);
    EXPECT_GT(last_tick_s(), 0);
}

TEST_F(LostWindow, KeepsSurfaceOfBrokenClip) {
    options_.session.playback = {{0, PlaybackVerb::loop, 0, 1'300'000'000}};
    options_.painter = "cpu";
    const auto played = play([&] { std::filesystem::resize_file(options_.session.clip.file, 20'000); });
    // It ran to its end, with the hand, and then says what was wrong.
    ASSERT_FALSE(played);
    EXPECT_EQ(played.error().kind, ErrorKind::input) << played.error().message;
    EXPECT_TRUE(contains(played.error().message, "globe.mkv"));
    EXPECT_GT(last_tick_s(), 1.1);
    EXPECT_TRUE(read_image(folder_ / "shot.png"));
}

TEST_F(LostWindow, KioskReopensRestoredClip) {
    const auto file = options_.session.clip.file, aside = folder_ / "aside.mkv";
    std::filesystem::copy(file, aside);
    options_.record.reset();
    options_.painter = "cpu";
    options_.kiosk = PlayOptions::Kiosk{.times = {60, 0.3}};
    options_.seconds = 2.6;
    const auto early = folder_ / "early.png", late = folder_ / "late.png";
    options_.script.push_back({2.3, WindowCommand{WindowVerb::screenshot, 0, early.string()}});
    options_.script.push_back({2.45, WindowCommand{WindowVerb::screenshot, 0, late.string()}});
    const auto played = play([&] {
        std::filesystem::resize_file(file, 20'000);
        std::this_thread::sleep_for(800ms);
        std::filesystem::copy(aside, file, std::filesystem::copy_options::overwrite_existing);
    });
    EXPECT_TRUE(played) << "a fault that is over: " << played.error().message;
    const auto first = read_image(early), second = read_image(late);
    ASSERT_TRUE(first && second);
    EXPECT_TRUE(first->samples != second->samples) << "it stands still";
}

/// A display that is gone once `is_gone` is set.
class VanishingScreen final : public WrappedScreen {
public:
    VanishingScreen(const ScreenOptions& options, const std::atomic<bool>& is_gone)
        : WrappedScreen(options), is_gone_(is_gone) {}
    Result<void> health() const override {
        if (!is_gone_) return {};
        return Error{ErrorKind::gpu, "the display that the window was on has gone away"};
    }

private:
    const std::atomic<bool>& is_gone_;
};

TEST_F(LostWindow, LostDisplayDecidesExitCode) {
    for (const bool is_kiosk : {true, false}) {
        const auto file = options_.session.clip.file, aside = folder_ / "aside.mkv";
        std::filesystem::copy(file, aside, std::filesystem::copy_options::overwrite_existing);
        options_.record.reset();
        options_.screenshot.reset();
        options_.existing = Existing::replace;
        std::filesystem::remove(first_picture());
        has_ended_ = false;
        options_.session.playback = {{0, PlaybackVerb::loop, 0, 1'300'000'000}};
        options_.painter = "cpu";
        if (is_kiosk) options_.kiosk = PlayOptions::Kiosk{.times = {60, 0.3}};
        if (!is_kiosk) options_.kiosk.reset();
        options_.seconds = 60;
        std::atomic<bool> is_gone{false};
        options_.make_screen = [&is_gone](const ScreenOptions& size) {
            return std::make_unique<VanishingScreen>(size, is_gone);
        };
        const auto played = play([&] {
            std::filesystem::resize_file(file, 20'000);
            std::this_thread::sleep_for(3s);  // the clip is read to there at once
            is_gone = true;
        });
        std::filesystem::copy(aside, file, std::filesystem::copy_options::overwrite_existing);
        ASSERT_FALSE(played);
        EXPECT_EQ(played.error().kind, ErrorKind::gpu) << is_kiosk << ": " << played.error().message;
    }
}

TEST_F(LostWindow, ReportsEarlierBrokenClip) {
    const std::string other = (folder_ / "other.mkv").string();
    make_clip(other, "globe", 3);
    options_.record.reset();
    options_.painter = "cpu";
    options_.script.push_back({0.9, WindowCommand{WindowVerb::open, 0, other}});
    const auto played = play([&] { std::filesystem::resize_file(options_.session.clip.file, 20'000); });
    ASSERT_FALSE(played);
    EXPECT_TRUE(contains(played.error().message, "globe.mkv"));
}

// A machine that is suspended while a finger presses.

/// A machine that sleeps for an hour once the script sets the window's size.
class SleepyScreen final : public WrappedScreen {
public:
    using WrappedScreen::WrappedScreen;
    void set_size(int, int) override { WindowClock::suspend(1h); }
};

/// Newtons on the first finger at the end, and the most there were, of these inputs; `sleeps`: the machine
/// does meanwhile.
std::pair<double, double> felt(const std::vector<ScriptedInput>& press, bool sleeps) {
    const TemporaryFolder folder;
    PlayOptions options = headless_by_cpu(made_clip("globe", 1));
    options.make_screen = [](const ScreenOptions& size) { return std::make_unique<SleepyScreen>(size); };
    options.record = folder / "hand.touch";
    options.script = press;
    if (sleeps) options.script.push_back({1, WindowCommand{.verb = WindowVerb::size}});
    options.seconds = 1.8;
    const auto played = play_in_window(options);
    EXPECT_TRUE(played) << played.error().message;
    const auto recording = read_recording(folder / "hand.touch");
    EXPECT_TRUE(recording);
    double most = 0, last = -1;
    if (recording)
        for (const auto& tick : recording->back().ticks)
            most = std::max(most, last = glm::length(tick.forces[0]));
    return {last, most};
}

TEST(SuspendedMachine, LiftsFingersAndButtons) {
    using Kind = InputEvent::Kind;
    const std::vector<ScriptedInput> finger{
        {0.1, InputEvent{.kind = Kind::touch_began, .x = 160, .y = 100, .touch = 1, .seconds = 0.1}},
        {1.2, InputEvent{.kind = Kind::touch_moved, .x = 161, .y = 100, .touch = 1, .seconds = 1.2}}};
    const std::vector<ScriptedInput> mouse{{0.1, InputEvent{.x = 160, .y = 100}},
                                           {0.1, InputEvent{.kind = Kind::pressed, .word = "left"}}};
    for (const auto* press : {&finger, &mouse}) {
        EXPECT_GT(felt(*press, false).first, 0.05);
        const auto [last, most] = felt(*press, true);
        EXPECT_GT(most, 0.05) << "nothing was pressed";
        EXPECT_EQ(last, 0);
    }
}

// A kiosk under siege: minutes of any keys, touches, clicks, drops, resizes and lost focus, by a clock that
// the test puts forward. The next visitor finds it as on its first day.

using namespace std::chrono_literals;
using Kind = InputEvent::Kind;

constexpr ScreenSize usual_size{320, 240, 1};
constexpr double quiet_s = 150;  // then; a held button still counts as a visitor for a minute

/// Minutes of it; TOUCHABLE_SIEGE_MINUTES says another number of them, 10 in the long run of the tests.
double minutes_of_siege() {
    const char* const asked = std::getenv("TOUCHABLE_SIEGE_MINUTES");
    return asked ? std::atof(asked) : 1;
}

/// For each seed always the same.
class Besiegers {
public:
    Besiegers(double minutes, unsigned seed) : random_(seed), end_s_(60 * minutes) {}

    bool are_gone() const { return now_s_ >= end_s_; }
    const ScreenSize& size() const { return size_; }
    std::int64_t inputs() const { return inputs_; }
    /// How long nothing happens, seconds: what a script's clock counts, or more.
    double pause() {
        const double pause = 0.1 + 0.001 * below(300);
        now_s_ += pause;
        return pause;
    }
    std::vector<InputEvent> inputs_after_pause() {
        std::vector<InputEvent> events;
        for (int k = below(5); k >= 0; --k) events.push_back(something());
        inputs_ += static_cast<std::int64_t>(events.size());
        return events;
    }

private:
    int below(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }
    Kind one_of(const std::vector<Kind>& kinds) {
        return kinds[static_cast<std::size_t>(below(static_cast<int>(kinds.size())))];
    }

    InputEvent something() {
        InputEvent event{.x = static_cast<double>(below(size_.width)),
                         .y = static_cast<double>(below(size_.height)),
                         .control = below(4) == 0,
                         .shift = below(4) == 0};
        const int what = below(20);
        if (what < 4) return event;  // moved
        if (what < 9) {              // mostly the button that buttons take
            event.kind = one_of({Kind::pressed, Kind::released});
            event.word =
                std::vector{"left", "left", "left", "right", "middle"}[static_cast<std::size_t>(below(5))];
        } else if (what < 14) {
            event.kind = one_of({Kind::touch_began, Kind::touch_moved, Kind::touch_ended});
            event.touch = 1 + below(6);  // one more than there are fingers
            event.seconds = now_s_;
        } else if (what < 17) {
            event.kind = one_of({Kind::key, Kind::key, Kind::key_released});
            event.word = key();
            event.repeated = below(5) == 0;
        } else if (what < 18) {
            event.kind = Kind::wheel;
            event.y = below(9) - 4;
        } else if (what < 19) {
            event.kind = one_of({Kind::left_window, Kind::close, Kind::dropped});
            event.word = "nowhere.mkv";
        } else {
            size_ = {160 + below(300), 120 + below(240), 1};
            event = {.kind = Kind::resized};
        }
        return event;
    }
    std::string key() {
        static const std::vector<std::string> others{
            "space",  "left",   "right",    "up",  "down", "home", "end", "tab", "escape", "enter", "f1",
            "delete", "pageup", "pagedown", "f11", "f12",  "?",    "+",   "-",   ",",      ".",     "["};
        if (below(2) == 0) return others[static_cast<std::size_t>(below(static_cast<int>(others.size())))];
        return std::string(1, "abcdefghijklmnopqrstuvwxyz0123456789"[below(36)]);
    }

    std::minstd_rand random_;
    double now_s_ = 0, end_s_;
    ScreenSize size_ = usual_size;
    std::int64_t inputs_ = 0;
};

/// Their screen; once they are gone it has its usual size again, and goes on.
class BesiegedScreen final : public PublicScreen {
public:
    BesiegedScreen(Besiegers& besiegers, TouchMeter& meter) : besiegers_(besiegers), meter_(meter) {}

    ScreenSize size() const override { return besiegers_.are_gone() ? usual_size : besiegers_.size(); }
    std::vector<InputEvent> next_events() override {
        if (!besiegers_.are_gone()) {
            put_forward(besiegers_.pause());
            return besiegers_.inputs_after_pause();
        }
        // Fingers, and clips that are opened, go by their own time.
        std::this_thread::sleep_for(++quiet_ < 60 ? 5ms : (quiet_ < quiet_s - 20 ? 20ms : 50ms));
        put_forward(1);
        return {};
    }
    /// By the script alone: once the window shows pictures, and once the finger rests.
    void set_size(int, int) override {
        if (is_open_) meter_.begin(StudyForce::on);
        is_open_ = true;
    }

private:
    Besiegers& besiegers_;
    TouchMeter& meter_;
    int quiet_ = 0;
};

/// The window as the next visitor finds it.
struct Found {
    Image picture;       ///< before he touches
    double newtons = 0;  ///< that he feels once the finger rests
    std::int64_t inputs = 0;
};

class KioskSiege : public ::testing::Test {
protected:
    void SetUp() override {
        // A clip goes by its own time: the first is so long that it is still there when he comes.
        make_clip(clip("globe"), "globe", 900);
        make_clip(clip("bumps"), "bumps", 30);
        options_.session.clip.file = clip("globe");
        options_.next_clips.emplace_back().file = clip("bumps");
        options_.session.builder.name = "cpu";
        options_.headless = true;
        options_.kiosk = PlayOptions::Kiosk{};
    }
    std::filesystem::path clip(const std::string& name) const { return folder_ / (name + ".mkv"); }

    /// He comes by a key, and looks at a moment of the clip, so that it is always the same; then he presses a
    /// finger in the middle.
    Found found_after(double minutes, unsigned seed) {
        int turns = 0;
        Besiegers counted(minutes, seed);
        for (; !counted.are_gone(); ++turns) {
            (void)counted.pause();
            (void)counted.inputs_after_pause();
        }
        Besiegers besiegers(minutes, seed);
        options_.meter = std::make_shared<TouchMeter>();
        options_.make_screen = [&](const ScreenOptions&) -> std::unique_ptr<Screen> {
            return std::make_unique<BesiegedScreen>(besiegers, *options_.meter);
        };
        const double next_s = 0.1 * (turns + quiet_s);  // of a script
        const auto shot = folder_ / (std::to_string(shots_++) + ".png");
        const InputEvent some_key{.kind = Kind::key, .word = "end"},  // that does nothing
            to_middle{.kind = Kind::moved, .x = 160, .y = 90};
        options_.script = {{0, WindowCommand{.verb = WindowVerb::size}},
                           {next_s, InputEvent{.kind = Kind::left_window}},
                           {next_s, some_key},
                           {next_s, WindowCommand{WindowVerb::step, -1}},  // which pauses
                           {next_s, WindowCommand{WindowVerb::seek_to, 0.3}},
                           {next_s + 1.5, some_key},
                           {next_s + 3, WindowCommand{WindowVerb::screenshot, 0, shot.string()}},
                           {next_s + 3, to_middle},
                           {next_s + 4.5, InputEvent{.kind = Kind::pressed, .word = "left"}},
                           {next_s + 6, to_middle},
                           {next_s + 6, WindowCommand{.verb = WindowVerb::size}},  // what is felt counts
                           {next_s + 7.5, WindowCommand{WindowVerb::quit}}};
        for (const WindowCommand& command : left_)
            options_.script.insert(options_.script.begin() + 1, {next_s, command});
        const auto played = play_in_window(options_);
        EXPECT_TRUE(played) << played.error().message;
        const auto picture = read_image(shot);
        EXPECT_TRUE(picture);
        return {picture ? *picture : Image{}, options_.meter->measures().mean_newtons, besiegers.inputs()};
    }

    const TemporaryFolder folder_;
    PlayOptions options_;
    std::vector<WindowCommand> left_;  // as by a visitor
    int shots_ = 0;
};

/// How many pixels differ by anything; -1: the pictures have two sizes.
int unequal_pixels(const Image& a, const Image& b) {
    return differences(a, b, {0, 0, a.width, a.height}, 0);
}

TEST_F(KioskSiege, LeavesNothingToNextVisitor) {
    const Found fresh = found_after(0, 1);
    EXPECT_GT(fresh.newtons, 0.2) << "the surface is not felt";
    const double minutes = minutes_of_siege();
    const unsigned seeds = minutes > 1 ? 2 : 1;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        const Found last = found_after(minutes / seeds, seed);
        const int differing = unequal_pixels(fresh.picture, last.picture);
        EXPECT_EQ(differing, 0) << "seed " << seed;
        EXPECT_NEAR(last.newtons, fresh.newtons, 0.02 * fresh.newtons) << "seed " << seed;
        std::cout << "seed " << seed << ": " << last.inputs << " inputs in " << minutes / seeds
                  << " min; pixels that differ: " << differing << "; " << last.newtons << " N, at first "
                  << fresh.newtons << " N\n";
    }
}

/// Otherwise the test above would see nothing.
TEST_F(KioskSiege, DetectsLeftovers) {
    const Found fresh = found_after(0, 1);
    left_ = {WindowCommand{.verb = WindowVerb::overlay, .word = "depth"},
             WindowCommand{.verb = WindowVerb::feel, .word = "max-force 1"}};
    const Found last = found_after(0, 1);
    EXPECT_GT(unequal_pixels(fresh.picture, last.picture), 1000);
    EXPECT_LT(last.newtons, 0.9 * fresh.newtons);
}

}  // namespace
}  // namespace touchable::test
