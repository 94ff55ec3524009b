// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The window of `touchable play` without a display, for the length of a clip.
struct WindowRun {
    enum class Use {
        touched,  ///< five fingers press while the pointer moves
        watched,  ///< no finger
        paused,   ///< the same, at rest
    };
    LiveClip clip;
    Use use = Use::touched;
    double turned = 0;  ///< degrees to the right, from the clip's own view
    int width = 1280, height = 720;
    std::string painter = "auto", builder = "auto";  ///< as in PlayOptions and BuilderChoice
};

/// Measures the window, after half a second of the same run, which fills the shader cache. Of a paused one:
/// what it does from the third second on.
Result<void> measure_window(const WindowRun& run, LiveClips& clips, Figures& figures);

}  // namespace touchable
