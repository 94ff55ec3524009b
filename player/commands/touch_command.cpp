// SPDX-License-Identifier: Apache-2.0
#include <termios.h>
#include <CLI/CLI.hpp>
#include <array>
#include <deque>
#include <glm/vec2.hpp>
#include <iostream>
#include <set>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/reports.hpp"
#include "player/commands/run_options.hpp"
#include "player/run/run_files.hpp"
#include "player/run/terminal.hpp"

namespace touchable {

namespace {

constexpr std::size_t trail_ticks = 500;
constexpr std::size_t trail_step = 4;  // ticks between two drawn points

/// Where frame `number` of an epoch is read from: there, or with a temporal filter where its epoch begins.
std::int64_t read_from_ns(const TouchSetup& setup, std::uint64_t epoch, std::int64_t number) {
    if (!setup.scene.filter.temporal) return setup.scene.rate.time_ns(number);
    PlaybackClock clock(setup.scene.rate, setup.options.playback);
    std::int64_t start_ns = 0;
    for (auto next = clock.next_epoch(); next && next->number <= epoch; next = clock.next_epoch())
        start_ns = next->start_ns;
    return start_ns;
}

using MaybePath = std::optional<std::filesystem::path>;

/// Every file that the run reads.
std::vector<NamedFile> inputs_of(const TouchOptions& options, const TouchSetup& setup) {
    std::vector<NamedFile> inputs = inputs_of(setup.options.clip, setup.feed->reader());
    if (options.replay) inputs.push_back({"--replay", *options.replay});
    if (options.play) inputs.push_back({"--play", *options.play});
    for (const auto& file : files_of(options.held)) inputs.push_back({"the device's file", file});
    if (const auto file = setup.hand ? setup.hand->file() : std::nullopt)
        inputs.push_back({"the hand's file", *file});
    return inputs;
}

Outputs outputs_of(const TouchOptions& options, const TouchSetup& setup) {
    Outputs outputs{{}, options.existing};
    const std::pair<const char*, const MaybePath&> asked_for[] = {{"--forces", options.forces},
                                                                  {"--device-log", options.device_log},
                                                                  {"--record", options.record},
                                                                  {"--json", options.json},
                                                                  {"--picture", options.picture.file}};
    for (const auto& [name, path] : asked_for)
        if (path) outputs.files.push_back({name, *path});
    if (options.record && setup.film)
        outputs.files.push_back({"the film of --record", film_beside(*options.record)});
    return outputs;
}

/// Refuses a picture beyond the run's end, if its length is known.
Result<void> check_picture_moment(const TouchOptions& options, const TouchSetup& setup,
                                  std::optional<std::int64_t> ticks) {
    const auto frames = setup.feed->reader().frame_count();
    const bool is_the_clips = !ticks && frames && setup.options.playback.empty() && !setup.options.control;
    if (is_the_clips) ticks = std::max(setup.scene.rate.time_ns(*frames), shortest_run_ns) / tick_ns;
    if (!options.picture_tick || !ticks || *options.picture_tick < *ticks) return {};
    const std::string end =
        std::to_string(*ticks / 1000) + '.' + std::to_string(1000 + *ticks % 1000).substr(1);
    return usage_error("--picture-at lies beyond the run's end at " + end + " s" +
                       (is_the_clips ? "; --seconds makes the run longer" : ""));
}

/// The tick that a picture shows by default: 60 % of the run, or of the clip's, at least 3 s, if the run's
/// length is unknown.
std::int64_t usual_picture_tick(const TouchSetup& setup, const std::optional<std::int64_t>& ticks) {
    if (ticks) return *ticks * 6 / 10;
    if (!setup.options.playback.empty()) return shortest_run_ns / tick_ns * 6 / 10;
    const auto frames = setup.feed->reader().frame_count();
    const std::int64_t clip_ms = frames ? setup.scene.rate.time_ns(*frames) / 1'000'000 : 0;
    return std::max<std::int64_t>(clip_ms, 3000) * 6 / 10;
}

/// `touch --picture`: stores the fingers at a moment of the run and their trails just before; after the run,
/// reads that moment's frames again and draws them.
class TouchPicture final : public TouchSink {
public:
    /// `tick`: the moment; if ticks are skipped, the first tick not before it.
    TouchPicture(PictureOrder order, std::int64_t tick) : order_(std::move(order)), tick_(tick) {}
    Result<void> consume(const TouchTick& tick) override {
        if (reached_) return {};
        trails_.resize(tick.contacts.size());
        for (std::size_t k = 0; k < trails_.size(); ++k) {
            const Contact& contact = tick.contacts[k];
            if (!contact.touching || !std::isfinite(contact.pixel_x) || !std::isfinite(contact.pixel_y)) {
                trails_[k].clear();
                continue;
            }
            trails_[k].emplace_back(contact.pixel_x, contact.pixel_y);
            if (trails_[k].size() > trail_ticks) trails_[k].pop_front();
        }
        reached_ = tick.tick >= tick_;
        moment_ = Moment{tick.pair.epoch, tick.pair.prev.number, tick.pair.next.number, tick.pair.blend, {}};
        for (std::size_t k = 0; k < trails_.size(); ++k) {
            const Contact& contact = tick.contacts[k];
            moment_->fingers.push_back({contact.goal, contact.proxy, tick.sent(k), contact.touching, {}});
        }
        return {};
    }
    bool is_reached() const { return reached_; }  ///< whether the moment was reached
    const SurfacePainter& painter() const { return *order_.painter; }
    /// Draws the moment. If the run ended before it: draws the last tick if `cut_short`,
    /// otherwise refused (ErrorKind::usage).
    Result<void> finish(const TouchSetup& setup, bool cut_short) {
        if (!moment_ || !(reached_ || cut_short))
            return usage_error("--picture: the run ended before " + std::to_string(tick_) +
                               " ms, the moment to draw; --picture-at says another");
        const StopScope drawing = StopScope::after_stop();  // the run may have been stopped by the user
        TRY_ASSIGN(auto reader, setup.options.clip.open());
        // If the GPU built the frames, it builds and draws them; otherwise build whole frames on the CPU.
        const bool on_gpu = setup.feed->builder_name() == "vulkan";
        BuilderChoice choice = on_gpu ? setup.options.builder : BuilderChoice{};
        choice.error_bars = order_.show == Overlay::errors;
        TRY_ASSIGN(auto builder, make_builder(choice, setup.scene, *setup.options.gpu));
        SurfaceFeed feed(std::move(reader), std::move(builder), setup.scene, setup.warm_up_frames,
                         SurfaceTimeline::Eye::one);
        feed.leave_out(setup.feed->dropped());
        TRY(feed.read_from(moment_->epoch, read_from_ns(setup, moment_->epoch, moment_->frame_prev)));
        TRY_ASSIGN(const FramePair pair, feed.pair_of(moment_->frame_prev, moment_->frame_next,
                                                      moment_->blend, moment_->epoch));
        const HeightField field(setup.scene, pair);
        const TimedFrame& nearer = field.blend() >= 0.5 ? pair.next : pair.prev;
        const auto stored = feed.stored_planes(pair.epoch, nearer.number);
        TRY(order_.deliver(field, pair, stored ? stored->colour : PlaneView(), fingers_on(field)));
        const std::string gpu = order_.painter->gpu_name();
        line_ = "picture: " + one_line(order_.file->target().string()) + " by the " +
                std::string(order_.painter->name()) + " painter" + (gpu.empty() ? "" : " on " + gpu) +
                formatted("; 1 N is %g units long\n",
                          mark_sizes(setup.scene, subject_of(field).middle).length_per_newton);
        return {};
    }
    /// A line about the picture; empty before `finish`.
    const std::string& line() const { return line_; }

private:
    using Place = glm::dvec2;  // proxy in the image, pixels
    struct Moment {
        std::uint64_t epoch = 0;
        std::int64_t frame_prev = 0, frame_next = 0;
        double blend = 0;
        std::vector<FingerMark> fingers;  // trails are still empty
    };
    std::vector<FingerMark> fingers_on(const HeightField& field) const {
        const FieldProbe probe(field);
        std::vector<FingerMark> fingers = moment_->fingers;
        for (std::size_t k = 0; k < fingers.size(); ++k) {
            const std::deque<Place>& trail = trails_[k];
            for (std::size_t at = trail.empty() ? 0 : (trail.size() - 1) % trail_step; at < trail.size();
                 at += trail_step)
                if (const auto depth = probe.depth_under(trail[at].x, trail[at].y))
                    fingers[k].trail.push_back(probe.unproject(trail[at].x, trail[at].y, *depth));
        }
        return fingers;
    }

