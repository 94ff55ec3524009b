#include <algorithm>
#include <chrono>
#include <iostream>
#include <utility>

#include "engine/scene/remark.hpp"
#include "player/terminal/interrupt.hpp"
#include "player/window/window_loop.hpp"

// Clips, and other settings of one: made ready on a thread of their own, while the clip that is there goes
// on.

namespace touchable {
namespace {

constexpr double opening_is_quick_s = 0.2;  // nobody needs to be told of it
// From one try to renew a session to the next; many fewer commands come in that time than it still takes.
constexpr std::chrono::seconds renew_pause(20);

/// All but those of the relief, which is made of a clip's colour: of a camera, or where a run is recorded,
/// there is none.
SessionSettings without_relief(const SessionSettings& settings) {
    SessionSettings rest;
    for (const SessionSetting& setting : session_settings())
        if (const auto value = settings.values().find(setting.name);
            value != settings.values().end() && !setting.of_relief)
            (void)rest.set(setting.name, value->second);
    return rest;
}

/// A window in which nothing is to be left before it.
bool closes(const InputEvent& event) {
    if (event.kind == InputEvent::Kind::close) return true;
    if (event.kind != InputEvent::Kind::key) return false;
    const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
    return binding && (binding->verb == WindowVerb::quit || binding->verb == WindowVerb::leave);
}

}  // namespace

/// Settings that do not go with the clip are not in effect then; they stay kept for another one. Those of the
/// relief are the first to go.
void WindowLoop::ask_for_clip(ClipChoice choice) {
    choice.share_clip();
    std::string name = choice.file.filename().string();
    if (name.empty()) name = choice.file.string();
    opening_.ask("opening " + name,
                 [this, choice, kept = settings_.kept](const std::stop_token& given_up) -> Result<Ready> {
                     auto opened = OpenedClip::open(options_, choice, kept.now(), *sound_, given_up);
                     if (opened.ok()) return Ready{.clip = std::move(*opened), .settings = {kept, kept}};
                     const std::string why = opened.error().message;
                     TwoSettings tried = kept;
                     for (const bool all : {false, true}) {
                         TwoSettings in_effect = kept;
                         (kept.b_is_on ? *in_effect.b : in_effect.a) =
                             all ? SessionSettings{} : without_relief(kept.now());
                         if (in_effect == tried || given_up.stop_requested()) continue;
                         tried = in_effect;
                         opened = OpenedClip::open(options_, choice, in_effect.now(), *sound_, given_up);
                         if (!opened.ok()) continue;
                         return Ready{
                             .clip = std::move(*opened),
                             .settings = {kept, in_effect},
                             .remark = (all ? "felt as the clip says: " : "felt without relief: ") + why};
                     }
                     return opened.error();
                 });
}

void WindowLoop::ask_for_change(const WindowSettings& wanted) {
    opening_.ask("changing to " + in_words(wanted),
                 [clip = clip_.get(), wanted](const std::stop_token& given_up) -> Result<Ready> {
                     auto change = clip->prepare(wanted.in_effect.now(), wanted.painted, given_up);
                     if (!change.ok()) return change.error();
                     return Ready{.clip = nullptr, .change = std::move(*change), .settings = wanted};
                 });
}

/// One after the other: whoever holds a key sees and feels each that there is time for, and in the end the
/// last. The clip that is there goes on where another one cannot be opened, or it does not go with settings.
void WindowLoop::go_on_opening() {
    if (auto made = opening_.take()) {
        if (made->ok())
            ready_ = std::move(**made);
        else if (asked_settings_)
            say(made->error());
        else
            say(made->error().message, Tone::fault);
        // Of settings that are refused.
        if (!made->ok() && wanted_settings_ == asked_settings_) wanted_settings_.reset();
        asked_settings_.reset();
    }
    // What the brush is asked for is done before its clip goes.
    if (ready_ && (ready_->clip ? !brush_.is_changing() : clip_->has_come_to(*ready_->change))) {
        Ready ready = *std::exchange(ready_, std::nullopt);
        say(take(ready));
    }
    const bool was_seen = figures_.pictures > changed_at_ || !clip_->session().running();
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
        if (auto shown = show(std::move(ready.clip)); !shown.ok()) return shown;
        if (!ready.remark.empty()) say(std::move(ready.remark), Tone::refusal);
        return {};
    }
    if (wanted_settings_ == ready.settings) wanted_settings_.reset();
    const bool had_failed = clip_->failure().has_value();
    const Result<void> changed = clip_->take(std::move(*ready.change));
    const bool has_failed = !had_failed && note_failure();
    if (!changed.ok()) return changed;
    picture_.forget();
    frames_shown_.forget();
    if (is_another && !has_failed) say(in_words(settings_));
    return {};
}

