#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// A clip of a globe of that size, all planes, read to its end `repeats` times by its reader and by
/// touch_clip_next, in turn: frames a second of the best time, and their ratio.
Result<void> measure_c_reading(int width, int height, int frames, int repeats, Figures& figures);

}  // namespace touchable
