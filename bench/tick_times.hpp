#pragma once

#include <string_view>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// A run of ticks that can be repeated: each repeat does exactly the same.
class TimedRun {
public:
    virtual ~TimedRun() = default;
    virtual int ticks() const = 0;
    virtual void restart() = 0;
    /// Untimed, before ticks from `begin` to below `end`, at most 64: what others would have made ready.
    virtual void prepare(int /*begin*/, int /*end*/) {}
    virtual void tick(int k) = 0;
};

/// How long ticks took (bench/README.md, "How time is taken").
struct TickTimes {
    double mean_us = 0;  ///< CPU time of the thread, the median over repeats of the mean over batches
    std::vector<double> in_order_us;  ///< every tick of every repeat, monotonic clock, one after another
    std::vector<double> wall_us;      ///< the same, ascending
    int batches = 0;                  ///< of 64 ticks, of those in wall_us
    int preempted = 0;                ///< of them, with an involuntary switch
    int gaps = 0;                     ///< of them, with a tick of more than 50 us

    double quantile_us(double share) const;
};

/// Ticks in a tight loop: each repeat once by the thread's CPU clock over batches, once tick by tick.
TickTimes time_hot(TimedRun& run, int repeats);
/// Ticks once each millisecond, as in use: caches and clock frequency cool down between them.
TickTimes time_paced(TimedRun& run);

/// tick_us_mean, _p50, _p99, _p999, _max, preempted_pct and gaps_pct, each followed by `suffix`.
void add_figures(const TickTimes& times, std::string_view suffix, Figures& figures);

}  // namespace touchable
