// SPDX-License-Identifier: Apache-2.0
#pragma once

// What lies between the solver's force and a device: the device's limits, ramps, damping, and the account of
// energy by which they are judged (docs/solver.md, Guard). touch_step.hpp includes it for its users.
//
// GuardSettings are the limits; a FingerGuard holds one finger's JumpCancellation and ForceGuard, and makes
// a GuardedForce of each tick's Contact: finite, no longer than the limit, with the GuardReasons for which it
// differs and the EnergyFigures so far. StaleSurface fades a surface without new frames, for all fingers.
//
// Threads: one at a time uses an object; no member waits or allocates. Settings and results are plain values.

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>

#include "engine/base/result.hpp"
#include "engine/base/same_bits.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// Time between two ticks.
inline constexpr double tick_seconds = 0.001;

/// Velocities are differences of positions from tick to tick, through a low pass of first order with its
/// cutoff at 80 Hz: a hand's motion lies below it, an encoder's jumps above. 1 - exp(-2 pi 80 Hz 1 ms),
/// rounded here so that it is the same everywhere.
inline constexpr double velocity_share = 0.395;

/// Ticks after which nothing is left of an earlier value that a double could show: 0.605^100 < 2^-72.
inline constexpr int settled_ticks = 100;

/// A longer pause counts as this many ticks: 1000 s.
inline constexpr int longest_ticks = 1'000'000;

/// `filtered` after `ticks` more ticks, 1 or more, in which the position changed by `step` in total; lengths
/// or vectors. Skipped ticks count as ticks of even motion.
template <class Value>
Value filtered_velocity(Value filtered, const Value& step, int ticks) {
    const Value velocity = step / (ticks * tick_seconds);
    for (int tick = std::min(ticks, settled_ticks); tick > 0; --tick)
        filtered = filtered + (velocity - filtered) * velocity_share;
    return filtered;
}

/// The spring between proxy and goal as a device renders it: F = min(k |x|, max_force) along x = S (P - G), k
/// at most max_stiffness. F is the negative gradient of its energy, which is k x^2 / 2 and, where the force
/// is cut off, linear.
struct DeviceSpring {
    double max_stiffness;  ///< N/m
    double max_force;      ///< N

    /// Joules at stiffness k and a stretch of x2 = |x|^2, square metres.
    double energy(double k, double x2) const;
    /// Newtons per metre of x.
    double pull(double k, double x2) const;
    /// The stiffness at which a stretch of x2 > 0 stores `joules`; infinite if no stiffness does.
    double stiffness(double joules, double x2) const;
};

/// Energy of one finger since the start, joules.
struct EnergyFigures {
    double work = 0;     ///< done on the hand by the held forces
    double surface = 0;  ///< put in by other than the hand: a moving surface, a ramp, a jump's cancellation
    double stored = 0;   ///< in the spring now
    double created = 0;  ///< largest value of work - surface + stored so far
    double bound = 0;    ///< the most that holding each force for a tick can create at a constant k

    /// Energy without a source: positive if some was created; negative if friction, or the proxy's drop to a
    /// lower minimum, took some.
    double balance() const { return work - surface + stored; }
};

/// The account of one finger's energy, exact per tick (docs/solver.md, Energy). In a tick, the surface moves
/// under the old goal, the goal moves against the held force, and a new force is made and held.
class EnergyAccount {
public:
    EnergyAccount(const DeviceSpring& spring, double metres_per_scene_unit)
        : spring_(spring), metres_per_unit_(metres_per_scene_unit) {}

    /// Books what happened before this tick's force. `carried_stiffness`: k (N/m) in effect at the place to
    /// which the moving surface carried the proxy, nothing without contact; `ramp`: the share of the spring
    /// that the guard lets through.
    void move(const Contact& contact, const std::optional<double>& carried_stiffness, double ramp);
    /// Books the spring's new energy, at the stiffness in effect (0 out of contact).
    void store(double stiffness);
    /// Sets the force that is held until the next tick, newtons. `blended`: its part that is not the
    /// spring's, because the surface jumped (BlendedForce::difference); its work counts as the surface's.
    void hold(const glm::dvec3& force, const glm::dvec3& blended = glm::dvec3(0.0)) {
        held_ = force;
        blended_ = blended;
    }
    /// The spring's force at the stiffness in effect, as the device renders it.
    const glm::dvec3& spring_force() const { return spring_force_; }
    /// If the hand's position is unknown: the spring is released, and the work of this tick is not booked.
    void lose_goal();

