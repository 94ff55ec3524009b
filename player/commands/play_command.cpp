// SPDX-License-Identifier: Apache-2.0
#include "player/commands/commands.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <system_error>

#include "engine/authoring/segments.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/stream/stream_url.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/option_types.hpp"
#include "player/commands/run_options.hpp"
#include "player/run/terminal.hpp"
#include "player/window/play_window.hpp"

namespace touchable {
namespace {

namespace fs = std::filesystem;

constexpr int smallest_window = 64, largest_window = 8192;

/// Options of a kiosk, as typed.
struct KioskWords {
    bool kiosk = false;
    std::vector<double> idle;
    std::string texts, bar;
    std::optional<fs::path> labels, use_log;
    std::string study;
    std::optional<fs::path> results;
};

/// Options as typed.
struct PlayWords {
    PlayOptions options;
    ClipTyped clip;
    PlaybackTyped playback;
    HeldDeviceWords held;
    std::string size = "1280x720";
    std::optional<fs::path> script;
    std::vector<fs::path> more_clips;
    const CLI::App* command = nullptr;
    std::string dent, light, samples = "2";
    LiveTyped live;
    KioskWords kiosk;
};

/// The file of --video; of numbered pictures the first, and all that are there.
void add_film(const fs::path& video, std::vector<NamedFile>& files) {
    const auto first = numbered_picture(video, 1);
    files.push_back({"--video", first.value_or(video)});
    const fs::path folder = video.has_parent_path() ? video.parent_path() : fs::path(".");
    const std::size_t place = video.filename().string().find('%');
    std::error_code failed;
    for (fs::directory_iterator at(folder, failed), end; first && !failed && at != end;
         at.increment(failed)) {
        const std::string name = at->path().filename().string();
        const long long number = name.size() > place ? std::atoll(name.c_str() + place) : 0;
        if (number > 1 && numbered_picture(video, number)->filename() == name)
            files.push_back({"--video", at->path()});
    }
}

/// Refuses outputs that would replace a file that the window shows or reads, under any name, or an existing
/// file. A clip opened here to list its inputs stays open for the window.
Result<void> check_files(PlayOptions& options, const std::optional<fs::path>& script) {
    Outputs outputs{{}, options.existing};
    if (options.record) outputs.files.push_back({"--record", *options.record});
    if (options.record && options.session.clip.plugged)
        outputs.files.push_back({"the film of --record", film_beside(*options.record)});
    if (options.sound) outputs.files.push_back({"--sound", *options.sound});
    if (options.video) add_film(*options.video, outputs.files);
    if (options.screenshot) outputs.files.push_back({"--screenshot", *options.screenshot});
    std::vector<NamedFile> inputs, saved;
    for (const ScriptedInput& input : options.script) {
        const auto* const event = std::get_if<InputEvent>(&input.what);
        const auto* const command = std::get_if<WindowCommand>(&input.what);
        if (event && event->kind == InputEvent::Kind::dropped)
            inputs.push_back({"what --script drops", event->word});
        if (!command || command->word.empty()) continue;
        if (command->verb == WindowVerb::open) inputs.push_back({"what --script opens", command->word});
        if (command->verb == WindowVerb::screenshot)
            outputs.files.push_back({"a screenshot of --script", command->word});
        if (command->verb == WindowVerb::save_materials)
            saved.push_back({"what --script saves", command->word});
    }
    // Settings may replace only the settings of the last session.
    Outputs kept{outputs.files, Existing::replace};
    if (options.settings_file) kept.files.push_back({"--settings", *options.settings_file});
    kept.files.insert(kept.files.end(), saved.begin(), saved.end());
    if (kept.files.empty()) return {};
    for (const ClipChoice& next : options.next_clips) inputs.push_back({"a clip", next.file});
    if (script) inputs.push_back({"--script", *script});
    if (options.session.clip.scene_file) inputs.push_back({"--scene", *options.session.clip.scene_file});
    if (options.session.clip.plugged) {
        inputs.push_back({"the camera", options.session.clip.file});
    } else if (!options.session.clip.file.empty()) {
        ClipChoice& clip = options.session.clip;
        clip.share_clip();
        const auto reader = clip.open(clip.is_camera() ? Colour::left_out : Colour::wanted);
        if (reader)
            std::ranges::copy(inputs_of(clip, **reader), std::back_inserter(inputs));
        else if (options.next_clips.empty())
            return reader.error();
        else  // the window skips an unreadable clip of several
            inputs.push_back({"a clip", clip.file});
    }
    TRY(check_outputs(kept, inputs));
    return check_outputs(outputs, inputs);
}

/// The named clips, with folders of clips expanded.
Result<void> read_list(const PlayWords& words, PlayOptions& options) {
    std::vector<fs::path> files = clips_of(options.session.clip.file);
    for (const auto& word : words.more_clips)
        for (auto& file : clips_of(word)) files.push_back(std::move(file));
    std::error_code failure;
    // The window names a missing clip of several and skips it, as one that cannot be read.
    if (std::ranges::none_of(files, [&](const auto& file) {
            return is_stream_url(file.string()) || fs::exists(file, failure);
        }))
        return input_error(files.front().string() + ": " + (failure ? failure.message() : "does not exist"));
    options.session.clip.file = files.front();
    for (std::size_t k = 1; k < files.size(); ++k)
        options.next_clips.emplace_back(options.session.clip).file = files[k];
    if (options.next_clips.empty()) return {};
    if (options.record) return usage_error("--record: a recording is of one clip, and not of several");
    if (options.segments) return usage_error("--segments: are those of one clip, and not of several");
    return {};
}

/// For a window without a clip yet: refuses options that need one from the start.
Result<void> check_empty(const PlayOptions& options) {
    const struct {
        bool is_asked_for;
        const char* name;
    } needs[] = {{options.record.has_value(), "--record"},
                 {options.video.has_value(), "--video"},
                 {options.segments.has_value(), "--segments"},
                 {options.session.clip.scene_file.has_value(), "--scene"},
                 {options.kiosk.has_value(), "--kiosk"}};
    for (const auto& need : needs)
        if (need.is_asked_for)
            return usage_error(std::string(need.name) +
                               ": needs a CLIP or a --camera; see touchable play -h");
    return {};
}

/// Options of a film that is drawn offline.
Result<void> check_film(const PlayWords& words, const PlayOptions& options) {
    constexpr int longest_side = 16384;  // of a Vulkan picture, mostly
    const bool is_numbered = options.video && numbered_picture(*options.video, 1);
    if (options.video && !is_numbered && CLI::detail::to_lower(options.video->extension()) == ".png")
        return usage_error("--video " + options.video->string() +
                           ": many pictures need a number in their name, such as shot-%04d.png");
    std::string asked = is_numbered ? "--video " + options.video->string() : "";
    for (const char* const name : {"--fps", "--samples", "--words"})
        if (words.command->count(name) > 0) asked = name;
    if (!asked.empty() && !options.is_offline())
        return usage_error(asked + " applies to a film without a window; give --headless and --video, and " +
                           "neither --camera nor --device");
    const int side = options.film.samples * std::max(options.screen.width, options.screen.height);
    if (options.is_offline() && side > longest_side)
        return usage_error("--samples " + std::to_string(options.film.samples) +
                           ": a side of --size would be " + std::to_string(side) +
                           " samples; must be at most " + std::to_string(longest_side));
    return {};
}

/// Reads the file of --segments; whether it fits the clip is known only once the clip's segments are read.
Result<SegmentNames> read_segment_names(const fs::path& file) {
    TRY_ASSIGN(const auto text,
               read_given_file(file, "--segments " + file.string(),
                               "a file of segments (JSON, docs/content.md)", largest_segment_names));
    return parse_segment_names(text, file.string());
}

bool ends_by_itself(const std::vector<ScriptedInput>& script) {
    return std::ranges::any_of(script, [](const ScriptedInput& input) {
        const auto* const command = std::get_if<WindowCommand>(&input.what);
        return command && command->verb == WindowVerb::quit;
    });
}

/// Whether the program was started from a desktop: stderr is neither a terminal nor a pipe. A run that ends
/// by itself or writes files was started by a script.
bool is_opened_on_desktop(const PlayOptions& options) {
    struct stat error {};
    const bool is_read =
        isatty(STDERR_FILENO) == 1 || fstat(STDERR_FILENO, &error) != 0 || S_ISFIFO(error.st_mode);
    const auto has = [](const char* display) {
        const char* const name = std::getenv(display);
        return name && *name;
    };
    const bool has_display = has("DISPLAY") || has("WAYLAND_DISPLAY");
    return isatty(STDIN_FILENO) == 0 && !is_read && has_display && !options.session.camera &&
           !options.headless && !options.kiosk && !options.study && !options.seconds && !options.record &&
           !options.video && !options.sound && !options.segments && options.script.empty();
}

/// Makes the devices that lead the fingers. The mouse needs none and excludes other devices.
Result<void> hold(const PlayWords& words, PlayOptions& options) {
    HeldDeviceWords held = words.held;
    held.is_looked_for_always = words.kiosk.kiosk;
    const auto mouse = std::ranges::find(held.devices, "mouse");
    if (mouse != held.devices.end() && held.devices.size() > 1)
        return usage_error("--device mouse leads the fingers alone, not beside another device");
    if (mouse != held.devices.end()) held.devices.clear();
    options.session.live = true;
    TRY(hold_devices(held, options.session));
    if (options.session.device)
        return usage_error("--device " + *options.session.device +
                           ": is held by a hand of touchable touch; in a window you hold what is there, or "
                           "lead by the mouse");
    if (!options.session.held_device) return {};
    options.hand = std::make_shared<PersistentDevice>(std::move(options.session.held_device));
    options.session.held_device.reset();
    options.session.control.reset();  // each session has its own
    return {};
}

/// The names of the JSON files in such a folder.
std::string names_there(const fs::path& folder) {
    std::vector<std::string> names;
    std::error_code failed;
    for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed))
        if (at->path().extension() == ".json") names.push_back(at->path().stem().string());
    std::ranges::sort(names);
    return listed(names);
}

