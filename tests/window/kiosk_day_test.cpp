// A day of a kiosk with visitors who press and touch whatever there is, by a clock that the test puts
// forward.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "engine/picture/image.hpp"
#include "player/window/play_window.hpp"
#include "player/window/window_clock.hpp"
#include "tests/player/program.hpp"
#include "tests/sanitizers.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

using namespace std::chrono_literals;

constexpr KioskTimes times{20, 60};
constexpr int public_width = 240, public_height = 180;
constexpr double bar_top = 104;  // of the kiosk's bar, where a press holds nothing
const InputEvent to_the_middle{.kind = InputEvent::Kind::moved, .x = 122, .y = 76};

/// Hours of it; TOUCHABLE_KIOSK_HOURS says another number of them, 24 in the long run of the tests.
double hours_of_visitors() {
    const char* const asked = std::getenv("TOUCHABLE_KIOSK_HOURS");
    return asked ? std::atof(asked) : 1;
}

/// What the next turn of the window brings: time, and what somebody does at its end.
struct Turn {
    double seconds = 0;
    std::vector<InputEvent> events{};
};

/// What a visitor presses, with a mouse and with fingers.
class Held {
public:
    /// What begins below `lowest` in the picture is left out.
    void take(const InputEvent& event, double lowest = public_height) {
        using Kind = InputEvent::Kind;
        if (event.kind == Kind::pressed && event.y <= lowest) presses_ = true;
        if (event.kind == Kind::released || event.kind == Kind::left_window) presses_ = false;
        if (event.kind == Kind::touch_began && event.y <= lowest) touches_.insert(event.touch);
        if (event.kind == Kind::touch_ended) touches_.erase(event.touch);
        if (event.kind == Kind::left_window) touches_.clear();
    }
    bool anything() const { return presses_ || !touches_.empty(); }

private:
    bool presses_ = false;
    std::set<std::int64_t> touches_;
};

/// Visitors who come and go, for each seed always the same ones.
class Visitors {
public:
    explicit Visitors(double hours) : end_s_(3600 * hours) {}
    /// One who never rests for so many hours.
    static Visitors restless(double hours, unsigned seed) {
        Visitors visitors(hours);
        visitors.random_.seed(seed);
        visitors.leaves_s_ = visitors.end_s_;
        return visitors;
    }

    bool are_gone() const { return now_s_ >= end_s_; }
    int count() const { return count_; }
    double seconds() const { return seconds_; }

    /// Steps are a tenth of a second at least, of which a script's clock counts a tenth.
    Turn next() {
        if (now_s_ >= leaves_s_) return wait();
        Turn turn{0.1 + 0.001 * below(2900), {}};
        now_s_ += turn.seconds;
        for (int k = below(4); k >= 0; --k) turn.events.push_back(something());
        const bool is_seen = std::ranges::any_of(
            turn.events, [](const InputEvent& event) { return is_for_visitors(event) && is_a_visit(event); });
        for (const InputEvent& event : turn.events) {
            held_.take(event);
            held_above_bar_.take(event, bar_top);
        }
        if (!is_seen) return turn;
        if (!is_there_) {
            ++count_;
            came_s_ = now_s_;
            is_there_ = true;
        }
        last_s_ = now_s_;
        return turn;
    }

private:
    /// Nobody is there; a moment before the next one comes.
    Turn wait() {
        if (comes_s_ <= now_s_) {
            // Never near the times of the kiosk, as the machine's own time is added.
            const double pause = below(3) == 0 && !held_.anything() ? 24 + below(30) : 150 + below(200);
            comes_s_ = std::max(last_s_, now_s_ - 15) + pause;
        }
        Turn turn{std::min(1.0 + below(9), comes_s_ - now_s_ + 0.1), {}};
        now_s_ += turn.seconds;
        if (is_there_ && now_s_ - last_s_ > times.invite_s) leave();
        if (now_s_ >= comes_s_) leaves_s_ = now_s_ + 5 + below(60);
        return turn;
    }
    void leave() {
        is_there_ = false;
        seconds_ += last_s_ - came_s_ + (held_above_bar_.anything() ? times.reset_s : 0);
        held_ = held_above_bar_ = Held();
    }
    int below(int count) { return static_cast<int>(random_() % static_cast<unsigned>(count)); }

