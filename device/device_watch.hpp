#pragma once

#include <cstdint>
#include <functional>

#include "device/drive_times.hpp"
#include "device/driven_device.hpp"
#include "device/measured_figures.hpp"

namespace touchable {

/// The time of whoever reads a device, as the haptic thread does.
struct TickPace {
    std::function<bool()> next_tick;  ///< waits for the next millisecond; false: give up
    std::function<std::int64_t()> now_ns;
};

/// Why a device's call returned false.
Error failure_of(const HapticDevice& device);

/// What a device does while a reader asks it a thousand times a second and asks for no force.
struct WatchFigures {
    double seconds = 0;
    std::int64_t readings = 0;
    std::int64_t without_place = 0;  ///< readings whose first finger had no position
    double reports_per_s = 0;
    Percentiles interval_s;   ///< from a report to the next
    Percentiles age_s;        ///< of the newest position, at a reading
    Percentiles going_out_s;  ///< from asking for a force until it was sent
    Percentiles
        until_received_s;  ///< from a force that had gone out to the next report, where no other went between
    double longest_call_s = 0;  ///< that the reader gave to the device in one tick, reading and writing
    RestFigures rest;           ///< first finger, a place for each reading that had a new one
};

/// Reads it so many ticks. It is open, `times` receives when its reports come. Error: it failed
/// (ErrorKind::device); given up (ErrorKind::interrupted).
Result<WatchFigures> watch_device(HapticDevice& device, const DriveTimes& times, const TickPace& pace,
                                  int ticks);

}  // namespace touchable