Result<KioskTexts> read_texts_of(const fs::path& file, const std::string& named) {
    TRY_ASSIGN(const auto text, read_given_file(file, named, "a file of a kiosk's texts (docs/exhibit.md)",
                                                largest_kiosk_texts));
    return parse_kiosk_texts(text, file.string());
}

/// `asked`: a language or a file; empty: the user's language, if there are texts in it.
Result<KioskTexts> choose_texts(const std::string& asked) {
    const std::string language = asked.empty() ? own_language() : asked;
    if (!is_language(language)) return read_texts_of(asked, "--kiosk-texts " + asked);
    const fs::path folder = folder_from_program(TOUCHABLE_KIOSK_FROM_PROGRAM),
                   file = folder / (language + ".json");
    std::error_code failed;
    if (fs::exists(file, failed)) return read_texts_of(file, file.string());
    if (asked.empty() || language == KioskTexts().language) return KioskTexts();
    return usage_error("--kiosk-texts " + asked + ": there are texts in these languages: " +
                       names_there(folder) + "; must be one of them, or the name of a file");
}

Result<TouchLabels> read_labels(const fs::path& file, const std::optional<fs::path>& segments) {
    TRY_ASSIGN(const auto text, read_given_file(file, "--labels " + file.string(),
                                                "a file of labels (docs/exhibit.md)", largest_labels));
    TRY_ASSIGN(auto labels, parse_touch_labels(text, file.string(), file.parent_path()));
    std::vector<std::string> names;
    if (segments) {
        TRY_ASSIGN(const auto parsed, read_segment_names(*segments));
        for (const NamedSegment& segment : parsed.segments) names.push_back(segment.name);
    }
    if (auto there = labels.has_segments(names); !there)
        return input_error(there.error().message + "; must be a name in the file of --segments");
    return labels;
}

