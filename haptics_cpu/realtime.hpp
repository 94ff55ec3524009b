#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

namespace touchable {

/// Memory from which no page has to be fetched in a tick.
enum class MemoryLock {
    none,
    present,  ///< what there was when it was asked for, as under a finite RLIMIT_MEMLOCK
    all       ///< and whatever comes later, once it has been touched
};

/// How much of what a real-time thread wants this machine allows.
struct RealtimeGrant {
    bool fifo = false;  ///< SCHED_FIFO
    MemoryLock memory = MemoryLock::none;
    std::optional<std::uint64_t> memory_limit{};  ///< RLIMIT_MEMLOCK, bytes; nothing: none that counts
    int cpu = -1;                                 ///< the one CPU the thread stays on; -1: any
    std::string in_words() const;  ///< "SCHED_FIFO, memory locked, on CPU 1", or what is missing
};

/// SCHED_FIFO priority of the haptic thread: above ordinary real-time work, below the kernel's own.
inline constexpr int haptic_priority = 80;

/// Asks for it, for the calling thread: SCHED_FIFO, the program's memory locked, pinned to the last of its
/// CPUs (interrupts tend to be served by the first) where there are several, timer slack 1 ns. Goes on
/// without what is refused.
RealtimeGrant become_realtime();

/// For a thread that carries a device's bytes: SCHED_FIFO as the haptic one has it, on any CPU. False: it is
/// not permitted.
bool become_fifo();

/// Sleeps until a moment of the monotonic clock, absolutely.
void sleep_until(std::chrono::steady_clock::time_point moment);

}  // namespace touchable
