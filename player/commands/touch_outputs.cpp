#include "player/commands/touch_outputs.hpp"

#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include "player/options/outputs.hpp"
#include "player/session/recorded_facts.hpp"
#include "player/terminal/standard_output.hpp"

namespace touchable {

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
    auto created = create(*path);
    if (!created.ok()) return created.error();
    file = std::move(*created);
    return {};
}

}  // namespace

Result<std::unique_ptr<TouchOutputs>> TouchOutputs::open(const TouchOptions& options, const TouchSetup& setup,
                                                         std::optional<std::int64_t> ticks) {
    if (options.record && is_standard_output(*options.record))
        return usage_error("--record -: a recording does not go to standard output; give it a file's name");
    if (auto free = check_outputs(outputs_of(options, setup), inputs_of(options, setup)); !free.ok())
        return free.error();
    std::unique_ptr<TouchOutputs> out(new TouchOutputs);
    const Pace pace = setup.live && !options.replay ? Pace::wall_clock : Pace::own;
    const auto forces = [&](const auto& path) { return ForcesFile::create(path, options.existing, pace); };
    if (auto opened = open_if(options.forces, out->forces_, forces); !opened.ok()) return opened.error();
    if (options.device_log && !setup.device_log)
        return usage_error("--device-log is of a --device that you hold; --forces has what a hand does");
    const auto log = [&](const auto& path) {
        return DeviceLogFile::create(path, options.existing, *setup.device_log);
    };
    if (auto opened = open_if(options.device_log, out->device_log_, log); !opened.ok()) return opened.error();
    const auto record = [&](const auto& path) {
        return RecordingFile::create(path, setup.settings.fingers, options.existing, pace);
    };
    if (auto opened = open_if(options.record, out->record_, record); !opened.ok()) return opened.error();
    if (options.record && setup.film) {
        out->film_ = setup.film;
        if (auto opened = setup.film->open(film_beside(*options.record), options.existing); !opened.ok())
            return opened.error();
    }
    const auto json = [&](const auto& path) {
        return OutputFile::create("--json", path, options.existing, pace);
    };
    if (auto opened = open_if(options.json, out->json_, json); !opened.ok()) return opened.error();
    auto order = order_picture(options.picture, options.existing, setup.builder, *setup.gpu);
    if (!order.ok()) return order.error();
    const std::int64_t usual = ticks ? *ticks * 6 / 10 : usual_picture_tick(setup);
    if (*order) out->picture_.emplace(std::move(**order), options.picture_tick.value_or(usual));
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
    if (forces_) done.push_back(forces_->finish());
    if (device_log_) done.push_back(device_log_->finish());
    if (record_) done.push_back(finish_record(force_hash, setup));
    if (json_) done.push_back(finish_json(report));
    if (picture_ && !is_drawn_) done.push_back(picture_->finish(setup, report.value("interrupted", false)));
    return all_ok(done);
}

}  // namespace touchable
