// SPDX-License-Identifier: Apache-2.0
#pragma once

// WoodenHaptics and Polhem: their parameter files, linkage and reports, up to `--device woodenhaptics:`.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "device/drivers/device_driver.hpp"
#include "device/drivers/hid_transport.hpp"

namespace touchable {

// ---- Parameter files

/// One of the three motors, and the joint that it turns by a cable. Signs matter.
struct WoodenJoint {
    double counts_per_turn = 0;  ///< of the motor, quadrupled; negative: they fall as the joint's angle grows
    double cable_ratio = 0;      ///< the joint's turn for one of the motor's: capstan over drum, 0 to 1
    double torque_constant = 0;  ///< N m/A; negative: a positive current turns the joint back
    double most_amperes = 0;     ///< limit of its motor and amplifier
    std::int16_t home_counts = 0;  ///< its counter's value in the home pose
};

/// Parameters of one build of a WoodenHaptics or Polhem, from its parameter file (docs/devices.md).
struct WoodenParameters {
    enum class Homing {
        start,  ///< it is opened in the home pose
        button  ///< it is in the home pose when its board's button is pressed
    };
    std::string name;
    bool drive = false;  ///< false: its motors get no current, whatever the force
    std::array<WoodenJoint, 3> joints{};
    std::array<double, 3> links{};  ///< m: from the base up to the second joint, then both moving links
    glm::dvec3 origin{0.0};  ///< m, the workspace's centre: x to the person, y right, z up, from the base
    double reach = 0;        ///< m to each side of `origin`
    DeviceLimits limits{};
    Homing homing = Homing::start;
};

/// Parses a parameter file. Refuses (ErrorKind::input) what is missing, unknown or out of range; `where` is
/// the file's name, for the message.
Result<WoodenParameters> parse_wooden_parameters(std::string_view json, std::string_view where);
Result<WoodenParameters> read_wooden_parameters(const std::filesystem::path& file);

// ---- Kinematics

/// Angles of the three joints, rad: the base's turn about the vertical, then both links', each measured on
/// its own and not from the link before (both motors stand in the base's body). The second link points up at
/// 0, the third down; both towards the person at a quarter turn.
glm::dvec3 wooden_angles(const WoodenParameters& build, const std::array<std::int16_t, 3>& counts);

/// Position of the handle, device metres: axes and workspace as in HapticDevice.
glm::dvec3 wooden_place(const WoodenParameters& build, const glm::dvec3& angles);
/// d place / d angles: one column for each joint, m/rad.
glm::dmat3 wooden_jacobian(const WoodenParameters& build, const glm::dvec3& angles);

/// Currents, mA, that make the handle exert a finite force. If a motor would need more than its limit, all
/// three are reduced by the same factor: the force is smaller and keeps its direction.
std::array<std::int16_t, 3> wooden_currents(const WoodenParameters& build, const glm::dvec3& angles,
                                            const glm::dvec3& newtons);

// ---- Reports

/// What the board of a WoodenHaptics or a Polhem reports: 14 bytes without a report number, seven 16-bit
/// integers, low byte first. It sends one report for each that it receives.
struct WoodenReading {
    static constexpr std::size_t bytes = 14;

    std::array<std::int16_t, 6> encoders{};  ///< counters, quadrupled counts; the first three move the handle
    std::int16_t info = 0;                   ///< 1: its button was pressed, to have the counters set
};

/// Refuses (ErrorKind::device) any other number of bytes.
Result<WoodenReading> decode_wooden_reading(std::span<const std::byte> report);

/// A report to the board, as HID takes it: a 0 in place of the report number, then seven 16-bit integers. It
/// takes effect for half a second at most.
using WoodenReport = std::array<std::byte, 1 + 14>;
/// Command 0: currents of the three motors, mA.
WoodenReport encode_wooden_currents(const std::array<std::int16_t, 3>& milliamperes);
/// Command 1: no currents; sets the board's six counters, and its button counts as not pressed.
WoodenReport encode_wooden_counters(const std::array<std::int16_t, 6>& counters);

// ---- The driver and its keys

/// A WoodenHaptics or Polhem through its board's HID reports. It has no position, and its motors get no
/// current, until it was in its home pose; they get none, either, if its parameter file forbids driving.
/// After a disconnection its pose is unknown: only its board's button makes it known again. The board's own
/// watchdog takes the currents away half a second after the last report.
class WoodenHapticsDriver final : public DeviceDriver {
public:
    static constexpr std::int64_t silent_ns = 1'000'000'000;  ///< without a valid report it counts as gone
    static constexpr int sure_of_button = 3;  ///< consecutive readings; a single one may be damaged
    static constexpr int home_slack = 500;    ///< counts that a hand may have moved it while they were set

