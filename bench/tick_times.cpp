// SPDX-License-Identifier: Apache-2.0
#include "bench/tick_times.hpp"

#include <algorithm>
#include <numeric>
#include <string>

#include "bench/clocks.hpp"

namespace touchable {
namespace {

constexpr int batch_ticks = 64;
constexpr double gap_us = 50;
constexpr std::int64_t period_ns = 1'000'000;

double microseconds(std::int64_t ns, double clock_cost_ns) {
    return std::max(0.0, (static_cast<double>(ns) - clock_cost_ns) / 1000.0);
}

/// Mean CPU time of a tick over the batches of one repeat.
double mean_cpu_us(TimedRun& run) {
    run.restart();
    const int ticks = run.ticks();
    double sum = 0;
    for (int k = 0; k < ticks;) {
        const int end = std::min(k + batch_ticks, ticks);
        run.prepare(k, end);
        const std::int64_t begin = thread_cpu_ns();
        for (; k < end; ++k) run.tick(k);
        sum += microseconds(thread_cpu_ns() - begin, clock_costs().thread_cpu);
    }
    return sum / ticks;
}

/// Least times over the repeats: of each tick, and of the root after each batch.
struct LeastTimes {
    std::vector<double> ticks_us, roots_us;
};
void keep_least(std::vector<double>& least, std::size_t at, double value) {
    if (at == least.size()) least.push_back(value);
    least[at] = std::min(least[at], value);
}
double mean_of(const std::vector<double>& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

/// Counts batches disturbed by other work of the machine.
class Disturbances {
public:
    explicit Disturbances(TickTimes& times) : times_(times), switches_(involuntary_switches()) {}

    void note(double tick_us) { gap_ |= tick_us > gap_us; }
    void end_batch() {
        const long switches = involuntary_switches();
        times_.preempted += switches != switches_;
        times_.gaps += gap_;
        ++times_.batches;
        switches_ = switches;
        gap_ = false;
    }

private:
    TickTimes& times_;
    long switches_;
    bool gap_ = false;
};

void take_wall_times(TimedRun& run, TickTimes& times, LeastTimes& least) {
    run.restart();
    const int ticks = run.ticks();
    std::size_t batch = 0;
    Disturbances disturbances(times);
    for (int k = 0; k < ticks;) {
        const int end = std::min(k + batch_ticks, ticks);
        run.prepare(k, end);
        for (; k < end; ++k) {
            const std::int64_t begin = monotonic_ns();
            run.tick(k);
            times.wall_us.push_back(microseconds(monotonic_ns() - begin, clock_costs().monotonic));
            disturbances.note(times.wall_us.back());
            keep_least(least.ticks_us, static_cast<std::size_t>(k), times.wall_us.back());
        }
        disturbances.end_batch();
        keep_least(least.roots_us, batch++, root_ns() / 1000);
    }
}

}  // namespace

double TickTimes::quantile_us(double share) const {
    if (wall_us.empty()) return 0;
    const auto rank = static_cast<std::size_t>(share * static_cast<double>(wall_us.size()));
    return wall_us[std::min(rank, wall_us.size() - 1)];
}

TickTimes time_hot(TimedRun& run, int repeats) {
    TickTimes times;
    times.wall_us.reserve(static_cast<std::size_t>(repeats) * static_cast<std::size_t>(run.ticks()));
    std::vector<double> means;
    LeastTimes least;
    for (int repeat = 0; repeat < repeats; ++repeat) {
        means.push_back(mean_cpu_us(run));
        take_wall_times(run, times, least);
    }
    std::sort(means.begin(), means.end());
    times.mean_us = means[means.size() / 2];
    times.in_order_us = times.wall_us;
    times.roots = mean_of(least.ticks_us) / mean_of(least.roots_us);
    std::sort(least.ticks_us.begin(), least.ticks_us.end());
    times.roots_p99 = least.ticks_us[least.ticks_us.size() * 99 / 100] / mean_of(least.roots_us);
    std::sort(times.wall_us.begin(), times.wall_us.end());
    return times;
}

TickTimes time_paced(TimedRun& run) {
    run.restart();
    TickTimes times;
    times.wall_us.reserve(static_cast<std::size_t>(run.ticks()));
    double sum = 0;
    Disturbances disturbances(times);
    const std::int64_t start = monotonic_ns() + period_ns;
    for (int k = 0; k < run.ticks(); ++k) {
        run.prepare(k, k + 1);
        sleep_until(start + k * period_ns);
        const std::int64_t cpu_begin = thread_cpu_ns(), begin = monotonic_ns();
        run.tick(k);
        const std::int64_t wall = monotonic_ns() - begin, cpu = thread_cpu_ns() - cpu_begin;
        times.wall_us.push_back(microseconds(wall, clock_costs().monotonic));
        sum += microseconds(cpu, clock_costs().thread_cpu_around_monotonic);
        disturbances.note(times.wall_us.back());
        if ((k + 1) % batch_ticks == 0 || k + 1 == run.ticks()) disturbances.end_batch();
    }
    times.mean_us = sum / run.ticks();
    times.in_order_us = times.wall_us;
    std::sort(times.wall_us.begin(), times.wall_us.end());
    return times;
}

void add_figures(const TickTimes& times, std::string_view suffix, Figures& figures) {
    const auto add = [&](std::string metric, double value, std::string_view unit) {
        figures.push_back({metric.append(suffix), value, unit});
    };
    const auto share = [&](int batches) { return times.batches ? 100.0 * batches / times.batches : 0.0; };
    add("tick_us_mean", times.mean_us, "us");
    add("tick_us_p50", times.quantile_us(0.5), "us");
    add("tick_us_p99", times.quantile_us(0.99), "us");
    add("tick_us_p999", times.quantile_us(0.999), "us");
    add("tick_us_max", times.quantile_us(1), "us");
    add("preempted_pct", share(times.preempted), "%");
    add("gaps_pct", share(times.gaps), "%");
}

}  // namespace touchable
