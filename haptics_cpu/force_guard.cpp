// SPDX-License-Identifier: Apache-2.0
#include "haptics_cpu/force_guard.hpp"

#include <glm/geometric.hpp>

namespace touchable {

namespace {

using glm::dot;
using glm::dvec3;

// No device and no scene gives values beyond these. Squares and products of values within them are finite.
constexpr double most_newtons = 1e30, most_newtons_per_metre = 1e15, farthest_metres = 1e12;

/// False for NaN, too.
bool is_within(const dvec3& v, double most) {
    return dot(v, v) <= most * most;
}
bool is_stiffness(double newtons_per_metre) {
    return newtons_per_metre >= 0 && newtons_per_metre <= most_newtons_per_metre;
}

/// Whether the forces of a contact can be used: numbers, and within the limits above.
bool has_sound_forces(const Contact& contact) {
    return is_within(contact.force, most_newtons) && is_stiffness(contact.properties.stiffness) &&
           (!contact.jumped || is_within(contact.jumped_force, most_newtons));
}

/// The same for its positions; `farthest`: farthest_metres in scene units.
bool has_sound_places(const Contact& contact, double farthest) {
    const double squares = dot(contact.goal, contact.goal) + dot(contact.proxy, contact.proxy) +
                           dot(contact.carried, contact.carried);
    return squares <= farthest * farthest &&
           (!contact.carried_stiffness || is_stiffness(*contact.carried_stiffness));
}

Error must_be(const char* name, const char* range, Hints hints = {}) {
    return usage_error(std::string(name) + " must be a number " + range, std::move(hints));
}

// Less than this is rounding of the books, and too little for a hand to feel.
constexpr double least_joules = 1e-9;

/// w: from 1 to 0 as ticks go from 0 to fade_ticks, level at both ends.
double fade(double ticks) {
    const double p = ticks / JumpCancellation::fade_ticks;
    return p < 1 ? 1.0 - p * p * (3.0 - 2.0 * p) : 0.0;
}

/// The largest slope of `fade`, of the whole in a tick.
constexpr double steepest_fade = 1.5 / JumpCancellation::fade_ticks;

/// N/m; a softer spring exerts nothing.
constexpr double least_stiffness = 1e-6;

/// Makes `out` neither longer than `force` nor opposed to it, with the least change.
dvec3 within(const dvec3& force, const dvec3& out) {
    const double f2 = dot(force, force), along = dot(out, force);
    if (!(f2 > 0 && std::isfinite(f2))) return force;
    const dvec3 with = along < 0 ? out - force * (along / f2) : out;
    const double length2 = dot(with, with);
    return length2 > f2 ? with * std::sqrt(f2 / length2) : with;
}

/// A limited force is this share shorter than the limit, so that no rounding, here or when its length is
/// computed again, brings it above: a device's limit holds to the last bit.
constexpr double hair = 0x1p-49;

/// Share of the device's force that may come back in a tick in which the hand stands still.
constexpr double largest_return = 0.01;

/// For squares: values between this share of the limit and the limit are checked exactly. Saves two roots.
constexpr double closely = 1 - 0x1p-40;

/// Share of a force that is left after calming, 0 to 1.
double share_of(const dvec3& blended, const dvec3& force) {
    const double squared = dot(force, force);
    return squared > 0 ? std::clamp(dot(blended, force) / squared, 0.0, 1.0) : 1.0;
}

/// The farthest position in scene units; -1 if no guard can be made with these settings.
double farthest_place(const GuardSettings& settings, double metres_per_unit) {
    if (!validate(settings) || !(metres_per_unit > 0) || !std::isfinite(metres_per_unit)) return -1;
    return std::min(farthest_metres / metres_per_unit, 1e150);  // its square is finite
}

}  // namespace

// Written so that NaN is refused.
Result<void> validate(const GuardSettings& settings) {
    if (!(settings.max_force >= 1e-6 && settings.max_force <= 1e9))
        return must_be("the device's force", "from 1e-6 to 1e9 N", {{Setting::max_force}});
    if (!(settings.max_stiffness >= 1e-3 && settings.max_stiffness <= 1e12))
        return must_be("the device's stiffness", "from 1e-6 to 1e9 N/mm", {{Setting::max_stiffness}});
    if (settings.ramp_in_ticks < 0 || settings.ramp_out_ticks < 0)
        return must_be("a ramp of force", "of ticks, 0 or more");
    if (!(settings.rise.per_tick > 0))
        return must_be("the rise of stiffness", "above 0 N/mm per second", {{Setting::stiffness_rise}});
    if (!(settings.damping >= 0 && std::isfinite(settings.damping)))
        return must_be("damping", "of N s/m, 0 or more", {{Setting::damping}});
    if (!(settings.passivity >= 0 && std::isfinite(settings.passivity)))
        return must_be("the passivity controller's damping", "of N s/m, 0 or more", {{Setting::passivity}});
    if (settings.stale_after_ns < 0 || settings.stale_after_ns > 3'600'000'000'000)
        return must_be("the age of a stale surface", "from 0 to 3600000 ms", {{Setting::stale_after}});
    return {};
}

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

