#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>

#include "engine/boot_time.hpp"

namespace touchable {

/// Of the thread that speaks with a device, in memory that it shares with the process that leaves the device
/// unpowered. Both sides write their own member first and read the other's afterwards: where a word and a
/// beat meet, one of the two knows of the other.
struct Heartbeat {
    static constexpr std::int64_t longest_ns =
        20'000'000;  ///< without a beat; then the device is made unpowered

    std::atomic<std::int64_t> beat_ns{0};  ///< the newest, `boot_ns`; 0: none is expected yet
    std::atomic<std::uint32_t> silences{
        0};  ///< how often the device was made unpowered in the thread's place
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "two processes share it");

/// How a heart is watched. It decides nothing by its own clock alone: it may have been late itself.
class HeartWatch {
public:
    /// In one silence, a `longest_ns` apart: a thread that is stopped again before its next beat may have
    /// sent one more force.
    static constexpr int most_packets = 20;
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

    /// When a word is due, should there be no other beat than this newest one.
    std::int64_t due_ns(std::int64_t beat_ns) {
        if (beat_ns != beat_ns_) {
            beat_ns_ = beat_ns;
            packets_ = 0;
        }
        if (beat_ns == 0 || packets_ == most_packets) return never;
        return (packets_ == 0 ? beat_ns : sent_ns_) + Heartbeat::longest_ns;
    }
    void sent(std::int64_t now) {
        sent_ns_ = now;
        ++packets_;
    }

private:
    std::int64_t beat_ns_ = 0, sent_ns_ = 0;
    int packets_ = 0;
};

/// How the process that watches hearts is watched itself, by each of those threads. A moment counts only
/// where the thread looked shortly before: whoever stood still itself, as on a machine that slept, knows
/// nothing of others meanwhile.
class WatchdogMonitor {
public:
    static constexpr std::int64_t longest_ns = 1'000'000'000;  ///< long: a busy machine must not end a run

    /// Whether it lives, by the number of its beats at this moment.
    bool is_alive(std::uint32_t beats, std::int64_t now) {
        const std::int64_t watched_ns = std::min(now - looked_ns_, Heartbeat::longest_ns);
        silent_ns_ = beats == beats_ ? silent_ns_ + watched_ns : 0;
        beats_ = beats;
        looked_ns_ = now;
        return silent_ns_ <= longest_ns;
    }

private:
    std::uint32_t beats_ = 0;
    std::int64_t looked_ns_ = 0, silent_ns_ = 0;
};

}  // namespace touchable
