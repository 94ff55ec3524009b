// SPDX-License-Identifier: Apache-2.0
#pragma once

// The Novint Falcon, from its USB cable up to `--device falcon:`.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string_view>

#include "device/drivers/device_driver.hpp"
#include "engine/base/result.hpp"

namespace touchable {

class ConnectedSystem;

// ---- USB

/// A command to an FTDI serial converter, apart from the bytes that it passes on: a vendor control request
/// without data (type 0x40, index 0).
struct FtdiCommand {
    std::uint8_t request = 0;
    std::uint16_t value = 0;
    bool operator==(const FtdiCommand&) const = default;

    // Encoded for FTDI's chips of this generation.
    /// Time to wait for a packet to become full, 1 to 255 ms.
    static FtdiCommand latency(std::chrono::milliseconds waits) {
        return {9, static_cast<std::uint16_t>(waits.count())};
    }
    /// Divisor of 3 MHz; bits 14 and 15: eighths.
    static FtdiCommand divisor(std::uint16_t encoded) { return {3, encoded}; }
    /// Eight data bits, no parity, one stop bit.
    static FtdiCommand eight_bits() { return {4, 8}; }
    static FtdiCommand no_flow_control() { return {2, 0}; }
    static FtdiCommand dtr(bool high) { return {1, static_cast<std::uint16_t>(high ? 0x101 : 0x100)}; }
    static FtdiCommand rts(bool high) { return {1, static_cast<std::uint16_t>(high ? 0x202 : 0x200)}; }
    static FtdiCommand purge_received() { return {0, 1}; }
    static FtdiCommand purge_to_send() { return {0, 2}; }
};

/// A USB device that is claimed, whatever carries its packets. Used by one thread. A failed call returns a
/// one-line error (ErrorKind::device); the device then counts as gone.
class UsbPort : NonCopyable {
public:
    virtual ~UsbPort() = default;  ///< closes the device

    static constexpr std::size_t packet_bytes = 64;  ///< largest packet received

    virtual Result<void> command(const FtdiCommand& command) = 0;
    virtual Result<void> write(std::span<const std::byte> bytes) = 0;
    /// Receives one packet into room for `packet_bytes`; waits `patience` at most. 0: none came.
    virtual Result<std::size_t> read(std::span<std::byte> room, std::chrono::microseconds patience) = 0;
    /// Descriptor of usbfs; -1: none.
    virtual int usbfs() const { return -1; }
};

/// Opens the first Novint Falcon that is plugged in, by bus and number, through libusb. Error
/// (ErrorKind::device): why it cannot be used, and what would change that.
Result<std::unique_ptr<UsbPort>> open_falcon(const ConnectedSystem& system);

// ---- The serial converter in it

/// Bytes through an FTDI converter, whose packets begin with two bytes of line state, which are no data.
class FtdiTransport final : public Transport {
public:
    static constexpr std::size_t state_bytes = 2;

    explicit FtdiTransport(std::unique_ptr<UsbPort> port, DriverClock clock = boot_ns)
        : port_(std::move(port)), clock_(std::move(clock)) {}

