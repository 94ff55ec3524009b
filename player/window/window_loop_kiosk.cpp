#include <algorithm>
#include <glm/common.hpp>

#include "player/view/surface_pick.hpp"
#include "player/window/window_loop.hpp"

// A window that nobody watches over.

namespace touchable {

/// Invites when nobody has been there for a while, and forgets what the last visitor did.
void WindowLoop::watch_over() {
    const double now = now_s();
    if (kiosk_->begins_anew(now)) begin_anew();
    const auto invited = kiosk_->invites(now);
    sound_->silence_fingers(invited.has_value());  // nobody is there to hear what shows how
    if (!invited && is_inviting_) pointer_.leave(clip_->fingers());
    is_inviting_ = invited.has_value();
    // A clip that did not say how long it is could not be told to loop.
    const bool ended = clip_->frames() == 0 && clip_->session().playback().at_end;
    if (ended && now > begun_anew_s_ + 1) begin_anew();
}

/// A finger that goes by itself over the picture, and really touches it: nearer to the middle where there is
/// nothing to touch farther out.
void WindowLoop::show_how(const HeightField& field, const ViewCamera& camera) {
    constexpr double goes_nearer = 0.03;  // a picture, of its way
    const ShownStroke stroke = stroke_at(kiosk_->invites(now_s()).value_or(0));
    const glm::dvec2 size(camera.width, camera.height);
    const auto middle = camera.project(clip_->view().middle());
    // The words are below.
    const glm::dvec2 from = glm::clamp(middle ? glm::dvec2(*middle) : size / 2.0, 0.3 * size, 0.5 * size);
    const auto place = [&](double share) { return from + stroke.off * size * share; };
    double share = 1;
    for (const double tried : {1.0, 0.75, 0.5, 0.25, 0.0}) {
        const auto met = pick(field, camera, place(tried).x, place(tried).y);
        if (!met || !met->drawn) continue;
        share = tried;
        break;
    }
    shown_share_ += std::clamp(share - shown_share_, -goes_nearer, goes_nearer);
    clip_->fingers().set_pointer(place(shown_share_));
    clip_->fingers().press(stroke.pressed);
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
    sound_->set_muted(false);
    say(playback_->begin_anew(options_.session.playback, true));
}

}  // namespace touchable
