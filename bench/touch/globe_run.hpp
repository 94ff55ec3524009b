// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"
#include "bench/touch/touch_surface.hpp"

namespace touchable {

/// The accuracy stroke on the bare globe, and closed loops under its surface: measures errors of the force's
/// direction and length, and created energy.
struct GlobeRun {
    TouchCase setup;
    int repeats = 5;              ///< repeats of the timed stroke
    int flanks = 0;               ///< number of places where loops are pressed into the globe
    double loop_step_mm = 0.001;  ///< goal's step per tick, device millimetres
};

/// Appends force_angle_deg_rms with its histogram, force_n_rms, force_n_max, contact_lost_ticks, the times
/// and counts of a tick, and with flanks the energies.
Result<void> measure_globe(const TouchSurface& surface, const GlobeRun& run, Figures& figures);

/// Energy created by press-slide-retract loops on 45-degree flanks (bench/README.md has the definition).
Result<void> measure_energy(const TouchSurface& surface, const GlobeRun& run, Figures& figures);

}  // namespace touchable
