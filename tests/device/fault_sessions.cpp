// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>
#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "device/drivers/driven_device.hpp"
#include "device/hand.hpp"
#include "device/haptic_device.hpp"
#include "tests/device/fault_sessions.hpp"
#include "tests/limits.hpp"
#include "tests/sweep.hpp"

namespace touchable::test {
namespace {

constexpr std::int64_t kept_ns = 250 * VirtualTime::ms;
constexpr double never_heard = std::numeric_limits<double>::infinity();

}  // namespace

void FaultyLine::begin(Fault fault, std::int64_t lasts_ns) {
    fault_ = fault;
    until_ns_ = time_.now_ns() + lasts_ns;
    delay_ns_ = (1 + below(40)) * VirtualTime::ms;
    struck_ = false;
}

void FaultyLine::lay(std::int64_t due_ns, Message message) {
    const auto later = [](std::int64_t due, const Coming& each) { return due < each.due_ns; };
    coming_.insert(std::upper_bound(coming_.begin(), coming_.end(), due_ns, later),
                   Coming{due_ns, std::move(message)});
}

void FaultyLine::keep(std::int64_t due_ns, const std::optional<glm::dvec3>& place) {
    if (place && std::isnan(place->x)) return;
    words_.push_back({due_ns, place});
    while (words_.front().due_ns < time_.now_ns() - kept_ns) words_.pop_front();
}

void FaultyLine::in_pieces(std::int64_t due_ns, const Message& message, const glm::dvec3& place) {
    const std::size_t first = 1 + below(message.size() - 1);
    const auto middle = message.begin() + static_cast<std::ptrdiff_t>(first);
    const std::int64_t rest_ns = due_ns + below(3) * VirtualTime::ms;
    lay(due_ns, Message(message.begin(), middle));
    lay(rest_ns, Message(middle, message.end()));
    last_due_ns_ = rest_ns;
    if (manner_.is_stream) keep(rest_ns, place);
}

void FaultyLine::tell(Message message, const glm::dvec3& place) {
    const Fault now = fault();
    std::int64_t due_ns = time_.now_ns() + manner_.answers_after_ns;
    // Messages that may overtake each other have a delay each.
    if (now == Fault::late) due_ns += manner_.reorders ? below(40) * VirtualTime::ms : delay_ns_;
    if (now == Fault::stalled) due_ns = std::max(due_ns, until_ns_);
    if (!manner_.reorders) due_ns = std::max(due_ns, last_due_ns_);
    last_due_ns_ = due_ns;
    const bool strikes = now != Fault::none && now != Fault::refuses;
    struck_ = struck_ || strikes;
    switch (now) {
        case Fault::lost:
        case Fault::unplugged:
            return;
        case Fault::cut:
            message.resize(below(message.size()));
            return lay(due_ns, std::move(message));
        case Fault::damaged:
            message[below(message.size())] ^= static_cast<std::byte>(1 + below(255));
            if (!manner_.has_checksum) keep(due_ns, std::nullopt);
            return lay(due_ns, std::move(message));
        case Fault::in_pieces:
            return in_pieces(due_ns, message, place);
        case Fault::babble:
            message.resize(below(65));
            for (std::byte& each : message) each = static_cast<std::byte>(below(256));
            return lay(due_ns, std::move(message));
        case Fault::twice:
            lay(due_ns, message);
            break;
        default:
            break;
    }
    keep(due_ns, place);
    lay(due_ns, std::move(message));
}

/// A device that loses its plug loses its power.
bool FaultyLine::is_cut() {
    const bool cut = fault() == Fault::unplugged;
    if (cut) {
        struck_ = true;
        force_ = 0;
        clear();
    }
    return cut;
}

bool FaultyLine::passes() {
    if (is_cut()) return false;
    if (fault() != Fault::refuses) return true;
    struck_ = true;
    end();
    return false;
}

std::optional<FaultyLine::Message> FaultyLine::next(std::chrono::microseconds patience) {
    const std::int64_t until = time_.now_ns() + std::chrono::nanoseconds(patience).count();
    const auto is_there = [&] { return !coming_.empty() && coming_.front().due_ns <= time_.now_ns(); };
    while (!is_there() && time_.now_ns() < until) {
        const std::int64_t due = coming_.empty() ? until : coming_.front().due_ns;
        time_.pass(std::min({until, due, time_.now_ns() + VirtualTime::ms}) - time_.now_ns());
    }
    if (!is_there()) return std::nullopt;
    Message message = std::move(coming_.front().message);
    coming_.pop_front();
    return message;
}

void FaultyLine::clear() {
    coming_.clear();
    last_due_ns_ = 0;
    std::erase_if(words_, [this](const Word& word) { return word.due_ns > time_.now_ns(); });
}

double FaultyLine::age_of(const glm::dvec3& place) const {
    std::int64_t newest_ns = -1;
    for (const Word& word : words_)
        if (word.due_ns <= time_.now_ns() &&
            (!word.place || glm::length(place - *word.place) <= manner_.place_step))
            newest_ns = std::max(newest_ns, word.due_ns);
    return newest_ns < 0 ? never_heard : static_cast<double>(time_.now_ns() - newest_ns) * 1e-9;
}

double FaultyLine::silence_s() const {
    std::int64_t newest_ns = -1;
    for (const Word& word : words_)
        if (word.due_ns <= time_.now_ns()) newest_ns = std::max(newest_ns, word.due_ns);
    return newest_ns < 0 ? never_heard : static_cast<double>(time_.now_ns() - newest_ns) * 1e-9;
}

}  // namespace touchable::test
namespace touchable::test {
namespace {

constexpr std::int64_t a_millisecond = VirtualTime::ms;
#ifdef TOUCHABLE_SANITIZED
constexpr int all_faults = 500;
#else
constexpr int all_faults = 10'000;
#endif
constexpr int faults_of_a_session = 100;
// A turn of the device's thread may wait so long for an answer before the next force, or zero, goes out.
constexpr double longest_turn_s = 0.006;

class FaultSessions {
public:
    explicit FaultSessions(FaultyDevice& device) : device_(device), line_(device.line), time_(device.time) {
        time_.on_tick = [this] { tick(); };
    }
    ~FaultSessions() { time_.on_tick = {}; }

