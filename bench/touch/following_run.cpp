// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/following_run.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>

#include "bench/touch/solver_ticks.hpp"
#include "tests/content/exact_touch.hpp"

namespace touchable {
namespace {

constexpr double off_surface = 2;     // scene units (mm); larger distance from the true closest point
constexpr double surely_under = 0.5;  // mm of the goal under the surface; far more than facets and codes
constexpr HapticProperties smooth{600, 0, 0};

std::vector<ReliefStroke::Goal> stroke_of(const FollowingRun& run) {
    ReliefStroke stroke(relief_of(run.setup.scene), run.setup.width, run.setup.height, run.speed);
    std::vector<ReliefStroke::Goal> goals;
    for (int k = 0; k < run.ticks; ++k) goals.push_back(stroke.next());
    return goals;
}

}  // namespace

Result<void> measure_following(const TouchSurface& surface, const FollowingRun& run, Figures& figures) {
    const std::vector<ReliefStroke::Goal> stroke = stroke_of(run);
    std::vector<glm::dvec3> goals;
    for (const auto& step : stroke) goals.push_back(step.goal);
    auto made = SolverTicks::create(surface, run.setup, smooth, goals);
    if (!made) return made.error();
    SolverTicks& touch = **made;

    int under = 0, off = 0, lost = 0;
    double farthest = 0, squared = 0, largest_step = 0;
    glm::dvec3 last_force(0.0);
    std::optional<glm::dvec3> nearest;  // nearest point of the true surface, tracked from tick to tick
    for (int k = 0; k < run.ticks; ++k) {
        touch.tick(k);
        const auto& [goal, depth_under] = stroke[static_cast<std::size_t>(k)];
        if (depth_under < surely_under) continue;
        const auto truth = surface.exact().closest(goal, nearest.value_or(goal), k * 0.001);
        if (!truth) return Error{ErrorKind::internal, "scene " + run.setup.scene + " knows no closest point"};
        nearest = truth->point;
        const Contact& contact = touch.contacts()[0];
        const double distance = length(contact.proxy - *nearest);
        ++under;
        lost += !contact.touching;
        off += !(distance <= off_surface);
        farthest = std::max(farthest, distance);
        squared += distance * distance;
        if (under > 1) largest_step = std::max(largest_step, length(contact.force - last_force));
        last_force = contact.force;
    }
    if (under == 0)
        return Error{ErrorKind::check, "no goal lies under the surface: there is nothing to follow"};
    figures.push_back({"off_surface_pct", 100.0 * off / under, "%"});
    figures.push_back({"contact_lost_ticks", static_cast<double>(lost), ""});
    figures.push_back({"distance_mm_rms", std::sqrt(squared / under), "mm"});
    figures.push_back({"distance_mm_max", farthest, "mm"});
    figures.push_back({"force_step_n_max", largest_step, "N"});
    add_figures(time_hot(touch, run.repeats), "", figures);
    return {};
}

}  // namespace touchable
