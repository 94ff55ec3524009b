#pragma once

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"

namespace touchable {

/// Measures FFmpeg's filter `median` over the picture's stored values, with the scene's side, 3 or 5; does
/// nothing without libavfilter. An error if its codes differ from the CPU builder's. It takes as long as some
/// hundred frames of the others: use small pictures, without invalid pixels.
Result<void> measure_ffmpeg_median(const SurfaceCase& c, const Picture& picture, int frames,
                                   Figures& figures);

}  // namespace touchable
