// A kiosk under siege: minutes of any keys, touches, clicks, drops, windows of other sizes and windows that
// nobody looks at, by a clock that the test puts forward. Who comes next finds it as on its first day.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <random>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "engine/picture/image.hpp"
#include "player/window/play_window.hpp"
#include "player/window/window_clock.hpp"
#include "tests/player/program.hpp"

namespace touchable::test {
namespace {

using namespace std::chrono_literals;
using Kind = InputEvent::Kind;

constexpr ScreenSize usual_size{320, 240, 1};
constexpr double nobody_s = 150;  // then; who holds something still counts for a minute

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
            event = {.kind = Kind::resized,
                     .x = static_cast<double>(size_.width),
                     .y = static_cast<double>(size_.height)};
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
class BesiegedScreen final : public Screen {
public:
    BesiegedScreen(Besiegers& besiegers, TouchMeter& meter) : besiegers_(besiegers), meter_(meter) {}

    std::vector<std::string> extensions() const override { return {}; }
    Result<void> attach(std::shared_ptr<GpuDevice>) override { return {}; }
    Result<void> health() const override { return {}; }
    ScreenSize size() const override { return besiegers_.are_gone() ? usual_size : besiegers_.size(); }
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        if (!is_open_) {
            std::this_thread::sleep_for(longest);
            return {};
        }
        if (!besiegers_.are_gone()) {
            put_forward(besiegers_.pause());
            return besiegers_.inputs_after_pause();
        }
        // Fingers, and clips that are opened, go by their own time.
        std::this_thread::sleep_for(++quiet_ < 60 ? 5ms : (quiet_ < nobody_s - 20 ? 20ms : 50ms));
        put_forward(1);
        return {};
    }
    Result<void> present(GpuCommands commands, const GpuImage&) override { return std::move(commands).run(); }
    std::string touch_state() const override { return ""; }
    void set_title(const std::string&) override {}
    void set_fullscreen(bool) override { ADD_FAILURE() << "a visitor has left full screen"; }
    /// By the script alone: once the window shows pictures, and once the finger rests.
    void set_size(int, int) override {
        if (is_open_) meter_.begin(StudyForce::on);
        is_open_ = true;
    }
    void hide_pointer(bool) override {}

private:
    static void put_forward(double seconds) {
        WindowClock::put_forward(
            std::chrono::duration_cast<WindowClock::duration>(std::chrono::duration<double>(seconds)));
    }

    Besiegers& besiegers_;
    TouchMeter& meter_;
    bool is_open_ = false;
    int quiet_ = 0;
};

/// What the visitor finds who comes then.
struct Found {
    Image picture;       ///< before he touches
    double newtons = 0;  ///< that he feels once the finger rests
    std::int64_t inputs = 0;
};

class KioskSiege : public ::testing::Test {
protected:
    void SetUp() override {
        // A clip goes by its own time: the first is so long that it is still there when he comes.
        for (const auto& [scene, frames] : {std::pair{"globe", "900"}, {"bumps", "30"}})
            ASSERT_EQ(
                run_touchable({"make", scene, clip(scene).string(), "--size", "64x48", "--frames", frames})
                    .code,
                0);
        options_.session.clip.file = clip("globe");
        options_.next_clips.resize(1);
        options_.next_clips[0].file = clip("bumps");
        options_.session.builder.name = "cpu";
        options_.headless = true;
        options_.kiosk = KioskOptions{};
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
        const double next_s = 0.1 * (turns + nobody_s);  // of a script
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

/// Where pictures differ, and how many pixels do.
struct Difference {
    std::int64_t pixels = -1;  // they are not of the same size
    int x = 0, y = 0;          // the first
};
Difference difference(const Image& a, const Image& b) {
    if (a.width != b.width || a.height != b.height || a.samples.size() != b.samples.size()) return {};
    Difference found{.pixels = 0};
    for (int y = a.height - 1; y >= 0; --y)
        for (int x = a.width - 1; x >= 0; --x) {
            const auto at = static_cast<std::ptrdiff_t>(3 * (y * a.width + x));
            const auto pixel = a.samples.begin() + at;
            if (std::equal(pixel, pixel + 3, b.samples.begin() + at)) continue;
            found = {found.pixels + 1, x, y};
        }
    return found;
}

TEST_F(KioskSiege, LeavesNothingToTheNextVisitor) {
    const Found fresh = found_after(0, 1);
    EXPECT_GT(fresh.newtons, 0.2) << "nobody feels the surface";
    const double minutes = minutes_of_siege();
    const unsigned seeds = minutes > 1 ? 2 : 1;
    for (unsigned seed = 1; seed <= seeds; ++seed) {
        const Found last = found_after(minutes / seeds, seed);
        const Difference differing = difference(fresh.picture, last.picture);
        EXPECT_EQ(differing.pixels, 0) << "seed " << seed << ", at " << differing.x << ", " << differing.y;
        EXPECT_NEAR(last.newtons, fresh.newtons, 0.02 * fresh.newtons) << "seed " << seed;
        std::cout << "seed " << seed << ": " << last.inputs << " inputs in " << minutes / seeds
                  << " min; pixels that differ: " << differing.pixels << "; " << last.newtons
                  << " N, at first " << fresh.newtons << " N\n";
    }
}

/// Otherwise the test above would see nothing.
TEST_F(KioskSiege, WouldSeeWhatAVisitorLeaves) {
    const Found fresh = found_after(0, 1);
    left_ = {WindowCommand{.verb = WindowVerb::overlay, .word = "depth"},
             WindowCommand{.verb = WindowVerb::feel, .word = "max-force 1"}};
    const Found last = found_after(0, 1);
    EXPECT_GT(difference(fresh.picture, last.picture).pixels, 1000);
    EXPECT_LT(last.newtons, 0.9 * fresh.newtons);
}

}  // namespace
}  // namespace touchable::test
