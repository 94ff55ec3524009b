// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// Least times of some frames, ms.
struct FrameTimes {
    double wall_ms = HUGE_VAL, cpu_ms = HUGE_VAL;  ///< CPU time: all threads of the process
};

/// One way to make a frame.
struct Racer {
    std::string name;
    std::function<Result<void>()> frame;
    FrameTimes times = {};
};

/// Lets every racer make a frame in turn, round after round, so that other load on the machine affects all of
/// them.
Result<void> race(std::vector<Racer>& racers, int rounds);

/// Appends `<what>_ms` and `<what>_cpu_ms`.
void add_times(Figures& figures, const std::string& what, const FrameTimes& times);

}  // namespace touchable
