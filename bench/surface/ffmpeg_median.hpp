#pragma once

#include "bench/suite.hpp"
#include "bench/surface/surface_case.hpp"

namespace touchable {

/// FFmpeg's filter `median` over the picture's stored values, by the scene's side, 3 or 5; nothing where the
/// program was built without libavfilter. An error where its codes are not the CPU builder's. It takes as
/// long as some hundred frames of others: to be asked of small pictures, without invalid pixels.
Result<void> measure_ffmpeg_median(const SurfaceCase& c, const Picture& picture, int frames,
                                   Figures& figures);

}  // namespace touchable
