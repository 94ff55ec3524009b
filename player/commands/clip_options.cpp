#include "player/commands/clip_options.hpp"

#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {

namespace {

/// Numbers between commas; fewer where one of them is none.
std::vector<double> numbers_in(std::string_view text) {
    std::vector<double> numbers;
    while (true) {
        const std::string_view part = text.substr(0, text.find(','));
        double number = 0;
        const auto [end, failure] = std::from_chars(part.data(), part.data() + part.size(), number);
        if (failure != std::errc() || end != part.data() + part.size() || !std::isfinite(number)) return {};
        numbers.push_back(number);
        if (part.size() == text.size()) return numbers;
        text.remove_prefix(part.size() + 1);
    }
}

/// Pixels are nearly as high as wide: other focal lengths come of a comma in place of a point.
Result<std::optional<SourceDescription>> with_likely_pixels(SourceDescription known,
                                                            const std::string& typed) {
    constexpr double most = 2;
    const double fx = known.intrinsics->fx, fy = std::abs(known.intrinsics->fy);
    if (fx <= most * fy && fy <= most * fx) return std::optional(std::move(known));
    std::string message = "--intrinsics '" + printable(typed);
    message += "': fx is ";
    message += short_number(fx);
    message += " and fy " + short_number(fy);
    return usage_error(
        message +
        ", one more than twice the other, as of no camera; right would be FX,FY or FX,FY,CX,CY "
        "in pixels, with a decimal point, such as 525.5,525.5");
}

Error refusal(std::string_view part, const std::string& why) {
    return usage_error("--filters '" + std::string(part) + "' will not do" + why +
                       "; right would be auto, off, or those that shall be on, such as "
                       "median=5,terraces,temporal=1.5+2e-6,holes=2");
}

/// What is wrong with a part of the list.
std::string why_not(std::string_view name) {
    const std::array<std::string, 5> names{"median", "holes", "terraces", "temporal", "flying"};
    if (name == "off" || name == "auto") return ": it stands alone, without other filters";
    if (name == "median") return ": the window's side is 3 or 5";
    if (name == "holes") return ": passes are a whole number, 1 to 16";
    if (name == "terraces") return ": it takes no value";
    if (name == "flying" || name == "temporal")
        return ": it needs a length above 0, in scene units, as in " + std::string(name) + "=1.5 or " +
               std::string(name) + "=1.5+2e-6";
    const std::string meant = nearest_word(name, names);
    return meant.empty() ? "" : ": did you mean " + meant + "?";
}

/// C or C+Q, not zero.
bool read_length(std::string_view value, DepthLength& length) {
    const auto read = as_depth_length(value, '+');
    if (read) length = *read;
    return read && *read != DepthLength{};
}

/// One word of the list; `value`: what stands behind its =, or nothing.
bool read_filter(std::string_view name, std::string_view value, FilterSettings& filter) {
    if (name == "median" && (value.empty() || value == "3" || value == "5")) {
        filter.median = value == "3" ? 3 : 5;
        return true;
    }
    if (name == "holes") {
        const double passes = value.empty() ? 2 : as_number(value).value_or(0);
        if (!(passes >= 1 && passes <= 16 && passes == std::floor(passes))) return false;
        filter.fill_holes = static_cast<int>(passes);
        return true;
    }
    if (name == "terraces" && value.empty()) {
        filter.terraces = TerraceRemoval::on;
        return true;
    }
    if (name == "flying") return read_length(value, filter.flying_pixels);
    if (name != "temporal") return false;
    filter.temporal = true;
    return value.empty() || read_length(value, filter.temporal_noise);
}

/// --terraces, instead of the scene's own.
CLI::Option* add_terrace_option(CLI::App& sub, std::optional<TerraceRemoval>& terraces) {
    const Words<TerraceRemoval> words{
        {"off", TerraceRemoval::off}, {"on", TerraceRemoval::on}, {"auto", TerraceRemoval::automatic}};
    return add_word_option(
        sub, "--terraces", terraces,
        "remove those of coarse depth, instead of the scene's: off, on, or auto (where kappa "
        "says that it helps; see touchable info)",
        words);
}

CLI::Validator is_median_side() {
    return {[](std::string& side) {
                return side == "0" || side == "3" || side == "5"
                           ? std::string()
                           : "'" + side + "' will not do; right would be 0 (off), 3 or 5";
            },
            ""};
}

Result<void> take_stream(SessionOptions& session) {
    const std::string words = session.clip.file.string();
    if (session.camera || !session.live || !is_stream_url(words)) return {};
    TRY_ASSIGN(auto url, read_stream_url(words));
    StreamSource source{.url = url};
    if (url.transport == StreamTransport::http && !url.is_playlist()) {
        TRY_ASSIGN(auto found, open_http(url));
        if (found.file) return {};
        source.connection = std::move(found.stream);
    }
    session.camera = "stream:" + url.name();
    session.clip.take({std::move(source), {}, {}});
    return {};
}

}  // namespace

