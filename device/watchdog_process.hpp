#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "device/heartbeat.hpp"

namespace touchable {

/// A message to the watchdog's process: what to send to one device. The device's descriptor comes with the
/// message (SCM_RIGHTS); a message without one says that the device is not to be looked after any more. The
/// process answers each message with its number, once it has done what the message says.
struct WatchdogOrder {
    static constexpr int most_devices = 8;
    static constexpr std::size_t most_bytes = 512;
    struct Packet {
        std::uint32_t bytes = 0;
        std::byte text[most_bytes] = {};
    };
    std::uint32_t number = 0;
    std::uint32_t place = 0;     ///< of the device and of its Heartbeat: below most_devices
    std::int32_t endpoint = -1;  ///< -1: write(2)
    Packet last, meanwhile;      ///< ZeroForcePacket's
};

/// In memory that both processes share.
struct WatchdogHeartbeats {
    std::array<Heartbeat, WatchdogOrder::most_devices> devices;
    std::atomic<std::uint32_t> watchdog_beats{
        0};  ///< counted up by the process while it looks after a device
};

/// All that the watchdog's process does, from its fork to its end. `command_line`: its own, as the system
/// shows it; it is overwritten, so that somebody who ends the program by its name does not end this process
/// too.
[[noreturn]] void watch_until_alone(int socket, WatchdogHeartbeats& hearts, std::span<char> command_line);

/// Where the system reads this process's command line from; empty: it does not say.
std::span<char> own_command_line();

}  // namespace touchable
