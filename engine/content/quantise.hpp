#pragma once

#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/content/scenes.hpp"

namespace touchable {

/// Analytic depths of a whole picture at time t, row-major, scene units.
std::vector<double> sample_depths(const AnalyticScene& scene, double t, RowBands& rows);

/// Writes each depth's nearest code as the scene's plane of 8 or 16 bits.
void quantise(const Scene& scene, const std::vector<double>& depths, RowBands& rows, FramePlanes& planes);

/// The planes seen as a frame that keeps them alive.
RawFrame view_of(std::shared_ptr<const FramePlanes> planes, const Scene& scene, std::int64_t number);

}  // namespace touchable
