// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Touches a whole clip in real time with five fingers, like `touchable touch --live --fingers 5`, and
/// appends figures of late ticks and frames.
Result<void> measure_live(const LiveClip& clip, LiveClips& clips, Figures& figures);

}  // namespace touchable
