// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// Measures the time from opening a device, and from the open device, to the first frame of 1920x1080 and 16
/// bits, by median: with empty shader caches, ours and Mesa's, and again with the caches filled.
Result<void> measure_start_up(Figures& figures);

}  // namespace touchable
