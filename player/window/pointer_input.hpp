#pragma once

#include <chrono>
#include <glm/vec2.hpp>
#include <optional>
#include <string>

#include "player/window/input_event.hpp"
#include "player/window/pointer_fingers.hpp"
#include "player/window/window_view.hpp"

namespace touchable {

/// What the pointer does over the picture: it leads the fingers, presses, and turns and moves the view. The
/// left button with Ctrl is a middle button.
class PointerInput {
public:
    using Clock = std::chrono::steady_clock;

    /// An event that no panel takes; of a picture of that size. Keys are not the pointer's.
    void take(const InputEvent& event, PointerFingers& fingers, WindowView& view, int width, int height);
    /// Likewise where fingers are led by something else: left and middle button turn the view, the right one
    /// moves it, the wheel nears it. `fingers` know where the pointer is, and nobody feels them.
    void take_for_view(const InputEvent& event, PointerFingers& fingers, WindowView& view, int width,
                       int height);
    /// By so many pixels, for whoever has keys alone; from the middle of the picture where it was nowhere.
    void move_by(const glm::dvec2& pixels, int width, int height, PointerFingers& fingers);
    /// The panel has the pointer, or it is nowhere: fingers leave, and nothing is held.
    void leave(PointerFingers& fingers);
    /// Whether a button is held that was pressed over the picture.
    bool holds() const { return !held_.empty(); }
    /// Where it clicked twice with the middle button, once.
    std::optional<glm::dvec2> take_double_click();

private:
    void press(const InputEvent& event);
    void drag(const glm::dvec2& moved, PointerFingers& fingers, WindowView& view, int width, int height);

    glm::dvec2 at_{0.0};
    std::string held_;  // the button
    std::optional<Clock::time_point> last_middle_;
    std::optional<glm::dvec2> double_click_;
    bool shift_ = false;
};

}  // namespace touchable
