// The window: what it opens, its turns, what it says, and how it ends.

#include "player/window/window_loop.hpp"

#include <malloc.h>

#include <cstdio>
#include <ctime>
#include <iostream>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"

namespace touchable {
namespace {

bool drops(const ScriptedInput& input) {
    const auto* const event = std::get_if<InputEvent>(&input.what);
    return event && event->kind == InputEvent::Kind::dropped;
}

/// On the terminal.
void warn(const std::string& words) {
    std::cerr << "touchable: warning: " << printable(words, 500) << '\n';
}

/// Each clip that is opened is read, built and drawn by threads of its own, and by default malloc has eight
/// places for each core, of which every thread takes another one. What one has freed no other uses, so that
/// memory would grow with every clip. The haptic thread has no need of any.
void share_memory_among_threads() {
#ifdef __GLIBC__
    mallopt(M_ARENA_MAX, 2);
#endif
}

}  // namespace

double words_scale(const ScreenSize& size, bool from_afar) {
    constexpr double most = 4;
    const double room = std::min(size.width / 1280.0, size.height / 720.0) / size.scale;
    const double grown = std::round(4 * (from_afar ? room : std::sqrt(room))) / 4;
    return std::max(std::min(size.scale * grown, most), size.scale);
}

Result<void> WindowLoop::open() {
    last_picture_ = asked_for_;
    if (options_.kiosk) TRY(open_kiosk());
    if (options_.settings_file) settings_file_ = SettingsFile(*options_.settings_file);
    const KeptSettings& kept = settings_file_.read();
    if (!options_.filters_are_stated) settings_.kept = {kept.a, kept.b};
    if (!settings_file_.message().empty()) say(settings_file_.message(), Tone::fault);
    TRY_ASSIGN(sound_, WindowSound::create(!options_.headless, options_.sound, options_.existing,
                                           options_.names.sound));
    sound_->set_volume(kept.volume);
    if (options_.kiosk) sound_->set_spoken(options_.kiosk->label_sounds);
    if (options_.rumble && !options_.headless) sound_->begin_rumble();
    TRY(open_screen(kept));
    ask_for_first_clip();
    TRY(open_parts());
    panel_->shown = kept.panel;
    is_dented_ = options_.dent.value_or(kept.dent);
    screen_->set_title(waits_for_wish() ? "touchable" : opening_.words() + " ... - touchable");
    return draw_opening();
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
        TRY_ASSIGN(screen_, open_glfw_screen(wanted));
    }
    if (!options_.gpu)
        options_.gpu = std::make_shared<RunGpu>(options_.session.builder.gpu, screen_->extensions());
    // One for the surface and its picture: what is built on it is drawn where it lies.
    options_.session.gpu = options_.gpu;
    return {};
}

