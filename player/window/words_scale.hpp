#pragma once

#include "player/window/screen.hpp"

namespace touchable {

/// How large words, lines and bars are in a window, as ScreenSize::scale: the display's, and more where the
/// window has more room than 1280x720 of such pixels. By the root of that, because whoever has a large window
/// wants to see more in it; `from_afar`, as visitors of a kiosk look, by all of it. In steps of a quarter, so
/// that a window that is being resized seldom changes them.
double words_scale(const ScreenSize& size, bool from_afar);

}  // namespace touchable
