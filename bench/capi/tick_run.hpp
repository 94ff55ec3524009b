#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// Fingers on a turning globe for a second, 640x480, 16 bits, alternately by the solver's own functions, by
/// touch_solver_tick and by touch_solver_run: the least CPU time of a tick of each, and ratios. An error if
/// their forces differ in a bit.
Result<void> measure_c_ticks(int fingers, int repeats, Figures& figures);

}  // namespace touchable
