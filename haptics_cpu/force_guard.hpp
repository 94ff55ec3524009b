#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/vec3.hpp>
#include <limits>

#include "engine/base/result.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// Time between two ticks.
inline constexpr double tick_seconds = 0.001;

/// Velocities are differences of positions from tick to tick, through a low pass of first order with its
/// cutoff at 80 Hz: below it a hand moves, above it an encoder jumps. 1 - exp(-2 pi 80 Hz 1 ms), rounded here
/// so that it is the same everywhere.
inline constexpr double velocity_share = 0.395;

/// After so many ticks nothing is left of what was before that a double could tell: 0.605^100 < 2^-72.
inline constexpr int settled_ticks = 100;

/// A pause of more counts as this many: 1000 s.
inline constexpr int longest_ticks = 1'000'000;

/// `filtered` after `ticks` more ticks, 1 or more, in which the position changed by `step` in all; a length
/// or a vector of them. Ticks that were skipped count like ticks in which it moved evenly.
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
    /// The stiffness at which a stretch of x2 > 0 stores `joules`; infinite where none stores so much.
    double stiffness(double joules, double x2) const;
};

/// Joules since the start, of one finger.
struct EnergyFigures {
    double work = 0;     ///< done on the hand by the forces that were held
    double surface = 0;  ///< put in by what was not the hand: a moving surface, a ramp, a jump's cancellation
    double stored = 0;   ///< in the spring now
    double created = 0;  ///< the most that work - surface + stored ever was
    double bound = 0;    ///< the most that holding each force for a tick can have created at a constant k

    /// Energy that nothing put in: positive where some was created; negative where friction, or the proxy's
    /// drop to a lower minimum, took some.
    double balance() const { return work - surface + stored; }
};

/// The books of one finger's energy, exact per tick (docs/solver.md, Energy). A tick: the surface moves under
/// the old goal, the goal moves against the force that is held, a new force is made and held.
class EnergyAccount {
public:
    EnergyAccount(const DeviceSpring& spring, double metres_per_scene_unit)
        : spring_(spring), metres_per_unit_(metres_per_scene_unit) {}

    /// What happened before this tick's force. `carried_stiffness`: k (N/m) in effect at the place to which
    /// the moving surface carried the proxy, nothing where there was no contact; `ramp`: the share of the
    /// spring that the guard lets through.
    void move(const Contact& contact, const std::optional<double>& carried_stiffness, double ramp);
    /// The spring's new energy, at the stiffness in effect (0 out of contact).
    void store(double stiffness);
    /// The force that is held until the next tick, newtons. `blended`: the part of it that is not the
    /// spring's, because the surface jumped (BlendedForce::difference); its work counts as the surface's.
    void hold(const glm::dvec3& force, const glm::dvec3& blended = glm::dvec3(0.0)) {
        held_ = force;
        blended_ = blended;
    }
    /// The spring's force at the stiffness in effect, as the device renders it.
    const glm::dvec3& spring_force() const { return spring_force_; }
    /// The hand's place is not known: the spring is let go, and the work of this tick is not booked.
    void lose_goal();

    // After `move`.
    /// What the spring may store without creating energy, joules.
    double allowed() const { return energy_before_ - work_of_tick_; }
    /// What it stores at a stiffness, and the stiffness (of a spring that stores any) for an energy.
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
    double excess_ = 0;  // summed for itself: in the sums of a long run its joules would be roundings
    EnergyFigures figures_;
};

/// How the stiffness under a finger may rise while it touches. It falls at once: that takes energy away.
struct StiffnessRise {
    /// Only as far as this contact's losses pay for: a map of stiffness creates no energy.
    bool paid = false;
    double per_tick = std::numeric_limits<double>::infinity();  ///< N/m

    bool limited() const { return paid || per_tick < std::numeric_limits<double>::infinity(); }
};

/// What a rise of stiffness adds to the force per tick, at most, N, where a finger comes out of a hole that
/// is softer than what is around it: the goal may be deep behind the hole's wall by then. 0.4 N in 10 ms
/// leaves room within 0.5 N for what the hand itself does meanwhile.
inline constexpr double rise_from_hole = 0.04;

/// The stiffness in effect, never above the map's; a contact begins with the map's (docs/solver.md, Stiffness
/// that differs from place to place).
class ContactStiffness {
public:
    explicit ContactStiffness(const StiffnessRise& rise) : rise_(rise) {}

