#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "device/device_driver.hpp"
#include "device/report_transport.hpp"
#include "device/spacemouse_motion.hpp"
#include "device/steady_time.hpp"

namespace touchable {

/// A 3Dconnexion SpaceMouse as a finger. It exerts no force. It sends reports only while it is pushed;
/// without reports the finger stays where it is, for as long as the node can be read.
class SpaceMouseDriver final : public DeviceDriver {
public:
    using Open = std::function<Result<std::unique_ptr<ReportTransport>>()>;

    SpaceMouseDriver(const SpaceMousePace& pace, Open open, DriverClock clock = steady_ns);

    std::string name() const override { return "SpaceMouse (exerts no force)"; }
    int fingers() const override { return 1; }
    /// Nobody feels these forces; they are only drawn.
    DeviceLimits limits() const override { return {1, 500}; }
    DeviceCapabilities capabilities() const override;
    Result<void> connect(const GivenUp& given_up) override;
    void disconnect() noexcept override { transport_.reset(); }
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;

    std::int64_t left_out() const override { return left_out_; }  ///< reports that were too short, so far

private:
    void take(std::span<const std::byte> report);

    const SpaceMousePace pace_;
    const Open open_;
    const DriverClock clock_;
    std::unique_ptr<ReportTransport> transport_;
    std::optional<SpaceMouseMotion> motion_;
    std::uint32_t buttons_ = 0;
    std::int64_t left_out_ = 0;
};

}  // namespace touchable
