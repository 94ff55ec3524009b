#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Goes to frames of a clip in random order, and appends how long it took until the frame was there. An error
/// of kind check where it is not the frame that was asked for.
Result<void> measure_seek(const LiveClip& clip, int seeks, LiveClips& clips, Figures& figures);

}  // namespace touchable
