#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// Reads a clip of a globe of that size, all planes, to its end `repeats` times, alternately with its reader
/// and with touch_clip_next: frames per second in the best time, and the ratio.
Result<void> measure_c_reading(int width, int height, int frames, int repeats, Figures& figures);

}  // namespace touchable