/// Reads each file once, even if several labels use it.
Result<void> read_sounds(PlayOptions::Kiosk& kiosk) {
    std::map<fs::path, std::shared_ptr<const SpokenSound>> read;
    for (const TouchLabel& label : kiosk.labels.labels) {
        const fs::path* const file = said_in(label.sounds, kiosk.texts.language);
        if (file && !read.contains(*file)) {
            TRY_ASSIGN(auto sound, SpokenSound::read(*file));
            read.emplace(*file, std::move(sound));
        }
        kiosk.label_sounds.push_back(file ? read.at(*file) : nullptr);
    }
    return {};
}

/// Reads all files of a kiosk. `segments`: the file of --segments. Nothing: not a kiosk.
Result<std::optional<PlayOptions::Kiosk>> read_kiosk(const KioskWords& words,
                                                     const std::optional<fs::path>& segments) {
    if (!words.kiosk) return std::optional<PlayOptions::Kiosk>();
    if (!words.idle.empty() && words.idle[1] < words.idle[0])
        return usage_error(
            "--idle: a kiosk begins anew, the second time, no sooner than it invites, the first");
    PlayOptions::Kiosk kiosk;
    if (!words.idle.empty()) kiosk.times = {words.idle[0], words.idle[1]};
    TRY_ASSIGN(kiosk.texts, choose_texts(words.texts));
    kiosk.touched_by = has_touch_screen() ? TouchedBy::touch_screen : TouchedBy::mouse;
    if (words.labels) {
        TRY_ASSIGN(kiosk.labels, read_labels(*words.labels, segments));
        TRY(read_sounds(kiosk));
    }
    kiosk.has_bar = words.bar != "off";
    kiosk.use_log = words.use_log;
    return std::optional(std::move(kiosk));
}

