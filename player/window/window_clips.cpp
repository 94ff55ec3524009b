// Clips, and other settings of one, that come and go: made ready on a thread of their own, while the clip
// that is there goes on. Which of several clips is shown.

#include "player/window/window_loop.hpp"

#include <filesystem>
#include <iostream>
#include <span>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {
namespace {

// From one try to renew a session to the next; many fewer commands come in that time than it still takes.
constexpr std::chrono::seconds renew_pause(20);

/// All but those of the relief, which is made of a clip's colour: of a camera, or where a run is recorded,
/// there is none.
SessionSettings without_relief(const SessionSettings& settings) {
    SessionSettings rest;
    for (const SessionSetting& setting : session_settings())
        if (const auto value = settings.values().find(setting.name);
            value != settings.values().end() && setting.of != SettingOf::relief)
            (void)rest.set(setting.name, value->second);
    return rest;
}

std::string title_of(const std::filesystem::path& file) {
    const std::string name = file.filename().string();
    return name.empty() ? file.string() : name;
}

}  // namespace

/// It may be open already, to know which files may be written; a later opening opens it anew.
void WindowLoop::ask_for_first_clip() {
    if (waits_for_wish()) return;
    const ClipChoice first = options_.session.clip;
    options_.session.clip.shared_clip.reset();
    std::vector<ClipChoice> clips{options_.session.clip};
    clips.insert(clips.end(), options_.next_clips.begin(), options_.next_clips.end());
    // A participant of a study cannot do with another clip.
    ask_for_clip(Playlist(std::move(clips), kiosk_.has_value()), options_.study ? 0 : 1, first);
}

/// Settings that do not go with the clip are not in effect then; they stay kept for another one. Those of the
/// relief are the first to go.
Result<WindowLoop::Ready> WindowLoop::open_clip(ClipChoice choice, const TwoSettings& kept) {
    choice.share_clip();
    auto opened = OpenedClip::open(options_, choice, kept.now(), *sound_);
    if (opened) return Ready{.clip = std::move(*opened), .settings = {kept, kept}};
    const std::string why = opened.error().message;
    TwoSettings tried = kept;
    for (const bool all : {false, true}) {
        TwoSettings in_effect = kept;
        (kept.b_is_on ? *in_effect.b : in_effect.a) = all ? SessionSettings{} : without_relief(kept.now());
        if (in_effect == tried || stop_requested()) continue;
        tried = in_effect;
        opened = OpenedClip::open(options_, choice, in_effect.now(), *sound_);
        if (!opened) continue;
        return Ready{.clip = std::move(*opened),
                     .settings = {kept, in_effect},
                     .remark = (all ? "felt as the clip says: " : "felt without relief: ") + why};
    }
    return opened.error();
}

/// `choice`, which is the list's now; where it cannot be opened, the first that can be of those `by` which
/// the list is gone through, each once; 0: of no other.
Result<WindowLoop::Ready> WindowLoop::open_first(Playlist list, int by, ClipChoice choice,
                                                 const TwoSettings& kept) {
    std::vector<Error> skipped;
    for (std::size_t tries = list.size(); tries > 0; --tries) {
        auto opened = open_clip(std::move(choice), kept);
        if (!opened && (opened.error().kind == ErrorKind::interrupted || stop_requested()))
            return opened.error();
        if (!opened) skipped.push_back(opened.error());
        const ClipChoice* const other = !opened && by != 0 ? list.go(by) : nullptr;
        if (other) {
            choice = *other;
            continue;
        }
        Ready ready = opened ? std::move(*opened) : Ready{};
        ready.list = std::move(list);
        ready.skipped = std::move(skipped);
        return ready;
    }
    return Ready{.skipped = std::move(skipped)};
}

/// As open_first has them. What was being changed is given up, and asked for again once the clip is there.
void WindowLoop::ask_for_clip(const Playlist& list, int by, const ClipChoice& choice) {
    ready_.reset();
    asked_settings_.reset();
    wanted_list_ = list;
    next_is_paused_ = false;
    opening_.ask("opening " + title_of(choice.file), [this, list, by, choice, kept = settings_.kept] {
        return open_first(list, by, choice, kept);
    });
}

