#include "player/window/kiosk.hpp"

#include <cmath>
#include <numbers>
#include <utility>

#include "player/window/window_command.hpp"

namespace touchable {

std::optional<double> KioskWatch::invites(double now_s) const {
    const double since = now_s - last_s_ - times_.invite_s;
    return since >= 0 ? std::optional(since) : std::nullopt;
}

bool KioskWatch::begins_anew(double now_s) {
    if (!was_visited_ || now_s - last_s_ < times_.reset_s) return false;
    was_visited_ = false;
    return true;
}

std::optional<KioskWatch::Visit> KioskWatch::ended(double now_s) {
    return now_s - last_s_ < times_.invite_s ? std::nullopt : end();
}

std::optional<KioskWatch::Visit> KioskWatch::end() {
    if (!std::exchange(is_there_, false)) return std::nullopt;
    return Visit{began_s_, last_s_ - began_s_};
}

namespace {

bool is_for_visitors(WindowVerb verb) {
    switch (verb) {
        case WindowVerb::play_pause:
        case WindowVerb::seek_by:
        case WindowVerb::step:
        case WindowVerb::faster:
        case WindowVerb::fingers:
        case WindowVerb::deeper:
        case WindowVerb::point_right:
        case WindowVerb::point_down:
        case WindowVerb::force:
        case WindowVerb::clutch:
        case WindowVerb::recentre:
        case WindowVerb::mute:
        case WindowVerb::overlay:
        case WindowVerb::home:
        case WindowVerb::turn:
        case WindowVerb::tilt:
        case WindowVerb::nearer:
            return true;
        default:
            return false;
    }
}

}  // namespace

bool is_for_visitors(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    if (event.kind == Kind::close || event.kind == Kind::dropped) return false;
    if (event.kind != Kind::key) return true;
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    return !binding || is_for_visitors(binding->verb);
}

bool is_a_visit(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    return event.kind == Kind::moved || event.kind == Kind::pressed || event.kind == Kind::wheel ||
           event.kind == Kind::key || event.kind == Kind::touch_began || event.kind == Kind::touch_moved;
}

ShownStroke stroke_at(double seconds) {
    constexpr double round_s = 9, stroke_s = 4.5, down_s = 0.7, up_s = 3.9;
    const double angle = 2 * std::numbers::pi * seconds / round_s;
    const double within = std::fmod(seconds, stroke_s);
    return {{0.17 * std::sin(angle), 0.12 * std::sin(2 * angle)}, within > down_s && within < up_s};
}

}  // namespace touchable
