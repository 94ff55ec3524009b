// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/proven_run.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bench/clocks.hpp"
#include "bench/touch/solver_ticks.hpp"
#include "tests/content/exact_touch.hpp"
#include "tests/reference/solver.hpp"

namespace touchable {
namespace {

constexpr HapticProperties frictionless{600, 0, 0};
// Tolerances for rounding of doubles: of 1 / depth, relative, and of lengths per (1 + |P - G|).
constexpr double depth_tolerance = 1e-9, excess_tolerance = 1e-9, way_tolerance = 1e-7;

std::vector<glm::dvec3> goals_of(const ProvenRun& run) {
    const TouchCase& c = run.setup;
    std::vector<glm::dvec3> goals;
    if (c.scene == "globe") {
        const GlobeStroke stroke(c.preset, c.width, c.height);
        for (int k = 0; k < GlobeStroke::approach_ticks + GlobeStroke::stroke_ticks; ++k)
            goals.push_back(stroke.at(k).goal);
        return goals;
    }
    ReliefStroke stroke(relief_of(c.scene), c.width, c.height, run.speed);
    for (int k = 0; k < run.ticks; ++k) goals.push_back(stroke.next().goal);
    return goals;
}

/// Results of the checks, tick by tick.
class Proof {
public:
    void look(const reference::Surface& truth, const Proxy& before, const Proxy& after,
              const Contact& contact) {
        ++ticks_;
        tunnelled_ += !(reference::depth_behind(truth, contact.proxy) <= depth_tolerance);
        if (contact.counts.capped) {  // the next tick continues it
            ++capped_;
            return;
        }
        if (contact.touching) {
            ++touching_;
            not_minima_ += !is_minimum(truth, after, contact);
        }
        const auto compared = reference::compare(truth, before, after, contact);
        farthest_ = std::max(farthest_, compared.distance_ratio);
        if (compared.same_basin)
            angle_ = std::max(angle_, compared.angle_degrees);
        else
            ++other_basin_;
    }

    Result<void> report(Figures& figures) const {
        if (2 * touching_ < ticks_)
            return Error{ErrorKind::check,
                         "less than half of the ticks are in contact: there is nothing to prove"};
        const auto add = [&](const char* metric, auto value, std::string_view unit) {
            figures.push_back({metric, static_cast<double>(value), unit});
        };
        add("proven_ticks", ticks_, "");
        add("capped_ticks", capped_, "");
        add("tunnelled_ticks", tunnelled_, "");
        add("non_minima_ticks", not_minima_, "");
        add("basin_mismatch_ticks", other_basin_, "");
        add("distance_over_reference_max", farthest_, "");
        add("reference_angle_deg_max", angle_, "deg");
        return {};
    }

private:
    static bool is_minimum(const reference::Surface& truth, const Proxy& proxy, const Contact& contact) {
        const glm::dvec3 pull = contact.proxy - contact.goal;
        const double unit = 1 + std::sqrt(glm::dot(pull, pull));
        return reference::excess_over_minimum(truth, proxy, contact.goal) <= excess_tolerance * unit &&
               reference::way_left(truth, proxy, contact.goal) <= way_tolerance * unit;
    }

    int ticks_ = 0, touching_ = 0, capped_ = 0, tunnelled_ = 0, not_minima_ = 0, other_basin_ = 0;
    reference::Real farthest_ = 0, angle_ = 0;
};

}  // namespace

Result<void> measure_proof(const TouchSurface& surface, const ProvenRun& run, Figures& figures) {
    auto made = SolverTicks::create(surface, run.setup, frictionless, goals_of(run));
    if (!made) return made.error();
    SolverTicks& touch = **made;
    Proof proof;
    for (int k = 0; k < touch.ticks(); ++k) {
        const Proxy before = touch.finger().proxy;
        touch.tick(k);
        const reference::Surface truth(touch.scene(), surface.pair_at(k * tick_length_ns));
        if (k > 0) proof.look(truth, before, touch.finger().proxy, touch.contacts()[0]);
    }
    return proof.report(figures);
}

}  // namespace touchable
