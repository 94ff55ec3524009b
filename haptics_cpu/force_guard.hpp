#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "haptics_cpu/contact_damping.hpp"
#include "haptics_cpu/contact_stiffness.hpp"
#include "haptics_cpu/energy_account.hpp"
#include "haptics_cpu/guard_settings.hpp"
#include "haptics_cpu/jump_cancellation.hpp"
#include "haptics_cpu/passivity_controller.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

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

}  // namespace touchable
