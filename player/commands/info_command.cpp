// SPDX-License-Identifier: Apache-2.0
#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/base/hand_thresholds.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/mpeg4/clip_scene.hpp"
#include "engine/scene/filter_codes.hpp"
#include "engine/surface/depth_estimator.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/reports.hpp"
#include "player/run/terminal.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {
namespace {

using Json = nlohmann::ordered_json;

const char* kind_name(DepthCodingKind kind) {
    constexpr const char* names[] = {"linear", "inverse", "metric", "hue", "log"};
    return names[static_cast<std::size_t>(kind)];
}

/// The quantity that codes divide evenly, unless it is depth.
std::string values_of(const DepthCoding& coding) {
    if (coding.kind == DepthCodingKind::inverse) return " (1/depth)";
    if (coding.kind != DepthCodingKind::log) return "";
    return formatted(" (ln(depth + %g))", coding.shift);
}

std::string coding_words(const DepthCoding& coding) {
    std::string words = coding.kind == DepthCodingKind::metric
                            ? formatted("metric, %g units a code", coding.scale)
                            : kind_name(coding.kind) + values_of(coding) +
                                  " between two planes, largest code at the " +
                                  (coding.near_is_high ? "near" : "far") + " one";
    if (coding.kind == DepthCodingKind::hue)
        words += ", no depth where R + G + B < " + std::to_string(coding.least_sum);
    return words + (coding.semantics == DepthSemantics::range ? "; range along the pixel's ray"
                                                              : "; planar, along -Z");
}

/// "400..4400 without 1000".
std::string valid_words(const DepthCoding& coding) {
    std::string words = std::to_string(coding.valid_min) + ".." + std::to_string(coding.valid_max);
    const char* separator = " without ";
    for (int k = 0; k < coding.invalid_code_count; ++k) {
        const std::uint16_t code = coding.invalid_codes[static_cast<std::size_t>(k)];
        if (code < coding.valid_min || code > coding.valid_max) continue;
        words += separator + std::to_string(code);
        separator = ", ";
    }
    return words;
}

std::string range_words(const PropertyRange& range) {
    return formatted("%g..%g", range.min, range.max);
}

/// The scene with measured levels, as used by terrace removal.
Scene with_levels(const ClipFacts& facts) {
    Scene scene = facts.scene;
    if (facts.measured) scene.filter.levels = facts.measured->levels;
    return scene;
}

/// Level spacing, and the reason if the steps remain.
std::string level_words(const ClipFacts& facts) {
    if (!facts.measured) return "not known: no pixel of the first frames is valid";
    const std::string words = levels_in_words(*facts.measured, facts.scene.metres_per_unit);
    if (!has_working_codes(with_levels(facts))) return words + "; codes leave no room for finer ones";
    const bool left = facts.scene.filter.terraces == TerraceRemoval::off;
    return words + (left && removal_advised(*facts.measured, facts.scene)
                        ? "; --terraces auto removes their steps"
                        : "");
}

/// The same as JSON.
Json terraces_json(const ClipFacts& facts) {
    const Scene scene = with_levels(facts);
    const auto working = working_codes(scene);
    const double stored = scene.depth.valid_max - scene.depth.valid_min;
    return {
        {"finer_codes", working ? 2.0 * (working->coding.valid_max - working->coding.valid_min) / stored : 0},
        {"advised", facts.measured && removal_advised(*facts.measured, facts.scene)}};
}

/// A point between smooth and as recorded (FilterSet::detail).
struct Detail {
    double detail = 0;        // 0 to 1
    std::string filters;      // in words
    double left_deg = 0;      // lean of smooth places to and fro, RMS
    double least_relief = 0;  // of which 80 % are kept, scene units; 0: any; infinity: none
    bool is_in_effect = false;
};

/// All points of a clip, from as recorded on; fewer after a stop request. Empty: nothing was tried.
std::vector<Detail> details_of(const ClipFacts& facts) {
    std::vector<Detail> details;
    if (!facts.measured || !facts.measured->patches) return details;
    const Scene& scene = facts.scene;
    const MeasuredDepth& measured = *facts.measured;
    const auto points = frontier(measured.tried, measured.is_noisy(scene.width));
    const TriedFilters* const now = found_among(measured.tried, scene.filter);
    double relief = 0;
    for (std::size_t k = 0; k < points.size() && points.size() > 1 && !stop_requested(); ++k) {
        const TriedFilters& point = *points[k];
        std::vector<std::string> filters;
        if (point.median > 0) filters.push_back(formatted("median %dx%d", point.median, point.median));
        if (point.temporal) filters.emplace_back("temporal");
        const double level = point.levels.at(measured.median) * scene.metres_per_unit * 1000;
        if (point.terraces)
            filters.push_back("terraces" + (level > 0 ? formatted(" %.3g mm apart", level) : ""));
        relief = std::max(relief, least_relief(*measured.patches, point, measured.noise));
        details.push_back({1 - static_cast<double>(k) / static_cast<double>(points.size() - 1),
                           filters.empty() ? "as recorded" : listed(filters), point.left_deg, relief,
                           &point == now});
    }
    return details;
}

Json details_json(const std::vector<Detail>& details) {
    Json out = Json::array();
    for (const Detail& point : details)
        out.push_back({{"detail", point.detail},
                       {"filters", point.filters},
                       {"left_degrees", point.left_deg},
                       {"left_jnd", direction_jnd(point.left_deg)},
                       {"least_relief", point.least_relief},
                       {"in_effect", point.is_in_effect}});
    return out;
}

double mm_per_unit(const Scene& scene) {
    return scene.metres_per_unit * 1000.0;
}

Json range_json(const PropertyRange& range) {
    return Json::array({range.min, range.max});
}

Json tracks_json(const std::vector<TrackInfo>& tracks) {
    Json out = Json::array();
    for (const TrackInfo& track : tracks)
        out.push_back({{"role", track.role},
                       {"codec", track.codec},
                       {"lossless", track.lossless},
                       {"pixel_format", track.pixel_format},
                       {"width", track.width},
                       {"height", track.height}});
    return out;
}

Json camera_json(const ClipFacts& facts) {
    const Camera& camera = facts.scene.camera;
    return {{"fx", camera.fx},
            {"fy", camera.fy},
            {"cx", camera.cx},
            {"cy", camera.cy},
            {"fov_x_degrees", facts.fov_x_degrees},
            {"fov_y_degrees", facts.fov_y_degrees}};
}

Json depth_json(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    Json depth{{"kind", kind_name(coding.kind)},
               {"semantics", coding.semantics == DepthSemantics::range ? "range" : "planar"},
               {"description", coding_words(coding)}};
    if (coding.kind == DepthCodingKind::metric)
        depth["scale"] = coding.scale;
    else
        depth["near_is_high"] = coding.near_is_high;
    depth["near"] = coding.near;
    depth["far"] = coding.far;
    depth["near_mm"] = coding.near * mm_per_unit(scene);
    depth["far_mm"] = coding.far * mm_per_unit(scene);
    depth["bits"] = scene.depth_bits;
    depth["code_max"] = coding.code_max;
    if (coding.kind == DepthCodingKind::log || coding.shift != 0) depth["shift"] = coding.shift;
    if (coding.kind == DepthCodingKind::hue) depth["least_sum"] = coding.least_sum;
    depth["valid_codes"] = {coding.valid_min, coding.valid_max};
    depth["invalid_codes"] = Json::array();
    for (int k = 0; k < coding.invalid_code_count; ++k)
        depth["invalid_codes"].push_back(coding.invalid_codes[static_cast<std::size_t>(k)]);
    return depth;
}

Json kappa_json(const ClipFacts& facts) {
    const auto one = [](const Kappa& k) { return Json{{"depth", k.depth}, {"kappa", k.kappa}}; };
    return {{"near", one(facts.near)}, {"mid", one(facts.mid)}, {"far", one(facts.far)}};
}

/// Ranges of the touch planes; for a clip without a haptic plane its default properties.
void add_touch(const ClipFacts& facts, Json& out) {
    const Scene& scene = facts.scene;
    if (facts.has_track("haptic"))
        out["haptic"] = {{"stiffness_n_per_mm", range_json(scene.haptic.stiffness)},
                         {"static_friction", range_json(scene.haptic.static_friction)},
                         {"dynamic_friction", range_json(scene.haptic.dynamic_friction)}};
    else
        out["default_properties"] = {{"stiffness_n_per_m", scene.default_properties.stiffness},
                                     {"static_friction", scene.default_properties.static_friction},
                                     {"dynamic_friction", scene.default_properties.dynamic_friction}};
    if (scene.hole_stiffness) out["hole_stiffness_n_per_mm"] = *scene.hole_stiffness;
    if (facts.has_track("height"))
        out["height_coding"] = {
            {"max_height", scene.height_coding.max_height},
            {"units", scene.height_coding.units == HeightUnits::levels ? "levels" : "world"},
            {"code_max", scene.height_coding.code_max},
            {"largest", largest_height(scene.height_coding, scene.depth)}};
}

/// Begins a line of a text report.
std::ostream& line(std::ostream& out, const std::string& label) {
    return out << "  " << label << std::string(13 - label.size(), ' ');
}

/// Smallest and largest gap between frames that have their own times.
struct GapsMs {
    double least, most;
};
std::optional<GapsMs> gaps_ms(const FrameRate& rate) {
    if (!rate.own_times) return {};
    const auto& times_ns = *rate.own_times;
    std::int64_t least = std::numeric_limits<std::int64_t>::max(), most = 0;
    for (std::size_t n = 1; n < times_ns.size(); ++n) {
        least = std::min(least, times_ns[n] - times_ns[n - 1]);
        most = std::max(most, times_ns[n] - times_ns[n - 1]);
    }
    return GapsMs{static_cast<double>(least) * 1e-6, static_cast<double>(most) * 1e-6};
}

void tell_picture(const ClipFacts& facts, std::ostream& out) {
    const Scene& scene = facts.scene;
    line(out, "picture") << scene.width << "x" << scene.height << " pixels, ";
    if (facts.frames) out << counted(*facts.frames, "frame") << ", ";
    out << scene.rate.per_second() << " frames/s";
    if (const auto gaps = gaps_ms(scene.rate))
        out << " on average, each at its own time (" << gaps->least << " to " << gaps->most
            << " ms after the one before)";
    if (facts.frames) out << ", " << static_cast<double>(scene.rate.time_ns(*facts.frames)) * 1e-9 << " s";
    out << '\n';
    for (const TrackInfo& track : facts.tracks)
        line(out, "track") << track.role << ": " << track.codec << (track.lossless ? " without loss" : "")
                           << ", " << track.pixel_format << ", " << track.width << "x" << track.height
                           << '\n';
    const Camera& camera = scene.camera;
    line(out, "camera") << "fx " << camera.fx << ", fy " << camera.fy << ", cx " << camera.cx << ", cy "
                        << camera.cy << " pixels; field of view " << facts.fov_x_degrees << " x "
                        << facts.fov_y_degrees << " degrees\n";
    if (scene.path)
        line(out, "camera path") << scene.path->known() << " frames, a way of "
                                 << scene.path->length() * scene.metres_per_unit << " m\n";
}

void tell_depth(const ClipFacts& facts, const std::vector<Detail>& details, std::ostream& out) {
    const Scene& scene = facts.scene;
    const DepthCoding& coding = scene.depth;
    const double mm = mm_per_unit(scene);
    line(out, "depth") << coding_words(coding) << '\n';
    line(out, "codes") << (coding.kind == DepthCodingKind::hue ? "3 x " : "") << scene.depth_bits
                       << " bits, 0.." << coding.code_max << ", of which valid " << valid_words(coding)
                       << '\n';
    line(out, "range") << coding.near << ".." << coding.far << " units = " << coding.near * mm << ".."
                       << coding.far * mm << " mm\n";
    line(out, "first frame") << "depths " << facts.nearest << ".." << facts.farthest << " units, "
                             << facts.invalid_pct << " % of the pixels invalid\n";
    line(out, "kappa") << facts.near.kappa << " at " << facts.near.depth << ", " << facts.mid.kappa << " at "
                       << facts.mid.depth << ", " << facts.far.kappa << " at " << facts.far.depth
                       << " units ("
                       << (scene.filter.levels == DepthLength{} ? "depth of one code"
                                                                : "distance of two levels")
                       << " / width of a pixel)\n";
    line(out, "filters") << filters_in_words(scene, facts.chosen) << '\n';
    for (const Detail& point : details)
        line(out, "detail") << formatted("%.2g: leans ", point.detail) << short_number(point.left_deg, 2)
                            << " degrees (" << short_number(direction_jnd(point.left_deg), 2)
                            << " times what is just noticed), keeps "
                            << (point.least_relief == 0 ? "all relief"
                                : std::isfinite(point.least_relief)
                                    ? "relief from " + short_number(point.least_relief * mm, 2) + " mm on"
                                    : "hardly any relief")
                            << ": " << point.filters << (point.is_in_effect ? " (in effect)" : "") << '\n';
    line(out, "levels") << level_words(facts) << '\n';
    if (const auto& bars = facts.error_degrees; bars && facts.bars_hold)
        line(out, "error") << "95 of 100 forces err by less than " << short_number((*bars)[1], 2)
                           << " degrees at half of the places (" << direction_jnd_words((*bars)[1]) << "), "
                           << short_number((*bars)[0], 2) << " at the best tenth\n";
    if (facts.measured) line(out, "noise") << noise_in_words(*facts.measured, scene.metres_per_unit) << '\n';
    line(out, "in between") << (scene.interpolation == FrameInterpolation::hold ? "hold the earlier frame"
                                                                                : "linear between two frames")
                            << '\n';
}

/// For a clip without a haptic plane, a note states its properties.
void tell_touch(const ClipFacts& facts, std::ostream& out) {
    const Scene& scene = facts.scene;
    if (facts.has_track("haptic"))
        line(out, "touch") << "per pixel: stiffness " << range_words(scene.haptic.stiffness)
                           << " N/mm, friction " << range_words(scene.haptic.static_friction) << " static, "
                           << range_words(scene.haptic.dynamic_friction) << " dynamic\n";
    if (scene.hole_stiffness)
        line(out, "holes") << "walls of missing depth have " << *scene.hole_stiffness << " N/mm\n";
    if (facts.has_track("height"))
        line(out, "height") << "up to " << scene.height_coding.max_height
                            << (scene.height_coding.units == HeightUnits::levels ? " level" : " scene unit")
                            << (scene.height_coding.max_height == 1 ? " = " : "s = ")
                            << largest_height(scene.height_coding, scene.depth) * mm_per_unit(scene)
                            << " mm of the scene\n";
}

Json to_json(const ClipFacts& facts, const std::vector<Detail>& details) {
    const Scene& scene = facts.scene;
    Json out{{"touchable_info", 1}};
    out["clip"] = facts.clip;
    out["name"] = scene.name;
    out["width"] = scene.width;
    out["height"] = scene.height;
    out["frames"] = facts.frames ? Json(*facts.frames) : Json(nullptr);
    out["rate"] = {{"num", scene.rate.num}, {"den", scene.rate.den}};
    if (const auto gaps = gaps_ms(scene.rate)) out["frame_ms"] = {gaps->least, gaps->most};
    out["tracks"] = tracks_json(facts.tracks);
    out["metres_per_unit"] = scene.metres_per_unit;
    out["camera"] = camera_json(facts);
    out["depth"] = depth_json(scene);
    out["first_frame"] = {
        {"invalid_pct", facts.invalid_pct}, {"nearest", facts.nearest}, {"farthest", facts.farthest}};
    out["kappa"] = kappa_json(facts);
    if (const auto& bars = facts.error_degrees; bars && facts.bars_hold)
        out["error_degrees"] = {{"tenth", (*bars)[0]}, {"half", (*bars)[1]}, {"nine_tenths", (*bars)[2]}};
    out["filters"] = filters_json(scene, facts.chosen, facts.measured);
    out["filters"]["details"] = details_json(details);
    out["terraces"] = terraces_json(facts);
    out["interpolation"] = scene.interpolation == FrameInterpolation::hold ? "hold" : "linear";
    add_touch(facts, out);
    out["notes"] = facts.notes;
    return out;
}

/// The same as text, one fact per line.
std::string to_text(const ClipFacts& facts, const std::vector<Detail>& details) {
    std::ostringstream out;
    out << one_line(facts.clip) << (facts.scene.name.empty() ? "" : ": ") << printable(facts.scene.name)
        << '\n';
    tell_picture(facts, out);
    tell_depth(facts, details, out);
    tell_touch(facts, out);
    for (const std::string& note : facts.notes) line(out, "note") << one_line(note) << '\n';
    return out.str();
}

/// The clip's scene as an MPEG-4 text, after comments on what MPEG-4 cannot express.
std::string mpeg4_text(const ClipFacts& facts) {
    const mpeg4::ClipNodes::Streams streams{facts.has_track("colour"), facts.has_track("haptic"),
                                            facts.has_track("height")};
    std::string text;
    for (const std::string& unsaid : mpeg4::unsaid_by_nodes(facts.scene, streams))
        text += "# An MPEG-4 scene cannot say: " + unsaid + '\n';
    const mpeg4::ClipNodes nodes = mpeg4::nodes_from(facts.scene, streams);
    return text + mpeg4::scene_text(mpeg4::scene_of(nodes, facts.scene.width, facts.scene.height));
}

struct InfoOptions {
    ClipChoice clip;
    JsonOutput json;
    bool scene_text = false, verify = false;
    VerifyPicture picture;
};

/// Prints a clip's facts, as text or as one JSON object.
Result<void> print_facts(const InfoOptions& options) {
    TRY(options.json.check(
        {{"the clip", options.clip.file}, {"--scene", options.clip.scene_file.value_or("")}}));
    TRY_ASSIGN(const auto facts, clip_facts(options.clip));
    const std::vector<Detail> details = details_of(facts);
    if (stop_requested()) return interrupted_error();
    std::optional<Verified> verified;
    if (options.verify) TRY(assign(verified, verify_clip(options.clip, facts, options.picture)));
    const std::string verdict = verdict_on(facts, verified ? &verified->findings : nullptr);
    if (options.scene_text) {
        std::cout << mpeg4_text(facts);
    } else if (!options.json.replaces_words()) {
        std::cout << on_terminal(to_text(facts, details) + (verified ? verified_in_words(*verified) : "") +
                                 "  verdict      " + verdict + '\n');
    }
    Json json = to_json(facts, details);
    if (verified) add_verified(*verified, json);
    json["verdict"] = verdict;
    return options.json.write(json);
}

}  // namespace

