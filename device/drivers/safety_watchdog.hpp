// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <sys/types.h>

#include <limits>

#include "device/drivers/device_driver.hpp"
#include "engine/base/result.hpp"
#include "engine/base/threads.hpp"

namespace touchable {

/// Shared memory of a device's thread and the watchdog's process. Each writes its own member first and reads
/// the other's afterwards: if the process sends zero force while the thread beats, at least one of them
/// notices.
struct Heartbeat {
    /// Without a beat for this time, the device is made unpowered.
    static constexpr std::int64_t longest_ns = 20'000'000;

    std::atomic<std::int64_t> beat_ns{0};    ///< the thread's newest beat, `boot_ns`; 0: none is expected yet
    std::atomic<std::uint32_t> silences{0};  ///< how often the process has made the device unpowered
};
static_assert(std::atomic<std::int64_t>::is_always_lock_free, "two processes share it");

/// When the watchdog's process has to send zero force to a device whose thread does not beat.
class HeartWatch {
public:
    /// Zero-force packets of one silence, `longest_ns` apart. More than one, because a thread that resumes
    /// and stops again before its next beat may have sent another force.
    static constexpr int most_packets = 20;
    static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::max();

    /// When the next packet is due if `beat_ns` stays the newest beat; `never`: no packet is due.
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

/// Tells a device's thread whether the watchdog's process stands still, from that process's count of beats.
/// At most `Heartbeat::longest_ns` counts between two looks: while the thread itself stood still, as on a
/// machine that slept, it cannot know what the process did.
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

struct WatchdogHeartbeats;

/// A small process that leaves devices without force when this one cannot: after this process has ended in
/// any way (signal, abort, kill), and while the thread that drives a device stands still (stopped, swapped
/// out, dumped). The small process holds the devices' descriptors and their zero-force packets. It sends
/// those once the last other end of its socket is closed, or a thread's heartbeat is missing. It does not
/// help if the whole machine stops.
class SafetyWatchdog : NonCopyable {
public:
    static constexpr int most_devices = 8;
    static constexpr std::size_t most_bytes = 512;  ///< of a packet

    /// Forks. Best called early: the process keeps a copy of this one's memory at that time, as far as either
    /// writes to it later. Error (internal): no process can be started.
    static Result<std::shared_ptr<SafetyWatchdog>> start();
    ~SafetyWatchdog();  ///< ends the process within two seconds; it sends zero force to devices that are
                        ///< still kept

    pid_t process() const { return process_; }
    /// Error (device): it is gone or stands still, which only a person or the system can have caused; it is
    /// not relied on afterwards. Any thread.
    Result<void> health() const;

    /// A device that the process looks after, until this is destroyed.
    class Kept : NonCopyable {
    public:
        ~Kept();
        /// Sets what to send, and to which descriptor. To be set again for hardware that came back: its new
        /// descriptor may have the old one's number. No beat is expected until the first one comes.
        Result<void> set_packet(const ZeroForcePacket& packet);
        /// Called by the device's thread before each send: the thread is alive. After the first beat, others
        /// are expected, `Heartbeat::longest_ns` apart at most. False: the process has made the device
        /// unpowered since the last beat, so the thread has to begin anew. Error (device):
        /// SafetyWatchdog::health's.
        Result<bool> beat();
        /// Whether the next `beat` will return false.
        bool was_made_unpowered() const;

    private:
        friend class SafetyWatchdog;
        Kept(std::shared_ptr<SafetyWatchdog> watchdog, std::size_t place)
            : watchdog_(std::move(watchdog)), place_(place) {}
        const std::shared_ptr<SafetyWatchdog> watchdog_;
        const std::size_t place_;
        std::uint32_t silences_ = 0;  // count that is known
        WatchdogMonitor watch_;
    };
    /// Error (device): `most_devices` are already kept.
    static Result<std::unique_ptr<Kept>> keep(std::shared_ptr<SafetyWatchdog> watchdog);

private:
    SafetyWatchdog(int socket, pid_t process, WatchdogHeartbeats& hearts)
        : socket_(socket), process_(process), hearts_(hearts) {}
    Result<void> give_order(std::size_t place, const ZeroForcePacket* packet);
    bool is_done(std::uint32_t number) const;

    const int socket_;
    const pid_t process_;
    WatchdogHeartbeats& hearts_;
    std::atomic<bool> stands_still_{false};
    std::mutex mutex_;  // threads of several devices
    bool taken_[most_devices] = {};
    std::uint32_t orders_ = 0;  // number of orders given
};

}  // namespace touchable
