#include "bench/touch/timing_run.hpp"

#include "bench/touch/touch_run.hpp"
#include "engine/content/strokes.hpp"

namespace touchable {
namespace {

constexpr double speed = 0.3;  // m/s
constexpr int ticks_between_fingers = 1000;
constexpr HapticProperties grip{600, 0.6, 0.4};

std::vector<glm::dvec3> goals_of(const TouchCase& c, int ticks) {
    ReliefStroke stroke(Relief::bumps, c.width, c.height, speed);
    std::vector<glm::dvec3> path;
    for (int k = 0; k < ticks + (c.fingers - 1) * ticks_between_fingers; ++k)
        path.push_back(stroke.next().goal);
    std::vector<glm::dvec3> goals;
    for (int k = 0; k < ticks; ++k)
        for (int finger = 0; finger < c.fingers; ++finger)
            goals.push_back(path[static_cast<std::size_t>(k + finger * ticks_between_fingers)]);
    return goals;
}

}  // namespace

Result<void> measure_timing(const TouchSurface& surface, const TimingRun& run, Figures& figures) {
    auto made = TouchRun::create(surface, run.setup, grip, goals_of(run.setup, run.ticks));
    if (!made.ok()) return made.error();
    TouchRun& hot = **made;
    const auto counts = verify(hot);
    if (!counts.ok()) return counts.error();

    const TickTimes times = time_hot(hot, run.repeats);
    add_figures(times, "", figures);
    figures.push_back({"cells_per_tick", counts->cells_per_tick, ""});
    figures.push_back({"ns_per_cell", 1000 * times.mean_us / counts->cells_per_tick, "ns"});
    figures.push_back({"events_mean", counts->events_mean, ""});
    figures.push_back({"events_max", static_cast<double>(counts->events_max), ""});
    figures.push_back({"capped_ticks", static_cast<double>(counts->capped_ticks), ""});
    if (run.paced_ticks == 0) return {};

    auto paced = TouchRun::create(surface, run.setup, grip, goals_of(run.setup, run.paced_ticks));
    if (!paced.ok()) return paced.error();
    add_figures(time_paced(**paced), "_paced", figures);
    return {};
}

}  // namespace touchable
