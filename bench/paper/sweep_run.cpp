#include "bench/paper/sweep_run.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "bench/clocks.hpp"
#include "bench/tick_times.hpp"
#include "bench/touch/touch_run.hpp"

namespace touchable {
namespace {

constexpr int second_ticks = 1000;
constexpr double under_mm = 2;

/// A tick is what the haptic thread does in one; with a lazy filter also taking in the new frame, 30 times a
/// second.
class SweepTicks final : public TimedRun {
public:
    SweepTicks(PlayedClip& played, const TouchSolver& solver, std::vector<glm::dvec3> goals)
        : played_(played), solver_(solver), goals_(std::move(goals)) {}

    int ticks() const override { return static_cast<int>(goals_.size()); }
    void restart() override {
        finger_ = {};
        played_.restart();
    }
    void tick(int k) override {
        const HeightField field(played_.scene(), played_.pair_at(k * tick_ns));
        solver_.tick(field, {&goals_[static_cast<std::size_t>(k)], 1}, {&finger_, 1}, {&contact_, 1});
    }
    const Contact& contact() const { return contact_; }
    /// What is wrong with the contact of tick k, which was the last; nullptr if it is sound.
    const char* fault(int k) {
        const HeightField field(played_.scene(), played_.pair_at(k * tick_ns));
        return fault_of(contact_, field, solver_.settings().metres_per_scene_unit,
                        behind_tolerance(solver_.settings().metric));
    }

private:
    PlayedClip& played_;
    const TouchSolver& solver_;
    std::vector<glm::dvec3> goals_;
    FingerState finger_;
    Contact contact_;
};

std::vector<glm::dvec3> goals_of(const PaperClip& clip, const SweepRun& run) {
    const double under = 0.001 * under_mm / clip.scene.device_metres_per_unit.value();
    std::vector<glm::dvec3> goals;
    for (int k = 0; k < run.seconds * second_ticks; ++k)
        goals.push_back(clip.surface_at(run.path.at(0.001 * k)) - glm::dvec3(0, 0, under));
    return goals;
}

/// Mean over the seconds of a run of the largest of each.
double mean_of_maxima(const double* values, int seconds) {
    double sum = 0;
    for (int second = 0; second < seconds; ++second, values += second_ticks)
        sum += *std::max_element(values, values + second_ticks);
    return sum / seconds;
}

/// Runs it once, untimed, looks at every tick and counts.
Result<void> add_primitives(SweepTicks& ticks, const SweepRun& run, Figures& figures) {
    ticks.restart();
    std::vector<double> primitives;
    double sum = 0;
    int touching = 0, capped = 0;
    for (int k = 0; k < ticks.ticks(); ++k) {
        ticks.tick(k);
        if (const char* fault = ticks.fault(k))
            return Error{ErrorKind::check, "tick " + std::to_string(k) + ": " + fault};
        primitives.push_back(ticks.contact().counts.events);
        sum += primitives.back();
        touching += ticks.contact().touching;
        capped += ticks.contact().counts.capped;
    }
    if (2 * touching < ticks.ticks())
        return Error{ErrorKind::check, "less than half of the ticks are in contact"};
    figures.push_back({"primitives_second_max", mean_of_maxima(primitives.data(), run.seconds), ""});
    figures.push_back({"primitives_mean", sum / touching, ""});
    figures.push_back({"contact_pct", 100.0 * touching / ticks.ticks(), "%"});
    figures.push_back({"capped_ticks", static_cast<double>(capped), ""});
    return {};
}

/// Each tick's least time over the repeats: what it takes where nothing else happens on the machine.
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
            times.in_order_us.data() + std::ptrdiff_t{repeat} * run.seconds * second_ticks, run.seconds));
    std::sort(repeats.begin(), repeats.end());
    figures.push_back({"tick_us_second_max", repeats[repeats.size() / 2], "us"});
    figures.push_back({"tick_us_second_max_undisturbed",
                       mean_of_maxima(least_of_repeats(times.in_order_us, run.repeats).data(), run.seconds),
                       "us"});
}

}  // namespace

Result<void> measure_sweep(std::shared_ptr<const PaperClip> clip, const SweepRun& run, Figures& figures) {
    std::vector<glm::dvec3> goals = goals_of(*clip, run);
    const auto played = PlayedClip::make(std::move(clip), run.filter);
    if (!played.ok()) return played.error();
    TouchSettings settings;
    settings.metric = run.setup.metric;
    settings.metres_per_scene_unit = (*played)->scene().device_metres_per_unit.value();
    const auto solver = TouchSolver::create((*played)->scene(), settings);
    if (!solver.ok()) return solver.error();
    SweepTicks ticks(**played, *solver, std::move(goals));
    Figures primitives;
    if (auto counted = add_primitives(ticks, run, primitives); !counted.ok()) return counted;
    const TickTimes times = time_hot(ticks, run.repeats);
    add_maxima(times, run, figures);
    figures.insert(figures.end(), primitives.begin(), primitives.end());
    add_figures(times, "", figures);
    return {};
}

}  // namespace touchable
