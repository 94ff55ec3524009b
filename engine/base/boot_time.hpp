#pragma once

#include <time.h>

#include <cstdint>

namespace touchable {

/// Since the machine was started, ns: never backward, never 0, and on while it is suspended, which the steady
/// clock of Linux sleeps through.
inline std::int64_t boot_ns() {
    timespec now{};
    clock_gettime(CLOCK_BOOTTIME, &now);
    return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec;
}

}  // namespace touchable