    // Valid after `move`.
    /// Energy that the spring may store without creating any, joules.
    double allowed() const { return energy_before_ - work_of_tick_; }
    /// Energy stored at a stiffness, and the stiffness (of a spring that stores any) for an energy.
    double energy(double stiffness) const { return ramp_ * spring_.energy(stiffness, x2_); }
    double stiffness(double joules) const { return spring_.stiffness(joules / ramp_, x2_); }
    /// S (P - G), and how the hand's motion in this tick changed it; metres.
    const glm::dvec3& stretch() const { return x_; }
    const glm::dvec3& stretched() const { return stretched_; }
    /// The hand's motion in this tick, metres.
    const glm::dvec3& step() const { return step_; }

    const EnergyFigures& figures() const { return figures_; }
    /// Joules created in this contact beyond what holding forces explains.
    double excess() const { return excess_; }
    void each_state(StateBytes& bytes) {
        EnergyFigures& f = figures_;
        bytes(started_, goal_, held_, blended_, spring_force_, step_, x_, stretched_, ramp_, x2_,
              stiffness_before_, energy_before_, work_of_tick_, excess_, f.work, f.surface, f.stored,
              f.created, f.bound);
    }

private:
    DeviceSpring spring_;
    double metres_per_unit_;
    bool started_ = false;
    glm::dvec3 goal_{0.0};          // scene units, of the last tick
    glm::dvec3 held_{0.0};          // N
    glm::dvec3 blended_{0.0};       // the part of it that is a jump's cancellation
    glm::dvec3 spring_force_{0.0};  // the part of it that was the spring's
    glm::dvec3 step_{0.0}, x_{0.0}, stretched_{0.0};
    double ramp_ = 1, x2_ = 0;
    std::optional<double> stiffness_before_;
    double energy_before_ = 0, work_of_tick_ = 0;
    double excess_ = 0;  // summed separately: in the sums of a long run its joules would be roundings
    EnergyFigures figures_;
};

/// How the stiffness under a finger may rise in contact. It falls at once, which takes energy away.
struct StiffnessRise {
    /// Rises only as far as this contact's losses pay for: a map of stiffness creates no energy.
    bool paid = false;
    double per_tick = 4;  ///< N/m; infinite: as fast as the map

    bool limited() const { return paid || per_tick < std::numeric_limits<double>::infinity(); }
};

/// The most that a rise of stiffness adds to the force per tick, N, when a finger comes out of a hole that is
/// softer than its surroundings: the goal may be deep behind the hole's wall by then. 0.4 N in 10 ms leaves
/// room within 0.5 N for the hand's own motion.
inline constexpr double rise_from_hole = 0.04;

/// The stiffness in effect, never above the map's; a contact begins with the map's (docs/solver.md, Stiffness
/// that differs from place to place).
class ContactStiffness {
public:
    explicit ContactStiffness(const StiffnessRise& rise) : rise_(rise) {}

    /// N/m where the surface carried the proxy, before the goal moved; nothing without contact.
    std::optional<double> carried(const Contact& contact) const;
    /// N/m at the proxy; 0 out of contact. To be called after `account.move`.
    double in_effect(const Contact& contact, const EnergyAccount& account);
    /// N/m at the proxy while the goal is missing.
    double held(const Contact& contact) const;
    void lift() { limited_ = from_hole_ = false; }
    void each_state(StateBytes& bytes) { bytes(limited_, from_hole_, stiffness_, paid_); }

private:
    bool has_jumped(const Contact& contact) const;
    double risen(double before, double map, const EnergyAccount& account);

    StiffnessRise rise_;
    bool limited_ = false;    // in a contact whose rises are limited
    bool from_hole_ = false;  // in a hole, or out of one but not yet as stiff as the map
    double stiffness_ = 0;
    double paid_ = 0;  // joules lost in this contact and not spent yet
};

/// Limits of the device, ramps of forces, and additions to forces; what a wrong one does to a hand.
struct GuardSettings {
    /// N, per finger; 1e-6 to 1e9. Too high: a wrong frame or goal hits the hand as hard as the motors can.
    double max_force = 10.0;
    /// N/m; 1e-3 to 1e12. Above what the device renders stably: contact vibrates and may throw the hand off.
    double max_stiffness = 10000.0;
    /// From the first tick, and again after a fault; 0 or more. Too short: the hand inside a surface is
    /// kicked.
    int ramp_in_ticks = 100;
    /// To zero after goals stop being finite; 0 or more, 0 counts as 1. Too short: a hand that presses falls
    /// forward. Too long: it is pushed on although its position is unknown.
    int ramp_out_ticks = 100;
    /// How stiffness may rise in contact. Too fast: a hand that slips onto a stiffer place is kicked. Unpaid,
    /// as by default: a hand that moves over the map gets pushes that it did not pay for.
    StiffnessRise rise;
    /// N s/m, 0 or more. Too high: noise of the measured speed becomes force, and the handle vibrates.
    double damping = 0;
    /// Largest damping of the passivity controller, N s/m, 0 or more; 0: off. Too high: as for `damping`.
    double passivity = 0;
    /// No force while a finger is inside a surface that is new to it, until it has been free once. Without it
    /// such a surface pushes the hand out, by the ramps.
    bool waits_to_be_free = false;
    /// A surface whose newest frame is older than this, 0 to an hour, fades by the ramps above
    /// (StaleSurface); 0: never. Too long: the hand feels a surface that may be gone, and the next frame is a
    /// jump.
    std::int64_t stale_after_ns = 0;
};