    void run() {
        const int faults = sweep_step() == 1 ? all_faults : all_faults / 5;
        while (struck_ < faults && violation_.empty()) {
            session();
            if (testing::Test::HasFatalFailure()) return;
        }
        std::printf(
            "%s: %d faults, seed %u, %.0f s of virtual time, %d forces left on, oldest position read %.1f ms "
            "(promised %.0f), longest call of the haptic thread %.3f ms by the clock on the wall\n",
            device_.name.c_str(), struck_, fault_seed(), static_cast<double>(time_.now_ns()) * 1e-9, left_on_,
            1e3 * oldest_s_, 1e3 * HapticDevice::oldest_s, static_cast<double>(longest_call_ns_) * 1e-6);
        ASSERT_EQ(violation_, "");
        EXPECT_EQ(left_on_, 0);
        // The device had sound times too.
        EXPECT_GT(placed_, ticks_ / 4);
        EXPECT_GT(oldest_s_, device_.exerts ? 0.019 : 0);
        EXPECT_GT(placeless_, ticks_ / 50);
        EXPECT_GT(exerting_, device_.exerts ? ticks_ / 10 : -1);
    }

private:
    bool one_in(unsigned n) { return device_.chance() % n == 0; }
    std::int64_t below_ms(unsigned n) {
        return device_.chance() % n * a_millisecond + device_.chance() % 1000 * 1000;
    }

    void session() {
        line_.end();
        DrivenDevice driven(device_.driver(), {.away_s = 600,
                                               .look_again_s = 0.01,
                                               .clock = [this] { return time_.now_ns(); },
                                               .own_thread = false});
        const auto opened = driven.open();
        ASSERT_TRUE(opened) << opened.error().message;
        driven_ = &driven;
        for (int fault = 0; fault < faults_of_a_session && violation_.empty(); ++fault) {
            device_.tend(driven.prompt());
            play(one_in(10) ? 150 * a_millisecond : below_ms(20));
            begin_a_fault();
            play(until_ns_ - time_.now_ns());
            struck_ += line_.struck() ? 1 : 0;
        }
        // The session ends in the middle of a fault, or of sound times.
        if (one_in(2)) {
            begin_a_fault();
            play(std::min(2 * a_millisecond, until_ns_ - time_.now_ns()));
            // A zero that does not go out when they part is a wire that is cut.
            if (line_.fault() == FaultyDevice::Fault::refuses) line_.end();
        }
        driven_ = nullptr;
        driven.close();
        if (line_.force() != 0) ++left_on_;
    }

    void begin_a_fault() {
        line_.forget();  // one of its own is none of the line's
        const std::int64_t lasts = a_millisecond + (one_in(6) ? below_ms(70) : below_ms(8));
        until_ns_ = time_.now_ns() + lasts;
        if (one_in(6)) sleeps_until_ns_ = until_ns_;
        if (one_in(50)) return device_.suffer_its_own();
        line_.begin(device_.faults[device_.chance() % device_.faults.size()], lasts);
    }

    /// A turn of the device's thread.
    void play(std::int64_t ns) {
        const std::int64_t until = time_.now_ns() + ns;
        while (time_.now_ns() < until && violation_.empty()) {
            const std::int64_t before = time_.now_ns();
            if (!driven_->turn()) violation_ = "it was given up";
            check_force();
            if (time_.now_ns() == before) time_.pass(a_millisecond / 4);
        }
    }

