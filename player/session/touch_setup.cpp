#include "player/session/touch_setup.hpp"

#include <algorithm>
#include <glm/matrix.hpp>
#include <string>
#include <utility>
#include <variant>

#include "engine/base/stop_request.hpp"
#include "engine/base/try.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/run/clip_workspace.hpp"
#include "player/run/field_probe.hpp"
#include "player/run/repeating_hand.hpp"
#include "player/session/builder_pick.hpp"
#include "player/session/playback_script.hpp"
#include "player/session/recorded_facts.hpp"
#include "player/session/replay.hpp"

namespace touchable {

namespace {

// Ticks that may wait to be written, as TickLog's: four seconds.
constexpr int device_log_ticks = 4096;

/// The builder that was asked for, or what auto is in this run. A GPU that was named may be a software one,
/// and has to be there whether auto takes it or not.
Result<void> choose_builder(TouchSetup& setup, std::optional<std::int64_t> frames,
                            const SessionOptions& options) {
    setup.builder = options.builder;
    if (options.builder.name == "lazy" && setup.filters && setup.filters->chosen.temporal &&
        setup.scene.filter.temporal) {
        setup.builder.name = "cpu";
        setup.builder_why =
            "the clip's noise is averaged over time, which needs whole frames, not the lazy builder";
    }
    const std::string watched = "somebody looks at whole frames, which the lazy builder does not make";
    if (options.watched && setup.builder.name == "lazy") {
        setup.builder.name = "cpu";
        setup.builder_why = watched;
    }
    if (options.builder.name != "auto") return {};
    const bool named = options.builder.names_gpu();
    if (named) TRY(setup.gpu->open());
    const TouchLoad load{setup.scene, frames != 1, setup.settings.fingers, options.live};
    const auto pick = pick_builder(load, [&] {
        const auto device = setup.gpu->open();
        return device.ok() && (named || (*device)->facts().kind != GpuKind::software);
    });
    setup.builder.name = pick.name;
    setup.builder.gpu_fallback = pick.name == "vulkan";
    setup.builder_why = pick.why;
    if (options.watched && pick.name == "lazy") {
        setup.builder.name = "cpu";
        setup.builder_why = watched;
    }
    return {};
}

/// What a stream shows is not there for sure once nothing has come for a quarter of a second, or for three
/// frames.
std::int64_t stale_after_ns(const SessionOptions& options, const FrameRate& rate) {
    if (options.stale_after_ns) return *options.stale_after_ns;
    constexpr std::int64_t usual_ns = 250'000'000;
    const auto& plugged = options.clip.plugged;
    const bool is_stream = plugged && std::holds_alternative<StreamChoice>(*plugged);
    return is_stream ? std::max(usual_ns, 3 * rate.time_ns(1)) : 0;
}

/// The clip's frames on their way to the surface.
Result<void> make_feed(TouchSetup& setup, OpenClip clip, const SessionOptions& options) {
    setup.scene = std::move(clip.scene);
    setup.notes = remarks_of(*clip.reader);
    setup.filters = std::move(clip.chosen);
    if (!setup.gpu) setup.gpu = options.gpu ? options.gpu : std::make_shared<RunGpu>(options.builder.gpu);
    if (auto chosen = choose_builder(setup, clip.reader->frame_count(), options); !chosen.ok()) return chosen;
    TRY_ASSIGN(auto builder, make_builder(setup.builder, setup.scene, *setup.gpu));
    const auto eye = options.watched ? SurfaceTimeline::Eye::one : SurfaceTimeline::Eye::none;
    setup.feed = std::make_unique<SurfaceFeed>(std::move(clip.reader), std::move(builder), setup.scene,
                                               setup.warm_up_frames, eye);
    if (!options.recorded) setup.feed->leave_out_hash();
    setup.feed->stop_at(options.given_up);
    return {};
}

/// A hand that knows its goals already: how many fingers it has, and at what scale it touches.
Result<void> repeat_hand(TouchSetup& setup, const SessionOptions& options) {
    if (options.held_device || !RepeatingHand::is_meant(options.hand)) return {};
    TRY_ASSIGN(auto hand, RepeatingHand::read(options.hand));
    const int fingers = hand->fingers();
    if (options.fingers != 1 && options.fingers != fingers)
        return usage_error("fingers " + std::to_string(options.fingers) + ": " + options.hand + " has " +
                               std::to_string(fingers) + "; leave it out",
                           {{Setting::fingers}});
    setup.settings.fingers = fingers;
    setup.settings.touch.metres_per_scene_unit = hand->metres_per_scene_unit();
    setup.hand = std::move(hand);
    return {};
}

/// A moment that the clip has not, where its length is known, and a run that would never end.
Result<void> check_playback(const TouchSetup& setup, const SessionOptions& options) {
    const auto& playback = setup.settings.playback;
    const auto frames = setup.feed->reader().frame_count();
    const std::int64_t end_ns = frames ? setup.scene.rate.time_ns(*frames) : latest_moment_ns + 1;
    std::vector<PlaybackCommand> beyond;
    for (const PlaybackCommand& command : playback)
        if ((command.verb == PlaybackVerb::seek || command.verb == PlaybackVerb::loop) &&
            command.first >= end_ns)
            beyond.push_back(command);
    if (!beyond.empty())
        return usage_error("playback '" + in_words(std::vector{beyond.front()}) + "': the clip ends at " +
                               std::to_string(static_cast<double>(end_ns) * 1e-9) + " s",
                           settings_of(beyond));
    const bool ends =
        setup.ticks() || options.live || PlaybackClock(setup.scene.rate, playback).plays_to_the_end();
    if (ends) return {};
    return usage_error(
        "playback '" + in_words(playback) + "' never comes to the clip's end; how long to touch must be said",
        {{Setting::seconds}});
}

/// Where a device stands over the clip: as somebody says, as the clip's first frame says, or fitted to what
/// the device reaches.
Result<void> place_workspace(TouchSetup& setup, const SessionOptions& options) {
    if (options.workspace) {
        setup.workspace = *options.workspace;
    } else if (options.world_from_camera) {
        setup.workspace = {setup.scene.metres_per_unit, glm::dvec3(0)};
    } else {
        TRY_ASSIGN(const auto first, setup.feed->pair_at(0));
        const SurfaceFrame& frame = *first.prev.frame;
        setup.workspace = setup.control
                              ? held_workspace(setup.scene, frame, setup.held_device->capabilities().reach)
                              : clip_workspace(setup.scene, frame);
    }
    setup.workspace.metres_per_scene_unit /= options.hand_scale;
    if (!setup.control) return {};
    HandMapping mapping{setup.workspace};
    if (options.world_from_camera) {
        // From the camera's axes (x right, y down, z forward) to the person's.
        const glm::dmat3 upright(1, 0, 0, 0, -1, 0, 0, 0, -1);
        mapping.turn = upright * glm::transpose(glm::dmat3(*options.world_from_camera));
        mapping.offset = -(mapping.turn * glm::dvec3((*options.world_from_camera)[3]));
    }
    setup.control->set_mapping(mapping);
    return {};
}

/// A hand over the frame that it begins with, and where it stands there. The scale is that of the clip's
/// first frame, wherever it begins, unless that is known.
Result<void> place_hand(TouchSetup& setup, const SessionOptions& options) {
    if (auto placed = place_workspace(setup, options); !placed.ok()) return placed;
    setup.hand_words = setup.held_device ? "a person's hand" : options.hand;
    TRY_ASSIGN(const auto begin,
               setup.feed->pair_at(PlaybackClock(setup.scene.rate, setup.settings.playback).at(0)));
    if (setup.held_device) {
        setup.settings.touch.metres_per_scene_unit = setup.workspace.metres_per_scene_unit;
        return {};
    }
    if (setup.hand) {
        setup.workspace.metres_per_scene_unit = setup.settings.touch.metres_per_scene_unit;
        return {};
    }
    const HeightField field(setup.scene, begin);
    TRY_ASSIGN(auto hand, make_hand(options.hand, options.fingers, setup.workspace, FieldProbe(field)));
    setup.hand = std::move(hand);
    setup.settings.touch.metres_per_scene_unit = setup.workspace.metres_per_scene_unit;
    return {};
}

/// A person may ask for less than the device can, never for more.
void keep_within(const DeviceLimits& can, GuardSettings& guard) {
    guard.max_force = std::min(guard.max_force, can.max_force);
    guard.max_stiffness = std::min(guard.max_stiffness, can.max_stiffness);
}

/// Of a device that a person holds: as many fingers as it has handles.
Result<void> take_held_device(TouchSetup& setup, const SessionOptions& options) {
    if (!options.held_device) return {};
    const int fingers = options.held_device->fingers();
    if (options.fingers != 1 && options.fingers != fingers)
        return usage_error("fingers " + std::to_string(options.fingers) + ": the " +
                               options.held_device->name() + " has " + std::to_string(fingers) +
                               "; leave it out",
                           {{Setting::fingers}});
    setup.settings.fingers = fingers;
    setup.held_device = options.held_device;
    setup.device_words = options.held_device->name();
    setup.control = options.control;
    if (options.device_log) setup.device_log = std::make_unique<DeviceTickLog>(device_log_ticks, fingers);
    keep_within(options.held_device->limits(), setup.settings.guard);
    return {};
}

Result<void> hold_device(TouchSetup& setup, const SessionOptions& options) {
    if (!options.device) return {};
    TRY_ASSIGN(auto device, make_simulated_device(*options.device, setup.settings.fingers));
    keep_within(device->limits(), setup.settings.guard);
    setup.device = std::move(device);
    setup.device_words = *options.device;
    return {};
}

Result<void> make_solver(TouchSetup& setup) {
    TRY_ASSIGN(auto solver, TouchSolver::create(setup.scene, setup.settings.touch));
    setup.solver = solver;
    return {};
}

}  // namespace

Result<std::unique_ptr<TouchSetup>> setup_from_options(const SessionOptions& options) {
    const WorkUntil until(options.given_up);
    TRY(validate(options));
    auto setup = std::make_unique<TouchSetup>();
    setup->clip = options.clip;
    setup->camera_words = options.camera.value_or("");
    setup->live = options.live;
    setup->hand_scale = options.hand_scale;
    setup->settings.fingers = options.fingers;
    setup->settings.ticks = options.ticks;
    setup->settings.playback = options.playback;
    setup->settings.touch.metric = options.metric;
    setup->settings.touch.stribeck_speed = options.stribeck_speed;
    setup->settings.guard = options.guard;
    setup->settings.guard.waits_to_be_free = options.live && !options.start_buried;

    TRY(take_held_device(*setup, options));
    TRY(repeat_hand(*setup, options));
    TRY_ASSIGN(auto clip, open_chosen(options.clip, options.watched ? Colour::wanted : Colour::left_out,
                                      options.given_up));
    if (options.recorded && options.clip.plugged) {
        setup->film = std::make_shared<CameraCapture>(clip.reader->described());
        clip.reader = with_film(std::move(clip.reader), setup->film);
    }
    TRY(make_feed(*setup, std::move(clip), options));
    setup->settings.guard.stale_after_ns = stale_after_ns(options, setup->scene.rate);
    if (options.late_playback) setup->settings.playback = options.late_playback();
    TRY(place_hand(*setup, options));
    TRY(check_playback(*setup, options));
    TRY(hold_device(*setup, options));
    TRY(make_solver(*setup));
    return setup;
}

namespace {

/// Why the recorded clip could not be opened; where it, or its scene file, is gone, how to say where it is
/// now.
Error gone(Error error, const TouchSetup& setup, const ClipChoice& instead) {
    std::error_code ignored;
    const auto say = [&error](Setting setting) {
        error.message += "; say where it is now";
        error.hints.push_back({setting, setting == Setting::clip ? "" : "FILE"});
    };
    const auto& scene_file = setup.clip.scene_file;
    if (instead.file.empty() && !std::filesystem::exists(setup.clip.file, ignored))
        say(Setting::clip);
    else if (!instead.scene_file && scene_file && !std::filesystem::exists(*scene_file, ignored))
        say(Setting::scene_file);
    else if (const auto& haptic = setup.clip.maps.haptic;
             haptic && !std::filesystem::exists(*haptic, ignored))
        say(Setting::haptic_map);
    else if (const auto& height = setup.clip.maps.height;
             height && !std::filesystem::exists(*height, ignored))
        say(Setting::height_map);
    return error;
}

/// The recorded clip, or the one it is now, as the `recorded` scene. Errors name the recording by `name`.
Result<OpenClip> open_recorded(TouchSetup& setup, const SceneDescription& recorded, const std::string& name,
                               const ClipChoice& instead) {
    if (!instead.file.empty()) setup.clip.file = instead.file;
    if (instead.scene_file) {
        setup.clip.scene_file = instead.scene_file;
        setup.clip.camera.reset();
    }
    if (instead.maps.haptic) setup.clip.maps.haptic = instead.maps.haptic;
    if (instead.maps.height) setup.clip.maps.height = instead.maps.height;
    if (setup.clip.as_camera && !recorded.unstated.rate) setup.clip.as_camera->rate = recorded.scene.rate;
    auto reader = setup.clip.open(Colour::left_out);
    if (!reader.ok()) return gone(reader.error(), setup, instead);
    const Scene& stored = (*reader)->scene();
    if (stored.width != recorded.scene.width || stored.height != recorded.scene.height)
        return input_error(setup.clip.file.string() + ": is " + std::to_string(stored.width) + "x" +
                           std::to_string(stored.height) + ", the recording was made on " +
                           std::to_string(recorded.scene.width) + "x" +
                           std::to_string(recorded.scene.height));
    auto scene = settle(recorded, {.rate = stored.rate});
    if (!scene.ok()) return input_error(name + ": its scene: " + scene.error().message);
    return OpenClip{std::move(*reader), std::move(*scene), {}};
}

/// Ticks at the times that were recorded, and of a live run with the frames they found: that was a matter of
/// the moment, and the recording knows.
void follow(const RecordedPart& part, TouchSetup& setup) {
    setup.settings.time_of_tick = [&part](std::int64_t tick) {
        const auto last = static_cast<std::int64_t>(part.ticks.size()) - 1;
        return part.ticks[static_cast<std::size_t>(std::min(tick, last))].time_ns;
    };
    setup.settings.playback = part.playback;
    if (!setup.live) return;
    setup.settings.is_after_gap = [&part](std::int64_t tick) {
        return (part.ticks[static_cast<std::size_t>(tick)].guards.front() & guard_gap) != 0;
    };
    const PlaybackClock clock(setup.scene.rate, part.playback);
    setup.settings.pair_of_tick = [&part, feed = setup.feed.get(), epoch = ComingEpoch{}, ahead = clock,
                                   now = clock](std::int64_t tick) mutable -> Result<FramePair> {
        const RecordedTick& recorded = part.ticks[static_cast<std::size_t>(tick)];
        if (recorded.epoch > now.at(recorded.time_ns / tick_ns).epoch)
            return input_error("tick " + std::to_string(tick) + " is of epoch " +
                               std::to_string(recorded.epoch) + ", which no command has begun by then");
        while (epoch.number < recorded.epoch) epoch = ahead.next_epoch().value();
        return feed->pair_of(epoch.number, epoch.start_ns, recorded.frame_prev, recorded.frame_next,
                             recorded.blend);
    };
}

}  // namespace

Result<std::unique_ptr<TouchSetup>> setup_from_recording(const RecordedPart& part,
                                                         const SessionOptions& options,
                                                         std::shared_ptr<RunGpu> gpu) {
    auto setup = std::make_unique<TouchSetup>();
    setup->gpu = std::move(gpu);
    setup->settings.fingers = part.fingers;
    TRY_ASSIGN(const auto scene, read_recorded_facts(part.facts, part.name, *setup));
    TRY_ASSIGN(auto clip, open_recorded(*setup, scene, part.name, options.clip));
    SessionOptions as_recorded = options;
    as_recorded.recorded = true;
    TRY(make_feed(*setup, std::move(clip), as_recorded));
    setup->feed->leave_out(setup->dropped);
    setup->hand = std::make_unique<ReplayHand>(part);
    follow(part, *setup);
    TRY(make_solver(*setup));
    return setup;
}

}  // namespace touchable