    // The goal moves against the held force.
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
    // The nearest place to the new goal is no farther from it than the previous place, so the energy grows by
    // -F.dG + k |dG|^2 / 2 at most.
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

/// Whether JumpCancellation brings on the stiffness.
bool ContactStiffness::has_jumped(const Contact& contact) const {
    return contact.jumped && !rise_.paid && !from_hole_ && contact.hole_share == 0;
}

std::optional<double> ContactStiffness::carried(const Contact& contact) const {
    if (!limited_ || !contact.carried_stiffness || has_jumped(contact)) return contact.carried_stiffness;
    return std::min(*contact.carried_stiffness, stiffness_);
}

double ContactStiffness::held(const Contact& contact) const {
    const double map = contact.properties.stiffness;
    return limited_ ? std::min(map, stiffness_) : map;
}

/// The stiffness of the next tick of a contact.
double ContactStiffness::risen(double before, double map, const EnergyAccount& account) {
    double most = rise_.per_tick;
    const double stretch2 = dot(account.stretch(), account.stretch());
    if (from_hole_ && stretch2 > 0) most = std::min(most, rise_from_hole / std::sqrt(stretch2));
    // At constant stiffness, holding a force creates a little energy; friction and drops lose much.
    const double stays = account.energy(before);
    paid_ += std::max(0.0, account.allowed() - stays);
    const double stiffness = std::min(map, before + most);
    const double cost = account.energy(stiffness) - stays;
    if (!rise_.paid || cost <= paid_) {
        paid_ = std::max(0.0, paid_ - cost);
        return stiffness;
    }
    const double affordable = std::clamp(account.stiffness(stays + paid_), before, stiffness);
    paid_ = 0;
    return affordable;
}

double ContactStiffness::in_effect(const Contact& contact, const EnergyAccount& account) {
    const double map = contact.properties.stiffness;
    from_hole_ = from_hole_ || contact.hole_share > 0;
    if (!rise_.limited() && !from_hole_) return map;
    const std::optional<double> carried = this->carried(contact);
    if (carried && contact.touching && !has_jumped(contact)) {
        stiffness_ = risen(*carried, map, account);
    } else {
        paid_ = 0;
        stiffness_ = map;
    }
    from_hole_ = contact.touching && (contact.hole_share > 0 || (from_hole_ && stiffness_ < map));
    limited_ = contact.touching && (rise_.limited() || from_hole_);
    return stiffness_;
}

dvec3 ContactDamping::force(const EnergyAccount& account, double stiffness, const dvec3& velocity,
                            int ticks) {
    if (!(stiffness > 0)) {
        lift();
        return dvec3(0.0);
    }
    rate_ = filtered_velocity(rate_, account.stretched(), ticks);
    const dvec3 damper = b_ * rate_;
    if (dot(damper, velocity) > 0) return dvec3(0.0);
    const dvec3& stretch = account.stretch();
    const double inward = -dot(damper, stretch), spring = stiffness * dot(stretch, stretch);
    if (spring == 0) return dvec3(0.0);
    return inward > spring ? damper * (spring / inward) : damper;
}

dvec3 PassivityController::force(double excess, const dvec3& velocity) const {
    const double speed2 = dot(velocity, velocity);
    if (!(excess > least_joules) || !(speed2 > 0)) return dvec3(0.0);
    return velocity * -std::min(excess / (tick_seconds * speed2), most_);
}

double JumpCancellation::felt_share(double stiffness) const {
    return stiffness > device_.max_stiffness ? device_.max_stiffness / stiffness : 1.0;
}

/// What the hand would feel of the jump alone.
dvec3 JumpCancellation::felt_jump(const Contact& contact, double stiffness) const {
    const double there = contact.carried_stiffness.value_or(contact.properties.stiffness);
    const bool rises = stiffness < contact.properties.stiffness && stiffness < there;
    return felt_share(rises ? stiffness : there) * (rises ? stiffness / there : 1.0) * contact.jumped_force;
}

void JumpCancellation::reset() {
    surface_is_new_ = device_.waits_to_be_free;
    waiting_ = buried_ = false;
    presence_ = share_ = 1;
    wanted_ = given_ = goal_ = dvec3(0.0);
    ticks_ = fade_ticks;
    weight_ = 0;
    stiffness_ = 0;
    near_hole_ = false;
}

/// The guard spreads the effect of a hole on stiffness (ContactStiffness), by the force of the spring at the
/// new stiffness. So the remembered spring forces are scaled with it: a jump is how far the surface jumped.
void JumpCancellation::follow_hole(const Contact& contact, double in_effect) {
    const double stiffness = std::min(in_effect, device_.max_stiffness);
    const bool near_hole = contact.hole_share > 0;
    if ((near_hole || near_hole_) && stiffness_ > least_stiffness) {
        const double scale = stiffness / stiffness_;
        wanted_ *= scale;
        given_ *= scale;
    }
    stiffness_ = stiffness;
    near_hole_ = near_hole;
}

/// The difference of the tick before, as far as it has faded by now.
dvec3 JumpCancellation::faded_difference() {
    const dvec3 difference = given_ - wanted_;
    const double before = std::exchange(weight_, fade(ticks_)),
                 length = std::sqrt(dot(difference, difference)), left = before > 0 ? weight_ / before : 0.0,
                 most = steepest_fade * device_.max_force;
    return (1.0 - left) * length > most ? difference * (1.0 - most / length) : difference * left;
}

/// The difference under a surface that has jumped, so that the hand gets what it got. `difference`: under
/// the surface before.
dvec3 JumpCancellation::begin(const dvec3& jumped_force, bool was_silent, const dvec3& difference) {
    buried_ = dot(jumped_force, jumped_force) > device_.max_force * device_.max_force;
    const bool silent = is_silent();
    if (silent && was_silent) return difference;
    if (silent || was_silent) {
        if (silent && given_ == dvec3(0.0)) presence_ = 0;
        ticks_ = 0;
        weight_ = 1;
        return silent ? given_ : given_ - jumped_force;
    }
    // The rest of an earlier jump fades on, from where it is. Both share one clock, set to the mean of
    // theirs, so that a series of small jumps is followed and not held back for ever.
    const dvec3 added = jumped_force - wanted_;
    const double rest_n = std::sqrt(dot(difference, difference)), added_n = std::sqrt(dot(added, added));
    ticks_ = rest_n > 0 ? ticks_ * (rest_n / (rest_n + added_n)) : 0.0;
    weight_ = fade(ticks_);
    return difference - added;
}

/// The part of a change of the solver's force that is kept from the hand, under a goal that `moved`. What the
/// hand's motion explains passes whole; the rest (a slip, a crest, a landing) passes in the share in which
/// the hand gets the force.
dvec3 JumpCancellation::withheld(const Contact& contact, const dvec3& change, const dvec3& felt,
                                 const dvec3& moved) const {
    const dvec3 stretch = contact.proxy - contact.goal;
    const double change2 = dot(change, change), stretch2 = dot(stretch, stretch);
    if (!(change2 > 0)) return change;
    // Twice the spring's: a proxy that slides with friction, or round a bend, moves as well.
    const double by_the_hand =
        stretch2 > 0 ? 2.0 * std::sqrt(dot(felt, felt) * dot(moved, moved) / stretch2) : 0.0;
    return change * ((1.0 - share_) * std::max(0.0, 1.0 - by_the_hand / std::sqrt(change2)));
}

BlendedForce JumpCancellation::calm(const Contact& contact, double stiffness) {
    if (!has_sound_forces(contact)) return {contact.force};
    follow_hole(contact, stiffness);
    const double map = contact.properties.stiffness,
                 share = felt_share(stiffness) * (stiffness < map ? stiffness / map : 1.0);
    const dvec3 felt = share * contact.force, moved = contact.goal - std::exchange(goal_, contact.goal);
    // By far the most ticks: nothing jumped, and nothing fades.
    if (!surface_is_new_ && !contact.jumped && !is_silent() && given_ == wanted_ && share_ >= 1 &&
        presence_ >= 1) {
        wanted_ = given_ = felt;
        return {contact.force};
    }
    const bool was_silent = is_silent(), is_new = contact.touching && std::exchange(surface_is_new_, false);
    dvec3 from = wanted_, difference = contact.goal_held ? given_ - wanted_ : faded_difference();
    if (!contact.touching) {
        buried_ = false;
        presence_ = 1;
        // A finger without a known goal is not known to be free.
        if (!contact.goal_held) surface_is_new_ = waiting_ = false;
    } else if (is_new || (contact.jumped && !waiting_)) {
        if (is_new) waiting_ = device_.waits_to_be_free;
        from = is_new ? felt : felt_jump(contact, stiffness);
        difference = begin(from, was_silent, difference);
        if (from != dvec3(0.0)) share_ = share_of(from + difference, from);
    }
    if (!is_silent()) difference -= withheld(contact, felt - from, felt, moved);
    BlendedForce out;
    out.presence = presence_;
    out.waiting = waiting_ && contact.touching;
    wanted_ = is_silent() ? dvec3(0.0) : felt;
    // Without a goal the hand gets what is left of its last force, whatever the surface does meanwhile.
    given_ = contact.goal_held ? wanted_ + difference : within(felt, wanted_ + difference);
    out.force = given_ == felt || share == 0 ? contact.force : given_ / share;
    // In the air the share is that of the last contact, and comes back as a fade would bring it.
    share_ = felt != dvec3(0.0) ? share_of(given_, felt) : std::min(1.0, share_ + steepest_fade);
    if (!contact.goal_held) {
        ticks_ = std::min(ticks_ + 1.0, static_cast<double>(fade_ticks));
        presence_ = std::clamp(presence_ + (is_silent() ? -1.0 : 1.0) / fade_ticks, 0.0, 1.0);
    }
    out.difference = out.force - contact.force;
    out.active = out.difference != dvec3(0.0);
    return out;
}

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

/// One step towards zero force. If the goal comes back before, the ramp goes on at the remaining share.
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
    ticks_held_ = std::max(ticks_held_, settled_ticks);  // no high velocity, however far away the hand is now
    last_force_ = dvec3(0.0);
    added_ = 0;
    account_.lose_goal();
    stiffness_.lift();
}

