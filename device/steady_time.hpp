#pragma once

#include <chrono>
#include <cstdint>
#include <functional>

namespace touchable {

/// Of the system's steady clock, ns: never backward, whatever is done to the time of day.
inline std::int64_t steady_ns() {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    return std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
}

/// Of a driver, so that a test may have time pass as it likes: ns that do not go back, never 0.
using DriverClock = std::function<std::int64_t()>;

}  // namespace touchable