    /// N/m where the surface took the proxy, before the goal moved; nothing without contact.
    std::optional<double> carried(const Contact& contact) const;
    /// N/m at the proxy; 0 out of contact. After `account.move`.
    double in_effect(const Contact& contact, const EnergyAccount& account);
    void lift() { limited_ = from_hole_ = false; }

private:
    double risen(double before, double map, const EnergyAccount& account);

    StiffnessRise rise_;
    bool limited_ = false;    // in a contact whose rises are limited
    bool from_hole_ = false;  // in a hole, or out of one and not yet as stiff as the map
    double stiffness_ = 0;
    double paid_ = 0;  // joules lost in this contact and not yet spent
};

/// What the device can bear, how forces come and go, and what is done to them on the way.
struct GuardSettings {
    double max_force = 10.0;         ///< N, per finger; 1e-6 to 1e9
    double max_stiffness = 10000.0;  ///< N/m; 1e-3 to 1e12
    int ramp_in_ticks = 100;         ///< from the first tick, and again after a fault
    int ramp_out_ticks = 100;        ///< to zero once goals are no longer finite
    StiffnessRise rise;              ///< how stiffness may rise in contact; by default as the map does
    double damping = 0;              ///< N s/m
    double passivity = 0;            ///< largest damping of the passivity controller, N s/m; 0: off
    /// No force where a finger is inside a surface that is new to it, until it has been free once.
    bool waits_to_be_free = false;
    /// A surface whose newest frame is older than this goes by the ramps above (StaleSurface); 0: it never
    /// does.
    std::int64_t stale_after_ns = 0;
};

/// Refuses what no guard can keep, by name. A guard that is made of it nevertheless exerts no force.
Result<void> validate(const GuardSettings& settings);

/// A damper beside the spring (docs/solver.md, Guard): b times the rate at which the hand's own motion
/// stretches it. What the surface's motion stretches is left out, so that it takes energy from the hand and
/// passes none on from the clip.
class ContactDamping {
public:
    /// b in N s/m; 0: none.
    explicit ContactDamping(double b) : b_(b) {}

    /// The damper's force, newtons, beside a spring of `stiffness` (N/m; 0 out of contact). After
    /// `account.move`, `ticks` after the one before. Only ever against the hand's `velocity` (m/s), and never
    /// so strong that the surface holds the finger back.
    glm::dvec3 force(const EnergyAccount& account, double stiffness, const glm::dvec3& velocity, int ticks);
    void lift() { rate_ = glm::dvec3(0.0); }

private:
    double b_;
    glm::dvec3 rate_{0.0};  // m/s, filtered
};

/// Takes back energy that a contact has created, as a damper of the hand's motion for as long as there is any
/// (Hannaford and Ryu 2002; docs/solver.md, Guard): alpha = excess / (T |v|^2), F -= alpha v.
class PassivityController {
public:
    /// `most`: the largest alpha, N s/m; 0: never.
    explicit PassivityController(double most) : most_(most) {}

    /// What to add to the force, newtons; `excess` in joules (EnergyAccount), velocity in m/s.
    glm::dvec3 force(double excess, const glm::dvec3& velocity) const;

private:
    double most_;
};

/// A force after a jump of the surface.
struct BlendedForce {
    glm::dvec3 force{0.0};       ///< N; never longer than the solver's, never against it
    glm::dvec3 difference{0.0};  ///< force less the solver's: what the jump's cancellation does to the hand
    bool active = false;         ///< the difference is not 0
    /// How much of the contact the hand is to feel, 0 to 1: what is added to the spring goes with it. 1 but
    /// where there is to be no force, and for a fade's length before and after.
    double presence = 1;
    bool waiting = false;  ///< there is none because the finger has not been free of a new surface
};

