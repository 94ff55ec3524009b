#include "player/window/pointer_input.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace touchable {
namespace {

constexpr double metres_per_notch = 0.0005, metres_per_pixel = 0.00003;  // of the hand, into the surface
constexpr double nearer_per_notch = 1.15;
constexpr std::chrono::milliseconds double_click(400);

void turn(const glm::dvec2& moved, WindowView& view, int height) {
    const glm::dvec2 degrees = moved * (WindowView::degrees_per_height / std::max(height, 1));
    view.turn(-degrees.x, degrees.y);
}

}  // namespace

void PointerInput::take(const InputEvent& event, PointerFingers& fingers, WindowView& view, int width,
                        int height) {
    using Kind = InputEvent::Kind;
    switch (event.kind) {
        case Kind::moved: {
            const glm::dvec2 to(event.x, event.y), moved = to - at_;
            at_ = to;
            fingers.set_pointer(to);
            drag(moved, fingers, view, width, height);
            break;
        }
        case Kind::pressed:
            press(event);
            if (held_ == "left") fingers.press(true);
            break;
        case Kind::released:
            if (event.word == "left") fingers.press(false);
            held_.clear();
            break;
        case Kind::wheel:
            if (event.control)
                view.near_by(std::pow(nearer_per_notch, event.y));
            else
                fingers.deepen(event.y * metres_per_notch);
            break;
        case Kind::left_window:
            leave(fingers);
            break;
        default:
            break;
    }
}

void PointerInput::take_for_view(const InputEvent& event, PointerFingers& fingers, WindowView& view,
                                 int width, int height) {
    using Kind = InputEvent::Kind;
    if (event.kind == Kind::moved) {
        const glm::dvec2 to(event.x, event.y), moved = to - at_;
        at_ = to;
        fingers.set_pointer(to);
        if (held_ == "right" || (!held_.empty() && shift_))
            view.pan(moved.x, moved.y, width, height);
        else if (!held_.empty())
            turn(moved, view, height);
    }
    if (event.kind == Kind::pressed) press(event);
    if (event.kind == Kind::released) held_.clear();
    if (event.kind == Kind::wheel) view.near_by(std::pow(nearer_per_notch, event.y));
    if (event.kind == Kind::left_window) leave(fingers);
}

void PointerInput::press(const InputEvent& event) {
    // Not every mouse has a middle button.
    held_ = event.word == "left" && event.control ? "middle" : event.word;
    shift_ = event.shift;
    if (held_ != "middle") return;
    const auto now = Clock::now();
    if (last_middle_ && now - *last_middle_ < double_click) double_click_ = at_;
    last_middle_ = now;
}

void PointerInput::drag(const glm::dvec2& moved, PointerFingers& fingers, WindowView& view, int width,
                        int height) {
    if (held_ == "right") fingers.deepen(moved.y * metres_per_pixel);
    if (held_ != "middle") return;
    if (shift_)
        view.pan(moved.x, moved.y, width, height);
    else
        turn(moved, view, height);
}

void PointerInput::move_by(const glm::dvec2& pixels, int width, int height, PointerFingers& fingers) {
    if (!fingers.pointer()) at_ = glm::dvec2(width, height) / 2.0;
    at_ = glm::clamp(at_ + pixels, glm::dvec2(0.0), glm::dvec2(width, height));
    fingers.set_pointer(at_);
}

void PointerInput::leave(PointerFingers& fingers) {
    fingers.press(false);
    fingers.set_pointer(std::nullopt);
    held_.clear();
}

std::optional<glm::dvec2> PointerInput::take_double_click() {
    return std::exchange(double_click_, std::nullopt);
}

}  // namespace touchable
