// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "device/drivers/device_driver.hpp"

namespace touchable::test {

/// Time that passes only while a thread waits. Each of its milliseconds is a haptic tick, also
/// those that pass while a device's thread waits.
class VirtualTime {
public:
    static constexpr std::int64_t ms = 1'000'000;

    std::int64_t now_ns() const { return now_ns_; }
    void pass(std::int64_t ns) {
        const std::int64_t until = now_ns_ + ns;
        while (next_tick_ns_ <= until) {
            now_ns_ = next_tick_ns_;
            next_tick_ns_ += ms;
            if (on_tick) on_tick();
        }
        now_ns_ = until;
    }
    std::function<void()> on_tick;  ///< may not wait

private:
    std::int64_t now_ns_ = ms, next_tick_ns_ = 2 * ms;
};

/// The line between a device that a test plays and the driver: the device's messages arrive after a while,
/// and meet faults on their way. It records what has arrived when, and which force the last bytes ask for
/// that went out.
class FaultyLine {
public:
    using Message = std::vector<std::byte>;
    enum class Fault {
        none,
        lost,
        late,
        cut,
        damaged,
        twice,
        in_pieces,
        babble,
        refuses,
        unplugged,
        stalled
    };

    struct Manner {
        std::int64_t answers_after_ns = VirtualTime::ms;
        bool is_stream = false;     ///< of bytes: pieces of a message are as good as the whole
        bool has_checksum = false;  ///< damage of any kind is seen
        bool reorders = false;      ///< what is late is overtaken
        double place_step = 1e-6;   ///< m: places that differ by less are the same
        double longest_force = 0;   ///< that may go out, in the unit of `went_out`
    };

    FaultyLine(const Manner& manner, VirtualTime& time, std::mt19937& chance)
        : manner_(manner), time_(time), chance_(chance) {}

    const Manner& manner() const { return manner_; }
    /// Starts a fault that lasts so long. A fault of `refuses` is one transfer that fails; messages of a
    /// `stalled` line arrive at its end.
    void begin(Fault fault, std::int64_t lasts_ns);
    void end() { until_ns_ = 0; }
    void forget() { struck_ = false; }
    Fault fault() const { return time_.now_ns() < until_ns_ ? fault_ : Fault::none; }
    /// Has it met anything since it began?
    bool struck() const { return struck_; }

    // The device's.
    /// Two bytes at least. Of a place; not a number: the message tells of none.
    void tell(Message message, const glm::dvec3& place);

    // The fake transport's.
    /// True if nothing passes; the driver gets an error.
    bool is_cut();
    /// True if bytes pass to the device; then the force that they ask for goes to `went_out`.
    bool passes();
    void went_out(double force) { force_ = force; }
    /// The next that has arrived; it is waited for.
    std::optional<Message> next(std::chrono::microseconds patience);
    /// Drops the messages on their way, as a new connection does.
    void clear();

    // The test's.
    double force() const { return force_; }
    /// The time since the device's message of this place arrived, s; infinite: it has not told it. A damaged
    /// message may have told any place.
    double age_of(const glm::dvec3& place) const;
    /// The time since the last message that may have told a place, s.
    double silence_s() const;

private:
    struct Coming {
        std::int64_t due_ns;
        Message message;
    };
    struct Word {
        std::int64_t due_ns;
        std::optional<glm::dvec3> place;  // nothing: damaged
    };
    unsigned below(std::size_t n) { return static_cast<unsigned>(chance_() % n); }
    void lay(std::int64_t due_ns, Message message);
    void keep(std::int64_t due_ns, const std::optional<glm::dvec3>& place);
    void in_pieces(std::int64_t due_ns, const Message& message, const glm::dvec3& place);

    const Manner manner_;
    VirtualTime& time_;
    std::mt19937& chance_;
    Fault fault_ = Fault::none;
    std::int64_t until_ns_ = 0, delay_ns_ = 0, last_due_ns_ = 0;
    bool struck_ = false;
    std::deque<Coming> coming_;
    std::deque<Word> words_;  // of the last fifth of a second and a little more
    double force_ = 0;
};

/// --gtest_random_seed, or 17.
unsigned fault_seed();

/// A device that a test plays, at the far end of a line with faults.
class FaultyDevice {
public:
    using Fault = FaultyLine::Fault;

    FaultyDevice(std::string its_name, const FaultyLine::Manner& manner)
        : name(std::move(its_name)), line(manner, time, chance) {}
    FaultyDevice(const FaultyDevice&) = delete;
    FaultyDevice& operator=(const FaultyDevice&) = delete;
    virtual ~FaultyDevice() = default;

    virtual std::unique_ptr<DeviceDriver> driver() = 0;
    /// Called each millisecond with the angle of its hand on a circle, rad.
    virtual void live(double angle) = 0;
    /// A person's answer to this prompt.
    virtual void tend(const std::string&) {}
    /// A fault that no other device has; they come seldom, because it takes long to recover from them.
    virtual void suffer_its_own() { line.begin(Fault::unplugged, 5 * VirtualTime::ms); }
    /// The time since its message of this place arrived, s.
    virtual double age_of(const glm::dvec3& place) { return line.age_of(place); }

    const std::string name;
    VirtualTime time;
    std::mt19937 chance{fault_seed()};
    FaultyLine line;
    std::vector<Fault> faults{Fault::lost,      Fault::late,   Fault::cut,     Fault::damaged,  Fault::twice,
                              Fault::in_pieces, Fault::babble, Fault::refuses, Fault::unplugged};
    bool exerts = true;
};

/// Whole sessions with such a device at 1 kHz in virtual time, from open to close, a hundred faults each at
/// random moments: 10^4 in all, 2,000 in a short run (sweep.hpp), under sanitizers a twentieth. Of each tick
/// it is checked that no force is out that no caller asks for or that answers a place older than promised,
/// and that no such place is read; of each session, that it leaves no force. Prints a line of what came of
/// it, with the longest call of the haptic thread.
void run_fault_sessions(FaultyDevice& device);

/// A hand that presses falls silent for 10 to 100 ms, in virtual time: below 50 ms its force returns by
/// itself, above that only once the finger has been free. It is judged by the last bytes that went out.
void expect_force_after_silence(FaultyDevice& device);

}  // namespace touchable::test
