// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "bench/real/depth_plane.hpp"
#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Appends force_band_mn and force_step_n_max of fingers held still 3 mm under the middles of these planes
/// while frames come at the scene's rate: the force from 20 to 500 Hz after `settled` frames, over 1024
/// ticks. An error if there are too few frames.
Result<void> measure_rest(const Scene& scene, const std::vector<SurfaceFrame>& frames,
                          const std::vector<DepthPlane>& planes, int settled, Figures& figures);

}  // namespace touchable
