// SPDX-License-Identifier: Apache-2.0
#include "player/session/touch_setup.hpp"

#include <cmath>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/scene/checked_json.hpp"
#include "engine/scene/scene.hpp"
#include "engine/stream/stream_url.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

using Json = nlohmann::ordered_json;
using checked_json::Node;

namespace {

void record_source(const SourceDescription& known, Json& facts) {
    if (const auto& lens = known.intrinsics) {
        facts["intrinsics"] = {lens->fx, lens->fy};
        if (lens->cx && lens->cy)
            facts["intrinsics"].insert(facts["intrinsics"].end(), {*lens->cx, *lens->cy});
        if (lens->width > 0) facts["intrinsics_size"] = {lens->width, lens->height};
        if (lens->fx <= 0) facts["intrinsics_fov"] = {lens->fov_x, lens->fov_y};
        if (!known.file.empty()) facts["intrinsics_file"] = known.file.filename().string();
    }
    for (const SourceSetting& setting : source_settings())
        if (const auto value = setting.get(known))
            std::visit([&](const auto& stated) { facts[std::string(setting.name)] = stated; }, *value);
}

}  // namespace

Json recorded_facts(const TouchSetup& setup, const std::string& force_hash) {
    const SessionOptions& options = setup.options;
    const TouchSettings& touch = options.touch;
    const GuardSettings& guard = options.guard;
    const ClipChoice& clip = options.clip;
    Json facts{{"rules", force_rules},
               {"clip", without_passphrase((setup.film ? setup.film->file() : clip.file).string())},
               {"scene", Json::parse(scene_to_json(setup.scene))},
               {"hand", options.hand},
               {"builder", setup.feed->builder_name()},
               {"clock", options.live ? "wall" : "virtual"},
               {"metric", name_of(touch.metric)},
               {"S", touch.metres_per_scene_unit},
               {"event_limit", touch.event_limit},
               {"stribeck_speed", touch.stribeck_speed},
               {"guard",
                {{"max_force", guard.max_force},
                 {"max_stiffness", guard.max_stiffness},
                 {"ramp_in_ticks", guard.ramp_in_ticks},
                 {"ramp_out_ticks", guard.ramp_out_ticks},
                 {"waits_to_be_free", guard.waits_to_be_free},
                 {"paid_rise", guard.rise.paid},
                 {"damping", guard.damping},
                 {"passivity", guard.passivity}}}};
    if (guard.stale_after_ns > 0) facts["guard"]["stale_after_ns"] = guard.stale_after_ns;
    if (std::isfinite(guard.rise.per_tick)) facts["guard"]["rise_per_tick"] = guard.rise.per_tick;
    const bool says_itself = setup.film || clip.filmed;  // a film has its scene, and maps
    if (clip.scene_file && !says_itself) facts["scene_file"] = clip.scene_file->string();
    if (clip.maps.haptic && !says_itself) facts["haptic"] = clip.maps.haptic->string();
    if (clip.maps.height && !says_itself) facts["height"] = clip.maps.height->string();
    if (clip.alignment != DepthAlignment::automatic && !says_itself)
        facts["align"] = clip.alignment == DepthAlignment::on;
    if (clip.fill_from_motion) facts["fill_from_motion"] = true;
    if (!says_itself) record_source(clip.camera, facts);
    if (options.camera) facts["camera"] = *options.camera;
    if (setup.film)
        for (const CameraCapture::Frame& frame : setup.film->frames())
            facts["filmed"].push_back({frame.number, frame.time_ns});
    if (options.device) facts["device"] = *options.device;
    if (!options.playback.empty()) facts["warm_up_frames"] = setup.warm_up_frames;
    const auto& built = setup.feed->built();
    std::int64_t frames = 0;
    for (const FrameRun& run : built) frames += run.count;
    facts["frames"] = frames;
    if (built != std::vector<FrameRun>{{0, frames}})
        for (const FrameRun& run : built) facts["built"].push_back({run.first, run.count});
    for (const FrameRun& run : setup.feed->dropped())
        facts["dropped"].push_back({run.epoch, run.first, run.count});
    facts["planes_hash"] = setup.feed->planes_hash();
    facts["force_hash"] = force_hash;
    return facts;
}

