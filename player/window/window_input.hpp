#pragma once

#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include "player/window/pointer.hpp"
#include "player/window/window_clock.hpp"

namespace touchable {

class WindowCore;

/// Tells the second of two quick presses at the same place from presses that touch.
class DoubleClick {
public:
    static constexpr double longest_s = 0.3;    ///< from press to press
    static constexpr double farthest_px = 6.0;  ///< between the two presses

    /// Whether the press of that moment, at that place, is a second one; a third is a first again.
    bool press(double now_s, const glm::dvec2& at) {
        const bool is_second =
            first_s_ && now_s - *first_s_ <= longest_s && glm::distance(at, at_) <= farthest_px;
        first_s_ = is_second ? std::nullopt : std::optional(now_s);
        at_ = at;
        return is_second;
    }
    /// What comes next belongs to no press before it.
    void forget() { first_s_.reset(); }

private:
    std::optional<double> first_s_;
    glm::dvec2 at_{0.0};
};

/// What a person does to the window: keys become commands; the pointer and fingers on a touch screen go to
/// the panel, to a mode that has the left button, or to the fingers over the clip and its view. By the
/// window's thread.
class WindowInput {
public:
    explicit WindowInput(WindowCore& core) : core_(core) {}

    /// An event that no mode takes.
    void take(const InputEvent& event);
    /// After a machine was suspended it is not known what is still pressed. Lifts all fingers and buttons
    /// that were down; the force of a finger that comes down again begins at zero.
    void lift_after_sleep();
    /// Lifts fingers on a touch screen, whatever they do: the window is looked at no more, or the clip goes.
    void lift_touches();
    /// The pointer leaves the picture: its fingers touch nothing, and nothing is held.
    void leave_picture();
    /// A button that is still pressed on something of the panel clicks nothing.
    void release_panel();
    /// The pointer moves by so many pixels.
    void move_by(double x, double y);
    void begin_clip() { pointer_ = PointerInput(); }
    /// Once a turn, with a clip: shows and hides the pointer and the bar.
    void go_on();

    /// Where the pointer is, or was last: window, pixels.
    const glm::dvec2& pointer() const { return at_; }
    /// The same, unless it is away, or over the panel.
    std::optional<glm::dvec2> pointer_over_picture() const;
    /// Whether a button is held that was pressed over the picture.
    bool holds_pointer() const { return pointer_.holds(); }
    /// Whether a button is, or a finger on a touch screen.
    bool holds() const { return pointer_.holds() || touches_.holds(); }
    /// As far as is known.
    bool has_touch_screen() const;
    std::optional<glm::dvec2> take_double_click() { return pointer_.take_double_click(); }

    /// Fingers leave: the pointer is over another place then, to which a pressed one would be torn.
    void turn_fullscreen();
    void set_fullscreen(bool on) { is_fullscreen_ = on; }
    bool fullscreen() const { return is_fullscreen_; }

    /// Since the last picture, for the panel.
    std::vector<InputEvent> take_events() { return std::exchange(events_, {}); }
    bool has_events() const { return !events_.empty(); }
    /// The first that is in no picture yet.
    std::optional<WindowClock::time_point> take_first_event() { return std::exchange(first_event_, {}); }
    /// Files and folders that were dropped at once.
    std::vector<std::string> take_dropped() { return std::exchange(dropped_, {}); }
    bool has_dropped() const { return !dropped_.empty(); }

private:
    void take_key(const InputEvent& event);
    void take_pointer(const InputEvent& event);
    void take_touch(const InputEvent& event);
    void take_pointers(const std::vector<InputEvent>& events);
    TouchInput::Ground ground_at(double x, double y);
    bool clicks_for_fullscreen(const InputEvent& event, bool is_of_panel);
    bool bar_is_wanted() const;

    WindowCore& core_;
    PointerInput pointer_;
    TouchInput touches_;
    bool was_touched_ = false;  // by a finger on a touch screen
    glm::dvec2 at_{0.0};
    bool is_there_ = false;  // the pointer, in the window
    DoubleClick fullscreen_click_;
    bool is_fullscreen_ = false;
    std::vector<InputEvent> events_;
    std::vector<std::string> dropped_;
    std::optional<WindowClock::time_point> first_event_;
    WindowClock::duration slept_ = WindowClock::slept();
};

}  // namespace touchable