/// The first of them, and of the clips in folders among them, that can be opened. A folder may lie on a disk
/// that does not answer.
void WindowLoop::ask_for_named(std::vector<std::string> named) {
    ready_.reset();
    asked_settings_.reset();
    wanted_list_.reset();
    next_is_paused_ = false;
    const std::string words = "opening " + title_of(named.front());
    const auto open = [this, named = std::move(named), kept = settings_.kept,
                       wraps = kiosk_.has_value()]() -> Result<Ready> {
        const auto files = unless_stopped([named, list = options_.clips_of] {
            std::vector<std::filesystem::path> all;
            for (const std::string& name : named)
                for (auto& file : list(name)) all.push_back(std::move(file));
            return all;
        });
        if (!files) return interrupted_error();
        std::vector<ClipChoice> clips;
        for (const auto& file : *files) clips.emplace_back().file = file;
        Playlist list(std::move(clips), wraps);
        const ClipChoice first = list.now();
        return open_first(std::move(list), 1, first, kept);
    };
    opening_.ask(words, open);
}

void WindowLoop::ask_for_change(const WindowSettings& wanted) {
    opening_.ask("changing to " + in_words(wanted), [clip = clip_.get(), wanted]() -> Result<Ready> {
        TRY_ASSIGN(auto change, clip->prepare(wanted.in_effect.now(), wanted.painted));
        return Ready{.clip = nullptr, .change = std::move(change), .settings = wanted};
    });
}

/// One after the other: a key that is held shows each clip that there is time for, and in the end the
/// last. The clip that is there goes on where another one cannot be opened, or it does not go with settings.
Result<void> WindowLoop::go_on_opening() {
    if (auto made = opening_.take()) TRY(take_made(std::move(*made)));
    // What the brush is asked for is done before its clip goes.
    if (ready_ && (ready_->clip ? !brush_.is_changing() : clip_->has_come_to(*ready_->change))) {
        Ready ready = *std::exchange(ready_, std::nullopt);
        const bool is_named = !clip_ && !waits_for_wish();
        if (const auto taken = take(ready); !taken && is_named)
            return taken;
        else
            say(taken);
    }
    if (clip_) go_on_changing();
    return {};
}

/// The program says in the end which of the clips that it was started with cannot be opened. Where none can
/// be, the window closes, or stays empty.
Result<void> WindowLoop::take_made(Result<Ready> made) {
    const bool is_change = asked_settings_.has_value(), is_named = !clip_ && !waits_for_wish();
    if (is_change && !made && wanted_settings_ == asked_settings_) wanted_settings_.reset();  // refused
    asked_settings_.reset();
    if (!made) {
        wanted_list_.reset();
        next_is_paused_.reset();
        if (is_named) return go_on_without_clip(made.error());
        is_change ? say(made.error()) : say(made.error().message, Tone::fault);
        return {};
    }
    std::span<const Error> skipped = made->skipped;
    if (is_named && !skipped.empty() && !failure_) failure_ = skipped.front();
    const bool is_none = !made->clip && !made->change;
    if (is_none) {
        wanted_list_.reset();
        next_is_paused_.reset();
    }
    if (is_none && is_named) {
        tell_skipped(skipped.first(skipped.size() - 1));
        return go_on_without_clip(skipped.back());
    }
    tell_skipped(skipped);
    if (!is_none) ready_ = std::move(*made);
    return {};
}

/// None of the clips that were named can be opened: the window closes, or stays empty.
Result<void> WindowLoop::go_on_without_clip(const Error& why) {
    if (!options_.stays_without_clip || why.kind == ErrorKind::interrupted) return why;
    if (!failure_) failure_ = why;
    std::filesystem::path& file = options_.session.clip.file;
    screen_->set_title(title_of(file) + " cannot be opened - touchable");
    file.clear();
    say(why.message, Tone::fault);
    return {};
}

void WindowLoop::go_on_changing() {
    const bool was_seen = figures_.pictures > changed_at_ || !clip_->session().running();
    // What a participant of a study touches is measured in one piece.
    if (study_ && study_->screen() && study_->screen()->is_touch()) return;
    if (!wanted_settings_ && Clock::now() > renew_after_ && clip_->is_nearly_full() && was_seen && !ready_ &&
        !opening_.is_busy()) {
        renew_after_ = Clock::now() + renew_pause;
        return ask_for_change(settings_);
    }
    if (!wanted_settings_ || !was_seen || ready_ || opening_.is_busy()) return;
    // What is painted and not felt changes nothing.
    if (wanted_settings_->in_effect.now() == clip_->settings() &&
        (wanted_settings_->painted == clip_->painted() || !has_materials(*wanted_settings_))) {
        const WindowSettings before = std::exchange(settings_, *wanted_settings_);
        wanted_settings_.reset();
        return before.in_effect.in_words() == settings_.in_effect.in_words() ? void()
                                                                             : say(in_words(settings_));
    }
    asked_settings_ = wanted_settings_;
    ask_for_change(*wanted_settings_);
}

