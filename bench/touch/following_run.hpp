#pragma once

#include "bench/suite.hpp"
#include "bench/touch/touch_surface.hpp"

namespace touchable {

/// The stroke over `bumps` or `moving` without friction: does the proxy stay where the true surface is
/// nearest to the hand?
struct FollowingRun {
    TouchCase setup;
    double speed = 0.3;  ///< m/s
    int ticks = 30000;
};

/// Appends off_surface_pct, contact_lost_ticks and distance_mm_max.
Result<void> measure_following(const TouchSurface& surface, const FollowingRun& run, Figures& figures);

}  // namespace touchable
