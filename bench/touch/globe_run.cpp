// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/globe_run.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "bench/touch/solver_ticks.hpp"
#include "engine/base/same_bits.hpp"
#include "tests/content/exact_touch.hpp"

namespace touchable {
namespace {

constexpr double true_force = 1;  // newtons: 1 N/mm, 1 mm under the surface

struct RootMeanSquare {
    double sum = 0;
    int count = 0;
    void add(double error) {
        sum += error * error;
        ++count;
    }
    double value() const { return count ? std::sqrt(sum / count) : 0; }
};

/// Errors of the force along the stroke; direction errors also by polar angle.
class ForceErrors {
public:
    void add(const GlobeStroke::Goal& goal, const Contact& contact) {
        const double newtons = length(contact.force), error = std::fabs(newtons - true_force);
        force_.add(error);
        largest_ = std::max(largest_, error);
        if (!contact.touching) {
            ++lost_;
            return;
        }
        // From the chord, which is accurate for small angles, unlike an arccosine.
        const double chord = length(contact.force / newtons - goal.normal);
        const double angle = 2 * arcsine(std::min(1.0, chord / 2)) * degrees;
        const double polar = goal.polar_angle * degrees;
        angle_.add(angle);
        if (polar < 45) below_45_.add(angle);
        by_polar_[polar < 45 ? static_cast<std::size_t>(polar / 15) : 3].add(angle);
    }
    void report(Figures& figures) const {
        figures.push_back({"force_angle_deg_rms", angle_.value(), "deg"});
        const std::array bins{"0_15", "15_30", "30_45", "45_58"};
        for (std::size_t bin = 0; bin < bins.size(); ++bin)
            figures.push_back(
                {std::string("force_angle_deg_rms_") + bins[bin], by_polar_[bin].value(), "deg"});
        figures.push_back({"force_angle_deg_rms_0_45", below_45_.value(), "deg"});
        figures.push_back({"force_n_rms", force_.value(), "N"});
        figures.push_back({"force_n_max", largest_, "N"});
        figures.push_back({"contact_lost_ticks", static_cast<double>(lost_), ""});
    }

private:
    static constexpr double degrees = 180 / pi;
    RootMeanSquare angle_, below_45_, force_;
    std::array<RootMeanSquare, 4> by_polar_;
    double largest_ = 0;
    int lost_ = 0;
};

}  // namespace

Result<void> measure_globe(const TouchSurface& surface, const GlobeRun& run, Figures& figures) {
    const TouchCase& c = run.setup;
    const GlobeStroke stroke(c.preset, c.width, c.height);
    std::vector<glm::dvec3> goals;
    for (int k = 0; k < GlobeStroke::approach_ticks + GlobeStroke::stroke_ticks; ++k)
        goals.push_back(stroke.at(k).goal);
    auto made = SolverTicks::create(surface, c, surface.scene().default_properties, std::move(goals));
    if (!made) return made.error();
    SolverTicks& touch = **made;

    const auto counts = verify(touch);
    if (!counts) return counts.error();

    touch.restart();
    ForceErrors errors;
    for (int k = 0; k < touch.ticks(); ++k) {
        touch.tick(k);
        if (k >= GlobeStroke::approach_ticks) errors.add(stroke.at(k), touch.contacts()[0]);
    }
    errors.report(figures);
    const TickTimes times = time_hot(touch, run.repeats);
    add_figures(times, "", figures);
    add_figures(*counts, times.mean_us, figures);
    return run.flanks > 0 ? measure_energy(surface, run, figures) : Result<void>();
}

}  // namespace touchable
