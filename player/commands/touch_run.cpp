#include "player/commands/touch_run.hpp"

#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <functional>
#include <iostream>
#include <memory>
#include <thread>
#include <vector>

#include "device/hand_control.hpp"
#include "engine/base/number_words.hpp"
#include "engine/base/printable.hpp"
#include "engine/base/start_thread.hpp"
#include "engine/base/try.hpp"
#include "player/commands/builder_options.hpp"
#include "player/commands/touch_outputs.hpp"
#include "player/commands/touch_report.hpp"
#include "player/run/live_line.hpp"
#include "player/run/live_session.hpp"
#include "player/run/memory.hpp"
#include "player/run/progress.hpp"
#include "player/run/standard_output.hpp"
#include "player/session/live_port.hpp"
#include "player/session/replay.hpp"
#include "player/session/touch_figures.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {
namespace {

/// Lines that a person types while a device is held: Enter turns forces on and off, c and Enter recentres.
/// Listens only where standard input is a terminal.
class ForceKeys {
public:
    /// `control` outlives it.
    explicit ForceKeys(HandControl& control);
    ~ForceKeys();
    ForceKeys(const ForceKeys&) = delete;
    ForceKeys& operator=(const ForceKeys&) = delete;

    bool listens() const { return thread_.joinable(); }

private:
    void listen();

