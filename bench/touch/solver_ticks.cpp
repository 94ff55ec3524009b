// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/solver_ticks.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <string>
#include <utility>

#include "bench/clocks.hpp"

namespace touchable {
namespace {

Error wrong(int tick, std::size_t finger, const char* fault) {
    return {ErrorKind::check,
            "tick " + std::to_string(tick) + ", finger " + std::to_string(finger) + ": " + fault};
}

}  // namespace

SolverTicks::SolverTicks(PairAt pair_at, const Scene& scene, const TouchSolver& solver, int fingers,
                         std::vector<glm::dvec3> goals)
    : pair_at_(std::move(pair_at)),
      scene_(scene),
      solver_(solver),
      goals_(std::move(goals)),
      fingers_(static_cast<std::size_t>(fingers)),
      contacts_(fingers_.size()) {}

Result<std::unique_ptr<SolverTicks>> SolverTicks::create(const TouchSurface& surface, const TouchCase& c,
                                                         const HapticProperties& properties,
                                                         std::vector<glm::dvec3> goals) {
    TouchSettings settings;
    settings.metric = c.metric;
    settings.metres_per_scene_unit = surface.scene().device_metres_per_unit.value();
    const auto solver = TouchSolver::create(surface.scene(), settings);
    if (!solver) return solver.error();
    Scene scene = surface.scene();
    scene.default_properties = properties;
    if (c.hold) scene.interpolation = FrameInterpolation::hold;
    return std::make_unique<SolverTicks>([&surface](std::int64_t ns) { return surface.pair_at(ns); }, scene,
                                         *solver, c.fingers, std::move(goals));
}

void SolverTicks::restart() {
    fingers_.assign(fingers_.size(), {});
}

HeightField SolverTicks::field(int k) const {
    return {scene_, pair_at_(k * tick_length_ns)};
}

void SolverTicks::tick(int k) {
    const auto goals =
        std::span(goals_).subspan(static_cast<std::size_t>(k) * fingers_.size(), fingers_.size());
    solver_.tick(field(k), goals, fingers_, contacts_);
}

FramePair frames_around(const FrameRate& rate, std::span<const SurfaceFrame> frames, std::int64_t time_ns) {
    std::int64_t n = time_ns * rate.num / (rate.den * 1'000'000'000);
    while (rate.time_ns(n + 1) <= time_ns) ++n;
    const auto timed = [&](std::int64_t number) {
        return TimedFrame{number, rate.time_ns(number),
                          &frames[static_cast<std::size_t>(number) % frames.size()]};
    };
    FramePair pair{timed(n), timed(n + 1)};
    pair.blend = static_cast<double>(time_ns - pair.prev.time_ns) /
                 static_cast<double>(pair.next.time_ns - pair.prev.time_ns);
    return pair;
}

void add_figures(const RunCounts& counts, double mean_us, Figures& figures) {
    figures.push_back({"cells_per_tick", counts.cells_per_tick, ""});
    figures.push_back({"ns_per_cell", 1000 * mean_us / counts.cells_per_tick, "ns"});
    figures.push_back({"events_mean", counts.events_mean, ""});
    figures.push_back({"events_max", static_cast<double>(counts.events_max), ""});
    figures.push_back({"capped_ticks", static_cast<double>(counts.capped_ticks), ""});
}

double behind_tolerance(TouchMetric metric) {
    return metric == TouchMetric::world ? 1e-9 : 1e-3;
}

const char* fault_of(const Contact& contact, const HeightField& field, double metres_per_scene_unit,
                     double tolerance) {
    const glm::dvec3 spring =
        contact.properties.stiffness * metres_per_scene_unit * (contact.proxy - contact.goal);
    const glm::dvec3 off = contact.force - spring;
    // Written so that NaN counts as a fault.
    if (!(glm::dot(off, off) <= 1e-24 * glm::dot(spring, spring)))
        return "the force is not k S (P - G), or not finite";
    if (is_behind_surface(field, contact.proxy, tolerance)) return "the proxy is behind the surface";
    return nullptr;
}

Result<RunCounts> verify(SolverTicks& run) {
    run.restart();
    RunCounts counts;
    const double tolerance = behind_tolerance(run.metric());
    double cells = 0, events = 0, contact_ticks = 0, finger_ticks = 0;
    for (int k = 0; k < run.ticks(); ++k) {
        run.tick(k);
        const HeightField field = run.field(k);
        const auto contacts = run.contacts();
        bool capped = false;
        for (std::size_t finger = 0; finger < contacts.size(); ++finger) {
            const Contact& contact = contacts[finger];
            if (const char* fault = fault_of(contact, field, run.metres_per_scene_unit(), tolerance))
                return wrong(k, finger, fault);
            cells += contact.counts.cells + contact.counts.events;
            events += contact.counts.events;
            contact_ticks += contact.touching;
            counts.events_max = std::max(counts.events_max, contact.counts.events);
            capped |= contact.counts.capped;
        }
        finger_ticks += static_cast<double>(contacts.size());
        counts.capped_ticks += capped;
    }
    if (!(contact_ticks >= 0.5 * finger_ticks))
        return Error{ErrorKind::check,
                     "less than half of the ticks are in contact: there is nothing to time"};
    counts.cells_per_tick = cells / run.ticks();
    counts.events_mean = events / contact_ticks;
    return counts;
}

}  // namespace touchable
