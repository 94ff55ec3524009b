#pragma once

#include <glm/vec3.hpp>

#include "haptics_cpu/guard_settings.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

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

}  // namespace touchable
