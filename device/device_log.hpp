#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "device/device_driver.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// What a device told, tick by tick, as a log has it (docs/devices.md, "Logs").
class DeviceLog {
public:
    /// Refuses (ErrorKind::input; file, line and column where there are such) what cannot be read, lacks a
    /// column of a log, or in which ticks go back or have other fingers than the first.
    static Result<DeviceLog> read(const std::string& file);

    int fingers() const { return fingers_; }
    std::size_t ticks() const { return seconds_.size(); }              ///< at least 1
    double seconds(std::size_t tick) const { return seconds_[tick]; }  ///< since the first
    DeviceSample sample(std::size_t tick) const;

private:
    int fingers_ = 0;
    std::vector<double> seconds_;
    std::vector<glm::dvec3> metres_;  // fingers of a tick one after the other
    std::vector<std::uint32_t> buttons_;
};

}  // namespace touchable
