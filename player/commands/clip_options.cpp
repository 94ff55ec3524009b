// SPDX-License-Identifier: Apache-2.0
#include "player/commands/clip_options.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/session/touch_setup.hpp"

namespace touchable {

namespace {

/// Numbers separated by commas; empty if one of them is invalid.
std::vector<double> numbers_in(std::string_view text) {
    std::vector<double> numbers;
    while (true) {
        const std::string_view part = text.substr(0, text.find(','));
        const auto number = parsed_number(part);
        if (!number) return {};
        numbers.push_back(*number);
        if (part.size() == text.size()) return numbers;
        text.remove_prefix(part.size() + 1);
    }
}

/// Pixels are nearly square: other focal lengths are typed with a decimal comma.
Result<SourceDescription> with_likely_pixels(SourceDescription known, const std::string& typed) {
    constexpr double most = 2;
    const double fx = known.intrinsics->fx, fy = std::abs(known.intrinsics->fy);
    if (fx <= most * fy && fy <= most * fx) return known;
    return usage_error(
        formatted("--intrinsics '%s': fx is %s and fy %s, one more than twice the other, as of no camera; "
                  "must be FX,FY or FX,FY,CX,CY in pixels, with a decimal point, such as 525.5,525.5",
                  printable(typed).c_str(), short_number(fx).c_str(), short_number(fy).c_str()));
}

Result<void> read_source_setting(const SourceSetting& setting, const std::string& word,
                                 SourceDescription& known) {
    const SettingRange& range = setting.range;
    SourceSetting::Value value = word;
    if (setting.is_number()) TRY(assign(value, read_number("", word, range.least, range.most, setting.form)));
    if (setting.state(value, known)) return {};
    if (setting.name != Setting::preset) return not_allowed("", word, range.in_words());
    const std::vector<std::string> names(range.words.begin(), range.words.end());
    const std::string meant = nearest_word(word, names);
    if (meant.empty()) return not_allowed("", word, "one of " + listed(names));
    return usage_error(printable(word) + " is not allowed: did you mean " + meant + "?");
}

/// Adds the options of what describes pictures, or of what is stated beside that.
void add_source_options(CLI::App& sub, CameraTyped& typed, bool describes) {
    CLI::Option* const scene = sub.get_option_no_throw("--scene");
    for (const SourceSetting& setting : source_settings()) {
        if (setting.describes != describes) continue;
        const auto read = [&typed, &setting](const std::string& word) {
            return read_source_setting(setting, word, typed.known);
        };
        const auto& words = setting.range.words;
        CLI::Option* const option =
            add_read_option(sub, "--" + with_dashes(setting.name), read, setting.what)
                ->type_name(words.empty() ? setting.form : type_with_words(setting.form, words));
        if (describes && scene) option->excludes(scene);
    }
}

/// Puts a part of the list into `choice`; returns what is wrong with it, or "".
std::string why_not(const std::string& name, const std::optional<std::string>& value,
                    ClipChoice::Filters& choice) {
    if (name == "off" || name == "auto") return ": it stands alone, without other filters";
    std::vector<std::string> names;
    for (const FilterSetting& setting : filter_settings()) {
        const std::string_view in_list = setting.in_list;  // "NAME", "NAME[=...]"
        names.emplace_back(in_list.substr(0, in_list.find_first_of("[=")));
        if (name.empty() || name != names.back()) continue;
        if (!setting.is_default(choice.settings)) return ": " + name + " is named twice";
        const std::string word = value.value_or(setting.usual);
        const bool is_read = choice.state(setting, word) && !setting.is_default(choice.settings);
        return is_read ? "" : ": it needs " + setting.right() + ", and what is off is left out";
    }
    const std::string meant = nearest_word(name, names);
    return meant.empty() ? ": there is no such filter" : ": did you mean " + meant + "?";
}

Result<void> take_stream(SessionOptions& session) {
    if (session.camera || !session.live) return {};
    TRY(choose_stream(session.clip));
    if (session.clip.plugged) session.camera = "stream:" + session.clip.file.string();
    return {};
}

}  // namespace

Result<void> choose_stream(ClipChoice& clip) {
    const std::string words = clip.file.string();
    if (clip.is_camera() || !is_stream_url(words)) return {};
    TRY_ASSIGN(auto url, read_stream_url(words));
    StreamSource source{.url = url};
    if (url.transport == StreamTransport::http && !url.is_playlist()) {
        TRY_ASSIGN(auto found, open_http(url));
        if (found.file) return {};
        source.connection = std::move(found.stream);
    }
    clip.choose({std::move(source), {}, {}});
    return {};
}

void add_camera_options(CLI::App& sub, CameraTyped& typed) {
    begin_topic(sub, "Camera");
    CLI::Option* const intrinsics =
        sub.add_option("--intrinsics", typed.intrinsics,
                       "focal lengths and principal point in pixels, or a file with them. For pictures "
                       "without a scene file; camera files are JSON, YAML or calib.txt")
            ->type_name("FX,FY[,CX,CY]|FILE");
    add_source_options(sub, typed, true);
    sub.get_option("--fov")->excludes(intrinsics);
    if (CLI::Option* const scene = sub.get_option_no_throw("--scene"); scene) intrinsics->excludes(scene);
}

Result<SourceDescription> read_camera(const CameraTyped& typed) {
    SourceDescription known = typed.known;
    if (!typed.intrinsics) return known;
    const std::vector<double> numbers = numbers_in(*typed.intrinsics);
    if (numbers.size() == 2 || numbers.size() == 4) {
        known.intrinsics = Intrinsics{.fx = numbers[0], .fy = numbers[1]};
        if (numbers.size() == 4) known.intrinsics->cx = numbers[2];
        if (numbers.size() == 4) known.intrinsics->cy = numbers[3];
        return with_likely_pixels(std::move(known), *typed.intrinsics);
    }
    std::error_code ignored;
    if (numbers.empty() && typed.intrinsics->find_first_of("./") != std::string::npos &&
        !std::filesystem::exists(*typed.intrinsics, ignored))
        return input_error(printable(*typed.intrinsics) + ": does not exist: must be a file of the camera");
    if (!std::filesystem::exists(*typed.intrinsics, ignored))
        return not_allowed("--intrinsics", *typed.intrinsics,
                           "FX,FY or FX,FY,CX,CY in pixels, such as 525,525, or a file of the camera");
    TRY_ASSIGN(known.intrinsics, read_intrinsics(*typed.intrinsics));
    known.file = *typed.intrinsics;
    return with_likely_pixels(std::move(known), *typed.intrinsics);
}

Result<ClipChoice::Filters> read_filters(const std::string& typed) {
    if (typed == "auto") return ClipChoice::Filters{.measured = all_unstated};
    ClipChoice::Filters choice = ClipChoice::Filters::off();
    if (typed == "off") return choice;
    for (std::size_t at = 0, end = 0; end != std::string::npos; at = end + 1) {
        end = typed.find(',', at);
        const std::string part = typed.substr(at, end == std::string::npos ? end : end - at);
        const std::size_t equals = part.find('=');
        const auto value =
            equals == std::string::npos ? std::nullopt : std::optional(part.substr(equals + 1));
        if (const std::string why = why_not(part.substr(0, equals), value, choice); !why.empty())
            return usage_error(refused_value(part) + " is not allowed" + why +
                               "; must be auto, off, or a comma-separated list of filters to enable, such "
                               "as median=5,terraces,temporal=1.5+2e-6,holes=2");
    }
    return choice;
}

CLI::Option* add_clip_options(CLI::App& sub, ClipTyped& typed) {
    begin_topic(sub, "Clip");
    auto* clip = add_file_option(sub, "CLIP", typed.choice.file,
                                 "clip, folder of pictures, depth picture, scene file or stream. A stream is "
                                 "an address (tcp://, http://, srt://, udp://) or - for standard input");
    add_file_option(sub, "--scene", typed.choice.scene_file,
                    "describe the clip by this scene file instead of its own");
    add_file_option(sub, "--haptic", typed.choice.maps.haptic,
                    "map of stiffness and friction for all frames, instead of the clip's. A picture (RGB, or "
                    "grey for stiffness alone), X3D or glTF");
    add_file_option(sub, "--height", typed.choice.maps.height,
                    "map of heights for all frames, instead of the clip's. A grey picture");
    add_word_option(sub, "--align", typed.choice.alignment,
                    "bring guessed depth without a scale to one scale for all frames. auto (default): of "
                    "pictures and videos without a scale whose depth pumps",
                    {"auto", "on", "off"});
    add_word_option(sub, "--fill-from-motion", typed.choice.fill_from_motion,
                    "fill holes in depth from frames that saw the background. The camera must stand still",
                    {"off", "on"});
    add_source_options(sub, typed.camera, false);
    return clip;
}

void add_filter_options(CLI::App& sub, ClipTyped& typed) {
    ClipChoice& clip = typed.choice;
    const auto read_all = [&clip](const std::string& words) -> Result<void> {
        TRY_ASSIGN(clip.filters, read_filters(words));
        return {};
    };
    std::vector<const char*> parts{"auto", "off"};
    for (const FilterSetting& setting : filter_settings())
        if (*setting.in_list) parts.push_back(setting.in_list);
    begin_topic(sub, filters_topic);
    add_read_option(sub, "--filters", read_all,
                    "which filters clean depth, instead of the scene's. auto: what the first frames need; "
                    "off: none; or a comma-separated list of filters to enable")
        ->type_name(type_with_words("LIST", parts));
    add_number_option(sub, "--detail", clip.single_filters.measured.detail, detail_words, 0, 1);
    for (const FilterSetting& setting : filter_settings()) {
        if (!*setting.what) continue;
        const auto read = [&clip, &setting](const std::string& word) -> Result<void> {
            if (clip.single_filters.state(setting, word)) return {};
            return not_allowed("", word, setting.right());
        };
        const auto& words = setting.range.words;
        const bool has_only_words = !words.empty() && !setting.length;
        add_read_option(sub, "--" + with_dashes(setting.name), read,
                        setting.what + (has_only_words ? std::string() : " Must be " + setting.right()))
            ->type_name(words.empty() ? "N"
                                      : type_with_words(setting.length ? "off|on|C[,Q]" : "WORD", words));
    }
}

void add_filtered_options(CLI::App& sub, ClipTyped& typed, const std::string& verb) {
    add_filter_options(sub, typed);
    typed.filters_need_filtered = true;
    sub.add_flag("--filtered", typed.filtered,
                 verb +
                     " the depth that filters leave, in place of what is stored. Holes stay holes unless a "
                     "filter fills them");
}

Result<ClipChoice> read_clip(const ClipTyped& typed) {
    ClipChoice choice = typed.choice;
    const bool has_filters = choice.filters.stated.any() || choice.filters.measured.any() ||
                             choice.single_filters.stated.any() || choice.single_filters.measured.detail;
    if (has_filters && typed.filters_need_filtered && !typed.filtered)
        return usage_error("filters are for --filtered: add it, or leave them out");
    TRY_ASSIGN(choice.camera, read_camera(typed.camera));
    if (choice.single_filters.measured.detail && choice.filters.stated.any())
        return usage_error(
            "--detail chooses filters, and --filters states them: give one, or --filters auto");
    return choice;
}

std::vector<NamedFile> inputs_of(const ClipChoice& clip, const ClipReader& reader) {
    std::vector<NamedFile> inputs;
    if (clip.scene_file) inputs.push_back({"--scene", *clip.scene_file});
    inputs.push_back({"the clip", clip.file});
    for (const auto& file : reader.inputs()) inputs.push_back({"a file of the clip", file});
    return inputs;
}

void add_live_options(CLI::App& sub, LiveTyped& typed, SessionOptions& session) {
    begin_topic(sub, "Camera");
    sub.add_option(
           "--camera", session.camera,
           "touch a live camera instead of CLIP. v4l2: one that is plugged in; pipe and tcp: a "
           "program that sends frames; stream: what CLIP takes; replay: a recording that behaves like "
           "a camera. v4l2 and replay take ,key=value,... (docs/streaming.md)")
        ->type_name(type_with_words("CAMERA", camera_words()));
    typed.latency =
        add_whole_option(sub, "--latency", typed.latency_ms,
                         "longest wait for late frames of a live stream. Less where its jitter allows", 1,
                         5000)
            ->type_name("MS")
            ->capture_default_str();
    add_number_option(sub, "--stale-after", typed.stale_after_ms,
                      "stop feeling a live surface after so long without a new frame. 0: keep it; default: "
                      "of a stream 250 or three frames, whichever is longer; of a camera 0",
                      0, 3'600'000)
        ->type_name("MS");
}

Result<void> read_live_options(const LiveTyped& typed, SessionOptions& session) {
    if (typed.stale_after_ms) session.stale_after_ns = std::llround(*typed.stale_after_ms * 1e6);
    if (session.camera) {
        if (!session.clip.file.empty())
            return usage_error("CLIP and --camera are two things to touch; leave one of them out");
        TRY_ASSIGN(const auto camera, read_live_camera(*session.camera));
        session.clip.choose(camera);
    }
    TRY(take_stream(session));
    auto& plugged = session.clip.plugged;
    auto* const stream = plugged ? std::get_if<StreamSource>(&*plugged) : nullptr;
    if (stream) stream->latency = std::chrono::milliseconds(typed.latency_ms);
    if (stream || typed.latency->count() == 0) return {};
    return usage_error(
        "--latency is for a stream that is touched live, such as touchable touch --live tcp://HOST:PORT");
}

}  // namespace touchable
