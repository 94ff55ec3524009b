#pragma once

#include <cstdint>
#include <functional>

#include "engine/boot_time.hpp"

namespace touchable {

/// Of the system's steady clock, ns: never backward, whatever is done to the time of day. A machine that is
/// suspended leaves it running: what was said before that is old afterwards.
inline std::int64_t steady_ns() {
    return boot_ns();
}

/// Of a driver, so that a test may have time pass as it likes: ns that do not go back, never 0.
using DriverClock = std::function<std::int64_t()>;

}  // namespace touchable
