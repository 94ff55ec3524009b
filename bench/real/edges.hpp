#pragma once

#include "bench/real/filter_choices.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Focal length of the camera that sees the edges, pixels.
inline constexpr double edges_focal_length = 285;

/// What filters leave of small things in front of a leaning wall, which a camera with levels sees from 0.75
/// to 1.5 m away: a pen 5 pixels wide and 10 levels high, a step of 4 levels, a box 300 mm before the wall.
/// Appends pen_pct, step_px and bleed_px without noise, and _noisy with it (bench/README.md).
Result<void> measure_edges(const SensorModel& model, const FilterChoice& choice, Figures& figures);

}  // namespace touchable
