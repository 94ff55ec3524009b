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
    return usage_error(message +
                       ", one more than twice the other, as of no camera; right would be FX,FY or "
                       "FX,FY,CX,CY in pixels, with a decimal point, such as 525.5,525.5");
}

/// The name of a part of `--filters`.
std::string name_in_list(const FilterSetting& setting) {
    const std::string_view in_list = setting.in_list;
    return std::string(in_list.substr(0, in_list.find_first_of("[=")));
}

/// What is wrong with a part of the list; empty: nothing, and `choice` has it.
std::string why_not(const std::string& name, const std::optional<std::string>& value, FiltersChoice& choice) {
    if (name == "off" || name == "auto") return ": it stands alone, without other filters";
    std::vector<std::string> names;
    for (const FilterSetting& setting : filter_settings()) {
        names.push_back(name_in_list(setting));
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

void add_camera_options(CLI::App& sub, CameraTyped& typed) {
    const std::string names = listed(all_presets(), &SourceDescription::Preset::name);
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
    const auto read_depth = [&typed](const std::string& word) -> Result<void> {
        TRY_ASSIGN(const double place, read_word({.words = {"range", "planar"}}, word));
        typed.depth = place == 0 ? DepthSemantics::range : DepthSemantics::planar;
        return {};
    };
    auto* depth = add_read_option(sub, "--depth", read_depth,
                                  "likewise: whether depth is a distance along each pixel's ray (range) or "
                                  "along the camera's axis (planar)")
                      ->type_name("WORD");
    auto* preset = sub.add_option("--preset", typed.preset,
                                  "likewise, what is known of " + names +
                                      "; of videos also that depth is hue, or the mean of colours")
                       ->type_name("NAME");
    if (CLI::Option* const scene = sub.get_option_no_throw("--scene"))
        for (CLI::Option* option : {intrinsics, fov, unit, depth, preset}) option->excludes(scene);
}

Result<std::optional<SourceDescription>> read_camera(const CameraTyped& typed) {
    if (!typed.intrinsics && !typed.fov && !typed.depth_unit && !typed.depth && !typed.preset &&
        !typed.least_confidence && !typed.channel && !typed.dataset)
        return std::optional<SourceDescription>();
    SourceDescription known;
    known.fov = typed.fov;
    known.metres_per_code = typed.depth_unit;
    known.semantics = typed.depth;
    known.preset = typed.preset.value_or("");
    known.least_confidence = typed.least_confidence;
    known.channel = typed.channel.value_or("");
    known.dataset = typed.dataset.value_or("");
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
        return usage_error("--intrinsics '" + printable(*typed.intrinsics) +
                           "' is not allowed; must be FX,FY or FX,FY,CX,CY in pixels, such as 525,525, or a "
                           "file of the camera");
    TRY_ASSIGN(known.intrinsics, read_intrinsics(*typed.intrinsics));
    known.file = *typed.intrinsics;
    return with_likely_pixels(std::move(known), *typed.intrinsics);
}

Result<FiltersChoice> read_filters(const std::string& typed) {
    if (typed == "auto") return FiltersChoice{.measured = all_unstated};
    FiltersChoice choice = FiltersChoice::off();
    if (typed == "off") return choice;
    for (std::size_t at = 0, end = 0; end != std::string::npos; at = end + 1) {
        end = typed.find(',', at);
        const std::string part = typed.substr(at, end == std::string::npos ? end : end - at);
        const std::size_t equals = part.find('=');
        const auto value =
            equals == std::string::npos ? std::nullopt : std::optional(part.substr(equals + 1));
        if (const std::string why = why_not(part.substr(0, equals), value, choice); !why.empty())
            return usage_error("'" + part + "' is not allowed" + why +
                               "; must be auto, off, or those that shall be on, such as "
                               "median=5,terraces,temporal=1.5+2e-6,holes=2");
    }
    return choice;
}

CLI::Option* add_clip_options(CLI::App& sub, ClipTyped& typed) {
    auto* clip = add_file_option(sub, "CLIP", typed.choice.file,
                                 "a clip, a folder of images, a depth picture, a scene file, or the address "
                                 "of a stream or a clip (tcp://, http://, srt://, udp://, -)");
    add_file_option(sub, "--scene", typed.choice.scene_file,
                    "scene file that describes the clip instead of its own");
    add_file_option(sub, "--haptic", typed.choice.maps.haptic,
                    "map of stiffness and friction for all frames, instead of the clip's: a picture (RGB, or "
                    "grey: stiffness), X3D or glTF");
    add_file_option(sub, "--height", typed.choice.maps.height,
                    "map of heights for all frames, instead of the clip's: a picture in grey");
    add_word_option(sub, "--align", typed.choice.alignment,
                    "depth without a scale, as networks guess it, to one scale for all frames: off, on, or "
                    "auto (of pictures and videos that came without one, where it pumps)",
                    {"auto", "on", "off"});
    add_word_option(sub, "--fill-from-motion", typed.choice.fill_from_motion,
                    "of a clip whose camera stands still: fill holes of depth from frames that saw what is "
                    "behind: off or on",
                    {"off", "on"});
    add_number_option(sub, "--least-confidence", typed.camera.least_confidence,
                      "of a .npz with an array conf beside depth: what is below it is no depth; otherwise "
                      "half of the median of frame 0",
                      -1e9, 1e9)
        ->type_name("C");
    sub.add_option(
           "--channel", typed.camera.channel,
           "of a rendering (OpenEXR): the channel or layer that is depth; otherwise found by its name")
        ->type_name("NAME");
    sub.add_option("--dataset", typed.camera.dataset,
                   "of an HDF5 file or a .npz: the data set or array that is depth, such as "
                   "/data/demo_0/obs/depth; otherwise found by its name")
        ->type_name("NAME");
    return clip;
}

std::vector<CLI::Option*> add_filter_options(CLI::App& sub, ClipTyped& typed) {
    ClipChoice& clip = typed.choice;
    const auto read_all = [&clip](const std::string& words) -> Result<void> {
        TRY_ASSIGN(clip.filters, read_filters(words));
        return {};
    };
    std::string parts;
    for (const FilterSetting& setting : filter_settings())
        if (*setting.in_list) parts += (parts.empty() ? "" : ", ") + std::string(setting.in_list);
    std::vector<CLI::Option*> options{
        add_read_option(sub, "--filters", read_all,
                        "all filters at once, instead of the scene's: off, auto (what the first frames ask "
                        "for), or those that shall be on: " +
                            parts + ", with commas between")
            ->type_name("WORD|LIST")};
    for (const FilterSetting& setting : filter_settings()) {
        if (!*setting.what) continue;
        const auto read = [&clip, &setting](const std::string& word) -> Result<void> {
            if (clip.single_filters.state(setting, word)) return {};
            return usage_error("'" + word + "' is not allowed; must be " + setting.right());
        };
        options.push_back(add_read_option(sub, "--" + setting.typed_name(), read,
                                          setting.right() + ", instead of the scene's. " + setting.what)
                              ->type_name(setting.length        ? "WORD|C[,Q]"
                                          : setting.range.whole ? "N"
                                                                : "WORD"));
    }
    for (CLI::Option* const option : options) option->group("Filters of depth");
    return options;
}

Result<ClipChoice> read_clip(const ClipTyped& typed) {
    ClipChoice choice = typed.choice;
    TRY_ASSIGN(choice.camera, read_camera(typed.camera));
    return choice;
}

void add_live_camera_option(CLI::App& sub, SessionOptions& session) {
    sub.add_option(
        "--camera", session.camera,
        "live, in place of CLIP: v4l2:/dev/videoN[,key=value,...], a camera that is plugged in; "
        "pipe:CMD or tcp://HOST:PORT, a program that sends framesets; stream:ADDRESS, as CLIP may "
        "be; or replay:PATH[,key=value,...], a recording that behaves like one (docs/streaming.md)");
}

void add_stale_after_option(CLI::App& sub, std::optional<double>& milliseconds) {
    add_number_option(sub, "--stale-after", milliseconds,
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
