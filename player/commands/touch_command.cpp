#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <memory>
#include <vector>

#include "engine/base/try.hpp"
#include "haptics_cpu/touch_step.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/run_options.hpp"
#include "player/commands/touch_run.hpp"

namespace touchable {

namespace {

/// Options as typed; what has a unit of its own on the command line is converted once they are read.
struct TouchWords {
    TouchOptions options;
    ClipTyped clip;
    PlaybackTyped playback;
    double max_stiffness_n_mm = 10;
    double stiffness_slew = 0;  // N/mm per second
    double seconds = 0, picture_seconds = 0;
    std::optional<double> stale_after_ms;
    std::vector<CLI::Option*> fixed_by_recording;
    CLI::Option* clip_word = nullptr;
    CLI::Option* duration = nullptr;
    CLI::Option* picture_moment = nullptr;
    CLI::Option* slew = nullptr;
    CLI::Option* latency = nullptr;

    void fix_by_recording(const std::vector<CLI::Option*>& more) {
        fixed_by_recording.insert(fixed_by_recording.end(), more.begin(), more.end());
    }
};

/// The run's length and the picture's moment, in ticks.
Result<void> read_moments(const TouchWords& words, TouchOptions& options) {
    auto& ticks = options.session.ticks;
    if (words.picture_moment->count() > 0)
        options.picture_tick = static_cast<std::int64_t>(words.picture_seconds * 1000 + 0.5);
    if (words.duration->count() > 0) ticks = static_cast<std::int64_t>(words.seconds * 1000 + 0.5);
    if (ticks && options.picture_tick && *options.picture_tick >= *ticks)
        return usage_error("--picture-at lies beyond the run's end; --seconds says when that is");
    return {};
}

Result<TouchOptions> read_words(const TouchWords& words) {
    TouchOptions options = words.options;
    GuardSettings& guard = options.session.guard;
    guard.max_stiffness = words.max_stiffness_n_mm * 1000;
    if (words.slew->count() > 0) guard.rise.per_tick = words.stiffness_slew * 1000 * tick_seconds;
    TRY(read_moments(words, options));
    if (options.replay) {
        for (const CLI::Option* option : words.fixed_by_recording)
            if (option->count() > 0)
                return usage_error(option->get_name() +
                                   " comes from the recording; leave it out with --replay");
    } else if (words.clip_word->count() == 0 && !options.session.camera) {
        return usage_error(
            "touch needs a CLIP, a --camera, or a recording to --replay; see touchable touch -h");
    }
    TRY_ASSIGN(options.session.clip, read_clip(words.clip));
    options.session.recorded = options.record.has_value();
    options.session.device_log = options.device_log.has_value();
    TRY(read_live_camera(words.clip_word->count() > 0, words.stale_after_ms, options.session));
    TRY(read_live_stream(words.latency->count() > 0, options.session));
    TRY_ASSIGN(options.session.playback, read_playback(words.playback));
    options.play = words.playback.script;
    return options;
}

/// What is written of the run.
void add_file_options(CLI::App& sub, TouchOptions& o) {
    add_file_option(sub, "--json", o.json, "write the figures as JSON; -: to standard output");
    add_file_option(sub, "--forces", o.forces,
                    "write goal, proxy and force of every tick and finger as CSV; -: to standard output");
    add_file_option(
        sub, "--device-log", o.device_log,
        "of a device that you hold: places, buttons and forces of every tick as CSV, which replays as a "
        "device; -: to standard output");
    auto* record = add_file_option(sub, "--record", o.record, "keep what it takes to repeat the run");
    auto* replay =
        add_file_option(sub, "--replay", o.replay, "repeat a recorded run and compare every force with it");
    record->excludes(replay);
    add_overwrite_option(sub, o.existing);
    sub.add_flag("--verbose", o.verbose, "print the whole table of figures, not the four lines of it");
    sub.add_flag("--strict", o.strict, "end with code 6 where the first line is a warning");
}

void add_moment_options(CLI::App& sub, TouchWords& words) {
    words.picture_moment =
        add_number_option(
            sub, "--picture-at", words.picture_seconds,
            "the moment drawn, seconds; otherwise 60 % of the run (of 3 s where its length is not known)", 0,
            1e6)
            ->needs("--picture");
    words.duration =
        add_number_option(sub, "--seconds", words.seconds,
                          "length of the run; otherwise that of a recorded hand or device; with a device "
                          "that you hold until Ctrl-C; else the clip's and at least 3",
                          0.001, 1e6);
    words.fix_by_recording({words.duration});
}

/// Who touches, and with what.
std::vector<CLI::Option*> add_hand_options(CLI::App& sub, SessionOptions& session) {
    return {
        sub.add_flag("--live", session.live,
                     "in real time on the wall clock, each part on a thread of its own"),
        add_live_camera_option(sub, session),
        sub.add_option(
               "--hand", session.hand,
               "wander, stroke, press, poke, csv:FILE or rec:FILE, each with :key=value,... (docs/hands.md)")
            ->capture_default_str(),
        add_whole_option(sub, "--fingers", session.fingers, "copies of the hand's path, spread on a circle",
                         1, 256)
            ->capture_default_str()};
}

CLI::Option* add_interpolation_option(CLI::App& sub, ClipChoice& clip) {
    const Words<FrameInterpolation> words{{"hold", FrameInterpolation::hold},
                                          {"linear", FrameInterpolation::linear}};
    return add_word_option(sub, "--interpolation", clip.interpolation,
                           "between frames, instead of the scene's: hold or linear", words);
}

/// How forces come about.
void add_force_options(CLI::App& sub, TouchWords& words) {
    const Words<TouchMetric> metrics{
        {"world", TouchMetric::world}, {"pixel", TouchMetric::pixel}, {"scaled", TouchMetric::scaled}};
    const Words<bool> rises{{"map", false}, {"passive", true}};
    SessionOptions& session = words.options.session;
    GuardSettings& guard = session.guard;
    words.slew =
        add_number_option(sub, "--stiffness-slew", words.stiffness_slew,
                          "N/mm per second: how fast stiffness may rise in contact; otherwise at once");
    words.fix_by_recording(
        {words.slew,
         sub.add_flag("--start-buried", session.start_buried,
                      "live: a finger that is inside the surface when it first meets it is pushed out at "
                      "once; otherwise it feels nothing until it has been free"),
         add_word_option(sub, "--metric", session.metric,
                         "where distances are measured: world; to compare, pixel (the paper's) or scaled "
                         "(pixel with levels as long as they are where the finger is)",
                         metrics),
         add_number_option(sub, "--max-force", guard.max_force, "N: what the device can exert on a finger")
             ->capture_default_str(),
         add_number_option(sub, "--max-stiffness", words.max_stiffness_n_mm,
                           "N/mm: what the device renders stably")
             ->capture_default_str(),
         add_number_option(
             sub, "--stribeck", session.stribeck_speed,
             "m/s: friction falls from static to dynamic about this speed; 0: the moment it slides")
             ->capture_default_str(),
         add_word_option(sub, "--stiffness", guard.rise.paid,
                         "in contact: map (the clip's), or passive (rises only as far as losses pay for)",
                         rises),
         add_number_option(sub, "--damping", guard.damping,
                           "N s/m beside the spring, against the hand's motion")
             ->capture_default_str(),
         add_number_option(
             sub, "--passivity", guard.passivity,
             "N s/m: the most by which a controller may brake to take back created energy; 0: off")
             ->capture_default_str()});
}

/// In the help each option stands under what it is about; what few people need comes last.
void group_options(CLI::App& sub) {
    const struct {
        const char* name;
        std::vector<const char*> options;
    } groups[] = {
        {"The clip",
         {"--scene", "--intrinsics", "--fov", "--depth-unit", "--preset", "--haptic", "--height", "--align",
          "--fill-from-motion", "--least-confidence", "--camera", "--latency", "--stale-after", "--start",
          "--rate", "--loop", "--play"}},
        {"The hand",
         {"--hand", "--fingers", "--seconds", "--live", "--device", "--force-on", "--hand-scale",
          "--world-from-camera", "--max-force", "--max-stiffness"}},
        {"Filters of depth", {"--median", "--fill-holes", "--terraces", "--temporal", "--interpolation"}},
        {"Files",
         {"--json", "--forces", "--device-log", "--record", "--replay", "--overwrite", "--verbose",
          "--strict"}},
        {"A picture", {"--picture", "--picture-at", "--picture-size", "--view", "--show"}},
        {"Expert",
         {"--builder", "--gpu", "--painter", "--metric", "--stribeck", "--stiffness", "--stiffness-slew",
          "--damping", "--passivity", "--start-buried"}}};
    for (const auto& group : groups)
        for (const char* option : group.options) sub.get_option(option)->group(group.name);
}

}  // namespace

void add_touch_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand(
        "touch", "touch a clip with a scripted or recorded hand: forces, figures, a recording");
    auto words = std::make_shared<TouchWords>();
    TouchOptions& o = words->options;
    // In the order in which the help names their groups.
    words->clip_word = add_clip_options(*sub, words->clip);
    words->fix_by_recording({sub->get_option("--align"), sub->get_option("--fill-from-motion"),
                             sub->get_option("--least-confidence")});
    words->fix_by_recording(add_camera_options(*sub, words->clip.camera));
    words->fix_by_recording(add_playback_options(*sub, words->playback));
    words->fix_by_recording(add_hand_options(*sub, o.session));
    words->latency = add_latency_option(*sub, o.session);
    words->fix_by_recording({words->latency});
    words->fix_by_recording({add_stale_after_option(*sub, words->stale_after_ms)});
    words->fix_by_recording(add_held_device_options(*sub, o.held, o.session));
    words->fix_by_recording(add_filter_options(*sub, words->clip));
    words->fix_by_recording({add_interpolation_option(*sub, words->clip.choice)});
    add_file_options(*sub, o);
    add_picture_options(*sub, o.picture);
    add_moment_options(*sub, *words);
    add_force_options(*sub, *words);
    add_builder_options(*sub, o.session.builder, {"auto", "cpu", "vulkan", "lazy", "reference"});
    group_options(*sub);
    sub->callback([words, &command] {
        command = [words]() -> Result<void> {
            TRY_ASSIGN(const auto options, read_words(*words));
            return run_touch(options);
        };
    });
}

}  // namespace touchable
