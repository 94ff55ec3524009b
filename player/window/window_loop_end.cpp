#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <string>
#include <utility>

#include "engine/base/printable.hpp"
#include "engine/base/try.hpp"
#include "engine/base/unless_stopped.hpp"
#include "player/run/interrupt.hpp"
#include "player/run/output_file.hpp"
#include "player/window/window_loop.hpp"

// How a window ends: when it may, what is finished then, and what is told of it.

namespace touchable {
namespace {

/// On the terminal: the window is about to go.
void warn(const std::string& words) {
    std::cerr << "touchable: warning: " << printable(words, 500) << '\n';
}

}  // namespace

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
    const bool is_kept = ended.ok() && options_.screenshot && !interrupted();
    if (is_kept) {
        ended = draw_newest();
        if (ended.ok()) kept = keep_picture(*options_.screenshot);
    }
    opening_.give_up();
    if (auto written = write_settings(); !written.ok())
        warn("settings are not kept: " + written.error().message);
    const Result<void> recorded = clip_->finish(), heard = sound_->finish();
    const Result<void> results =
        study_ ? study_->end(now_s(), std::chrono::system_clock::now()) : Result<void>();
    sum_up();
    // However the window ends.
    for (const std::string& line : measured_) std::printf("%-24s%s\n", "measured", line.c_str());
    note_last_failure();
    const bool is_filmed = film_ && (begun_ || !interrupted());
    const Result<void> filmed = is_filmed ? film_->finish(now_s()) : Result<void>();
    if (film_) figures_.film_pictures = film_->pictures();
    if (film_) figures_.film_left_out = film_->left_out();
    const Result<void> saved = finish_brush();
    figures_.materials = brush_.unsaved_words();
    kept = finish_screenshots(is_kept, std::move(kept));
    const bool has_failed =
        failure_ && failure_->kind != ErrorKind::interrupted && !(kiosk_ && interrupted());
    const Result<void> failed = has_failed ? Result<void>(*failure_) : Result<void>();
    TRY(all_ok({ended, failed, recorded, heard, filmed, kept, saved, results}));
    if (interrupted()) return interruption();
    return std::move(figures_);
}

/// Waits for their disk, but not for ever.
Result<void> WindowLoop::write_settings() const {
    if (!options_.settings_file) return {};
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(2);
    const auto written =
        unless_stopped([file = settings_file_, kept = to_keep()] { return file.write(kept); },
                       [until] { return std::chrono::steady_clock::now() >= until; });
    if (written) return *written;
    return disk_does_not_answer(*options_.settings_file);
}

/// Of the clip that is there, or the device that is held.
void WindowLoop::note_last_failure() {
    if (!failure_) failure_ = clip_->failure();
    if (!failure_ && options_.hand && options_.hand->is_gone())
        if (const auto health = options_.hand->health(); !health.ok()) failure_ = health.error();
}

/// `is_kept`: the one that was asked for by an option is among them, `kept` what became of it until then.
Result<void> WindowLoop::finish_screenshots(bool is_kept, Result<void> kept) {
    screenshots_.finish();
    for (const auto& written : screenshots_.take()) {
        if (written.ok()) continue;
        if (is_kept && kept.ok())
            kept = written.error();
        else
            warn(written.error().message);
    }
    return kept;
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

/// Why materials that were to be saved are not. An interrupted run tells it, and says in the end that it was
/// interrupted.
Result<void> WindowLoop::finish_brush() {
    Result<void> saved = brush_.finish();
    if (interrupted()) saved = {};
    for (const auto& remark : brush_.take_news().remarks)
        if (remark.tone != Tone::remark && (saved.ok() || remark.words != saved.error().message))
            std::cerr << "touchable: warning: " << printable(remark.words, 500) << '\n';
    return saved;
}

}  // namespace touchable
