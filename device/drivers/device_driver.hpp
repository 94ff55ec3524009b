#pragma once

// What a backend is written against: the driver's interface, what goes between it and DrivenDevice, and the
// bytes below it (docs/devices.md, "Add a device in an afternoon").

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

/// Of a finger that has no position now.
inline constexpr glm::dvec3 no_place(std::numeric_limits<double>::quiet_NaN());

/// What one message of a device says. Device metres, as HapticDevice has them.
struct DeviceSample {
    static constexpr std::size_t most_fingers = 10;

    std::array<glm::dvec3, most_fingers> metres{};
    std::uint32_t buttons = 0;  ///< one bit for each that is pressed
    std::int64_t kept_ns = 0;   ///< for how long the driver has had it, waiting for a newer one
};

/// Bytes that leave a device without force, and where another process can write them (SafetyWatchdog). They
/// are written twice: the first time this process may have been ended in the middle of a message.
struct ZeroForcePacket {
    int descriptor = -1;  ///< of an open file, socket or USB device
    std::vector<std::byte> bytes{};
    std::optional<std::uint8_t> usb_endpoint{};  ///< of a usbfs descriptor; nothing: written by write(2)
    /// Sent in place of `bytes` where the process stands still but may go on; empty: `bytes` are sent then
    /// too.
    std::vector<std::byte> meanwhile{};
};

/// Of a driver, so that a test may have time pass as it likes: ns that do not go back, never 0.
using DriverClock = std::function<std::int64_t()>;

/// Carries a device's bytes, whatever they mean. One thread's. A call that fails says why (ErrorKind::device)
/// and what it was that failed; the device is taken for gone then.
class Transport : NonCopyable {
public:
    virtual ~Transport() = default;

    /// All of it, or an error. A transport of messages (HID reports, WebSocket) sends one.
    virtual Result<void> send(std::span<const std::byte> bytes) = 0;
    /// How many bytes came, at most `room`'s; of messages one. Waits for them `patience` at most. 0: none.
    virtual Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) = 0;
    /// Drops what has come and was not received; into `room`, of the longest message.
    Result<void> drop_what_came(std::span<std::byte> room) {
        for (int most = 256; most > 0; --most) {  // whatever babbles must not hold the thread
            const auto came = receive(room, std::chrono::microseconds(0));
            if (!came) return came.error();
            if (*came == 0) break;
        }
        return {};
    }
    /// The descriptor that poll(2) reports as readable once something has come; -1: there is none.
    virtual int descriptor() const { return -1; }
};

/// A backend: it knows one kind of hardware and its bytes. `DrivenDevice` makes a HapticDevice of it, keeps
/// the safety contract, and calls it from one thread of its own, so it may wait where it says so. A call that
/// fails says why in one line (ErrorKind::device); then comes `disconnect`, and perhaps another `connect`.
class DeviceDriver : NonCopyable {
public:
    virtual ~DeviceDriver() = default;

    virtual std::string name() const = 0;
    virtual int fingers() const { return 1; }  ///< 1 to DeviceSample::most_fingers
    virtual DeviceLimits limits() const = 0;
    virtual DeviceCapabilities capabilities() const = 0;

    /// Takes hold of the hardware, which has no force afterwards. Waits as long as that takes; once
    /// stop_requested (engine/base/threads.hpp) says so, it ends within a tenth of a second with
    /// interrupted_error().
    virtual Result<void> connect() = 0;
    /// Sends zero force if anything can still be sent, and lets go. Does nothing where not connected.
    virtual void disconnect() noexcept = 0;

    /// Of every finger; finite, no longer than `limits` say. Waits no longer than a transfer takes.
    virtual Result<void> send(std::span<const glm::dvec3> newtons) = 0;
    /// What has come since; waits for it `patience` at most. False: nothing, and `sample` is as it was.
    virtual Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) = 0;

    /// Drops what has come, and expects no answer to what was sent before. It is called after this process
    /// stood still: the watchdog's process has sent zero force in its place, and the hardware answered that.
    virtual Result<void> forget_what_came() { return {}; }

    /// The descriptor that poll(2) reports as readable once something has come; `receive` is called then
    /// alone, so `send` has to notice a device that is silent. -1: there is none, and `receive` itself waits.
    virtual int descriptor() const { return -1; }
    /// What another process sends to leave the device without force; valid while connected. Nothing: no other
    /// process can.
    virtual std::optional<ZeroForcePacket> zero_force_packet() const { return std::nullopt; }
    /// Reports that came and were left out, so far: damaged, too short, not newer. -1: it does not count
    /// them.
    virtual std::int64_t left_out() const { return -1; }
    /// Whether nothing will come any more, as of a log that was replayed to its end.
    virtual bool is_over() const { return false; }
    /// HapticDevice::prompt: "pull the grip out, then push it in"; empty: nothing.
    virtual std::string prompt() const { return {}; }
    /// Any thread: why no position ever came; empty: it knows no more than `prompt` says.
    virtual std::string why_no_position() const { return {}; }
};

}  // namespace touchable
