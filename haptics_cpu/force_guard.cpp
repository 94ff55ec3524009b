#include "haptics_cpu/force_guard.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "haptics_cpu/tick_velocity.hpp"

namespace touchable {

namespace {

/// A limited force is this share shorter than the limit, so that no rounding, here or where its length is
/// computed once more, brings it above: a device's limit holds to the last bit.
constexpr double hair = 0x1p-49;

}  // namespace

ForceGuard::ForceGuard(const GuardSettings& settings, double metres_per_scene_unit)
    : settings_(settings),
      account_({settings.max_stiffness, settings.max_force}, metres_per_scene_unit),
      stiffness_(settings.rise),
      damping_(settings.damping),
      passivity_(settings.passivity) {}

GuardedForce ForceGuard::ramp_out() {
    ticks_in_ = 0;
    ticks_faulty_ = std::min(ticks_faulty_ + 1, settings_.ramp_out_ticks);
    const double left = 1.0 - static_cast<double>(ticks_faulty_) / std::max(1, settings_.ramp_out_ticks);
    account_.lose_goal();
    stiffness_.lift();
    damping_.lift();
    velocity_ = glm::dvec3(0.0);
    return {last_force_ * left, guard_fault, account_.figures()};
}

glm::dvec3 ForceGuard::spring(const Contact& contact, const glm::dvec3& unlimited, double stiffness,
                              std::uint32_t& reasons) const {
    glm::dvec3 force = unlimited;
    if (!contact.touching) return force;
    const double map = contact.properties.stiffness;
    if (stiffness < map) {
        force *= stiffness / map;
        reasons |= guard_rise;
    }
    if (stiffness > settings_.max_stiffness) {
        force *= settings_.max_stiffness / stiffness;
        reasons |= guard_stiffness;
    }
    return force;
}

void ForceGuard::limit(GuardedForce& out) const {
    const double length = std::sqrt(glm::dot(out.force, out.force));
    if (length <= settings_.max_force) return;
    out.force *= settings_.max_force / length * (1 - hair);
    out.reasons |= guard_force;
}

GuardedForce ForceGuard::guard(const Contact& contact, const glm::dvec3& force, bool calmed) {
    ticks_held_ = std::min(ticks_held_ + std::clamp(contact.ticks, 1, longest_ticks), longest_ticks);
    if (contact.goal_held || !std::isfinite(glm::dot(contact.force, contact.force))) return ramp_out();
    ticks_faulty_ = 0;
    const int passed = std::exchange(ticks_held_, 0);
    const bool ramping = ticks_in_ < settings_.ramp_in_ticks;
    const double ramp = ramping ? static_cast<double>(ticks_in_) / settings_.ramp_in_ticks : 1.0;

    account_.move(contact, stiffness_.carried(contact), ramp);
    const double stiffness = stiffness_.in_effect(contact, account_);
    account_.store(stiffness);
    GuardedForce out;
    out.force = spring(contact, force, stiffness, out.reasons);
    GuardedForce alone = out;  // before anything is added
    const bool damped = settings_.damping > 0, controlled = settings_.passivity > 0;
    if (damped || controlled) velocity_ = filtered_velocity(velocity_, account_.step(), passed);
    if (damped) {
        const glm::dvec3 damper =
            damping_.force(account_, std::min(stiffness, settings_.max_stiffness), velocity_, passed);
        out.force += damper;
        if (damper != glm::dvec3(0.0)) out.reasons |= guard_damping;
    }
    limit(out);
    if (ramping) {
        out.force *= ramp;
        out.reasons |= guard_ramp;
        ++ticks_in_;
    }
    if (controlled && contact.touching) {
        const glm::dvec3 brake = passivity_.force(account_.excess(), velocity_);
        out.force += brake;
        if (brake != glm::dvec3(0.0)) out.reasons |= guard_passivity;
        limit(out);
    }
    glm::dvec3 by_the_jump(0.0);
    if (calmed) {
        limit(alone);
        by_the_jump = ramp * alone.force - account_.spring_force();
        out.reasons |= guard_jump;
    }
    account_.hold(out.force, by_the_jump);
    out.energy = account_.figures();
    last_force_ = out.force;
    return out;
}

}  // namespace touchable
