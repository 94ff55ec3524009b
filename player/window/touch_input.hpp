#pragma once

#include <cstdint>
#include <functional>
#include <glm/vec2.hpp>
#include <optional>
#include <vector>

#include "player/window/input_event.hpp"
#include "player/window/pointer_fingers.hpp"
#include "player/window/window_view.hpp"

namespace touchable {

/// What the fingers on a touch screen do. Each that is put down on the surface touches it, until it is
/// lifted. Two that are put down together and move at once turn the view, and zoom it by their distance,
/// until both are lifted; two that rest first, or three and more, touch. One that is put down where there is
/// nothing to touch turns the view.
class TouchInput {
public:
    static constexpr double together_s = 0.3;    ///< two fingers that come within it are put down together
    static constexpr double rest_s = 0.5;        ///< who rests so long touches
    static constexpr double moved_share = 0.03;  ///< of the picture's height: farther is moved

    /// What is where a finger is put down.
    enum class Ground {
        surface,
        nothing,  ///< a hole, or beside the clip; or fingers are led by something else
        pointers  ///< a panel, or whatever else takes a touch for the pointer's left button
    };
    /// What touches lead. Null where no clip is there: then every `ground` is the pointer's.
    struct Led {
        PointerFingers* fingers = nullptr;
        WindowView* view = nullptr;
    };
    /// A touch's event; of a picture of that size. `ground` counts where it begins. Gives what the pointer
    /// does where the touch is one.
    std::vector<InputEvent> take(const InputEvent& event, Ground ground, const Led& led, int width,
                                 int height);
    /// Whether a finger is down.
    bool holds() const { return !touches_.empty(); }
    /// Whether one that is over the picture, and no pointer, is down where `is_there` says.
    bool any_over_picture(const std::function<bool(const glm::dvec2&)>& is_there) const;
    /// All are lifted; what still comes of them is nobody's. Gives likewise what the pointer does.
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
    /// Of those that turn the view: their middle, and how far they are from it.
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
    int count(Role role) const;
    Touch* find(std::int64_t id);

    std::vector<Touch> touches_;
    std::optional<double> pair_since_s_;  // two were put down together, and have not moved
    bool gesture_ = false;                // a pair turned the view, and one of it is still down
};

}  // namespace touchable
