// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"
#include "bench/touch/touch_surface.hpp"

namespace touchable {

/// The stroke over a height field at 0.3 m/s, 600 N/m, friction 0.6 and 0.4. Finger k runs one second ahead
/// of finger k - 1.
struct TimingRun {
    TouchCase setup;
    int ticks = 30000;
    int repeats = 25;     ///< repeats of the hot loop
    int paced_ticks = 0;  ///< 0: not paced
};

inline constexpr HapticProperties timing_grip{600, 0.6, 0.4};
/// All fingers of tick 0, of tick 1, ...
std::vector<glm::dvec3> timing_goals(const TouchCase& c, int ticks);

/// Appends times, cells and events; an error if the run is invalid (verify).
Result<void> measure_timing(const TouchSurface& surface, const TimingRun& run, Figures& figures);

}  // namespace touchable
