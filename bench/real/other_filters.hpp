// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "bench/real/built_frames.hpp"
#include "bench/real/sensor_models.hpp"
#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// What a way to filter is judged by.
struct Judges {
    const Scene& scene;                                       ///< without filters
    const std::vector<RawFrame>& raws;                        ///< of `scene`; the program chooses by them
    std::function<Result<double>(const Filtering&)> degrees;  ///< RMS, of forces
    std::function<Result<double>(const Filtering&)> lag_mm;   ///< null: not measured
};

/// Measures the program's choice beside filters of others (docs/measurements.md, Other filters): `rs`,
/// librealsense's spatial and temporal filter by their published algorithm, in float; `cv`, OpenCV's
/// bilateral filter. Of each a default setting (rs_default), the one of some fifty that leaves the least
/// error (rs_least), and the one that does so among those that keep as much relief as ours (rs; absent: none
/// does). Appends of each, and of `ours`: _deg; _pen_pct, what is left of a pen 5 pixels wide and 4 least
/// steps of `model` high; _lag_mm; _cpu_ms of a frame; _times, the error over ours.
Result<void> compare_with_others(const SensorModel& model, const Judges& judges, Figures& figures);

}  // namespace touchable
