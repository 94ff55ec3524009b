// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Seeks frames of a clip in random order and appends the time until each frame is read. An error of kind
/// check if it is another frame.
Result<void> measure_seek(const LiveClip& clip, int seeks, LiveClips& clips, Figures& figures);

}  // namespace touchable