/// What draws.
Result<void> WindowLoop::open_parts() {
    const double scale = scale_of_words(screen_->size());
    layer_.emplace(scale, kiosk_letters(), options_.kiosk ? options_.kiosk->texts.language : "");
    tell_of_letters();
    TRY(open_graphics());
    panel_.emplace(scale);
    if (!options_.video) return {};
    TRY_ASSIGN(film_, WindowFilm::create(*options_.video, options_.existing));
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

/// A headless window needs no GPU, unless an option names one.
Result<std::unique_ptr<WindowGraphics>> WindowLoop::make_graphics() {
    if (options_.headless && options_.painter == "cpu") return make_cpu_graphics();
    auto device = options_.gpu->open();
    const bool is_asked_for = options_.painter != "auto" || options_.session.builder.names_gpu();
    if (!device && options_.headless && (!is_asked_for || lost_at_)) return make_cpu_graphics();
    if (!device) return device.error();
    TRY(screen_->attach(*device));
    return make_gpu_graphics(std::move(*device), options_.painter, *screen_);
}

Result<void> WindowLoop::open_graphics() {
    TRY_ASSIGN(auto graphics, make_graphics());
    figures_.painter = graphics->painter();
    figures_.gpu = graphics->gpu();
    governor_ = PictureGovernor(graphics->thins_vertices() ? LessOf::vertices : LessOf::pixels);
    picture_.use(std::move(graphics));
    return {};
}

/// After an error of drawing: once, where the GPU was lost. The hand goes on meanwhile.
Result<void> WindowLoop::open_graphics_anew(const Error& error) {
    constexpr std::chrono::seconds soon(10);  // a GPU that is lost again so soon will be lost again
    TRY(screen_->health());
    const auto now = Clock::now();
    if (!picture_.graphics().is_lost() || (lost_at_ && now - *lost_at_ < soon)) return error;
    lost_at_ = now;
    picture_.use(nullptr);
    TRY(open_graphics());
    say(error.message + "; drawn by the " + figures_.painter + " painter on " +
            (figures_.gpu.empty() ? "the CPU" : figures_.gpu) + " from now on",
        Tone::fault);
    return {};
}

Result<PlayFigures> WindowLoop::run() {
    Result<void> ended = open();
    while (ended && !stop_requested() && (!quit_ || has_to_stay())) ended = turn();
    return end(std::move(ended));
}

/// Draws where something is to be seen, takes what has come, and does it.
Result<void> WindowLoop::turn() {
    const WatchedMoment* const moment = clip_ ? clip_->session().look() : nullptr;
    if (clip_) say(playback_->go_on(moment));
    watch(moment, Clock::now());
    if (clip_ && options_.hand) look_after_hand(moment);
    if (is_due(moment, Clock::now()))
        if (auto drawn = draw_what_is_there(moment); !drawn) TRY(open_graphics_anew(drawn.error()));
    TRY(screen_->health());
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
    TRY(go_on_opening());
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

double WindowLoop::now_s() const {
    return begun_ ? seconds_between(*begun_, Clock::now()) : 0;
}

double WindowLoop::thread_cpu_ms() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) * 1e3 + static_cast<double>(time.tv_nsec) * 1e-6;
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
        written.result ? say("kept as " + std::filesystem::absolute(written.file).string())
                       : say(written.result.error().message, Tone::fault);
}

/// What is to be kept and no longer can be: once, as it happens.
void WindowLoop::note_files() {
    for (const auto& fault :
         {clip_ ? clip_->record_fault() : std::nullopt, sound_->file_fault(),
          film_ ? film_->fault() : std::nullopt, use_log_ ? use_log_->missing() : std::nullopt,
          study_ ? study_->fault() : std::nullopt})
        if (fault && file_faults_.insert(fault->message).second) say(fault->message, Tone::fault);
}

Result<void> WindowLoop::keep_picture(const std::filesystem::path& name) {
    TRY_ASSIGN(auto image, picture_.graphics().picture());
    screenshots_.give(screenshot(std::move(image), name, options_.existing));
    return {};
}

void WindowLoop::say(const Result<void>& done) {
    if (!done) say(done.error());
}

void WindowLoop::say(const Error& error) {
    say(error.message, error.kind == ErrorKind::usage ? Tone::refusal : Tone::fault);
}

void WindowLoop::say(std::string words, Tone tone, About about) {
    if (tone == Tone::fault) log_fault(words);
    if (tone != Tone::remark) tell(words);
    notices_.say(std::move(words), tone, time_s_, about);
    last_event_ = Clock::now();
}

/// Prints the fault to stderr where no window is seen (headless), and in a kiosk, whose visitors cannot mend
/// it: there each message once, a hundred in all.
void WindowLoop::tell(const std::string& fault) {
    constexpr std::size_t most_told = 100;
    const bool is_told = kiosk_ && (told_.size() == most_told || !told_.insert(fault).second);
    if ((options_.headless || kiosk_) && !is_told) warn(fault);
}

