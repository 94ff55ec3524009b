// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/suite.hpp"
#include "bench/touch/touch_surface.hpp"

namespace touchable {

/// The timing stroke over a moving scene whose frames are published to a SurfaceTimeline, as in a live
/// session.
struct FrameChangeRun {
    TouchCase setup;
    int ticks = 30000;
};

/// Appends new_frame_us, by how much the median tick with a new pair of frames is longer than the median
/// tick, and times and counts of both kinds of tick. A tick here includes getting its pair from the timeline.
Result<void> measure_frame_changes(const TouchSurface& surface, const FrameChangeRun& run, Figures& figures);

}  // namespace touchable
