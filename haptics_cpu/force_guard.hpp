#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "haptics_cpu/contact_damping.hpp"
#include "haptics_cpu/contact_stiffness.hpp"
#include "haptics_cpu/energy_account.hpp"
#include "haptics_cpu/passivity_controller.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// What the device can bear, how forces come and go, and what is done to them on the way.
struct GuardSettings {
    double max_force = 10.0;         ///< N, per finger
    double max_stiffness = 10000.0;  ///< N/m
    int ramp_in_ticks = 100;         ///< from the first tick, and again after a fault
    int ramp_out_ticks = 100;        ///< to zero once goals are no longer finite
    StiffnessRise rise;              ///< how stiffness may rise in contact; by default as the map does
    double damping = 0;              ///< N s/m
    double passivity = 0;            ///< largest damping of the passivity controller, N s/m; 0: off
};

/// Why a guarded force is not the solver's; bits of the `guard` column.
enum GuardReason : std::uint32_t {
    guard_none = 0,
    guard_stiffness = 1,   ///< k limited to the device's
    guard_force = 2,       ///< |F| limited to the device's
    guard_ramp = 4,        ///< ramping in
    guard_fault = 8,       ///< goal not finite: ramping to zero, or zero
    guard_rise = 16,       ///< k not yet risen to the map's
    guard_damping = 32,    ///< a damper's force added
    guard_passivity = 64,  ///< the passivity controller's force added
    guard_jump = 128       ///< the surface jumped: JumpCancellation
};

struct GuardedForce {
    glm::dvec3 force{0.0};  ///< N, world axes; never longer than max_force, never NaN
    std::uint32_t reasons = guard_none;
    EnergyFigures energy{};  ///< up to this tick
};

/// Stands between the solver's force and one finger's device: device limits, ramp in, ramp out on a fault,
/// and the books of energy (docs/solver.md, Guard). Unless a damper or the passivity controller is asked for
/// it only ever shortens a force. No allocation; a pure function of what it was given so far.
class ForceGuard {
public:
    ForceGuard(const GuardSettings& settings, double metres_per_scene_unit);
    GuardedForce guard(const Contact& contact) { return guard(contact, contact.force, false); }
    /// After a jump of the surface: `calmed` takes the place of the contact's force.
    GuardedForce guard_calmed(const Contact& contact, const glm::dvec3& calmed) {
        return guard(contact, calmed, true);
    }

private:
    GuardedForce ramp_out();
    GuardedForce guard(const Contact& contact, const glm::dvec3& force, bool calmed);
    glm::dvec3 spring(const Contact& contact, const glm::dvec3& force, double stiffness,
                      std::uint32_t& reasons) const;
    void limit(GuardedForce& out) const;

    GuardSettings settings_;
    int ticks_in_ = 0;      // since the ramp in began
    int ticks_faulty_ = 0;  // since the goal stopped being finite
    int ticks_held_ = 0;    // that have passed since a goal was last known
    glm::dvec3 last_force_{0.0};
    EnergyAccount account_;
    ContactStiffness stiffness_;
    ContactDamping damping_;
    PassivityController passivity_;
    glm::dvec3 velocity_{0.0};  // of the goal, m/s, filtered; where someone asks
};

}  // namespace touchable