dvec3 ForceGuard::spring(const Contact& contact, const dvec3& unlimited, double stiffness,
                         std::uint32_t& reasons) const {
    dvec3 force = unlimited;
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
    const double squared = dot(out.force, out.force);
    if (squared <= surely_) return;
    const double length = std::sqrt(squared);
    if (length <= settings_.max_force) return;
    out.force *= settings_.max_force / length * (1 - hair);
    out.reasons |= guard_force;
}

/// Adds the damper and the passivity controller's brake, scaled by the contact's presence.
void ForceGuard::brake(const Contact& contact, const BlendedForce& blended, double stiffness, int ticks,
                       GuardedForce& out) {
    const bool damped = settings_.damping > 0, controlled = settings_.passivity > 0;
    if (damped || controlled) velocity_ = filtered_velocity(velocity_, account_.step(), ticks);
    if (damped) {
        const double spring = std::min(stiffness, settings_.max_stiffness);
        const dvec3 damper =
            blended.presence *
            damping_.force(account_, spring * share_of(blended.force, contact.force), velocity_, ticks);
        out.force += damper;
        if (damper != dvec3(0.0)) out.reasons |= guard_damping;
    }
    limit(out);
    if (!controlled || !contact.touching) return;
    const dvec3 brake = blended.presence * passivity_.force(account_.excess(), velocity_);
    out.force += brake;
    if (brake != dvec3(0.0)) out.reasons |= guard_passivity;
    limit(out);
}

