#include "haptics_cpu/energy_account.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace touchable {

using glm::dot;
using glm::dvec3;

double DeviceSpring::energy(double k, double x2) const {
    k = std::min(k, max_stiffness);
    if (k * k * x2 <= max_force * max_force) return 0.5 * k * x2;
    return max_force * (std::sqrt(x2) - 0.5 * max_force / k);
}

double DeviceSpring::pull(double k, double x2) const {
    k = std::min(k, max_stiffness);
    return k * k * x2 <= max_force * max_force ? k : max_force / std::sqrt(x2);
}

double DeviceSpring::stiffness(double joules, double x2) const {
    const double k = 2.0 * joules / x2;
    if (k * k * x2 <= max_force * max_force) return k;
    const double cut = std::sqrt(x2) - joules / max_force;
    return cut > 0 ? 0.5 * max_force / cut : std::numeric_limits<double>::infinity();
}

void EnergyAccount::move(const Contact& contact, const std::optional<double>& carried_stiffness,
                         double ramp) {
    if (!started_) goal_ = contact.goal;
    started_ = true;
    if (!carried_stiffness) excess_ = 0;

    // The surface moves, the goal does not.
    ramp_ = ramp;
    stiffness_before_ = carried_stiffness;
    energy_before_ = 0;
    dvec3 before(0.0), fresh(0.0);  // the stretch, and what the spring would exert now
    if (carried_stiffness) {
        before = metres_per_unit_ * (contact.carried - goal_);
        const double before2 = dot(before, before);
        energy_before_ = ramp * spring_.energy(*carried_stiffness, before2);
        fresh = ramp * spring_.pull(*carried_stiffness, before2) * before;
    }
    figures_.surface += energy_before_ - figures_.stored;

    // The goal moves against the force that is held.
    step_ = metres_per_unit_ * (contact.goal - goal_);
    work_of_tick_ = dot(held_, step_);
    figures_.work += work_of_tick_;
    const double by_the_jump = dot(blended_, step_);
    figures_.surface += by_the_jump;
    const double bound = std::max(0.0, dot(spring_force_ - fresh, step_));
    figures_.bound += bound;
    excess_ += work_of_tick_ - by_the_jump - energy_before_ - bound;
    x_ = metres_per_unit_ * (contact.proxy - contact.goal);
    x2_ = dot(x_, x_);
    stretched_ = x_ - before;
    goal_ = contact.goal;
}

void EnergyAccount::store(double stiffness) {
    figures_.stored = energy(stiffness);
    spring_force_ = ramp_ * spring_.pull(stiffness, x2_) * x_;
    // The nearest place to the new goal is no farther from it than the place before was, so that the energy
    // grows by -F.dG + k |dG|^2 / 2 at most.
    const double k = std::min(stiffness_before_.value_or(stiffness), spring_.max_stiffness);
    const double bound = 0.5 * ramp_ * k * dot(step_, step_);
    figures_.bound += bound;
    excess_ += figures_.stored - bound;
    figures_.created = std::max(figures_.created, figures_.balance());
}

void EnergyAccount::lose_goal() {
    figures_.surface -= figures_.stored;
    figures_.stored = 0;
    held_ = blended_ = spring_force_ = dvec3(0.0);
}

}  // namespace touchable