/// Whether the clip's session ended as it should not have: the window says so, and in the end the program.
bool WindowLoop::note_failure() {
    if (!clip_->failure()) return false;
    if (!failure_) failure_ = clip_->failure();
    say(clip_->failure()->message, Tone::fault);
    return true;
}

/// In place of the one that is there, if one is.
Result<void> WindowLoop::show(std::unique_ptr<OpenedClip> clip) {
    if (clip_) {
        lift_touches();
        if (auto finished = clip_->finish(); !finished.ok()) say(finished);
        note_failure();
        clip->fingers().set_count(clip_->fingers().count());
        // Who has stopped all force has stopped it for every clip.
        clip->device().set_force(clip_->device().force_is_on());
    }
    if (auto begun = clip->begin(); !begun.ok()) return begun;
    if (clip_) count_session();
    clip_ = std::move(clip);
    clip_->begin_sound();
    picture_.forget();
    picture_.set_overlay(Overlay::colour);  // whoever opens a clip wants to see it first
    frames_shown_.forget();
    slow_reading_ = {};
    is_told_of_reading_ = false;
    playback_.emplace(*clip_);
    shown_s_ = time_s_;
    if (kiosk_ && clip_repeats() && !clip_->session().playback().loops && clip_->seconds() >= 0.1)
        say(playback_->toggle_loop());
    pointer_ = PointerInput();
    screen_->set_title(clip_->name() + " - touchable");
    say_place_in_list();
    tell_guesses();
    if (wanted_settings_) wanted_settings_->painted.reset();
    brush_.go_to(*clip_);
    measure_.let_go();
    return {};
}

/// What nobody said of the clip: one who touches it is to know that its size may be another.
void WindowLoop::tell_guesses() {
    bool any = false;
    for (const Remark& remark : clip_->scene().remarks) {
        if (!remark.is_guess) continue;
        any = true;
        std::cerr << "touchable: " << options_.names.remark(remark) << '\n';
    }
    if (any && !kiosk_)
        say(clip_->is_camera()
                ? "what nobody said of the camera is guessed; the terminal tells what and how to say it"
                : "camera and unit are guessed: touchable info tells how to say them");
}

/// The first one. Whoever closes the window meanwhile has closed it.
Result<void> WindowLoop::wait_for_clip() {
    screen_->set_title(opening_.words() + " ... - touchable");
    if (auto drawn = draw_opening(); !drawn.ok()) return drawn;
    while (!clip_ && !quit_ && !interrupted()) {
        bool is_resized = false;
        for (const InputEvent& event : screen_->poll(std::chrono::milliseconds(2)))
            if (event.kind == InputEvent::Kind::resized)
                is_resized = true;
            else if (kiosk_ && !is_for_visitors(event))
                continue;
            else if (closes(event))
                quit_ = true;
        if (auto there = screen_->health(); !there.ok()) return there;
        if (is_resized)
            if (auto drawn = draw_opening(); !drawn.ok()) return drawn;
        auto made = opening_.take();
        if (!made) continue;
        if (!made->ok()) {
            if (auto next = go_past(made->error()); !next.ok()) return next;
            continue;
        }
        if (auto taken = take(**made); !taken.ok()) return taken;
    }
    return {};
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

std::string WindowLoop::words_of_opening() const {
    return opening_.seconds() > opening_is_quick_s ? opening_.words() + " ..." : std::string();
}

}  // namespace touchable
