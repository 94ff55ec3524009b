#include "player/session/run_record.hpp"

#include <cmath>
#include <cstring>
#include <stdexcept>

#include "engine/base/words.hpp"
#include "engine/scene/scene.hpp"
#include "engine/stream/stream_url.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {

using Json = nlohmann::ordered_json;

Json recorded_facts(const TouchSetup& setup) {
    const TouchSettings& touch = setup.settings.touch;
    const GuardSettings& guard = setup.settings.guard;
    const ClipChoice& clip = setup.clip;
    Json facts{{"rules", force_rules},
               {"clip", without_passphrase((setup.film ? setup.film->file() : clip.file).string())},
               {"scene", Json::parse(scene_to_json(setup.scene))},
               {"hand", setup.hand_words},
               {"builder", setup.feed->builder_name()},
               {"clock", setup.live ? "wall" : "virtual"},
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
    if (const auto& camera = clip.camera; camera && !says_itself) {
        if (const auto& lens = camera->intrinsics) {
            facts["intrinsics"] = {lens->fx, lens->fy};
            if (lens->cx && lens->cy)
                facts["intrinsics"].insert(facts["intrinsics"].end(), {*lens->cx, *lens->cy});
            if (lens->width > 0) facts["intrinsics_size"] = {lens->width, lens->height};
            if (lens->fx <= 0) facts["intrinsics_fov"] = {lens->fov_x, lens->fov_y};
            if (!camera->file.empty()) facts["intrinsics_file"] = camera->file.filename().string();
        }
        if (camera->fov) facts["fov"] = *camera->fov;
        if (camera->metres_per_code) facts["depth_unit"] = *camera->metres_per_code;
        if (camera->semantics)
            facts["depth"] = camera->semantics == DepthSemantics::range ? "range" : "planar";
        if (camera->least_confidence) facts["least_confidence"] = *camera->least_confidence;
        if (!camera->channel.empty()) facts["channel"] = camera->channel;
        if (!camera->dataset.empty()) facts["dataset"] = camera->dataset;
        if (!camera->preset.empty()) facts["preset"] = camera->preset;
    }
    if (!setup.camera_words.empty()) facts["camera"] = setup.camera_words;
    if (setup.film)
        for (const CameraCapture::Frame& frame : setup.film->frames())
            facts["filmed"].push_back({frame.number, frame.time_ns});
    if (!setup.device_words.empty()) facts["device"] = setup.device_words;
    if (!setup.settings.playback.empty()) facts["warm_up_frames"] = setup.warm_up_frames;
    const auto& built = setup.feed->built();
    std::int64_t frames = 0;
    for (const FrameRun& run : built) frames += run.count;
    facts["frames"] = frames;
    if (built != std::vector<FrameRun>{{0, frames}})
        for (const FrameRun& run : built) facts["built"].push_back({run.first, run.count});
    for (const DroppedFrames& run : setup.feed->dropped())
        facts["dropped"].push_back({run.epoch, run.first, run.count});
    facts["planes_hash"] = setup.feed->planes_hash();
    return facts;
}

namespace {

constexpr std::int64_t most_frames = 1'000'000'000;

/// Throws std::out_of_range with the member's name if it is missing or not of `kind`.
template <class Value>
Value member(const Json& facts, const char* name, const char* kind) {
    try {
        return facts.at(name).get<Value>();
    } catch (const Json::exception&) {
        throw std::out_of_range(std::string(name) +
                                (facts.contains(name) ? std::string(" must be ") + kind : " is missing"));
    }
}

std::string text(const Json& facts, const char* name) {
    return member<std::string>(facts, name, "text");
}

double number(const Json& facts, const char* name) {
    return member<double>(facts, name, "a number");
}

/// Recordings of versions without the member have the default.
double number_or(const Json& facts, const char* name, double otherwise) {
    return facts.contains(name) ? number(facts, name) : otherwise;
}

Json object(const Json& facts, const char* name) {
    auto value = member<Json>(facts, name, "an object");
    if (!value.is_object()) throw std::out_of_range(std::string(name) + " must be an object");
    return value;
}

int whole_number(const Json& facts, const char* name, int least, int most) {
    const double value = number(facts, name);
    if (value >= least && value <= most && value == std::floor(value)) return static_cast<int>(value);
    throw std::out_of_range(std::string(name) + " must be a whole number, " + std::to_string(least) + " to " +
                            std::to_string(most));
}

TouchMetric metric_named(const std::string& name) {
    const SettingRange& range = session_setting("metric")->range;
    if (const auto metric = range.value_of(name)) return static_cast<TouchMetric>(*metric);
    throw std::out_of_range("metric must be " + range.in_words());
}

/// The lens stated for a depth picture without a scene file.
Intrinsics intrinsics_of(const Json& facts) {
    const auto numbers = member<std::vector<double>>(facts, "intrinsics", "numbers");
    if (numbers.size() != 2 && numbers.size() != 4)
        throw std::out_of_range("intrinsics must be two numbers, or four");
    Intrinsics lens{.fx = numbers[0], .fy = numbers[1]};
    if (numbers.size() == 4) lens.cx = numbers[2];
    if (numbers.size() == 4) lens.cy = numbers[3];
    if (facts.contains("intrinsics_fov")) {
        const auto seen = member<std::vector<double>>(facts, "intrinsics_fov", "numbers");
        if (seen.size() != 2) throw std::out_of_range("intrinsics_fov must be two numbers");
        lens.fov_x = seen[0];
        lens.fov_y = seen[1];
    }
    if (!facts.contains("intrinsics_size")) return lens;
    const auto size = member<std::vector<int>>(facts, "intrinsics_size", "numbers");
    if (size.size() != 2) throw std::out_of_range("intrinsics_size must be two numbers");
    lens.width = size[0];
    lens.height = size[1];
    return lens;
}

/// The camera settings of pictures without a scene file.
std::optional<SourceDescription> camera_of(const Json& facts) {
    SourceDescription known;
    if (facts.contains("intrinsics")) known.intrinsics = intrinsics_of(facts);
    if (facts.contains("intrinsics_file")) known.file = text(facts, "intrinsics_file");
    if (facts.contains("fov")) known.fov = number(facts, "fov");
    if (facts.contains("depth_unit")) known.metres_per_code = number(facts, "depth_unit");
    if (facts.contains("depth")) {
        const std::string word = text(facts, "depth");
        if (word != "range" && word != "planar") throw std::out_of_range("depth must be range or planar");
        known.semantics = word == "range" ? DepthSemantics::range : DepthSemantics::planar;
    }
    if (facts.contains("least_confidence")) known.least_confidence = number(facts, "least_confidence");
    if (facts.contains("channel")) known.channel = text(facts, "channel");
    if (facts.contains("dataset")) known.dataset = text(facts, "dataset");
    if (facts.contains("preset")) known.preset = text(facts, "preset");
    if (known == SourceDescription()) return std::nullopt;
    return known;
}

std::vector<DroppedFrames> dropped_frames(const Json& facts) {
    std::vector<DroppedFrames> dropped;
    if (!facts.contains("dropped")) return dropped;
    constexpr const char* kind = "triples of an epoch, a frame's number and a count";
    const auto triples = member<std::vector<std::array<std::int64_t, 3>>>(facts, "dropped", kind);
    for (const auto& [epoch, first, count] : triples) {
        if (epoch < 0 || first < 0 || count < 1 || first > most_frames || count > most_frames)
            throw std::out_of_range(std::string("dropped must be ") + kind);
        dropped.push_back({static_cast<std::uint64_t>(epoch), first, count});
    }
    return dropped;
}

/// The frames of a camera, in the order of its film.
CameraCapture::Frames filmed_frames(const Json& facts) {
    constexpr const char* kind = "pairs of a frame's number and time, each later than the one before";
    const auto pairs = member<std::vector<std::array<std::int64_t, 2>>>(facts, "filmed", kind);
    CameraCapture::Frames frames;
    for (const auto& [number, time_ns] : pairs) {
        const CameraCapture::Frame before = frames.empty() ? CameraCapture::Frame{-1, -1} : frames.back();
        if (number <= before.number || time_ns <= before.time_ns || number > most_frames)
            throw std::out_of_range(std::string("filmed must be ") + kind);
        frames.push_back({number, time_ns});
    }
    return frames;
}

/// Throws as `member` does, also if a setting is out of range.
void read_touch(const Json& facts, TouchSettings& touch) {
    touch.metric = metric_named(text(facts, "metric"));
    touch.metres_per_scene_unit = number(facts, "S");
    if (!(touch.metres_per_scene_unit > 0)) throw std::out_of_range("S must be above 0");
    touch.event_limit = whole_number(facts, "event_limit", 1, 1'000'000);
    touch.stribeck_speed = number_or(facts, "stribeck_speed", touch.stribeck_speed);
    if (!(touch.stribeck_speed >= 0)) throw std::out_of_range("stribeck_speed must be 0 or above");
}

/// Throws as read_touch does.
void read_guard(const Json& limits, GuardSettings& guard) {
    guard.max_force = number(limits, "max_force");
    guard.max_stiffness = number(limits, "max_stiffness");
    guard.ramp_in_ticks = whole_number(limits, "ramp_in_ticks", 0, 1'000'000);
    guard.ramp_out_ticks = whole_number(limits, "ramp_out_ticks", 0, 1'000'000);
    if (limits.contains("waits_to_be_free"))
        guard.waits_to_be_free = member<bool>(limits, "waits_to_be_free", "true or false");
    if (limits.contains("paid_rise")) guard.rise.paid = member<bool>(limits, "paid_rise", "true or false");
    guard.rise.per_tick = number_or(limits, "rise_per_tick", guard.rise.per_tick);
    guard.damping = number_or(limits, "damping", guard.damping);
    guard.passivity = number_or(limits, "passivity", guard.passivity);
    const double stale_after_ns = number_or(limits, "stale_after_ns", 0);
    if (!(stale_after_ns >= 0 && stale_after_ns <= 3.6e12))
        throw std::out_of_range("stale_after_ns must be 0 to 3600000000000");
    guard.stale_after_ns = static_cast<std::int64_t>(stale_after_ns);
    if (auto checked = check_guard(guard); !checked) throw std::out_of_range(checked.error().message);
}

/// Throws as read_touch does.
void read_recorded_camera(const Json& facts, TouchSetup& setup) {
    const std::string words = text(facts, "camera");
    const auto camera = read_live_camera(words);
    if (!camera) throw std::out_of_range(camera.error().message);
    setup.camera_words = words;
    if (camera->plugged)
        setup.clip.filmed = filmed_frames(facts);
    else
        setup.clip.as_camera = camera->delivery;
}

/// Returns the recorded scene as text. Throws std::out_of_range if a member is missing, of another kind or
/// out of range.
std::string read_facts(const Json& facts, TouchSetup& setup) {
    setup.clip.file = text(facts, "clip");
    if (facts.contains("scene_file")) setup.clip.scene_file = text(facts, "scene_file");
    setup.clip.camera = camera_of(facts);
    if (facts.contains("haptic")) setup.clip.maps.haptic = text(facts, "haptic");
    if (facts.contains("height")) setup.clip.maps.height = text(facts, "height");
    if (facts.contains("align"))
        setup.clip.alignment =
            member<bool>(facts, "align", "true or false") ? DepthAlignment::on : DepthAlignment::off;
    if (facts.contains("fill_from_motion"))
        setup.clip.fill_from_motion = member<bool>(facts, "fill_from_motion", "true or false");
    setup.hand_words = text(facts, "hand");
    setup.live = facts.contains("clock") && text(facts, "clock") == "wall";
    if (facts.contains("camera")) read_recorded_camera(facts, setup);
    if (facts.contains("device")) setup.device_words = text(facts, "device");
    read_touch(facts, setup.settings.touch);
    read_guard(object(facts, "guard"), setup.settings.guard);
    if (facts.contains("warm_up_frames"))
        setup.warm_up_frames = whole_number(facts, "warm_up_frames", 0, 1000);
    if (facts.contains("rules")) (void)whole_number(facts, "rules", 1, 1'000'000);
    if (facts.contains("frames")) (void)whole_number(facts, "frames", 1, most_frames);
    (void)built_frames(facts);
    setup.dropped = dropped_frames(facts);
    for (const char* hash : {"planes_hash", "force_hash"}) (void)text(facts, hash);
    return object(facts, "scene").dump();
}

bool same_bits(const glm::dvec3& a, const glm::dvec3& b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

std::string to_text(const glm::dvec3& force, std::uint32_t guard) {
    return formatted("(%.17g, %.17g, %.17g) N with guard %u", force.x, force.y, force.z, guard);
}

/// A live session prefetches as many frames as its builder manages, its replay fewer, so the recording states
/// which frames its hash covers. A live recording of a version that did not state them cannot be checked.
bool has_other_frames(const RecordedPart& recording, const TouchSetup& setup) {
    const auto recorded = recording.facts.at("planes_hash").get<std::string>();
    const auto built = built_frames(recording.facts);
    if (!built) return !setup.live && recorded != setup.feed->planes_hash();
    if (*built == setup.feed->built()) return recorded != setup.feed->planes_hash();
    const auto reader = setup.clip.open(Colour::left_out);
    if (!reader) return true;
    const auto found = planes_hash_of(**reader, *built);
    return !found || *found != recorded;
}

std::string in_words(std::uint64_t epoch, std::int64_t prev, std::int64_t next, double blend) {
    std::string words = formatted("between frames %lld and %lld at %.17g", static_cast<long long>(prev),
                                  static_cast<long long>(next), blend);
    if (epoch > 0) words += " of epoch " + std::to_string(epoch);
    return words;
}

}  // namespace

std::optional<std::vector<FrameRun>> built_frames(const Json& facts) {
    std::vector<FrameRun> runs;
    if (!facts.contains("built")) {
        if (!facts.contains("frames")) return std::nullopt;
        return std::vector<FrameRun>{{0, whole_number(facts, "frames", 1, most_frames)}};
    }
    const auto pairs = member<std::vector<std::array<std::int64_t, 2>>>(
        facts, "built", "pairs of a frame's number and a count");
    for (const auto& [first, count] : pairs) {
        if (first < 0 || count < 1)
            throw std::out_of_range("built must be pairs of a frame's number and a count");
        runs.push_back({first, count});
    }
    return runs;
}

Result<SceneDescription> read_recorded_facts(const Json& facts, const std::string& name, TouchSetup& setup) {
    std::string scene;
    try {
        scene = read_facts(facts, setup);
    } catch (const std::exception& fault) {
        return input_error(name + ": invalid recording header: " + fault.what());
    }
    return parse_scene(scene, name);
}

Result<void> ReplayCheck::consume(const TouchTick& tick) {
    if (difference_) return {};
    const RecordedPart::Tick& recorded = recording_.ticks[next_++];
    const std::string where = "tick " + std::to_string(tick.tick);
    if (recorded.frame_prev != tick.pair.prev.number || recorded.frame_next != tick.pair.next.number ||
        recorded.blend != tick.blend || recorded.epoch != tick.pair.epoch) {
        difference_ = where + ": " +
                      in_words(tick.pair.epoch, tick.pair.prev.number, tick.pair.next.number, tick.blend) +
                      ", recorded " +
                      in_words(recorded.epoch, recorded.frame_prev, recorded.frame_next, recorded.blend);
        return {};
    }
    for (std::size_t k = 0; k < tick.forces.size(); ++k) {
        if (same_bits(recorded.forces[k], tick.forces[k].force) &&
            recorded.guards[k] == tick.forces[k].reasons)
            continue;
        difference_ = where + ", finger " + std::to_string(k + 1) + ": force " +
                      to_text(tick.forces[k].force, tick.forces[k].reasons) + ", recorded " +
                      to_text(recorded.forces[k], recorded.guards[k]);
        return {};
    }
    return {};
}

ReplayCheck::Outcome ReplayCheck::outcome(const std::string& force_hash, const TouchSetup& setup) const {
    Outcome part{recording_.rules(), difference_, has_other_frames(recording_, setup)};
    const auto hash = recording_.facts.at("force_hash").get<std::string>();
    if (!part.difference && hash != force_hash)
        part.difference = "force_hash " + force_hash + ", recorded " + hash;
    return part;
}

Result<std::string> judge_replay(std::span<const ReplayCheck::Outcome> parts, const std::string& force_hash) {
    bool others = false;
    for (std::size_t k = 0; k < parts.size(); ++k) {
        const ReplayCheck::Outcome& part = parts[k];
        if (part.rules != force_rules)
            return input_error("replay is not comparable: made under rules " + std::to_string(part.rules) +
                               " of force, this program has rules " + std::to_string(force_rules) +
                               "; what was asked for is written, with its forces");
        others = others || part.has_other_frames;
        const std::string where = parts.size() > 1 ? "part " + std::to_string(k + 1) + ", " : "";
        if (part.difference)
            return Error{ErrorKind::check,
                         "replay differs first at " + where + *part.difference +
                             (part.has_other_frames ? "; the clip's frames are not the recorded ones" : "")};
    }
    const std::string all = parts.size() > 1 ? " in all " + std::to_string(parts.size()) + " parts" : "";
    return "replay: every force is as recorded, to the bit" + all + " (" + force_hash + ")\n" +
           (others ? "note: the clip's frames are not the recorded ones; they differ where no finger "
                     "felt it\n"
                   : "");
}

}  // namespace touchable
