#pragma once

#include <algorithm>

namespace touchable {

/// 0 below `from`, 1 above `to`, between them the cubic that is level at both ends.
inline double smooth_step(double from, double to, double x) {
    const double t = std::clamp((x - from) / (to - from), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

}  // namespace touchable
