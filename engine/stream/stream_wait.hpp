#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <limits>

#include "engine/base/result.hpp"
#include "engine/base/stop_request.hpp"

namespace touchable {

/// How long a stream is waited for.
struct StreamPatience {
    std::chrono::milliseconds connection{5'000};  ///< for a connection
    std::chrono::milliseconds caller{60'000};     ///< for one who calls, where this end listens
    std::chrono::milliseconds opening{10'000};    ///< from the call to the first whole frameset, all in all
    std::chrono::milliseconds frameset{10'000};   ///< for the next whole frameset
    std::chrono::milliseconds silence{20'000};    ///< in a live run, until the connection is given up
    std::chrono::milliseconds back_off{500};      ///< before connecting again; doubles up to 16 times that
};

/// When a wait for a stream ends: somebody says so, from any thread, or its time is over.
class StreamWait {
public:
    using Clock = std::chrono::steady_clock;
    /// The next wait, which also ends when `together_at_most` does.
    void at_most(std::chrono::milliseconds longest) {
        until_ = std::min<std::int64_t>(ns(Clock::now() + longest), together_until_);
    }
    /// All waits from now on together, until this or `each_alone` is called.
    void together_at_most(std::chrono::milliseconds longest) {
        until_ = together_until_ = ns(Clock::now() + longest);
    }
    void each_alone() { together_until_ = std::numeric_limits<std::int64_t>::max(); }
    bool is_together() const { return together_until_ != std::numeric_limits<std::int64_t>::max(); }
    void interrupt() { interrupted_ = true; }
    /// By whoever waits, or by somebody who asks the program to stop.
    bool is_interrupted() const { return interrupted_ || stop_requested(); }
    bool is_too_long() const { return ns(Clock::now()) > until_; }
    /// What went wrong, where that may be that this wait is over (ErrorKind::interrupted).
    Error in_time(Error error) const {
        if (is_interrupted()) return interrupted_error();
        if (error.kind == ErrorKind::interrupted) error.kind = ErrorKind::input;
        return error;
    }
    bool is_over() const { return is_interrupted() || is_too_long(); }

private:
    static std::int64_t ns(Clock::time_point moment) {
        return std::chrono::nanoseconds(moment.time_since_epoch()).count();
    }
    std::atomic<bool> interrupted_{false};
    std::atomic<std::int64_t> until_{std::numeric_limits<std::int64_t>::max()};
    std::atomic<std::int64_t> together_until_{std::numeric_limits<std::int64_t>::max()};
};

}  // namespace touchable
