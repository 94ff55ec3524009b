#include <algorithm>
#include <string>

#include "player/window/window_loop.hpp"

// Several clips, one after the other.

namespace touchable {

/// They, and the clips of a folder, are what there is from now on.
void WindowLoop::open_others(const std::vector<std::string>& named) {
    if (options_.record)
        return say("a recording is of one clip; another can be opened where none is made", Tone::refusal);
    std::vector<ClipChoice> clips;
    for (const std::string& name : named)
        for (const std::filesystem::path& file : clips_of(name)) clips.emplace_back().file = file;
    playlist_ = Playlist(std::move(clips), kiosk_.has_value());
    open_instead(playlist_.now());
}

void WindowLoop::open_instead(const ClipChoice& choice) {
    notices_.clear_passing();
    ready_.reset();
    asked_settings_.reset();  // given up, and asked for again once the clip is there
    ask_for_clip(choice);
}

void WindowLoop::go_in_list(int by) {
    const ClipChoice* const other = by > 0 ? playlist_.next() : playlist_.previous();
    if (other) return open_instead(*other);
    if (playlist_.size() == 1) return say("there is no other clip; drop some on the window");
    say("this is the " + std::string(by > 0 ? "last" : "first") + " of " + std::to_string(playlist_.size()) +
        " clips");
}

/// From a clip's end to the next clip. What is over in a blink rests first; and whoever touches it, paints
/// it, or drags something of the panel is not torn away from it.
void WindowLoop::go_on_in_list(const WatchedMoment* moment) {
    constexpr double blink_s = 1, rest_s = 5, again_s = 1;
    const PlaybackState playback = clip_->session().playback();
    const bool has_ended = playback.at_end && playback.playing && !playback.loops;
    if (!has_ended || playlist_.size() < 2 || opening_.is_busy() || ready_) return;
    if (clip_->seconds() < blink_s && time_s_ < shown_s_ + rest_s) return;
    if (time_s_ < went_on_s_ + again_s) return;  // one that cannot be opened is not tried on and on
    if (brush_.is_held() || measure_.is_held() || layer_->holds_pointer()) return;
    const bool is_touched =
        pointer_.holds() ||
        (moment && clip_->session().running() &&
         std::any_of(moment->felt.fingers.begin(), moment->felt.fingers.end(),
                     [](const WatchedFinger& finger) { return finger.contact.touching; }));
    if (is_touched && !is_inviting_) return;  // which touches by itself
    went_on_s_ = time_s_;
    if (const ClipChoice* const next = playlist_.next()) open_instead(*next);
}

/// Of the first clip, or the first ones: another that can be opened is shown instead, and the program says in
/// the end what went wrong.
Result<void> WindowLoop::go_past(const Error& error) {
    if (playlist_.place() + 1 >= playlist_.size() || error.kind == ErrorKind::interrupted) return error;
    if (!failure_) failure_ = error;
    say(error.message, Tone::fault);
    ask_for_clip(*playlist_.next());
    return {};
}

void WindowLoop::say_place_in_list() {
    if (playlist_.size() > 1)
        say(clip_->name() + ", " + std::to_string(playlist_.place() + 1) + " of " +
            std::to_string(playlist_.size()));
}

}  // namespace touchable
