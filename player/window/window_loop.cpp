#include "player/window/window_loop.hpp"

#include <malloc.h>

#include <algorithm>
#include <ctime>
#include <iostream>
#include <optional>
#include <utility>

#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "player/run/interrupt.hpp"
#include "player/window/words_scale.hpp"

namespace touchable {

Result<void> WindowLoop::open() {
    last_picture_ = asked_for_;
    if (options_.kiosk)
        if (auto opened = open_kiosk(); !opened.ok()) return opened;
    if (options_.settings_file) settings_file_ = SettingsFile(*options_.settings_file);
    const KeptSettings& kept = settings_file_.read();
    if (!options_.filters_are_stated) settings_.kept = {kept.a, kept.b};
    if (!settings_file_.message().empty()) say(settings_file_.message(), Tone::fault);
    TRY_ASSIGN(auto sound, WindowSound::create(!options_.headless, options_.sound, options_.existing,
                                               options_.names.sound));
    sound_ = std::move(sound);
    sound_->set_volume(kept.volume);
    if (options_.kiosk) sound_->set_spoken(options_.kiosk->label_sounds);
    if (options_.rumble && !options_.headless) sound_->begin_rumble();
    if (auto opened = open_screen(kept); !opened.ok()) return opened;
    ask_for_first_clip();
    if (auto opened = open_parts(); !opened.ok()) return opened;
    panel_->shown = kept.panel;
    is_dented_ = options_.dent.value_or(kept.dent);
    screen_->set_title(waits_for_wish() ? "touchable" : opening_.words() + " ... - touchable");
    return draw_opening();
}

/// It may be open already, to know which files may be written; whoever opens it later opens it anew.
void WindowLoop::ask_for_first_clip() {
    if (waits_for_wish()) return;
    const ClipChoice first = options_.session.clip;
    options_.session.clip.shared_clip.reset();
    std::vector<ClipChoice> clips{options_.session.clip};
    clips.insert(clips.end(), options_.next_clips.begin(), options_.next_clips.end());
    // A participant of a study cannot do with another clip.
    ask_for_clip(Playlist(std::move(clips), kiosk_.has_value()), options_.study ? 0 : 1, first);
}

Result<void> WindowLoop::open_screen(const KeptSettings& kept) {
    ScreenOptions wanted = options_.screen;
    if (!options_.size_is_stated && kept.width > 0) {
        wanted.width = kept.width;
        wanted.height = kept.height;
    }
    fullscreen_ = wanted.fullscreen;
    wanted.at_once = [this](InputEvent& event) { stop_force_at_once(event); };
    if (options_.make_screen) {
        screen_ = options_.make_screen(wanted);
    } else if (options_.headless) {
        screen_ = make_headless_screen(wanted);
    } else {
        TRY_ASSIGN(auto screen, open_glfw_screen(wanted));
        screen_ = std::move(screen);
    }
    if (!options_.gpu)
        options_.gpu = std::make_shared<RunGpu>(options_.session.builder.gpu, screen_->extensions());
    // One for the surface and its picture: what is built on it is drawn where it lies.
    options_.session.gpu = options_.gpu;
    return {};
}

double WindowLoop::scale_of_words(const ScreenSize& size) const {
    return options_.scale.value_or(words_scale(size, kiosk_.has_value()));
}

/// In a window that has another size by now.
Result<void> WindowLoop::fit_words(const ScreenSize& size) {
    const double scale = scale_of_words(size);
    if (scale == layer_->scale()) return {};
    layer_->set_scale(scale);
    panel_->set_scale(scale);
    return picture_.graphics().take_letters();
}

/// What draws.
Result<void> WindowLoop::open_parts() {
    const double scale = scale_of_words(screen_->size());
    layer_.emplace(scale, kiosk_letters(), options_.kiosk ? options_.kiosk->texts.language : "");
    tell_of_letters();
    if (auto opened = open_graphics(); !opened.ok()) return opened;
    panel_.emplace(scale);
    if (!options_.video) return {};
    TRY_ASSIGN(auto film, WindowFilm::create(*options_.video, options_.existing));
    film_ = std::move(film);
    return {};
}

Result<PlayFigures> WindowLoop::run() {
    Result<void> ended = open();
    while (ended.ok() && !interrupted() && (!quit_ || has_to_stay())) ended = turn();
    return end(std::move(ended));
}

/// Draws where something is to be seen, takes what has come, and does it.
Result<void> WindowLoop::turn() {
    const WatchedMoment* const moment = clip_ ? clip_->session().look() : nullptr;
    if (clip_) say(playback_->go_on(moment));
    watch(moment, Clock::now());
    if (clip_ && options_.hand) look_after_hand(moment);
    if (is_due(moment, Clock::now()))
        if (auto drawn = draw_what_is_there(moment); !drawn.ok())
            if (auto opened = open_graphics_anew(drawn.error()); !opened.ok()) return opened;
    if (auto there = screen_->health(); !there.ok()) return there;
    const double left_ms = pause_ms() - 1000 * seconds_between(last_picture_, Clock::now());
    // Until another frame is seen, or the first clip is open.
    const int longest_ms = (clip_ ? clip_->session().playback().playing : opening_.is_busy()) ? 2 : 8;
    const auto wait = std::chrono::milliseconds(std::clamp(static_cast<int>(left_ms), 1, longest_ms));
    const std::vector<InputEvent> events = screen_->poll(wait);
    time_s_ = script_clock_.at(now_s(), is_at_work());
    lift_after_sleep();
    for (const InputEvent& event : events) take(event);
    if (begun_ && !quit_) take_script();
    // Until the clip that was asked for first is open, or cannot be, what is dropped waits.
    if (!dropped_.empty() && (clip_ || waits_for_wish())) open_others(std::exchange(dropped_, {}));
    if (kiosk_ && clip_ && begun_) watch_over();
    for (const WindowCommand& command : std::exchange(asked_, {})) take(command);
    if (clip_) go_on_with_clip();
    if (auto opened = go_on_opening(); !opened.ok()) return opened;
    note_files();
    note_screenshots();
    if (options_.seconds && time_s_ >= *options_.seconds) quit_ = true;
    return {};
}

void WindowLoop::go_on_with_clip() {
    if (study_ && begun_) go_on_in_study();
    go_on_in_list(clip_->session().look());
    panel_->bar_shown = bar_is_wanted();
    const bool is_finger = !options_.hand && clip_->shown() > 0 && clip_->force_is_on() &&
                           !brush_.is_held() && !measure_.is_held() && !is_turning_;
    screen_->hide_pointer((is_finger && !panel_->covers(pointer_at_.x, pointer_at_.y)) ||
                          (options_.hand && !panel_->bar_shown));
    brush_.go_on(screen_->size());
    heed_brush();
    note_sound();
    note_slow_reading();
    if (!clip_->session().running() && !begun_) quit_ = true;  // there will be no picture
}

/// Once for each clip.
void WindowLoop::note_sound() {
    const std::string fault = sound_->clip_fault();
    if (fault == std::exchange(sound_fault_, fault) || fault.empty()) return;
    if (figures_.sound_fault.empty()) figures_.sound_fault = fault;
    say(fault, Tone::fault, About::clip);
}

/// Pictures that other programs packed take their time: once for each clip, and what helps.
void WindowLoop::note_slow_reading() {
    const Scene& scene = clip_->scene();
    if (!scene.folder || clip_->is_still() || is_told_of_reading_) return;
    const double period_ms = 1000 / scene.rate.per_second();
    slow_reading_.add(clip_->figures(), period_ms);
    if (!slow_reading_.is_why()) return;
    is_told_of_reading_ = true;
    const std::string help = options_.names.faster(clip_->choice().file.string());
    std::string words = "frames come late: reading the pictures of one takes " +
                        short_number(slow_reading_.read_ms(), 3) + " ms, and it is shown for " +
                        short_number(period_ms, 3) + " ms" + (help.empty() ? "" : "; " + help);
    if (figures_.slow_reading.empty()) figures_.slow_reading = words;
    say(std::move(words));
}

void WindowLoop::note_screenshots() {
    for (const auto& written : screenshots_.take())
        written.ok() ? say("kept as " + std::filesystem::absolute(*written).string())
                     : say(written.error().message, Tone::fault);
}

/// What is to be kept and no longer can be: once, as it happens.
void WindowLoop::note_files() {
    for (const auto& fault :
         {clip_ ? clip_->record_fault() : std::nullopt, sound_->file_fault(),
          film_ ? film_->fault() : std::nullopt, use_log_ ? use_log_->missing() : std::nullopt,
          study_ ? study_->fault() : std::nullopt})
        if (fault && file_faults_.insert(fault->message).second) say(fault->message, Tone::fault);
}

double WindowLoop::now_s() const {
    return begun_ ? seconds_between(*begun_, Clock::now()) : 0;
}

double WindowLoop::thread_cpu_ms() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
}