/// Keeps a surface that jumps under one finger - a cut, an object from the side, a frame that was late - from
/// kicking the hand (docs/solver.md, Sudden change). With J the jump of the force at the goal of the tick
/// before, the hand gets F - w J, where w goes smoothly from 1 to 0 in `fade_ticks`: no step when the surface
/// jumps, and dF/dG is the spring's own, so nothing lags.
///
/// It only takes away: the result is never longer than F, nor does it pull against F. Jumps that overlap go
/// on from the current result; the end of contact ends it at once. Where a jump leaves
/// the goal so deep that the spring exceeds what the device can bear (F_max / k), there is no force at all,
/// until the goal surfaces or another jump brings it near. A surface that is new is a jump for who is inside
/// it; with `waits_to_be_free` there is no force then until the finger has been free once. Forces count as
/// the device gives them: from one stiffness to another, both beyond its own, nothing jumps.
///
/// While a goal is missing the fade rests: the hand gets what is left of its last force, and finds that force
/// again, not one that has gone over to another surface meanwhile.
///
/// No allocation; a pure function of what it was given so far; what never jumps goes through unchanged, to
/// the bit. A contact with forces that are none goes through unchanged too, for the guard to refuse, and
/// leaves no trace.
class JumpCancellation {
public:
    static constexpr int fade_ticks = 100;

    explicit JumpCancellation(const GuardSettings& device) : device_(device) { reset(); }
    BlendedForce calm(const Contact& contact);
    /// The next contact is with a surface that is new to the finger; the first one is (the guard's ramp is
    /// its fade where nothing waits).
    void surface_is_new() { surface_is_new_ = true; }
    /// As it was made.
    void reset();

private:
    /// How much of a spring of this stiffness (N/m) the device gives to the hand: all up to its own.
    double felt_share(double stiffness) const;
    glm::dvec3 felt_jump(const Contact& contact) const;
    bool is_silent() const { return buried_ || waiting_; }
    void fall_silent();
    void begin(const glm::dvec3& jumped_force);
    void follow_hole(const Contact& contact);
    void meet_new(const glm::dvec3& force);

    GuardSettings device_;
    bool surface_is_new_ = false;  // and not met yet
    bool waiting_ = false;         // inside a surface that was new, and never free since
    bool buried_ = false;          // by a jump, deeper than the device can bear
    double presence_ = 1;
    glm::dvec3 jump_{0.0};       // J, at w = 1
    double ticks_ = fade_ticks;  // since w was 1, of the coming tick
    bool rested_ = false;        // in the tick before
    // As the device gives them (`felt_share`), of the tick before: what the hand would have got without J,
    // and what it got.
    glm::dvec3 wanted_{0.0}, given_{0.0};
    double stiffness_ = 0;    // N/m as the device gives it, of the tick before; 0 out of contact
    bool near_hole_ = false;  // part of it was that of holes
};

/// Why a guarded force is not the solver's; bits of the `guard` column.
enum GuardReason : std::uint32_t {
    guard_none = 0,
    guard_stiffness = 1,   ///< k limited to the device's
    guard_force = 2,       ///< |F| limited to the device's
    guard_ramp = 4,        ///< ramping in
    guard_fault = 8,       ///< what came in was no number: ramping to zero; or what would go out: zero
    guard_rise = 16,       ///< k not yet risen to the map's
    guard_damping = 32,    ///< a damper's force added
    guard_passivity = 64,  ///< the passivity controller's force added
    guard_jump = 128,      ///< the surface jumped: JumpCancellation
    guard_waiting = 256,   ///< with guard_jump: no force until the finger has been free of a new surface
    guard_gap = 512,       ///< the hand was left alone before this tick: TouchStep::come_back
    guard_stale = 1024     ///< the surface is too old, or was: StaleSurface
};

struct GuardedForce {
    glm::dvec3 force{0.0};  ///< N, world axes; never longer than max_force, never NaN
    std::uint32_t reasons = guard_none;
    EnergyFigures energy{};  ///< up to this tick
};

/// Stands between the solver's force and one finger's device: device limits, ramp in, ramp out on a fault,
/// and the account of energy (docs/solver.md, Guard). Unless a damper or the passivity controller is asked
/// for it only ever shortens a force. It trusts no input: impossible contacts are a fault; a force that is no
/// number or longer than the device's limit is never given out, and the guard begins anew. No allocation; a
/// pure function of what it was given so far.
class ForceGuard {
public:
    /// Of settings that `validate` refuses, or of a scale that is no positive number, it is a guard that
    /// exerts no force: every tick is a fault.
    ForceGuard(const GuardSettings& settings, double metres_per_scene_unit);
    /// `surface_share`: how much of the surface is felt at all (StaleSurface).
    GuardedForce guard(const Contact& contact, double surface_share = 1) {
        return guard(contact, {contact.force}, false, surface_share);
    }
    /// After a jump of the surface: `blended` takes the place of the contact's force.
    GuardedForce guard_blended(const Contact& contact, const BlendedForce& blended,
                               double surface_share = 1) {
        return guard(contact, blended, true, surface_share);
    }
    /// Goals have been missing for so long that no force is left: what comes next is a new beginning.
    bool has_let_go() const { return ticks_faulty_ >= ramp_out_ticks(); }
    /// Sets the state that missing goals lead to: the hand was left alone, and its force has ended.
    void let_go();

