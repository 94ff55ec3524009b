// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/timing_run.hpp"

#include "bench/touch/solver_ticks.hpp"
#include "tests/content/exact_touch.hpp"

namespace touchable {
namespace {

constexpr double speed = 0.3;  // m/s
constexpr int ticks_between_fingers = 1000;

}  // namespace

std::vector<glm::dvec3> timing_goals(const TouchCase& c, int ticks) {
    ReliefStroke stroke(relief_of(c.scene), c.width, c.height, speed);
    std::vector<glm::dvec3> path;
    for (int k = 0; k < ticks + (c.fingers - 1) * ticks_between_fingers; ++k)
        path.push_back(stroke.next().goal);
    std::vector<glm::dvec3> goals;
    for (int k = 0; k < ticks; ++k)
        for (int finger = 0; finger < c.fingers; ++finger)
            goals.push_back(path[static_cast<std::size_t>(k + finger * ticks_between_fingers)]);
    return goals;
}

Result<void> measure_timing(const TouchSurface& surface, const TimingRun& run, Figures& figures) {
    auto made = SolverTicks::create(surface, run.setup, timing_grip, timing_goals(run.setup, run.ticks));
    if (!made) return made.error();
    SolverTicks& hot = **made;
    const auto counts = verify(hot);
    if (!counts) return counts.error();

    const TickTimes times = time_hot(hot, run.repeats);
    add_figures(times, "", figures);
    figures.push_back({"tick_roots", times.roots, ""});
    figures.push_back({"cell_roots", times.roots / counts->cells_per_tick, ""});
    figures.push_back({"tick_roots_p99", times.roots_p99, ""});
    add_figures(*counts, times.mean_us, figures);
    if (run.paced_ticks == 0) return {};

    auto paced = SolverTicks::create(surface, run.setup, timing_grip, timing_goals(run.setup, run.paced_ticks));
    if (!paced) return paced.error();
    add_figures(time_paced(**paced), "_paced", figures);
    return {};
}

}  // namespace touchable
