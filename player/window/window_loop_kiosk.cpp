#include <utility>

#include "player/window/window_loop.hpp"

// A window that nobody watches over.

namespace touchable {

/// Invites when nobody has been there for a while, and forgets what the last visitor did.
void WindowLoop::watch_over() {
    const double now = now_s();
    if (kiosk_->begins_anew(now)) begin_anew();
    const auto invited = kiosk_->invites(now);
    if (invited && !is_inviting_) {
        was_muted_ = sound_->is_muted();
        sound_->set_muted(true);  // nobody is there to hear it
    } else if (!invited && is_inviting_) {
        sound_->set_muted(was_muted_);
    }
    if (invited || is_inviting_) show_how(invited);
    is_inviting_ = invited.has_value();
    // A clip that did not say how long it is could not be told to loop.
    const bool ended = clip_->frames() == 0 && clip_->session().playback().at_end;
    if (ended && now > begun_anew_s_ + 1) begin_anew();
}

/// A finger that goes by itself over the picture, and really touches it.
void WindowLoop::show_how(std::optional<double> invited) {
    PointerFingers& fingers = clip_->fingers();
    if (!invited) return pointer_.leave(fingers);
    const ScreenSize size = screen_->size();
    const ShownStroke stroke = stroke_at(*invited);
    fingers.set_pointer(stroke.at * glm::dvec2(size.width, size.height));
    fingers.press(stroke.pressed);
    screen_->hide_pointer(true);
}

/// As it was at the start.
void WindowLoop::begin_anew() {
    begun_anew_s_ = now_s();
    clip_->view().go_home();
    clip_->fingers().set_count(KeptSettings().fingers);
    clip_->fingers().lift();
    clip_->device().set_force(true);
    picture_->set_overlay(Overlay::colour);
    was_muted_ = false;
    if (!is_inviting_) sound_->set_muted(false);
    say(playback_->begin_anew(options_.session.playback, true));
}

}  // namespace touchable
