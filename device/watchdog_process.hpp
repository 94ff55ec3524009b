#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>

#include "device/heartbeat.hpp"

namespace touchable {

/// What is told to the process that leaves devices unpowered: of one device, with its descriptor beside it
/// (SCM_RIGHTS). Without one, that the device needs nobody any more. It answers each with its number once it
/// is done.
struct WatchdogOrder {
    static constexpr int most_devices = 8;
    static constexpr std::size_t most_bytes = 512;
    struct Packet {
        std::uint32_t bytes = 0;
        std::byte text[most_bytes] = {};
    };
    std::uint32_t number = 0;
    std::uint32_t place = 0;     ///< the device's, and its heart's: below most_devices
    std::int32_t endpoint = -1;  ///< -1: write(2)
    Packet last, meanwhile;      ///< ZeroForcePacket's
};

/// In memory that both processes share.
struct WatchdogHeartbeats {
    std::array<Heartbeat, WatchdogOrder::most_devices> devices;
    std::atomic<std::uint32_t> watchdog_beats{0};  ///< that process's own, as long as it keeps a device
};

/// That process, from its fork to its end. `command_line`: its own, which it covers, so that whoever ends the
/// program by its name does not end this one with it.
[[noreturn]] void watch_until_alone(int socket, WatchdogHeartbeats& hearts, std::span<char> command_line);

/// Where the system reads this process's command line from; empty: it does not say.
std::span<char> own_command_line();

}  // namespace touchable