/// Refuses settings that no guard can keep, by name. A guard with such settings exerts no force.
Result<void> validate(const GuardSettings& settings);

/// A damper beside the spring (docs/solver.md, Guard): b times the rate at which the hand's own motion
/// stretches the spring. Stretching by the surface's motion is left out, so that the damper takes energy from
/// the hand and passes none on from the clip.
class ContactDamping {
public:
    /// b in N s/m; 0: none.
    explicit ContactDamping(double b) : b_(b) {}

    /// The damper's force, newtons, beside a spring of `stiffness` (N/m; 0 out of contact). To be called
    /// after `account.move`, `ticks` after the previous call. Acts only against the hand's `velocity` (m/s),
    /// and never so strongly that the surface holds the finger back.
    glm::dvec3 force(const EnergyAccount& account, double stiffness, const glm::dvec3& velocity, int ticks);
    void lift() { rate_ = glm::dvec3(0.0); }
    void each_state(StateBytes& bytes) { bytes(rate_); }

private:
    double b_;
    glm::dvec3 rate_{0.0};  // m/s, filtered
};

/// Takes back energy that a contact has created, by damping the hand's motion as long as there is any
/// (Hannaford and Ryu 2002; docs/solver.md, Guard): alpha = excess / (T |v|^2), F -= alpha v.
class PassivityController {
public:
    /// `most`: the largest alpha, N s/m; 0: never.
    explicit PassivityController(double most) : most_(most) {}

    /// The force to add, newtons; `excess` in joules (EnergyAccount), velocity in m/s.
    glm::dvec3 force(double excess, const glm::dvec3& velocity) const;

private:
    double most_;
};

/// A force after a jump of the surface.
struct BlendedForce {
    glm::dvec3 force{0.0};       ///< N; never longer than the solver's, never against it
    glm::dvec3 difference{0.0};  ///< force minus the solver's: the effect of the cancellation
    bool active = false;         ///< the difference is not 0
    /// Share of the contact that the hand feels, 0 to 1: additions to the spring are scaled by it. 1 except
    /// while there is to be no force, and for a fade's length before and after.
    double presence = 1;
    bool waiting = false;  ///< no force, because the finger has not been free of a new surface
};

/// Keeps a surface that jumps under one finger (a cut, an object from the side, a late frame) from kicking
/// the hand (docs/solver.md, Sudden change). With J the jump of the force at the previous tick's goal, the
/// hand gets F - w J, and w goes smoothly from 1 to 0 in `fade_ticks`: no step when the surface jumps, and
/// dF/dG is the spring's own, so nothing lags. If F meanwhile changes by itself (a slip, a crest, a landing),
/// the hand gets that change in the share in which it gets F.
///
/// It only takes away: the result is never longer than F and never pulls against F. Overlapping jumps go on
/// from the current result. If a jump leaves the goal so deep that the spring exceeds what the device can
/// bear (F_max / k), there is no force at all, until the goal surfaces or another jump brings it near. A new
/// surface is a jump for a finger inside it; with `waits_to_be_free` there is then no force until the finger
/// has been free once. Forces count as the device renders them: between two stiffnesses beyond its own,
/// nothing jumps.
///
/// While a goal is missing the fade rests: the hand gets what is left of its last force, and finds that force
/// again, not one that has changed to another surface meanwhile.
///
/// No allocation; a pure function of its inputs so far; without jumps, forces pass unchanged, to the bit. A
/// contact with invalid forces passes unchanged, too, for the guard to refuse, and leaves no trace.
class JumpCancellation {
public:
    static constexpr int fade_ticks = 100;

