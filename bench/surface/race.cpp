// SPDX-License-Identifier: Apache-2.0
#include "bench/surface/race.hpp"

#include <algorithm>

#include "bench/clocks.hpp"

namespace touchable {

Result<void> race(std::vector<Racer>& racers, int rounds) {
    for (int round = 0; round < rounds; ++round)
        for (Racer& racer : racers) {
            const std::int64_t wall = monotonic_ns(), cpu = process_cpu_ns();
            if (Result<void> done = racer.frame(); !done) return done;
            FrameTimes& times = racer.times;
            times.wall_ms = std::min(times.wall_ms, static_cast<double>(monotonic_ns() - wall) * 1e-6);
            times.cpu_ms = std::min(times.cpu_ms, static_cast<double>(process_cpu_ns() - cpu) * 1e-6);
        }
    return {};
}

void add_times(Figures& figures, const std::string& what, const FrameTimes& times) {
    figures.push_back({what + "_ms", times.wall_ms, "ms"});
    figures.push_back({what + "_cpu_ms", times.cpu_ms, "ms"});
}

}  // namespace touchable
