// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace touchable {

inline constexpr std::int64_t tick_length_ns = 1'000'000;  ///< touch time from one tick to the next

std::int64_t monotonic_ns();
/// CPU time of this thread.
std::int64_t thread_cpu_ns();
/// CPU time of all threads of this process.
std::int64_t process_cpu_ns();
/// Number of involuntary context switches of this thread (getrusage, RUSAGE_THREAD).
long involuntary_switches();

/// Time that a pair of clock readings measures by itself, ns: median of many. Subtracted from every time.
struct ClockCosts {
    double monotonic = 0, thread_cpu = 0;
    /// A pair of readings of the thread's clock around a pair of the monotonic clock.
    double thread_cpu_around_monotonic = 0;
};
/// Measured once, at the first call.
const ClockCosts& clock_costs();

/// CPU time of one of 1000 dependent square roots, ns: the unit of ticks' times. Measured between ticks, it
/// has their clock frequency and their neighbours.
double root_ns();

/// Sleeps until a time of the monotonic clock.
void sleep_until(std::int64_t time_ns);

}  // namespace touchable