    /// A tick of the haptic thread.
    void tick() {
        device_.live(static_cast<double>(time_.now_ns()) * 7.5e-9);
        if (!driven_) return;
        ++ticks_;
        exerting_ += line_.force() != 0 ? 1 : 0;
        check_force();
        if (time_.now_ns() < sleeps_until_ns_) return;
        const glm::dvec3 newtons = one_in(8) ? glm::dvec3(0) : glm::dvec3(one_in(2) ? 1 : 30, 2, -1);
        glm::dvec3 place(0);
        const std::int64_t began = boot_ns();
        const bool reads = driven_->read_positions(std::span(&place, 1));
        const bool writes = driven_->write_forces(std::span(&newtons, 1));
        longest_call_ns_ = std::max(longest_call_ns_, boot_ns() - began);
        if (!reads || !writes) return say("the haptic thread's calls fail");
        if (newtons != glm::dvec3(0)) asked_ns_ = time_.now_ns();
        if (std::isnan(place.x))
            ++placeless_;
        else
            check_place(place);
    }

    void check_place(const glm::dvec3& place) {
        ++placed_;
        const double age = device_.age_of(place);
        if (!(age <= 1)) return say("a place was read that was never told");
        oldest_s_ = std::max(oldest_s_, age);
        // A word lies there for up to a turn before it is heard.
        if (age > HapticDevice::oldest_s + 0.001) say("a place was read that is too old");
    }

    void check_force() {
        if (line_.force() == 0) return;
        const double asked_s = static_cast<double>(time_.now_ns() - asked_ns_) * 1e-9;
        if (line_.force() > line_.manner().longest_force) say("a force is longer than the limit");
        if (asked_s > HapticDevice::silence_s + longest_turn_s) say("a force outlived its caller");
        if (line_.silence_s() > HapticDevice::oldest_s + longest_turn_s)
            say("a force answers a place that is too old");
    }

    void say(const std::string& what) {
        if (violation_.empty())
            violation_ = what + ", after " + std::to_string(struck_) + " faults, in a fault of kind " +
                         std::to_string(static_cast<int>(line_.fault()));
    }

    FaultyDevice& device_;
    FaultyLine& line_;
    VirtualTime& time_;
    DrivenDevice* driven_ = nullptr;  // while it is open
    std::int64_t until_ns_ = 0, sleeps_until_ns_ = 0, asked_ns_ = 0;
    std::string violation_;
    int struck_ = 0, left_on_ = 0;
    std::int64_t ticks_ = 0, placed_ = 0, exerting_ = 0, placeless_ = 0, longest_call_ns_ = 0;
    double oldest_s_ = 0;
};

}  // namespace

unsigned fault_seed() {
    const auto given = GTEST_FLAG_GET(random_seed);
    return given != 0 ? static_cast<unsigned>(given) : 17U;
}

void run_fault_sessions(FaultyDevice& device) {
    FaultSessions(device).run();
}

void expect_force_after_silence(FaultyDevice& device) {
    HandControl control(1, {});
    control.ask_force(true);
    VirtualTime& time = device.time;
    DrivenDevice driven(
        device.driver(),
        {.look_again_s = 0.01, .clock = [&time] { return time.now_ns(); }, .own_thread = false});
    bool is_inside = false;
    time.on_tick = [&] {
        device.live(static_cast<double>(time.now_ns()) * 7.5e-9);
        glm::dvec3 place(0), newtons(0);
        if (!driven.read_positions(std::span(&place, 1))) return;
        glm::dvec3 goal = place;
        control.to_goals(std::span(&goal, 1), driven.buttons());
        const glm::dvec3 guarded(0, 0, is_inside ? 1 : 0);
        control.to_device(std::span(&guarded, 1), 1, std::span(&newtons, 1));
        if (std::isnan(place.x)) newtons = glm::dvec3(0);
        EXPECT_TRUE(driven.write_forces(std::span(&newtons, 1)));
    };
    double silence_s = 0;
    const auto play = [&](std::int64_t ms, bool inside) {
        is_inside = inside;
        device.tend(driven.prompt());
        for (const std::int64_t until = time.now_ns() + ms * a_millisecond; time.now_ns() < until;) {
            const std::int64_t before = time.now_ns();
            ASSERT_TRUE(driven.turn());
            if (time.now_ns() == before) time.pass(a_millisecond / 4);
            silence_s = std::max(silence_s, device.line.silence_s());
        }
    };
    ASSERT_TRUE(driven.open());
    play(100, false);
    int returned = 0, waited = 0;
    for (std::int64_t ms = 10; ms <= 100; ms += 3) {
        play(50, false);
        play(500, true);
        ASSERT_GT(device.line.force(), 0) << device.name << " before a silence of " << ms << " ms";
        silence_s = 0;
        device.line.begin(FaultyDevice::Fault::stalled, ms * a_millisecond);
        play(ms + 600, true);
        if (std::abs(silence_s - 0.05) < 0.002) continue;  // a turn of the device's thread
        const bool is_short = silence_s < 0.05;
        EXPECT_EQ(device.line.force() > 0, is_short) << device.name << " after " << silence_s << " s";
        ++(is_short ? returned : waited);
    }
    play(50, false);
    play(500, true);
    EXPECT_GT(device.line.force(), 0);
    EXPECT_GT(returned, 8);
    EXPECT_GT(waited, 8);
    driven.close();
    time.on_tick = {};
}

}  // namespace touchable::test
