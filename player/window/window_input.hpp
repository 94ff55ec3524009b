// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "player/view/pointer.hpp"
#include "player/window/window_clock.hpp"
#include "player/window/window_command.hpp"

namespace touchable {

class WindowPanel;
class WindowState;

/// Detects the second of two quick presses at the same place, in contrast to touching presses.
class DoubleClick {
public:
    static constexpr double longest_s = 0.3;    ///< from press to press
    static constexpr double farthest_px = 6.0;  ///< between the two presses

    /// Whether this press is a second one; a third counts as a first again.
    bool press(double now_s, const glm::dvec2& at) {
        const bool is_second =
            first_s_ && now_s - *first_s_ <= longest_s && glm::distance(at, at_) <= farthest_px;
        first_s_ = is_second ? std::nullopt : std::optional(now_s);
        at_ = at;
        return is_second;
    }
    /// Makes the next press a first one.
    void forget() { first_s_.reset(); }

private:
    std::optional<double> first_s_;
    glm::dvec2 at_{0.0};
};

/// User input to the window: keys become commands; the pointer and touch screen fingers go to the panel, to a
/// mode that uses the left button, or to the fingers over the clip and its view. The window's thread only.
class WindowInput {
public:
    WindowInput(WindowState& window, WindowPanel& panel) : window_(window), panel_(panel) {}

    /// Takes an event that no mode takes. Returns the command of its key, if any.
    std::optional<WindowCommand> take(const InputEvent& event);
    /// Whether the machine was suspended since the last call. The state of buttons is unknown then.
    bool has_slept();
    /// Lifts all touch screen fingers: the window has lost the focus, or the clip changes.
    void lift_touches();
    /// The pointer leaves the picture: its fingers touch nothing, and no button is held.
    void leave_picture();
    /// Releases a button held on the panel without a click.
    void release_panel();
    /// Moves the pointer by pixels.
    void move_by(double x, double y);
    void begin_clip() {
        pointer_ = PointerInput();
        middle_click_.forget();
        middle_.reset();
    }
    /// Once a turn, with a clip: shows and hides the pointer and the bar.
    void go_on();

    /// Makes the place last clicked with the right button the view's middle.
    void centre() { middle_ = clicked_; }
    /// Where the right button was last pressed.
    const glm::dvec2& clicked() const { return clicked_; }
    /// The pointer's current or last position: window, pixels.
    const glm::dvec2& pointer() const { return at_; }
    /// The same, unless it is away, or over the panel.
    std::optional<glm::dvec2> pointer_over_picture() const;
    /// Whether a button pressed over the picture is held.
    bool holds_pointer() const { return pointer_.holds(); }
    /// Whether that or a touch screen finger is down.
    bool holds() const { return pointer_.holds() || touches_.holds(); }
    /// As far as known.
    bool has_touch_screen() const;
    /// Returns the place that becomes the view's middle, of `centre` or of a double click with the middle
    /// button, once.
    std::optional<glm::dvec2> take_middle() { return std::exchange(middle_, std::nullopt); }

    /// Lifts fingers: the pointer's place changes, and a pressed finger would jump there.
    void turn_fullscreen();
    void set_fullscreen(bool on) { is_fullscreen_ = on; }
    bool fullscreen() const { return is_fullscreen_; }

    /// Events since the last picture, for the panel.
    std::vector<InputEvent> take_events() { return std::exchange(events_, {}); }
    bool has_events() const { return !events_.empty(); }
    /// Time of the first event not shown in a picture yet.
    std::optional<WindowClock::time_point> take_first_event() { return std::exchange(first_event_, {}); }
    /// Files and folders dropped together.
    std::vector<std::string> take_dropped() { return std::exchange(dropped_, {}); }
    bool has_dropped() const { return !dropped_.empty(); }

private:
    std::optional<WindowCommand> command_of(const InputEvent& event) const;
    void take_pointer(const InputEvent& event);
    void take_touch(const InputEvent& event);
    void take_pointers(const std::vector<InputEvent>& events);
    TouchInput::Ground ground_at(double x, double y);
    bool clicks_for_fullscreen(const InputEvent& event, bool is_of_panel);
    bool bar_is_wanted() const;

    WindowState& window_;
    WindowPanel& panel_;
    PointerInput pointer_;
    TouchInput touches_;
    bool was_touched_ = false;  // by a touch screen finger
    glm::dvec2 at_{0.0};
    bool is_there_ = false;  // the pointer, in the window
    DoubleClick fullscreen_click_, middle_click_;
    std::optional<glm::dvec2> middle_;
    glm::dvec2 clicked_{0.0};
    bool is_fullscreen_ = false;
    std::vector<InputEvent> events_;
    std::vector<std::string> dropped_;
    std::optional<WindowClock::time_point> first_event_;
    WindowClock::duration slept_ = WindowClock::slept();
};

}  // namespace touchable
