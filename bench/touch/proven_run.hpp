// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"
#include "bench/touch/touch_surface.hpp"

namespace touchable {

/// A stroke whose every tick is solved again by the reference solver, in long double and from the same state,
/// and checked with its certificates. Nothing is timed.
struct ProvenRun {
    TouchCase setup;
    double speed = 0.3;  ///< m/s of a height field's stroke; the globe has its accuracy stroke
    int ticks = 30000;   ///< of a height field's stroke
};

/// Appends proven_ticks, capped_ticks, tunnelled_ticks, non_minima_ticks, basin_mismatch_ticks,
/// distance_over_reference_max and reference_angle_deg_max (bench/README.md).
Result<void> measure_proof(const TouchSurface& surface, const ProvenRun& run, Figures& figures);

}  // namespace touchable
