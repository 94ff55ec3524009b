// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"

namespace touchable {

/// Measures the lazy builder's addition to a tick of the timing stroke over `bumps` of this size, 16 bits, 30
/// frames a second, by fingers (1, 5, 10) and median (0, 3, 5): CPU time of the ticks and of passing in the
/// frames, less that of ticks over another builder's frames. An error if any force differs.
Result<void> measure_lazy(int width, int height, bool quick, Figures& figures);

/// The same for 8 bits with terrace removal, one finger, no median, by reach (16 to 128).
Result<void> measure_lazy_terraces(int width, int height, bool quick, Figures& figures);

}  // namespace touchable
