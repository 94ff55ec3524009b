#include "player/window/playlist_mode.hpp"

#include "player/window/window_core.hpp"

namespace touchable {

void PlaylistMode::go(int by) {
    if (!core_.clip() && !core_.clips().waits_for_wish()) return;  // the first is not open yet
    Playlist list = core_.clips().wanted_list();
    if (list.go(by)) return core_.clips().open_instead(std::move(list), by);
    if (list.size() < 2) return core_.say("there is no other clip; drop some on the window");
    core_.say("this is the " + std::string(by > 0 ? "last" : "first") + " of " + std::to_string(list.size()) +
              " clips");
}

/// By a person.
bool PlaylistMode::is_touched() const {
    if (core_.any_button(LeftButton::is_a_tool) || core_.picture().holds_pointer()) return true;
    if (core_.any(&WindowMode::moves_by_itself)) return false;
    WatchedSession& session = core_.clip()->session();
    const WatchedMoment* const moment = session.look();
    return core_.input().holds_pointer() ||
           (moment && session.running() &&
            std::ranges::any_of(moment->felt.fingers,
                                [](const WatchedTick::Finger& finger) { return finger.contact.touching; }));
}

void PlaylistMode::go_on(double) {
    constexpr double blink_s = 1, rest_s = 5, again_s = 1, between_strokes_s = 3;
    const double now_s = core_.time.script_s;
    if (is_touched()) touched_s_ = now_s;
    const OpenedClip& clip = *core_.clip();
    const PlaybackState playback = clip.session().playback();
    const bool has_ended = playback.at_end && playback.playing && !playback.loops;
    if (!has_ended) return went_on_s_.reset();
    if (core_.any(&WindowMode::chooses_clip) || list_.size() < 2 || core_.clips().is_busy()) return;
    if (clip.seconds() < blink_s && now_s < shown_s_ + rest_s) return;
    // Where no other can be opened, this is said once, but an unattended window tries on.
    if (went_on_s_ && (!core_.is_unattended() || now_s < *went_on_s_ + again_s)) return;
    if (touched_s_ && now_s < *touched_s_ + between_strokes_s) return;
    went_on_s_ = now_s;
    Playlist list = list_;
    if (list.next()) core_.clips().open_instead(std::move(list), 1);
}

void PlaylistMode::begin_clip(bool) {
    went_on_s_.reset();
    shown_s_ = core_.time.script_s;
    if (list_.size() > 1)
        core_.say(core_.clip()->name() + ", " + std::to_string(list_.place() + 1) + " of " +
                  std::to_string(list_.size()));
}

}  // namespace touchable