namespace {

bool drops(const ScriptedInput& input) {
    const auto* const event = std::get_if<InputEvent>(&input.what);
    return event && event->kind == InputEvent::Kind::dropped;
}

}  // namespace

/// What is done before anything that comes after it: what a brush was asked for, and a study's results begun.
bool WindowLoop::is_at_work() const {
    return brush_.is_at_work() || (study_ && study_->is_beginning());
}

void WindowLoop::take_script() {
    // A first clip is opened before.
    const double until_s = time_s_;
    const auto is_next = [this](double by_s) {
        return scripted_ < options_.script.size() && options_.script[scripted_].seconds <= by_s;
    };
    while (is_next(until_s) && !is_at_work() && (clip_ || !opening_.is_busy())) {
        const auto& [at_s, what] = options_.script[scripted_++];
        time_s_ = at_s;
        if (const auto* event = std::get_if<InputEvent>(&what))
            take(*event);
        else
            take(std::get<WindowCommand>(what));
        // What is dropped at one moment is one drop.
        if (!dropped_.empty() && !(is_next(at_s) && drops(options_.script[scripted_])))
            open_others(std::exchange(dropped_, {}));
    }
    time_s_ = until_s;
}

void WindowLoop::take(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    const bool is_of_study = study_ && clip_ && event.kind == Kind::key;
    if (kiosk_ && !is_for_visitors(event) && !is_of_study) return;
    if (kiosk_ && clip_ && is_a_visit(event)) welcome(event);
    if (study_ && clip_ && take_of_study(event)) return;
    if (is_a_visit(event)) stirred_s_ = time_s_;
    last_event_ = Clock::now();
    if (!first_event_) first_event_ = last_event_;
    if (is_touch(event)) return take_of_touch(event);
    if (event.kind == Kind::left_window) lift_touches();
    events_.push_back(event);
    if (event.kind == Kind::close) {
        leaves_at_once_ = quit_;
        quit_ = true;
    }
    if (event.kind == Kind::dropped) dropped_.push_back(event.word);
    if (event.kind == Kind::key) {
        const KeyBinding* const binding = binding_of(event.word, event.control, event.shift);
        if (binding && (!event.repeated || goes_by_steps(binding->verb)))
            take(WindowCommand{binding->verb, event.stopped_force ? -1 : binding->number, ""});
        return;
    }
    if (event.kind == Kind::key_released) {
        for (const KeyBinding& binding : key_bindings())
            if (event.word == binding.key && binding.verb == WindowVerb::clutch)
                take(WindowCommand{WindowVerb::clutch, 0});
        return;
    }
    take_of_pointer(event);
}

