#include "haptics_cpu/jump_cancellation.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "haptics_cpu/sound_contact.hpp"

namespace touchable {

namespace {

using glm::dot;
using glm::dvec3;

/// w: from 1 to 0 as ticks go from 0 to fade_ticks, level at both ends.
double fade(double ticks) {
    const double p = ticks / JumpCancellation::fade_ticks;
    return p < 1 ? 1.0 - p * p * (3.0 - 2.0 * p) : 0.0;
}

/// N/m; a softer spring exerts nothing.
constexpr double least_stiffness = 1e-6;

/// Neither longer than F nor against it, with as little change as that takes.
dvec3 within(const dvec3& force, const dvec3& out) {
    const double f2 = dot(force, force), along = dot(out, force);
    if (!(f2 > 0 && std::isfinite(f2))) return force;
    const dvec3 with = along < 0 ? out - force * (along / f2) : out;
    const double length2 = dot(with, with);
    return length2 > f2 ? with * std::sqrt(f2 / length2) : with;
}

}  // namespace

double JumpCancellation::felt_share(double stiffness) const {
    return stiffness > device_.max_stiffness ? device_.max_stiffness / stiffness : 1.0;
}

/// What the jump alone would make the hand feel.
dvec3 JumpCancellation::felt_jump(const Contact& contact) const {
    return felt_share(contact.carried_stiffness.value_or(contact.properties.stiffness)) *
           contact.jumped_force;
}

void JumpCancellation::reset() {
    surface_is_new_ = device_.waits_to_be_free;
    waiting_ = buried_ = false;
    presence_ = 1;
    jump_ = wanted_ = given_ = dvec3(0.0);
    ticks_ = fade_ticks;
    rested_ = false;
    stiffness_ = 0;
    near_hole_ = false;
}

/// What a hole does to stiffness is spread by the guard (ContactStiffness), which goes by what the spring
/// would exert at the new stiffness. So what is remembered of the spring goes with it: a jump is how far the
/// surface jumped.
void JumpCancellation::follow_hole(const Contact& contact) {
    const double stiffness = std::min(contact.properties.stiffness, device_.max_stiffness);
    const bool near_hole = contact.hole_share > 0;
    if ((near_hole || near_hole_) && stiffness_ > least_stiffness) {
        const double scale = stiffness / stiffness_;
        jump_ *= scale;
        wanted_ *= scale;
        given_ *= scale;
    }
    stiffness_ = stiffness;
    near_hole_ = near_hole;
}

/// From what the hand gets now to nothing.
void JumpCancellation::fall_silent() {
    jump_ = -given_;
    ticks_ = 0;
    if (given_ == dvec3(0.0)) presence_ = 0;
}

void JumpCancellation::meet_new(const dvec3& force) {
    surface_is_new_ = false;
    waiting_ = device_.waits_to_be_free;
    if (waiting_)
        fall_silent();
    else
        begin(force);
}

void JumpCancellation::begin(const dvec3& jumped_force) {
    const bool was_buried = buried_;
    buried_ = dot(jumped_force, jumped_force) > device_.max_force * device_.max_force;
    if (buried_) {
        if (!was_buried) fall_silent();
        return;
    }
    if (was_buried) {
        jump_ = jumped_force - given_;
        ticks_ = 0;
        return;
    }
    // What is left of an earlier jump fades on, from where it is. For both there is one clock; it shows the
    // mean of theirs, so that a row of small jumps is followed and not held back for ever.
    const dvec3 added = jumped_force - wanted_;
    const double before = rested_ ? fade(ticks_) : fade(ticks_ - 1);
    const double left = fade(ticks_) > 0 ? fade(ticks_) / before : 0.0;
    const dvec3 rest = (wanted_ - given_) * left;
    const double rest_n = std::sqrt(dot(rest, rest)), added_n = std::sqrt(dot(added, added));
    ticks_ = rest_n > 0 ? ticks_ * (rest_n / (rest_n + added_n)) : 0.0;
    jump_ = (rest + added) / fade(ticks_);
}

BlendedForce JumpCancellation::calm(const Contact& contact) {
    if (!has_sound_forces(contact)) return {contact.force};
    follow_hole(contact);
    const double share = felt_share(contact.properties.stiffness);
    const dvec3 felt = share * contact.force;
    // Most ticks by far: nothing jumped, and there is nothing to fade.
    if (!surface_is_new_ && !contact.jumped && !is_silent() && ticks_ >= fade_ticks && presence_ >= 1) {
        wanted_ = given_ = felt;
        return {contact.force};
    }
    if (!contact.touching) {
        buried_ = false;
        ticks_ = fade_ticks;
        presence_ = 1;
        // A finger whose goal is not known is not known to be free.
        if (!contact.goal_held) surface_is_new_ = waiting_ = false;
    } else if (surface_is_new_) {
        meet_new(felt);
    } else if (contact.jumped && !waiting_) {
        begin(felt_jump(contact));
    }
    BlendedForce out;
    out.presence = presence_;
    out.waiting = waiting_ && contact.touching;
    wanted_ = is_silent() ? dvec3(0.0) : felt;
    given_ = felt;
    out.force = contact.force;
    if (is_silent() || ticks_ < fade_ticks) {
        given_ = within(felt, wanted_ - fade(ticks_) * jump_);
        out.force = given_ / share;
        if (!contact.goal_held) ticks_ = std::min(ticks_ + 1.0, static_cast<double>(fade_ticks));
    }
    rested_ = contact.goal_held;
    if (!contact.goal_held)
        presence_ = std::clamp(presence_ + (is_silent() ? -1.0 : 1.0) / fade_ticks, 0.0, 1.0);
    out.difference = out.force - contact.force;
    out.active = out.difference != dvec3(0.0);
    return out;
}

}  // namespace touchable