    /// `is_homed`: for a build with a button, it was pressed since the board's power-up.
    WoodenHapticsDriver(const WoodenParameters& build, bool is_homed, OpenReports open,
                        DriverClock clock = boot_ns)
        : build_(build), is_homed_(is_homed), open_(std::move(open)), clock_(std::move(clock)) {}
    ~WoodenHapticsDriver() override { disconnect(); }

    std::string name() const override {
        return build_.name + (build_.drive ? "" : " (exerts no force: \"drive\" is \"no\" in its file)");
    }
    DeviceLimits limits() const override { return build_.limits; }
    DeviceCapabilities capabilities() const override {
        return {.axes_driven = build_.drive ? 3 : 0,
                .reach = glm::dvec3(build_.reach),
                .rate_hz = 1000,
                .own_watchdog = true,
                .answers = true};
    }
    Result<void> connect() override;
    void disconnect() noexcept override;
    Result<void> send(std::span<const glm::dvec3> newtons) override {
        // The board remembers its button until its counters are set.
        if (homed_ != Homed::yes && pressed_ >= sure_of_button) return set_counters();
        const bool lives = build_.drive && has_place();
        return transport_->send(encode_wooden_currents(lives ? wooden_currents(build_, angles(), newtons[0])
                                                             : std::array<std::int16_t, 3>{}));
    }
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    Result<void> forget_what_came() override {
        std::array<std::byte, 65> room;
        read_ns_ = clock_();  // the silence timeout starts anew
        return transport_->drop_what_came(room);
    }
    std::optional<ZeroForcePacket> zero_force_packet() const override {
        if (!transport_ || transport_->spare_descriptor() < 0) return std::nullopt;
        const auto unpowered = encode_wooden_currents({});
        return ZeroForcePacket{transport_->spare_descriptor(), {unpowered.begin(), unpowered.end()}, {}, {}};
    }
    std::string prompt() const override {
        if (homed_ == Homed::yes) return {};
        if (build_.homing == WoodenParameters::Homing::start)
            return "it was away: put the handle in its home pose, and press the button of its board or start "
                   "anew";
        return "put the handle in its home pose, and press the button of its board";
    }

    std::int64_t left_out() const override { return left_out_; }  ///< invalid reports so far

private:
    /// Progress of homing.
    enum class Homed { no, counters_sent, yes };

    Result<bool> read_newest(std::chrono::microseconds patience);
    Result<void> await_reading(const std::function<bool()>& is_right, const char* otherwise);
    Result<void> set_counters() {
        std::array<std::int16_t, 6> counters{};
        for (std::size_t joint = 0; joint < 3; ++joint) counters[joint] = build_.joints[joint].home_counts;
        homed_ = Homed::counters_sent;
        return transport_->send(encode_wooden_counters(counters));
    }
    /// A pressed button announces new angles; a button that is released after the counters were sent confirms
    /// them.
    void look_at_button() {
        if (pressed_ >= sure_of_button && homed_ == Homed::yes) homed_ = Homed::no;
        if (reading_.info == 0 && homed_ == Homed::counters_sent)
            homed_ = is_at_home() ? Homed::yes : Homed::no;
    }
    bool has_place() const { return homed_ == Homed::yes && reading_.info == 0; }
    bool is_at_home() const {
        for (std::size_t joint = 0; joint < 3; ++joint)
            if (std::abs(reading_.encoders[joint] - build_.joints[joint].home_counts) > home_slack)
                return false;
        return true;
    }
    glm::dvec3 angles() const {
        return wooden_angles(build_, {reading_.encoders[0], reading_.encoders[1], reading_.encoders[2]});
    }

    const WoodenParameters build_;
    const bool is_homed_;
    const OpenReports open_;
    const DriverClock clock_;
    std::unique_ptr<ReportTransport> transport_;
    bool was_held_ = false;  // it was connected before
    int pressed_ = 0;        // consecutive readings with a pressed button
    Homed homed_ = Homed::no;
    WoodenReading reading_;
    std::int64_t read_ns_ = 0;
    std::int64_t left_out_ = 0;
};

struct WoodenSettings {
    std::string node;  ///< empty: the first that is connected
    std::filesystem::path file;
    bool homed = false;
};

/// Whether the ids are those of WoodenHaptics' firmware (1234:0006, which other boards of its kind share).
bool is_woodenhaptics(std::uint16_t vendor, std::uint16_t product);

/// Settings of "woodenhaptics:file=FILE[,key=value,...]" (docs/devices.md). Refuses (ErrorKind::usage)
/// invalid keys and a missing file key.
Result<WoodenSettings> read_wooden_settings(std::string_view keys);
/// Error (input) also if the file cannot be read or is no parameter file.
Result<std::unique_ptr<DeviceDriver>> make_woodenhaptics_driver(std::string_view keys);

}  // namespace touchable
