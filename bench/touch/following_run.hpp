// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"
#include "bench/touch/touch_surface.hpp"

namespace touchable {

/// The stroke over `bumps` or `moving` without friction: measures whether the proxy stays at the true
/// surface's nearest point to the hand.
struct FollowingRun {
    TouchCase setup;
    double speed = 0.3;  ///< m/s
    int ticks = 30000;
    int repeats = 1;  ///< repeats of the timing
};

/// Appends off_surface_pct, contact_lost_ticks, distances, the largest step of the force and the times of a
/// tick.
Result<void> measure_following(const TouchSurface& surface, const FollowingRun& run, Figures& figures);

}  // namespace touchable
