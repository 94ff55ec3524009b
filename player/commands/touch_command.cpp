#include "player/commands/touch_command.hpp"

#include <CLI/CLI.hpp>
#include <cmath>
#include <memory>

#include "haptics_cpu/tick_velocity.hpp"
#include "player/commands/builder_options.hpp"
#include "player/commands/camera_options.hpp"
#include "player/commands/file_option.hpp"
#include "player/commands/outputs.hpp"
#include "player/commands/temporal_option.hpp"
#include "player/commands/terrace_option.hpp"
#include "player/commands/touch_run.hpp"
#include "player/commands/whole_option.hpp"
#include "player/commands/word_option.hpp"

namespace touchable {

namespace {

/// Options as typed; what has a unit of its own on the command line is converted once they are read.
struct TouchWords {
    TouchOptions options;
    double max_stiffness_n_mm = 10;
    double stiffness_slew = 0;  // N/mm per second
    double seconds = 0, picture_seconds = 0;
    CameraTyped camera;
    std::vector<CLI::Option*> fixed_by_recording;
    CLI::Option* clip = nullptr;
    CLI::Option* duration = nullptr;
    CLI::Option* picture_moment = nullptr;
    CLI::Option* slew = nullptr;
};

Result<TouchOptions> read_words(const TouchWords& words) {
    TouchOptions options = words.options;
    options.guard.max_stiffness = words.max_stiffness_n_mm * 1000;
    const auto camera = read_camera(words.camera);
    if (!camera.ok()) return camera.error();
    options.camera = *camera;
    if (words.slew->count() > 0) options.guard.rise.per_tick = words.stiffness_slew * 1000 * tick_seconds;
    if (std::isnan(words.seconds)) return usage_error("--seconds is not a number; must be 0.001 to 1e6");
    if (std::isnan(words.picture_seconds))
        return usage_error("--picture-at is not a number; must be 0 to 1e6");
    if (words.picture_moment->count() > 0)
        options.picture_tick = static_cast<std::int64_t>(words.picture_seconds * 1000 + 0.5);
    if (words.duration->count() > 0) options.ticks = static_cast<std::int64_t>(words.seconds * 1000 + 0.5);
    if (options.ticks && options.picture_tick && *options.picture_tick >= *options.ticks)
        return usage_error("--picture-at lies beyond the run's end; --seconds says when that is");
    if (options.replay) {
        for (const CLI::Option* option : words.fixed_by_recording)
            if (option->count() > 0)
                return usage_error(option->get_name() +
                                   " comes from the recording; leave it out with --replay");
    } else if (words.clip->count() == 0) {
        return usage_error("touch needs a CLIP, or a recording to --replay; see touchable touch -h");
    }
    return options;
}

}  // namespace

void add_touch_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand(
        "touch", "touch a clip with a scripted or recorded hand: forces, figures, a recording");
    auto words = std::make_shared<TouchWords>();
    TouchOptions& o = words->options;
    const Words<TouchMetric> metrics{
        {"world", TouchMetric::world}, {"pixel", TouchMetric::pixel}, {"scaled", TouchMetric::scaled}};
    const Words<FrameInterpolation> interpolations{{"hold", FrameInterpolation::hold},
                                                   {"linear", FrameInterpolation::linear}};

    const Words<bool> rises{{"map", false}, {"passive", true}};

    words->clip =
        add_file_option(*sub, "CLIP", o.clip, "a clip, a folder of images, a depth picture, or a scene file");
    add_file_option(*sub, "--scene", o.scene, "scene file that describes the clip instead of its own");
    add_builder_options(*sub, o.builder, {"auto", "cpu", "vulkan", "lazy", "reference"});
    add_file_option(*sub, "--json", o.json, "write the figures as JSON; -: to standard output");
    add_file_option(*sub, "--forces", o.forces,
                    "write goal, proxy and force of every tick and finger as CSV; -: to standard output");
    auto* record = add_file_option(*sub, "--record", o.record, "keep what it takes to repeat the run");
    auto* replay =
        add_file_option(*sub, "--replay", o.replay, "repeat a recorded run and compare every force with it");
    record->excludes(replay);
    add_overwrite_option(*sub, o.existing);
    sub->add_flag("--strict", o.strict, "end with code 6 where the table begins with a warning");

