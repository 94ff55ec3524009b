#pragma once

#include <sys/types.h>

#include <atomic>
#include <memory>
#include <mutex>

#include "device/device_driver.hpp"
#include "device/watchdog_process.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// A small process beside this one that leaves devices without force when this one cannot: when this process
/// is gone, however it ended (by a signal, by abort, killed), and while the thread that drives a device
/// stands still, because it is stopped, swapped out or dumped. The small process holds the devices'
/// descriptors and the bytes that leave them unpowered. It sends those once the last other end of its socket
/// is closed, or once a thread's heartbeat is missing. It does not help where the whole machine stops.
class SafetyWatchdog {
public:
    static constexpr int most_devices = WatchdogOrder::most_devices;
    static constexpr std::size_t most_bytes = WatchdogOrder::most_bytes;

    /// Forks. Best done early: it keeps a copy of what this process has in memory by then, as long as neither
    /// writes to it. Error (internal): no process can be had.
    static Result<std::shared_ptr<SafetyWatchdog>> start();
    ~SafetyWatchdog();  ///< the process ends, in two seconds at most, and sends zero force to what it still
                        ///< keeps
    SafetyWatchdog(const SafetyWatchdog&) = delete;
    SafetyWatchdog& operator=(const SafetyWatchdog&) = delete;

    pid_t process() const { return process_; }
    /// Error (device): it is gone or stands still, which nobody but a person or the system can have done.
    /// From then on it is not relied on any more. Any thread.
    Result<void> health() const;

    /// A device that the process looks after, until this is destroyed.
    class Kept {
    public:
        Kept(Kept&& other) noexcept
            : watchdog_(std::move(other.watchdog_)),
              place_(other.place_),
              silences_(other.silences_),
              watch_(other.watch_) {}
        Kept& operator=(Kept&& other) noexcept;
        ~Kept();
        /// What to send, and to which descriptor, in place of the last. To be set again for hardware that
        /// came back: its new descriptor may have the old one's number. From here on no beat is expected
        /// until the first one comes.
        Result<void> set_packet(const ZeroForcePacket& packet);
        /// To be called by the device's thread before it sends anything: the thread is alive. From the first
        /// beat on others are expected, `Heartbeat::longest_ns` apart at most. False: the process has made
        /// the device unpowered since the last beat, so the thread has to begin anew. Error (device):
        /// SafetyWatchdog::health's.
        Result<bool> beat();
        /// Whether the next `beat` will return false.
        bool was_made_unpowered() const;

    private:
        friend class SafetyWatchdog;
        Kept(std::shared_ptr<SafetyWatchdog> watchdog, std::size_t place)
            : watchdog_(std::move(watchdog)), place_(place) {}
        std::shared_ptr<SafetyWatchdog> watchdog_;
        std::size_t place_ = 0;
        std::uint32_t silences_ = 0;  // that are known of
        WatchdogMonitor watch_;
    };
    /// Error (device): `most_devices` are kept already.
    static Result<Kept> keep(std::shared_ptr<SafetyWatchdog> watchdog);

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
    std::uint32_t orders_ = 0;  // that were given
};

}  // namespace touchable
