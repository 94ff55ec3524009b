#pragma once

#include <vector>

#include "engine/scene/scene.hpp"

namespace touchable {

/// A length that was measured at a depth, both in scene units and above zero, and how much it counts.
struct LengthAtDepth {
    double depth, length, weight;
};

/// constant + quadratic depth^2 with the least squares of relative errors; neither is negative. Zero without
/// lengths.
DepthLength fitted_length(const std::vector<LengthAtDepth>& lengths);

}  // namespace touchable