    add_picture_options(*sub, o.picture);
    words->picture_moment =
        sub->add_option(
               "--picture-at", words->picture_seconds,
               "the moment drawn, seconds; otherwise 60 % of the run (of 3 s where its length is not known)")
            ->needs("--picture")
            ->check(CLI::Range(0.0, 1e6));
    words->duration =
        sub->add_option("--seconds", words->seconds,
                        "length of the run; otherwise that of a recorded hand, or the clip's and at least 3")
            ->check(CLI::Range(0.001, 1e6));
    words->slew =
        sub->add_option("--stiffness-slew", words->stiffness_slew,
                        "N/mm per second: how fast stiffness may rise in contact; otherwise at once");
    words->fixed_by_recording = {
        words->slew,
        words->duration,
        sub->add_flag("--live", o.live, "in real time on the wall clock, each part on a thread of its own"),
        sub->add_flag(
            "--start-buried", o.start_buried,
            "live: a finger that is inside the surface when it first meets it is pushed out at once; "
            "otherwise it feels nothing until it has been free"),
        sub->add_option("--device", o.device,
                        "live: what the hand holds, simulated[:key=value,...] (docs/devices.md); without it "
                        "nothing holds the hand back"),
        sub->add_option("--hand", o.hand,
                        "wander, stroke, press, poke or csv:FILE, each with :key=value,... "
                        "(docs/hands.md)")
            ->capture_default_str(),
        add_whole_option(*sub, "--fingers", o.fingers, "copies of the hand's path, spread on a circle", 1,
                         256)
            ->capture_default_str(),
        add_word_option(*sub, "--metric", o.metric,
                        "where distances are measured: world; to compare, pixel (the paper's) or scaled "
                        "(pixel with levels as long as they are where the finger is)",
                        metrics),
        add_whole_option(*sub, "--median", o.median, "window side instead of the scene's: 0 (off), 3 or 5"),
        add_whole_option(*sub, "--fill-holes", o.fill_holes, "passes instead of the scene's: 0 to 16"),
        add_terrace_option(*sub, o.terraces),
        add_temporal_option(*sub, o.temporal),
        add_word_option(*sub, "--interpolation", o.interpolation,
                        "between frames, instead of the scene's: hold or linear", interpolations),
        sub->add_option("--max-force", o.guard.max_force, "N: what the device can exert on a finger")
            ->capture_default_str(),
        sub->add_option("--max-stiffness", words->max_stiffness_n_mm, "N/mm: what the device renders stably")
            ->capture_default_str(),
        sub->add_option(
               "--stribeck", o.stribeck_speed,
               "m/s: friction falls from static to dynamic about this speed; 0: the moment it slides")
            ->capture_default_str(),
        add_word_option(*sub, "--stiffness", o.guard.rise.paid,
                        "in contact: map (the clip's), or passive (rises only as far as losses pay for)",
                        rises),
        sub->add_option("--damping", o.guard.damping, "N s/m beside the spring, against the hand's motion")
            ->capture_default_str(),
        sub->add_option("--passivity", o.guard.passivity,
                        "N s/m: the most by which a controller may brake to take back created energy; 0: off")
            ->capture_default_str()};

    for (CLI::Option* option : add_camera_options(*sub, words->camera))
        words->fixed_by_recording.push_back(option);
    sub->callback([words, &command] {
        command = [words]() -> Result<void> {
            const auto options = read_words(*words);
            if (!options.ok()) return options.error();
            return run_touch(*options);
        };
    });
}

}  // namespace touchable