/// Reads the file of a study. `clips`: number of clips. Nothing: no study.
Result<std::optional<Study>> read_study(const KioskWords& words, std::size_t clips) {
    if (words.study.empty()) return std::optional<Study>();
    const fs::path folder = folder_from_program(TOUCHABLE_STUDY_FROM_PROGRAM);
    fs::path file = words.study;
    std::error_code failed;
    if (const fs::path known = folder / (words.study + ".json");
        file.filename() == file && !fs::exists(file, failed) && fs::exists(known, failed))
        file = known;
    const std::string named = "--study " + words.study;
    if (!fs::exists(file, failed) && file.extension() != ".json")
        return usage_error(named + ": there are these studies: " + names_there(folder) +
                           "; must be one of them, or the name of a file");
    TRY_ASSIGN(const auto text,
               read_given_file(file, named, "a study (JSON, docs/exhibit.md)", largest_study));
    TRY_ASSIGN(auto study, parse_study(text, file.string()));
    if (study.clips() > clips)
        return usage_error(named + ": has a touch of clip " + std::to_string(study.clips()) +
                           ", and there are " + std::to_string(clips) +
                           "; must be as many CLIPs as the study has");
    return std::optional(std::move(study));
}

Result<PlayOptions> read_words(const PlayWords& words) {
    PlayOptions options = words.options;
    // First, while the process is small and has one thread.
    TRY(hold(words, options));
    TRY_ASSIGN(const auto size, read_pixel_size("--size", words.size, smallest_window, largest_window));
    options.screen.width = size.width;
    options.screen.height = size.height;
    TRY_ASSIGN(options.session.clip, read_clip(words.clip));
    TRY(read_live_options(words.live, options.session));
    const bool is_empty = words.clip.choice.file.empty() && !options.session.camera;
    if (!is_empty && !options.session.clip.plugged) TRY(read_list(words, options));
    TRY_ASSIGN(options.session.playback, read_playback(words.playback));
    if (words.script) TRY(assign(options.script, read_window_script(*words.script)));
    options.film.samples = std::stoi(words.samples);
    options.size_is_stated = words.command->count("--size") > 0;
    if (!words.dent.empty()) options.dent = words.dent == "on";
    if (!words.light.empty()) TRY(assign(options.light, light_after(Lighting::off, words.light)));
    options.filters_are_stated = std::ranges::any_of(words.command->get_options(), [](const auto* option) {
        return option->get_group() == filters_topic && option->count() > 0;
    });
    TRY_ASSIGN(options.kiosk, read_kiosk(words.kiosk, options.segments));
    TRY_ASSIGN(options.study, read_study(words.kiosk, 1 + options.next_clips.size()));
    options.study_results = words.kiosk.results.value_or("");
    if (options.kiosk) options.screen.fullscreen = options.screen.stays = options.screen.awake = true;
    if (is_empty) TRY(check_empty(options));
    if (options.screenshot && !options.seconds) options.seconds = options.screenshot_s;
    if (options.headless && !options.seconds && !ends_by_itself(options.script))
        return usage_error(
            "--headless needs an end: give --seconds or --screenshot, or put quit into --script");
    TRY(check_film(words, options));
    TRY(check_files(options, words.script));
    if (options.segments) TRY(read_segment_names(*options.segments));
    return options;
}

