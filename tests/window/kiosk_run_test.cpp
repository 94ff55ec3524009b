// SPDX-License-Identifier: Apache-2.0
// A day of a kiosk whose visitors press and touch everything, by a clock that the test puts forward.

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <memory>
#include <numeric>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "engine/picture/image.hpp"
#include "engine/picture/sound.hpp"
#include "player/audio/heard_sound.hpp"
#include "player/audio/window_sound.hpp"
#include "tests/limits.hpp"
#include "tests/sweep.hpp"
#include "tests/video/remuxed_clip.hpp"
#include "tests/window/scripted_window.hpp"
#include "tests/window/window_rig.hpp"

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

/// One turn of the window: how long it takes, and the inputs at its end.
struct Turn {
    double seconds = 0;
    std::vector<InputEvent> events{};
};

/// The buttons and fingers that a visitor holds down.
class Held {
public:
    /// Presses below `lowest` in the picture do not count.
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
    /// A turn without a visitor, up to a moment before the next one comes.
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

/// Memory early and late in a day.
struct Day {
    double early_mib = 0, late_mib = 0;
};

/// Their screen. Once they are gone it goes on without input.
class DayScreen final : public PublicScreen {
public:
    DayScreen(Visitors visitors, int turns, Day& day)
        : visitors_(std::move(visitors)), turns_(turns), day_(day) {}

    ScreenSize size() const override { return {public_width, public_height, 1}; }
    std::vector<InputEvent> next_events() override {
        if (visitors_.are_gone()) {
            day_.late_mib = std::max(day_.late_mib, resident_mib());
            std::this_thread::sleep_for(++quiet_ < 145 ? 5ms : 20ms);  // fingers go by their own time
            put_forward(1);
            return {};
        }
        if (++turn_ == turns_ / 4) day_.early_mib = resident_mib();
        const Turn turn = visitors_.next();
        put_forward(turn.seconds);
        return turn.events;
    }
    void set_size(int, int) override {
        EXPECT_FALSE(is_open_) << "a visitor has changed the window";
        is_open_ = true;
    }

private:
    Visitors visitors_;
    int turns_, turn_ = 0, quiet_ = 0;
    Day& day_;
};

class KioskDay : public ::testing::Test {
protected:
    void SetUp() override {
        options_ = headless_by_cpu(folder_ / "globe.mkv");
        make_clip(folder_ / "globe.mkv", "globe", 30);
        options_.kiosk = PlayOptions::Kiosk{.times = times, .use_log = folder_ / "use.csv"};
    }
    /// The picture that the next visitor sees after so many hours of others, who presses a finger in the
    /// middle: of a moment of the clip, so that it is always the same. `is_stopped`: its force is off.
    Image seen_after(const Visitors& visitors, bool is_stopped = false) {
        int turns = 0;
        for (Visitors counted = visitors; !counted.are_gone(); ++turns) (void)counted.next();
        options_.make_screen = [&](const ScreenOptions&) -> std::unique_ptr<Screen> {
            return std::make_unique<DayScreen>(visitors, turns, day_);
        };
        // Of a script: 150 s without a visitor, as a held button counts as one for a minute.
        const double next_s = 0.1 * turns + 15;
        const auto shot = folder_ / (std::to_string(shots_++) + ".png");
        using Kind = InputEvent::Kind;
        options_.script = {{0, WindowCommand{.verb = WindowVerb::size}},
                           {next_s, to_the_middle},
                           {next_s, WindowCommand{WindowVerb::play_pause}},
                           {next_s, WindowCommand{WindowVerb::seek_to, 0.3}},
                           // Once the clip is there: a surface that moves would take the finger along.
                           {next_s + 2, InputEvent{.kind = Kind::pressed, .word = "left"}}};
        if (is_stopped) options_.script.push_back({next_s + 2.1, InputEvent{.kind = Kind::key, .word = "f"}});
        for (int k = 3; k < 6; ++k)  // the visitor does something
            options_.script.push_back({next_s + k, to_the_middle});
        options_.script.push_back({next_s + 5.5, WindowCommand{WindowVerb::screenshot, 0, shot.string()}});
        options_.script.push_back({next_s + 5.6, WindowCommand{WindowVerb::quit}});
        const auto played = play_in_window(options_);
        EXPECT_TRUE(played) << played.error().message;
        const auto image = read_image(shot);
        EXPECT_TRUE(image);
        return image ? *image : Image{};
    }
    /// Samples that differ by more than 24.
    static int differences(const Image& a, const Image& b) {
        if (a.samples.size() != b.samples.size()) return -1;
        return std::inner_product(a.samples.begin(), a.samples.end(), b.samples.begin(), 0, std::plus<>(),
                                  [](int one, int other) { return std::abs(one - other) > 24 ? 1 : 0; });
    }

