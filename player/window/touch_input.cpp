#include "player/window/touch_input.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {
namespace {

using Kind = InputEvent::Kind;

constexpr std::size_t most_touches = 32;
constexpr double degrees_per_height = WindowView::degrees_per_height;  // as a mouse
constexpr double least_radius_share = 0.01;  // of the picture's height: nearer fingers zoom nothing
constexpr double most_nearer = 2;            // with one event

InputEvent pointer_event(Kind kind, const glm::dvec2& at) {
    const bool is_button = kind == Kind::pressed || kind == Kind::released;
    return {.kind = kind, .x = at.x, .y = at.y, .word = is_button ? "left" : ""};
}

}  // namespace

std::vector<InputEvent> TouchInput::take(const InputEvent& event, Ground ground, const Led& led, int width,
                                         int height) {
    if (width < 1 || height < 1 || !std::isfinite(event.x) || !std::isfinite(event.y)) return {};
    Touch* const touch = find(event.touch);
    if (event.kind == Kind::touch_began)
        return touch ? std::vector<InputEvent>() : begin(event, ground, led.fingers, height);
    if (!touch) return {};  // it was cancelled
    if (event.kind == Kind::touch_ended) {
        const Touch ended = *touch;
        std::erase_if(touches_, [&](const Touch& other) { return other.id == ended.id; });
        return end(ended, led.fingers);
    }
    move(*touch, event, led, height);
    if (touch->role != Role::pointer) return {};
    return {pointer_event(Kind::moved, touch->at)};
}

std::vector<InputEvent> TouchInput::begin(const InputEvent& event, Ground ground, PointerFingers* fingers,
                                          int height) {
    if (touches_.size() >= most_touches) return {};
    const glm::dvec2 at(event.x, event.y);
    Touch touch{event.touch, role_on(ground, fingers), at, at, event.seconds};
    if (touch.role == Role::pointer) {
        touches_.push_back(touch);
        return {pointer_event(Kind::moved, at), pointer_event(Kind::pressed, at)};
    }
    // Until it is moved again: X may have told of its pointer before it told of the finger.
    if (fingers) fingers->set_pointer(std::nullopt);
    if (is_pair(touch, height))
        pair_since_s_ = event.seconds;
    else
        pair_since_s_.reset();
    if (touch.role == Role::finger) touch.finger = *fingers->put_down(at);
    touches_.push_back(touch);
    return {};
}

TouchInput::Role TouchInput::role_on(Ground ground, const PointerFingers* fingers) const {
    if (!fingers || ground == Ground::pointers) return count(Role::pointer) == 0 ? Role::pointer : Role::none;
    if (gesture_ || ground == Ground::nothing) return Role::view;
    return fingers->has_free() ? Role::finger : Role::none;
}

/// Whether it and the only other one are put down together.
bool TouchInput::is_pair(const Touch& second, int height) const {
    if (gesture_ || count(Role::finger) + count(Role::view) != 1) return false;
    const auto first = std::find_if(touches_.begin(), touches_.end(), over_picture);
    return second.began_s - first->began_s <= together_s &&
           glm::distance(first->at, first->began) <= moved_share * height;
}

void TouchInput::move(Touch& touch, const InputEvent& event, const Led& led, int height) {
    if (pair_since_s_ && event.seconds - *pair_since_s_ > rest_s) pair_since_s_.reset();
    const glm::dvec2 to(event.x, event.y);
    if (pair_since_s_ && over_picture(touch) && glm::distance(to, touch.began) > moved_share * height)
        begin_gesture(led.fingers);
    const Spread before = spread();
    touch.at = to;
    if (touch.role == Role::finger) led.fingers->move(touch.finger, to);
    if (touch.role != Role::view) return;
    const Spread now = spread();
    const glm::dvec2 moved = (now.middle - before.middle) * (degrees_per_height / height);
    led.view->turn(-moved.x, moved.y);
    const double least = least_radius_share * height;
    if (now.touches > 1 && before.radius > least && now.radius > least)
        led.view->near_by(std::clamp(now.radius / before.radius, 1 / most_nearer, most_nearer));
}

/// What the pair touched until now it lets go of.
void TouchInput::begin_gesture(PointerFingers* fingers) {
    pair_since_s_.reset();
    gesture_ = true;
    for (Touch& touch : touches_) {
        if (touch.role == Role::finger) fingers->lift(touch.finger);
        if (over_picture(touch)) touch.role = Role::view;
    }
}

std::vector<InputEvent> TouchInput::end(const Touch& touch, PointerFingers* fingers) {
    if (touch.role == Role::pointer)
        return {pointer_event(Kind::released, touch.at), pointer_event(Kind::left_window, touch.at)};
    pair_since_s_.reset();
    if (touch.role == Role::finger) fingers->lift(touch.finger);
    if (count(Role::view) == 0) gesture_ = false;
    return {};
}

std::vector<InputEvent> TouchInput::cancel(PointerFingers* fingers) {
    std::vector<InputEvent> events;
    for (const Touch& touch : touches_) {
        if (touch.role == Role::finger) fingers->lift(touch.finger);
        // Away before it is let go, so that it clicks nothing.
        if (touch.role == Role::pointer)
            events = {pointer_event(Kind::left_window, touch.at), pointer_event(Kind::released, touch.at)};
    }
    *this = TouchInput();
    return events;
}

bool TouchInput::any_over_picture(const std::function<bool(const glm::dvec2&)>& is_there) const {
    return std::any_of(touches_.begin(), touches_.end(),
                       [&](const Touch& touch) { return over_picture(touch) && is_there(touch.at); });
}

TouchInput::Spread TouchInput::spread() const {
    Spread spread;
    for (const Touch& touch : touches_) {
        if (touch.role != Role::view) continue;
        spread.middle += touch.at;
        ++spread.touches;
    }
    if (spread.touches == 0) return spread;
    spread.middle /= spread.touches;
    for (const Touch& touch : touches_)
        if (touch.role == Role::view)
            spread.radius += glm::distance(touch.at, spread.middle) / spread.touches;
    return spread;
}

int TouchInput::count(Role role) const {
    return static_cast<int>(std::count_if(touches_.begin(), touches_.end(),
                                          [role](const Touch& touch) { return touch.role == role; }));
}

TouchInput::Touch* TouchInput::find(std::int64_t id) {
    const auto found =
        std::find_if(touches_.begin(), touches_.end(), [id](const Touch& touch) { return touch.id == id; });
    return found == touches_.end() ? nullptr : &*found;
}

}  // namespace touchable