Result<void> WindowLoop::take(Ready& ready) {
    changed_at_ = figures_.pictures;
    const bool is_another = settings_.in_effect.in_words() != ready.settings.in_effect.in_words();
    settings_ = ready.settings;
    if (ready.clip) {
        TRY(show(ready));
        if (!ready.remark.empty()) say(std::move(ready.remark), Tone::refusal);
        return {};
    }
    if (wanted_settings_ == ready.settings) wanted_settings_.reset();
    const bool had_failed = clip_->failure().has_value();
    const Result<void> changed = clip_->take(std::move(*ready.change));
    lead_force();
    const bool has_failed = !had_failed && note_failure();
    if (!changed) return changed;
    picture_.forget();
    frames_shown_.forget();
    if (is_another && !has_failed) say(in_words(settings_));
    return {};
}

/// In place of the one that is there, if one is.
Result<void> WindowLoop::show(Ready& ready) {
    std::unique_ptr<OpenedClip> clip = std::move(ready.clip);
    const bool is_first = !clip_;
    lift_touches();
    // A visitor goes on as before: what he has chosen is of all clips.
    const bool goes_on = clip_ && kiosk_ && !study_ && kiosk_->was_visited();
    if (goes_on) clip->view().look_as(clip_->view());
    if (clip_) {
        if (auto finished = clip_->finish(); !finished) say(finished);
        note_failure();
        clip->fingers().set_count(clip_->fingers().count());
        // Who has stopped all force has stopped it for every clip.
        clip->device().set_force(clip_->device().force_is_on());
    } else {
        clip->fingers().set_count(settings_file_.read().fingers);
    }
    if (auto begun = clip->begin(); !begun) {
        wanted_list_.reset();  // the clip that is there has ended; a kiosk opens it again
        next_is_paused_.reset();
        return begun;
    }
    // In a kiosk a fault that is over is a row of the log and no exit code.
    if (kiosk_ && !is_first && ready.skipped.empty()) failure_.reset();
    begun_anew_s_ = now_s();
    if (clip_) count_session();
    clip_ = std::move(clip);
    lead_force();
    playlist_ = std::move(ready.list);
    wanted_list_.reset();
    went_on_s_.reset();
    if (is_first) TRY(check_labels());
    clip_->begin_sound();
    notices_.leave_clip();
    picture_.forget();
    if (!goes_on) picture_.set_overlay(Overlay::colour);  // a clip that was just opened is to be seen first
    frames_shown_.forget();
    slow_reading_ = {};
    is_told_of_reading_ = false;
    is_turning_ = is_turning_ && goes_on;
    playback_.emplace(*clip_);
    shown_s_ = time_s_;
    if (kiosk_ && clip_repeats() && !clip_->session().playback().loops && clip_->seconds() >= 0.1)
        say(playback_->toggle_loop());
    if (std::exchange(next_is_paused_, std::nullopt).value_or(false)) say(playback_->pause(true));
    pointer_ = PointerInput();
    screen_->set_title(clip_->name() + " - touchable");
    say_place_in_list();
    tell_guesses();
    if (wanted_settings_) wanted_settings_->painted.reset();
    brush_.go_to(*clip_);
    measure_.let_go();
    return {};
}

/// Whether the clip's session ended as it should not have: the window says so, and in the end the program.
bool WindowLoop::note_failure() {
    if (!clip_->failure()) return false;
    if (!failure_) failure_ = clip_->failure();
    say(clip_->failure()->message, Tone::fault, About::clip);
    return true;
}

