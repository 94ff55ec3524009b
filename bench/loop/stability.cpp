// SPDX-License-Identifier: Apache-2.0
#include "bench/loop/stability.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

namespace touchable {
namespace {

constexpr double nudge = 0.005;     // m/s
constexpr double loud = 3 * nudge;  // RMS speed that no nudge explains
constexpr double silent = 1e-7;     // m/s; rounding errors
constexpr double quieter = 0.97;    // ratio below which the motion is coming to rest
constexpr double lowest_stiffness = 20, rung = 1.4142135623730951, precision = 1.01;

/// RMS speed over some ticks.
class Loudness {
public:
    void add(const glm::dvec3& velocity) {
        sum_ += glm::dot(velocity, velocity);
        ++count_;
    }
    double value() const { return std::sqrt(sum_ / count_); }

private:
    double sum_ = 0;
    int count_ = 0;
};

/// Ticks of a quarter of a trial. Near the boundary, oscillations of a body with damping b grow or decay by
/// exp(-(1 - K/boundary) b/(2m) t); two quarters are at least 10 m/b.
int quarter_ticks(const HandleDynamics& handle) {
    constexpr double least_s = 0.5, most_s = 10;
    const double s = handle.damping > 0 ? 5 * handle.mass / handle.damping : most_s;
    return static_cast<int>(std::clamp(s, least_s, most_s) / ClosedLoop::period_s);
}

}  // namespace

double colgate_schenkel_bound(const HandleDynamics& handle) {
    return 2 * handle.damping / ClosedLoop::period_s;
}

double gil_bound(const HandleDynamics& handle, int delay_ticks) {
    return handle.damping / (ClosedLoop::period_s * (0.5 + delay_ticks));
}

double abbott_okamura_bound(const HandleDynamics& handle) {
    const double viscous = colgate_schenkel_bound(handle);
    return handle.quantum > 0 ? std::min(viscous, 2 * handle.friction / handle.quantum) : viscous;
}

Result<LoopFate> fate_of(const TouchSurface& surface, const LoopCase& c, const PressedPlace& place,
                         double stiffness) {
    auto nudged = ClosedLoop::create(surface, c, place, stiffness, nudge);
    if (!nudged) return nudged.error();
    std::optional<ClosedLoop> calm;
    if (surface.moves()) {
        auto made = ClosedLoop::create(surface, c, place, stiffness, 0);
        if (!made) return made.error();
        calm.emplace(std::move(*made));
    }
    const int quarter = quarter_ticks(c.handle);
    Loudness before, after;
    int touching = 0;
    for (int k = 0; k < 4 * quarter; ++k) {
        nudged->tick();
        glm::dvec3 motion = nudged->handle().velocity();
        if (calm) {
            calm->tick();
            motion -= calm->handle().velocity();
        }
        if (k / quarter == 1) before.add(motion);
        if (k / quarter == 3) {
            after.add(motion);
            touching += nudged->touching();
        }
    }
    const bool rests =
        after.value() < silent || (after.value() < quieter * before.value() && after.value() < loud);
    if (!rests) return LoopFate::shakes;
    return touching > quarter / 2 ? LoopFate::rests : LoopFate::leaves;
}

Result<double> stability_boundary(const TouchSurface& surface, const LoopCase& c, const PressedPlace& place) {
    const double quantum = c.handle.quantum;
    const double highest =
        quantum > 0 ? std::min(highest_stiffness, ClosedLoop::press_n / quantum) : highest_stiffness;
    double stable = 0, shaking = lowest_stiffness;
    while (shaking < highest) {
        const auto fate = fate_of(surface, c, place, shaking);
        if (!fate) return fate.error();
        if (*fate == LoopFate::shakes) break;
        if (*fate == LoopFate::leaves && stable == 0)
            return Error{ErrorKind::check, "the finger slides off the surface: there is nothing to measure"};
        if (*fate == LoopFate::leaves) return shaking;
        stable = shaking;
        shaking *= rung;
    }
    if (shaking >= highest) return highest;
    while (shaking > stable * precision && shaking > 1) {
        const double between = stable > 0 ? std::sqrt(stable * shaking) : 0.5 * shaking;
        const auto fate = fate_of(surface, c, place, between);
        if (!fate) return fate.error();
        (*fate == LoopFate::shakes ? shaking : stable) = between;
    }
    return stable;
}

}  // namespace touchable