    const TemporaryFolder folder_;
    PlayOptions options_;
    Day day_;
    int shots_ = 0;
};

TEST_F(KioskDay, LeavesNothingAndLeaksNothing) {
    const double hours = hours_of_visitors();
    const Image first = seen_after(Visitors(0)), stopped = seen_after(Visitors(0), true);
    std::filesystem::remove(folder_ / "use.csv");
    const Image last = seen_after(Visitors(hours));
    // What the finger takes of the picture is some 250 samples, and a little less or more in each run; a
    // second finger is as many, a view or an overlay thousands.
    EXPECT_GT(differences(first, stopped), 150) << "the finger is not seen";
    EXPECT_GT(differences(last, stopped), 100) << "the force of a visitor is still off";
    EXPECT_GE(differences(first, last), 0);
    EXPECT_LT(differences(first, last), 220) << "something of the visitors is left";
#ifndef TOUCHABLE_SANITIZED  // which keeps what is freed
    EXPECT_LT(day_.late_mib, day_.early_mib + 12);
#endif
    // Its log has every visitor, and for how long.
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

/// A visitor who comes before the clip.
TEST_F(KioskDay, SaysNothingBeforeItsClip) {
    class EarlyScreen final : public WrappedScreen {
    public:
        using WrappedScreen::WrappedScreen;
        std::vector<InputEvent> poll(std::chrono::milliseconds longest) override {
            using Kind = InputEvent::Kind;
            if (std::exchange(has_come_, true)) return WrappedScreen::poll(longest);
            return {{.kind = Kind::key, .word = "space"},
                    {.kind = Kind::key, .word = "q"},
                    {.kind = Kind::key, .word = "escape"},
                    {.kind = Kind::close}};
        }

    private:
        bool has_come_ = false;
    };
    options_.make_screen = [](const ScreenOptions& wanted) { return std::make_unique<EarlyScreen>(wanted); };
    options_.seconds = 0.3;
    testing::internal::CaptureStderr();
    const auto played = play_in_window(options_);
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
    ASSERT_TRUE(played) << played.error().message;
    EXPECT_GE(played->seconds, 0.3) << "it was closed";
}

TEST_F(KioskDay, IsReadyAfterRestlessVisitors) {
    const Image first = seen_after(Visitors(0));
    // All of them in the long run of the tests. The 13th leaves with a button held on a button.
    const unsigned step = hours_of_visitors() > 1 ? 1 : 4 * static_cast<unsigned>(sweep_step());
    for (unsigned seed = 1; seed <= 20; seed += step) {
        const Image last = seen_after(Visitors::restless(1.0 / 6, seed));
        EXPECT_GE(differences(first, last), 0) << seed;
        EXPECT_LT(differences(first, last), 220) << seed << ": something of the visitors is left";
    }
}

// A kiosk's bar of large buttons: what visitors do by it, with a mouse and with a finger, and what is left of
// it. The window is so narrow that buttons fill the bar: so their places are known.

/// From the left, of two clips that are more than a picture; of one there is no `next`, of pictures no
/// `pause`.
enum class Pressed { mode, pause, colours, next, straight };

/// Where it is, of so many, in a window of 320x240.
std::string place_of(int button, int count) {
    const double wide = (320.0 - 12 - 6 * (count + 1)) / count, left = 6 + 6;
    return std::to_string(static_cast<int>(left + button * (wide + 6) + wide / 2)) + " 198";
}
std::string click(double at_s, const std::string& place) {
    return std::to_string(at_s) + " move " + place + "\n" + std::to_string(at_s + 0.15) + " press left\n" +
           std::to_string(at_s + 0.3) + " release left\n" + std::to_string(at_s + 0.45) + " move 310 4\n";
}
std::string tap(double at_s, const std::string& place) {
    return std::to_string(at_s) + " touch 1 " + place + "\n" + std::to_string(at_s + 0.2) + " touch-end 1\n";
}

constexpr PicturePart above{90, 8, 312, 150}, bar{8, 164, 312, 232};

class KioskBarTest : public ::testing::Test {
protected:
    /// A kiosk of two pictures, whose buttons are turn, colours, next, straight.
    static Image seen(const std::string& script, const char* seconds, std::vector<std::string> more = {}) {
        std::vector<std::string> words{made_clip("globe", 1).string(), made_clip("bumps", 1).string(),
                                       "--kiosk"};
        words.insert(words.end(), more.begin(), more.end());
        return played_by(words, script, seconds).image;
    }
    static Image bumps(const std::string& script, const char* seconds) {
        return played_by({made_clip("bumps", 1).string(), "--kiosk"}, script, seconds).image;
    }
    static std::string turn() { return place_of(0, 4); }
    static std::string colours() { return place_of(1, 4); }
    static std::string next() { return place_of(2, 4); }
    static std::string straight() { return place_of(3, 4); }
};

TEST_F(KioskBarTest, WorksByMouseAndFinger) {
    const Image plain = seen("0 move 310 4\n", "1");
    for (const auto& press : {click, tap}) {
        const Image coloured = seen(press(0.1, colours()), "1.2");
        EXPECT_GT(differences(plain, coloured, above), 3000);
        const std::string drag =
            "0.8 move 200 60\n0.9 press left\n1 move 260 60\n1.1 release left\n1.2 move 310 4\n";
        const Image
            pressed = seen(drag, "1.9"),
            turned = seen(press(0.1, turn()) + drag, "1.9"),
            back = seen(press(0.1, turn()) + drag + press(1.4, straight()), "2.6"),
            again =
                seen(press(0.1, turn()) + drag + press(1.4, straight()) +
                         "2 move 200 60\n2.1 press left\n2.2 move 260 60\n2.3 release left\n2.4 move 310 4\n",
                     "3.1");
        EXPECT_LT(differences(plain, pressed, above), 300) << "a drag touches";
        EXPECT_GT(differences(plain, turned, above), 3000) << "a drag turns";
        EXPECT_LT(differences(plain, back, above), 300);
        EXPECT_LT(differences(plain, again, above), 300) << "after the way back a drag touches again";
        EXPECT_GT(differences(pressed, turned, bar), 100) << "the bar does not show that it turns";
    }
}

TEST_F(KioskBarTest, KeepsChoicesAcrossClips) {
    const std::string chosen = "0.1 turn 30\n" + click(0.2, colours());
    const Image other = seen(chosen + click(0.9, next()), "2"),
                same = bumps("0.1 turn 30\n0.2 overlay depth\n0.8 move 310 4\n", "2");
    EXPECT_LT(differences(other, same, above), 100);
    EXPECT_GT(differences(same, bumps("", "1"), above), 3000);
    EXPECT_LT(differences(seen(click(0.2, next()), "1.5"), bumps("0.5 move 310 4\n", "1.5"), above), 100);
}

/// The finger that invites is elsewhere.
TEST_F(KioskBarTest, ResetsForNextVisitor) {
    const std::vector<std::string> soon{"--idle", "0.8", "0.9"};
    constexpr PicturePart beside{100, 30, 150, 90};
    const Image fresh = seen("", "0.5"),
                chosen = seen("0.1 turn 30\n" + click(0.1, colours()) + click(0.6, next()), "1.4",
                              {"--idle", "9", "9"}),
                later = seen("0.1 turn 30\n" + click(0.1, colours()) + click(0.6, next()), "4", soon);
    EXPECT_GT(differences(fresh, chosen, beside), 1500);
    EXPECT_LT(differences(fresh, later, beside), 100);
}

TEST_F(KioskBarTest, IgnoresButtonHeldOverReset) {
    const std::vector<std::string> soon{"--idle", "0.8", "0.8"};
    const std::string by_mouse =
                          "0.1 move " + colours() + "\n0.2 press left\n2.6 release left\n2.7 move 310 4\n",
                      by_finger = "0.1 touch 1 " + colours() + "\n3 touch-end 1\n3.1 move 310 4\n";
    const Image fresh = seen("0 move 310 4\n", "0.3");
    EXPECT_LT(differences(fresh, seen(by_mouse, "2.9", soon), above), 100);
    EXPECT_LT(differences(fresh, seen(by_finger, "3.3", soon), above), 100);
}

/// One clip: of several the next one would come.
TEST_F(KioskBarTest, HidesWhenIdle) {
    const auto alone = [](const std::string& script, const char* seconds, std::vector<std::string> more) {
        more.insert(more.begin(), {made_clip("globe", 1).string(), "--kiosk"});
        return played_by(more, script, seconds).image;
    };
    const std::vector<std::string> late{"--idle", "30", "60"};
    const Image shown = alone("0.1 move 310 4\n", "1", late), gone = alone("0.1 move 310 4\n", "5", late),
                again = alone("5 move 310 4\n", "5.4", late),
                off = alone("0.1 move 310 4\n", "1", {"--kiosk-bar", "off"});
    EXPECT_GT(differences(shown, gone, bar), 3000);
    EXPECT_LT(differences(shown, again, bar), 100);
    EXPECT_LT(differences(gone, off, bar), 100);
    const std::vector<std::string> play{"play", made_clip("globe", 1).string(), "--headless", "--seconds",
                                        "0.2"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), play.begin(), play.end());
        return more;
    };
    expect_refused(with({"--kiosk", "--kiosk-bar", "perhaps"}), 2);
    expect_refused(with({"--kiosk-bar", "off"}), 2);
}

