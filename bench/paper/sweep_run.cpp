// SPDX-License-Identifier: Apache-2.0
#include "bench/paper/sweep_run.hpp"

#include <algorithm>
#include <limits>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "bench/clocks.hpp"
#include "bench/tick_times.hpp"
#include "bench/touch/solver_ticks.hpp"
#include "engine/base/try.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {
namespace {

constexpr int second_ticks = 1000;
constexpr double under_mm = 2, above_mm = 50;  // of the true surface, along the optical axis

/// Ticks over a playing clip; with a lazy filter they also filter the touched pixels.
class SweepTicks final : public SolverTicks {
public:
    SweepTicks(PlayedClip& played, const TouchSolver& solver, int fingers, std::vector<glm::dvec3> goals)
        : SolverTicks([&played](std::int64_t ns) { return played.pair_at(ns); }, played.scene(), solver,
                      fingers, std::move(goals)),
          played_(played) {}

    void restart() override {
        SolverTicks::restart();
        played_.restart();
    }
    void prepare(int /*begin*/, int end) override { played_.play_to((end - 1) * tick_length_ns); }
    /// What is wrong with a contact of tick k, the last one; nullptr: all are valid.
    const char* fault(int k) const {
        const HeightField of_tick = field(k);
        for (const Contact& contact : contacts())
            if (const char* fault =
                    fault_of(contact, of_tick, metres_per_scene_unit(), behind_tolerance(metric())))
                return fault;
        return nullptr;
    }

private:
    PlayedClip& played_;
};

/// The hand comes down in the first half second; the figures start with the second second. Fingers are evenly
/// spread over one period of the path.
std::vector<glm::dvec3> goals_of(const PaperClip& clip, const SweepRun& run) {
    const double units_per_mm = 0.001 / clip.scene.device_metres_per_unit.value();
    const int fingers = run.setup.fingers;
    std::vector<glm::dvec3> goals;
    for (int k = 0; k < (1 + run.seconds) * second_ticks; ++k) {
        const double way_down = std::min(1.0, k / (0.5 * second_ticks));
        const double under = -above_mm + (under_mm + above_mm) * way_down;
        for (int finger = 0; finger < fingers; ++finger) {
            const double ahead = finger / (run.path.hz_x * fingers);
            goals.push_back(clip.surface_at(run.path.at(0.001 * k + ahead)) -
                            glm::dvec3(0, 0, under * units_per_mm));
        }
    }
    return goals;
}

/// Mean of each second's maximum, without the first second.
double mean_of_maxima(const double* values, int seconds) {
    double sum = 0;
    for (int second = 1; second <= seconds; ++second) {
        const double* const begin = values + std::ptrdiff_t{second} * second_ticks;
        sum += *std::max_element(begin, begin + second_ticks);
    }
    return sum / seconds;
}

/// Runs the ticks once, untimed, checks each, and counts from the second second on.
Result<void> add_primitives(SweepTicks& ticks, const SweepRun& run, Figures& figures) {
    ticks.restart();
    std::vector<double> primitives;
    ForceHash hash;
    double sum = 0;
    int touching = 0, capped = 0;
    for (int k = 0; k < ticks.ticks(); ++k) {
        ticks.prepare(k, k + 1);
        ticks.tick(k);
        if (const char* fault = ticks.fault(k))
            return Error{ErrorKind::check, "tick " + std::to_string(k) + ": " + fault};
        primitives.push_back(0);
        for (const Contact& contact : ticks.contacts()) {
            hash.add(contact.force);
            primitives.back() += contact.counts.events;
            if (k < second_ticks) continue;
            touching += contact.touching;
            capped += contact.counts.capped;
        }
        if (k >= second_ticks) sum += primitives.back();
    }
    const int counted = run.seconds * second_ticks * run.setup.fingers;
    if (2 * touching < counted) return Error{ErrorKind::check, "less than half of the ticks are in contact"};
    figures.push_back({"primitives_second_max", mean_of_maxima(primitives.data(), run.seconds), ""});
    figures.push_back({"primitives_mean", sum / touching, ""});
    figures.push_back({"contact_pct", 100.0 * touching / counted, "%"});
    figures.push_back({"capped_ticks", static_cast<double>(capped), ""});
    figures.push_back(named("force_hash", hash.hex()));
    return {};
}

/// Each tick's least time over the repeats: its time on an otherwise idle machine.
std::vector<double> least_of_repeats(const std::vector<double>& in_order, int repeats) {
    const std::size_t ticks = in_order.size() / static_cast<std::size_t>(repeats);
    std::vector<double> least(in_order.begin(), in_order.begin() + static_cast<std::ptrdiff_t>(ticks));
    for (std::size_t k = ticks; k < in_order.size(); ++k)
        least[k % ticks] = std::min(least[k % ticks], in_order[k]);
    return least;
}

void add_maxima(const TickTimes& times, const SweepRun& run, Figures& figures) {
    std::vector<double> repeats;
    for (int repeat = 0; repeat < run.repeats; ++repeat)
        repeats.push_back(mean_of_maxima(
            times.in_order_us.data() + std::ptrdiff_t{repeat} * (1 + run.seconds) * second_ticks,
            run.seconds));
    std::sort(repeats.begin(), repeats.end());
    figures.push_back({"tick_us_second_max", repeats[repeats.size() / 2], "us"});
    figures.push_back({"tick_us_second_max_undisturbed",
                       mean_of_maxima(least_of_repeats(times.in_order_us, run.repeats).data(), run.seconds),
                       "us"});
}

/// Each frame is built once more.
Result<void> add_frame_time(PlayedClip& played, Figures& figures) {
    std::int64_t least = std::numeric_limits<std::int64_t>::max();
    for (std::size_t n = 0; n < played.slots(); ++n) {
        const std::int64_t begin = monotonic_ns();
        TRY(played.build(n));
        least = std::min(least, monotonic_ns() - begin);
    }
    figures.push_back({"frame_ms", 1e-6 * static_cast<double>(least), "ms"});
    return {};
}

Result<void> run_sweep(const std::shared_ptr<const PaperClip>& clip, const SweepRun& run, auto&& work) {
    TRY_ASSIGN(const auto played, PlayedClip::make(clip, run.filter));
    TRY_ASSIGN(const TouchSolver solver, played->solver(run.setup.metric));
    SweepTicks ticks(*played, solver, run.setup.fingers, goals_of(*clip, run));
    return work(ticks, *played);
}

}  // namespace

Result<void> count_primitives(std::shared_ptr<const PaperClip> clip, const SweepRun& run, Figures& figures) {
    return run_sweep(clip, run,
                     [&](SweepTicks& ticks, PlayedClip&) { return add_primitives(ticks, run, figures); });
}

Result<void> measure_sweep(std::shared_ptr<const PaperClip> clip, const SweepRun& run, Figures& figures) {
    return run_sweep(clip, run, [&](SweepTicks& ticks, PlayedClip& played) -> Result<void> {
        Figures primitives;
        TRY(add_primitives(ticks, run, primitives));
        const TickTimes times = time_hot(ticks, run.repeats);
        add_maxima(times, run, figures);
        figures.insert(figures.end(), primitives.begin(), primitives.end());
        add_figures(times, "", figures);
        return run.filter.lazy ? Result<void>() : add_frame_time(played, figures);
    });
}

}  // namespace touchable
