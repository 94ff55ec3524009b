// SPDX-License-Identifier: Apache-2.0
#pragma once

// A device's log, replayed as a device.

#include <chrono>
#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "device/drivers/device_driver.hpp"
#include "engine/base/result.hpp"
#include "engine/base/words.hpp"

namespace touchable {

/// Positions and buttons of a device, tick by tick, from a log (docs/devices.md, "Logs").
class DeviceLog {
public:
    /// Refuses (ErrorKind::input, with file, line and column if known) a log that cannot be read, lacks a
    /// column, or has ticks that go back or have other fingers than the first.
    static Result<DeviceLog> read(const std::string& file);

    int fingers() const { return fingers_; }
    std::size_t ticks() const { return seconds_.size(); }              ///< at least 1
    double seconds(std::size_t tick) const { return seconds_[tick]; }  ///< since the first
    DeviceSample sample(std::size_t tick) const {
        DeviceSample sample;
        sample.metres.fill(no_place);
        const auto first = metres_.begin() + static_cast<std::ptrdiff_t>(tick) * fingers_;
        std::copy(first, first + fingers_, sample.metres.begin());
        sample.buttons = buttons_[tick];
        return sample;
    }

private:
    int fingers_ = 0;
    std::vector<double> seconds_;
    std::vector<glm::dvec3> metres_;  // the fingers of a tick are consecutive
    std::vector<std::uint32_t> buttons_;
};

/// Clock of a replay.
class ReplayClock : NonCopyable {
public:
    virtual ~ReplayClock() = default;
    virtual std::chrono::nanoseconds now() = 0;
    virtual void wait_until(std::chrono::nanoseconds moment) = 0;
};

/// A log as a device: positions as they were read, at the times they were read, from `connect` on. Forces
/// have no effect. After the log's end its positions are NaN.
class ReplayDriver final : public DeviceDriver {
public:
    ReplayDriver(std::string file, DeviceLog log, DeviceLimits limits, std::unique_ptr<ReplayClock> clock)
        : file_(std::move(file)), log_(std::move(log)), limits_(limits), clock_(std::move(clock)) {}

    std::string name() const override { return "recorded device"; }
    int fingers() const override { return log_.fingers(); }
    DeviceLimits limits() const override { return limits_; }
    DeviceCapabilities capabilities() const override {
        const std::size_t ticks = log_.ticks();
        const double length = log_.seconds(ticks - 1);
        return {.axes_driven = 0,
                .rate_hz = length > 0 ? static_cast<double>(ticks - 1) / length : 0,
                .buttons = 32,
                .own_watchdog = true};
    }
    Result<void> connect() override {
        connected_ = true;
        since_ = clock_->now();
        next_ = 0;
        over_ = false;
        return {};
    }
    void disconnect() noexcept override { connected_ = false; }
    Result<void> send(std::span<const glm::dvec3>) override {
        if (!connected_) return device_error("the replay of " + printable(file_) + " is closed");
        return {};
    }
    Result<bool> receive(DeviceSample& sample, std::chrono::microseconds patience) override;
    bool is_over() const override { return over_; }
    std::string prompt() const override {
        return over_ ? "the log " + printable(file_) + " has ended: nothing holds the handle any more"
                     : std::string();
    }

private:
    std::chrono::nanoseconds time_of(std::size_t tick) const {
        return since_ + std::chrono::nanoseconds(static_cast<std::int64_t>(log_.seconds(tick) * 1e9 + 0.5));
    }

    const std::string file_;
    const DeviceLog log_;
    const DeviceLimits limits_;
    const std::unique_ptr<ReplayClock> clock_;
    bool connected_ = false;
    std::chrono::nanoseconds since_{0};
    std::size_t next_ = 0;  // next tick to return
    bool over_ = false;     // and the end has been reported
};

/// Makes a replay of "FILE[:key=value,...]", which follows "recorded:" (docs/devices.md). Refuses an unknown
/// key (ErrorKind::usage) and a file that is no log (ErrorKind::input).
Result<std::unique_ptr<ReplayDriver>> read_recorded_device(std::string_view text,
                                                           std::unique_ptr<ReplayClock> clock);
Result<std::unique_ptr<DeviceDriver>> make_recorded_driver(std::string_view text);

}  // namespace touchable
