// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>

#include "engine/base/threads.hpp"

namespace touchable {

/// The window's clock: std::chrono::steady_clock, which a test can advance, so that a day of a kiosk takes
/// minutes. While a film is drawn without a window it stands, and advances by `put_forward` alone. Sessions
/// and their forces use their own clocks. Any thread.
class WindowClock {
public:
    using duration = std::chrono::steady_clock::duration;
    using time_point = std::chrono::steady_clock::time_point;

    static time_point now() {
        const duration ahead(ahead_.load(std::memory_order_relaxed)), stands(stands_.load());
        return (stands.count() != 0 ? time_point(stands) : std::chrono::steady_clock::now()) + ahead;
    }
    static void stand_still(bool on) {
        stands_.store(on ? std::chrono::steady_clock::now().time_since_epoch().count() : 0);
    }
    static void put_forward(duration by) { ahead_.fetch_add(by.count(), std::memory_order_relaxed); }
    /// Total time that the machine was suspended, which `now` does not count; a test can add to it.
    static duration slept() {
        if (stands_.load() != 0) return {};
        const auto steady = std::chrono::steady_clock::now().time_since_epoch();
        return std::chrono::nanoseconds(boot_ns()) - steady +
               duration(asleep_.load(std::memory_order_relaxed));
    }
    static void suspend(duration by) { asleep_.fetch_add(by.count(), std::memory_order_relaxed); }
    static double seconds_between(time_point from, time_point to) {
        return std::chrono::duration<double>(to - from).count();
    }

private:
    static inline std::atomic<duration::rep> ahead_{0}, asleep_{0}, stands_{0};
};

/// The time of a script, and of `seconds`, after which the window closes. After a stall, as on a machine that
/// was busy or asleep, it continues where it was: separate inputs do not coincide.
class ScriptClock {
public:
    /// Script time at this moment of the window's clock, seconds, monotonic. `stands`: the time since the
    /// last call does not count.
    double at(double now_s, bool stands = false) {
        constexpr double longest_step_s = 0.1;  // a slow picture is no stall
        if (!stands) time_s_ += std::min(now_s - seen_s_, longest_step_s);
        seen_s_ = now_s;
        return time_s_;
    }

private:
    double seen_s_ = 0, time_s_ = 0;
};

}  // namespace touchable
