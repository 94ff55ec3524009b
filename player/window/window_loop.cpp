// SPDX-License-Identifier: Apache-2.0
// A window's main loop, a script's inputs, and the files kept at the end.

#include <malloc.h>

#include "engine/base/threads.hpp"
#include "engine/base/try.hpp"
#include "player/window/window_core.hpp"

namespace touchable {
namespace {

bool drops(const ScriptedInput& input) {
    const auto* const event = std::get_if<InputEvent>(&input.what);
    return event && event->kind == InputEvent::Kind::dropped;
}

/// Limits malloc's arenas. Each clip is read, built and drawn by its own threads, and by default malloc has
/// eight arenas per core, a new one for every thread. An arena's freed memory is not reused by others, so
/// memory would grow with every clip. The haptic thread does not allocate.
void share_memory_among_threads() {
#ifdef __GLIBC__
    mallopt(M_ARENA_MAX, 2);
#endif
}

/// Runs a window (window_core.hpp) to its end.
class WindowLoop {
public:
    explicit WindowLoop(PlayOptions options) : core_(std::move(options)) {}

    Result<PlayFigures> run() {
        Result<void> ended = core_.open();
        while (ended && !stop_requested() && (!window_.quits() || has_to_stay())) ended = turn();
        return end(std::move(ended));
    }

private:
    /// Draws if a picture is due, then processes input.
    Result<void> turn() {
        OpenedClip* const clip = window_.clip.get();
        const WatchedMoment* const moment = clip ? clip->session().look() : nullptr;
        if (clip) window_.say(window_.playback->go_on(moment ? &moment->held.pair : nullptr));
        if (clip && options_.hand) core_.hand.look_after();
        if (moment)
            for (WindowMode* const mode : window_.modes) mode->look(*moment);
        if (!is_offline_ || !is_busy()) TRY(core_.picture.draw_if_due(moment));
        TRY(window_.screen->health());
        take_input();
        if (clip) go_on_with_clip();
        TRY(core_.go_on_with_clips());
        note_files();
        if (options_.seconds && window_.time.script_s >= *options_.seconds) window_.quit();
        return {};
    }
    /// Waits for input and processes it, then the script's due inputs and the panel's commands.
    void take_input() {
        WindowTime& time = window_.time;
        const OpenedClip* const clip = window_.clip.get();
        const std::vector<InputEvent> events = window_.screen->poll(is_offline_ ? pass_time() : pause());
        time.script_s = is_offline_ ? time.now_s() : script_clock_.at(time.now_s(), is_at_work());
        if (core_.input.has_slept()) core_.take(InputEvent{.kind = InputEvent::Kind::left_window});
        for (const InputEvent& event : events) core_.take(event);
        if (time.begun && !window_.quits()) take_script();
        // Dropped files wait until the first requested clip is open, or failed to open.
        if (core_.input.has_dropped() && (clip || core_.clips.waits_for_wish()))
            core_.clips.open_others(core_.input.take_dropped());
        if (clip && time.begun)
            for (WindowMode* const mode : window_.modes) mode->tick(time.now_s());
        for (const WindowCommand& command : core_.picture.take_asked()) core_.take(command);
    }
    /// Until another frame is due, or the first clip is open.
    std::chrono::milliseconds pause() {
        const OpenedClip* const clip = window_.clip.get();
        const PlaybackState playback = clip ? clip->session().playback() : PlaybackState{};
        const bool is_quick = clip ? playback.playing && !playback.at_end : core_.clips.is_opening();
        const int longest_ms = is_quick ? 2 : options_.hand ? 8 : 16;
        const int left_ms = static_cast<int>(core_.picture.left_ms());  // below 0: nothing has moved
        return std::chrono::milliseconds(left_ms < 0 ? longest_ms : std::clamp(left_ms, 1, longest_ms));
    }
    /// Offline: goes on by a tick and a millisecond. While a clip is opened or the brush works, the time
    /// stands; returns how long to wait for that.
    std::chrono::milliseconds pass_time() {
        constexpr std::chrono::milliseconds work_pause(2), tick(1);
        OpenedClip* const clip = window_.clip.get();
        const WatchedMoment* const moment = clip ? clip->session().look() : nullptr;
        // The brush may wait for a moment.
        if (!clip || core_.clips.is_opening() || (moment && is_busy())) return work_pause;
        WatchedSession& session = clip->session();
        if (moment) core_.picture.lead_fingers(*moment);
        session.run_tick();
        if (!window_.time.begun && session.running())
            core_.picture.begin_time(WindowClock::now());
        else if (moment || !session.running())
            WindowClock::put_forward(tick);
        return {};
    }
    void take_script() {
        // The first clip is opened before.
        WindowTime& time = window_.time;
        const double until_s = time.script_s;
        const std::vector<ScriptedInput>& script = options_.script;
        const auto is_next = [&](double by_s) {
            return scripted_ < script.size() && script[scripted_].seconds <= by_s;
        };
        while (is_next(until_s) && !is_at_work() && (window_.clip || !core_.clips.is_opening())) {
            const auto& [at_s, what] = script[scripted_++];
            time.script_s = at_s;
            std::visit([this](const auto& input) { core_.take(input); }, what);
            // Files dropped at one moment form one drop.
            if (core_.input.has_dropped() && !(is_next(at_s) && drops(script[scripted_])))
                core_.clips.open_others(core_.input.take_dropped());
        }
        time.script_s = until_s;
    }
    void go_on_with_clip() {
        for (WindowMode* const mode : window_.modes) mode->go_on(window_.time.now_s());
        core_.input.go_on();
        note_sound();
        core_.clips.note_slow_reading();
        if (!window_.clip->session().running() && !window_.time.begun)
            window_.quit();  // there will be no picture
    }
    bool is_at_work() const { return window_.any(&WindowMode::is_at_work); }
    bool is_busy() { return core_.clips.is_opening() || is_at_work(); }
    /// Whether the brush is still working on requests made before the window was closed. Closing it again
    /// does not wait. The haptic device has no forces by then.
    bool has_to_stay() {
        if (window_.leaves_at_once() || !core_.brush.brush().is_changing()) return false;
        if (!std::exchange(is_leaving_, true)) {
            core_.hand.power_off();
            window_.say("the window closes when the brush has finished; close it again to quit at once");
        }
        return true;
    }
    /// Once per clip.
    void note_sound() {
        const std::string fault = window_.sound->clip_fault();
        if (fault == std::exchange(sound_fault_, fault) || fault.empty()) return;
        if (window_.figures.sound_fault.empty()) window_.figures.sound_fault = fault;
        window_.say(fault, Tone::fault, About::clip);
    }
    /// Reports files that can no longer be written, once each, and screenshots that were written.
    void note_files() {
        const auto& film = core_.picture.film();
        std::vector<Error> faults;
        for (const auto& fault : {window_.clip ? window_.clip->record_fault() : std::nullopt,
                                  window_.sound->file_fault(), film ? film->fault() : std::nullopt})
            if (fault) faults.push_back(*fault);
        for (const WindowMode* const mode : window_.modes)
            for (const Error& fault : mode->faults()) faults.push_back(fault);
        if (is_offline_ && film->fault()) window_.quit();
        // What is said of a file does not depend on the disk's time.
        while (is_offline_ && !stop_requested() && !window_.screenshots.wait(std::chrono::milliseconds(50))) {
        }
        for (const Error& fault : faults)
            if (window_.is_new_fault(fault)) window_.say(fault.message, Tone::fault);
        for (const auto& written : window_.screenshots.take()) {
            written.result ? window_.say(saved_as + std::filesystem::absolute(written.file).string())
                           : window_.say(written.result.error().message, Tone::fault);
            if (options_.headless && !written.result) lost_.push_back(written.result);
        }
    }

