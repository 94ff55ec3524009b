// SPDX-License-Identifier: Apache-2.0
#include "bench/real/resting.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "bench/clocks.hpp"
#include "bench/touch/force_spectrum.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {
namespace {

constexpr double rest_under_mm = 3;
constexpr double band_from_hz = 20, band_to_hz = 500, ticks_per_second = 1000;
constexpr int ticks_of_a_spectrum = 1024;

/// The frames around a tick's time; nothing after the last pair.
std::optional<FramePair> frames_around(const Scene& scene, const std::vector<SurfaceFrame>& frames,
                                       std::int64_t time_ns) {
    std::int64_t n = 0;
    while (scene.rate.time_ns(n + 1) <= time_ns) ++n;
    if (n + 1 >= static_cast<std::int64_t>(frames.size())) return std::nullopt;
    const auto timed = [&](std::int64_t number) {
        return TimedFrame{number, scene.rate.time_ns(number), &frames[static_cast<std::size_t>(number)]};
    };
    FramePair pair{timed(n), timed(n + 1), 0};
    pair.blend = static_cast<double>(time_ns - pair.prev.time_ns) /
                 static_cast<double>(pair.next.time_ns - pair.prev.time_ns);
    return pair;
}

/// One finger's force: a series per world axis.
struct RestingForce {
    std::vector<double> axes[3];
    double greatest_step = 0;

    void add(const glm::dvec3& force) {
        if (!axes[0].empty())
            greatest_step =
                std::max(greatest_step,
                         glm::distance(force, glm::dvec3(axes[0].back(), axes[1].back(), axes[2].back())));
        for (int axis = 0; axis < 3; ++axis) axes[axis].push_back(force[axis]);
    }
    double band() const {
        double power = 0;
        for (const auto& axis : axes) power += band_power(axis, ticks_per_second, band_from_hz, band_to_hz);
        return power;
    }
};

}  // namespace

Result<void> measure_rest(const Scene& scene, const std::vector<SurfaceFrame>& frames,
                          const std::vector<DepthPlane>& planes, int settled, Figures& figures) {
    const auto solver = TouchSolver::create(scene, {});
    if (!solver) return solver.error();
    std::vector<glm::dvec3> goals;
    for (const DepthPlane& plane : planes)
        goals.push_back(unproject(scene.camera, plane.x, plane.y, 1 / plane.at) -
                        rest_under_mm * normal_of(plane, scene.camera));
    std::vector<FingerState> fingers(goals.size());
    std::vector<Contact> contacts(goals.size());
    std::vector<RestingForce> forces(goals.size());
    const std::int64_t begin_ns = scene.rate.time_ns(settled);
    for (std::int64_t time_ns = 0; time_ns < begin_ns + ticks_of_a_spectrum * tick_length_ns;
         time_ns += tick_length_ns) {
        const auto pair = frames_around(scene, frames, time_ns);
        if (!pair) return Error{ErrorKind::check, scene.name + ": too few frames to rest on"};
        solver->tick(HeightField(scene, *pair), goals, fingers, contacts);
        for (std::size_t k = 0; time_ns >= begin_ns && k < forces.size(); ++k)
            forces[k].add(contacts[k].force);
    }
    double power = 0, step = 0;
    for (const RestingForce& force : forces) {
        power += force.band();
        step = std::max(step, force.greatest_step);
    }
    figures.push_back({"force_band_mn", 1000 * std::sqrt(power / static_cast<double>(forces.size())), "mN"});
    figures.push_back({"force_step_n_max", step, "N"});
    return {};
}

}  // namespace touchable