    InputEvent something() {
        using Kind = InputEvent::Kind;
        const std::string buttons[] = {"left", "right", "middle"};
        InputEvent event;
        event.control = below(4) == 0;
        event.shift = below(4) == 0;
        event.x = below(public_width);
        event.y = below(public_height);
        switch (below(16)) {
            case 0:
            case 1:
            case 2:
                return event;  // moved
            case 3:
            case 4:
                event.kind = Kind::pressed;
                event.word = buttons[below(3)];
                return event;
            case 5:
                event.kind = Kind::released;
                event.word = buttons[below(3)];
                return event;
            case 6:
                event.kind = Kind::wheel;
                event.y = below(9) - 4;
                return event;
            case 7:
                event.kind = std::vector{Kind::left_window, Kind::close,
                                         Kind::dropped}[static_cast<std::size_t>(below(3))];
                event.word = "nowhere.mkv";
                return event;
            case 8:
            case 9:
            case 10:
            case 11:
                event.kind = std::vector{Kind::touch_began, Kind::touch_moved,
                                         Kind::touch_ended}[static_cast<std::size_t>(below(3))];
                event.touch = 1 + below(6);  // one more than there are fingers
                event.seconds = now_s_;
                return event;
            default:
                event.kind = below(5) == 0 ? Kind::key_released : Kind::key;
                event.repeated = below(5) == 0;
                event.word = key();
                return event;
        }
    }
    std::string key() {
        static const std::vector<std::string> others{
            "space",     "left",   "right",  "up",       "down", "home", "end", "tab", "escape", "enter",
            "backspace", "delete", "pageup", "pagedown", "f1",   "f2",   "f5",  "f10", "f11",    "f12",
            "?",         "+",      "-",      "=",        ",",    ".",    "[",   "]"};
        if (below(2) == 0) return others[static_cast<std::size_t>(below(static_cast<int>(others.size())))];
        return std::string(1, "abcdefghijklmnopqrstuvwxyz0123456789"[below(36)]);
    }

    std::minstd_rand random_{37};
    double now_s_ = 0, end_s_;
    double comes_s_ = 0, leaves_s_ = 0;  // the next one; the one who is there
    bool is_there_ = false;
    Held held_, held_above_bar_;
    double came_s_ = 0, last_s_ = -100, seconds_ = 0;
    int count_ = 0;
};

/// Bytes of this process that are in memory.
double resident_mib() {
    std::ifstream in("/proc/self/statm");
    long pages = 0, resident = 0;
    in >> pages >> resident;
    return static_cast<double>(resident) * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

/// What the test knows of a day once it is over.
struct Day {
    double early_mib = 0, late_mib = 0;
};

/// A screen whose time is the visitors'. Once they are gone it goes on, with nobody there.
class PublicScreen final : public Screen {
public:
    PublicScreen(Visitors visitors, int turns, Day& day)
        : visitors_(std::move(visitors)), turns_(turns), day_(day) {}

    std::vector<std::string> extensions() const override { return {}; }
    Result<void> attach(std::shared_ptr<GpuDevice>) override { return {}; }
    Result<void> health() const override { return {}; }
    ScreenSize size() const override { return {public_width, public_height, 1}; }
    std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
        if (!is_open_) {
            std::this_thread::sleep_for(longest);
            return {};
        }
        if (visitors_.are_gone()) {
            day_.late_mib = std::max(day_.late_mib, resident_mib());
            std::this_thread::sleep_for(++quiet_ < 145 ? 5ms : 20ms);  // fingers go by their own time
            WindowClock::put_forward(1s);
            return {};
        }
        if (++turn_ == turns_ / 4) day_.early_mib = resident_mib();
        const Turn turn = visitors_.next();
        WindowClock::put_forward(
            std::chrono::duration_cast<WindowClock::duration>(std::chrono::duration<double>(turn.seconds)));
        return turn.events;
    }
    Result<void> present(GpuCommands commands, const GpuImage&) override { return std::move(commands).run(); }
    std::string touch_state() const override { return ""; }
    void set_title(const std::string&) override {}
    void set_fullscreen(bool) override { ADD_FAILURE() << "a visitor has left full screen"; }
    /// By the script, once the window shows pictures.
    void set_size(int, int) override {
        EXPECT_FALSE(is_open_) << "a visitor has changed the window";
        is_open_ = true;
    }
    void hide_pointer(bool) override {}

private:
    Visitors visitors_;
    int turns_, turn_ = 0, quiet_ = 0;
    Day& day_;
    bool is_open_ = false;
};