void add_info_command(CLI::App& app, Command& command) {
    auto* info =
        app.add_subcommand("info", "say what a clip is: size, rate, camera, depth coding, touch, error");
    struct Typed {
        InfoOptions options;
        ClipTyped clip;
    };
    auto typed = std::make_shared<Typed>();
    InfoOptions& options = typed->options;
    add_clip_options(*info, typed->clip)->required();
    begin_topic(*info, "Facts");
    auto* as_json = add_json_option(*info, options.json.file, "print the same facts as JSON");
    auto* as_text = info->add_flag("--scene-text", options.scene_text,
                                   "print only the text of its MPEG-4 scene (docs/codecs.md)");
    as_text->excludes(as_json);
    auto* verify = info->add_flag("--verify", options.verify,
                                  "read all of it, and say what would feel wrong and what mends that");
    verify->excludes(as_text);
    add_file_option(*info, "--picture", options.picture.file,
                    "draw the first frame with those places as a PNG, with --verify")
        ->check(ends_in({".png"}, "a picture"))
        ->needs(verify);
    add_overwrite_option(*info, options.picture.existing);
    add_camera_options(*info, typed->clip.camera);
    add_filter_options(*info, typed->clip);
    set_work(*info, command, [typed]() -> Result<void> {
        TRY_ASSIGN(typed->options.clip, read_clip(typed->clip));
        typed->options.json.existing = typed->options.picture.existing;
        return within_memory("the frames of " + typed->options.clip.file.string(),
                             [&] { return print_facts(typed->options); });
    });
}

}  // namespace touchable
