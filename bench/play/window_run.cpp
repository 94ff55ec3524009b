// SPDX-License-Identifier: Apache-2.0
#include "bench/play/window_run.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "engine/base/same_bits.hpp"
#include "engine/base/try.hpp"
#include "player/window/play_window.hpp"

namespace touchable {
namespace {

constexpr double moves_per_s = 20;
constexpr double warm_up_s = 0.5;

/// Of `touched`: five pressed fingers around a pointer that moves in circles, at times not aligned to frames.
std::vector<ScriptedInput> hand(const WindowRun& run, double seconds) {
    if (run.use == WindowRun::Use::paused) return {{0.3, WindowCommand{WindowVerb::play_pause}}};
    if (run.use == WindowRun::Use::watched) return {};
    const double x = run.width / 2.0, y = run.height / 2.0;
    using Kind = InputEvent::Kind;
    std::vector<ScriptedInput> script{{0, WindowCommand{WindowVerb::fingers, 5, ""}},
                                      {0, InputEvent{.kind = Kind::moved, .x = x, .y = y}},
                                      {0.05, InputEvent{.kind = Kind::pressed, .word = "left"}}};
    if (run.turned != 0) script.insert(script.begin(), {0, WindowCommand{WindowVerb::turn, run.turned, ""}});
    for (double at = 0.1; at < seconds; at += 1 / moves_per_s)
        script.push_back(
            {at, InputEvent{.kind = Kind::moved, .x = x + 60 * cosine(at), .y = y + 60 * sine(at)}});
    return script;
}

double percent(std::int64_t part, std::int64_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

void add_spread(Figures& figures, const std::string& what, const TimeSpread& values) {
    const Spread spread = values.spread();
    figures.push_back({what + "_p50", spread.p50, "ms"});
    figures.push_back({what + "_p99", spread.p99, "ms"});
}

Result<PlayFigures> run_window(const WindowRun& run, const std::filesystem::path& file, double seconds) {
    PlayOptions options;
    options.session.clip.file = file;
    options.session.builder.name = run.builder;
    options.painter = run.painter;
    options.headless = true;
    options.screen.width = run.width;
    options.screen.height = run.height;
    options.size_is_stated = true;
    options.seconds = seconds;
    options.script = hand(run, seconds);
    return play_in_window(std::move(options));
}

}  // namespace

Result<void> measure_window(const WindowRun& run, LiveClips& clips, Figures& figures) {
    TRY_ASSIGN(const auto file, clips.file(run.clip));
    const double seconds = run.clip.frames / 30.0;
    TRY(run_window(run, file, warm_up_s));
    if (run.use == WindowRun::Use::paused) {
        constexpr double until_rest_s = 3, at_rest_s = 10;
        TRY_ASSIGN(const PlayFigures before, run_window(run, file, until_rest_s));
        TRY_ASSIGN(const PlayFigures after, run_window(run, file, until_rest_s + at_rest_s));
        const double more = after.seconds - before.seconds;
        figures.push_back(
            {"pictures_per_s", static_cast<double>(after.pictures - before.pictures) / more, ""});
        figures.push_back({"cpu_pct", (after.process_cpu_ms - before.process_cpu_ms) / (10 * more), "%"});
        return {};
    }
    TRY_ASSIGN(const PlayFigures p, run_window(run, file, seconds));
    if (p.pictures < 1) return Error{ErrorKind::check, "the window showed no pictures"};

    const auto pictures = static_cast<double>(p.pictures);
    const double counted = std::max(1.0, pictures - 1);  // without the first one
    figures.push_back({"frames_in_time_pct", percent(p.frames_in_time, p.frames_due), "%"});
    figures.push_back({"pictures_per_s", pictures / p.seconds, ""});
    add_spread(figures, "picture_ms", p.draw_ms);
    for (const auto& [stage, values] :
         {std::pair{"surface_ms", &p.surface_ms}, {"words_ms", &p.words_ms}, {"shown_ms", &p.shown_ms}})
        figures.push_back({stage, values->spread().p50, "ms"});
    add_spread(figures, "input_ms", p.input_to_picture_ms);
    figures.push_back({"first_picture_ms", p.first_picture_ms, "ms"});
    figures.push_back({"cpu_ms_per_picture", p.process_cpu_ms / counted, "ms"});
    figures.push_back({"cpu_pct", p.process_cpu_ms / (10 * p.seconds), "%"});
    figures.push_back({"window_cpu_ms", p.window_cpu_ms / counted, "ms"});
    figures.push_back({"least_detail_pct", 100 * p.least_detail, "%"});
    const auto& [feed, ticks, late_frames] = p.sessions;
    figures.push_back({"tick_late_us_p99", ticks.late_us_p99, "us"});
    figures.push_back({"late_ticks_pct", percent(ticks.late, ticks.ticks), "%"});
    figures.push_back({"late_frames_pct", percent(late_frames, feed.frames), "%"});
    figures.push_back(named("painter", p.painter));
    figures.push_back(named("builder", feed.builder));
    return {};
}

}  // namespace touchable
