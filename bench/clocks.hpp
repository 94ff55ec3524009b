#pragma once

#include <cstdint>

namespace touchable {

inline constexpr std::int64_t tick_length_ns = 1'000'000;  ///< of the touched time, from one tick to the next

std::int64_t monotonic_ns();
/// CPU time of this thread.
std::int64_t thread_cpu_ns();
/// CPU time of all threads of this process.
std::int64_t process_cpu_ns();
/// How often the kernel has taken the core from this thread (getrusage, RUSAGE_THREAD).
long involuntary_switches();

/// What a pair of readings measures of nothing, in nanoseconds: median of many. Taken off every time.
struct ClockCosts {
    double monotonic = 0, thread_cpu = 0;
    /// Of a pair of readings of the thread's clock around a pair of the monotonic one.
    double thread_cpu_around_monotonic = 0;
};
/// Measured once, when first asked for.
const ClockCosts& clock_costs();

/// Sleeps until a time of the monotonic clock.
void sleep_until(std::int64_t time_ns);

}  // namespace touchable