    PictureOrder order_;
    std::int64_t tick_;
    std::vector<std::deque<Place>> trails_;  // per finger, since its last contact began
    std::optional<Moment> moment_;           // the newest tick, until the moment
    bool reached_ = false;
    std::string line_;
};

/// The requested files of a run: opened before it, so that unwritable places are reported at once, and named
/// after it, so that a failed run leaves none. A full disk ends neither the run nor the other files.
class TouchOutputs {
public:
    /// Refuses files that are also inputs or named twice, existing files that may not be replaced, and a
    /// picture of a moment beyond the run's end, if its length is known. `ticks`: length of all parts, if
    /// known. `options` must outlive this.
    static Result<std::unique_ptr<TouchOutputs>> open(const TouchOptions& options, const TouchSetup& setup,
                                                      std::optional<std::int64_t> ticks) {
        TRY(check_picture_moment(options, setup, ticks));
        if (options.record && is_standard_output(*options.record))
            return usage_error(
                "--record -: a recording does not go to standard output; give it a file's name");
        TRY(check_outputs(outputs_of(options, setup), inputs_of(options, setup)));
        std::unique_ptr<TouchOutputs> out(new TouchOutputs(options));
        const Pace pace = setup.options.live && !options.replay ? Pace::wall_clock : Pace::own;
        if (options.forces)
            TRY(assign(out->forces_,
                       TickTable::create_forces(*options.forces, options.existing, pace, "--forces")));
        out->only_forces_ = options.forces && !options.device_log && !options.record && !options.json &&
                            !options.picture.file && !options.replay && !options.strict &&
                            !setup.options.control;
        if (options.device_log) {
            if (!setup.device_log)
                return usage_error(
                    "--device-log is of a --device that you hold; --forces has what a hand does");
            TRY_ASSIGN(out->device_log_, TickTable::create_device_log(*options.device_log, options.existing,
                                                                      *setup.device_log, "--device-log"));
        }
        if (options.record)
            TRY(assign(out->record_, RecordingFile::create(*options.record, setup.options.fingers,
                                                           options.existing, pace, "--record")));
        if (options.record && setup.film) {
            out->film_ = setup.film;
            TRY(setup.film->open(film_beside(*options.record), options.existing));
        }
        if (options.json)
            TRY(assign(out->json_, OutputFile::create("--json", *options.json, options.existing, pace)));
        TRY_ASSIGN(auto order, order_picture(options.picture, options.existing, setup.options.builder,
                                             *setup.options.gpu));
        if (order)
            out->picture_.emplace(std::move(*order),
                                  options.picture_tick.value_or(usual_picture_tick(setup, ticks)));
        return out;
    }

