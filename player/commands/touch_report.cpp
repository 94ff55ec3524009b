// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <vector>

#include "engine/base/words.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/stream/stream_url.hpp"
#include "player/commands/machine_check.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/reports.hpp"

namespace touchable {

using Json = nlohmann::ordered_json;

namespace {

constexpr double bearable_skipped_pct = 1;

void add_live_warnings(const LiveFacts& live, std::int64_t frames, std::int64_t dropped,
                       std::vector<std::string> remarks, std::vector<std::string>& warnings) {
    if (!live.loop.grant.fifo)
        warnings.emplace_back(
            "no real-time scheduling (SCHED_FIFO is not permitted): ticks come late when the machine is "
            "busy");
    const auto skipped = static_cast<double>(live.loop.skipped);
    const double skipped_pct = 100 * skipped / (skipped + static_cast<double>(live.loop.ticks));
    if (skipped_pct > bearable_skipped_pct)
        warnings.push_back(
            formatted("%.1f %% of the ticks were skipped, because others came too late", skipped_pct));
    if (live.late_frames > 0)
        warnings.push_back(std::to_string(live.late_frames) + " of " + std::to_string(frames) +
                           " frames came too late: decoding and building are too slow; touchable convert "
                           "writes a clip that decodes faster");
    for (std::string& remark : remarks) warnings.push_back(std::move(remark));
    if (dropped > 0 && !live.camera)  // a camera drops frames itself
        warnings.push_back(std::to_string(dropped) +
                           " frames were left out, because their time had passed before they were decoded");
}

/// Warnings about a run, a line each: figures that show an unintended run or wrong forces. `live`: nullptr in
/// virtual time. `why_no_position`: why the held device never had a position; empty: it had one, or no device
/// was held.
std::vector<std::string> touch_warnings(const Json& report, const SurfaceFeed& feed, const LiveFacts* live,
                                        const std::string& why_no_position) {
    std::vector<std::string> warnings;
    if (live)
        add_live_warnings(*live, feed.frames(), feed.dropped_frames(), feed.reader().remarks(), warnings);
    else
        warnings = feed.reader().remarks();
    if (!feed.any_valid())
        warnings.emplace_back(
            "100 % of the pixels are invalid: there is no surface; is depth.invalid of the scene right?");
    if (!why_no_position.empty())
        warnings.push_back(why_no_position);
    else if (report.at("contact_ticks") == 0)
        warnings.emplace_back("no finger touched anything");
    return warnings;
}

/// Notes on the clip's end and the hand's remarks after the run.
std::vector<std::string> notes_of_run(const TouchSetup& setup, const TouchFigures& figures) {
    std::vector<std::string> notes;
    if (!setup.scene.hole_stiffness && figures.force_limited_in_holes())
        notes.push_back(
            "walls of missing depth pushed as hard as the device can; hole_stiffness in the scene file makes "
            "them soft");
    const double clip = static_cast<double>(setup.feed->end_ns()) * 1e-9,
                 run = 1e-3 * static_cast<double>(figures.ticks());
    if (setup.options.playback.empty() && setup.feed->ended() && setup.feed->frames() > 1 &&
        run > 1.02 * clip)
        notes.push_back(
            formatted("the clip ends at %.3g s; its last frame stands still until %.3g s", clip, run));
    if (setup.options.held_device && setup.options.held_device->is_over())
        notes.push_back(setup.options.held_device->name() + ": " + setup.options.held_device->prompt() +
                        (setup.options.ticks ? "" : "; the run ends there"));
    if (setup.film)
        notes.push_back("the camera's frames are kept as " + setup.film->file().string() +
                        ", which --replay reads");
    for (const std::string& remark : setup.hand ? setup.hand->remarks() : std::vector<std::string>())
        notes.push_back("hand: " + remark);
    return notes;
}

Json to_json(const StreamFigures& stream) {
    Json json{{"whole", stream.whole},
              {"held", stream.held},
              {"late", stream.late},
              {"lost", stream.lost},
              {"torn", stream.torn},
              {"repeated", stream.repeated},
              {"connections", stream.connections},
              {"delay_ms", stream.delay_ms},
              {"longest_gap_ms", stream.longest_gap_ms}};
    if (stream.levels)
        json["levels"] = {{"full_s", stream.levels->full_s},
                          {"low_s", stream.levels->low_s},
                          {"changes", stream.levels->changes}};
    if (stream.link) json["link"] = to_json(*stream.link);
    return json;
}

void add_live_figures(Json& report, const TouchFigures& figures, const LiveFacts& live,
                      std::int64_t dropped_frames) {
    const auto frames = report["frames"].get<double>();
    report["late_ticks"] = live.loop.late;
    report["skipped_ticks"] = live.loop.skipped;
    report["gaps"] = live.loop.gaps;
    report["late_us"] = to_json(figures.late_us());
    report["late_us_histogram"] = figures.late_histogram();
    report["scheduling"] = live.loop.grant.in_words();
    report["dropped_frames"] = dropped_frames;
    report["interrupted"] = live.interrupted;
    if (live.camera) {
        report["frames_shown"] = live.camera->frames_shown;
        report["exposure_to_force_ms"] = to_json(live.camera->exposure_to_force_ms);
        return;
    }
    report["late_frames"] = live.late_frames;
    report["late_frames_pct"] = frames > 0 ? 100.0 * static_cast<double>(live.late_frames) / frames : 0.0;
}

/// Time of fingers at the device's force limit, mostly caught behind a wall.
std::string limited_words(const Json& report) {
    const auto& limited = report["force_limited"];
    if (limited["finger_ticks"] == 0) return "";
    return formatted("; at the device's limit for %.3f s, at most %.3f s in a row",
                     1e-3 * limited["finger_ticks"].get<double>(),
                     1e-3 * limited["longest_ticks"].get<double>());
}

/// Time of fingers caught behind walls of missing depth.
std::string hole_words(const Json& holes) {
    return formatted("%.3f s behind walls of missing depth (%.1f %% of contact), at most %.3f s in a row",
                     1e-3 * holes["finger_ticks"].get<double>(), holes["contact_pct"].get<double>(),
                     1e-3 * holes["longest_ticks"].get<double>());
}

/// Energy that a surface of uniform stiffness would not create, without that of moving surfaces
/// (docs/solver.md).
std::string energy_words(const Json& report) {
    const double created = report["energy_mj"]["created"], bound = report["energy_mj"]["zoh_bound"],
                 smallest = report["stiffness_limited"]["smallest_n_mm"],
                 largest = report["stiffness_limited"]["largest_n_mm"];
    if (report["energy_mj"].value("of_the_map", false))
        return formatted(
            "%.3g mJ, because the clip is soft here and stiff there (%.3g to %.3g N/mm), as it asks to be; "
            "--stiffness passive takes that away",
            created, smallest, largest);
    return formatted(
        "%.3g mJ came out of the surface, where a real one gives none; holding each force for 1 ms explains "
        "up to %.3g mJ of it",
        created, bound);
}

/// Statistics of the received stream.
std::string stream_words(const Json& stream) {
    const auto count = [&](const char* what) { return std::to_string(stream[what].get<std::int64_t>()); };
    std::string text = count("whole") + " framesets whole, " + count("lost") + " lost, " + count("late") +
                       " late, " + count("torn") + " damaged" +
                       formatted("; held back %.1f ms now, longest gap %.0f ms",
                                 stream["delay_ms"].get<double>(), stream["longest_gap_ms"].get<double>());
    if (stream.contains("levels") && stream["levels"]["changes"] > 0)
        text += formatted("; full level for %.0f s, low one for %.0f s",
                          stream["levels"]["full_s"].get<double>(), stream["levels"]["low_s"].get<double>());
    if (!stream.contains("link")) return text;
    const Json& link = stream["link"];
    return text +
           formatted("; %.0f ms there and back, %.1f %% of the datagrams lost", link["rtt_ms"].get<double>(),
                     100 * link["lost"].get<double>() / std::max(1.0, link["datagrams"].get<double>()));
}

/// Describes a builder without technical terms.
std::string what_it_builds(const std::string& builder) {
    if (builder == "lazy") return "only where fingers are";
    return builder == "vulkan" ? "in whole frames on a GPU" : "in whole frames";
}

/// Figures of a held device.
void add_hand_figures(Json& report, const HandControl::Figures& hand, bool has_motors,
                      const LiveFacts* live) {
    report["device_exerts_force"] = has_motors;
    report["forces_on_ticks"] = has_motors ? hand.exerting : 0;
    report["placeless_ticks"] = hand.placeless;
    if (live) report["longest_device_call_ms"] = live->loop.longest_port_ms;
}

/// Whether more energy was created than the zero-order hold explains, and the clip's varying stiffness
/// explains the rest.
bool gives_energy_by_its_map(const Json& report, const TouchSetup& setup) {
    const auto& energy = report["energy_mj"];
    const auto& stiffness = report["stiffness_limited"];
    return energy["created"] > energy["zoh_bound"] &&
           stiffness["smallest_n_mm"] < stiffness["largest_n_mm"] &&
           setup.options.touch.metric == TouchMetric::world && !setup.options.guard.rise.paid;
}

/// Whether the held device never had a position.
bool was_never_there(const Json& report) {
    return report.contains("placeless_ticks") && report["placeless_ticks"] == report["ticks"];
}

/// A line of a table.
std::string labelled(const char* name, const std::string& value) {
    std::string label = name;
    label.resize(22, ' ');
    return "  " + label + one_line(value) + '\n';
}

std::string force_words(const Json& report) {
    const Json& force = report["force_n"];
    return formatted("%.3f N mean in contact, %.3f N max", force["mean"].get<double>(),
                     force["max"].get<double>()) +
           (force["max_jnd"].is_null()
                ? ""
                : formatted(" (a hand just notices %.2g N of that)", force["max_jnd"].get<double>())) +
           limited_words(report);
}

/// Why fingers in contact had less than the surface's force: a line's label and its words. Empty: they had
/// it.
std::vector<std::pair<const char*, std::string>> missing_force(const Json& report) {
    std::vector<std::pair<const char*, std::string>> lines;
    if (report["held_back_ticks"] != 0)
        lines.emplace_back("held back",
                           formatted("%.3f s of contact with no force or a part of it: forces were off, or "
                                     "the finger had not been free since",
                                     1e-3 * report["held_back_ticks"].get<double>()));
    if (report["waiting_ticks"] != 0)
        lines.emplace_back("began inside",
                           counted(report["waiting_ticks"].get<std::int64_t>(), "tick") +
                               " without force, for a finger that had not been free of the surface; "
                               "--start-buried pushes it out");
    if (report["stale_ticks"] != 0)
        lines.emplace_back("old surface",
                           formatted("%.3f s without force, or with a part of it: the surface was too old, "
                                     "because no newer frame came",
                                     1e-3 * report["stale_ticks"].get<double>()));
    return lines;
}

/// Number of guesses about the clip. Empty: none.
std::string guesses_in_words(const Json& report) {
    const auto guesses = report.value("guesses", std::int64_t{0});
    if (guesses == 0) return "";
    return "; " + counted(guesses, "thing is", "things are") +
           " guessed of the clip (touchable info says which)";
}

/// Empty: a scripted hand never lifted a finger.
std::string hops_in_words(const Json& report) {
    const auto hops = report["hops"].get<std::int64_t>();
    return hops == 0 ? "" : ", " + counted(hops, "hop") + " over edges and rough ground";
}

/// A window may have more fingers than are moved: "led of all".
std::string fingers_in_words(const Json& report) {
    const auto fingers = report["fingers"].get<int>(), led = report["fingers_led"].get<int>();
    return (led == 0 || led == fingers ? "" : std::to_string(led) + " of ") + std::to_string(fingers);
}

/// Result of the run's checks.
std::string verdict_words(const Json& report) {
    std::string faults;
    const auto add = [&](const std::string& words) { faults += (faults.empty() ? "" : "; ") + words; };
    const auto count = [&](const char* name, const char* words) {
        if (report[name] != 0) add(counted(report[name].get<std::int64_t>(), "tick") + words);
    };
    count("nonfinite_ticks", " without a finite force");
    count("proxy_behind_mesh_ticks", " with a finger behind the surface");
    count("capped_ticks", " that met more edges than a tick can follow");
    count("late_ticks", " late by 1 ms or more");
    if (!report.value("device_exerts_force", true)) add("the device exerts no force");
    for (const auto& [label, words] : missing_force(report)) add(words);
    return faults.empty() ? "sound: every force is finite, and no finger got behind the surface" : faults;
}

}  // namespace

Json to_json(const StreamFigures::Link& link) {
    return {{"rtt_ms", link.rtt_ms},
            {"datagrams", link.datagrams},
            {"lost", link.lost},
            {"sent_again", link.sent_again}};
}

Json make_report(const TouchSetup& setup, const TouchFigures& figures, const LiveFacts* live,
                 const SurfacePainter* painter) {
    const SessionOptions& options = setup.options;
    const std::string cpu = cpu_facts().model;
    const std::vector<std::string> of_run = notes_of_run(setup, figures);
    std::vector<std::string> notes = remarks_with_options(setup.notes);
    notes.insert(notes.end(), of_run.begin(), of_run.end());
    Json report{
        {"format", 1},
        {"clip", without_passphrase(options.clip.file.string())},
        {"notes", notes},
        {"guesses", std::ranges::count(setup.notes, true, &Remark::is_guess)},
        {"run_notes", of_run},
        {"filters",
         filters_json(setup.scene, setup.filters, setup.filters ? setup.filters->measured : std::nullopt)},
        {"hand", options.hand},
        {"builder", setup.feed->builder_name()},
        {"builder_why", setup.feed->builder_name() == options.builder.name ? options.builder.why : ""},
        {"device_name", setup.feed->builder_name() == "vulkan" ? options.gpu->name() : cpu},
        {"cpu_name", cpu},
        {"width", setup.scene.width},
        {"height", setup.scene.height},
        {"frames", setup.feed->frames()},
        {"fingers", options.fingers},
        {"device_metres_per_metre", options.touch.metres_per_scene_unit / setup.scene.metres_per_unit}};
    report.update(figures.to_json());
    report["energy_mj"]["of_the_map"] = gives_energy_by_its_map(report, setup);
    if (!options.playback.empty()) report["playback"] = in_words(options.playback);
    report["clock"] = live ? "wall" : "virtual";
    if (options.camera) report["camera"] = *options.camera;
    if (options.device) report["device"] = *options.device;
    if (options.control)
        add_hand_figures(report, options.control->figures(), setup.exerting_control() != nullptr, live);
    if (live) add_live_figures(report, figures, *live, setup.feed->dropped_frames());
    if (const auto stream = setup.feed->reader().stream_figures()) report["stream"] = to_json(*stream);
    report["skipped_tiles_pct"] = 100 * setup.feed->skipped_share();
    const Spread built = setup.feed->build_ms().spread();
    report["frame_ms"] = to_json(built);
    report["stages_ms"] = {{"read", setup.feed->read_ms().spread().mean}, {"build", built.p50}};
    if (painter) {
        const std::string gpu = painter->gpu_name();
        report["painter"] = painter->name();
        report["painter_device_name"] = gpu.empty() ? cpu : gpu;
    }
    const bool is_absent = options.control && was_never_there(report);
    report["warnings"] = touch_warnings(report, *setup.feed, live,
                                        is_absent ? options.held_device->why_no_position() : std::string());
    for (const Remark& remark : setup.notes)
        if (remark.kind == RemarkKind::unit_doubt) report["warnings"].push_back(remark_with_options(remark));
    return report;
}

Json join_reports(const std::vector<Json>& parts, const TouchFigures& all) {
    Json report{{"format", 1}, {"clip", parts.front().at("clip")}, {"fingers", parts.front().at("fingers")}};
    report.update(all.to_json());
    std::vector<std::string> warnings;
    for (std::size_t k = 0; k < parts.size(); ++k)
        for (const auto& warning : parts[k].at("warnings"))
            warnings.push_back("part " + std::to_string(k + 1) + ": " + warning.get<std::string>());
    report["warnings"] = warnings;
    report["parts"] = parts;
    return report;
}

std::string report_in_short(const Json& report, const std::optional<std::vector<std::string>>& files) {
    std::string text;
    for (const auto& warning : report["warnings"]) text += labelled("warning", warning.get<std::string>());
    text += labelled("touched", report["clip"].get<std::string>() + ", by " + fingers_in_words(report) +
                                    (report["fingers"] == 1 ? " finger" : " fingers") +
                                    formatted(" for %.3f s, %.1f %% of it in contact",
                                              1e-3 * report["ticks"].get<double>(),
                                              report["finger_contact_pct"].get<double>()) +
                                    hops_in_words(report) + guesses_in_words(report));
    for (const auto& note : report.value("run_notes", std::vector<std::string>()))
        text += labelled("note", note);
    text += labelled("force", force_words(report));
    text += labelled("verdict", verdict_words(report));
    const std::string written = listed(files.value_or(std::vector<std::string>()));
    text += labelled("figures", !files ? "--verbose prints more; --json FILE and --forces FILE write them"
                                : written.empty() ? "--verbose prints them"
                                                  : written + "; --verbose prints them");
    return text;
}

std::string report_to_text(const Json& r) {
    std::string text;
    if (r.contains("parts")) {
        const std::size_t parts = r["parts"].size();
        for (std::size_t k = 0; k < parts; ++k)
            text += "part " + std::to_string(k + 1) + " of " + std::to_string(parts) + '\n' +
                    report_to_text(r["parts"][k]);
        return text;
    }
    auto line = [&text](const char* name, const std::string& value) { text += labelled(name, value); };
    auto number = [](double value, const char* format) { return formatted(format, value); };
    auto count = [&r](const char* name, const char* one = nullptr) {
        const auto amount = r[name].get<std::int64_t>();
        return one ? counted(amount, one) : std::to_string(amount);
    };
    auto spread = [&](const Json& s) {
        return number(s["mean"], "%.3g mean") + number(s["p50"], ", %.3g median") +
               number(s["p99"], ", %.3g p99") + number(s["max"], ", %.3g max");
    };
    for (const auto& warning : r["warnings"]) line("warning", warning.get<std::string>());
    line("clip", r["clip"].get<std::string>() + ", " + count("width") + "x" + count("height") + ", " +
                     count("frames", "frame"));
    for (const auto& note : r["notes"]) line("note", note.get<std::string>());
    if (r.contains("camera")) line("camera", r["camera"].get<std::string>());
    if (r.contains("playback")) line("playback", r["playback"].get<std::string>() + " (seconds, command)");
    line("filters", r["filters"]["in_words"].get<std::string>());
    const auto why = r["builder_why"].get<std::string>();
    const auto builder = r["builder"].get<std::string>();
    line("surface", "built " + what_it_builds(builder) + " (" + builder + " builder, " +
                        r["device_name"].get<std::string>() + ")" + (why.empty() ? "" : ": " + why));
    const auto hand = r["hand"].get<std::string>(), device = r.value("device", hand);
    line("fingers", fingers_in_words(r) + ", " + hand + (device == hand ? "" : " with " + device));
    if (r.contains("forces_on_ticks"))
        line("device", (r["device_exerts_force"] == true
                            ? number(r["forces_on_ticks"].get<double>() / 1000, "forces on for %.3f s; ")
                            : std::string("exerts no force; ")) +
                           number(r["placeless_ticks"].get<double>() / 1000, "no position for %.3f s"));
    if (r.contains("longest_device_call_ms"))
        line("device calls", number(r["longest_device_call_ms"], "longest %.3g ms of a tick, ") +
                                 "to read positions and write forces");
    line("scale", number(1 / r["device_metres_per_metre"].get<double>(),
                         "the hand moves 1 m over %.3g m of the scene"));
    line("ticks", count("ticks") + " at 1 kHz, " + count("contact_ticks") + " with contact (" +
                      number(r["finger_contact_pct"], "%.1f %% of each finger's)") + hops_in_words(r));
    line("force", force_words(r));
    if (r["hole_contact"]["finger_ticks"] > 0) line("caught in holes", hole_words(r["hole_contact"]));
    if (!was_never_there(r))
        line("guard", count("guarded_ticks", "tick") + " changed by it" +
                          (r.value("placeless_ticks", 0) > 0 ? ", those without a position among them" : ""));
    for (const auto& [label, words] : missing_force(r)) line(label, words);
    const auto& limited = r["stiffness_limited"];
    line("stiffness", number(limited["largest_n_mm"], "%.3g N/mm at most in the clip; limited in ") +
                          counted(limited["ticks"].get<std::int64_t>(), "tick"));
    line("energy from nowhere", energy_words(r));
    line("behind the surface", count("proxy_behind_mesh_ticks", "tick"));
    line("not finite", count("nonfinite_ticks", "tick"));
    line("event limit reached", count("capped_ticks", "tick"));
    line("time per tick", spread(r["tick_us"]) + " us, all fingers");
    if (r["clock"] == "wall")
        line("on the wall clock",
             count("late_ticks", "tick") + " late by 1 ms or more, " + count("skipped_ticks") + " skipped" +
                 (r["gaps"] == 0 ? "" : ", with " + count("gaps", "gap") + " of over 50 ms") + "; began " +
                 spread(r["late_us"]) + " us after their time; " + r["scheduling"].get<std::string>());
    if (r.contains("late_frames"))
        line("frames too late", count("late_frames") + " of " + count("frames") +
                                    number(r["late_frames_pct"], " (%.1f %%), ") + count("dropped_frames") +
                                    " left out" +
                                    (r["late_frames"] == 0 ? "" : "; decoding and building are too slow"));
    if (r.contains("exposure_to_force_ms")) {
        if (r.contains("stream")) line("stream", stream_words(r["stream"]));
        line("camera's frames", count("frames_shown") + " felt, " + count("dropped_frames") + " left out");
        line("exposure to force", spread(r["exposure_to_force_ms"]) + " ms");
    }
    const char* reading = r.contains("exposure_to_force_ms")
                              ? "%.3g ms mean waiting for the camera; surface "
                              : "%.3g ms mean waiting for a decoded one; surface ";
    line("time per frame", number(r["stages_ms"]["read"], reading) + spread(r["frame_ms"]) + " ms");
    line("force hash", r["force_hash"].get<std::string>());
    return text;
}

}  // namespace touchable