    HandControl& control_;
    std::atomic<bool> over_{false};
    std::thread thread_;
};

ForceKeys::ForceKeys(HandControl& control) : control_(control) {
    if (isatty(STDIN_FILENO) == 0) return;
    tcflush(STDIN_FILENO, TCIFLUSH);  // what was typed before meant something else
    [[maybe_unused]] const auto started =
        start_thread(thread_, "force-keys", "that reads keys", [this] { listen(); });
}

ForceKeys::~ForceKeys() {
    over_ = true;
    if (thread_.joinable()) thread_.join();
}

void ForceKeys::listen() {
    pollfd input{STDIN_FILENO, POLLIN, 0};
    while (!over_) {
        if (poll(&input, 1, 50) <= 0) continue;
        char line[64];
        const auto typed = read(STDIN_FILENO, line, sizeof line);
        if (typed <= 0) return control_.ask_force(false);  // nobody can stop them any more
        if (line[0] == 'c' || line[0] == 'C')
            control_.recentre();
        else
            control_.ask_force(!control_.force_is_asked());
    }
}

/// Where the table goes: not between figures that another program reads.
std::ostream& stream_of_words(const TouchOptions& options) {
    for (const auto& file : {options.json, options.forces, options.device_log})
        if (file && is_standard_output(*file)) return std::cerr;
    return std::cout;
}

/// Whether the run is on the wall clock; a replay never is.
bool runs_live(const TouchSetup& setup, const TouchOptions& options) {
    return setup.live && !options.replay;
}

// Somebody who holds a device says when it is over, or the device does: eleven days.
constexpr std::int64_t until_it_is_ended = 1'000'000'000;

/// Which file a live run's ticks did not wait for, from how many there were.
using FellBehind = std::function<Error(std::int64_t)>;

Result<LiveFacts> run_live(TouchSetup& s, std::span<TouchSink* const> sinks, const FellBehind& fell_behind) {
    TRY_ASSIGN(auto port, open_port(s));
    TouchSessionSettings settings = s.settings;
    settings.ticks = s.ticks();
    std::optional<ForceKeys> keys;
    std::function<std::string()> device;  // what the line says of it
    if (s.control) {
        if (!settings.ticks) {
            settings.ticks = until_it_is_ended;
            settings.hand_is_over = [&s] { return s.held_device->is_over(); };
        }
        keys.emplace(*s.control);
        std::cerr << how_to_begin(*s.held_device, *s.control, keys->listens()) << '\n';
        device = [&s] { return state_of(*s.held_device, *s.control); };
    }
    LiveLine line(s.exerting_control(), std::move(device));
    settings.on_status = [&line](const LiveStatus& status) { line.show(status); };
    std::vector<TouchSink*> all(sinks.begin(), sinks.end());
    all.push_back(&line);
    LiveSession session(s.scene, *s.feed, *port, *s.solver, settings);
    const auto ran = session.run(all);
    LiveFacts facts = session.facts();
    if (facts.sinks_fell_behind) return fell_behind(facts.loop.lost);
    if (!ran.ok()) return ran.error();
    explain_failure(s, facts);
    return facts;
}

Result<LiveFacts> run_session(TouchSetup& s, bool live, std::span<TouchSink* const> sinks,
                              const FellBehind& fell_behind) {
    if (live) return run_live(s, sinks, fell_behind);
    TickProgress progress(s.ticks().value_or(0));
    std::vector<TouchSink*> all(sinks.begin(), sinks.end());
    all.push_back(&progress);
    TRY(TouchSession(s.scene, *s.feed, *s.hand, *s.solver, s.settings).run(all));
    return LiveFacts{};
}

/// The parts of what is replayed; none of any other run.
Result<Recording> read_replayed(const TouchOptions& options) {
    return options.replay ? read_recording(*options.replay) : Result<Recording>(Recording());
}

/// Gives the ticks of a later part on as those of one run with the parts before, and knows who takes longest.
class ConcatenatingSink final : public TouchSink {
public:
    /// `outputs`: what they can no longer write is said at once; nullptr: in the end.
    ConcatenatingSink(std::int64_t ticks_before, std::vector<TouchSink*> sinks, TouchOutputs* outputs)
        : before_(ticks_before), sinks_(std::move(sinks)), took_(sinks_.size()), outputs_(outputs) {}
    Result<void> take(const TouchTick& tick) override {
        TouchTick later = tick;
        later.tick += before_;
        later.time_ns += before_ * tick_ns;
        for (std::size_t k = 0; k < sinks_.size(); ++k) {
            const auto begun = std::chrono::steady_clock::now();
            if (auto taken = sinks_[k]->take(later); !taken.ok()) return taken;
            took_[k] += std::chrono::steady_clock::now() - begun;
        }
        if (outputs_)
            for (const std::string& fault : outputs_->new_faults())
                std::cerr << "touchable: warning: " << printable(fault, 500) << "; the run goes on\n";
        return {};
    }
    const TouchSink* slowest() const {
        return sinks_[static_cast<std::size_t>(std::max_element(took_.begin(), took_.end()) - took_.begin())];
    }

private:
    std::int64_t before_;
    std::vector<TouchSink*> sinks_;
    std::vector<std::chrono::steady_clock::duration> took_;
    TouchOutputs* outputs_;
};

std::int64_t ticks_of(const RecordedPart& part) {
    return part.ticks.back().time_ns / tick_ns + 1;
}

/// What there is to say of the run's parts; of any other run than a replay, of its only one.
struct Told {
    std::vector<nlohmann::ordered_json> reports;
    std::vector<ReplayedPart> replayed;
    TouchFigures all;
    LiveFacts live;          // of the last
    std::int64_t ticks = 0;  // of those before, in time
};

/// Of a run that ended too early and whose files are complete nevertheless.
Result<void> ended_early(const LiveFacts& facts) {
    if (!facts.interrupted && !facts.failure) return {};
    const std::string kept = formatted(" after %.3f s; what was asked for is written, up to there",
                                       static_cast<double>(facts.loop.ticks + facts.loop.skipped) / 1000);
    if (facts.failure) {
        Error failure = *facts.failure;
        failure.message += ": ended" + kept;
        return failure;
    }
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

/// Runs the only part, or the one of a recording.
Result<void> run_part(const TouchOptions& options, const RecordedPart* part, TouchSetup& s,
                      TouchOutputs& outputs, Told& told) {
    TouchFigures figures;
    std::vector<TouchSink*> of_all = outputs.sinks();
    of_all.push_back(&told.all);
    const bool live = runs_live(s, options);
    ConcatenatingSink one_run(told.ticks, std::move(of_all), live ? &outputs : nullptr);
    std::vector<TouchSink*> sinks{&one_run};
    std::optional<ReplayCheck> check;
    if (part) sinks.push_back(&check.emplace(*part));
    if (part) sinks.push_back(&figures);
    TRY_ASSIGN(const auto ran, run_session(s, live, sinks, [&](std::int64_t ticks) {
                   return fell_behind_error(outputs.name_of(one_run.slowest()), ticks);
               }));
    told.live = ran;
    told.reports.push_back(
        make_report(s, part ? figures : told.all, live ? &ran : nullptr, outputs.painter()));
    if (!part) return {};
    told.replayed.push_back(compare_replay(*part, *check, figures.force_hash(), s));
    told.all.end_part();
    told.ticks += ticks_of(*part);
    return {};
}

/// One after the other, in the memory of one. The first is set up already; the last stays.
Result<void> run_parts(const TouchOptions& options, const Recording& recording,
                       std::unique_ptr<TouchSetup>& setup, TouchOutputs& outputs, Told& told) {
    if (recording.empty()) return run_part(options, nullptr, *setup, outputs, told);
    for (const RecordedPart& part : recording) {
        if (&part != &recording.front()) {
            if (auto ended = outputs.end_part(*setup); !ended.ok()) return ended;
            const auto gpu = setup->gpu;
            setup.reset();
            TRY_ASSIGN(auto next, setup_from_recording(part, options.session, gpu));
            setup = std::move(next);
        }
        if (auto ran = run_part(options, &part, *setup, outputs, told); !ran.ok()) return ran;
    }
    return {};
}

/// `at_work`: what memory is needed for, once that is known.
Result<void> touch(const TouchOptions& options, std::string& at_work) {
    auto checked = check_gpu_options(options.session.builder, options.picture.draws_on_gpu());
    if (!checked.ok()) return checked;
    TRY_ASSIGN(const auto recording, read_replayed(options));
    const bool replays = !recording.empty();
    TRY_ASSIGN(auto first, replays ? setup_from_recording(recording.front(), options.session)
                                   : setup_from_options(options.session));
    std::unique_ptr<TouchSetup> setup = std::move(first);
    at_work = frames_in_words(setup->scene) + ", or for a run of that length";
    std::optional<std::int64_t> ticks = setup->ticks();
    if (recording.size() > 1) {
        ticks = 0;
        for (const RecordedPart& part : recording) *ticks += ticks_of(part);
    }
    TRY_ASSIGN(auto outputs, TouchOutputs::open(options, *setup, ticks));

    Told told;
    if (auto ran = run_parts(options, recording, setup, *outputs, told); !ran.ok()) return ran;
    const auto report = told.reports.size() > 1 ? join_reports(told.reports, told.all) : told.reports.front();
    // Files first: whoever reads the table may go away half-way.
    const auto done = outputs->finish(report, told.all.force_hash(), *setup);
    std::ostream& words = stream_of_words(options);
    if (options.verbose)
        words << report_to_text(report) << outputs->remark();
    else
        words << report_in_short(report, outputs->written());
    if (!done.ok()) return done;
    if (auto whole = ended_early(told.live); !whole.ok()) return whole;
    if (!replays) return strictly(options, report);
    TRY_ASSIGN(const auto same, judge_replay(told.replayed, told.all.force_hash()));
    words << same;
    return strictly(options, report);
}

}  // namespace

Result<void> run_touch(const TouchOptions& options) {
    TouchOptions run = options;
    if (auto held = hold_devices(options.held, run.session); !held.ok()) return held;
    std::string at_work = "what is to be touched";
    return within_memory(at_work, [&] { return touch(run, at_work); });
}

}  // namespace touchable
