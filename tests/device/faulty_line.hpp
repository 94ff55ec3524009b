#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <glm/vec3.hpp>
#include <optional>
#include <random>
#include <vector>

#include "tests/device/virtual_time.hpp"

namespace touchable::test {

/// What lies between a device that a test plays and the driver: what the device tells arrives after a while,
/// and meets faults on its way. It keeps what has arrived when, and which force the last bytes ask for that
/// went out.
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
        bool has_checksum = false;  ///< damage is seen, whatever it is
        bool reorders = false;      ///< what is late is overtaken
        double place_step = 1e-6;   ///< m: places that differ by less are the same
        double longest_force = 0;   ///< that may go out, in the unit of `went_out`
    };

    FaultyLine(const Manner& manner, VirtualTime& time, std::mt19937& chance)
        : manner_(manner), time_(time), chance_(chance) {}

    const Manner& manner() const { return manner_; }
    /// From now on, for so long. A fault of `refuses` is one transfer that fails; what is told while the line
    /// is `stalled` arrives at its end.
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
    /// Nothing passes, and the driver is told so.
    bool is_cut();
    /// Whether bytes pass to the device; where they do, the force that they ask for goes to `went_out`.
    bool passes();
    void went_out(double force) { force_ = force; }
    /// The next that has arrived; it is waited for.
    std::optional<Message> next(std::chrono::microseconds patience);
    /// What was on its way is gone, as when a connection is made anew.
    void clear();

    // The test's.
    double force() const { return force_; }
    /// How long ago the device's word of this place had come, s; infinite: it has not told it. What came
    /// damaged may have told any place.
    double age_of(const glm::dvec3& place) const;
    /// How long ago the last word came that may have told a place.
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

}  // namespace touchable::test
