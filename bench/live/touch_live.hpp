#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Touches a clip in real time with five fingers, as `touchable touch --live --fingers 5` does, over all of
/// it, and appends what came late.
Result<void> measure_live(const LiveClip& clip, LiveClips& clips, Figures& figures);

}  // namespace touchable