std::vector<CLI::Option*> add_camera_options(CLI::App& sub, CameraTyped& typed) {
    std::string names;
    for (const SourceDescription::Preset& preset : all_presets())
        names += (names.empty() ? "" : ", ") + std::string(preset.name);
    auto* intrinsics = sub.add_option("--intrinsics", typed.intrinsics,
                                      "of pictures without a scene file: focal lengths and principal point, "
                                      "pixels, or a file of the camera that has them (JSON, YAML, calib.txt)")
                           ->type_name("FX,FY[,CX,CY]|FILE");
    auto* fov = add_number_option(sub, "--fov", typed.fov,
                                  "likewise: degrees that are seen from left to right", 1, 179)
                    ->type_name("DEGREES")
                    ->excludes(intrinsics);
    auto* unit = add_number_option(sub, "--depth-unit", typed.depth_unit,
                                   "likewise: metres that a stored 1 stands for", 1e-9, 1e6)
                     ->type_name("METRES");
    auto* preset = sub.add_option("--preset", typed.preset,
                                  "likewise, what is known of " + names +
                                      "; of videos also that depth is hue, or the mean of colours")
                       ->type_name("NAME");
    std::vector<CLI::Option*> options{intrinsics, fov, unit, preset};
    if (CLI::Option* const scene = sub.get_option_no_throw("--scene"))
        for (CLI::Option* option : options) option->excludes(scene);
    return options;
}

Result<std::optional<SourceDescription>> read_camera(const CameraTyped& typed) {
    if (!typed.intrinsics && !typed.fov && !typed.depth_unit && !typed.preset && !typed.least_confidence)
        return std::optional<SourceDescription>();
    SourceDescription known;
    known.fov = typed.fov;
    known.metres_per_code = typed.depth_unit;
    known.preset = typed.preset.value_or("");
    known.least_confidence = typed.least_confidence;
    if (!typed.intrinsics) return std::optional(known);
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
        return usage_error(
            "--intrinsics '" + printable(*typed.intrinsics) +
            "' will not do; right would be FX,FY or FX,FY,CX,CY in pixels, such as 525,525, or a file "
            "of the camera");
    TRY_ASSIGN(known.intrinsics, read_intrinsics(*typed.intrinsics));
    known.file = *typed.intrinsics;
    return with_likely_pixels(std::move(known), *typed.intrinsics);
}

std::optional<double> as_number(std::string_view text) {
    double value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size() || !std::isfinite(value))
        return std::nullopt;
    return value;
}

std::optional<DepthLength> as_depth_length(std::string_view text, char separator) {
    const std::size_t at = text.find(separator);
    const auto constant = as_number(text.substr(0, at));
    const auto quadratic = at == std::string_view::npos ? 0.0 : as_number(text.substr(at + 1));
    if (!constant || !quadratic || *constant < 0 || *quadratic < 0) return std::nullopt;
    return DepthLength{*constant, *quadratic};
}

CLI::Option* add_temporal_option(CLI::App& sub, std::optional<std::string>& typed) {
    return sub
        .add_option("--temporal", typed,
                    "average noise from frame to frame, instead of the scene's: off, on (noise as the scene "
                    "says, or as measured), or the noise of depth in scene units, C or C,Q for C + Q depth^2")
        ->type_name("WORD|C[,Q]");
}

Result<TemporalChoice> read_temporal(const std::string& typed) {
    if (typed == "off" || typed == "on") return TemporalChoice{typed == "on", std::nullopt};
    const auto noise = as_depth_length(typed, ',');
    if (!noise || *noise == DepthLength{})
        return usage_error(
            "--temporal '" + typed +
            "' will not do; right would be off, on, or the noise of depth in scene units, such as 1.5 "
            "or 1.5,0.002");
    return TemporalChoice{true, noise};
}

CLI::Option* add_filters_option(CLI::App& sub, std::optional<std::string>& typed) {
    return sub
        .add_option(
            "--filters", typed,
            "all filters at once, instead of the scene's: off, auto (what the first frames ask for), or "
            "those that shall be on: median[=3|5], holes[=PASSES], terraces, temporal[=C[+Q]], "
            "flying=C[+Q], with commas between")
        ->type_name("WORD|LIST");
}

Result<FiltersChoice> read_filters(const std::string& typed) {
    if (typed == "off") return FiltersChoice{};
    if (typed == "auto") return FiltersChoice{{}, all_unstated};
    FiltersChoice choice;
    std::set<std::string_view> named;
    std::string_view rest = typed;
    for (bool more = true; more;) {
        const std::size_t comma = rest.find(',');
        more = comma != std::string_view::npos;
        const std::string_view part = rest.substr(0, comma);
        const std::size_t equals = part.find('=');
        const bool has_value = equals != std::string_view::npos;
        const std::string_view value = has_value ? part.substr(equals + 1) : std::string_view();
        const std::string_view name = part.substr(0, equals);
        if ((has_value && value.empty()) || !read_filter(name, value, choice.settings))
            return refusal(part, why_not(name));
        if (!named.insert(name).second) return refusal(part, ": " + std::string(name) + " is named twice");
        if (more) rest.remove_prefix(comma + 1);
    }
    return choice;
}

