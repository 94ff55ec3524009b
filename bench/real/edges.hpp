// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "bench/real/built_frames.hpp"
#include "bench/real/filter_choices.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Focal length of the camera, pixels.
inline constexpr double edges_focal_length = 285;

/// Measures how filters preserve small objects in front of a leaning wall, seen by a camera with levels from
/// 0.75 to 1.5 m: pens 5 pixels wide, 10 and 4 levels high, a step of 4 levels, a box 300 mm in front of the
/// wall. Appends pen_pct, low_pen_pct, step_px and bleed_px without noise, and _noisy with it
/// (bench/README.md).
Result<void> measure_edges(const SensorModel& model, const FilterChoice& choice, Figures& figures);
/// The same for filters that the program chooses from frames with noise, and objects as many of the sensor's
/// least steps high.
Result<void> measure_least_steps(const SensorModel& model, Figures& figures);

/// The same for filters that the program chooses from frames with noise, the wall `middle` mm away, the low
/// pen and the step `pen` mm high. Appends low_pen_pct, step_px, and for the wall's faces the angle to the
/// true normal, face_angle_deg_rms, and the share off by more than 20 degrees, over_20deg_pct.
Result<void> measure_low_relief(const SensorModel& model, double middle, double pen, Figures& figures);

/// Makes a scene's filtering by its first frames.
using MakeFiltering = std::function<Filtering(const std::vector<RawFrame>&, const Scene&)>;
/// Of a pen 5 pixels wide and four of the sensor's least steps high, the share that is left where frames have
/// noise, per cent.
Result<double> kept_relief_pct(const SensorModel& model, const MakeFiltering& filtering);

/// Requirements on filters without noise, for the low pen and the step.
inline constexpr double least_low_pen_pct = 95, most_step_px = 1;
Result<bool> keeps_edges(const SensorModel& model, const FilterSettings& filter);

}  // namespace touchable