    /// The outputs that take every tick.
    std::vector<TouchSink*> sinks() {
        std::vector<TouchSink*> sinks;
        for (OutputSink* const file : files())
            if (file) sinks.push_back(file);
        if (picture_) sinks.push_back(&*picture_);
        return sinks;
    }
    /// The file of a sink, for messages: "--forces f.csv"; empty: writes none during the run.
    std::string name_of(const TouchSink* sink) const {
        for (const OutputSink* const file : files())
            if (sink == file) return file->name();
        return "";
    }
    /// The picture's painter; nullptr: no picture.
    const SurfacePainter* painter() const { return picture_ ? &picture_->painter() : nullptr; }
    /// After a part that is not the last: draws the picture if its moment was in the part.
    Result<void> end_part(const TouchSetup& setup) {
        if (!picture_ || is_drawn_ || !picture_->is_reached()) return {};
        is_drawn_ = true;
        return picture_->finish(setup, false);
    }
    /// Whether the run has no more use: its only output is a pipe that its reader has closed.
    bool are_unread() const { return only_forces_ && forces_->is_unread(); }
    /// Faults of outputs since the last call; each is reported once.
    std::vector<std::string> new_faults() {
        std::vector<std::string> faults;
        for (const OutputSink* const file : files())
            if (const auto fault = file ? file->fault() : std::nullopt; fault && told_.insert(file).second)
                faults.push_back(fault->message);
        if (const auto fault = film_ ? film_->fault() : std::nullopt;
            fault && told_.insert(film_.get()).second)
            faults.push_back("the film of --record: " + fault->message);
        return faults;
    }
    /// After the run's last part, that of `setup`: completes every file even if others fail. An error names
    /// the incomplete ones.
    Result<void> finish(const nlohmann::ordered_json& report, const std::string& force_hash,
                        const TouchSetup& setup) {
        std::vector<Result<void>> done;
        const auto keep = [&](Result<void> finished, const std::filesystem::path& file) {
            if (!written_) written_.emplace();
            if (finished && !is_standard_output(file)) written_->push_back(file.string());
            done.push_back(std::move(finished));
        };
        if (forces_) keep(forces_->finish(), *options_.forces);
        if (device_log_) keep(device_log_->finish(), *options_.device_log);
        if (record_) keep(finish_record(force_hash, setup), *options_.record);
        if (json_) keep(write_report(report, *json_), *options_.json);
        if (picture_)
            keep(is_drawn_ ? Result<void>() : picture_->finish(setup, report.value("interrupted", false)),
                 *options_.picture.file);
        return all_ok(done);
    }
    /// The files completed by `finish`, without standard output; nothing: none requested.
    const std::optional<std::vector<std::string>>& written() const { return written_; }
    /// A remark to print after the table; may be empty.
    std::string remark() const { return picture_ ? picture_->line() : std::string(); }

private:
    explicit TouchOutputs(const TouchOptions& options) : options_(options) {}
    /// Those that write while the run goes on; null: not asked for.
    std::array<OutputSink*, 3> files() const { return {forces_.get(), device_log_.get(), record_.get()}; }
    Result<void> finish_record(const std::string& force_hash, const TouchSetup& setup) {
        if (setup.film) {
            TRY(setup.film->finish());
            if (const auto fault = setup.film->fault())
                record_->end_with_frame(setup.film->last_frame(), *fault);
        }
        return record_->finish(recorded_facts(setup, force_hash), setup.options.playback);
    }