/// How often a finger comes to the surface.
int touches_by(const std::string& script) {
    PlayOptions options = headless_by_cpu(made_clip("bumps", 1));
    options.kiosk = PlayOptions::Kiosk{};
    options.meter = std::make_shared<TouchMeter>();
    options.script = inputs_of(script + "5.4 quit\n");
    const auto played = play_in_window(options);
    EXPECT_TRUE(played) << played.error().message;
    return options.meter->measures().touches;
}

TEST_F(KioskBarTest, PressTouchesNothingBelow) {
    const std::string button = place_of(1, 3);
    EXPECT_EQ(touches_by(click(0.5, button) + tap(1.2, button)), 0);
    const std::string deep = "0.3 move " + button + "\n0.4 wheel 9\n0.5 wheel 9\n";
    EXPECT_EQ(touches_by(deep + click(0.6, button)), 0);
    EXPECT_GE(touches_by("0.2 move 160 60\n0.4 press left\n1 release left\n"), 1);
    EXPECT_GE(touches_by("0.1 move 2 2\n4.7 touch 1 " + button + "\n5 touch-end 1\n"), 1);
}

// A kiosk's labels and texts, by the program as a person starts it: what is seen, and what is heard.

constexpr double label_hertz = 3000;

class KioskLabels : public ::testing::Test {
protected:
    void SetUp() override {
        clip_ = (folder_ / "still.mkv").string();
        make_clip(clip_, "globe", 1, "160x120");
        write_sounding_clip(folder_ / "bell.wav", tone(label_hertz, 0.4));
    }
    /// `play`, which has to end well.
    void play_well(const std::string& labels, const std::vector<std::string>& more = {},
                   const std::string& script = press, const char* at_s = "2", const char* has_bar = "off") {
        const Outcome played = play(labels, more, script, at_s, has_bar);
        EXPECT_EQ(played.code, 0) << played.err;
    }
    static constexpr const char* press = "0 move 160 110\n0.1 press left\n";
    /// The finger comes to the middle of a window of 320x240, and stays.
    Outcome play(const std::string& labels, const std::vector<std::string>& more = {},
                 const std::string& script = press, const char* at_s = "2", const char* has_bar = "off") {
        std::ofstream(folder_ / "labels.json") << "{\"touchable_labels\": 1, \"labels\": [" << labels << "]}";
        std::filesystem::remove(folder_ / "heard.wav");
        std::filesystem::remove(folder_ / "shot.png");
        std::vector<std::string> words{
            clip_,          "--kiosk",   "--kiosk-bar", has_bar,
            "--sound",      "heard.wav", "--labels",    (folder_ / "labels.json").string(),
            "--screenshot", "shot.png",  "--at",        at_s};
        words.insert(words.end(), more.begin(), more.end());
        return run_scripted(words, script, folder_.path());
    }
    /// The kiosk invites, without a visitor.
    void invite(const std::vector<std::string>& more) {
        std::vector<std::string> words{clip_,          "--kiosk",  "--idle", "0.1", "9",
                                       "--screenshot", "shot.png", "--at",   "1.6", "--overwrite"};
        words.insert(words.end(), more.begin(), more.end());
        const Outcome played = run_scripted(words, "", folder_.path());
        EXPECT_EQ(played.code, 0) << played.err;
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

TEST_F(KioskLabels, AppearUnderRestingFinger) {
    const std::string middle =
        R"({"caption": "Indian Ocean", "sound": "bell.wav", "rectangle": [60, 40, 100, 70]})";
    play_well(middle);
    EXPECT_GT(written(), 100) << "no caption";
    EXPECT_LT(tone_between(0, 0.5), 0.01) << "the finger had not rested yet";
    EXPECT_GT(tone_between(0.5, 2), 0.08) << "no sound";
    const std::string other =
        R"({"caption": "Indian Ocean", "sound": "bell.wav", "rectangle": [0, 0, 50, 119]})";
    play_well(other);
    EXPECT_LT(written(), 20);
    play_well(middle, {}, press, "2", "on");
    EXPECT_GT(written(135, 160), 60) << "the bar is over it";
    play_well(other, {}, press, "2", "on");
    EXPECT_LT(written(135, 160), 20);
    EXPECT_LT(tone_between(0.5, 2), 0.01);
    play_well(middle, {}, "0 move 160 110\n");
    EXPECT_LT(written(), 20) << "the finger touched nothing";
    play_well(middle, {}, "0 move 160 110\n0 mute\n0.1 press left\n");
    EXPECT_LT(tone_between(0.5, 2), 0.01) << "M silences all";
}

TEST_F(KioskLabels, AreFoundBySegmentName) {
    ASSERT_NO_FATAL_FAILURE(write_two_surfaces(folder_ / "wall.mkv", 1));
    clip_ = (folder_ / "wall.mkv").string();
    std::ofstream(folder_ / "segments.json")
        << R"({"touchable_segments": 1, "segments": [{"name": "the wall", "material": "wood", "at": [20, 20, 0]}]})";
    const std::string label = R"({"caption": "the wall", "sound": "bell.wav", "segment": "the wall"})";
    const auto refused = play(label);
    EXPECT_EQ(refused.code, 3);
    EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
    EXPECT_TRUE(contains(refused.err, "--segments"));
    const std::vector<std::string> segments{"--segments", (folder_ / "segments.json").string()};
    play_well(label, segments, "0 move 80 120\n0.3 press left\n", "4");
    EXPECT_GT(written(), 40);
    play_well(label, segments, "0 move 250 120\n0.3 press left\n", "4");
    EXPECT_LT(written(), 20);
}

TEST_F(KioskLabels, RejectInvalidInOneLine) {
    for (const auto& [label, words] :
         {std::pair{R"({"caption": "a", "rectangle": [0, 0, 160, 10]})", "160x120"},
          {R"({"caption": "a", "rectangle": [0, 0, 1, 1], "sound": "none.wav"})", "none.wav"},
          {R"({"caption": "a", "rectangle": [0, 0, 1, 1], "sound": "labels.json"})", "WAV"}}) {
        const auto refused = play(label);
        EXPECT_EQ(refused.code, 3) << label;
        EXPECT_TRUE(refused.one_line_of_error()) << refused.err;
        EXPECT_TRUE(contains(refused.err, words));
    }
}

/// Each of them once, and each of the languages that come with the program.
TEST_F(KioskLabels, TextsFollowLanguageOrFile) {
    const auto bright = [&](const std::vector<std::string>& more, const char* language = nullptr) {
        if (language) setenv("LC_ALL", language, 1);
        invite(more);
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
    EXPECT_LT(bright({"--kiosk-texts", "texts.json"}), english * 3 / 4);
    expect_refused({"play", clip_, "--kiosk", "--headless", "--seconds", "0.2", "--kiosk-texts", "xx"}, 2,
                   "de, en");
}

TEST_F(KioskLabels, LongTextWraps) {
    std::string words;
    while (words.size() < 190) words += "Etna ";
    std::ofstream(folder_ / "texts.json")
        << R"({"touchable_kiosk_texts": 1, "language": "en", "invitation": ")" << words << R"("})";
    invite({"--kiosk-texts", "texts.json"});
    EXPECT_EQ(written(115, 240, 0, 5), 0) << "cut off on the left";
    EXPECT_EQ(written(115, 240, 315, 320), 0) << "cut off on the right";
    EXPECT_GT(written(130, 155), 60) << "one of its lines";
    EXPECT_GT(written(180, 200), 60) << "another one";
}

TEST_F(KioskLabels, ForceStaysBelowMaxForce) {
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

TEST(SpokenSound, PlaysOnceAndDucksOthers) {
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

TEST(SpokenSound, RejectsLongOrSilent) {
    const TemporaryFolder folder;
    write_sounding_clip(folder / "long.wav", tone(100, 61));
    write_sounding_clip(folder / "silent.wav", std::vector<StereoSample>(4800));
    for (const char* name : {"long.wav", "silent.wav", "missing.wav"}) {
        const auto refused = SpokenSound::read(folder / name);
        ASSERT_FALSE(refused) << name;
        EXPECT_TRUE(contains(refused.error().message, name));
    }
}

}  // namespace
}  // namespace touchable::test
