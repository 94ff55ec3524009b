// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bench/suite.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// 48 fingers that rest 3 mm under a wall seen by a noisy camera (noisy_scene.hpp), with a filter, and moving
/// objects.
struct SteadinessRun {
    std::string name;
    bool temporal = false;
    double noise_factor = 1;  ///< stated noise / true noise; a very large one: no gate
    FrameInterpolation interpolation = FrameInterpolation::linear;
    int frames = 75;
};

/// Appends force_band_mn, force_step_n_max and force_jitter_deg of the fingers at rest; lag_mm and ghost_pct
/// of the ball; lag_mm_<speed> of a wall approaching at that many mm/s (docs in bench/README.md). Nothing is
/// timed: the same figures on every machine.
Result<void> measure_steadiness(const SteadinessRun& run, Figures& figures);

}  // namespace touchable