    const TouchOptions& options_;
    std::optional<std::vector<std::string>> written_;
    std::unique_ptr<TickTable> forces_, device_log_;
    std::unique_ptr<RecordingFile> record_;
    std::unique_ptr<OutputFile> json_;
    std::optional<TouchPicture> picture_;
    bool only_forces_ = false;             // nothing else is written, checked or felt
    bool is_drawn_ = false;                // the picture is drawn
    std::shared_ptr<CameraCapture> film_;  // beside the recording
    std::set<const void*> told_;           // outputs whose fault was reported
};

/// Keys for a held device: Enter toggles forces, c and Enter recentres. Listens only if standard input is a
/// terminal.
class ForceKeys : NonCopyable {
public:
    /// `control` must outlive this.
    explicit ForceKeys(HandControl& control) : control_(control) {
        if (isatty(STDIN_FILENO) == 0) return;
        tcflush(STDIN_FILENO, TCIFLUSH);  // discards earlier input
        [[maybe_unused]] const auto started =
            start_thread(thread_, "force-keys", "that reads keys", [this] { listen(); });
    }
    ~ForceKeys() {
        over_ = true;
        if (thread_.joinable()) thread_.join();
    }

    bool listens() const { return thread_.joinable(); }

private:
    void listen() {
        pollfd input{STDIN_FILENO, POLLIN, 0};
        while (!over_) {
            if (poll(&input, 1, 50) <= 0) continue;
            char line[64];
            const auto typed = read(STDIN_FILENO, line, sizeof line);
            if (typed <= 0) return control_.ask_force(false);  // no key could turn forces off any more
            if (line[0] == 'c' || line[0] == 'C')
                control_.recentre();
            else
                control_.ask_force(!control_.force_is_asked());
        }
    }