    explicit JumpCancellation(const GuardSettings& device) : device_(device) { reset(); }
    /// `stiffness`: in effect at the proxy, N/m (ContactStiffness).
    BlendedForce calm(const Contact& contact, double stiffness);
    BlendedForce calm(const Contact& contact) { return calm(contact, contact.properties.stiffness); }
    /// The next contact is with a surface that is new to the finger, as the first one is (without waiting,
    /// the guard's ramp is its fade).
    void surface_is_new() { surface_is_new_ = true; }
    /// Restores the initial state.
    void reset();
    void each_state(StateBytes& bytes) {
        bytes(surface_is_new_, waiting_, buried_, presence_, ticks_, weight_, wanted_, given_, share_, goal_,
              stiffness_, near_hole_);
    }

private:
    /// Share of a spring of this stiffness (N/m) that the device renders: all up to its own.
    double felt_share(double stiffness) const;
    glm::dvec3 felt_jump(const Contact& contact, double stiffness) const;
    bool is_silent() const { return buried_ || waiting_; }
    glm::dvec3 faded_difference();
    glm::dvec3 begin(const glm::dvec3& jumped_force, bool was_silent, const glm::dvec3& difference);
    glm::dvec3 withheld(const Contact& contact, const glm::dvec3& change, const glm::dvec3& felt,
                        const glm::dvec3& moved) const;
    void follow_hole(const Contact& contact, double in_effect);

    GuardSettings device_;
    bool surface_is_new_ = false;  // and not met yet
    bool waiting_ = false;         // inside a surface that was new, and not free since
    bool buried_ = false;          // by a jump, deeper than the device can bear
    double presence_ = 1;
    double ticks_ = fade_ticks;  // since w was 1, at the coming tick
    // In the previous tick: w; the solver's force as the device renders it (`felt_share`; none in silence),
    // what the hand got, and its share of the former, along it (in the air that of the last contact).
    double weight_ = 0;
    glm::dvec3 wanted_{0.0}, given_{0.0};
    double share_ = 1;
    glm::dvec3 goal_{0.0};
    double stiffness_ = 0;    // N/m as the device renders it, previous tick; 0 out of contact
    bool near_hole_ = false;  // part of it came from holes
};

/// Why a guarded force differs from the solver's; bits of the `guard` column.
enum GuardReason : std::uint32_t {
    guard_none = 0,
    guard_stiffness = 1,   ///< k limited to the device's
    guard_force = 2,       ///< |F| limited to the device's
    guard_ramp = 4,        ///< ramping in
    guard_fault = 8,       ///< invalid input: ramping to zero; or impossible output: zero
    guard_rise = 16,       ///< k not yet risen to the map's
    guard_damping = 32,    ///< a damper's force added
    guard_passivity = 64,  ///< the passivity controller's force added
    guard_jump = 128,      ///< the surface jumped: JumpCancellation
    guard_waiting = 256,   ///< with guard_jump: no force until the finger has been free of a new surface
    guard_gap = 512,       ///< the hand got no ticks before this one: TouchStep::come_back
    guard_stale = 1024     ///< the surface is too old, or was: StaleSurface
};

struct GuardedForce {
    glm::dvec3 force{0.0};  ///< N, world axes; never longer than max_force, never NaN
    std::uint32_t reasons = guard_none;
    EnergyFigures energy{};  ///< up to this tick
};

/// Layer between the solver's force and one finger's device: device limits, ramp in, ramp out on a fault, and
/// the energy account (docs/solver.md, Guard). Without damper and passivity controller it only shortens
/// forces. It trusts no input: impossible contacts are a fault; a force that is NaN or longer than the
/// device's limit is never returned, and the guard begins anew. No allocation; a pure function of its inputs
/// so far.
class ForceGuard {
public:
    /// With settings that `validate` refuses, or a scale that is not a positive number, the guard exerts no
    /// force: every tick is a fault.
    ForceGuard(const GuardSettings& settings, double metres_per_scene_unit);
    /// `surface_share`: share of the surface that is felt (StaleSurface).
    GuardedForce guard(const Contact& contact, double surface_share = 1) {
        const double stiffness = meet(contact, surface_share);
        return guard(contact, {contact.force}, false, stiffness, surface_share);
    }
    /// After a jump of the surface: `blended` replaces the contact's force.
    GuardedForce guard_blended(const Contact& contact, const BlendedForce& blended,
                               double surface_share = 1) {
        const double stiffness = meet(contact, surface_share);
        return guard(contact, blended, true, stiffness, surface_share);
    }
    /// The first half of a tick: books what surface and goal did, and returns the stiffness in effect, N/m.
    double meet(const Contact& contact, double surface_share);
    /// The second half, with that stiffness; `is_blended`: `blended` is not the contact's force.
    GuardedForce guard(const Contact& contact, const BlendedForce& blended, bool is_blended, double stiffness,
                       double surface_share);
    /// Whether goals have been missing for so long that no force is left: the next goal is a new beginning.
    bool has_let_go() const { return ticks_faulty_ >= ramp_out_ticks(); }
    /// Sets the state after missing goals: the hand was left alone, and its force has ended.
    void let_go();

