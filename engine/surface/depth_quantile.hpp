#pragma once

#include <vector>

#include "engine/scene/scene.hpp"
#include "engine/scene/surface_frame.hpp"

namespace touchable {

/// A frame's valid depths, row by row, scene units; the far plane where none is valid. Of a frame larger than
/// 4096x4096 every so many pixels, evenly spread. Of a lazy frame all of it is built for that. Unfinished
/// where it is asked to stop meanwhile.
std::vector<double> valid_depths(const Scene& scene, const SurfaceFrame& frame);

/// So many of them, of all (`share`: 0 to 1), are not above it. Needs one; changes their order.
double quantile(std::vector<double>& depths, double share);

}  // namespace touchable
