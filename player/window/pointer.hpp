#pragma once

// The mouse as a finger, fingers on a touch screen, and the view that both turn. docs/play.md has what a
// person sees, how a finger gets over what is in its way, and why each length is what it is.
//
// PointerInput (the mouse) and TouchInput (a touch screen) take the window's events. Each event leads the
// fingers (PointerFingers) or turns, moves and zooms the view (WindowView). Once a picture the fingers'
// goals are computed, from what is seen and what was felt:
//
//     pointer.take(event, PointerInput::Leads::fingers, fingers, view, width, height);  // for each event
//     fingers.intend(field, view.camera(width, height), felt);                          // once a picture
//
// The goals go to a PointerDevice, from which the haptic thread reads where the fingers are. All of this
// belongs to the window's thread; nothing waits, and nothing fails. Places of the pointer are pixels of the
// picture from its upper left; lengths whose names end in _m are the hand's (device metres), along a ray and
// growing into the surface; all other places are the world's.

#include <array>
#include <chrono>
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
#include "player/draw/view.hpp"
#include "player/window/input_event.hpp"

namespace touchable {

/// From where the window looks: the clip's own camera, until the view is turned, moved or zoomed.
class WindowView {
public:
    /// `middle`: of what there is to see, world.
    WindowView(const Scene& scene, const glm::dvec3& middle);

    ViewCamera camera(int width, int height) const;
    /// Keeps the lower part of the picture, that share of its height, free for something else.
    void leave_below(double share) { below_ = share; }
    /// Turned like `other`, the view of another clip, and as near.
    void look_as(const WindowView& other);
    /// Whether it is the clip's own camera.
    bool own() const { return own_; }
    const Viewpoint& orbit() const { return orbit_; }
    /// How far apart neighbouring vertices lie in the middle of a picture of that size, as long as the view
    /// is not turned; a turned one has some of them closer.
    double pixels_per_vertex(int width, int height) const;

    /// A drag as long as the picture is high turns the view by so much.
    static constexpr double degrees_per_height = 216;
    /// Turns the view by so many degrees to the right and up.
    void turn(double azimuth, double elevation);
    /// Moves the view so that the picture, of that size, follows the pointer by so many pixels.
    void pan(double x, double y, int width, int height);
    /// Brings the view nearer by this factor; below 1 farther away.
    void near_by(double factor) {
        own_ = false;
        orbit_.zoom = std::clamp(orbit_.zoom.value_or(1) * factor, 0.1, 20.0);
    }
    /// From now on the view turns round this place, which is seen then where the clip's camera has its axis.
    void look_at(const glm::dvec3& place) {
        own_ = false;
        set_centre(place);
    }
    void go_home();

private:
    void set_centre(const glm::dvec3& place);

    const Scene& scene_;
    glm::dvec3 home_, centre_{0.0};
    bool own_ = true;
    double below_ = 0;
    Viewpoint orbit_{};
};

/// The pointer over the picture as fingers of a device: above what is seen there, or pressed into it. Or the
/// fingers on a touch screen, each of which presses where it is; while one is down the pointer leads none.
class PointerFingers {
public:
    static constexpr int most = 5;
    static constexpr double hover_m = -0.004;  ///< above the surface while nothing presses
    static constexpr double press_m = 0.004;   ///< what holding the button presses to
    /// How far the wheel goes. A finger that comes begins at highest_m, and is lifted so high over an edge.
    static constexpr double deepest_m = 0.012, highest_m = 2 * hover_m;

    /// `device` has `most` fingers and outlives this.
    PointerFingers(PointerDevice& device, const Workspace& workspace)
        : device_(device), workspace_(workspace) {}

    /// The surface that a finger touches at that place of the picture. Nothing: a hole, beside the clip, or
    /// the surface from behind.
    static std::optional<ViewCamera::Pick> ground_at(const HeightField& field, const ViewCamera& camera,
                                                     const glm::dvec2& at);

    void set_count(int fingers) { count_ = fingers; }
    int count() const { return count_; }
    /// How many of them have a goal: none before the pointer was over something for the first time.
    int shown() const { return distance_ && (is_touched() || pointer_) ? present() : 0; }
    /// How many there are, with a goal or without: of a touch screen up to the last that is down.
    int present() const { return is_touched() ? touched() : count_; }
    /// Whether they are led by fingers on a touch screen.
    bool is_touched() const { return touched() > 0; }
    /// Where the pointer is; nothing: nowhere, and no finger touches.
    void set_pointer(std::optional<glm::dvec2> at);
    const std::optional<glm::dvec2>& pointer() const { return pointer_; }
    /// The place that a person looks at: the pointer's, or that of the first finger on a touch screen.
    std::optional<glm::dvec2> looked_at() const;

    // Fingers on a touch screen, which count from 0.
    /// A finger comes down there and presses: its number. Nothing: all are down.
    std::optional<std::size_t> put_down(const glm::dvec2& at);
    void move(std::size_t finger, const glm::dvec2& at) { fingers_[finger].touch = at; }
    /// It touches nothing any more, from now on.
    void lift(std::size_t finger) {
        fingers_[finger].touch.reset();
        device_.withdraw(finger);
    }

