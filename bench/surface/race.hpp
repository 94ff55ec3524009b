#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "bench/suite.hpp"

namespace touchable {

/// The least of some frames, milliseconds.
struct FrameTimes {
    double wall_ms = HUGE_VAL, cpu_ms = HUGE_VAL;  ///< CPU time: of all threads of the process
};

/// One way to make a frame.
struct Racer {
    std::string name;
    std::function<Result<void>()> frame;
    FrameTimes times = {};
};

/// Has every racer make a frame, in turn, round after round, so that whatever else the machine does meets all
/// of them.
Result<void> race(std::vector<Racer>& racers, int rounds);

/// `<what>_ms` and `<what>_cpu_ms`.
void add_times(Figures& figures, const std::string& what, const FrameTimes& times);

}  // namespace touchable