    HandControl& control_;
    std::atomic<bool> over_{false};
    std::thread thread_;
};

/// Stream of the table: stderr if another output uses standard output.
std::ostream& stream_of_words(const TouchOptions& options) {
    for (const auto& file : {options.json, options.forces, options.device_log})
        if (file && is_standard_output(*file)) return std::cerr;
    return std::cout;
}

// Ticks; eleven days: the user or the device ends the run.
constexpr std::int64_t until_it_is_ended = 1'000'000'000;

/// Makes the error of a live run that lost this many ticks because an output was too slow.
using FellBehind = std::function<Error(std::int64_t)>;

Result<LiveFacts> run_live(TouchSetup& s, std::span<TouchSink* const> sinks, const FellBehind& fell_behind) {
    TRY_ASSIGN(auto port, open_port(s));
    TouchSessionSettings settings = s.options;
    settings.ticks = s.ticks();
    std::optional<ForceKeys> keys;
    std::function<std::string()> device;  // the device's state for the status line
    if (s.options.control) {
        if (!settings.ticks) {
            settings.ticks = until_it_is_ended;
            settings.hand_is_over = [&s] { return s.options.held_device->is_over(); };
        }
        keys.emplace(*s.options.control);
        std::cerr << one_line(how_to_begin(*s.options.held_device, *s.options.control, keys->listens()))
                  << '\n';
        device = [&s] { return state_of(*s.options.held_device, *s.options.control); };
    }
    LiveLine line(s.exerting_control(), std::move(device), [&s](std::int64_t silent_ns) {
        return silence_in_words(silent_ns, s.options.guard.stale_after_ns, s.feed->reader());
    });
    settings.on_status = [&line](const TouchSessionSettings::LiveStatus& status) { line.show(status); };
    std::vector<TouchSink*> all(sinks.begin(), sinks.end());
    all.push_back(&line);
    LiveSession session(*s.feed, *port, *s.solver, settings);
    const auto ran = session.run(all);
    LiveFacts facts = session.facts();
    if (facts.sinks_fell_behind) return fell_behind(facts.loop.lost);
    if (!ran) return ran.error();
    explain_failure(s, facts);
    return facts;
}

Result<LiveFacts> run_session(TouchSetup& s, bool live, std::span<TouchSink* const> sinks,
                              const FellBehind& fell_behind) {
    if (live) return run_live(s, sinks, fell_behind);
    Progress progress("tick", s.ticks().value_or(0));
    std::vector<TouchSink*> all(sinks.begin(), sinks.end());
    all.push_back(&progress);
    TRY(TouchSession(*s.feed, *s.hand, *s.solver, s.options).run(all));
    return LiveFacts{};
}

/// Passes a later part's ticks on as if they continued the previous parts; finds the slowest sink.
class ConcatenatingSink final : public TouchSink {
public:
    /// `live`: faults of the outputs are printed at once; otherwise at the end.
    ConcatenatingSink(std::int64_t ticks_before, std::vector<TouchSink*> sinks, TouchOutputs& outputs,
                      bool live)
        : before_(ticks_before), sinks_(std::move(sinks)), outputs_(outputs), live_(live) {}
    Result<void> consume(const TouchTick& tick) override {
        TouchTick later = tick;
        later.tick += before_;
        later.time_ns += before_ * tick_ns;
        for (std::size_t k = 0; k < sinks_.size(); ++k) {
            const auto begun = std::chrono::steady_clock::now();
            TRY(sinks_[k]->consume(later));
            took_[k] += std::chrono::steady_clock::now() - begun;
        }
        if (live_)
            for (const std::string& fault : outputs_.new_faults())
                say_on_stderr("warning: " + fault + "; the run goes on");
        return outputs_.are_unread() ? Result<void>(interrupted_error()) : Result<void>();
    }
    const TouchSink* slowest() const {
        return sinks_[static_cast<std::size_t>(std::ranges::max_element(took_) - took_.begin())];
    }

private:
    std::int64_t before_;
    std::vector<TouchSink*> sinks_;
    std::vector<std::chrono::steady_clock::duration> took_ = decltype(took_)(sinks_.size());
    TouchOutputs& outputs_;
    bool live_;
};

std::int64_t ticks_of(const RecordedPart& part) {
    return part.ticks.back().time_ns / tick_ns + 1;
}

/// Reports of the run's parts; only a replay can have several.
struct Told {
    std::vector<nlohmann::ordered_json> reports;
    std::vector<ReplayCheck::Outcome> replayed;
    TouchFigures all;
    LiveFacts live;          // of the last part
    std::int64_t ticks = 0;  // length of the previous parts
};

/// Error of a run that ended early with complete files.
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

/// With `--strict`, warnings are an error.
Result<void> strictly(const TouchOptions& options, const nlohmann::ordered_json& report) {
    const auto warnings = report.at("warnings").get<std::vector<std::string>>();
    const std::string all = listed(warnings, std::identity(), "; ");
    if (!options.strict || all.empty()) return {};
    return Error{ErrorKind::check, "--strict: " + all};
}

/// Runs the only part, or one of a recording.
Result<void> run_part(const TouchOptions& options, const RecordedPart* part, TouchSetup& s,
                      TouchOutputs& outputs, Told& told) {
    TouchFigures figures;
    std::vector<TouchSink*> of_all = outputs.sinks();
    of_all.push_back(&told.all);
    const bool live = s.options.live && !options.replay;  // on the wall clock; a replay never is
    ConcatenatingSink one_run(told.ticks, std::move(of_all), outputs, live);
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
    told.replayed.push_back(check->outcome(figures.force_hash(), has_other_frames(*part, s)));
    told.all.end_part();
    told.ticks += ticks_of(*part);
    return {};
}

/// Runs the parts one by one, each freed before the next. The first is already set up; the last stays.
Result<void> run_parts(const TouchOptions& options, const Recording& recording,
                       std::unique_ptr<TouchSetup>& setup, TouchOutputs& outputs, Told& told) {
    if (recording.empty()) return run_part(options, nullptr, *setup, outputs, told);
    for (const RecordedPart& part : recording) {
        if (&part != &recording.front()) {
            TRY(outputs.end_part(*setup));
            const auto gpu = setup->options.gpu;
            setup.reset();
            TRY_ASSIGN(setup, setup_from_recording(part, options.session, gpu));
        }
        TRY(run_part(options, &part, *setup, outputs, told));
    }
    return {};
}

/// `at_work`: set to what memory is needed for, once known.
Result<void> touch(const TouchOptions& options, std::string& at_work) {
    TRY(check_gpu_options(options.session.builder, options.picture.draws_on_gpu()));
    // The parts to replay; empty otherwise.
    TRY_ASSIGN(const auto recording,
               options.replay ? read_recording(*options.replay) : Result<Recording>(Recording()));
    const bool replays = !recording.empty();
    TRY_ASSIGN(auto setup, replays ? setup_from_recording(recording.front(), options.session)
                                   : setup_from_options(options.session));
    at_work = frames_in_words(setup->scene) + ", or for a run of that length";
    std::optional<std::int64_t> ticks = setup->ticks();
    if (recording.size() > 1) {
        ticks = 0;
        for (const RecordedPart& part : recording) *ticks += ticks_of(part);
    }
    TRY_ASSIGN(auto outputs, TouchOutputs::open(options, *setup, ticks));

    Told told;
    const auto ran = run_parts(options, recording, setup, *outputs, told);
    if (outputs->are_unread()) return {};
    if (!ran) return ran;
    const auto report = told.reports.size() > 1 ? join_reports(told.reports, told.all) : told.reports.front();
    // Files first: the reader of the table may close its pipe.
    const auto done = outputs->finish(report, told.all.force_hash(), *setup);
    std::ostream& words = stream_of_words(options);
    if (options.verbose)
        words << on_terminal(report_to_text(report) + outputs->remark());
    else
        words << on_terminal(report_in_short(report, outputs->written()));
    if (!done) return done;
    TRY(ended_early(told.live));
    if (!replays) return strictly(options, report);
    TRY_ASSIGN(const auto same, judge_replay(told.replayed, told.all.force_hash()));
    words << same;
    return strictly(options, report);
}

/// Options as typed; values with units are converted after parsing.
struct TouchWords {
    TouchOptions options;
    ClipTyped clip;
    PlaybackTyped playback;
    std::optional<double> seconds, picture_seconds;
    CLI::App* command = nullptr;
    LiveTyped live;
};

/// The run's length and the picture's moment, in ticks.
Result<void> read_moments(const TouchWords& words, TouchOptions& options) {
    const auto in_ticks = [](double seconds) { return static_cast<std::int64_t>(seconds * 1000 + 0.5); };
    auto& ticks = options.session.ticks;
    if (words.picture_seconds) options.picture_tick = in_ticks(*words.picture_seconds);
    if (words.seconds) ticks = in_ticks(*words.seconds);
    if (ticks && options.picture_tick && *options.picture_tick >= *ticks)
        return usage_error("--picture-at lies beyond the run's end; --seconds says when that is");
    return {};
}

/// With --replay the recording defines the run; only the clip's place, the builder and outputs may be given.
Result<void> check_replay(const CLI::App& command) {
    const std::set<std::string> free{"CLIP",      "--scene", "--haptic", "--height",
                                     "--builder", "--gpu",   "--painter"};
    for (const CLI::Option* const option : command.get_options()) {
        const std::string &group = option->get_group(), name = option->get_name();
        if (option->count() > 0 && group != files_topic && group != picture_topic && !free.contains(name))
            return usage_error(name + " comes from the recording; leave it out with --replay");
    }
    return {};
}

Result<TouchOptions> read_words(const TouchWords& words) {
    TouchOptions options = words.options;
    TRY(read_moments(words, options));
    if (options.replay) {
        TRY(check_replay(*words.command));
    } else if (words.clip.choice.file.empty() && !options.session.camera) {
        return usage_error(
            "touch needs a CLIP, a --camera, or a recording to --replay; see touchable touch -h");
    }
    TRY_ASSIGN(auto clip, read_clip(words.clip));
    clip.interpolation = options.session.clip.interpolation;
    options.session.clip = std::move(clip);
    options.session.recorded = options.record.has_value();
    options.session.builder.error_bars = options.forces.has_value();
    options.session.device_log = options.device_log.has_value();
    TRY(read_live_options(words.live, options.session));
    TRY_ASSIGN(options.session.playback, read_playback(words.playback));
    options.play = words.playback.script;
    return options;
}

/// Adds the options of output files.
void add_file_options(CLI::App& sub, TouchOptions& o) {
    begin_topic(sub, files_topic);
    add_json_option(sub, o.json, "write the figures as JSON", true);
    add_file_option(
        sub, "--forces", o.forces,
        "write goal, proxy, force and its error of every tick and finger as CSV. -: to standard output");
    add_file_option(sub, "--device-log", o.device_log,
                    "write positions, buttons and forces of a device that you hold as CSV. It replays as the "
                    "device recorded; -: to standard output");
    auto* record = add_file_option(sub, "--record", o.record, "save what it takes to repeat the run");
    auto* replay =
        add_file_option(sub, "--replay", o.replay, "repeat a recorded run and compare every force with it");
    record->excludes(replay);
    add_overwrite_option(sub, o.existing);
    sub.add_flag("--verbose", o.verbose, "print all figures, not only the first four lines");
    sub.add_flag("--strict", o.strict, "exit with code 6 on any warning");
}

/// Adds the options of the hand and the run's length.
void add_hand_options(CLI::App& sub, TouchWords& words) {
    SessionOptions& session = words.options.session;
    begin_topic(sub, "Hand");
    sub.add_flag("--live", session.live, "run in real time on the wall clock. Each part has its own thread");
    sub.add_option("--hand", session.hand, "how the hand moves. Each takes :key=value,... (docs/touch.md)")
        ->type_name(type_with_words("HAND", hand_words()))
        ->capture_default_str();
    add_whole_option(sub, "--fingers", session.fingers,
                     "number of fingers. They copy the hand's path, spread on a circle", 1, 256)
        ->capture_default_str();
    add_number_option(sub, "--seconds", words.seconds,
                      "length of the run. By default that of a recorded hand or device; with a device that "
                      "you hold, until Ctrl-C; otherwise the clip's, but at least 3",
                      0.001, 1e6)
        ->type_name("SECONDS");
}

/// Adds a run's setting. The run refuses what is in the option's range and still invalid.
CLI::Option* add_setting_option(CLI::App& sub, const SessionSetting& setting, SessionOptions& session) {
    const SettingRange& range = setting.range;
    const bool is_number = range.words.empty();
    const auto read = [&setting, &range, is_number, &session](const std::string& word) -> Result<void> {
        TRY_ASSIGN(const double number,
                   is_number ? read_number("", word, setting.typed.least, setting.typed.most, range.unit)
                             : read_word(range, word));
        setting.set(number, session);
        return {};
    };
    return add_read_option(sub, "--" + setting.name, read, setting.what)
        ->default_str(setting.usual)
        ->type_name(!is_number    ? type_with_words("WORD", range.words)
                    : *range.unit ? range.unit
                                  : "NUMBER");
}

/// Adds the options of the force computation, mostly rarely needed.
void add_force_options(CLI::App& sub, SessionOptions& session) {
    begin_topic(sub, expert_topic);
    sub.add_flag("--start-buried", session.start_buried,
                 "push out a finger that starts inside the surface at once, with --live. Otherwise it feels "
                 "nothing until it has been free");
    for (const SessionSetting& setting : run_settings())
        if (setting.of == SettingOf::felt || setting.of == SettingOf::expert)
            add_setting_option(sub, setting, session);
    for (const char* limit : {"--max-force", "--max-stiffness"}) sub.get_option(limit)->group("Hand");
    sub.get_option("--interpolation")->group("Playback");
}

}  // namespace

Result<void> run_touch(const TouchOptions& options) {
    TouchOptions run = options;
    TRY(hold_devices(options.held, run.session));
    std::string at_work = "what is to be touched";
    return within_memory(at_work, [&] { return touch(run, at_work); });
}

void add_touch_command(CLI::App& app, Command& command) {
    auto* sub =
        app.add_subcommand("touch", "touch a clip without a window, by a scripted hand or a haptic device");
    auto words = std::make_shared<TouchWords>();
    TouchOptions& o = words->options;
    words->command = sub;
    add_clip_options(*sub, words->clip);
    add_camera_options(*sub, words->clip.camera);
    add_playback_options(*sub, words->playback);
    add_live_options(*sub, words->live, o.session);
    add_hand_options(*sub, *words);
    add_device_options(*sub, o.held, o.session, false);
    add_filter_options(*sub, words->clip);
    add_file_options(*sub, o);
    add_picture_options(*sub, o.picture);
    add_number_option(*sub, "--picture-at", words->picture_seconds,
                      "when to draw. By default at 60 % of the run (of 3 s where its length is not known)", 0,
                      1e6)
        ->type_name("SECONDS")
        ->needs("--picture");
    sub->get_option("--painter")->group(expert_topic);
    add_force_options(*sub, o.session);
    add_builder_options(*sub, o.session.builder, {"auto", "cpu", "vulkan", "lazy", "reference"});
    set_work(*sub, command, [words]() -> Result<void> {
        TRY_ASSIGN(const auto options, read_words(*words));
        return run_touch(options);
    });
}

}  // namespace touchable
