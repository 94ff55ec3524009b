#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// From opening a device to the first frame of 1920x1080 and 16 bits, by median, and from the open device on:
/// with an empty cache of compiled shaders, ours and Mesa's, and again with what that left.
Result<void> measure_start_up(Figures& figures);

}  // namespace touchable
