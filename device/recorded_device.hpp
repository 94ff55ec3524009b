#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

#include "device/device_driver.hpp"
#include "device/device_log.hpp"
#include "device/driven_device.hpp"

namespace touchable {

/// The time that a replay goes by.
class ReplayClock {
public:
    ReplayClock() = default;
    ReplayClock(const ReplayClock&) = delete;
    ReplayClock& operator=(const ReplayClock&) = delete;
    virtual ~ReplayClock() = default;
    virtual std::chrono::nanoseconds now() = 0;
    virtual void wait_until(std::chrono::nanoseconds moment) = 0;
};

/// The machine's, which never goes back.
std::unique_ptr<ReplayClock> steady_replay_clock();

/// A log as a device: it tells what was read then, at the times it was read, from `connect` on, and feels
/// nothing of the forces. Where a log has ended its positions are not numbers.
class ReplayDriver final : public DeviceDriver {
public:
    ReplayDriver(std::string file, DeviceLog log, DeviceLimits limits, std::unique_ptr<ReplayClock> clock);

    std::string name() const override { return "recorded device"; }
    int fingers() const override { return log_.fingers(); }
    DeviceLimits limits() const override { return limits_; }
    DeviceCapabilities capabilities() const override;
    Result<void> connect(const GivenUp& given_up) override;
    void disconnect() noexcept override { connected_ = false; }
    Result<void> send(std::span<const glm::dvec3> newtons) override;
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    bool is_over() const override { return over_; }
    std::string prompt() const override;

private:
    std::chrono::nanoseconds time_of(std::size_t tick) const;

    const std::string file_;
    const DeviceLog log_;
    const DeviceLimits limits_;
    const std::unique_ptr<ReplayClock> clock_;
    bool connected_ = false;
    std::chrono::nanoseconds since_{0};
    std::size_t next_ = 0;  // tick that is told next
    bool over_ = false;     // and that has been told
};

/// Of "FILE[:key=value,...]", which follows "recorded:" (docs/devices.md). Refuses a key that is none
/// (ErrorKind::usage) and a file that is no log (ErrorKind::input).
Result<std::unique_ptr<ReplayDriver>> read_recorded_device(std::string_view text,
                                                           std::unique_ptr<ReplayClock> clock);
Result<std::unique_ptr<HapticDevice>> make_recorded_device(std::string_view text,
                                                           const DrivenSettings& driven);

}  // namespace touchable
