#include "player/commands/touch_run.hpp"

#include <cstdio>
#include <iostream>
#include <memory>
#include <vector>

#include "player/commands/builder_options.hpp"
#include "player/commands/touch_outputs.hpp"
#include "player/commands/touch_report.hpp"
#include "player/session/live_port.hpp"
#include "player/session/live_session.hpp"
#include "player/session/memory.hpp"
#include "player/session/replay.hpp"
#include "player/session/standard_output.hpp"
#include "player/session/touch_figures.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

namespace {

/// Where the table goes: not between figures that another program reads.
std::ostream& stream_of_words(const TouchOptions& options) {
    for (const auto& file : {options.json, options.forces})
        if (file && is_standard_output(*file)) return std::cerr;
    return std::cout;
}

/// Whether the run is on the wall clock; a replay never is.
bool runs_live(const TouchSetup& setup, const TouchOptions& options) {
    return setup.live && !options.replay;
}

Result<LiveFacts> run_live(TouchSetup& s, std::span<TouchSink* const> sinks) {
    auto port = open_port(s);
    if (!port.ok()) return port.error();
    TouchSessionSettings settings = s.settings;
    settings.ticks = s.ticks();
    LiveSession session(s.scene, *s.feed, **port, *s.solver, settings);
    if (auto ran = session.run(sinks); !ran.ok()) return ran.error();
    LiveFacts facts = session.facts();
    explain_failure(s, facts);
    return facts;
}

Result<LiveFacts> run_session(TouchSetup& s, bool live, std::span<TouchSink* const> sinks) {
    if (live) return run_live(s, sinks);
    auto ran = TouchSession(s.scene, *s.feed, *s.hand, *s.solver, s.settings).run(sinks);
    if (!ran.ok()) return ran.error();
    return LiveFacts{};
}

Result<std::optional<Recording>> read_replayed(const TouchOptions& options) {
    if (!options.replay) return std::optional<Recording>();
    auto read = read_recording(*options.replay);
    if (!read.ok()) return read.error();
    return std::optional(std::move(*read));
}

/// Of a run that ended too early and whose files are complete nevertheless.
Result<void> ended_early(const LiveFacts& facts) {
    if (!facts.interrupted && !facts.failure) return {};
    char seconds[32];
    std::snprintf(seconds, sizeof seconds, "%.3f",
                  static_cast<double>(facts.loop.ticks + facts.loop.skipped) / 1000);
    const std::string kept =
        std::string(" after ") + seconds + " s; what was asked for is written, up to there";
    if (facts.failure) return Error{facts.failure->kind, facts.failure->message + ": ended" + kept};
    return Error{ErrorKind::interrupted, "interrupted" + kept};
}

/// What `--strict` makes of the warnings.
Result<void> strictly(const TouchOptions& options, const nlohmann::ordered_json& report) {
    std::string all;
    for (const auto& warning : report.at("warnings"))
        all += (all.empty() ? "" : "; ") + warning.get<std::string>();
    if (!options.strict || all.empty()) return {};
    return Error{ErrorKind::check, "--strict: " + all};
}

/// `at_work`: what memory is needed for, once that is known.
Result<void> touch(const TouchOptions& options, std::string& at_work) {
    auto checked = check_gpu_options(options.session.builder, options.picture.draws_on_gpu());
    if (!checked.ok()) return checked;
    auto recording = read_replayed(options);
    if (!recording.ok()) return recording.error();
    auto setup = *recording ? setup_from_recording(**recording, *options.replay, options.session)
                            : setup_from_options(options.session);
    if (!setup.ok()) return setup.error();
    TouchSetup& s = **setup;
    at_work = frames_in_words(s.scene) + ", or for a run of that length";
    auto outputs = TouchOutputs::open(options, s);
    if (!outputs.ok()) return outputs.error();

    TouchFigures figures;
    std::vector<TouchSink*> sinks = (*outputs)->sinks();
    sinks.push_back(&figures);
    std::optional<ReplayCheck> check;
    if (*recording) sinks.push_back(&check.emplace(**recording));
    const bool live = runs_live(s, options);
    const auto ran = run_session(s, live, sinks);
    if (!ran.ok()) return ran.error();

    const auto report = make_report(s, figures, live ? &*ran : nullptr, (*outputs)->painter());
    // Files first: whoever reads the table may go away half-way.
    const auto done = (*outputs)->finish(report, figures);
    std::ostream& words = stream_of_words(options);
    words << report_to_text(report) << (*outputs)->remark();
    if (!done.ok()) return done;
    if (auto whole = ended_early(*ran); !whole.ok()) return whole;
    if (!*recording) return strictly(options, report);
    const auto same = judge_replay(**recording, *check, figures.force_hash(), s);
    if (!same.ok()) return same.error();
    words << *same;
    return strictly(options, report);
}

}  // namespace

Result<void> run_touch(const TouchOptions& options) {
    std::string at_work = "what is to be touched";
    return within_memory(at_work, [&] { return touch(options, at_work); });
}

}  // namespace touchable
