#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "device/heartbeat.hpp"

namespace touchable {

/// What is told to the process that leaves devices limp: of one device, with its descriptor beside it
/// (SCM_RIGHTS). Without one, that the device needs nobody any more. It answers each with a byte once it is
/// done.
struct LimpOrder {
    static constexpr int most_devices = 8;
    static constexpr std::size_t most_bytes = 512;
    struct Word {
        std::uint32_t bytes = 0;
        std::byte text[most_bytes] = {};
    };
    std::uint32_t place = 0;     ///< the device's, and its heart's: below most_devices
    std::int32_t endpoint = -1;  ///< -1: write(2)
    Word last, meanwhile;        ///< LastWord's
};

/// That process, from its fork to its end. `hearts`: of the devices, shared. `command_line`: its own, which
/// it covers, so that whoever ends the program by its name does not end this one with it.
[[noreturn]] void keep_limp_until_alone(int socket, std::span<Heartbeat> hearts,
                                        std::span<char> command_line);

/// Where the system reads this process's command line from; empty: it does not say.
std::span<char> own_command_line();

}  // namespace touchable
