#include "player/window/view_mode.hpp"

#include "player/window/window_core.hpp"

namespace touchable {

void ViewMode::go_home() {
    core_.clip()->view().go_home();
    is_turning_ = false;
}

/// A finger that presses leaves, as no event would lift it.
void ViewMode::turn_or_touch() {
    if (core_.options.hand) return core_.say("dragging turns the view already");
    is_turning_ = !is_turning_;
    if (is_turning_) {
        core_.input().leave_picture();
        core_.clip()->fingers().lift();
        core_.take_button(*this);
    }
    core_.say(is_turning_ ? "drag: the view turns; with the right button it moves; the wheel comes nearer"
                          : "the left button presses the finger again");
}

}  // namespace touchable
