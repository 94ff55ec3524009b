#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// What the device can bear and how forces come and go.
struct GuardSettings {
    double max_force = 10.0;         ///< N, per finger
    double max_stiffness = 10000.0;  ///< N/m
    int ramp_in_ticks = 100;         ///< from the first tick, and again after a fault
    int ramp_out_ticks = 100;        ///< to zero once goals are no longer finite
};

/// Why a guarded force is not the solver's; bits of the `guard` column.
enum GuardReason : std::uint32_t {
    guard_none = 0,
    guard_stiffness = 1,  ///< k limited to the device's
    guard_force = 2,      ///< |F| limited to the device's
    guard_ramp = 4,       ///< ramping in
    guard_fault = 8       ///< goal not finite: ramping to zero, or zero
};

struct GuardedForce {
    glm::dvec3 force{0.0};  ///< N, world axes; never longer than max_force, never NaN
    std::uint32_t reasons = guard_none;
};

/// Stands between the solver's force and one finger's device: device limits, ramp in, ramp out on a fault. It
/// only ever shortens a force. No allocation; a pure function of what it was given so far.
class ForceGuard {
public:
    explicit ForceGuard(const GuardSettings& settings) : settings_(settings) {}
    GuardedForce guard(const Contact& contact);

private:
    GuardedForce ramp_out();
    GuardSettings settings_;
    int ticks_in_ = 0;      // since the ramp in began
    int ticks_faulty_ = 0;  // since the goal stopped being finite
    glm::dvec3 last_force_{0.0};
};

}  // namespace touchable