    void press(bool held) {
        held_ = held;
        was_pressed_ = was_pressed_ || held;
    }
    bool was_pressed() const { return was_pressed_; }  ///< ever
    /// Device metres, into the surface; stays when the button is let go.
    void deepen(double metres) { rest_m_ = std::clamp(rest_m_ + metres, highest_m, deepest_m); }
    /// Takes the depth back to `hover_m`: fingers are above the surface again, until they are pressed.
    void lift() { rest_m_ = hover_m; }
    /// How deep fingers are meant to be in the surface; below 0 above it.
    double depth_m() const { return held_ || is_touched() ? std::max(press_m, rest_m_) : rest_m_; }

    /// Once a picture: gives the device the goals of the fingers over what `camera` shows of `field`. `felt`:
    /// what they touched last; a finger without it goes straight to its place, whatever is in its way.
    void intend(const HeightField& field, const ViewCamera& camera, std::span<const Contact> felt = {});

private:
    struct Finger {
        std::optional<glm::dvec2> touch;  // where it is down on a touch screen
        bool is_lifted = false;           // on its way over something
        glm::dvec3 lifted_for{0.0};       // the place under the pointer when it was last lifted
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
    std::optional<double> distance_;  // scene units, from the eye to what was met last
};

/// What the mouse does over the picture. The left button with Ctrl is a middle button.
class PointerInput {
public:
    using Clock = std::chrono::steady_clock;

    enum class Leads {
        fingers,  ///< the left button presses them, the right one and the wheel deepen; the middle one turns
        view      ///< the left and the middle button turn it, the right one moves it, the wheel zooms it
    };
    /// An event that no panel takes; of a picture of that size. Keys are not the pointer's. `fingers` know
    /// where the pointer is, also where it leads the view, as something else leads them then.
    void take(const InputEvent& event, Leads leads, PointerFingers& fingers, WindowView& view, int width,
              int height);
    /// By so many pixels, by keys; from the middle of the picture if it was nowhere.
    void move_by(const glm::dvec2& pixels, int width, int height, PointerFingers& fingers);
    /// The panel has the pointer, or it is nowhere: fingers leave, and nothing is held.
    void leave(PointerFingers& fingers);
    /// Whether a button is held that was pressed over the picture.
    bool holds() const { return !held_.empty(); }
    /// The place of a double click with the middle button, once.
    std::optional<glm::dvec2> take_double_click() { return std::exchange(double_click_, std::nullopt); }

private:
    glm::dvec2 move_to(const glm::dvec2& place, PointerFingers& fingers);
    void press(const InputEvent& event);
    void drag(const glm::dvec2& moved, Leads leads, PointerFingers& fingers, WindowView& view, int width,
              int height);

    glm::dvec2 at_{0.0};
    std::string held_;  // the button
    std::optional<Clock::time_point> last_middle_;
    std::optional<glm::dvec2> double_click_;
    bool shift_ = false;
};

/// What the fingers on a touch screen do. Each that is put down on the surface touches it, until it is
/// lifted. Two that are put down together and move at once turn the view, and zoom it by their distance,
/// until both are lifted; two that rest first, or three and more, touch. One that is put down where there is
/// nothing to touch turns the view.
class TouchInput {
public:
    static constexpr double together_s = 0.3;    ///< two fingers that come within it are put down together
    static constexpr double rest_s = 0.5;        ///< two that rest so long touch
    static constexpr double moved_share = 0.03;  ///< of the picture's height: farther is moved

    /// The place where a finger is put down.
    enum class Ground {
        surface,
        nothing,  ///< a hole, or beside the clip; or fingers are led by something else
        pointers  ///< a panel, or whatever else takes a touch for the pointer's left button
    };
    /// What touches lead. Null: there is no clip, and every `ground` is the pointer's.
    struct Led {
        PointerFingers* fingers = nullptr;
        WindowView* view = nullptr;
    };
    /// A touch's event; of a picture of that size. `ground` counts as it begins. Gives what the pointer does
    /// if the touch stands for it.
    std::vector<InputEvent> take(const InputEvent& event, Ground ground, const Led& led, int width,
                                 int height);
    /// Whether a finger is down.
    bool holds() const { return !touches_.empty(); }
    /// Whether one that is over the picture, and no pointer, is down where `is_there` says.
    bool any_over_picture(const std::function<bool(const glm::dvec2&)>& is_there) const {
        return std::ranges::any_of(
            touches_, [&](const Touch& touch) { return over_picture(touch) && is_there(touch.at); });
    }
    /// All are lifted; later events of them are ignored. Gives what the pointer does.
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
    /// The touches that turn the view: their middle, and how far they are from it.
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
    std::optional<double> pair_since_s_;  // two were put down together, and have not moved
    bool gesture_ = false;                // a pair turned the view, and one of it is still down
};

}  // namespace touchable
