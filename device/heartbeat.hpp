#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>

#include "engine/base/boot_time.hpp"

namespace touchable {

/// What the thread that drives a device and the watchdog's process tell each other, in memory that both
/// share. Each writes its own member first and reads the other's afterwards. So where the process sends zero
/// force while the thread beats, at least one of them sees what the other did.
struct Heartbeat {
    /// Without a beat for so long, the device is made unpowered.
    static constexpr std::int64_t longest_ns = 20'000'000;

    std::atomic<std::int64_t> beat_ns{0};    ///< the thread's newest beat, `boot_ns`; 0: none is expected yet
    std::atomic<std::uint32_t> silences{0};  ///< how often the process has made the device unpowered
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "two processes share it");

/// When the watchdog's process has to send zero force to a device whose thread does not beat.
class HeartWatch {
public:
    /// Zero-force packets of one silence, `longest_ns` apart. More than one, because a thread that goes on
    /// and is stopped again before its next beat may have sent one more force.
    static constexpr int most_packets = 20;
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

    /// When the next packet is due if `beat_ns` stays the newest beat; `never`: none is.
    std::int64_t due_ns(std::int64_t beat_ns) {
        if (beat_ns != beat_ns_) {
            beat_ns_ = beat_ns;
            packets_ = 0;
        }
        if (beat_ns == 0 || packets_ == most_packets) return never;
        return (packets_ == 0 ? beat_ns : sent_ns_) + Heartbeat::longest_ns;
    }
    /// A packet was sent.
    void sent(std::int64_t now) {
        sent_ns_ = now;
        ++packets_;
    }

private:
    std::int64_t beat_ns_ = 0, sent_ns_ = 0;
    int packets_ = 0;
};

/// How a device's thread finds out that the watchdog's process itself stands still: by the process's own
/// count of beats. Time counts only up to `Heartbeat::longest_ns` after the thread last looked: while the
/// thread stood still too, as on a machine that slept, it cannot know what the process did.
class WatchdogMonitor {
public:
    static constexpr std::int64_t longest_ns = 1'000'000'000;  ///< long: a busy machine must not end a run

    /// Whether the process is alive; `beats`: its count at `now`.
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
