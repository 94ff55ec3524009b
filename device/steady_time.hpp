#pragma once

#include <cstdint>
#include <functional>

#include "engine/base/boot_time.hpp"

namespace touchable {

/// ns by the clock that goes on while the machine is suspended (CLOCK_BOOTTIME), so that what a device said
/// before that is old afterwards. Never backward, whatever is done to the time of day.
inline std::int64_t steady_ns() {
    return boot_ns();
}

/// Of a driver, so that a test may have time pass as it likes: ns that do not go back, never 0.
using DriverClock = std::function<std::int64_t()>;

}  // namespace touchable
