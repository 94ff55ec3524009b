#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "engine/base/boot_time.hpp"

namespace touchable {

/// The window's clock: std::chrono::steady_clock, which a test can put forward, so that a day of a kiosk
/// takes minutes. Sessions and their forces go by their own.
class WindowClock {
public:
    using duration = std::chrono::steady_clock::duration;
    using rep = duration::rep;
    using period = duration::period;
    using time_point = std::chrono::steady_clock::time_point;
    static constexpr bool is_steady = true;

    static time_point now() {
        return std::chrono::steady_clock::now() + duration(ahead_.load(std::memory_order_relaxed));
    }
    static void put_forward(duration by) { ahead_.fetch_add(by.count(), std::memory_order_relaxed); }
    /// For how long the machine has been suspended so far, which `now` sleeps through; a test can suspend it.
    static duration slept() {
        const auto steady = std::chrono::steady_clock::now().time_since_epoch();
        return std::chrono::nanoseconds(boot_ns()) - steady +
               duration(asleep_.load(std::memory_order_relaxed));
    }
    static void suspend(duration by) { asleep_.fetch_add(by.count(), std::memory_order_relaxed); }

private:
    static inline std::atomic<rep> ahead_{0}, asleep_{0};
};

}  // namespace touchable
