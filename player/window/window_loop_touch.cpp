#include <chrono>
#include <utility>

#include "player/draw/surface_pick.hpp"
#include "player/window/touch_screens.hpp"
#include "player/window/window_loop.hpp"

// Fingers on a touch screen.

namespace touchable {

/// What a finger that comes down there is for. A brush, a measure and the panel take it for the pointer.
TouchInput::Ground WindowLoop::ground_at(double x, double y) {
    using Ground = TouchInput::Ground;
    if (!clip_ || brush_.is_held() || measure_.is_held() || panel_->covers(x, y)) return Ground::pointers;
    const WatchedMoment* const moment = clip_->session().look();
    if (options_.hand || is_turning_ || !moment) return Ground::nothing;
    const ScreenSize size = screen_->size();
    const HeightField field(clip_->scene(), moment->held.pair);
    const auto met = pick(field, clip_->view().camera(size.width, size.height), x, y);
    return met && met->drawn && met->from_front ? Ground::surface : Ground::nothing;
}

void WindowLoop::take_of_touch(const InputEvent& event) {
    const ScreenSize size = screen_->size();
    was_touched_ = true;
    const bool begins = event.kind == InputEvent::Kind::touch_began;
    const auto ground = begins ? ground_at(event.x, event.y) : TouchInput::Ground::nothing;
    const auto led = clip_ ? TouchInput::Led{&clip_->fingers(), &clip_->view()} : TouchInput::Led{};
    for (const InputEvent& done : touches_.take(event, ground, led, size.width, size.height)) {
        events_.push_back(done);
        take_of_pointer(done);
    }
}

/// Whatever they do: the window is looked at no more, or the clip goes.
void WindowLoop::lift_touches() {
    for (const InputEvent& done : touches_.cancel(clip_ ? &clip_->fingers() : nullptr)) {
        events_.push_back(done);
        take_of_pointer(done);
    }
}

/// As far as is known.
bool WindowLoop::has_touch_screen() const {
    static const bool is_there = touchable::has_touch_screen();
    return was_touched_ || (is_there && !options_.headless);
}

/// Of a machine that was suspended nobody knows who still presses: fingers and buttons that were down are
/// lifted, and the force of one that comes down again begins at zero.
void WindowLoop::lift_after_sleep() {
    constexpr std::chrono::milliseconds noticed(100);
    const Clock::duration slept = Clock::slept();
    if (slept - std::exchange(slept_, slept) > noticed)
        take(InputEvent{.kind = InputEvent::Kind::left_window});
}

}  // namespace touchable
