#pragma once

#include <string>

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The window of `touchable play` without a display, for the length of a clip, with five fingers pressed on
/// it while the pointer moves.
struct WindowRun {
    LiveClip clip;
    double turned = 0;  ///< degrees to the right, from the clip's own view
    int width = 1280, height = 720;
    std::string painter = "auto", builder = "auto";  ///< as in PlayOptions and BuilderChoice
};

/// Measures the window, after half a second of the same run, which fills the shader cache.
Result<void> measure_window(const WindowRun& run, LiveClips& clips, Figures& figures);

}  // namespace touchable
