#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// From opening a device to the first frame of 1920x1080 and 16 bits, by median: with an empty cache of
/// Mesa's compiled shaders, a folder of its own, and again with what that left. Drivers that are not Mesa's
/// know no such folder: with them both times are as their own caches have it.
Result<void> measure_start_up(Figures& figures);

}  // namespace touchable
