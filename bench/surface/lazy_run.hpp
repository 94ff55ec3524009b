#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// What the lazy builder adds to a tick of the timing stroke over `bumps` of this size, 16 bits, 30 frames a
/// second, by fingers (1, 5, 10) and median (0, 3, 5): CPU time of the ticks and of taking in the frames,
/// less that of ticks over frames that somebody else has built. An error where any force differs.
Result<void> measure_lazy(int width, int height, bool quick, Figures& figures);

}  // namespace touchable