/// Whether the brush is still at what it was asked for before the window was closed. Who closes it again does
/// not wait. A hand has no forces by then.
bool WindowLoop::has_to_stay() {
    if (leaves_at_once_ || !brush_.is_changing()) return false;
    if (!std::exchange(is_leaving_, true)) {
        power_hand_off();
        say("the window closes once the brush has done what it was asked for; close it again to leave now");
    }
    return true;
}

/// Whatever ended it: what was touched, heard, filmed and answered until then is kept. The exit code is that
/// of `ended`; an earlier fault, which the window outlived, decides only where nothing failed in the end. A
/// kiosk that was interrupted was ended by that, not by a fault.
Result<PlayFigures> WindowLoop::end(Result<void> ended) {
    power_hand_off();
    if (kiosk_) log_visit(kiosk_->end());
    end_log(ended);
    if (!clip_) return end_without_clip(std::move(ended));
    Result<void> kept;
    const bool is_kept = ended && options_.screenshot && !stop_requested();
    if (is_kept) {
        ended = draw_newest();
        if (ended) kept = keep_picture(*options_.screenshot);
    }
    opening_.give_up();
    if (auto written = write_settings(); !written) warn("settings are not kept: " + written.error().message);
    const Result<void> recorded = clip_->finish(), heard = sound_->finish();
    const Result<void> results =
        study_ ? study_->end(now_s(), std::chrono::system_clock::now()) : Result<void>();
    sum_up();
    // However the window ends.
    for (const std::string& line : measured_) std::printf("%-24s%s\n", "measured", line.c_str());
    note_last_failure();
    const bool is_filmed = film_ && (begun_ || !stop_requested());
    const Result<void> filmed = is_filmed ? film_->finish(now_s()) : Result<void>();
    if (film_) figures_.film_pictures = film_->pictures();
    if (film_) figures_.film_left_out = film_->left_out();
    const Result<void> saved = finish_brush();
    figures_.materials = brush_.unsaved_words();
    kept = finish_screenshots(is_kept, std::move(kept));
    const bool has_failed =
        failure_ && failure_->kind != ErrorKind::interrupted && !(kiosk_ && stop_requested());
    const Result<void> failed = has_failed ? Result<void>(*failure_) : Result<void>();
    TRY(all_ok({ended, failed, recorded, heard, filmed, kept, saved, results}));
    if (stop_requested()) return interruption();
    return std::move(figures_);
}

/// Closed while the first clip was opened, or waited for; or it cannot be opened.
Result<PlayFigures> WindowLoop::end_without_clip(Result<void> ended) {
    opening_.let_go();
    const bool is_kept = ended && begun_ && options_.screenshot && !stop_requested();
    if (is_kept) {
        ended = draw_opening();
        if (ended) ended = keep_picture(*options_.screenshot);
    }
    if (ended = finish_screenshots(is_kept, std::move(ended)); !ended) return ended.error();
    if (stop_requested()) return interruption();
    if (failure_) return *failure_;
    figures_.seconds = now_s();
    return std::move(figures_);
}

/// Waits for their disk, but not for ever.
Result<void> WindowLoop::write_settings() const {
    if (!options_.settings_file) return {};
    BackgroundWriter writer("settings", "settings");
    writer.give(
        {.file = *options_.settings_file,
         .write = [file = settings_file_, kept = to_keep()](const auto&) { return file.write(kept); }});
    writer.finish();
    return writer.take().front().result;
}

KeptSettings WindowLoop::to_keep() const {
    KeptSettings kept = settings_file_.read();
    kept.panel = panel_->shown;
    if (!options_.dent) kept.dent = is_dented_;
    kept.fingers = clip_->fingers().count();
    kept.volume = sound_->volume();
    if (!options_.filters_are_stated) {
        const TwoSettings settings = wanted_settings().kept;
        kept.a = settings.a;
        kept.b = settings.b;
    }
    const ScreenSize size = screen_->size();
    if (options_.size_is_stated || fullscreen_ || size.width < 1) return kept;
    kept.width = std::max(static_cast<int>(std::lround(size.width / size.scale)), SettingsFile::least_width);
    kept.height =
        std::max(static_cast<int>(std::lround(size.height / size.scale)), SettingsFile::least_height);
    return kept;
}