/// Printed after the window is closed.
void print(const PlayFigures& figures) {
    const Spread draw = figures.draw_ms.spread(), input = figures.input_to_picture_ms.spread();
    std::printf("%-24s%lld in %.1f s, %.1f a second, by the %s painter%s\n", "pictures",
                static_cast<long long>(figures.pictures), figures.seconds,
                static_cast<double>(figures.pictures) / std::max(figures.seconds, 1e-3),
                figures.painter.c_str(), figures.gpu.empty() ? "" : (" on " + figures.gpu).c_str());
    std::printf("%-24s%lld of %lld\n", "frames shown in time", static_cast<long long>(figures.frames_in_time),
                static_cast<long long>(figures.frames_due));
    if (draw.max > 0) std::printf("%-24sp50 %.1f, p99 %.1f ms\n", "time per picture", draw.p50, draw.p99);
    if (input.max > 0) std::printf("%-24sp50 %.1f, p99 %.1f ms\n", "input to picture", input.p50, input.p99);
    const auto& [feed, ticks, late_frames] = figures.sessions;
    std::printf("%-24s%lld, %lld too late\n", "ticks", static_cast<long long>(ticks.ticks),
                static_cast<long long>(ticks.late));
    if (!feed.builder.empty())  // empty: there was no clip
        std::printf("%-24s%lld, %lld late, %lld left out, by the %s builder\n", "frames",
                    static_cast<long long>(feed.frames), static_cast<long long>(late_frames),
                    static_cast<long long>(feed.dropped), feed.builder.c_str());
    if (!figures.relief.empty()) std::printf("%-24s%s\n", "relief", one_line(figures.relief).c_str());
    if (!figures.materials.empty())
        std::printf("%-24s%s\n", "materials", one_line(figures.materials).c_str());
    if (figures.film_pictures > 0)
        std::printf("%-24s%lld pictures, %lld left out\n", "film",
                    static_cast<long long>(figures.film_pictures),
                    static_cast<long long>(figures.film_left_out));
}

/// For a visible window only; a headless one is the same for every user. Finds the user's settings file and
/// the folder of brush strokes, which survive a crash.
void find_own_files(PlayOptions& options) {
    if (options.headless || options.kiosk) return;
    const auto find = [](std::optional<fs::path>& place, Result<fs::path> own, const char* what) {
        if (own)
            place = std::move(*own);
        else
            say_on_stderr(std::string("warning: ") + what + " are not kept: " + own.error().message);
    };
    if (!options.settings_file) find(options.settings_file, own_settings_file(), "settings");
    if (!options.brush_history)
        find(options.brush_history, own_folder("XDG_STATE_HOME", ".local/state"), "changes by the brush");
}

std::string tell_saved(const std::string& clip, const std::string& file) {
    return "saved as " + file + "; touchable materials " + shell_word(clip) + " OUT.mkv --segments " +
           shell_word(file) + " writes the clip with it";
}

std::string tell_relief(const std::string& clip, const std::map<std::string, std::string>& in_effect) {
    std::string words = "to keep it: touchable relief " + shell_word(clip) + " OUT.mkv";
    for (const auto& [setting, option] : {std::pair{"relief", " --amount "},
                                          {"relief-height", " --max-height "},
                                          {"relief-fine", " --fine "},
                                          {"relief-medium", " --medium "},
                                          {"relief-coarse", " --coarse "}})
        words += option + in_effect.at(setting);
    return words + (in_effect.at("relief-invert") == "on" ? " --invert" : "");
}

