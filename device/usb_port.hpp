#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/result.hpp"

namespace touchable {

/// What a serial converter by FTDI is told beside the bytes that it passes on: a vendor's control request
/// without data (type 0x40, index 0).
struct FtdiCommand {
    std::uint8_t request = 0;
    std::uint16_t value = 0;
    bool operator==(const FtdiCommand&) const = default;
};

/// A USB device that is one's own, whatever carries its packets. One thread's. A call that fails says why in
/// one line (ErrorKind::device); the device is taken for gone then.
class UsbPort {
public:
    UsbPort() = default;
    UsbPort(const UsbPort&) = delete;
    UsbPort& operator=(const UsbPort&) = delete;
    virtual ~UsbPort() = default;  ///< lets go of it

    static constexpr std::size_t packet_bytes = 64;  ///< most that come at once

    virtual Result<void> command(const FtdiCommand& command) = 0;
    virtual Result<void> write(std::span<const std::byte> bytes) = 0;
    /// One packet, into room for `packet_bytes`. Waits for it `patience` at most. 0: none.
    virtual Result<std::size_t> read(std::span<std::byte> room, std::chrono::microseconds patience) = 0;
    /// Of usbfs; -1: there is none.
    virtual int usbfs() const { return -1; }
};

}  // namespace touchable