/// Of the clip that is there, or the device that is held.
void WindowLoop::note_last_failure() {
    if (!failure_) failure_ = clip_->failure();
    if (!failure_ && options_.hand && options_.hand->is_gone())
        if (const auto health = options_.hand->health(); !health) failure_ = health.error();
}

/// `is_kept`: the one that was asked for by an option is among them, `kept` what became of it until then.
Result<void> WindowLoop::finish_screenshots(bool is_kept, Result<void> kept) {
    screenshots_.finish();
    for (const auto& written : screenshots_.take()) {
        if (written.result) continue;
        if (is_kept && kept)
            kept = written.result.error();
        else
            warn(written.result.error().message);
    }
    return kept;
}

/// Why materials that were to be saved are not. An interrupted run tells it, and says in the end that it was
/// interrupted.
Result<void> WindowLoop::finish_brush() {
    Result<void> saved = brush_.finish();
    if (stop_requested()) saved = {};
    for (const auto& remark : brush_.take_news().remarks)
        if (remark.tone != Tone::remark && (saved || remark.words != saved.error().message))
            warn(remark.words);
    return saved;
}

/// Ended by a person's signal: what is kept of what was asked for.
Error WindowLoop::interruption() const {
    std::string written, missing;
    const auto add = [&](const std::string& name, bool is_asked_for, bool is_written) {
        std::string& to = is_written ? written : missing;
        if (is_asked_for) to += (to.empty() ? "" : ", ") + name;
    };
    add(options_.names.record, options_.record.has_value(), clip_ != nullptr);
    add(options_.names.sound, options_.sound.has_value(), clip_ != nullptr);
    add(options_.names.video, options_.video.has_value(), begun_.has_value());
    add(options_.names.screenshot, options_.screenshot.has_value(), false);
    std::string words = "interrupted";
    if (!begun_) words += " before the first picture";
    if (!written.empty()) words += "; written up to there: " + written;
    if (!missing.empty()) words += "; not written: " + missing;
    return {ErrorKind::interrupted, std::move(words)};
}

void WindowLoop::sum_up() {
    figures_.seconds = now_s();
    figures_.window_cpu_ms = begun_ ? thread_cpu_ms() - begun_cpu_ms_ : 0;
    figures_.frames_due = frames_shown_.due();
    figures_.frames_in_time = frames_shown_.in_time();
    figures_.relief = relief_words();
    count_session();
}

/// What keeps the relief that is felt; empty: there is none.
std::string WindowLoop::relief_words() const {
    const auto& in_effect = clip_->in_effect();
    const auto amount = in_effect.find("relief");
    if (amount == in_effect.end() || amount->second == "0") return {};
    return options_.names.relief(clip_->choice().file.string(), in_effect);
}

/// Of all clips that were there.
void WindowLoop::count_session() {
    const WatchedFigures sessions = clip_->figures();
    figures_.builder = sessions.feed.builder;
    figures_.ticks += sessions.ticks.ticks;
    figures_.late_ticks += sessions.ticks.late;
    figures_.tick_late_us_p99 = std::max(figures_.tick_late_us_p99, sessions.ticks.late_us_p99);
    figures_.frames += sessions.feed.frames;
    figures_.late_frames += sessions.late_frames;
    figures_.dropped_frames += sessions.feed.dropped;
}

Result<PlayFigures> play_in_window(PlayOptions options) {
    share_memory_among_threads();
    WindowLoop window(std::move(options));
    return window.run();
}

}  // namespace touchable
