#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// A second of fingers on a globe that turns, 640x480, 16 bits: by the solver's own functions, by
/// touch_solver_tick and by touch_solver_run, in turn; the least CPU time of a tick of each, and ratios. An
/// error where their forces are not the same bits.
Result<void> measure_c_ticks(int fingers, int repeats, Figures& figures);

}  // namespace touchable