    /// On every exit path, keeps touches, sound, film and answers so far. The exit code is that of `ended`;
    /// an earlier fault that the window survived decides only if nothing failed at the end. An interruption
    /// of an unattended window is no fault.
    Result<PlayFigures> end(Result<void> ended) {
        core_.hand.power_off();
        for (WindowMode* const mode : window_.modes) mode->close(ended);
        if (!window_.clip) return end_without_clip(std::move(ended));
        WindowPicture& picture = core_.picture;
        Result<void> kept;
        const bool is_kept = ended && options_.screenshot && !stop_requested();
        if (is_kept) {
            ended = picture.draw_newest();
            if (ended) kept = picture.keep(*options_.screenshot);
        }
        core_.clips.give_up();
        if (auto written = write_settings(); !written)
            warn_on_terminal("settings are not kept: " + written.error().message);
        write_programs();
        const Result<void> recorded = window_.clip->finish(), heard = window_.sound->finish();
        Result<void> results;
        for (WindowMode* const mode : window_.modes)
            if (auto finished = mode->finish(); !finished) results = std::move(finished);
        sum_up();
        PlayFigures& figures = window_.figures;
        const auto& film = picture.film();
        const bool is_filmed = film && (window_.figures.pictures > 0 || (ended && !stop_requested()));
        const Result<void> filmed = is_filmed ? film->finish(window_.time.now_s()) : Result<void>();
        if (film) figures.film_pictures = film->pictures();
        if (film) figures.film_left_out = film->left_out();
        const Result<void> saved = core_.brush.save();
        figures.materials = core_.brush.brush().unsaved_words();
        kept = finish_screenshots(is_kept, std::move(kept));
        const auto& failure = core_.clips.failure();
        const bool has_failed = failure && failure->kind != ErrorKind::interrupted &&
                                !(window_.is_unattended() && stop_requested());
        const Result<void> failed = has_failed ? Result<void>(*failure) : Result<void>();
        TRY(all_ok({ended, failed, recorded, heard, filmed, kept, saved, results}));
        if (stop_requested()) return interruption();
        return std::move(figures);
    }
    /// Closed while the first clip was opened or requested, or it cannot be opened.
    Result<PlayFigures> end_without_clip(Result<void> ended) {
        core_.clips.let_go();
        const bool is_kept = ended && window_.time.begun && options_.screenshot && !stop_requested();
        if (is_kept) {
            ended = core_.picture.draw_opening();
            if (ended) ended = core_.picture.keep(*options_.screenshot);
        }
        TRY(finish_screenshots(is_kept, std::move(ended)));
        if (stop_requested()) return interruption();
        if (core_.clips.failure()) return *core_.clips.failure();
        window_.figures.seconds = window_.time.now_s();
        return std::move(window_.figures);
    }
    /// Keeps GPU programs for later runs; waits for their disk for a limited time.
    void write_programs() {
        auto programs = window_.options.gpu ? window_.options.gpu->take_new_programs() : std::nullopt;
        if (!programs) return;
        BackgroundWriter writer("programs", "programs of the GPU");
        const std::filesystem::path file = programs->file;
        writer.give({.file = file,
                     .write = [programs = std::move(*programs)](const auto&) { return programs.keep(); }});
        writer.finish();
    }
    /// Waits for their disk for a limited time.
    Result<void> write_settings() {
        if (!options_.settings_file) return {};
        BackgroundWriter writer("settings", "settings");
        writer.give({.file = *options_.settings_file,
                     .write = [file = window_.settings_file, kept = to_keep()](const auto&) {
                         return file.write(kept);
                     }});
        writer.finish();
        return writer.take().front().result;
    }
    KeptSettings to_keep() {
        KeptSettings kept = window_.settings_file.read();
        kept.panel = core_.panel.shown;
        if (!options_.dent) kept.dent = core_.picture.is_dented();
        if (!options_.light) kept.light = core_.picture.surface().light();
        kept.fingers = window_.clip->fingers().count();
        kept.volume = window_.sound->volume();
        kept.recent = core_.clips.recent();
        if (!options_.filters_are_stated) {
            const TwoSettings settings = core_.clips.wanted_settings().kept;
            kept.a = settings.a;
            kept.b = settings.b;
        }
        const ScreenSize size = window_.screen->size();
        if (options_.size_is_stated || core_.input.fullscreen() || size.width < 1) return kept;
        kept.width =
            std::max(static_cast<int>(std::lround(size.width / size.scale)), SettingsFile::least_width);
        kept.height =
            std::max(static_cast<int>(std::lround(size.height / size.scale)), SettingsFile::least_height);
        return kept;
    }
    /// `is_kept`: they include the one requested by an option, with `kept` as its result so far. Without a
    /// window each lost picture is an error, as no person sees that it is.
    Result<void> finish_screenshots(bool is_kept, const Result<void>& kept) {
        lost_.push_back(kept);
        window_.screenshots.finish();
        for (const auto& written : window_.screenshots.take())
            if (is_kept || (options_.headless && !stop_requested()))
                lost_.push_back(written.result);
            else if (!written.result)
                warn_on_terminal(written.result.error().message);
        return all_ok(lost_);
    }
    /// The error for an interruption by a signal, with a list of the outputs written and missing.
    Error interruption() {
        std::string written, missing;
        const auto add = [&](const std::string& name, bool is_asked_for, bool is_written) {
            std::string& to = is_written ? written : missing;
            if (is_asked_for) to += (to.empty() ? "" : ", ") + name;
        };
        const bool has_clip = window_.clip != nullptr, has_begun = window_.figures.pictures > 0;
        add(options_.names.record, options_.record.has_value(), has_clip);
        add(options_.names.sound, options_.sound.has_value(), has_clip);
        add(options_.names.video, options_.video.has_value(), has_begun);
        add(options_.names.screenshot, options_.screenshot.has_value(), false);
        std::string words = "interrupted";
        if (!has_begun) words += " before the first picture";
        if (!written.empty()) words += "; written up to there: " + written;
        if (!missing.empty()) words += "; not written: " + missing;
        return {ErrorKind::interrupted, std::move(words)};
    }
    void sum_up() {
        PlayFigures& figures = window_.figures;
        figures.seconds = window_.time.now_s();
        figures.window_cpu_ms = window_.time.thread_cpu_ms();
        figures.process_cpu_ms = window_.time.process_cpu_ms();
        figures.frames_due = core_.picture.frames_shown().due();
        figures.frames_in_time = core_.picture.frames_shown().in_time();
        figures.relief = relief_words(window_);
        core_.clips.note_end();
    }

    WindowCore core_;
    WindowState& window_ = core_.state;
    PlayOptions& options_ = window_.options;
    const bool is_offline_ = options_.is_offline();
    std::vector<Result<void>> lost_;  // results of pictures that were to be written without a window
    std::size_t scripted_ = 0;
    ScriptClock script_clock_;
    std::string sound_fault_;
    bool is_leaving_ = false;  // and waits for the brush
};

}  // namespace

Result<PlayFigures> play_in_window(PlayOptions options) {
    share_memory_among_threads();
    WindowClock::stand_still(options.is_offline());
    WindowLoop window(std::move(options));
    auto played = window.run();
    WindowClock::stand_still(false);
    return played;
}

}  // namespace touchable
