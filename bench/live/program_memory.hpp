// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// Peak memory of the program (the kernel's VmHWM) while `touchable make` writes a clip of 1920x1080 and
/// while `touchable touch --live` plays one with all planes.
Result<void> measure_program_memory(const LiveClip& clip, LiveClips& clips, Figures& figures);

}  // namespace touchable
