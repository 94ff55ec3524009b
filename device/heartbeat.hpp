#pragma once

#include <atomic>
#include <cstdint>
#include <limits>

#include "engine/boot_time.hpp"

namespace touchable {

/// Of the thread that speaks with a device, in memory that it shares with the process that leaves the device
/// limp. Both sides write their own member first and read the other's afterwards: where a word and a beat
/// meet, one of the two knows of the other.
struct Heartbeat {
    static constexpr std::int64_t longest_ns = 20'000'000;  ///< without a beat; then the device is made limp

    std::atomic<std::int64_t> beat_ns{0};    ///< the newest, `boot_ns`; 0: none is expected yet
    std::atomic<std::uint32_t> silences{0};  ///< how often the device was made limp in the thread's place
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "two processes share it");

/// How a heart is watched. It decides nothing by its own clock alone: it may have been late itself.
class HeartWatch {
public:
    /// In one silence, a `longest_ns` apart: a thread that is stopped again before its next beat may have
    /// sent one more force.
    static constexpr int most_words = 20;
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

    /// When a word is due, should there be no other beat than this newest one.
    std::int64_t due_ns(std::int64_t beat_ns) {
        if (beat_ns != heard_ns_) {
            heard_ns_ = beat_ns;
            words_ = 0;
        }
        if (beat_ns == 0 || words_ == most_words) return never;
        return (words_ == 0 ? beat_ns : spoken_ns_) + Heartbeat::longest_ns;
    }
    void spoke(std::int64_t now) {
        spoken_ns_ = now;
        ++words_;
    }

private:
    std::int64_t heard_ns_ = 0, spoken_ns_ = 0;
    int words_ = 0;
};

}  // namespace touchable
