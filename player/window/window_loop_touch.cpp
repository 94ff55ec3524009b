#include "player/view/surface_pick.hpp"
#include "player/window/window_loop.hpp"

// Fingers on a touch screen.

namespace touchable {

/// What a finger that comes down there is for. A brush, a measure and the panel take it for the pointer.
TouchInput::Ground WindowLoop::ground_at(double x, double y) {
    using Ground = TouchInput::Ground;
    if (brush_.is_held() || measure_.is_held() || panel_->covers(x, y)) return Ground::pointers;
    const WatchedMoment* const moment = clip_->session().look();
    if (options_.hand || is_turning_ || !moment) return Ground::nothing;
    const ScreenSize size = screen_->size();
    const HeightField field(clip_->scene(), moment->held.pair);
    const auto met = pick(field, clip_->view().camera(size.width, size.height), x, y);
    return met && met->drawn && met->from_front ? Ground::surface : Ground::nothing;
}

void WindowLoop::take_of_touch(const InputEvent& event) {
    const ScreenSize size = screen_->size();
    const bool begins = event.kind == InputEvent::Kind::touch_began;
    const auto ground = begins ? ground_at(event.x, event.y) : TouchInput::Ground::nothing;
    for (const InputEvent& done :
         touches_.take(event, ground, clip_->fingers(), clip_->view(), size.width, size.height)) {
        events_.push_back(done);
        take_of_pointer(done);
    }
}

/// Whatever they do: the window is looked at no more, or the clip goes.
void WindowLoop::lift_touches() {
    for (const InputEvent& done : touches_.cancel(clip_->fingers())) {
        events_.push_back(done);
        take_of_pointer(done);
    }
}

}  // namespace touchable
