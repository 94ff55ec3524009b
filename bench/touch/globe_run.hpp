#pragma once

#include "bench/suite.hpp"
#include "bench/touch/touch_surface.hpp"

namespace touchable {

/// The accuracy stroke on the bare globe, and closed loops under it: how wrong are direction and length of
/// the force, and does it create energy?
struct GlobeRun {
    TouchCase setup;
    int repeats = 5;              ///< of the timing of the stroke
    int flanks = 0;               ///< places where loops are pressed into the globe; 0: none
    double loop_step_mm = 0.001;  ///< of the goal per tick, device millimetres
};

/// Appends force_angle_deg_rms with its histogram, force_n_rms, force_n_max, contact_lost_ticks, the times
/// and counts of a tick, and where there are flanks the energies.
Result<void> measure_globe(const TouchSurface& surface, const GlobeRun& run, Figures& figures);

/// Energy created by press-slide-retract loops on 45-degree flanks (bench/README.md has the definition).
Result<void> measure_energy(const TouchSurface& surface, const GlobeRun& run, Figures& figures);

}  // namespace touchable