/// Bounds how fast damper and controller lengthen the spring's force, or give back what they took off it: by
/// a ramp's step a tick and what the hand's own motion explains. So a hand that stops, or ticks that were
/// left out, end neither of them in one step.
void ForceGuard::add_slowly(const dvec3& spring, int ticks, GuardedForce& out) {
    const double whole = std::min(std::sqrt(dot(spring, spring)), settings_.max_force),
                 speed = std::sqrt(dot(account_.step(), account_.step())) / (ticks * tick_seconds),
                 by_the_hand = (settings_.damping + settings_.passivity) * velocity_share * speed,
                 most = std::max(0.0, whole + added_ + settings_.max_force * largest_return + by_the_hand);
    double length = std::sqrt(dot(out.force, out.force));
    if (length > most) {
        out.force *= most / length;
        out.reasons |= settings_.damping > 0 ? guard_damping : guard_passivity;
        length = most;
    }
    added_ = length - whole;
}

/// The final check. Written so that NaN does not pass.
bool ForceGuard::can_go_out(const GuardedForce& out) const {
    const double squared = dot(out.force, out.force);
    return (squared <= surely_ || std::sqrt(squared) <= settings_.max_force) &&
           std::isfinite(out.energy.balance() - out.energy.bound);
}

/// If the output cannot be right, all state that led to it is dropped.
GuardedForce ForceGuard::begin_anew() {
    *this = ForceGuard(settings_, metres_per_unit_);
    return {dvec3(0.0), guard_fault, {}};
}