void WindowLoop::take_of_pointer(const InputEvent& event) {
    using Kind = InputEvent::Kind;
    if (event.kind == Kind::moved) pointer_at_ = {event.x, event.y};
    if (event.kind == Kind::moved || event.kind == Kind::left_window)
        pointer_is_there_ = event.kind == Kind::moved;
    const bool is_over = !pointer_.holds() && panel_->covers(pointer_at_.x, pointer_at_.y);
    const bool is_of_panel = layer_->holds_pointer() || is_over;
    // A finger under the bar is felt, though the bar has the clicks; not in a kiosk, where some never knew
    // that a finger is there.
    const bool leaves =
        layer_->holds_pointer() || (is_over && (kiosk_ || !panel_->is_bar(pointer_at_.x, pointer_at_.y)));
    if (clip_ && leaves && (event.kind == Kind::moved || event.kind == Kind::pressed))
        pointer_.leave(clip_->fingers());
    const ScreenSize size = screen_->size();
    if (!is_of_panel && measure_.take(event, pointer_at_)) return;
    if (clip_ && brush_.take(event, pointer_at_, is_of_panel, size)) return;
    if (clicks_for_full_screen(event, is_of_panel)) return turn_full_screen();
    if (!clip_) return;
    const auto lead = options_.hand || is_turning_ ? &PointerInput::take_for_view : &PointerInput::take;
    // A clip that has just come knows of no pointer yet.
    if (event.kind == Kind::pressed && pointer_is_there_ && !is_of_panel)
        (pointer_.*lead)({.kind = Kind::moved, .x = pointer_at_.x, .y = pointer_at_.y}, clip_->fingers(),
                         clip_->view(), size.width, size.height);
    const bool ends = event.kind == Kind::released || event.kind == Kind::left_window;
    if (!is_of_panel || ends || (event.kind == Kind::moved && !leaves))
        (pointer_.*lead)(event, clip_->fingers(), clip_->view(), size.width, size.height);
}

void WindowLoop::say(const Result<void>& done) {
    if (!done.ok()) say(done.error());
}

void WindowLoop::say(const Error& error) {
    say(error.message, error.kind == ErrorKind::usage ? Tone::refusal : Tone::fault);
}

/// Who sees no window, or is no visitor, learns what went wrong all the same.
void WindowLoop::tell(const std::string& fault) {
    constexpr std::size_t most_told = 100;
    const bool is_told = kiosk_ && (told_.size() == most_told || !told_.insert(fault).second);
    if ((options_.headless || kiosk_) && !is_told)
        std::cerr << "touchable: warning: " << printable(fault, 500) << '\n';
}

void WindowLoop::say(std::string words, Tone tone, About about) {
    if (tone == Tone::fault) log_fault(words);
    if (tone != Tone::remark) tell(words);
    notices_.say(std::move(words), tone, time_s_, about);
    last_event_ = Clock::now();
}

namespace {

/// Each clip that is opened is read, built and drawn by threads of its own, and by default malloc has eight
/// places for each core, of which every thread takes another one. What one has freed no other uses, so that
/// memory would grow with every clip. The haptic thread has no need of any.
void share_memory_among_threads() {
#ifdef __GLIBC__
    mallopt(M_ARENA_MAX, 2);
#endif
}

}  // namespace

Result<PlayFigures> play_in_window(PlayOptions options) {
    share_memory_among_threads();
    WindowLoop window(std::move(options));
    return window.run();
}

}  // namespace touchable
