#pragma once

#include "bench/suite.hpp"
#include "bench/touch/touch_surface.hpp"

namespace touchable {

/// The timing stroke over a scene that moves, its frames published into a SurfaceTimeline as a live session
/// does.
struct FrameChangeRun {
    TouchCase setup;
    int ticks = 30000;
};

/// Appends new_frame_us, by how much the median tick that meets a new pair of frames is longer than the
/// median tick, and times and counts of both kinds of tick. A tick here begins with asking the timeline for
/// its pair.
Result<void> measure_frame_changes(const TouchSurface& surface, const FrameChangeRun& run, Figures& figures);

}  // namespace touchable
