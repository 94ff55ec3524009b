// SPDX-License-Identifier: Apache-2.0
#include "player/session/touch_setup.hpp"

#include <glm/matrix.hpp>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/gpu/vulkan_builder.hpp"

namespace touchable {

namespace {

// N s/m. Above this, damping throws the hand on a light device back within a tick instead of slowing it down.
constexpr double most_damping = 100;

/// A camera takes its frames in real time, one after another.
Result<void> check_camera(const SessionOptions& options) {
    if (!options.camera) return {};
    if (!options.live)
        return usage_error("camera needs a live run: its frames come in real time",
                           {{Setting::camera}, {Setting::live}});
    if (!options.playback.empty())
        return usage_error(
            "a camera's time only goes on: another start or rate, a loop or other commands are for a clip",
            settings_of(options.playback));
    if (options.clip.interpolation == FrameInterpolation::linear)
        return usage_error(
            "interpolation linear needs the frame after, which a camera has not taken yet; leave it out",
            {{Setting::interpolation}});
    return {};
}

// Ticks that may wait to be written, like TickLog's: four seconds.
constexpr int device_log_ticks = 4096;

/// Resolves auto for this run. A GPU named by the user may be a software one; it must exist even if auto does
/// not use it.
Result<void> choose_builder(TouchSetup& setup, std::optional<std::int64_t> frames) {
    SessionOptions& options = setup.options;
    BuilderChoice& choice = options.builder;
    if (choice.name == "auto") {
        const bool named = choice.names_gpu();
        bool drawn = options.drawn;
        if (named) {
            TRY_ASSIGN(const auto device, options.gpu->open());
            drawn = drawn && device->facts().kind != GpuKind::software;  // there the CPU draws
        }
        const BuilderChoice pick = pick_builder({setup.scene, frames != 1, drawn}, [&] {
            const auto device = options.gpu->open_measured(measure_builders);
            return device && (named || is_fast_builder((*device)->facts()));
        });
        choice.name = pick.name;
        choice.why = pick.why;
        choice.gpu_fallback = pick.name == "vulkan";
    }
    const bool averages = setup.filters && setup.filters->chosen.temporal && setup.scene.filter.temporal;
    if (choice.name != "lazy" || !averages) return {};
    choice.name = "cpu";
    choice.why = "the clip's noise is averaged over time, which needs whole frames, not the lazy builder";
    return {};
}

/// Default for streams: the surface is stale after a quarter of a second or three frames without data,
/// whichever is longer. 0: never stale.
std::int64_t stale_after_ns(const SessionOptions& options, const FrameRate& rate) {
    if (options.stale_after_ns) return *options.stale_after_ns;
    constexpr std::int64_t usual_ns = 250'000'000;
    const auto& plugged = options.clip.plugged;
    const bool is_stream = plugged && std::holds_alternative<StreamSource>(*plugged);
    return is_stream ? std::max(usual_ns, 3 * rate.time_ns(1)) : 0;
}

/// Makes the feed, which turns the clip's frames into surfaces.
Result<void> make_feed(TouchSetup& setup, ClipChoice::Opened clip) {
    SessionOptions& options = setup.options;
    setup.scene = std::move(clip.scene);
    setup.notes = remarks_of(*clip.reader);
    setup.filters = std::move(clip.chosen);
    if (!options.gpu) options.gpu = std::make_shared<RunGpu>(options.builder.gpu);
    TRY(choose_builder(setup, clip.reader->frame_count()));
    TRY_ASSIGN(auto builder, make_builder(options.builder, setup.scene, *options.gpu));
    const auto eye = options.watched ? SurfaceTimeline::Eye::one : SurfaceTimeline::Eye::none;
    setup.feed = std::make_unique<SurfaceFeed>(std::move(clip.reader), std::move(builder), setup.scene,
                                               setup.warm_up_frames, eye);
    if (!options.recorded) setup.feed->leave_out_hash();
    return {};
}

/// Sets the run's finger count from `of`, a hand or a device.
Result<void> take_fingers(int fingers, const std::string& of, SessionOptions& options) {
    if (options.fingers != 1 && options.fingers != fingers)
        return usage_error("fingers " + std::to_string(options.fingers) + ": " + of + " has " +
                               std::to_string(fingers) + "; leave it out",
                           {{Setting::fingers}});
    options.fingers = fingers;
    return {};
}

/// Reads a hand whose goals are given (RepeatingHand) and takes its finger count and scale.
Result<void> repeat_hand(TouchSetup& setup) {
    SessionOptions& options = setup.options;
    if (options.held_device || !RepeatingHand::is_meant(options.hand)) return {};
    TRY_ASSIGN(auto hand, RepeatingHand::read(options.hand));
    TRY(take_fingers(hand->fingers(), options.hand, options));
    options.touch.metres_per_scene_unit = hand->metres_per_scene_unit();
    setup.hand = std::move(hand);
    return {};
}

/// Refuses moments beyond the clip's end, if its length is known, and runs that would never end.
Result<void> check_playback(const TouchSetup& setup) {
    const auto& playback = setup.options.playback;
    const auto frames = setup.feed->reader().frame_count();
    const std::int64_t end_ns =
        frames ? setup.scene.rate.time_ns(*frames) : std::numeric_limits<std::int64_t>::max();
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
        setup.ticks() || setup.options.live || PlaybackClock(setup.scene.rate, playback).plays_to_the_end();
    if (ends) return {};
    return usage_error(
        "playback '" + in_words(playback) + "' never comes to the clip's end; how long to touch must be said",
        {{Setting::seconds}});
}

/// Places a device over the clip: as the options state, from the clip's first frame, or fitted to the
/// device's reach.
Result<void> place_workspace(TouchSetup& setup) {
    const SessionOptions& options = setup.options;
    if (options.workspace) {
        setup.workspace = *options.workspace;
    } else if (options.world_from_camera) {
        setup.workspace = {setup.scene.metres_per_unit, glm::dvec3(0)};
    } else {
        TRY_ASSIGN(const auto first, setup.feed->pair_at(0));
        const SurfaceFrame& frame = *first.prev.frame;
        setup.workspace = options.control
                              ? held_workspace(setup.scene, frame, options.held_device->capabilities().reach)
                              : clip_workspace(setup.scene, frame);
    }
    setup.workspace.metres_per_scene_unit /= options.hand_scale;
    if (!options.control) return {};
    HandMapping mapping{setup.workspace};
    if (options.world_from_camera) {
        // From the camera's axes (x right, y down, z forward) to the user's.
        const glm::dmat3 upright(1, 0, 0, 0, -1, 0, 0, 0, -1);
        mapping.turn = upright * glm::transpose(glm::dmat3(*options.world_from_camera));
        mapping.offset = -(mapping.turn * glm::dvec3((*options.world_from_camera)[3]));
    }
    options.control->set_mapping(mapping);
    return {};
}

/// Makes a hand over the frame it begins with. The scale is that of the clip's first frame, wherever playback
/// begins, unless the hand knows its own.
Result<void> place_hand(TouchSetup& setup) {
    SessionOptions& options = setup.options;
    TRY(place_workspace(setup));
    TRY_ASSIGN(const auto begin,
               setup.feed->pair_at(PlaybackClock(setup.scene.rate, options.playback).at(0)));
    double& scale = setup.workspace.metres_per_scene_unit;
    if (setup.hand) scale = options.touch.metres_per_scene_unit;
    if (!options.held_device && !setup.hand) {
        const HeightField field(setup.scene, begin);
        TRY_ASSIGN(setup.hand, make_hand(options.hand, options.fingers, setup.workspace, FieldProbe(field)));
    }
    options.touch.metres_per_scene_unit = scale;
    return {};
}

/// The user may set lower limits than the device's, never higher ones.
void keep_within(const DeviceLimits& can, GuardSettings& guard) {
    guard.max_force = std::min(guard.max_force, can.max_force);
    guard.max_stiffness = std::min(guard.max_stiffness, can.max_stiffness);
}

/// Takes a device held by the user: one finger per handle.
Result<void> take_held_device(TouchSetup& setup) {
    SessionOptions& options = setup.options;
    if (!options.held_device) return {};
    const int fingers = options.held_device->fingers();
    TRY(take_fingers(fingers, "the " + options.held_device->name(), options));
    options.hand = "a person's hand";
    options.device = options.held_device->name();
    if (options.device_log) setup.device_log = std::make_unique<DeviceTickLog>(device_log_ticks, fingers);
    keep_within(options.held_device->limits(), options.guard);
    return {};
}

Result<void> hold_device(TouchSetup& setup) {
    if (!setup.options.device || setup.options.held_device) return {};
    TRY_ASSIGN(setup.device, make_simulated_device(*setup.options.device, setup.options.fingers));
    keep_within(setup.device->limits(), setup.options.guard);
    return {};
}

/// Why the recorded clip could not be opened. If it or one of its files is gone, adds a hint with the option
/// that states the new place.
Error gone(Error error, const ClipChoice& recorded, const ClipChoice& instead) {
    const std::optional<std::filesystem::path> clip(recorded.file), none;
    const std::pair<Setting::Name, std::optional<std::filesystem::path>> files[] = {
        {Setting::clip, instead.file.empty() ? clip : none},
        {Setting::scene_file, instead.scene_file ? none : recorded.scene_file},
        {Setting::haptic_map, recorded.maps.haptic},
        {Setting::height_map, recorded.maps.height}};
    for (const auto& [setting, file] : files) {
        std::error_code ignored;
        if (!file || std::filesystem::exists(*file, ignored)) continue;
        error.message += "; say where it is now";
        error.hints.push_back({setting, setting == Setting::clip ? "" : "FILE"});
        break;
    }
    return error;
}

/// The recorded clip, or its replacement from `instead`, with the `recorded` scene. Errors call the recording
/// `name`.
Result<ClipChoice::Opened> open_recorded(ClipChoice& clip, const SceneDescription& recorded,
                                         const std::string& name, const ClipChoice& instead) {
    if (!instead.file.empty()) clip.file = instead.file;
    if (instead.scene_file) {
        clip.scene_file = instead.scene_file;
        clip.camera = {};
    }
    if (instead.maps.haptic) clip.maps.haptic = instead.maps.haptic;
    if (instead.maps.height) clip.maps.height = instead.maps.height;
    if (clip.as_camera && !recorded.unstated.rate) clip.as_camera->rate = recorded.scene.rate;
    auto reader = clip.open(Colour::left_out);
    if (!reader) return gone(reader.error(), clip, instead);
    const Scene& stored = (*reader)->scene();
    if (stored.width != recorded.scene.width || stored.height != recorded.scene.height)
        return input_error(clip.file.string() + ": is " + size_text(stored.width, stored.height) +
                           ", the recording was made on " +
                           size_text(recorded.scene.width, recorded.scene.height));
    TRY_ASSIGN(auto scene, error_at(name + ": its scene", settle(recorded, {.rate = stored.rate})));
    return ClipChoice::Opened{std::move(*reader), std::move(scene), {}};
}

/// `--replay FILE`: the recorded goals as a hand.
class ReplayHand final : public Hand {
public:
    explicit ReplayHand(const RecordedPart& recording) : recording_(recording) {}
    int fingers() const override { return recording_.fingers; }
    void goals_at(std::int64_t tick, const SurfaceProbe&, std::span<glm::dvec3> goals) override {
        std::ranges::copy(recording_.ticks[static_cast<std::size_t>(tick)].goals, goals.begin());
    }
    std::optional<std::int64_t> ticks() const override { return std::ssize(recording_.ticks); }

private:
    const RecordedPart& recording_;
};

/// Runs ticks at their recorded times and, for a live run, with their recorded frame pairs: which pair a live
/// tick found depended on timing.
void follow(const RecordedPart& part, TouchSetup& setup) {
    setup.options.playback = part.playback;
    const PlaybackClock clock(setup.scene.rate, part.playback);
    setup.options.given_tick = [&part, is_live = setup.options.live, feed = setup.feed.get(), epoch = ComingEpoch{},
                                ahead = clock, now = clock](std::int64_t tick) mutable -> Result<TouchSessionSettings::GivenTick> {
        const RecordedPart::Tick& recorded = part.ticks[static_cast<std::size_t>(tick)];
        TouchSessionSettings::GivenTick given{recorded.time_ns};
        if (!is_live) return given;
        given.after_gap = (recorded.guards.front() & guard_gap) != 0;
        if (recorded.epoch > now.at(recorded.time_ns / tick_ns).epoch)
            return input_error("tick " + std::to_string(tick) + " is of epoch " +
                               std::to_string(recorded.epoch) + ", which no command has begun by then");
        while (epoch.number < recorded.epoch) epoch = ahead.next_epoch().value();
        TRY(assign(given.pair, feed->pair_of(recorded.frame_prev, recorded.frame_next, recorded.blend,
                                             epoch.number, epoch.start_ns)));
        return given;
    };
}

}  // namespace

Result<void> check_guard(const GuardSettings& guard) {
    TRY(validate(guard));
    if (guard.damping > most_damping)
        return usage_error("damping must be 0 to 100 N s/m", {{Setting::damping}});
    if (guard.passivity > most_damping)
        return usage_error("the passivity controller's damping must be 0 to 100 N s/m",
                           {{Setting::passivity}});
    return {};
}

Result<void> validate(const SessionOptions& options) {
    if (options.stale_after_ns && !options.camera)
        return usage_error("the age of a stale surface needs a live source: a clip's frames are never late",
                           {{Setting::stale_after}, {Setting::camera}});
    TRY(check_guard(options.guard));
    if (!(options.touch.stribeck_speed >= 0 && std::isfinite(options.touch.stribeck_speed)))
        return usage_error("stribeck must be a number of m/s, 0 or above", {{Setting::stribeck}});
    if (options.recorded && options.clip.relief)
        return usage_error(
            "relief that is tried is not recorded: touchable relief CLIP OUT.mkv writes a clip that has it, "
            "and a run over that can be");
    if (options.recorded && options.clip.painted)
        return usage_error(
            "materials that are tried are not recorded: touchable materials writes a clip that has them, and "
            "a run over that can be");
    if (options.start_buried && !options.live)
        return usage_error(
            "a hand that starts buried needs a live run: in another no finger waits to be free",
            {{Setting::start_buried}, {Setting::live}});
    if (options.device && !options.live)
        return usage_error("device needs a live run: it is held in real time",
                           {{Setting::device}, {Setting::live}});
    if (options.held_device && (!options.live || options.device))
        return usage_error(
            "a device that a person holds is touched with in real time, and without another that a hand "
            "holds: leave the other out",
            {{Setting::device}});
    if (options.control && options.hand != SessionOptions{}.hand)
        return usage_error(
            "hand " + options.hand + ": the hand that holds the device is yours; leave one of them out",
            {{Setting::hand}});
    return check_camera(options);
}

Result<std::unique_ptr<TouchSetup>> setup_from_options(const SessionOptions& options) {
    TRY(validate(options));
    auto setup = std::make_unique<TouchSetup>();
    setup->options = options;
    setup->options.guard.waits_to_be_free = options.live && !options.start_buried;

    TRY(take_held_device(*setup));
    TRY(repeat_hand(*setup));
    TRY_ASSIGN(auto clip, open_chosen(options.clip, options.watched ? Colour::wanted : Colour::left_out));
    if (options.recorded && options.clip.plugged) {
        setup->film = std::make_shared<CameraCapture>(clip.reader->described());
        clip.reader = with_film(std::move(clip.reader), setup->film);
    }
    TRY(make_feed(*setup, std::move(clip)));
    setup->options.guard.stale_after_ns = stale_after_ns(options, setup->scene.rate);
    if (options.late_playback) setup->options.playback = options.late_playback();
    setup->options.late_playback = nullptr;  // may refer to variables of the caller
    TRY(place_hand(*setup));
    TRY(check_playback(*setup));
    TRY(hold_device(*setup));
    TRY_ASSIGN(setup->solver, TouchSolver::create(setup->scene, setup->options.touch));
    return setup;
}

Result<std::unique_ptr<TouchSetup>> setup_from_recording(const RecordedPart& part,
                                                         const SessionOptions& options,
                                                         std::shared_ptr<RunGpu> gpu) {
    auto setup = std::make_unique<TouchSetup>();
    setup->options.gpu = gpu ? std::move(gpu) : options.gpu;
    setup->options.builder = options.builder;
    setup->options.recorded = true;
    setup->options.fingers = part.fingers;
    TRY_ASSIGN(const auto scene, read_recorded_facts(part.facts, part.name, *setup));
    TRY_ASSIGN(auto clip, open_recorded(setup->options.clip, scene, part.name, options.clip));
    TRY(make_feed(*setup, std::move(clip)));
    setup->feed->leave_out(setup->dropped);
    setup->hand = std::make_unique<ReplayHand>(part);
    follow(part, *setup);
    TRY_ASSIGN(setup->solver, TouchSolver::create(setup->scene, setup->options.touch));
    return setup;
}

}  // namespace touchable
