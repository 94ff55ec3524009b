#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/haptic_device.hpp"

namespace touchable {

/// What a device told at once. Device metres, as HapticDevice has them.
struct DeviceSample {
    static constexpr std::size_t most_fingers = 10;

    std::array<glm::dvec3, most_fingers> metres{};  ///< not a number: this finger has no position now
    std::uint32_t buttons = 0;                      ///< one bit for each that is pressed
    std::int64_t kept_ns = 0;  ///< for how long the driver has had it, waiting for a newer one
};

/// Bytes that leave a device without force, and where another process can write them (SafetyWatchdog).
struct ZeroForcePacket {
    int descriptor = -1;  ///< of an open file, socket or USB device
    std::vector<std::byte> bytes{};
    std::optional<std::uint8_t> usb_endpoint{};  ///< of a usbfs descriptor; nothing: written by write(2)
    std::vector<std::byte>
        meanwhile{};  ///< for a process that may go on, unlike one that is gone; empty: `bytes`
};

/// Whether whoever waits wants it no more; asked now and then by calls that wait long.
using GivenUp = std::function<bool()>;

/// A backend: it knows one kind of hardware and its bytes. `DrivenDevice` makes a HapticDevice of it, keeps
/// the safety contract, and calls it from one thread of its own, so it may wait where it says so. A call that
/// fails says why in one line (ErrorKind::device); then comes `disconnect`, and perhaps another `connect`.
class DeviceDriver {
public:
    DeviceDriver() = default;
    DeviceDriver(const DeviceDriver&) = delete;
    DeviceDriver& operator=(const DeviceDriver&) = delete;
    virtual ~DeviceDriver() = default;

    virtual std::string name() const = 0;
    virtual int fingers() const = 0;  ///< 1 to DeviceSample::most_fingers
    virtual DeviceLimits limits() const = 0;
    virtual DeviceCapabilities capabilities() const = 0;

    /// Takes hold of the hardware, which has no force afterwards. Waits as long as that takes, and gives up
    /// (ErrorKind::interrupted) within a tenth of a second.
    virtual Result<void> connect(const GivenUp& given_up) = 0;
    /// Sends zero force if anything can still be sent, and lets go. Does nothing where not connected.
    virtual void disconnect() noexcept = 0;

    /// Of every finger; finite, no longer than `limits` say. Waits no longer than a transfer takes.
    virtual Result<void> send(std::span<const glm::dvec3> newtons) = 0;
    /// What has come since; waits for it `patience` at most. False: nothing, and `sample` is as it was.
    virtual Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) = 0;

    /// What has come is dropped, and nothing is taken for unanswered: while this process stood still another
    /// one spoke to the hardware in its place, whose answers nobody asked for.
    virtual Result<void> forget_what_came() { return {}; }

    /// What poll(2) tells of that something has come. -1: there is no such thing, `receive` waits by itself.
    virtual int descriptor() const { return -1; }
    /// For a process that outlives this one, as long as it is connected. Nothing: it has none.
    virtual std::optional<ZeroForcePacket> zero_force_packet() const { return std::nullopt; }
    /// Reports that came and were left out, so far: damaged, too short, not newer. -1: it does not count
    /// them.
    virtual std::int64_t left_out() const { return -1; }
    /// Whether nothing will come any more, as of a log that has been told to its end.
    virtual bool is_over() const { return false; }
    /// What it waits for, for the person who holds it ("pull the grip out, then push it in"); empty: nothing.
    virtual std::string prompt() const { return {}; }
    /// Any thread: what it knows of why no position ever came; empty: no more than `prompt` says.
    virtual std::string why_no_position() const { return {}; }
};

}  // namespace touchable
