#include "haptics_cpu/force_guard.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <utility>

#include "haptics_cpu/sound_contact.hpp"
#include "haptics_cpu/tick_velocity.hpp"

namespace touchable {

namespace {

/// A limited force is this share shorter than the limit, so that no rounding, here or where its length is
/// computed once more, brings it above: a device's limit holds to the last bit.
constexpr double hair = 0x1p-49;

/// Of squares; what lies between this and the limit is looked at closely. It spares most ticks two roots.
constexpr double closely = 1 - 0x1p-40;

/// How much of a force a calmed one is, 0 to 1.
double share_of(const glm::dvec3& blended, const glm::dvec3& force) {
    const double squared = glm::dot(force, force);
    return squared > 0 ? std::clamp(glm::dot(blended, force) / squared, 0.0, 1.0) : 1.0;
}

/// The farthest place in scene units; -1 where no guard can be made of it.
double farthest_place(const GuardSettings& settings, double metres_per_unit) {
    if (!validate(settings) || !(metres_per_unit > 0) || !std::isfinite(metres_per_unit)) return -1;
    return std::min(farthest_metres / metres_per_unit, 1e150);  // its square is finite
}

}  // namespace

ForceGuard::ForceGuard(const GuardSettings& settings, double metres_per_scene_unit)
    : settings_(settings),
      metres_per_unit_(metres_per_scene_unit),
      surely_(settings.max_force * settings.max_force * closely),
      farthest_(farthest_place(settings, metres_per_scene_unit)),
      account_({settings.max_stiffness, settings.max_force}, metres_per_scene_unit),
      stiffness_(settings.rise),
      damping_(settings.damping),
      passivity_(settings.passivity) {}

int ForceGuard::ramp_out_ticks() const {
    return std::max(1, settings_.ramp_out_ticks);
}

bool ForceGuard::is_sound(const Contact& contact, const BlendedForce& blended) const {
    return farthest_ >= 0 && has_sound_forces(contact) && has_sound_places(contact, farthest_) &&
           is_within(blended.force, most_newtons) && blended.presence >= 0 && blended.presence <= 1;
}

/// A step towards no force. Whoever comes back before that finds the ramp at the share that was left.
GuardedForce ForceGuard::ramp_out(double surface_share) {
    if (ticks_faulty_ < ramp_out_ticks()) ++ticks_faulty_;
    const double left = 1.0 - static_cast<double>(ticks_faulty_) / ramp_out_ticks();
    ticks_in_ = ramp_ * left * settings_.ramp_in_ticks;
    account_.lose_goal();
    if (has_let_go()) stiffness_.lift();
    const std::uint32_t stale = surface_share < 1 ? guard_stale : guard_none;
    const GuardedForce out{last_force_ * left * surface_share, guard_fault | stale, account_.figures()};
    return can_go_out(out) ? out : begin_anew();
}

void ForceGuard::let_go() {
    ticks_faulty_ = ramp_out_ticks();
    ticks_in_ = 0;
    ticks_held_ = std::max(ticks_held_, settled_ticks);  // no haste, however far away the hand is now
    last_force_ = glm::dvec3(0.0);
    account_.lose_goal();
    stiffness_.lift();
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
    const double squared = glm::dot(out.force, out.force);
    if (squared <= surely_) return;
    const double length = std::sqrt(squared);
    if (length <= settings_.max_force) return;
    out.force *= settings_.max_force / length * (1 - hair);
    out.reasons |= guard_force;
}

/// Adds the damper and the passivity controller's brake, as far as the contact is to be felt.
void ForceGuard::brake(const Contact& contact, const BlendedForce& blended, double stiffness, int ticks,
                       GuardedForce& out) {
    const bool damped = settings_.damping > 0, controlled = settings_.passivity > 0;
    if (damped || controlled) velocity_ = filtered_velocity(velocity_, account_.step(), ticks);
    if (damped) {
        const double spring = std::min(stiffness, settings_.max_stiffness);
        const glm::dvec3 damper =
            blended.presence *
            damping_.force(account_, spring * share_of(blended.force, contact.force), velocity_, ticks);
        out.force += damper;
        if (damper != glm::dvec3(0.0)) out.reasons |= guard_damping;
    }
    limit(out);
    if (!controlled || !contact.touching) return;
    const glm::dvec3 brake = blended.presence * passivity_.force(account_.excess(), velocity_);
    out.force += brake;
    if (brake != glm::dvec3(0.0)) out.reasons |= guard_passivity;
    limit(out);
}

/// The last word. Written so that NaN stays in.
bool ForceGuard::can_go_out(const GuardedForce& out) const {
    const double squared = glm::dot(out.force, out.force);
    return (squared <= surely_ || std::sqrt(squared) <= settings_.max_force) &&
           std::isfinite(out.energy.balance() - out.energy.bound);
}

/// Where what would go out cannot be, nothing that led to it is believed.
GuardedForce ForceGuard::begin_anew() {
    *this = ForceGuard(settings_, metres_per_unit_);
    return {glm::dvec3(0.0), guard_fault, {}};
}

GuardedForce ForceGuard::guard(const Contact& contact, const BlendedForce& blended, bool is_blended,
                               double surface_share) {
    ticks_held_ = std::min(ticks_held_ + std::clamp(contact.ticks, 1, longest_ticks), longest_ticks);
    if (contact.goal_held || !is_sound(contact, blended)) return ramp_out(surface_share);
    ticks_faulty_ = 0;
    const int ticks = std::exchange(ticks_held_, 0);
    const bool ramping = ticks_in_ < settings_.ramp_in_ticks;
    ramp_ = ramping ? ticks_in_ / settings_.ramp_in_ticks : 1.0;
    const double felt_share = ramp_ * surface_share;

    account_.move(contact, stiffness_.carried(contact), felt_share);
    const double stiffness = stiffness_.in_effect(contact, account_);
    account_.store(stiffness);
    GuardedForce out;
    out.force = spring(contact, blended.force, stiffness, out.reasons);
    GuardedForce alone = out;  // before anything is added
    brake(contact, blended, stiffness, ticks, out);
    if (ramping) {
        out.force *= ramp_;
        out.reasons |= guard_ramp;
        ticks_in_ += 1;
    }
    const glm::dvec3 whole = out.force;
    if (surface_share < 1) {
        out.force *= surface_share;
        out.reasons |= guard_stale;
    }
    glm::dvec3 by_the_jump(0.0);
    if (is_blended) {
        limit(alone);
        by_the_jump = felt_share * alone.force - account_.spring_force();
        out.reasons |= guard_jump;
    }
    account_.hold(out.force, by_the_jump);
    out.energy = account_.figures();
    if (!can_go_out(out)) return begin_anew();
    last_force_ = whole;
    return out;
}

}  // namespace touchable
