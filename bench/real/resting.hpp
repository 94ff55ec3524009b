#pragma once

#include <vector>

#include "bench/real/depth_plane.hpp"
#include "bench/suite.hpp"
#include "engine/scene/frames.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Appends force_band_mn and force_step_n_max of fingers that are held still 3 mm under the middles of these
/// planes while frames come at the scene's rate: what is felt from 20 to 500 Hz once `settled` frames have
/// passed, over 1024 ticks. An error where there are too few frames for that.
Result<void> measure_rest(const Scene& scene, const std::vector<SurfaceFrame>& frames,
                          const std::vector<DepthPlane>& planes, int settled, Figures& figures);

}  // namespace touchable
