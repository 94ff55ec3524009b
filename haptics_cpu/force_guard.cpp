#include "haptics_cpu/force_guard.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {

GuardedForce ForceGuard::ramp_out() {
    ticks_in_ = 0;
    ticks_faulty_ = std::min(ticks_faulty_ + 1, settings_.ramp_out_ticks);
    const double left = 1.0 - static_cast<double>(ticks_faulty_) / std::max(1, settings_.ramp_out_ticks);
    return {last_force_ * left, guard_fault};
}

GuardedForce ForceGuard::guard(const Contact& contact) {
    const double squared = glm::dot(contact.force, contact.force);
    if (contact.goal_held || !std::isfinite(squared)) return ramp_out();
    ticks_faulty_ = 0;

    GuardedForce out{contact.force, guard_none};
    double length = std::sqrt(squared);
    const double k = contact.properties.stiffness;
    if (contact.touching && k > settings_.max_stiffness) {
        const double share = settings_.max_stiffness / k;
        out.force *= share;
        length *= share;
        out.reasons |= guard_stiffness;
    }
    if (length > settings_.max_force) {
        out.force *= settings_.max_force / length;
        out.reasons |= guard_force;
    }
    if (ticks_in_ < settings_.ramp_in_ticks) {
        out.force *= static_cast<double>(ticks_in_) / settings_.ramp_in_ticks;
        out.reasons |= guard_ramp;
        ++ticks_in_;
    }
    last_force_ = out.force;
    return out;
}

}  // namespace touchable
