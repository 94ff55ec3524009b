#pragma once

#include <cstdint>

#include "engine/base/result.hpp"
#include "haptics_cpu/contact_stiffness.hpp"

namespace touchable {

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

}  // namespace touchable