double ForceGuard::meet(const Contact& contact, double surface_share) {
    if (contact.goal_held || !is_sound(contact, {contact.force})) return stiffness_.held(contact);
    ramp_ = ticks_in_ < settings_.ramp_in_ticks ? ticks_in_ / settings_.ramp_in_ticks : 1.0;
    account_.move(contact, stiffness_.carried(contact), ramp_ * surface_share);
    const double stiffness = stiffness_.in_effect(contact, account_);
    account_.store(stiffness);
    return stiffness;
}

GuardedForce ForceGuard::guard(const Contact& contact, const BlendedForce& blended, bool is_blended,
                               double stiffness, double surface_share) {
    ticks_held_ = std::min(ticks_held_ + std::clamp(contact.ticks, 1, longest_ticks), longest_ticks);
    if (contact.goal_held || !is_sound(contact, blended)) return ramp_out(surface_share);
    ticks_faulty_ = 0;
    const int ticks = std::exchange(ticks_held_, 0);
    const bool ramping = ticks_in_ < settings_.ramp_in_ticks;
    GuardedForce out;
    out.force = spring(contact, blended.force, stiffness, out.reasons);
    GuardedForce alone = out;  // without damper and brake
    brake(contact, blended, stiffness, ticks, out);
    if (settings_.damping > 0 || settings_.passivity > 0) add_slowly(alone.force, ticks, out);
    if (ramping) {
        out.force *= ramp_;
        out.reasons |= guard_ramp;
        ticks_in_ += 1;
    }
    const dvec3 whole = out.force;
    if (surface_share < 1) {
        out.force *= surface_share;
        out.reasons |= guard_stale;
    }
    dvec3 by_the_jump(0.0);
    if (is_blended) {
        limit(alone);
        by_the_jump = ramp_ * surface_share * alone.force - account_.spring_force();
        out.reasons |= guard_jump;
    }
    account_.hold(out.force, by_the_jump);
    out.energy = account_.figures();
    if (!can_go_out(out)) return begin_anew();
    last_force_ = whole;
    return out;
}

GuardedForce FingerGuard::guard(const Contact& contact, double surface_share) {
    const double stiffness = guard_.meet(contact, surface_share);
    const BlendedForce blended = jump_.calm(contact, stiffness);
    GuardedForce out = guard_.guard(contact, blended.active ? blended : BlendedForce{contact.force},
                                    blended.active, stiffness, surface_share);
    if ((out.reasons & guard_fault) && guard_.has_begun_anew()) jump_.reset();
    if (blended.waiting) out.reasons |= guard_waiting;
    return out;
}

void FingerGuard::surface_is_new() {
    if (has_let_go()) jump_.reset();  // no force is left that could fade
    jump_.surface_is_new();
}

}  // namespace touchable
