// SPDX-License-Identifier: Apache-2.0
#pragma once

// Interfaces of a backend: the driver, the data between it and DrivenDevice, and the byte transport below it
// (docs/devices.md, "Add a device in an afternoon").

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <limits>
#include <span>

#include "device/haptic_device.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// Position of a finger that has none.
inline constexpr glm::dvec3 no_place(std::numeric_limits<double>::quiet_NaN());

/// Content of one message of a device; positions in device metres, as in HapticDevice.
struct DeviceSample {
    static constexpr std::size_t most_fingers = 10;

    std::array<glm::dvec3, most_fingers> metres{};
    std::uint32_t buttons = 0;  ///< one bit per pressed button
    std::int64_t kept_ns = 0;   ///< time that the driver held it, waiting for a newer one
};

/// Bytes that leave a device without force, and where another process can write them (SafetyWatchdog). They
/// are written twice, because this process may have ended in the middle of a message.
struct ZeroForcePacket {
    int descriptor = -1;  ///< of an open file, socket or USB device
    std::vector<std::byte> bytes{};
    std::optional<std::uint8_t> usb_endpoint{};  ///< of a usbfs descriptor; nothing: use write(2)
    /// Sent instead of `bytes` if the process stands still but may go on; empty: `bytes` are sent.
    std::vector<std::byte> meanwhile{};
};

/// Clock of a driver, ns; never goes back, never 0. Tests replace it with virtual time.
using DriverClock = std::function<std::int64_t()>;

/// Carries a device's bytes, whatever they mean. Used by one thread. A failed call returns an error
/// (ErrorKind::device) that names what failed; the device then counts as gone.
class Transport : NonCopyable {
public:
    virtual ~Transport() = default;

    /// Sends all bytes, or returns an error. A message transport (HID reports, WebSocket) sends one message.
    virtual Result<void> send(std::span<const std::byte> bytes) = 0;
    /// Receives up to room.size() bytes, or one message; waits `patience` at most. Returns their number; 0:
    /// none.
    virtual Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) = 0;
    /// Drops bytes that came but were not read; `room` must hold the longest message.
    Result<void> drop_what_came(std::span<std::byte> room) {
        for (int most = 256; most > 0; --most) {  // bounded: endless data must not hold the thread
            const auto came = receive(room, std::chrono::microseconds(0));
            if (!came) return came.error();
            if (*came == 0) break;
        }
        return {};
    }
    /// Descriptor that poll(2) reports as readable when data has come; -1: none.
    virtual int descriptor() const { return -1; }
};

/// A backend: knows one kind of hardware and its bytes. `DrivenDevice` makes a HapticDevice of it, keeps the
/// safety contract, and calls it from one own thread, so calls may wait as documented. A failed call returns
/// a one-line error (ErrorKind::device); `disconnect` follows, and perhaps another `connect`.
class DeviceDriver : NonCopyable {
public:
    virtual ~DeviceDriver() = default;

    virtual std::string name() const = 0;
    virtual int fingers() const { return 1; }  ///< 1 to DeviceSample::most_fingers
    virtual DeviceLimits limits() const = 0;
    virtual DeviceCapabilities capabilities() const = 0;

    /// Opens the hardware and leaves it without force. Waits as long as that takes; returns
    /// interrupted_error() within 0.1 s of stop_requested (engine/base/threads.hpp).
    virtual Result<void> connect() = 0;
    /// Sends zero force if anything can still be sent, and closes. No effect if not connected.
    virtual void disconnect() noexcept = 0;

    /// Sends a force for every finger, finite and within `limits`. Waits no longer than a transfer takes.
    virtual Result<void> send(std::span<const glm::dvec3> newtons) = 0;
    /// Receives a new sample; waits `patience` at most. False: none came, and `sample` is unchanged.
    virtual Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) = 0;

    /// Drops received data and expects no answer to earlier messages. Called after this process stood still:
    /// the watchdog's process has sent zero force meanwhile, and the hardware has answered that.
    virtual Result<void> forget_what_came() { return {}; }

    /// Descriptor that poll(2) reports as readable when data has come; `receive` is called only then, so
    /// `send` must notice a silent device. -1: none, and `receive` itself waits.
    virtual int descriptor() const { return -1; }
    /// Packet with which another process leaves the device without force; valid while connected. Nothing: no
    /// other process can.
    virtual std::optional<ZeroForcePacket> zero_force_packet() const { return std::nullopt; }
    /// Count of reports left out: damaged, too short, not newer. -1: not counted.
    virtual std::int64_t left_out() const { return -1; }
    /// Whether no more data will come, as from a log that was replayed to its end.
    virtual bool is_over() const { return false; }
    /// HapticDevice::prompt, such as "pull the grip out, then push it in"; empty: none.
    virtual std::string prompt() const { return {}; }
    /// Any thread: why no position ever came; empty: no reason beyond `prompt`.
    virtual std::string why_no_position() const { return {}; }
};

}  // namespace touchable
