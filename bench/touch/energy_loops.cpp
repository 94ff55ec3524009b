// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "bench/touch/globe_run.hpp"
#include "bench/touch/solver_ticks.hpp"
#include "engine/base/same_bits.hpp"
#include "engine/content/families.hpp"

namespace touchable {
namespace {

// Device millimetres.
constexpr double slide = 5, press = 2, clearance = 1;
constexpr double polar_angle = 45 * pi / 180;
constexpr std::array faster_steps{0.01, 0.1};  // mm per tick of the goal: 10 and 100 mm/s
constexpr double infinity = std::numeric_limits<double>::infinity();

/// A rectangular path in the plane of the globe's axis and a flank: from outside straight in, along, out, and
/// back through free space.
class FlankLoop {
public:
    FlankLoop(const GlobeSphere& sphere, double azimuth)
        : scale_(sphere.radius / (1000 * globe_device_radius)) {
        const glm::dvec3 aside{cosine(azimuth), sine(azimuth), 0};
        const glm::dvec3 axis{0, 0, 1};
        out_ = sine(polar_angle) * aside + cosine(polar_angle) * axis;
        limbward_ = cosine(polar_angle) * aside - sine(polar_angle) * axis;
        touching_ = sphere.centre + sphere.radius * out_;
    }

    /// `step`: device millimetres. `limbward`: slide under the surface away from the axis, else towards it.
    std::vector<glm::dvec3> goals(double step, bool limbward) const {
        const double near = limbward ? -slide / 2 : slide / 2, far = -near;
        const std::array corners{at(near, clearance), at(near, -press), at(far, -press), at(far, clearance),
                                 at(near, clearance)};
        std::vector<glm::dvec3> path{corners[0]};
        for (std::size_t side = 0; side + 1 < corners.size(); ++side) {
            const glm::dvec3 way = corners[side + 1] - corners[side];
            const int steps = static_cast<int>(std::ceil(std::sqrt(glm::dot(way, way)) / (step * scale_)));
            for (int k = 1; k <= steps; ++k)
                path.push_back(corners[side] + way * (static_cast<double>(k) / steps));
        }
        return path;
    }

private:
    glm::dvec3 at(double along, double outside) const {
        return touching_ + (along * limbward_ + outside * out_) * scale_;
    }
    double scale_;  // scene units per device millimetre
    glm::dvec3 out_, limbward_, touching_;
};

/// Work on the hand over a loop, millijoules.
struct Work {
    /// With the mean of the forces at both ends of each step, which excludes the leak of sampling.
    double created = 0;
    double held = 0;  ///< with the force at the beginning of each step, as exerted by a device
    /// Limit of the energy from holding: sum of k/2 |G_k - G_k-1|^2 over the steps in contact. It holds for
    /// any surface if the proxy never gets farther from the goal than its previous position is
    /// (docs/solver.md).
    double bound = 0;
};

Work work_of(SolverTicks& touch) {
    touch.restart();
    Work work;
    Contact last;
    for (int k = 0; k < touch.ticks(); ++k) {
        touch.tick(k);
        const Contact& contact = touch.contacts()[0];
        if (k > 0) {
            const glm::dvec3 step = (contact.goal - last.goal) * touch.metres_per_scene_unit();
            work.created += 500 * glm::dot(last.force + contact.force, step);
            work.held += 1000 * glm::dot(last.force, step);
            const double stiffness = std::max(last.properties.stiffness, contact.properties.stiffness);
            work.bound += 500 * stiffness * glm::dot(step, step);
        }
        last = contact;
    }
    return work;
}

}  // namespace

Result<void> measure_energy(const TouchSurface& surface, const GlobeRun& run, Figures& figures) {
    const TouchCase& c = run.setup;
    const GlobeSphere sphere = globe_sphere(c.preset, c.width, c.height);
    double limbward = 0, inward = 0, larger = 0, largest = -infinity, over_bound = -infinity;
    std::array held{-infinity, -infinity, -infinity};
    for (int flank = 0; flank < run.flanks; ++flank) {
        const FlankLoop loop(sphere, 0.2 + 2 * pi * flank / run.flanks);
        std::array<double, 2> created{};
        for (const bool way : {false, true}) {
            for (std::size_t speed = 0; speed < held.size(); ++speed) {
                const double step = speed == 0 ? run.loop_step_mm : faster_steps[speed - 1];
                auto made =
                    SolverTicks::create(surface, c, surface.scene().default_properties, loop.goals(step, way));
                if (!made) return made.error();
                const Work work = work_of(**made);
                if (speed == 0) created[way] = work.created;
                held[speed] = std::max(held[speed], work.held);
                over_bound = std::max(over_bound, work.held / work.bound);
            }
        }
        inward += created[0] / run.flanks;
        limbward += created[1] / run.flanks;
        larger += std::max(created[0], created[1]) / run.flanks;
        largest = std::max({largest, created[0], created[1]});
    }
    figures.push_back({"energy_created_mj", larger, "mJ"});
    figures.push_back({"energy_created_mj_limbward", limbward, "mJ"});
    figures.push_back({"energy_created_mj_inward", inward, "mJ"});
    figures.push_back({"energy_created_mj_max", largest, "mJ"});
    figures.push_back({"energy_held_mj_slow", held[0], "mJ"});
    figures.push_back({"energy_held_mj_10mm_s", held[1], "mJ"});
    figures.push_back({"energy_held_mj_100mm_s", held[2], "mJ"});
    figures.push_back({"energy_held_over_bound", over_bound, ""});
    return {};
}

}  // namespace touchable