    Result<void> command(const FtdiCommand& command) { return port_->command(command); }
    /// Drops bytes that came but were not read, here and in the converter.
    Result<void> purge();
    Result<void> send(std::span<const std::byte> bytes) override { return port_->write(bytes); }
    Result<std::size_t> receive(std::span<std::byte> room, std::chrono::microseconds patience) override;
    int usbfs() const { return port_->usbfs(); }
    std::int64_t now_ns() const { return clock_(); }

private:
    std::unique_ptr<UsbPort> port_;
    DriverClock clock_;
    std::array<std::byte, UsbPort::packet_bytes> packet_{};
    std::size_t next_ = 0, end_ = 0;  // unread part of packet_
};

// ---- Firmware

/// Longest wait for an answer, per step.
struct FalconPatience {
    std::chrono::milliseconds greeting{60};
    std::chrono::milliseconds echo{500};
    std::chrono::milliseconds question{20};
};

/// Reads the Falcon's firmware from a file that the user names: its makers' licence does not let others pass
/// it on. Error (ErrorKind::input): no such file, or not the size of firmware.
Result<std::vector<std::byte>> read_falcon_firmware(const std::string& path);

/// Loads firmware into a Falcon, which has none after power-up; takes about two seconds. Compares the echo
/// byte by byte. Error (device): the step at which the answer was missing or different; (interrupted):
/// cancelled.
Result<void> load_falcon_firmware(FtdiTransport& transport, std::span<const std::byte> firmware,
                                  const FalconPatience& patience);

/// Sets the serial line for running firmware.
Result<void> begin_falcon_run(FtdiTransport& transport);

// ---- Packets

/// The packets of the Novint Falcon, as its owners have described them (libnifalcon's documentation): 16
/// bytes in each direction, '<', 14 that carry four bits each as 'A' + bits, '>'. The device answers each
/// packet with one; packets have no number, time or checksum.
inline constexpr std::size_t falcon_packet_bytes = 16;
using FalconPacket = std::array<std::byte, falcon_packet_bytes>;

/// Lamps in the Falcon's ring.
enum class FalconLamp : std::uint8_t { none = 0, green = 2, blue = 4, red = 8 };

struct FalconCommand {
    std::array<std::int16_t, 3> motors{};  ///< of the top, right and left arm
    FalconLamp lamp = FalconLamp::none;
};
/// Also requests the homing state, always: otherwise the Falcon does not follow its encoders.
FalconPacket encode(const FalconCommand& command);

struct FalconReport {
    std::array<std::int16_t, 3> counts{};  ///< of the top, right and left encoder
    std::uint8_t buttons = 0;              ///< bits 0 to 3: the grip's right, forward, middle, left button
    bool homed = false;  ///< all three encoders have met their marks, so counts give positions
};

/// Finds reports in bytes that may be cut, damaged or repeated: each '<' begins one, and a report with an
/// impossible byte is dropped.
class FalconReader {
public:
    /// Returns the report that this byte completes, if any.
    std::optional<FalconReport> take(std::byte byte);
    void forget() { filled_ = 0; }  ///< drops an incomplete report
    std::int64_t damaged() const { return damaged_; }

private:
    FalconPacket packet_{};
    std::size_t filled_ = 0;
    std::int64_t damaged_ = 0;
};

// ---- Kinematics

/// Geometry of the Novint Falcon, as its owners have measured it (libnifalcon, after Stamper's thesis, 1997):
/// three arms around an axis. A motor turns each arm in a plane through (about) the axis; a parallelogram at
/// the arm's end carries the grip without turning it. Order: top, right, left arm.
///
/// Positions are the grip's, in metres of the device: x right, y up, z towards the person, from the middle of
/// the reach, 0.125 m before the motors' plane.
inline constexpr double falcon_reach = 0.05;  ///< metres; radius of a ball that the grip fully reaches
inline constexpr double falcon_edge = 0.075;  ///< metres; no grip gets this far from the middle
using FalconAngles =
    std::array<double, 3>;  ///< radians, 0: the arm points outward; grows as the grip is pulled

/// Arm angle at an encoder count: 320 slots of four counts on the motor's shaft, whose capstan of 14.25 mm
/// turns the arm's drum of 110 mm; 35 degrees at 0.
double falcon_angle(std::int16_t count);

/// Closed form. Nothing if an arm does not reach.
std::optional<FalconAngles> falcon_angles(const glm::dvec3& place);

struct FalconPose {
    glm::dvec3 place{0.0};
    glm::dmat3 metres_per_radian{0.0};  ///< column: derivative of the position by that arm's angle
};
/// By Newton's method from `start`, converged to far below a nanometre. Nothing if the angles belong to no
/// position within `falcon_edge`, as those of damaged packets.
std::optional<FalconPose> falcon_pose(const FalconAngles& angles, const glm::dvec3& start = glm::dvec3(0.0));

/// Largest motor word sent: the cap of the public driver's description. What a motor bears is not published.
inline constexpr int falcon_largest_word = 4096;
/// Motor words whose torques exert that force, N. Words that are too large are scaled together, so the
/// direction stays. Their unit is not published: as with the public driver, one is -0.1 mN m of the arm's
/// torque.
std::array<std::int16_t, 3> falcon_motor_words(const FalconPose& pose, const glm::dvec3& newtons);

// ---- The driver and its keys

/// How a Falcon is used.
struct FalconSettings {
    std::vector<std::byte> firmware{};  ///< empty: none to load, so the device must have some
    DeviceLimits limits{8, 1000};       ///< N, N/m
    FalconPatience patience{};
};

/// Opens a Falcon that is plugged in. Error (ErrorKind::device): what would make it ready.
using FalconPlug = std::function<Result<std::unique_ptr<UsbPort>>()>;

/// A Novint Falcon. `connect` loads its firmware if it has none. There is then no position and no force until
/// a person has moved the grip over the encoders' marks (`prompt` says so).
class FalconDriver final : public DeviceDriver {
public:
    static constexpr std::uint8_t usb_endpoint_out = 0x02;
    static constexpr double silent_s = 0.25;  ///< without an answer, it then counts as gone
    static constexpr int homed_reports = 8;   ///< consecutive reports before homing counts

