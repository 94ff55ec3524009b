#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Reads a clip, and reads and builds it, as fast as that goes, and appends the figures (bench/README.md,
/// "Suite live"). `colour`: it is wanted. An error of kind check where a plane of touch, or one that is kept
/// exactly, is not what went in.
Result<void> measure_feed(const LiveClip& clip, bool colour, int rounds, LiveClips& clips, Figures& figures);

}  // namespace touchable