std::string tell_faster(const std::string& clip) {
    return "touchable convert " + shell_word(clip) + " OUT.mkv writes a clip that is read faster";
}

Result<void> run_play(PlayOptions options) {
    find_own_files(options);
    options.names = {
        "--record",     "--sound",           "--video",
        "--screenshot", remark_with_options, tell_saved,
        tell_relief,    tell_faster,         [](const Error& error) { return message_with_options(error); }};
    const bool is_told_at_once = options.headless || options.kiosk;
    TRY_ASSIGN(auto figures, play_in_window(std::move(options)));
    print(figures);
    // Otherwise it was printed when it occurred.
    if (!figures.sound_fault.empty() && !is_told_at_once) say_on_stderr("warning: " + figures.sound_fault);
    if (!figures.slow_reading.empty()) say_on_stderr("warning: " + figures.slow_reading);
    return {};
}

void add_kiosk_options(CLI::App& sub, KioskWords& words) {
    begin_topic(sub, "Kiosk");
    auto* const kiosk =
        sub.add_flag("--kiosk", words.kiosk,
                     "unattended exhibit mode: full screen, loops for ever. Invites visitors to touch, and "
                     "nothing that they do ends it (docs/exhibit.md)")
            ->excludes("--record")
            ->excludes("--settings")
            ->excludes("--brush-history");
    add_number_option(sub, "--idle", words.idle,
                      "seconds without a touch until a kiosk invites to touch, and until it starts over. 20 "
                      "60 by default",
                      0.1, 1e6)
        ->expected(2)
        ->type_name("INVITE RESTART")
        ->needs(kiosk);
    sub.add_option("--kiosk-texts", words.texts,
                   "language of a kiosk (en, de), or a file of its texts. By default your own language "
                   "(docs/exhibit.md)")
        ->needs(kiosk)
        ->type_name("LANGUAGE|FILE");
    add_word_option(sub, "--kiosk-bar", words.bar,
                    "whether a kiosk shows a bar of large buttons. on by default", {"on", "off"})
        ->needs(kiosk);
    add_file_option(sub, "--labels", words.labels,
                    "captions and sounds for places in the clip, given where a finger rests "
                    "(docs/exhibit.md)")
        ->needs(kiosk);
    add_file_option(sub, "--use-log", words.use_log,
                    "add each visit to a kiosk, and each fault, to this CSV file")
        ->needs(kiosk);
    auto* const study = sub.add_option("--study", words.study,
                                       "run a user study: what participants read, touch and answer. One "
                                       "that comes with the program (paper-4.2), or a file "
                                       "(docs/exhibit.md)")
                            ->needs(kiosk)
                            ->excludes("--labels")
                            ->excludes("--kiosk-bar")
                            ->excludes("--idle")
                            ->type_name("NAME|FILE");
    auto* const results =
        sub.add_option("--results", words.results, "folder for a CSV file of each participant of --study")
            ->needs(study)
            ->type_name("FOLDER");
    study->needs(results);
}

