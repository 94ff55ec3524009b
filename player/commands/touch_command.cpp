#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
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

/// Options as typed; values with units are converted after parsing.
struct TouchWords {
    TouchOptions options;
    ClipTyped clip;
    PlaybackTyped playback;
    std::optional<double> seconds, picture_seconds;
    CLI::App* command = nullptr;
    LiveTyped live;
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

/// With --replay the recording defines the run; only the clip's place, the builder and outputs may be given.
Result<void> check_replay(const CLI::App& command) {
    const std::set<std::string> free{"CLIP",      "--scene", "--haptic", "--height",
                                     "--builder", "--gpu",   "--painter"};
    for (const CLI::Option* const option : command.get_options()) {
        const std::string &group = option->get_group(), name = option->get_name();
        if (option->count() > 0 && group != files_topic && group != picture_topic && !free.contains(name))
            return usage_error(name + " comes from the recording; leave it out with --replay");
    }
    return {};
}

Result<TouchOptions> read_words(const TouchWords& words) {
    TouchOptions options = words.options;
    TRY(read_moments(words, options));
    if (options.replay) {
        TRY(check_replay(*words.command));
    } else if (words.clip.choice.file.empty() && !options.session.camera) {
        return usage_error(
            "touch needs a CLIP, a --camera, or a recording to --replay; see touchable touch -h");
    }
    TRY_ASSIGN(auto clip, read_clip(words.clip));
    clip.interpolation = options.session.clip.interpolation;
    options.session.clip = std::move(clip);
    options.session.recorded = options.record.has_value();
    options.session.device_log = options.device_log.has_value();
    TRY(read_live_options(words.live, options.session));
    TRY_ASSIGN(options.session.playback, read_playback(words.playback));
    options.play = words.playback.script;
    return options;
}

/// Adds the options of output files.
void add_file_options(CLI::App& sub, TouchOptions& o) {
    begin_topic(sub, files_topic);
    add_json_option(sub, o.json, "write the figures as JSON", true);
    add_file_option(sub, "--forces", o.forces,
                    "write goal, proxy and force of every tick and finger as CSV. -: to standard output");
    add_file_option(sub, "--device-log", o.device_log,
                    "write positions, buttons and forces of a device that you hold as CSV. It replays as the "
                    "device recorded; -: to standard output");
    auto* record = add_file_option(sub, "--record", o.record, "save what it takes to repeat the run");
    auto* replay =
        add_file_option(sub, "--replay", o.replay, "repeat a recorded run and compare every force with it");
    record->excludes(replay);
    add_overwrite_option(sub, o.existing);
    sub.add_flag("--verbose", o.verbose, "print all figures, not only the first four lines");
    sub.add_flag("--strict", o.strict, "exit with code 6 on any warning");
}

/// Adds the options of the hand and the run's length.
void add_hand_options(CLI::App& sub, TouchWords& words) {
    SessionOptions& session = words.options.session;
    begin_topic(sub, "Hand");
    sub.add_flag("--live", session.live, "run in real time on the wall clock. Each part has its own thread");
    sub.add_option("--hand", session.hand, "how the hand moves. Each takes :key=value,... (docs/touch.md)")
        ->type_name(type_with_words("HAND", hand_words()))
        ->capture_default_str();
    add_whole_option(sub, "--fingers", session.fingers,
                     "number of fingers. They copy the hand's path, spread on a circle", 1, 256)
        ->capture_default_str();
    add_number_option(sub, "--seconds", words.seconds,
                      "length of the run. By default that of a recorded hand or device; with a device that "
                      "you hold, until Ctrl-C; otherwise the clip's, but at least 3",
                      0.001, 1e6)
        ->type_name("SECONDS");
}

/// Adds a run's setting. The run refuses what is in the option's range and still invalid.
CLI::Option* add_setting_option(CLI::App& sub, const SessionSetting& setting, SessionOptions& session) {
    const SettingRange& range = setting.range;
    const bool is_number = range.words.empty();
    const auto read = [&setting, &range, is_number, &session](const std::string& word) -> Result<void> {
        TRY_ASSIGN(const double number,
                   is_number ? read_number("", word, setting.typed.least, setting.typed.most, range.unit)
                             : read_word(range, word));
        setting.set(number, session);
        return {};
    };
    return add_read_option(sub, "--" + setting.name, read, setting.what)
        ->default_str(setting.usual)
        ->type_name(!is_number    ? type_with_words("WORD", range.words)
                    : *range.unit ? range.unit
                                  : "NUMBER");
}

/// Adds the options of the force computation, mostly rarely needed.
void add_force_options(CLI::App& sub, SessionOptions& session) {
    begin_topic(sub, expert_topic);
    sub.add_flag("--start-buried", session.start_buried,
                 "push out a finger that starts inside the surface at once, with --live. Otherwise it feels "
                 "nothing until it has been free");
    for (const SessionSetting& setting : run_settings())
        if (setting.of == SettingOf::felt || setting.of == SettingOf::expert)
            add_setting_option(sub, setting, session);
    for (const char* limit : {"--max-force", "--max-stiffness"}) sub.get_option(limit)->group("Hand");
    sub.get_option("--interpolation")->group("Playback");
}

}  // namespace

void add_touch_command(CLI::App& app, Command& command) {
    auto* sub =
        app.add_subcommand("touch", "touch a clip without a window, by a scripted hand or a haptic device");
    auto words = std::make_shared<TouchWords>();
    TouchOptions& o = words->options;
    words->command = sub;
    add_clip_options(*sub, words->clip);
    add_camera_options(*sub, words->clip.camera);
    add_playback_options(*sub, words->playback);
    add_live_options(*sub, words->live, o.session);
    add_hand_options(*sub, *words);
    add_device_options(*sub, o.held, o.session, false);
    add_filter_options(*sub, words->clip);
    add_file_options(*sub, o);
    add_picture_options(*sub, o.picture);
    add_number_option(*sub, "--picture-at", words->picture_seconds,
                      "when to draw. By default at 60 % of the run (of 3 s where its length is not known)", 0,
                      1e6)
        ->type_name("SECONDS")
        ->needs("--picture");
    sub->get_option("--painter")->group(expert_topic);
    add_force_options(*sub, o.session);
    add_builder_options(*sub, o.session.builder, {"auto", "cpu", "vulkan", "lazy", "reference"});
    set_work(*sub, command, [words]() -> Result<void> {
        TRY_ASSIGN(const auto options, read_words(*words));
        return run_touch(options);
    });
}

}  // namespace touchable