    FalconDriver(FalconSettings settings, FalconPlug plug, DriverClock clock = boot_ns)
        : settings_(std::move(settings)), plug_(std::move(plug)), clock_(std::move(clock)) {}
    ~FalconDriver() override { disconnect(); }

    std::string name() const override { return "Novint Falcon"; }
    DeviceLimits limits() const override { return settings_.limits; }
    DeviceCapabilities capabilities() const override {
        return {.reach = glm::dvec3(falcon_reach), .rate_hz = 1000, .buttons = 4, .answers = true};
    }
    Result<void> connect() override;
    void disconnect() noexcept override;
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    Result<void> forget_what_came() override;
    std::optional<ZeroForcePacket> zero_force_packet() const override {
        if (!transport_ || !runs_ || transport_->usbfs() < 0) return std::nullopt;
        const auto packet = encode(FalconCommand{});
        return ZeroForcePacket{transport_->usbfs(), {packet.begin(), packet.end()}, usb_endpoint_out, {}};
    }
    std::string prompt() const override;

    std::int64_t left_out() const override { return reader_.damaged(); }

private:
    bool is_homed() const { return homed_in_a_row_ >= homed_reports; }
    Result<void> command(const std::array<std::int16_t, 3>& motors) {
        FalconCommand command;
        command.motors = motors;
        command.lamp = is_homed() ? FalconLamp::green : FalconLamp::red;
        ++unanswered_;
        return transport_->send(encode(command));
    }
    Result<std::optional<FalconReport>> newest_report(std::chrono::microseconds patience);
    Result<bool> answers();
    Result<void> load();
    void take(const FalconReport& report, DeviceSample& sample);

    const FalconSettings settings_;
    const FalconPlug plug_;
    const DriverClock clock_;
    std::unique_ptr<FtdiTransport> transport_;
    bool runs_ = false;  // firmware runs, so motor words have a meaning
    FalconReader reader_;
    int unanswered_ = 0;
    std::int64_t received_ns_ = 0;
    int homed_in_a_row_ = 0, impossible_in_a_row_ = 0;
    std::optional<FalconPose> pose_;  // of the newest report
};

/// Settings of "falcon[:key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage) invalid keys and
/// (ErrorKind::input) a file that cannot be firmware.
Result<FalconSettings> read_falcon_settings(std::string_view keys);
Result<std::unique_ptr<DeviceDriver>> make_falcon_driver(std::string_view keys);

}  // namespace touchable
