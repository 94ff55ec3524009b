#pragma once

#include <functional>
#include <memory>
#include <string>

#include "device/device_driver.hpp"
#include "device/report_transport.hpp"
#include "device/steady_time.hpp"
#include "device/woodenhaptics_kinematics.hpp"
#include "device/woodenhaptics_protocol.hpp"

namespace touchable {

/// A WoodenHaptics or Polhem behind its board's HID reports. It has no place, and its motors no current,
/// until it was in its home pose; nor current where its parameter file says that it must not be driven. Once
/// it was away nobody knows its pose any more: then only the button of its board brings it home. The board's
/// own watchdog takes the currents away half a second after the last report.
class WoodenHapticsDriver final : public DeviceDriver {
public:
    static constexpr std::int64_t silent_ns = 1'000'000'000;  ///< without a sound report it is gone
    static constexpr int sure_of_button = 3;  ///< readings in a row that show it; one may be damaged
    static constexpr int home_slack = 500;    ///< counts that a hand may have moved while they were set

    using Open = std::function<Result<std::unique_ptr<ReportTransport>>()>;

    /// `is_homed`: of a build with a button, that it was pressed since the board got its power.
    WoodenHapticsDriver(const WoodenParameters& build, bool is_homed, Open open,
                        DriverClock clock = steady_ns);
    ~WoodenHapticsDriver() override { disconnect(); }

    std::string name() const override;
    int fingers() const override { return 1; }
    DeviceLimits limits() const override { return build_.limits; }
    DeviceCapabilities capabilities() const override;
    Result<void> connect(const GivenUp& given_up) override;
    void disconnect() noexcept override;
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    Result<void> forget_what_came() override;
    std::optional<ZeroForcePacket> zero_force_packet() const override;
    std::string prompt() const override;

    std::int64_t left_out() const override { return left_out_; }  ///< reports that cannot be, so far

private:
    /// How far it is to known angles.
    enum class Homed { no, counters_sent, yes };

    Result<bool> read_newest(std::chrono::microseconds patience);
    Result<void> await_reading(const GivenUp& given_up, const std::function<bool()>& is_right,
                               const char* otherwise);
    Result<void> set_counters();
    void look_at_button();
    bool has_place() const;
    bool is_at_home() const;
    glm::dvec3 angles() const;

    const WoodenParameters build_;
    const bool is_homed_;
    const Open open_;
    const DriverClock clock_;
    std::unique_ptr<ReportTransport> transport_;
    bool was_held_ = false;  // before: it was away since
    int pressed_ = 0;        // readings in a row that show its button
    Homed homed_ = Homed::no;
    WoodenReading reading_;
    std::int64_t read_ns_ = 0;
    std::int64_t left_out_ = 0;
};

}  // namespace touchable