/// What else could be true of the clip's camera and unit: the surface would have another size then.
void WindowLoop::tell_guesses() {
    std::string guessed, doubt;
    for (const Remark& remark : clip_->scene().remarks) {
        const bool is_doubt = doubts_unit(remark);
        if (!remark.is_guess && !is_doubt && remark.hints.empty()) continue;
        std::cerr << "touchable: " << options_.names.remark(remark) << '\n';
        if (is_doubt) doubt = remark.what;
        if (!remark.is_guess) continue;
        const bool is_unit = std::any_of(remark.hints.begin(), remark.hints.end(), [](const Hint& hint) {
            return hint.setting == Setting::depth_unit;
        });
        const std::string_view what = guesses_camera(remark) ? "the camera" : is_unit ? "the unit" : "";
        if (guessed.find(what) == std::string::npos)
            guessed += std::string(guessed.empty() ? "" : " and ") + std::string(what);
    }
    if (kiosk_ || (doubt.empty() && guessed.empty())) return;
    say((doubt.empty() ? "guessed: " + guessed : doubt) +
        (clip_->is_camera() ? "; the terminal tells how to say it" : "; touchable info tells how to say it"));
}

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
                     [](const WatchedTick::Finger& finger) { return finger.contact.touching; }));
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

void WindowLoop::feel(const WindowCommand& command) {
    WindowSettings wanted = wanted_settings();
    const std::size_t space = command.word.find(' ');
    const SessionSetting* const setting = session_setting(command.word.substr(0, space));
    if (setting && setting->of == SettingOf::device && !options_.hand)
        return say(setting->name + " is of a device that is held; there is none", Tone::refusal);
    const bool is_of_brush = setting && setting->of == SettingOf::brush;
    if (is_of_brush && !wanted.painted)
        return say("nothing is painted yet; P takes the brush of materials", Tone::refusal);
    const bool to_b = command.word.empty() ? !wanted.in_effect.b_is_on : command.word == "b";
    for (TwoSettings* const settings : {&wanted.kept, &wanted.in_effect}) {
        if (is_of_brush && settings == &wanted.kept) continue;
        if (command.verb == WindowVerb::settings) {
            settings->turn_to(to_b);
        } else if (auto set = settings->set(command.word.substr(0, space), command.word.substr(space + 1));
                   !set) {
            return say(set.error());
        }
    }
    wanted_settings_ = wanted;
}

/// What it says, and what of it is to be felt: by the road of other settings.
void WindowLoop::heed_brush() {
    const WindowBrush::News news = brush_.take_news();
    WindowSettings wanted = wanted_settings();
    for (const auto& [words, tone, is_change] : news.remarks)
        say(words + (is_change && !has_materials(wanted) ? "; B feels it" : ""), tone);
    if (news.has_begun) compare_with_before();
    if (!news.is_another) return;
    wanted = wanted_settings();
    wanted.painted = brush_.felt();
    if (!(wanted == wanted_settings())) wanted_settings_ = std::move(wanted);
}

/// The set of settings that is not in effect becomes that which is, without materials: one key compares.
void WindowLoop::compare_with_before() {
    WindowSettings wanted = wanted_settings();
    TwoSettings& two = wanted.in_effect;
    SessionSettings before = two.now();
    (void)before.set("materials", "off");
    if (two.b_is_on)
        two.a = before;
    else
        two.b = before;
    wanted_settings_ = std::move(wanted);
}

void WindowLoop::reset() {
    WindowSettings anew;
    anew.painted = wanted_settings().painted;
    wanted_settings_ = anew;
    if (anew.painted) compare_with_before();
    panel_->shown = false;
    is_dented_ = KeptSettings().dent;
    clip_->fingers().set_count(KeptSettings().fingers);
    sound_->set_volume(KeptSettings().volume);
    picture_.set_overlay(Overlay::colour);
    measure_.let_go();
    if (!fullscreen_) screen_->set_size(options_.screen.width, options_.screen.height);
}

/// Whether what is painted is felt by the set of settings that is in effect.
bool WindowLoop::has_materials(const WindowSettings& settings) {
    const auto& values = settings.in_effect.now().values();
    const auto materials = values.find("materials");
    return materials == values.end() || materials->second == "on";
}

/// The set of settings that is in effect, for a person.
std::string WindowLoop::in_words(const WindowSettings& settings) {
    if (!settings.painted || !has_materials(settings)) return settings.in_effect.in_words();
    if (settings.in_effect.now() == SessionSettings{})
        return settings.in_effect.b_is_on ? "B: as painted" : "A: as painted";
    return settings.in_effect.in_words() + ", as painted";
}

}  // namespace touchable
