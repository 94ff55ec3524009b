#pragma once

#include <string>

#include "bench/live/live_clip.hpp"
#include "bench/suite.hpp"

namespace touchable {

/// The window of `touchable play` without a display, over a clip that plays and that five fingers press while
/// the pointer moves: as long as the clip is.
struct WindowRun {
    LiveClip clip;
    double turned = 0;  ///< degrees to the right, from the clip's own view
    int width = 1280, height = 720;
    std::string painter = "auto", builder = "auto";  ///< as PlayOptions and BuilderChoice have them
};

/// Measures it, after half a second of the same, which fills the shader cache.
Result<void> measure_window(const WindowRun& run, LiveClips& clips, Figures& figures);

}  // namespace touchable
