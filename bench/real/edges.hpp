#pragma once

#include "bench/real/filter_choices.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Focal length of the camera that sees the edges, pixels.
inline constexpr double edges_focal_length = 285;

/// What filters leave of small things in front of a leaning wall, which a camera with levels sees from 0.75
/// to 1.5 m away: pens 5 pixels wide, 10 and 4 levels high, a step of 4 levels, a box 300 mm before the wall.
/// Appends pen_pct, low_pen_pct, step_px and bleed_px without noise, and _noisy with it (bench/README.md).
Result<void> measure_edges(const SensorModel& model, const FilterChoice& choice, Figures& figures);
/// The same of filters that the program chooses by frames with noise, and of things that are as many of the
/// least steps high that the sensor can tell.
Result<void> measure_least_steps(const SensorModel& model, Figures& figures);

/// Of filters that the program chooses by frames with noise, of the same wall `middle` mm away, with the low
/// pen and the step `pen` mm high there. Appends low_pen_pct, step_px, and of the wall's faces the angle to
/// the true normal, face_angle_deg_rms, and how many are off by more than 20 degrees, over_20deg_pct.
Result<void> measure_low_relief(const SensorModel& model, double middle, double pen, Figures& figures);

/// What filters are to keep without noise: of the low pen, and of the step.
inline constexpr double least_low_pen_pct = 95, most_step_px = 1;
Result<bool> keeps_edges(const SensorModel& model, const FilterSettings& filter);

}  // namespace touchable
