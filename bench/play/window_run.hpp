#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The window of `touchable play` without a display, 1280x720, over a clip that plays and that five fingers
/// press while the pointer moves: as long as the clip is. `turned`: by how many degrees to the right the view
/// is turned from the clip's own place.
Result<void> measure_window(const LiveClip& clip, double turned, LiveClips& clips, Figures& figures);

}  // namespace touchable