namespace {

constexpr std::int64_t most_frames = 1'000'000'000;

// Functions that read a Node throw a checked_json::Refusal.

/// Reads a member that may be left out, also as versions without it did: `value` then stays.
template <class Value>
void read_stated(const Node& facts, const char* name, Value& value) {
    if (!facts.has(name)) return;
    if constexpr (std::is_same_v<Value, double>)
        value = facts[name].number();
    else if constexpr (std::is_same_v<Value, bool>)
        value = facts[name].boolean();
    else
        value = facts[name].text();
}

/// The rows of a list, each of so many whole numbers from 0 on.
template <std::size_t size>
std::vector<std::array<std::int64_t, size>> rows_of(const Node& list, const char* right) {
    constexpr auto most = std::numeric_limits<std::int64_t>::max();
    std::vector<std::array<std::int64_t, size>> rows;
    for (const Node& row : list.elements(0, std::numeric_limits<std::size_t>::max(), right)) {
        const auto numbers = row.elements(size, size, right);
        rows.emplace_back();
        for (std::size_t k = 0; k < size; ++k) rows.back()[k] = numbers[k].integer(0, most);
    }
    return rows;
}

/// The lens stated for a depth picture without a scene file.
Intrinsics read_lens(const Node& facts) {
    constexpr const char *right = "two numbers, or four", *pair = "two numbers";
    const auto numbers = facts["intrinsics"].elements(2, 4, right);
    if (numbers.size() == 3) facts["intrinsics"].refuse(right);
    Intrinsics lens{.fx = numbers[0].number(), .fy = numbers[1].number()};
    if (numbers.size() == 4) lens.cx = numbers[2].number();
    if (numbers.size() == 4) lens.cy = numbers[3].number();
    if (facts.has("intrinsics_fov")) {
        const auto seen = facts["intrinsics_fov"].elements(2, 2, pair);
        lens.fov_x = seen[0].number();
        lens.fov_y = seen[1].number();
    }
    if (facts.has("intrinsics_size")) {
        const auto size = facts["intrinsics_size"].elements(2, 2, pair);
        lens.width = size[0].whole();
        lens.height = size[1].whole();
    }
    return lens;
}

/// What was stated of pictures without a scene file.
SourceDescription read_source(const Node& facts) {
    SourceDescription known;
    if (facts.has("intrinsics")) known.intrinsics = read_lens(facts);
    read_stated(facts, "intrinsics_file", known.file);
    for (const SourceSetting& setting : source_settings()) {
        const std::string name(setting.name);
        if (!facts.has(name.c_str())) continue;
        const Node node = facts[name.c_str()];
        const auto value = setting.is_number() ? SourceSetting::Value(node.number()) : node.text();
        if (!setting.state(value, known)) node.refuse(setting.range.in_words());
    }
    return known;
}

std::optional<std::vector<FrameRun>> read_built_frames(const Node& facts) {
    if (!facts.has("built")) {
        if (!facts.has("frames")) return std::nullopt;
        return std::vector<FrameRun>{{0, facts["frames"].integer(1, most_frames)}};
    }
    constexpr const char* right = "pairs of a frame's number and a count";
    std::vector<FrameRun> runs;
    for (const auto& [first, count] : rows_of<2>(facts["built"], right)) {
        if (count < 1) facts["built"].refuse(right);
        runs.push_back({first, count});
    }
    return runs;
}

std::vector<FrameRun> read_dropped_frames(const Node& facts) {
    std::vector<FrameRun> dropped;
    if (!facts.has("dropped")) return dropped;
    constexpr const char* right = "triples of an epoch, a frame's number and a count";
    for (const auto& [epoch, first, count] : rows_of<3>(facts["dropped"], right)) {
        if (count < 1 || first > most_frames || count > most_frames) facts["dropped"].refuse(right);
        dropped.push_back({first, count, static_cast<std::uint64_t>(epoch)});
    }
    return dropped;
}

/// The frames of a camera, in the order of its film.
CameraCapture::Frames read_filmed_frames(const Node& filmed) {
    constexpr const char* right = "pairs of a frame's number and time, each later than the one before";
    CameraCapture::Frames frames;
    for (const auto& [number, time_ns] : rows_of<2>(filmed, right)) {
        const CameraCapture::Frame before = frames.empty() ? CameraCapture::Frame{-1, -1} : frames.back();
        if (number <= before.number || time_ns <= before.time_ns || number > most_frames)
            filmed.refuse(right);
        frames.push_back({number, time_ns});
    }
    return frames;
}

void read_touch(const Node& facts, TouchSettings& touch) {
    const SettingRange& metrics = session_setting("metric")->range;
    const auto metric = metrics.value_of(facts["metric"].text());
    if (!metric) facts["metric"].refuse(metrics.in_words());
    touch.metric = static_cast<TouchMetric>(*metric);
    touch.metres_per_scene_unit = facts["S"].number();
    if (!(touch.metres_per_scene_unit > 0)) facts["S"].refuse("above 0");
    touch.event_limit = facts["event_limit"].whole(1, 1'000'000);
    read_stated(facts, "stribeck_speed", touch.stribeck_speed);
    if (!(touch.stribeck_speed >= 0)) facts["stribeck_speed"].refuse("0 or above");
}

void read_guard(const Node& limits, GuardSettings& guard) {
    guard.max_force = limits["max_force"].number();
    guard.max_stiffness = limits["max_stiffness"].number();
    guard.ramp_in_ticks = limits["ramp_in_ticks"].whole(0, 1'000'000);
    guard.ramp_out_ticks = limits["ramp_out_ticks"].whole(0, 1'000'000);
    read_stated(limits, "waits_to_be_free", guard.waits_to_be_free);
    read_stated(limits, "paid_rise", guard.rise.paid);
    guard.rise.per_tick = std::numeric_limits<double>::infinity();
    read_stated(limits, "rise_per_tick", guard.rise.per_tick);
    read_stated(limits, "damping", guard.damping);
    read_stated(limits, "passivity", guard.passivity);
    guard.stale_after_ns =
        limits.has("stale_after_ns") ? limits["stale_after_ns"].integer(0, 3'600'000'000'000) : 0;
    if (auto checked = check_guard(guard); !checked) throw checked_json::Refusal{checked.error().message};
}

void read_recorded_camera(const Node& facts, SessionOptions& options) {
    options.camera = facts["camera"].text();
    const auto camera = read_live_camera(*options.camera);
    if (!camera) throw checked_json::Refusal{camera.error().message};
    if (camera->plugged)
        options.clip.filmed = read_filmed_frames(facts["filmed"]);
    else
        options.clip.as_camera = camera->delivery;
}

/// Returns the recorded scene as text.
std::string read_facts(const Node& facts, TouchSetup& setup) {
    SessionOptions& options = setup.options;
    ClipChoice& clip = options.clip;
    clip.file = facts["clip"].text();
    read_stated(facts, "scene_file", clip.scene_file);
    clip.camera = read_source(facts);
    read_stated(facts, "haptic", clip.maps.haptic);
    read_stated(facts, "height", clip.maps.height);
    if (facts.has("align"))
        clip.alignment = facts["align"].boolean() ? DepthAlignment::on : DepthAlignment::off;
    read_stated(facts, "fill_from_motion", clip.fill_from_motion);
    options.hand = facts["hand"].text();
    options.live = facts.has("clock") && facts["clock"].text() == "wall";
    if (facts.has("camera")) read_recorded_camera(facts, options);
    read_stated(facts, "device", options.device);
    read_touch(facts, options.touch);
    read_guard(facts["guard"], options.guard);
    if (facts.has("warm_up_frames")) setup.warm_up_frames = facts["warm_up_frames"].whole(0, 1000);
    if (facts.has("rules")) (void)facts["rules"].whole(1, 1'000'000);
    if (facts.has("frames")) (void)facts["frames"].integer(1, most_frames);
    setup.recorded_frames = read_built_frames(facts);
    setup.dropped = read_dropped_frames(facts);
    for (const char* hash : {"planes_hash", "force_hash"}) (void)facts[hash].text();
    if (!facts["scene"].is_object()) facts["scene"].refuse("an object {...}");
    return facts["scene"].json();
}

/// The hash of these frames, in this order; an error if the clip lacks one.
Result<std::string> planes_hash_of(ClipReader& clip, const std::vector<FrameRun>& runs) {
    ByteHash hash;
    for (const FrameRun& run : runs) {
        TRY(clip.seek(run.first));
        for (std::int64_t k = 0; k < run.count; ++k) {
            TRY_ASSIGN(const auto frame, clip.next());
            if (!frame) return input_error("the clip has no frame " + std::to_string(run.first + k));
            add_planes(*frame, hash);
        }
    }
    return hash.hex();
}

}  // namespace

Result<SceneDescription> read_recorded_facts(const Json& facts, const std::string& name, TouchSetup& setup) {
    const checked_json::Json json(facts);
    TRY_ASSIGN(const auto scene, checked_json::checked(name + ": invalid recording header",
                                                       [&] { return read_facts(Node(json, ""), setup); }));
    return parse_scene(scene, name);
}

/// A live session prefetches as many frames as its builder manages, its replay fewer, so the recording states
/// which frames its hash covers. A live recording of a version that did not state them cannot be checked.
bool has_other_frames(const RecordedPart& recording, const TouchSetup& setup) {
    const auto recorded = recording.facts.at("planes_hash").get<std::string>();
    const auto& built = setup.recorded_frames;
    if (!built) return !setup.options.live && recorded != setup.feed->planes_hash();
    if (*built == setup.feed->built()) return recorded != setup.feed->planes_hash();
    const auto reader = setup.options.clip.open(Colour::left_out);
    if (!reader) return true;
    const auto found = planes_hash_of(**reader, *built);
    return !found || *found != recorded;
}

}  // namespace touchable
