#include "bench/play/window_run.hpp"

#include <cmath>
#include <string>
#include <utility>

#include "bench/clocks.hpp"
#include "engine/base/same_bits.hpp"
#include "player/session/run_record.hpp"
#include "player/window/play_window.hpp"

namespace touchable {
namespace {

constexpr int width = 1280, height = 720;
constexpr double moves_per_s = 20;

/// Five fingers that press, round a pointer that goes in circles, moved at odd moments of a frame.
std::vector<ScriptedInput> hand(double seconds, double turned) {
    using Kind = InputEvent::Kind;
    std::vector<ScriptedInput> script{
        {0, WindowCommand{WindowVerb::fingers, 5, ""}},
        {0, InputEvent{.kind = Kind::moved, .x = width / 2.0, .y = height / 2.0}},
        {0.05, InputEvent{.kind = Kind::pressed, .word = "left"}}};
    if (turned != 0) script.insert(script.begin(), {0, WindowCommand{WindowVerb::turn, turned, ""}});
    for (double at = 0.1; at < seconds; at += 1 / moves_per_s)
        script.push_back({at, InputEvent{.kind = Kind::moved,
                                         .x = width / 2.0 + 60 * cosine(at),
                                         .y = height / 2.0 + 60 * sine(at)}});
    return script;
}

double percent(std::int64_t part, std::int64_t whole) {
    return whole > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(whole) : 0;
}

void add_spread(Figures& figures, const std::string& what, const PlayFigures::NewestValues& values) {
    const Spread spread = spread_of(values.values());
    figures.push_back({what + "_p50", spread.p50, "ms"});
    figures.push_back({what + "_p99", spread.p99, "ms"});
}

}  // namespace

Result<void> measure_window(const LiveClip& clip, double turned, LiveClips& clips, Figures& figures) {
    const auto file = clips.file(clip);
    if (!file) return file.error();
    PlayOptions options;
    options.session.clip.file = *file;
    options.headless = true;
    options.screen.width = width;
    options.screen.height = height;
    options.size_is_stated = true;
    options.seconds = clip.frames / 30.0;
    options.script = hand(*options.seconds, turned);
    const std::int64_t cpu = process_cpu_ns();
    const auto played = play_in_window(options);
    if (!played) return played.error();
    const auto cpu_ms = static_cast<double>(process_cpu_ns() - cpu) * 1e-6;
    const PlayFigures& p = *played;
    if (p.pictures < 2 || p.frames_due < 1) return Error{ErrorKind::check, "the window showed no pictures"};

    const auto pictures = static_cast<double>(p.pictures);
    figures.push_back({"frames_in_time_pct", percent(p.frames_in_time, p.frames_due), "%"});
    figures.push_back({"pictures_per_s", pictures / p.seconds, ""});
    add_spread(figures, "picture_ms", p.draw_ms);
    for (const auto& [stage, values] :
         {std::pair{"surface_ms", &p.surface_ms}, {"words_ms", &p.words_ms}, {"shown_ms", &p.shown_ms}})
        figures.push_back({stage, spread_of(values->values()).p50, "ms"});
    add_spread(figures, "input_ms", p.input_to_picture_ms);
    figures.push_back({"first_picture_ms", p.first_picture_ms, "ms"});
    figures.push_back({"cpu_ms_per_picture", cpu_ms / pictures, "ms"});
    figures.push_back({"window_cpu_ms", p.window_cpu_ms / pictures, "ms"});
    figures.push_back({"least_detail_pct", 100 * p.least_detail, "%"});
    figures.push_back({"tick_late_us_p99", p.tick_late_us_p99, "us"});
    figures.push_back({"late_ticks_pct", percent(p.late_ticks, p.ticks), "%"});
    figures.push_back({"late_frames_pct", percent(p.late_frames, p.frames), "%"});
    return {};
}

}  // namespace touchable