    /// Whether a tick with a fault made the guard begin anew, because the force that it computed was
    /// impossible.
    bool has_begun_anew() const { return ticks_faulty_ == 0; }

private:
    int ramp_out_ticks() const;
    bool is_sound(const Contact& contact, const BlendedForce& blended) const;
    GuardedForce ramp_out(double surface_share);
    GuardedForce guard(const Contact& contact, const BlendedForce& blended, bool is_blended,
                       double surface_share);
    glm::dvec3 spring(const Contact& contact, const glm::dvec3& force, double stiffness,
                      std::uint32_t& reasons) const;
    void brake(const Contact& contact, const BlendedForce& blended, double stiffness, int ticks,
               GuardedForce& out);
    void limit(GuardedForce& out) const;
    bool can_go_out(const GuardedForce& out) const;
    GuardedForce begin_anew();

    GuardSettings settings_;
    double metres_per_unit_;
    double surely_;         // a force of less than this, N^2, is within the limit, whatever rounding says
    double farthest_;       // a place may be, scene units; below 0: settings are not sound, and nothing is
    double ticks_in_ = 0;   // since the ramp in began; after a fault, where it goes on from
    double ramp_ = 0;       // share let through in the last tick without a fault
    int ticks_faulty_ = 0;  // since the goal stopped being finite
    int ticks_held_ = 0;    // that have passed since a goal was last known
    glm::dvec3 last_force_{0.0};  // of a surface that is felt whole
    EnergyAccount account_;
    ContactStiffness stiffness_;
    ContactDamping damping_;
    PassivityController passivity_;
    glm::dvec3 velocity_{0.0};  // of the goal, m/s, filtered; where someone asks
};

/// All that stands between what a finger met and its device: jump cancellation, then the force guard.
/// Whatever comes in, what goes out is finite and no longer than the device's force.
class FingerGuard {
public:
    FingerGuard(const GuardSettings& settings, double metres_per_scene_unit)
        : jump_(settings), guard_(settings, metres_per_scene_unit) {}

    /// `surface_share`: how much of the surface is felt at all (StaleSurface).
    GuardedForce guard(const Contact& contact, double surface_share = 1);
    /// The next contact is with a surface that is new to the finger.
    void surface_is_new();
    /// Goals have been missing for so long that no force is left.
    bool has_let_go() const { return guard_.has_let_go(); }
    /// ForceGuard::let_go.
    void let_go() { guard_.let_go(); }

private:
    JumpCancellation jump_;
    ForceGuard guard_;
};

/// How much of a live surface is felt, by its age: one that no newer frame has renewed for as long as the
/// settings say goes by the ramp by which forces go, and comes back by that by which they come, once there is
/// a newer frame. A pure function of what it was given so far.
class StaleSurface {
public:
    explicit StaleSurface(const GuardSettings& settings)
        : after_ns_(settings.stale_after_ns),
          falls_(1.0 / std::max(1, settings.ramp_out_ticks)),
          rises_(1.0 / std::max(1, settings.ramp_in_ticks)) {}

    /// The next tick: its newest frame is so old, and so many ticks have passed since the last one. True
    /// where the surface comes back after nothing of it was felt.
    bool look(std::int64_t age_ns, int ticks) {
        if (after_ns_ == 0) return false;
        const bool was_gone = share_ == 0, is_stale = age_ns > after_ns_;
        share_ = std::clamp(is_stale ? share_ - ticks * falls_ : share_ + ticks * rises_, 0.0, 1.0);
        return was_gone && !is_stale;
    }
    /// 0 to 1.
    double share() const { return share_; }

private:
    std::int64_t after_ns_;
    double falls_, rises_;  // per tick
    double share_ = 1;
};

}  // namespace touchable
