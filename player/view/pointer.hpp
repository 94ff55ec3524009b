// SPDX-License-Identifier: Apache-2.0
#pragma once

// The mouse as a finger, fingers on a touch screen, and the view that both turn. docs/play.md describes the
// user's side, how a finger gets over obstacles, and the reason for each length.
//
// PointerInput (the mouse) and TouchInput (a touch screen) process the window's events. Each event moves the
// fingers (PointerFingers) or turns, moves and zooms the view (WindowView). Once a picture the fingers' goals
// are computed from the picture and the last contacts:
//
//     pointer.take(event, PointerInput::Leads::fingers, fingers, view, width, height);  // for each event
//     fingers.intend(field, view.camera(width, height), felt);                          // once a picture
//
// The goals go to a PointerDevice, from which the haptic thread reads the fingers' positions. All of it
// never waits, and never fails. Pointer positions are pixels of the picture from its upper left; lengths
// whose names end in _m are the hand's (device metres), along a ray and growing into the surface; all other
// positions are in world coordinates.
// Threads: all of this belongs to the window's, or the page's worker.

#include <array>
#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/haptic_device.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/height_field.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/view/view.hpp"

namespace touchable {

/// A user input, from a window system or a script. Positions are pixels of the picture, from its upper left.
struct InputEvent {
    enum class Kind {
        moved,     ///< the pointer, to (x, y)
        pressed,   ///< a button, `word`: left, right or middle
        released,  ///< as `pressed`
        wheel,     ///< turned by y notches, away from the person is positive
        key,  ///< `word`: a letter, digit or sign, or space, left, right, up, down, home, tab, escape, ...
        key_released,  ///< as `key`
        resized,       ///< the picture has another size, or has to be shown again
        dropped,       ///< `word`: a file or folder that was dropped on the window
        left_window,   ///< the pointer left, or the window lost the focus: nothing touches
        touch_began,   ///< a finger came down on a touch screen, at (x, y); `touch` is its number
        touch_moved,   ///< as `touch_began`
        touch_ended,   ///< it was lifted
        close          ///< a request to close the window
    };
    Kind kind = Kind::moved;
    double x = 0, y = 0;
    std::string word{};
    bool control = false, shift = false;  ///< held at that moment
    bool repeated = false;                ///< a key that is still held
    bool stopped_force = false;           ///< a key that has already switched all forces off on arrival
    std::int64_t touch = 0;               ///< unique among the fingers that are down
    double seconds = 0;                   ///< of a touch; its clock is monotonic while a finger is down
};

inline bool is_touch(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    return event.kind == Kind::touch_began || event.kind == Kind::touch_moved ||
           event.kind == Kind::touch_ended;
}

/// The window's viewpoint: the clip's own camera, until the view is turned, moved or zoomed.
class WindowView {
public:
    /// `middle`: of the visible scene, world.
    WindowView(const Scene& scene, const glm::dvec3& middle);

    ViewCamera camera(int width, int height) const;
    /// Keeps a share of the picture's width on the right free, and one of its height below.
    void leave_free(const glm::dvec2& shares) { free_ = shares; }
    /// Call it with each picture's field. In the clip's own view, it finds the thing in the middle of the
    /// picture: the surface that reaches from there to the next edge, or what is nearest to it. A later turn
    /// goes round that thing and keeps it where it is in the picture. At first, or without depth, `middle`.
    void note_middle(const HeightField& field);
    /// Copies the rotation and zoom of `other`, the view of another clip.
    void look_as(const WindowView& other);
    /// Whether the view is the clip's own camera.
    bool own() const { return now_.own; }
    const Viewpoint& orbit() const { return now_.orbit; }
    /// Distance of neighbouring vertices in the middle of a picture of that size, pixels, if the view is not
    /// turned; in a turned view some are closer.
    double pixels_per_vertex(int width, int height) const;

    /// Degrees turned by a drag as long as the picture's height.
    static constexpr double degrees_per_height = 216;
    /// Turns the view by degrees to the right and up.
    void turn(double azimuth, double elevation);
    /// Moves the view so that the picture, of that size, follows the pointer by (x, y) pixels.
    void pan(double x, double y, int width, int height);
    /// Zooms in by this factor; below 1 out.
    void near_by(double factor) {
        now_.own = false;
        now_.orbit.zoom = std::clamp(now_.orbit.zoom.value_or(1) * factor, 0.1, 20.0);
    }
    /// Makes the view turn round this place, and shows it at the clip camera's principal point.
    void look_at(const glm::dvec3& place);
    void go_home();

