#include "player/commands/touch_setup.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "device/workspace.hpp"
#include "engine/media/clip.hpp"
#include "engine/scene/scene_file.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/force_rules.hpp"
#include "player/commands/replay.hpp"
#include "player/commands/temporal_option.hpp"
#include "player/session/builder_pick.hpp"
#include "player/session/clip_workspace.hpp"
#include "player/session/field_probe.hpp"

namespace touchable {

namespace {

using Json = nlohmann::ordered_json;

// N s/m. Beyond this a hand on a light device no longer slows down within a tick, it is thrown back.
constexpr double most_damping = 100;

Result<void> check_guard(const GuardSettings& guard) {
    if (!(guard.max_force >= 1e-6 && guard.max_force <= 1e9))
        return usage_error("--max-force must be a number from 1e-6 to 1e9 N");
    if (!(guard.max_stiffness >= 1e-3 && guard.max_stiffness <= 1e12))
        return usage_error("--max-stiffness must be a number from 1e-6 to 1e9 N/mm");
    if (!(guard.rise.per_tick > 0))
        return usage_error("--stiffness-slew must be a number above 0 N/mm per second");
    if (!(guard.damping >= 0 && guard.damping <= most_damping))
        return usage_error("--damping must be 0 to 100 N s/m");
    if (!(guard.passivity >= 0 && guard.passivity <= most_damping))
        return usage_error("--passivity must be 0 to 100 N s/m");
    return {};
}

/// The builder that was asked for, or what auto is in this run. A GPU that was named may be a software one,
/// and has to be there whether auto takes it or not.
Result<void> choose_builder(TouchSetup& setup, std::optional<std::int64_t> frames, int fingers,
                            const TouchOptions& options) {
    setup.builder = options.builder;
    if (options.builder.name != "auto") return {};
    const bool named = options.builder.names_gpu();
    if (named)
        if (auto opened = setup.gpu->open(); !opened.ok()) return opened.error();
    const TouchLoad load{setup.scene, frames != 1, fingers, options.live};
    const auto pick = pick_builder(load, [&] {
        const auto device = setup.gpu->open();
        return device.ok() && (named || (*device)->facts().kind != GpuKind::software);
    });
    setup.builder.name = pick.name;
    setup.builder.gpu_fallback = pick.name == "vulkan";  // nobody asked for it
    setup.builder_why = pick.why;
    return {};
}

/// Opens the clip and makes its feed; `recorded` is what the run applies where it is done again.
Result<void> open_feed(TouchSetup& setup, const std::optional<Scene>& recorded, int fingers,
                       const TouchOptions& options) {
    auto reader = setup.open();
    if (!reader.ok()) return reader.error();
    setup.scene = recorded ? *recorded : (*reader)->scene();
    if (!recorded) {
        if (options.median) setup.scene.filter.median = *options.median;
        if (options.fill_holes) setup.scene.filter.fill_holes = *options.fill_holes;
        if (options.terraces) setup.scene.filter.terraces = *options.terraces;
        if (auto applied = apply_temporal(options.temporal, setup.scene.filter); !applied.ok())
            return applied;
        if (options.interpolation) setup.scene.interpolation = *options.interpolation;
        if (auto valid = validate(setup.scene); !valid.ok()) return usage_error(valid.error().message);
    }
    const Scene& stored = (*reader)->scene();
    if (stored.width != setup.scene.width || stored.height != setup.scene.height)
        return input_error(setup.clip.string() + ": is " + std::to_string(stored.width) + "x" +
                           std::to_string(stored.height) + ", the recording was made on " +
                           std::to_string(setup.scene.width) + "x" + std::to_string(setup.scene.height));
    setup.notes = (*reader)->notes();
    setup.gpu = std::make_unique<RunGpu>(options.builder.gpu);
    if (auto chosen = choose_builder(setup, (*reader)->frame_count(), fingers, options); !chosen.ok())
        return chosen;
    auto builder = make_builder(setup.builder, setup.scene, *setup.gpu);
    if (!builder.ok()) return builder.error();
    setup.feed = std::make_unique<SurfaceFeed>(std::move(*reader), std::move(*builder), setup.scene);
    return {};
}

Result<void> hold_device(TouchSetup& setup, const TouchOptions& options) {
    if (!options.device) return {};
    if (!options.live) return usage_error("--device needs --live: a device is held in real time");
    auto device = make_simulated_device(*options.device, options.fingers,
                                        {options.guard.max_force, options.guard.max_stiffness});
    if (!device.ok()) return device.error();
    setup.device = std::move(*device);
    setup.device_words = *options.device;
    return {};
}

Result<void> make_solver(TouchSetup& setup) {
    auto solver = TouchSolver::create(setup.scene, setup.settings.touch);
    if (!solver.ok()) return solver.error();
    setup.solver = *solver;
    return {};
}

}  // namespace

Result<std::unique_ptr<TouchSetup>> setup_from_options(const TouchOptions& options) {
    if (auto checked = check_guard(options.guard); !checked.ok()) return checked.error();
    if (!(options.stribeck_speed >= 0 && std::isfinite(options.stribeck_speed)))
        return usage_error("--stribeck must be a number of m/s, 0 or above");
    if (options.start_buried && !options.live)
        return usage_error("--start-buried needs --live: without it no finger waits to be free");
    auto setup = std::make_unique<TouchSetup>();
    setup->clip = options.clip;
    setup->scene_file = options.scene;
    setup->camera = options.camera;
    setup->hand_words = options.hand;
    if (auto opened = open_feed(*setup, std::nullopt, options.fingers, options); !opened.ok())
        return opened.error();

    const auto first = setup->feed->pair_at(0);
    if (!first.ok()) return first.error();
    const Workspace workspace = clip_workspace(setup->scene, *first->prev.frame);
    const HeightField field(setup->scene, *first);
    auto hand = make_hand(options.hand, options.fingers, workspace, FieldProbe(field));
    if (!hand.ok()) return hand.error();
    setup->hand = std::move(*hand);

    setup->settings.fingers = options.fingers;
    setup->settings.touch.metric = options.metric;
    setup->settings.touch.metres_per_scene_unit = workspace.metres_per_scene_unit;
    setup->settings.touch.stribeck_speed = options.stribeck_speed;
    setup->settings.guard = options.guard;
    setup->settings.guard.waits_to_be_free = options.live && !options.start_buried;
    setup->settings.ticks = options.ticks;
    setup->live = options.live;
    setup->workspace = workspace;
    if (auto held = hold_device(*setup, options); !held.ok()) return held.error();
    if (auto made = make_solver(*setup); !made.ok()) return made.error();
    return setup;
}

Json TouchSetup::facts() const {
    const TouchSettings& touch = settings.touch;
    const GuardSettings& guard = settings.guard;
    Json facts{{"rules", force_rules},
               {"clip", clip.string()},
               {"scene", Json::parse(scene_to_json(scene))},
               {"hand", hand_words},
               {"builder", feed->builder_name()},
               {"clock", live ? "wall" : "virtual"},
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
    if (std::isfinite(guard.rise.per_tick)) facts["guard"]["rise_per_tick"] = guard.rise.per_tick;
    if (scene_file) facts["scene_file"] = scene_file->string();
    if (camera) {
        facts["intrinsics"] = {camera->fx, camera->fy};
        if (camera->cx && camera->cy)
            facts["intrinsics"].insert(facts["intrinsics"].end(), {*camera->cx, *camera->cy});
        facts["depth_unit"] = camera->metres_per_code;
    }
    if (!device_words.empty()) facts["device"] = device_words;
    return facts;
}

namespace {

/// Throws std::out_of_range, with the member's name, where it is missing or no `kind`.
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

/// Of versions that did not know it, the default.
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
    for (const TouchMetric metric : {TouchMetric::world, TouchMetric::pixel, TouchMetric::scaled})
        if (name_of(metric) == name) return metric;
    throw std::out_of_range("metric must be world, pixel or scaled");
}

/// Of a single depth picture, what stood in for its scene file.
std::optional<PictureCamera> camera_of(const Json& facts) {
    if (!facts.contains("intrinsics")) return std::nullopt;
    const auto numbers = member<std::vector<double>>(facts, "intrinsics", "numbers");
    if (numbers.size() != 2 && numbers.size() != 4)
        throw std::out_of_range("intrinsics must be two numbers, or four");
    PictureCamera camera{.fx = numbers[0], .fy = numbers[1]};
    if (numbers.size() == 4) camera.cx = numbers[2];
    if (numbers.size() == 4) camera.cy = numbers[3];
    camera.metres_per_code = number(facts, "depth_unit");
    return camera;
}

/// Reads what `TouchSetup::facts` wrote, and gives the recorded scene. Throws std::out_of_range where
/// something is missing, of another kind or impossible.
Json read_facts(const Json& facts, TouchSetup& setup) {
    setup.clip = text(facts, "clip");
    if (facts.contains("scene_file")) setup.scene_file = text(facts, "scene_file");
    setup.camera = camera_of(facts);
    setup.hand_words = text(facts, "hand");
    setup.live = facts.contains("clock") && text(facts, "clock") == "wall";
    if (facts.contains("device")) setup.device_words = text(facts, "device");
    TouchSettings& touch = setup.settings.touch;
    touch.metric = metric_named(text(facts, "metric"));
    touch.metres_per_scene_unit = number(facts, "S");
    if (!(touch.metres_per_scene_unit > 0)) throw std::out_of_range("S must be above 0");
    touch.event_limit = whole_number(facts, "event_limit", 1, 1'000'000);
    touch.stribeck_speed = number_or(facts, "stribeck_speed", touch.stribeck_speed);
    if (!(touch.stribeck_speed >= 0)) throw std::out_of_range("stribeck_speed must be 0 or above");
    const Json limits = object(facts, "guard");
    GuardSettings& guard = setup.settings.guard;
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
    if (auto checked = check_guard(guard); !checked.ok()) throw std::out_of_range(checked.error().message);
    if (facts.contains("rules")) (void)whole_number(facts, "rules", 1, 1'000'000);
    if (facts.contains("frames")) (void)whole_number(facts, "frames", 1, 1'000'000'000);
    for (const char* hash : {"planes_hash", "force_hash"}) (void)text(facts, hash);
    return object(facts, "scene");
}

/// Why the recorded clip could not be opened; where it, or its scene file, is gone, how to say where it is
/// now.
Error gone(Error error, const TouchSetup& setup, const TouchOptions& options) {
    std::error_code ignored;
    const std::string again = "; where it is now can be said: --replay " + options.replay->string();
    if (options.clip.empty() && !std::filesystem::exists(setup.clip, ignored))
        error.message += again + " CLIP";
    else if (!options.scene && setup.scene_file && !std::filesystem::exists(*setup.scene_file, ignored))
        error.message += again + " --scene FILE";
    return error;
}

}  // namespace

Result<std::unique_ptr<TouchSetup>> setup_from_recording(const Recording& recording,
                                                         const TouchOptions& options) {
    const std::string name = "recording " + options.replay->string();
    auto setup = std::make_unique<TouchSetup>();
    std::string scene_text;
    try {
        scene_text = read_facts(recording.facts, *setup).dump();
    } catch (const std::exception& fault) {
        return input_error(name + ": its facts will not do: " + fault.what());
    }
    const auto scene = parse_scene(scene_text, name);
    if (!scene.ok()) return scene.error();
    if (!options.clip.empty()) setup->clip = options.clip;
    if (options.scene) {
        setup->scene_file = options.scene;
        setup->camera.reset();
    }
    if (auto opened = open_feed(*setup, *scene, recording.fingers, options); !opened.ok())
        return gone(opened.error(), *setup, options);
    setup->hand = std::make_unique<ReplayHand>(recording);
    setup->settings.fingers = recording.fingers;
    setup->settings.time_of_tick = [&recording](std::int64_t tick) {
        const auto last = static_cast<std::int64_t>(recording.ticks.size()) - 1;
        return recording.ticks[static_cast<std::size_t>(std::min(tick, last))].time_ns;
    };
    if (setup->live) {
        // Which frames a tick found was a matter of the moment; the recording knows.
        setup->settings.pair_of_tick = [&recording, feed = setup->feed.get()](std::int64_t tick) {
            const RecordedTick& recorded = recording.ticks[static_cast<std::size_t>(tick)];
            return feed->pair_of(recorded.frame_prev, recorded.frame_next, recorded.blend);
        };
    }
    if (auto made = make_solver(*setup); !made.ok()) return made.error();
    return setup;
}

}  // namespace touchable