class KioskDay : public ::testing::Test {
protected:
    void SetUp() override {
        options_.session.clip.file = folder_ / "globe.mkv";
        ASSERT_EQ(run_touchable({"make", "globe", (folder_ / "globe.mkv").string(), "--size", "64x48",
                                 "--frames", "30"})
                      .code,
                  0);
        options_.session.builder.name = "cpu";
        options_.headless = true;
        options_.painter = "cpu";
        options_.kiosk = KioskOptions{.times = times, .use_log = folder_ / "use.csv"};
    }
    /// The picture that the next visitor sees after so many hours of others, who presses a finger in the
    /// middle: of a moment of the clip, so that it is always the same. `is_stopped`: its force is off.
    Image seen_after(double hours, bool is_stopped) {
        return seen_after(Visitors(hours), std::to_string(hours), is_stopped);
    }
    Image seen_after(const Visitors& visitors, const std::string& name, bool is_stopped) {
        int turns = 0;
        for (Visitors counted = visitors; !counted.are_gone(); ++turns) (void)counted.next();
        options_.make_screen = [&](const ScreenOptions&) -> std::unique_ptr<Screen> {
            return std::make_unique<PublicScreen>(visitors, turns, day_);
        };
        // Of a script: 150 s without anybody, as one who holds something counts as being there for a minute.
        const double next_s = 0.1 * turns + 15;
        const auto shot = folder_ / (name + (is_stopped ? "stopped.png" : ".png"));
        using Kind = InputEvent::Kind;
        options_.script = {{0, WindowCommand{.verb = WindowVerb::size}},
                           {next_s, to_the_middle},
                           {next_s, WindowCommand{WindowVerb::play_pause}},
                           {next_s, WindowCommand{WindowVerb::seek_to, 0.3}},
                           // Once the clip is there: a surface that moves would take the finger along.
                           {next_s + 2, InputEvent{.kind = Kind::pressed, .word = "left"}}};
        if (is_stopped) options_.script.push_back({next_s + 2.1, InputEvent{.kind = Kind::key, .word = "f"}});
        for (int k = 3; k < 6; ++k)  // somebody who is there does something
            options_.script.push_back({next_s + k, to_the_middle});
        options_.script.push_back({next_s + 5.5, WindowCommand{WindowVerb::screenshot, 0, shot.string()}});
        options_.script.push_back({next_s + 5.6, WindowCommand{WindowVerb::quit}});
        const auto played = play_in_window(options_);
        EXPECT_TRUE(played) << played.error().message;
        const auto image = read_image(shot);
        EXPECT_TRUE(image);
        return image ? *image : Image{};
    }
    static int differences(const Image& a, const Image& b) {
        if (a.samples.size() != b.samples.size()) return -1;
        int count = 0;
        for (std::size_t k = 0; k < a.samples.size(); ++k)
            count += std::abs(a.samples[k] - b.samples[k]) > 24;
        return count;
    }

    const TemporaryFolder folder_;
    PlayOptions options_;
    Day day_;
};

TEST_F(KioskDay, EndsReadyForTheNextVisitorAndInTheMemoryThatItBeganWith) {
    const double hours = hours_of_visitors();
    const Image first = seen_after(0, false), stopped = seen_after(0, true);
    std::filesystem::remove(folder_ / "use.csv");
    const Image last = seen_after(hours, false);
    // What the finger takes of the picture is some 250 samples, and a little less or more in each run; a
    // second finger is as many, a view or an overlay thousands.
    EXPECT_GT(differences(first, stopped), 150) << "nobody sees the finger";
    EXPECT_GT(differences(last, stopped), 100) << "the force of a visitor is still off";
    EXPECT_GE(differences(first, last), 0);
    EXPECT_LT(differences(first, last), 220) << "something of the visitors is left";
#ifndef TOUCHABLE_SANITIZED  // which keeps what is freed
    EXPECT_LT(day_.late_mib, day_.early_mib + 12);
#endif
    // Its log has everybody, and for how long.
    Visitors visitors(hours);
    while (!visitors.are_gone()) (void)visitors.next();
    std::istringstream log(file_contents(folder_ / "use.csv"));
    int visits = 0, faults = 0;
    double seconds = 0;
    for (std::string line; std::getline(log, line);) {
        faults += line.find(",fault,") != std::string::npos;
        const std::size_t at = line.find(",visit,");
        if (at == std::string::npos) continue;
        ++visits;
        seconds += std::atof(line.c_str() + line.find(',', at + 7) + 1);
    }
    EXPECT_NEAR(visits, visitors.count() + 1, 1);
    EXPECT_GT(visits, 10 * hours);
    EXPECT_NEAR(seconds, visitors.seconds(), 0.05 * visitors.seconds() + 60);
    std::cout << seconds << " s of visits in the log, " << visitors.seconds() << " s by the visitors\n";
    EXPECT_EQ(faults, 0) << file_contents(folder_ / "use.csv");
}

TEST_F(KioskDay, IsReadyAfterTenMinutesOfAnyVisitorWhoNeverRests) {
    const Image first = seen_after(0, false);
    // All of them in the long run of the tests. The 13th leaves with a button held on a button.
    const unsigned step = hours_of_visitors() > 1 ? 1 : 4 * static_cast<unsigned>(sweep_step());
    for (unsigned seed = 1; seed <= 20; seed += step) {
        const Image last = seen_after(Visitors::restless(1.0 / 6, seed), std::to_string(seed), false);
        EXPECT_GE(differences(first, last), 0) << seed;
        EXPECT_LT(differences(first, last), 220) << seed << ": something of the visitors is left";
    }
}

}  // namespace
}  // namespace touchable::test
