// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Reads a clip, and reads and builds it, as fast as possible, and appends the figures (bench/README.md,
/// "Suite live"). `colour`: read colour, too. An error of kind check if a touch plane, or another lossless
/// plane, differs from the source.
Result<void> measure_feed(const LiveClip& clip, bool colour, int rounds, LiveClips& clips, Figures& figures);

}  // namespace touchable
