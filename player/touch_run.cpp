#include "player/touch_run.hpp"

#include <iostream>
#include <memory>
#include <vector>

#include "player/device_port.hpp"
#include "player/forces_file.hpp"
#include "player/live_session.hpp"
#include "player/machine_facts.hpp"
#include "player/output_file.hpp"
#include "player/outputs_apart.hpp"
#include "player/recording.hpp"
#include "player/touch_figures.hpp"
#include "player/touch_picture.hpp"
#include "player/touch_setup.hpp"

namespace touchable {

namespace {

using Json = nlohmann::ordered_json;

Json make_report(const TouchSetup& setup, const TouchFigures& figures, const LoopFacts* loop) {
    const std::string cpu = cpu_facts().model;
    Json report{{"format", 1},
                {"clip", setup.clip.string()},
                {"hand", setup.hand_words},
                {"builder", setup.feed->builder_name()},
                {"device_name", setup.feed->builder_name() == "vulkan" ? setup.gpu->name() : cpu},
                {"cpu_name", cpu},
                {"width", setup.scene.width},
                {"height", setup.scene.height},
                {"frames", setup.feed->frames()},
                {"fingers", setup.settings.fingers}};
    report.update(figures.to_json());
    report["clock"] = loop ? "wall" : "virtual";
    if (!setup.device_words.empty()) report["device"] = setup.device_words;
    if (loop) {
        report["late_ticks"] = loop->late;
        report["skipped_ticks"] = loop->skipped;
        report["late_us"] = to_json(figures.late_us());
        report["late_us_histogram"] = figures.late_histogram();
        report["scheduling"] = loop->grant.in_words();
    }
    // The lazy builder computes no tile as a whole, the others compute all of them.
    report["skipped_tiles_pct"] = setup.feed->builder_name() == "lazy" ? 100.0 : 0.0;
    report["frame_ms"] = to_json(spread_of(setup.feed->build_ms()));
    report["stages_ms"] = {{"read", spread_of(setup.feed->read_ms()).p50},
                           {"build", spread_of(setup.feed->build_ms()).p50}};
    return report;
}

/// On the wall clock where the run is live; a replay is always offline.
Result<void> run_session(TouchSetup& s, bool replay, std::span<TouchSink* const> sinks, LoopFacts& loop) {
    if (!s.live || replay) return TouchSession(s.scene, *s.feed, *s.hand, *s.solver, s.settings).run(sinks);
    HandPort hand(*s.hand);
    std::optional<SimulatedPort> device;
    if (s.device) {
        if (auto opened = s.device->open(); !opened.ok()) return opened;
        device.emplace(*s.hand, *s.device, s.workspace);
    }
    HapticPort& port = device ? static_cast<HapticPort&>(*device) : hand;
    LiveSession session(s.scene, *s.feed, *s.hand, port, *s.solver, s.settings);
    auto ran = session.run(sinks);
    loop = session.facts();
    // Why the device stopped, it knows best.
    if (loop.port_failed && s.device)
        if (auto healthy = s.device->health(); !healthy.ok()) return healthy;
    return ran;
}

/// Every file the run reads, and every file it is to write.
Result<void> check_outputs(const TouchOptions& options, const TouchSetup& setup) {
    std::vector<NamedFile> outputs, inputs{{"the clip", setup.clip}};
    const auto add = [](std::vector<NamedFile>& files, const char* name,
                        const std::optional<std::filesystem::path>& path) {
        if (path) files.push_back({name, *path});
    };
    add(inputs, "--scene", setup.scene_file);
    add(inputs, "--replay", options.replay);
    if (setup.hand_words.starts_with("csv:")) {
        // A file's name may hold ':': keys begin after the last one that is followed by a '='.
        const std::string words = setup.hand_words.substr(4);
        const std::size_t equals = words.find('=');
        const std::size_t keys = equals == std::string::npos ? equals : words.rfind(':', equals);
        inputs.push_back({"the hand's file", words.substr(0, keys)});
    }
    add(outputs, "--forces", options.forces);
    add(outputs, "--record", options.record);
    add(outputs, "--json", options.json);
    add(outputs, "--picture", options.picture.file);
    return keep_outputs_apart(outputs, inputs);
}

/// What a replay found; the recorded frames and forces against these.
Result<void> judge_replay(const Recording& recording, const ReplayCheck& check, const TouchSetup& setup,
                          const std::string& force_hash) {
    const auto hash = recording.facts.at("force_hash").get<std::string>();
    const bool other_frames = recording.facts.at("planes_hash") != setup.feed->planes_hash();
    if (!check.difference() && hash == force_hash) {
        std::cout << "replay: every force is as recorded, to the bit (" << hash << ")\n";
        return {};
    }
    const std::string what = check.difference().value_or("force_hash " + force_hash + ", recorded " + hash);
    return Error{ErrorKind::check, "replay differs first at " + what +
                                       (other_frames ? "; the clip's frames are not the recorded ones" : "")};
}

}  // namespace

Result<void> run_touch(const TouchOptions& options) {
    if (auto checked = check_gpu_options(options.builder, options.picture.draws_on_gpu()); !checked.ok())
        return checked;
    std::optional<Recording> recording;
    if (options.replay) {
        auto read = read_recording(*options.replay);
        if (!read.ok()) return read.error();
        recording = std::move(*read);
    }
    auto setup = recording ? setup_from_recording(*recording, options) : setup_from_options(options);
    if (!setup.ok()) return setup.error();
    TouchSetup& s = **setup;
    if (auto apart = check_outputs(options, s); !apart.ok()) return apart;

    TouchFigures figures;
    std::vector<TouchSink*> sinks{&figures};
    std::unique_ptr<ForcesFile> forces;
    if (options.forces) {
        auto created = ForcesFile::create(*options.forces);
        if (!created.ok()) return created.error();
        forces = std::move(*created);
        sinks.push_back(forces.get());
    }
    std::unique_ptr<RecordingFile> record;
    if (options.record) {
        auto created = RecordingFile::create(*options.record, s.settings.fingers);
        if (!created.ok()) return created.error();
        record = std::move(*created);
        sinks.push_back(record.get());
    }
    std::unique_ptr<OutputFile> json;
    if (options.json) {
        auto created = OutputFile::create("--json", *options.json);
        if (!created.ok()) return created.error();
        json = std::move(*created);
    }
    auto order = order_picture(options.picture, s.builder, *s.gpu);
    if (!order.ok()) return order.error();
    std::optional<TouchPicture> picture;
    if (*order) {
        const std::int64_t moment = options.picture_tick.value_or(usual_picture_tick(s));
        sinks.push_back(&picture.emplace(std::move(**order), moment));
    }
    std::optional<ReplayCheck> check;
    if (recording) sinks.push_back(&check.emplace(*recording));

    LoopFacts loop;
    if (auto ran = run_session(s, recording.has_value(), sinks, loop); !ran.ok()) return ran;

    Json report = make_report(s, figures, s.live && !recording ? &loop : nullptr);
    if (picture) {
        const std::string gpu = picture->painter().gpu_name();
        report["painter"] = picture->painter().name();
        report["painter_device_name"] = gpu.empty() ? cpu_facts().model : gpu;
    }
    std::cout << report_to_text(report);
    if (forces)
        if (auto done = forces->finish(); !done.ok()) return done;
    if (record) {
        Json facts = s.facts();
        facts["planes_hash"] = s.feed->planes_hash();
        facts["force_hash"] = figures.force_hash();
        if (auto done = record->finish(facts); !done.ok()) return done;
    }
    if (json) {
        const std::string text = report.dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
        if (auto written = json->write(text); !written.ok()) return written;
        if (auto done = json->finish(); !done.ok()) return done;
    }
    if (picture)
        if (auto done = picture->finish(s); !done.ok()) return done;
    return recording ? judge_replay(*recording, *check, s, figures.force_hash()) : Result<void>{};
}

}  // namespace touchable
