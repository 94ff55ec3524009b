#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "device/device_driver.hpp"
#include "device/falcon_kinematics.hpp"
#include "device/falcon_loader.hpp"
#include "device/falcon_protocol.hpp"
#include "device/ftdi_transport.hpp"

namespace touchable {

/// How a Falcon is used.
struct FalconSettings {
    std::vector<std::byte> firmware{};  ///< empty: none can be loaded, it must have some
    DeviceLimits limits{8, 1000};       ///< N, N/m
    FalconPatience patience{};
};

/// Takes hold of a Falcon that is plugged in. Error (ErrorKind::device): what would make it ready.
using FalconPlug = std::function<Result<std::unique_ptr<UsbPort>>()>;

/// A Novint Falcon. `connect` loads its firmware where it has none. It then has no position and no force
/// until a person has moved its grip over the marks of its encoders (`prompt` asks for that).
class FalconDriver final : public DeviceDriver {
public:
    static constexpr std::uint8_t usb_endpoint_out = 0x02;
    static constexpr double silent_s = 0.25;  ///< after which it is taken for gone
    static constexpr int homed_reports = 8;   ///< one after the other, before homing is believed

    FalconDriver(FalconSettings settings, FalconPlug plug, DriverClock clock = steady_ns)
        : settings_(std::move(settings)), plug_(std::move(plug)), clock_(std::move(clock)) {}
    ~FalconDriver() override { disconnect(); }

    std::string name() const override { return "Novint Falcon"; }
    int fingers() const override { return 1; }
    DeviceLimits limits() const override { return settings_.limits; }
    DeviceCapabilities capabilities() const override;
    Result<void> connect(const GivenUp& given_up) override;
    void disconnect() noexcept override;
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    Result<void> forget_what_came() override;
    std::optional<ZeroForcePacket> zero_force_packet() const override;
    std::string prompt() const override;

    std::int64_t left_out() const override { return reader_.damaged(); }

private:
    bool is_homed() const { return homed_in_a_row_ >= homed_reports; }
    Result<void> command(const std::array<std::int16_t, 3>& motors);
    Result<std::optional<FalconReport>> newest_report(std::chrono::microseconds patience);
    Result<bool> answers(const GivenUp& given_up);
    Result<void> load(const GivenUp& given_up);
    void take(const FalconReport& report, DeviceSample& sample);

    const FalconSettings settings_;
    const FalconPlug plug_;
    const DriverClock clock_;
    std::unique_ptr<FtdiTransport> transport_;
    bool runs_ = false;  // its firmware does, so that motor words mean something
    FalconReader reader_;
    int unanswered_ = 0;
    std::int64_t received_ns_ = 0;
    int homed_in_a_row_ = 0, impossible_in_a_row_ = 0;
    std::optional<FalconPose> pose_;  // of the newest report
};

}  // namespace touchable