CLI::Option* add_clip_options(CLI::App& sub, ClipTyped& typed) {
    auto* clip = add_file_option(
        sub, "CLIP", typed.choice.file,
        "a clip, a folder of images, a depth picture, a scene file, or the address of a stream "
        "or a clip (tcp://, http://, srt://, udp://, -)");
    add_file_option(sub, "--scene", typed.choice.scene_file,
                    "scene file that describes the clip instead of its own");
    add_file_option(sub, "--haptic", typed.choice.maps.haptic,
                    "map of stiffness and friction for all frames, instead of the clip's: a picture (RGB, or "
                    "grey: stiffness), X3D or glTF");
    add_file_option(sub, "--height", typed.choice.maps.height,
                    "map of heights for all frames, instead of the clip's: a picture in grey");
    const Words<DepthAlignment> words{
        {"off", DepthAlignment::off}, {"on", DepthAlignment::on}, {"auto", DepthAlignment::automatic}};
    add_word_option(
        sub, "--align", typed.choice.alignment,
        "depth without a scale, as networks guess it, to one scale for all frames: off, on, or auto "
        "(of pictures and videos that came without one, where it pumps)",
        words);
    const Words<bool> on_or_off{{"off", false}, {"on", true}};
    add_word_option(sub, "--fill-from-motion", typed.choice.fill_from_motion,
                    "of a clip whose camera stands still: fill holes of depth from frames that saw what is "
                    "behind: off or "
                    "on",
                    on_or_off);
    add_number_option(
        sub, "--least-confidence", typed.camera.least_confidence,
        "of a .npz with an array conf beside depth: what is below it is no depth; otherwise half of the "
        "median of frame 0",
        -1e9, 1e9)
        ->type_name("C");
    return clip;
}

std::vector<CLI::Option*> add_filter_options(CLI::App& sub, ClipTyped& typed) {
    return {add_filters_option(sub, typed.filters),
            add_whole_option(sub, "--median", typed.choice.median,
                             "window side instead of the scene's: 0 (off), 3 or 5")
                ->check(is_median_side()),
            add_whole_option(sub, "--fill-holes", typed.choice.fill_holes,
                             "passes instead of the scene's: 0 to 16", 0, 16),
            add_terrace_option(sub, typed.choice.terraces), add_temporal_option(sub, typed.temporal)};
}

Result<ClipChoice> read_clip(const ClipTyped& typed) {
    ClipChoice choice = typed.choice;
    TRY_ASSIGN(choice.camera, read_camera(typed.camera));
    if (typed.filters) {
        TRY_ASSIGN(choice.filters, read_filters(*typed.filters));
    }
    if (!typed.temporal) return choice;
    TRY_ASSIGN(choice.temporal, read_temporal(*typed.temporal));
    return choice;
}

CLI::Option* add_live_camera_option(CLI::App& sub, SessionOptions& session) {
    return sub.add_option(
        "--camera", session.camera,
        "live, in place of CLIP: v4l2:/dev/videoN[,key=value,...], a camera that is plugged in; pipe:CMD or "
        "tcp://HOST:PORT, a program that sends framesets; stream:ADDRESS, as CLIP may be; or "
        "replay:PATH[,key=value,...], a recording that "
        "behaves like one (docs/camera.md)");
}

CLI::Option* add_stale_after_option(CLI::App& sub, std::optional<double>& milliseconds) {
    return add_number_option(
        sub, "--stale-after", milliseconds,
        "ms: a live surface that no newer frame has renewed for so long is not felt any more, "
        "until one comes; 0: it stays as it is (otherwise 250 of a stream, 0 of a camera)",
        0, 3'600'000);
}

CLI::Option* add_latency_option(CLI::App& sub, SessionOptions& session) {
    return add_whole_option(sub, "--latency", session.stream_latency_ms,
                            "live, of a stream: the longest that framesets wait until nearly all come in "
                            "time, ms; they wait no longer than its jitter",
                            1, 5000)
        ->type_name("MS")
        ->capture_default_str();
}

Result<void> read_live_stream(bool has_latency, SessionOptions& session) {
    TRY(take_stream(session));
    auto& plugged = session.clip.plugged;
    auto* const stream = plugged ? std::get_if<StreamSource>(&*plugged) : nullptr;
    if (stream) stream->latency = std::chrono::milliseconds(session.stream_latency_ms);
    if (stream || !has_latency) return {};
    return usage_error(
        "--latency is for a stream that is touched live, such as touchable touch --live tcp://HOST:PORT");
}

Result<void> read_live_camera(bool has_clip, const std::optional<double>& stale_after_ms,
                              SessionOptions& session) {
    if (stale_after_ms) session.stale_after_ns = std::llround(*stale_after_ms * 1e6);
    if (!session.camera) return {};
    if (has_clip) return usage_error("CLIP and --camera are two things to touch; leave one of them out");
    TRY_ASSIGN(const auto camera, read_live_camera(*session.camera));
    session.clip.take(camera);
    return {};
}

}  // namespace touchable
