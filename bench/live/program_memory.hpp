#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The most memory that the program itself holds, as the kernel counts it (VmHWM), while `touchable make`
/// writes a clip of 1920x1080 and while `touchable touch --live` plays one with all planes.
Result<void> measure_program_memory(const LiveClip& clip, LiveClips& clips, Figures& figures);

}  // namespace touchable
