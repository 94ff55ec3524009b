#include "player/commands/touch_outputs.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "engine/base/number_words.hpp"
#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "player/commands/outputs.hpp"
#include "player/run/field_probe.hpp"
#include "player/run/standard_output.hpp"
#include "player/session/recorded_facts.hpp"

namespace touchable {
namespace {

constexpr std::size_t trail_ticks = 500;
constexpr std::size_t trail_step = 4;  // ticks between two points that are drawn

/// A frame of the clip, read and built once more.
struct FrameAgain {
    RawFrame raw;
    SurfaceFrame surface;
};

/// The first frame that those of an epoch are made of, `number` being one of them: that one alone, or where a
/// filter remembers what it has seen since the epoch's start.
std::int64_t first_read(const TouchSetup& setup, std::uint64_t epoch, std::int64_t number) {
    if (!setup.scene.filter.temporal) return number;
    PlaybackClock clock(setup.scene.rate, setup.settings.playback);
    std::int64_t start_ns = 0;
    for (auto next = clock.next_epoch(); next && next->number <= epoch; next = clock.next_epoch())
        start_ns = next->start_ns;
    if (epoch == 0) return 0;
    const std::int64_t first = std::min(setup.scene.rate.frame_at(start_ns), number);
    return std::max<std::int64_t>(0, first - setup.warm_up_frames);
}

/// Reads on until frame `number`, and builds it, and of those before it those that it is made of.
Result<void> read_frame(ClipReader& reader, SurfaceBuilder& builder, std::int64_t number,
                        const std::function<bool(std::int64_t)>& is_part, FrameAgain& frame) {
    for (;;) {
        TRY_ASSIGN(auto raw, reader.next());
        if (!raw) return input_error("the clip ends before frame " + std::to_string(number) + " this time");
        const bool wanted = raw->number == number;
        if (!wanted && !is_part(raw->number)) continue;
        frame.raw = *raw;
        if (auto built = builder.build(frame.raw, frame.surface); wanted || !built.ok()) return built;
    }
}

}  // namespace

std::int64_t usual_picture_tick(const TouchSetup& setup) {
    const auto known = setup.ticks();
    if (known) return *known * 6 / 10;
    if (!setup.settings.playback.empty()) return shortest_run_ns / tick_ns * 6 / 10;
    const auto frames = setup.feed->reader().frame_count();
    const std::int64_t clip_ms = frames ? setup.scene.rate.time_ns(*frames) / 1'000'000 : 0;
    return std::max<std::int64_t>(clip_ms, 3000) * 6 / 10;
}

Result<void> TouchPicture::take(const TouchTick& tick) {
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

std::vector<FingerMark> TouchPicture::fingers_on(const HeightField& field) const {
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

Result<void> TouchPicture::finish(const TouchSetup& setup, bool cut_short) {
    if (!moment_ || !(reached_ || cut_short))
        return usage_error("--picture: the run ended before " + std::to_string(tick_) +
                           " ms, the moment to draw; --picture-at says another");
    const WorkAfterStop drawing;  // of a run that a person has ended
    TRY_ASSIGN(auto reader, setup.clip.open());
    // Frames of the GPU that also draws stay there; others are built here, whole.
    const bool on_gpu = setup.feed->builder_name() == "vulkan";
    TRY_ASSIGN(const auto builder,
               make_builder(on_gpu ? setup.builder : BuilderChoice{}, setup.scene, *setup.gpu));
    const std::int64_t first = first_read(setup, moment_->epoch, moment_->frame_prev);
    if (auto there = reader->seek(first); !there.ok()) return there;
    FrameAgain prev, next;
    const auto is_part = [&](std::int64_t number) {
        return setup.scene.filter.temporal && !setup.feed->has_dropped(moment_->epoch, number);
    };
    if (auto read = read_frame(*reader, *builder, moment_->frame_prev, is_part, prev); !read.ok())
        return read;
    const bool between = moment_->frame_next != moment_->frame_prev;
    if (between)
        if (auto read = read_frame(*reader, *builder, moment_->frame_next, is_part, next); !read.ok())
            return read;

    FramePair pair;
    pair.prev = {moment_->frame_prev, 0, &prev.surface};
    pair.next = {moment_->frame_next, 0, between ? &next.surface : &prev.surface};
    pair.blend = moment_->blend;
    const HeightField field(setup.scene, pair);
    const RawFrame& nearer = field.blend() >= 0.5 ? next.raw : prev.raw;
    if (auto done = order_.deliver(field, pair, nearer.colour, fingers_on(field)); !done.ok()) return done;
    const std::string gpu = order_.painter->gpu_name();
    line_ = "picture: " + order_.file->target().string() + " by the " + std::string(order_.painter->name()) +
            " painter" + (gpu.empty() ? "" : " on " + gpu) +
            formatted("; 1 N is %g units long\n",
                      mark_sizes(setup.scene, subject_of(field).middle).length_per_newton);
    return {};
}

namespace {

using MaybePath = std::optional<std::filesystem::path>;

/// Every file the run reads.
std::vector<NamedFile> inputs_of(const TouchOptions& options, const TouchSetup& setup) {
    std::vector<NamedFile> inputs;
    if (setup.clip.scene_file) inputs.push_back({"--scene", *setup.clip.scene_file});
    if (options.replay) inputs.push_back({"--replay", *options.replay});
    if (options.play) inputs.push_back({"--play", *options.play});
    for (const auto& file : files_of(options.held)) inputs.push_back({"the device's file", file});
    if (const auto file = setup.hand ? setup.hand->file() : std::nullopt)
        inputs.push_back({"the hand's file", *file});
    add_inputs(inputs, setup.clip.file, setup.feed->reader());
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

/// Makes what `path` asks for, if anything.
template <class File, class Create>
Result<void> open_if(const MaybePath& path, std::unique_ptr<File>& file, Create create) {
    if (!path) return {};
    TRY_ASSIGN(auto created, create(*path));
    file = std::move(created);
    return {};
}

/// Of a run whose length is known before.
Result<void> check_picture_moment(const TouchOptions& options, const TouchSetup& setup,
                                  std::optional<std::int64_t> ticks) {
    const auto frames = setup.feed->reader().frame_count();
    const bool is_the_clips = !ticks && frames && setup.settings.playback.empty() && !setup.control;
    if (is_the_clips) ticks = std::max(setup.scene.rate.time_ns(*frames), shortest_run_ns) / tick_ns;
    if (!options.picture_tick || !ticks || *options.picture_tick < *ticks) return {};
    const std::string end =
        std::to_string(*ticks / 1000) + '.' + std::to_string(1000 + *ticks % 1000).substr(1);
    return usage_error("--picture-at lies beyond the run's end at " + end + " s" +
                       (is_the_clips ? "; --seconds makes the run longer" : ""));
}

}  // namespace

Result<std::unique_ptr<TouchOutputs>> TouchOutputs::open(const TouchOptions& options, const TouchSetup& setup,
                                                         std::optional<std::int64_t> ticks) {
    TRY(check_picture_moment(options, setup, ticks));
    if (options.record && is_standard_output(*options.record))
        return usage_error("--record -: a recording does not go to standard output; give it a file's name");
    TRY(check_outputs(outputs_of(options, setup), inputs_of(options, setup)));
    std::unique_ptr<TouchOutputs> out(new TouchOutputs(options));
    const Pace pace = setup.live && !options.replay ? Pace::wall_clock : Pace::own;
    const auto forces = [&](const auto& path) {
        return ForcesFile::create(path, options.existing, pace, "--forces");
    };
    TRY(open_if(options.forces, out->forces_, forces));
    if (options.device_log && !setup.device_log)
        return usage_error("--device-log is of a --device that you hold; --forces has what a hand does");
    const auto log = [&](const auto& path) {
        return DeviceLogFile::create(path, options.existing, *setup.device_log, "--device-log");
    };
    TRY(open_if(options.device_log, out->device_log_, log));
    const auto record = [&](const auto& path) {
        return RecordingFile::create(path, setup.settings.fingers, options.existing, pace, "--record");
    };
    TRY(open_if(options.record, out->record_, record));
    if (options.record && setup.film) {
        out->film_ = setup.film;
        TRY(setup.film->open(film_beside(*options.record), options.existing));
    }
    const auto json = [&](const auto& path) {
        return OutputFile::create("--json", path, options.existing, pace);
    };
    TRY(open_if(options.json, out->json_, json));
    TRY_ASSIGN(auto order, order_picture(options.picture, options.existing, setup.builder, *setup.gpu));
    const std::int64_t usual = ticks ? *ticks * 6 / 10 : usual_picture_tick(setup);
    if (order) out->picture_.emplace(std::move(*order), options.picture_tick.value_or(usual));
    return out;
}

std::vector<TouchSink*> TouchOutputs::sinks() {
    std::vector<TouchSink*> sinks;
    if (forces_) sinks.push_back(forces_.get());
    if (device_log_) sinks.push_back(device_log_.get());
    if (record_) sinks.push_back(record_.get());
    if (picture_) sinks.push_back(&*picture_);
    return sinks;
}

std::string TouchOutputs::name_of(const TouchSink* sink) const {
    if (sink == forces_.get()) return forces_->name();
    if (sink == device_log_.get()) return device_log_->name();
    return sink == record_.get() ? record_->name() : "";
}

const SurfacePainter* TouchOutputs::painter() const {
    return picture_ ? &picture_->painter() : nullptr;
}

Result<void> TouchOutputs::end_part(const TouchSetup& setup) {
    if (!picture_ || is_drawn_ || !picture_->is_reached()) return {};
    is_drawn_ = true;
    return picture_->finish(setup, false);
}

std::vector<std::string> TouchOutputs::new_faults() {
    std::vector<std::string> faults;
    for (const OutputSink* const file :
         std::initializer_list<const OutputSink*>{forces_.get(), device_log_.get(), record_.get()})
        if (const auto fault = file ? file->fault() : std::nullopt; fault && told_.insert(file).second)
            faults.push_back(fault->message);
    if (const auto fault = film_ ? film_->fault() : std::nullopt; fault && told_.insert(film_.get()).second)
        faults.push_back("the film of --record: " + fault->message);
    return faults;
}

Result<void> TouchOutputs::finish_record(const std::string& force_hash, const TouchSetup& setup) {
    if (setup.film) {
        if (auto done = setup.film->finish(); !done.ok()) return done;
        if (const auto fault = setup.film->fault()) record_->end_with_frame(setup.film->last_frame(), *fault);
    }
    nlohmann::ordered_json facts = recorded_facts(setup);
    facts["force_hash"] = force_hash;
    return record_->finish(facts, setup.settings.playback);
}

Result<void> TouchOutputs::finish_json(const nlohmann::ordered_json& report) {
    const auto replace = nlohmann::ordered_json::error_handler_t::replace;  // names need not be UTF-8
    if (auto written = json_->write(report.dump(2, ' ', false, replace) + '\n'); !written.ok())
        return written;
    return json_->finish();
}

Result<void> TouchOutputs::finish(const nlohmann::ordered_json& report, const std::string& force_hash,
                                  const TouchSetup& setup) {
    std::vector<Result<void>> done;
    const auto keep = [&](Result<void> finished, const std::filesystem::path& file) {
        if (!written_) written_.emplace();
        if (finished.ok() && !is_standard_output(file)) written_->push_back(file.string());
        done.push_back(std::move(finished));
    };
    if (forces_) keep(forces_->finish(), *options_.forces);
    if (device_log_) keep(device_log_->finish(), *options_.device_log);
    if (record_) keep(finish_record(force_hash, setup), *options_.record);
    if (json_) keep(finish_json(report), *options_.json);
    if (picture_)
        keep(is_drawn_ ? Result<void>() : picture_->finish(setup, report.value("interrupted", false)),
             *options_.picture.file);
    return all_ok(done);
}

}  // namespace touchable