void add_window_options(CLI::App& sub, PlayWords& words) {
    PlayOptions& o = words.options;
    begin_topic(sub, "Window");
    sub.add_option("--size", words.size, "size of the window in pixels")
        ->type_name("WxH")
        ->capture_default_str();
    add_number_option(sub, "--scale", o.scale,
                      "size of words and bars, 0.8 to 4. By default as display and window ask for", 0.8, 4);
    sub.add_flag("--fullscreen,--fs", o.screen.fullscreen, "fill the screen (F11 does so later)");
    add_word_option(sub, "--dent", words.dent,
                    "show how the surface gives way under a finger. Changes no force; by default as in the "
                    "last window, at first on",
                    {"on", "off"});
    add_word_option(sub, "--light", words.light,
                    "light on the clip's colours, which shows relief. By default as in the last window, at "
                    "first off",
                    {light_names.begin(), light_names.end()});
    add_number_option(sub, "--seconds", o.seconds, "close the window after so many seconds", 0.1, 1e6)
        ->type_name("SECONDS");
    sub.add_flag("--rumble", o.rumble, "let a gamepad that is plugged in rumble with what is felt");
    begin_topic(sub, files_topic);
    auto* picture =
        add_file_option(sub, "--screenshot", o.screenshot, "save what the window shows in the end as a PNG")
            ->check(ends_in({".png"}, "a picture"));
    add_number_option(sub, "--at", o.screenshot_s,
                      "when to take --screenshot, in seconds after the window opens", 0.1, 1e6)
        ->type_name("SECONDS")
        ->needs(picture)
        ->capture_default_str();
    sub.get_option("--seconds")->excludes("--at");
    add_file_option(sub, "--record", o.record,
                    "save what it takes to repeat the touch. touchable touch --replay FILE repeats it");
    add_file_option(
        sub, "--video", o.video,
        "save what is seen and heard as a film, .mp4 or .mkv. With --headless each picture is "
        "drawn at its moment, however long it takes, also as shot-%04d.png (from 1), without sound")
        ->check(ends_in({".mp4", ".mkv", ".png"}, "a film"));
    add_whole_option(sub, "--fps", o.film.rate, "pictures a second of --video with --headless, 1 to 240", 1,
                     FilmWriter::most_rate)
        ->capture_default_str();
    add_word_option(sub, "--samples", words.samples, "samples along a pixel's side in that film",
                    {"1", "2", "4"})
        ->default_str(words.samples);
    sub.add_flag("--words", o.film.has_words, "show bars and words in that film (H does so later)");
    add_file_option(sub, "--sound", o.sound, "save what is heard as a WAV file")
        ->check(ends_in({".wav"}, "sound"));
    add_file_option(sub, "--segments", o.segments,
                    "let segments feel like the materials in this file, NAME.json (docs/content.md)")
        ->excludes("--record")
        ->excludes("--camera");
    add_file_option(sub, "--settings", o.settings_file,
                    "keep settings from one window to the next in this file, instead of your own");
    sub.add_option("--brush-history", o.brush_history,
                   "keep what the material brush changed in this folder, instead of your own")
        ->type_name("FOLDER");
    add_overwrite_option(sub, o.existing);
    begin_topic(sub, expert_topic);
    add_painter_option(sub, o.painter);
    sub.add_flag("--headless", o.headless, "draw what the window would show, without a window");
    add_file_option(sub, "--script", words.script,
                    "timed inputs, as a person would give them (docs/play.md)");
}

}  // namespace

void add_play_command(CLI::App& app, Command& command) {
    auto words = std::make_shared<PlayWords>();
    CLI::App* const sub =
        app.add_subcommand("play", "watch a clip in a window and touch it with the mouse or a device");
    words->command = sub;
    SessionOptions& session = words->options.session;
    add_clip_options(*sub, words->clip);
    add_file_option(*sub, "MORE", words->more_clips,
                    "further clips, shown one after another. A folder of clips stands for all of them")
        ->expected(0, -1);
    add_live_options(*sub, words->live, session);
    add_camera_options(*sub, words->clip.camera);
    add_playback_options(*sub, words->playback);
    // In a window the user gives later commands.
    sub->remove_option(sub->get_option("--play"));
    add_window_options(*sub, *words);
    add_kiosk_options(*sub, words->kiosk);
    add_device_options(*sub, words->held, session, true);
    const SettingRange& force = session_setting("max-force")->range;
    add_number_option(*sub, "--max-force", words->options.most_newtons,
                      "largest force on a finger, whatever the panel says", force.least, force.most)
        ->type_name(force.unit);
    add_filter_options(*sub, words->clip);
    add_builder_options(*sub, session.builder, {"auto", "cpu", "vulkan"});
    set_work(*sub, command, [words]() -> Result<void> {
        TRY_ASSIGN(auto options, read_words(*words));
        options.stays_without_clip = !words->clip.choice.file.empty() && is_opened_on_desktop(options);
        return run_play(std::move(options));
    });
}

}  // namespace touchable