    /// Of what a camera sees in its picture: about the middle, in shares from -1 to 1.
    struct Placing {
        double scale = 1;
        glm::dvec2 shift{0.0};
        void apply(ViewCamera& camera) const;
    };
    /// All that turning, moving and zooming change.
    struct State {
        bool own = true;
        Viewpoint orbit{};
        glm::dvec3 centre{0.0};
        std::vector<glm::dvec3> thing;   // points of what turns in place, world
        std::optional<Placing> placing;  // of a view that was moved; else `placing` follows the thing
        /// Whether both look the same; of the clip's own view, whatever its thing is.
        bool looks_as(const State& other) const;
    };
    const State& state() const { return now_; }
    void set_state(const State& state) { now_ = state; }

private:
    void set_centre(const glm::dvec3& place);
    struct Covered {
        glm::dvec2 middle{0.0}, size{0.0};
    };
    Covered covered_by_thing(const Viewpoint& viewpoint, int width, int height) const;
    Placing placing(int width, int height) const;

    const Scene& scene_;
    glm::dvec3 home_;
    glm::dvec2 free_{0.0};
    State now_;
};

/// The pointer over the picture as fingers of a device: hovering above the surface, or pressed into it. Or
/// the fingers on a touch screen, each of which presses; while one is down the pointer moves none.
class PointerFingers {
public:
    static constexpr int most = 5;
    static constexpr double hover_m = -0.004;  ///< above the surface while nothing presses
    static constexpr double press_m = 0.004;   ///< depth while the button is held
    /// Range of the wheel. A new finger begins at highest_m, and is lifted to it over an edge.
    static constexpr double deepest_m = 0.012, highest_m = 2 * hover_m;

    /// `device` has `most` fingers and outlives this.
    PointerFingers(PointerDevice& device, const Workspace& workspace)
        : device_(device), workspace_(workspace) {}

    /// The surface that a finger touches at that place of the picture. nullopt: a hole, beside the clip, or
    /// the surface's back.
    static std::optional<ViewCamera::Pick> ground_at(const HeightField& field, const ViewCamera& camera,
                                                     const glm::dvec2& at);

    void set_count(int fingers) { count_ = fingers; }
    int count() const { return count_; }
    /// Number of fingers with a goal: none until the pointer was over a surface.
    int shown() const { return distance_ && (is_touched() || pointer_) ? present() : 0; }
    /// Number of fingers, with a goal or without: on a touch screen up to the last that is down.
    int present() const { return is_touched() ? touched() : count_; }
    /// Whether touch screen fingers drive them.
    bool is_touched() const { return touched() > 0; }
    /// The pointer's position; nullopt: absent, and no finger touches.
    void set_pointer(std::optional<glm::dvec2> at);
    const std::optional<glm::dvec2>& pointer() const { return pointer_; }
    /// The place of the user's attention: the pointer's, or that of the first finger on a touch screen.
    std::optional<glm::dvec2> looked_at() const;

    // Fingers on a touch screen, which count from 0.
    /// A finger comes down there and presses; returns its number. nullopt: all are down.
    std::optional<std::size_t> put_down(const glm::dvec2& at);
    void move(std::size_t finger, const glm::dvec2& at) { fingers_[finger].touch = at; }
    /// The finger touches nothing any more, from now on.
    void lift(std::size_t finger) {
        fingers_[finger].touch.reset();
        device_.withdraw(finger);
    }

    void press(bool held) {
        held_ = held;
        was_pressed_ = was_pressed_ || held;
    }
    bool was_pressed() const { return was_pressed_; }  ///< ever
    /// Device metres, into the surface; stays after the button is released.
    void deepen(double metres) { rest_m_ = std::clamp(rest_m_ + metres, highest_m, deepest_m); }
    /// Resets the depth to `hover_m`: fingers hover above the surface until they are pressed.
    void lift() { rest_m_ = hover_m; }
    /// Intended depth of fingers in the surface; below 0 above it.
    double depth_m() const { return held_ || is_touched() ? std::max(press_m, rest_m_) : rest_m_; }

    /// Once a picture: sets the device's goals for the fingers over `field` as seen by `camera`. `felt`:
    /// their last contacts; a finger without one goes straight to its place, ignoring obstacles.
    void intend(const HeightField& field, const ViewCamera& camera, std::span<const Contact> felt = {});

private:
    struct Finger {
        std::optional<glm::dvec2> touch;  // position on a touch screen
        bool is_lifted = false;           // on its way over an obstacle
        glm::dvec3 lifted_for{0.0};       // the place under the pointer at the last lift
    };
    int touched() const;
    void lead(std::size_t finger, const glm::dvec2& at, const HeightField& field, const ViewCamera& camera,
              const Contact* felt);
    std::optional<glm::dvec3> detour(Finger& finger, const HeightField& field, const glm::dvec3& ground,
                                     double deep_m, const Contact& felt) const;
    bool is_caught(const Contact& felt, double deep_m) const;

