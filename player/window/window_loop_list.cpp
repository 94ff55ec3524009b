#include <algorithm>
#include <span>
#include <string>
#include <utility>

#include "player/window/window_loop.hpp"

// Several clips, one after the other.

namespace touchable {

/// They, and the clips of a folder, are what there is once the first of them is open.
void WindowLoop::open_others(std::vector<std::string> named) {
    if (study_) return say("a study has clips of its own; no other is opened", Tone::refusal);
    if (options_.record)
        return say("a recording is of one clip; another can be opened where none is made", Tone::refusal);
    notices_.clear_passing();
    ask_for_named(std::move(named));
}

/// Of the list's clip; where that cannot be opened, of those `by` which the list is gone through.
void WindowLoop::open_instead(Playlist list, int by) {
    notices_.clear_passing();
    ask_for_clip(list, by, list.now());
}

void WindowLoop::go_in_list(int by) {
    if (!clip_ && !waits_for_wish()) return;  // the first is not open yet
    Playlist list = wanted_list_.value_or(playlist_);
    if (list.go(by)) return open_instead(std::move(list), by);
    if (list.size() < 2) return say("there is no other clip; drop some on the window");
    say("this is the " + std::string(by > 0 ? "last" : "first") + " of " + std::to_string(list.size()) +
        " clips");
}

/// From a clip's end to the next clip. A clip that is over in a blink rests first. The clip also stays while
/// it is touched or painted, or something of the panel is dragged, and for `between_strokes_s` after that.
void WindowLoop::go_on_in_list(const WatchedMoment* moment) {
    constexpr double blink_s = 1, rest_s = 5, again_s = 1, between_strokes_s = 3;
    const bool is_touched =
        pointer_.holds() ||
        (moment && clip_->session().running() &&
         std::any_of(moment->felt.fingers.begin(), moment->felt.fingers.end(),
                     [](const WatchedFinger& finger) { return finger.contact.touching; }));
    if (brush_.is_held() || measure_.is_held() || layer_->holds_pointer() ||
        (is_touched && !is_inviting_))  // which touches by itself
        touched_s_ = time_s_;
    const PlaybackState playback = clip_->session().playback();
    const bool has_ended = playback.at_end && playback.playing && !playback.loops;
    if (!has_ended) return went_on_s_.reset();
    if (study_ || playlist_.size() < 2 || opening_.is_busy() || ready_) return;
    if (clip_->seconds() < blink_s && time_s_ < shown_s_ + rest_s) return;
    // Where no other can be opened, a person is told once, and a kiosk tries on.
    if (went_on_s_ && (!kiosk_ || time_s_ < *went_on_s_ + again_s)) return;
    if (touched_s_ && time_s_ < *touched_s_ + between_strokes_s) return;
    went_on_s_ = time_s_;
    Playlist list = playlist_;
    if (list.next()) open_instead(std::move(list), 1);
}

/// From wherever a visitor has left the list.
void WindowLoop::go_to_first() {
    Playlist list = playlist_;
    list.go_to(0);
    open_instead(std::move(list), 1);
}

/// Of very many it says how many more there are.
void WindowLoop::tell_skipped(std::span<const Error> skipped) {
    const std::size_t told =
        skipped.size() > Notices::most_faults ? Notices::most_faults - 1 : skipped.size();
    for (const Error& error : skipped.first(told)) say(error.message, Tone::fault);
    if (told < skipped.size())
        say(std::to_string(skipped.size() - told) + " more clips cannot be opened", Tone::fault);
}

void WindowLoop::say_place_in_list() {
    if (playlist_.size() > 1)
        say(clip_->name() + ", " + std::to_string(playlist_.place() + 1) + " of " +
            std::to_string(playlist_.size()));
}

}  // namespace touchable
