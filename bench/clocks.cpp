// SPDX-License-Identifier: Apache-2.0
#include "bench/clocks.hpp"

#include <sys/resource.h>
#include <time.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace touchable {
namespace {

constexpr std::int64_t nanoseconds_per_second = 1'000'000'000;

std::int64_t now_ns(clockid_t clock) {
    timespec t = {};
    clock_gettime(clock, &t);
    return t.tv_sec * nanoseconds_per_second + t.tv_nsec;
}

template <class Pair>
double median_ns(Pair pair) {
    std::array<std::int64_t, 2001> costs;
    for (std::int64_t& cost : costs) cost = pair();
    std::nth_element(costs.begin(), costs.begin() + costs.size() / 2, costs.end());
    return static_cast<double>(costs[costs.size() / 2]);
}

}  // namespace

std::int64_t monotonic_ns() {
    return now_ns(CLOCK_MONOTONIC);
}

std::int64_t thread_cpu_ns() {
    return now_ns(CLOCK_THREAD_CPUTIME_ID);
}

std::int64_t process_cpu_ns() {
    return now_ns(CLOCK_PROCESS_CPUTIME_ID);
}

long involuntary_switches() {
    rusage usage = {};
    getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_nivcsw;
}

const ClockCosts& clock_costs() {
    static const ClockCosts costs = [] {
        ClockCosts c;
        c.monotonic = median_ns([] {
            const std::int64_t begin = monotonic_ns();
            return monotonic_ns() - begin;
        });
        c.thread_cpu = median_ns([] {
            const std::int64_t begin = thread_cpu_ns();
            return thread_cpu_ns() - begin;
        });
        c.thread_cpu_around_monotonic = median_ns([] {
            const std::int64_t begin = thread_cpu_ns();
            monotonic_ns();
            monotonic_ns();
            return thread_cpu_ns() - begin;
        });
        return c;
    }();
    return costs;
}

double root_ns() {
    constexpr int roots = 1000;
    volatile double begin_at = 2, end_at;  // so that the compiler computes all of them, here
    double x = begin_at;
    const std::int64_t begin = thread_cpu_ns();
    for (int k = 0; k < roots; ++k) x = std::sqrt(x + 1);
    end_at = x;
    const auto ns = static_cast<double>(thread_cpu_ns() - begin) - clock_costs().thread_cpu;
    static_cast<void>(end_at);
    return ns / roots;
}

void sleep_until(std::int64_t time_ns) {
    timespec t = {};
    t.tv_sec = time_ns / nanoseconds_per_second;
    t.tv_nsec = time_ns % nanoseconds_per_second;
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, nullptr) != 0) {
    }
}

}  // namespace touchable