    /// Whether a tick with a fault made the guard begin anew, because the computed force was impossible.
    bool has_begun_anew() const { return ticks_faulty_ == 0; }
    void each_state(StateBytes& bytes) {
        bytes(ticks_in_, ramp_, ticks_faulty_, ticks_held_, last_force_, account_, stiffness_, damping_,
              velocity_, added_);
        bytes.expect(ticks_faulty_ >= 0 && ticks_held_ >= 0 &&
                     std::max(ticks_faulty_, ticks_held_) <= 1 << 30);
    }

private:
    int ramp_out_ticks() const;
    bool is_sound(const Contact& contact, const BlendedForce& blended) const;
    GuardedForce ramp_out(double surface_share);
    glm::dvec3 spring(const Contact& contact, const glm::dvec3& force, double stiffness,
                      std::uint32_t& reasons) const;
    void brake(const Contact& contact, const BlendedForce& blended, double stiffness, int ticks,
               GuardedForce& out);
    void limit(GuardedForce& out) const;
    void add_slowly(const glm::dvec3& spring, int ticks, GuardedForce& out);
    bool can_go_out(const GuardedForce& out) const;
    GuardedForce begin_anew();

    GuardSettings settings_;
    double metres_per_unit_;
    double surely_;               // N^2; forces up to this square are within the limit in spite of rounding
    double farthest_;             // farthest position, scene units; below 0: invalid settings
    double ticks_in_ = 0;         // since the ramp in began; after a fault, where it resumes
    double ramp_ = 0;             // share let through in the last tick without a fault
    int ticks_faulty_ = 0;        // since the goal stopped being finite
    int ticks_held_ = 0;          // since a goal was last known
    glm::dvec3 last_force_{0.0};  // without surface_share
    EnergyAccount account_;
    ContactStiffness stiffness_;
    ContactDamping damping_;
    PassivityController passivity_;
    glm::dvec3 velocity_{0.0};  // of the goal, m/s, filtered; for damper and controller
    double added_ = 0;          // N by which these lengthened the spring's force in the last tick
};

/// Everything between a finger's contact and its device: jump cancellation, then the force guard. For any
/// input, the output is finite and no longer than the device's force.
class FingerGuard {
public:
    FingerGuard(const GuardSettings& settings, double metres_per_scene_unit)
        : jump_(settings), guard_(settings, metres_per_scene_unit) {}

    /// `surface_share`: share of the surface that is felt (StaleSurface).
    GuardedForce guard(const Contact& contact, double surface_share = 1);
    /// The next contact is with a surface that is new to the finger.
    void surface_is_new();
    /// Goals have been missing for so long that no force is left.
    bool has_let_go() const { return guard_.has_let_go(); }
    /// ForceGuard::let_go.
    void let_go() { guard_.let_go(); }
    void each_state(StateBytes& bytes) { bytes(jump_, guard_); }

private:
    JumpCancellation jump_;
    ForceGuard guard_;
};

/// Share of a live surface that is felt, by its age: a surface without a newer frame for the time in the
/// settings fades by the ramp out, and comes back by the ramp in after a newer frame. A pure function of its
/// inputs so far.
class StaleSurface {
public:
    explicit StaleSurface(const GuardSettings& settings)
        : after_ns_(settings.stale_after_ns),
          falls_(1.0 / std::max(1, settings.ramp_out_ticks)),
          rises_(1.0 / std::max(1, settings.ramp_in_ticks)) {}

    /// To be called every tick: `age_ns` of the newest frame, `ticks` since the last call, in which the share
    /// may fall; it rises as in one. True if the surface comes back after nothing of it was felt.
    bool look(std::int64_t age_ns, int ticks) {
        if (after_ns_ == 0) return false;
        const bool was_gone = share_ == 0, is_stale = age_ns > after_ns_;
        share_ = std::clamp(is_stale ? share_ - ticks * falls_ : share_ + rises_, 0.0, 1.0);
        return was_gone && !is_stale;
    }
    /// 0 to 1.
    double share() const { return share_; }
    void each_state(StateBytes& bytes) { bytes(share_); }

private:
    std::int64_t after_ns_;
    double falls_, rises_;  // per tick
    double share_ = 1;
};

}  // namespace touchable
