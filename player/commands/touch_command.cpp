#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <limits>
#include <memory>
#include <set>
#include <string>

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
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
    std::optional<double> seconds, picture_seconds, stale_after_ms;
    CLI::App* command = nullptr;
    CLI::Option* clip_word = nullptr;
    CLI::Option* latency = nullptr;
};

/// The run's length and the picture's moment, in ticks.
Result<void> read_moments(const TouchWords& words, TouchOptions& options) {
    const auto in_ticks = [](double seconds) { return static_cast<std::int64_t>(seconds * 1000 + 0.5); };
    auto& ticks = options.session.ticks;
    if (words.picture_seconds) options.picture_tick = in_ticks(*words.picture_seconds);
    if (words.seconds) ticks = in_ticks(*words.seconds);
    if (ticks && options.picture_tick && *options.picture_tick >= *ticks)
        return usage_error("--picture-at lies beyond the run's end; --seconds says when that is");
    return {};
}

/// With --replay a recording says all of the run; but where the clip is now, how it is built, what is
/// written.
Result<void> check_replay(const CLI::App& command) {
    const std::set<std::string> free{"CLIP",      "--scene", "--haptic", "--height",
                                     "--builder", "--gpu",   "--painter"};
    for (const CLI::Option* const option : command.get_options()) {
        const std::string &group = option->get_group(), name = option->get_name();
        if (option->count() > 0 && group != "Files" && group != "A picture" && !free.contains(name))
            return usage_error(name + " comes from the recording; leave it out with --replay");
    }
    return {};
}

Result<TouchOptions> read_words(const TouchWords& words) {
    TouchOptions options = words.options;
    TRY(read_moments(words, options));
    if (options.replay) {
        TRY(check_replay(*words.command));
    } else if (words.clip_word->count() == 0 && !options.session.camera) {
        return usage_error(
            "touch needs a CLIP, a --camera, or a recording to --replay; see touchable touch -h");
    }
    TRY_ASSIGN(auto clip, read_clip(words.clip));
    clip.interpolation = options.session.clip.interpolation;
    options.session.clip = std::move(clip);
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
    add_file_option(sub, "--device-log", o.device_log,
                    "of a device that you hold: places, buttons and forces of every tick as CSV, which "
                    "replays as a device; -: to standard output");
    auto* record = add_file_option(sub, "--record", o.record, "keep what it takes to repeat the run");
    auto* replay =
        add_file_option(sub, "--replay", o.replay, "repeat a recorded run and compare every force with it");
    record->excludes(replay);
    add_overwrite_option(sub, o.existing);
    sub.add_flag("--verbose", o.verbose, "print the whole table of figures, not the four lines of it");
    sub.add_flag("--strict", o.strict, "end with code 6 where the first line is a warning");
}

/// What touches, and for how long.
void add_hand_options(CLI::App& sub, TouchWords& words) {
    SessionOptions& session = words.options.session;
    sub.add_flag("--live", session.live, "in real time on the wall clock, each part on a thread of its own");
    sub.add_option(
           "--hand", session.hand,
           "wander, stroke, press, poke, csv:FILE or rec:FILE, each with :key=value,... (docs/touch.md)")
        ->capture_default_str();
    add_whole_option(sub, "--fingers", session.fingers, "copies of the hand's path, spread on a circle", 1,
                     256)
        ->capture_default_str();
    add_number_option(sub, "--seconds", words.seconds,
                      "length of the run; otherwise that of a recorded hand or device; with a device that "
                      "you hold until Ctrl-C; else the clip's and at least 3",
                      0.001, 1e6);
}

/// A run's setting. Numbers may be any: the run refuses those that cannot be.
CLI::Option* add_setting_option(CLI::App& sub, const SessionSetting& setting, SessionOptions& session) {
    const SettingRange& range = setting.range;
    const bool is_number = range.words.empty();
    const auto read = [&setting, &range, is_number, &session](const std::string& word) -> Result<void> {
        using Limits = std::numeric_limits<double>;
        const auto number =
            is_number ? read_number("", word, Limits::lowest(), Limits::max()) : read_word(range, word);
        if (!number) return number.error();
        setting.set(*number, session);
        return {};
    };
    return add_read_option(sub, "--" + setting.name, read,
                           (is_number ? range.unit : range.in_words()) + ". " + setting.what)
        ->default_str(setting.usual)
        ->type_name(is_number ? "FLOAT" : "WORD");
}

/// How forces come about. Few people need most of it.
void add_force_options(CLI::App& sub, SessionOptions& session) {
    sub.add_flag("--start-buried", session.start_buried,
                 "live: a finger that is inside the surface when it first meets it is pushed out at once; "
                 "otherwise it feels nothing until it has been free");
    for (const SessionSetting& setting : run_settings())
        if (setting.of == SettingOf::felt || setting.of == SettingOf::expert)
            add_setting_option(sub, setting, session);
    for (const char* limit : {"--max-force", "--max-stiffness"}) sub.get_option(limit)->group("The hand");
    sub.get_option("--interpolation")->group("Filters of depth");
}

}  // namespace

void add_touch_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand(
        "touch", "touch a clip with a scripted or recorded hand: forces, figures, a recording");
    auto words = std::make_shared<TouchWords>();
    TouchOptions& o = words->options;
    words->command = sub;
    // In the help each option stands under what it is about; what few people need comes last.
    const auto begin_group = [sub](const char* name) { sub->option_defaults()->group(name); };
    begin_group("The clip");
    words->clip_word = add_clip_options(*sub, words->clip);
    add_camera_options(*sub, words->clip.camera);
    add_playback_options(*sub, words->playback);
    add_live_camera_option(*sub, o.session);
    words->latency = add_latency_option(*sub, o.session);
    add_stale_after_option(*sub, words->stale_after_ms);
    begin_group("The hand");
    add_hand_options(*sub, *words);
    add_device_options(*sub, o.held, o.session, false);
    add_filter_options(*sub, words->clip);
    begin_group("Files");
    add_file_options(*sub, o);
    begin_group("A picture");
    add_picture_options(*sub, o.picture);
    add_number_option(
        *sub, "--picture-at", words->picture_seconds,
        "the moment drawn, seconds; otherwise 60 % of the run (of 3 s where its length is not known)", 0, 1e6)
        ->needs("--picture");
    begin_group("Expert");
    sub->get_option("--painter")->group("Expert");
    add_force_options(*sub, o.session);
    add_builder_options(*sub, o.session.builder, {"auto", "cpu", "vulkan", "lazy", "reference"});
    sub->callback([words, &command] {
        command = [words]() -> Result<void> {
            TRY_ASSIGN(const auto options, read_words(*words));
            return run_touch(options);
        };
    });
}

}  // namespace touchable