    PointerDevice& device_;
    Workspace workspace_;
    std::optional<glm::dvec2> pointer_;
    std::array<Finger, most> fingers_{};
    int count_ = 1;
    bool held_ = false, was_pressed_ = false;
    double rest_m_ = hover_m;
    std::optional<double> distance_;  // scene units, from the eye to the last surface hit
};

/// The mouse's actions over the picture. The left button with Ctrl acts as the middle button.
class PointerInput {
public:
    enum class Leads {
        fingers,  ///< the left button presses them, the right one and the wheel deepen; the middle one turns
                  ///< the view
        view      ///< the left and the middle button turn it, the right one moves it, the wheel zooms it
    };
    /// Takes an event that no panel takes, for a picture of that size. Ignores keys. `fingers` get the
    /// pointer's position even if it controls the view, when something else moves them.
    void take(const InputEvent& event, Leads leads, PointerFingers& fingers, WindowView& view, int width,
              int height);
    /// Moves the pointer by pixels, with keys; from the picture's middle if it was absent.
    void move_by(const glm::dvec2& pixels, int width, int height, PointerFingers& fingers);
    /// The panel takes the pointer, or it is absent: fingers leave, and no button is held.
    void leave(PointerFingers& fingers);
    /// Whether a button pressed over the picture is held.
    bool holds() const { return !held_.empty(); }

private:
    glm::dvec2 move_to(const glm::dvec2& place, PointerFingers& fingers);
    void press(const InputEvent& event);
    void drag(const glm::dvec2& moved, Leads leads, PointerFingers& fingers, WindowView& view, int width,
              int height);

    glm::dvec2 at_{0.0};
    std::string held_;  // the button
    bool shift_ = false;
};

/// Fingers on a touch screen. A finger put down on the surface touches it, until it is lifted. Two put down
/// together that soon move turn the view, and zoom it by their distance, until both are lifted; two that rest
/// first, or three and more, touch. One put down beside the surface turns the view.
class TouchInput {
public:
    static constexpr double together_s = 0.3;    ///< two fingers within this time are put down together
    static constexpr double rest_s = 0.5;        ///< a pair that rests this long touches
    static constexpr double moved_share = 0.03;  ///< of the picture's height; more counts as moved

    /// What lies under a new touch.
    enum class Ground {
        surface,
        nothing,  ///< a hole, or beside the clip; or another device moves the fingers
        pointers  ///< a panel, or another user of the pointer's left button
    };
    /// What touches control. Null: there is no clip, and every `ground` is the pointer's.
    struct Led {
        PointerFingers* fingers = nullptr;
        WindowView* view = nullptr;
    };
    /// Takes a touch event, for a picture of that size. `ground` counts when it begins. Returns the pointer's
    /// events if the touch stands for it.
    std::vector<InputEvent> take(const InputEvent& event, Ground ground, const Led& led, int width,
                                 int height);
    /// Whether a finger is down.
    bool holds() const { return !touches_.empty(); }
    /// Whether a finger over the picture, not a pointer, is down where `is_there` is true.
    bool any_over_picture(const std::function<bool(const glm::dvec2&)>& is_there) const {
        return std::ranges::any_of(
            touches_, [&](const Touch& touch) { return over_picture(touch) && is_there(touch.at); });
    }
    /// Lifts all; ignores their later events. Returns the pointer's events.
    std::vector<InputEvent> cancel(PointerFingers* fingers);

private:
    enum class Role { finger, view, pointer, none };
    struct Touch {
        std::int64_t id = 0;
        Role role = Role::none;
        glm::dvec2 began{0.0}, at{0.0};
        double began_s = 0;
        std::size_t finger = 0;
    };
    /// The touches that turn the view: their middle, and mean distance from it.
    struct Spread {
        glm::dvec2 middle{0.0};
        double radius = 0;
        int touches = 0;
    };

    std::vector<InputEvent> begin(const InputEvent& event, Ground ground, PointerFingers* fingers,
                                  int height);
    void move(Touch& touch, const InputEvent& event, const Led& led, int height);
    std::vector<InputEvent> end(const Touch& touch, PointerFingers* fingers);
    static bool over_picture(const Touch& touch) {
        return touch.role == Role::finger || touch.role == Role::view;
    }
    Role role_on(Ground ground, const PointerFingers* fingers) const;
    bool is_pair(const Touch& second, int height) const;
    void begin_gesture(PointerFingers* fingers);
    Spread spread() const;
    int count(Role role) const { return static_cast<int>(std::ranges::count(touches_, role, &Touch::role)); }
    Touch* find(std::int64_t id);

    std::vector<Touch> touches_;
    std::optional<double> pair_since_s_;  // time a pair was put down, if it has not moved
    bool gesture_ = false;                // a pair turned the view, and one of its fingers is still down
};

}  // namespace touchable
