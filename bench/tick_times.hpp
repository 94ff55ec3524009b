// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string_view>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// A repeatable run of ticks: each repeat does exactly the same.
class TimedRun {
public:
    virtual ~TimedRun() = default;
    virtual int ticks() const = 0;
    virtual void restart() = 0;
    /// Untimed, before ticks from `begin` to below `end`, at most 64: work that other threads would have
    /// done.
    virtual void prepare(int /*begin*/, int /*end*/) {}
    virtual void tick(int k) = 0;
};

/// Times of ticks (bench/README.md, "How time is taken").
struct TickTimes {
    double mean_us = 0;               ///< thread's CPU time: mean over batches, median over repeats
    /// Mean and 99 % of the ticks, in dependent square roots between their batches (clocks.hpp), both by the
    /// monotonic clock. Each tick and root counts with its least repeat, as other load disturbs some.
    double roots = 0, roots_p99 = 0;
    std::vector<double> in_order_us;  ///< every tick of every repeat, monotonic clock, one after another
    std::vector<double> wall_us;      ///< in_order_us, ascending
    int batches = 0;                  ///< batches of 64 ticks in wall_us
    int preempted = 0;                ///< batches with an involuntary context switch
    int gaps = 0;                     ///< batches with a tick of more than 50 us

    double quantile_us(double share) const;
};

/// Ticks in a tight loop: each repeat is timed once per batch with the thread's CPU clock and once tick by
/// tick.
TickTimes time_hot(TimedRun& run, int repeats);
/// One tick per millisecond, as in use: caches get cold and the clock frequency drops in between.
TickTimes time_paced(TimedRun& run);

/// tick_us_mean, _p50, _p99, _p999, _max, preempted_pct and gaps_pct, each followed by `suffix`.
void add_figures(const TickTimes& times, std::string_view suffix, Figures& figures);

}  // namespace touchable
