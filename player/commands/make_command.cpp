// SPDX-License-Identifier: Apache-2.0
#include <future>
#include <iostream>
#include <tuple>

#include "engine/base/files.hpp"
#include "engine/base/try.hpp"
#include "engine/base/words.hpp"
#include "engine/clip/clip.hpp"
#include "engine/content/globe_maps.hpp"
#include "engine/content/scenes.hpp"
#include "engine/picture/image.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/option_types.hpp"
#include "player/run/terminal.hpp"
#include "player/run/touch_session.hpp"

namespace touchable {

namespace {

/// Files and options of a globe made from maps.
struct GlobeMapFiles {
    std::filesystem::path colour, elevation, mask, haptic;
    std::optional<double> sea_level{}, relief_percent{}, smoothing_degrees{};

    bool any() const { return !colour.empty() || !elevation.empty() || !mask.empty(); }
    /// The files that are read, with their options.
    std::vector<NamedFile> files() const {
        std::vector<NamedFile> named;
        const std::pair<const char*, const std::filesystem::path&> all[] = {
            {"--colour", colour}, {"--elevation", elevation}, {"--mask", mask}, {"--haptic", haptic}};
        for (const auto& [name, path] : all)
            if (!path.empty()) named.push_back({name, path});
        return named;
    }
};

/// Maps with the pictures that hold their samples.
struct ReadGlobeMaps {
    StoredImage colour{}, elevation{}, mask{}, haptic{};
    GlobeMaps maps;
    std::string remark;  ///< one line about the sea level found
};
/// Options of a generated clip.
struct MakeOptions {
    std::string scene;                   ///< one of scene_names()
    std::filesystem::path out;           ///< a name that ends in .mkv or .mp4
    Existing existing = Existing::keep;  ///< treatment of an existing file of that name
    std::int64_t frames = 90;            ///< 1 to 1 000 000
    ClipStorage storage{};
    SceneOptions generator;
    GlobeMapFiles maps;
};

GlobeMap map_of(const StoredImage& picture) {
    const Image& image = picture.image;
    if (!picture.values.empty()) return {{}, picture.values, image.width, image.height, 1};
    return {image.view(), {}, image.width, image.height, image.channels, (1 << picture.bits) - 1};
}

enum class MapKind { as_stored, grey };

/// Reads a file's map into `picture`; no map if `file` is empty. The map refers to `picture`.
Result<GlobeMap> read_map(const std::filesystem::path& file, MapKind kind, StoredImage& picture) {
    if (file.empty()) return GlobeMap{};
    if (stop_requested()) return interrupted_error();
    TRY_ASSIGN(picture, read_stored_image(SourceFile(file)));
    if (kind == MapKind::grey && picture.image.channels > 1)  // a grey picture may be stored as colour
        if (auto grey = as_grey(picture.image)) picture.image = std::move(*grey);
    return map_of(picture);
}

double least_of(const GlobeMap& elevation) {
    double least = HUGE_VAL;
    for (int y = 0; y < elevation.height; ++y)
        for (int x = 0; x < elevation.width; ++x)
            if (const double here = elevation.at(x, y, 0); std::isfinite(here)) least = std::min(least, here);
    return least;
}

/// White where the elevation map is above `level`.
StoredImage mask_of(const GlobeMap& elevation, double level) {
    StoredImage mask{};
    mask.image = {elevation.width, elevation.height, 1, 1, {}};
    for (int y = 0; y < elevation.height; ++y)
        for (int x = 0; x < elevation.width; ++x)
            mask.image.samples.push_back(elevation.at(x, y, 0) > level ? 255 : 0);
    return mask;
}

std::string shore_in_words(const GlobeMaps::Shore& shore, bool told, bool has_mask) {
    const std::string level = formatted("sea level %.9g", shore.sea_level);
    if (!has_mask)
        return level +
               (told ? ", as told" : ", the least of the elevation map (--sea-level VALUE says otherwise)") +
               "; --mask FILE would say which is land";
    return level + (told ? ", as told" : " of the elevation map") + "; land is " +
           (shore.bright_is_land ? "bright" : "dark") +
           formatted(" in the mask; the two agree on %.1f %% of the globe", 100 * shore.agreement) +
           (told ? "" : " (--sea-level VALUE says otherwise)");
}

Result<std::unique_ptr<const ReadGlobeMaps>> read_globe_maps(const GlobeMapFiles& files) {
    auto read = std::make_unique<ReadGlobeMaps>();
    GlobeMaps& maps = read->maps;
    for (const auto& [file, kind, picture, map] :
         {std::tuple{&files.colour, MapKind::as_stored, &read->colour, &maps.colour},
          {&files.elevation, MapKind::grey, &read->elevation, &maps.elevation},
          {&files.mask, MapKind::grey, &read->mask, &maps.mask},
          {&files.haptic, MapKind::as_stored, &read->haptic, &maps.haptic}}) {
        TRY_ASSIGN(*map, read_map(*file, kind, *picture));
    }
    std::optional<double> sea_level = files.sea_level;
    if (files.mask.empty() && !maps.elevation.empty() && maps.elevation.channels == 1) {
        if (!sea_level) sea_level = least_of(maps.elevation);
        read->mask = mask_of(maps.elevation, *sea_level);
        maps.mask = map_of(read->mask);
        const auto& mask = read->mask.image.samples;
        if (std::ranges::find(mask, mask.front() ^ 255) == mask.end())
            return input_error(files.sea_level
                                   ? "--sea-level leaves only land, or only sea, in the elevation map"
                                   : "the elevation map is level everywhere");
    }
    if (files.relief_percent) maps.relief = *files.relief_percent / 100;
    if (files.smoothing_degrees) maps.smoothing_degrees = *files.smoothing_degrees;
    TRY(check_globe_maps(maps));
    TRY_ASSIGN(maps.shore, find_shore(maps.elevation, maps.mask, sea_level));
    read->remark = shore_in_words(maps.shore, files.sea_level.has_value(), !files.mask.empty());
    return std::unique_ptr<const ReadGlobeMaps>(std::move(read));
}

Result<void> write_frames(const AnalyticScene& source, std::int64_t frames, ClipWriter& writer) {
    Progress progress("making frame", frames, Progress::InALog::lines);
    // A frame is made while the previous one is encoded; if no thread is available, after it.
    const auto make = [&source](std::int64_t n) {
        return std::async([&source, n] { return source.frame(n); });
    };
    std::future<RawFrame> made = make(0);
    for (std::int64_t n = 0; n < frames; ++n) {
        if (stop_requested()) return interrupted_error();
        progress.at(n + 1);
        const RawFrame frame = made.get();
        if (n + 1 < frames) made = make(n + 1);
        TRY(writer.write(frame));
    }
    return {};
}

/// The scene; `remark`: a line about its maps.
Result<std::unique_ptr<AnalyticScene>> make_source(const MakeOptions& options, std::string& remark) {
    if (!options.maps.any()) return make_scene(options.scene, options.generator);
    StatusLine line;
    if (line.is_on_terminal()) line.show("reading the maps");
    TRY_ASSIGN(const auto read, read_globe_maps(options.maps));
    remark = read->remark;
    SceneOptions generator = options.generator;
    generator.maps = &read->maps;
    return make_scene(options.scene, generator);
}

constexpr std::int64_t most_frames = 1'000'000;

void add_globe_options(CLI::App& make, SceneOptions& generator, GlobeMapFiles& maps) {
    add_number_option(make, "--turn", generator.seconds_per_turn,
                      "seconds for a turn of the globe (default 12)", 0.1, 1e9)
        ->type_name("SECONDS");
    add_number_option(make, "--axial-tilt", generator.axial_tilt_degrees,
                      "how far the globe's pole leans to the right (default 26; of maps 23.4)", -90, 90)
        ->type_name("DEGREES");
    add_number_option(make, "--longitude", generator.first_longitude_degrees,
                      "degrees east that face the camera at first (default -72; of maps 80)", -180, 180)
        ->type_name("DEGREES");
    begin_topic(make, "Maps");
    add_file_option(make, "--colour", maps.colour,
                    "colour of a globe of maps: longitude -180 to 180 from left to right, north up");
    add_file_option(make, "--elevation", maps.elevation, "heights of a globe of maps, in any unit");
    add_file_option(make, "--mask", maps.mask,
                    "land and ocean of a globe of maps, in black and white. By default ocean is where "
                    "elevation is least, or up to --sea-level");
    add_file_option(make, "--haptic", maps.haptic,
                    "touch of a globe of maps, in place of land and ocean: RGB. Codes of stiffness (0.1 to 2 "
                    "N/mm), static and dynamic friction (0 to 1)");
    add_number_option(make, "--sea-level", maps.sea_level,
                      "elevation up to which it is sea. By default where the mask says so; without a mask "
                      "the least elevation");
    add_number_option(make, "--relief", maps.relief_percent,
                      "height of the highest place, percent of the radius (default 3)", 0.01, 10)
        ->type_name("PERCENT");
    add_number_option(make, "--smoothing", maps.smoothing_degrees,
                      "put mountains narrower than this into the height plane, wider ones into depth "
                      "(default 1; 0: all into depth)",
                      0, 10)
        ->type_name("DEGREES");
}

/// Options as typed; untyped options keep the scene's default.
struct MakeWords {
    MakeOptions options;
    std::string size, frames = "90", rate = "30", seed = "1";
    bool plain = false;
    const CLI::App* command = nullptr;
    bool is_typed(const char* option) const { return command->count(option) > 0; }
};

/// With another extension other programs would misinterpret a clip.
Result<void> check_name(const std::filesystem::path& out) {
    const std::string ending = small_letters(out.extension().string());
    if (ending == ".mkv" || ending == ".mp4") return {};
    return usage_error("OUT '" + out.string() +
                       "' does not end in .mkv (Matroska) or .mp4 (MPEG-4), which a clip is");
}

/// Scenes with independent pixels; published at 128x128.
bool without_shape(std::string_view scene) {
    return scene == "noise" || scene == "cliffs" || scene == "grain";
}

/// Refuses options that the scene would ignore, and maps that need another map.
Result<void> refuse_idle_options(const MakeWords& words) {
    const std::string& scene = words.options.scene;
    const GlobeMapFiles& maps = words.options.maps;
    const bool globe = scene == "globe", plane = scene == "plane", random = without_shape(scene);
    const bool turns = globe && !words.plain;
    const char* const turning = "a globe that turns";
    const char* const of_maps = "a globe of maps (--colour and --elevation)";
    const struct {
        const char* option;
        bool fits;
        const char* whose;
    } options[] = {
        {"--preset", globe, "globe"},
        {"--properties", globe, "globe"},
        {"--plain", globe, "globe"},
        {"--exact-colour", turns, turning},
        {"--tilt", plane, "plane"},
        {"--tilt-direction", plane, "plane"},
        {"--seed", random || (turns && !maps.any()), "noise, cliffs, grain and the planet of globe"},
        {"--colour", turns, turning},
        {"--elevation", turns, turning},
        {"--mask", turns, turning},
        {"--turn", turns, turning},
        {"--axial-tilt", turns, turning},
        {"--longitude", turns, turning},
        {"--haptic", maps.any(), of_maps},
        {"--sea-level", maps.any(), of_maps},
        {"--relief", maps.any(), of_maps},
        {"--smoothing", maps.any(), of_maps}};
    for (const auto& [option, fits, whose] : options)
        if (!fits && words.is_typed(option))
            return usage_error(std::string(option) + " does nothing for '" + scene +
                               (words.plain ? "' --plain" : "'") + "; it belongs to " + whose);
    if (!maps.any()) return {};
    for (const auto& [option, file] : {std::pair{"--colour", &maps.colour}, {"--elevation", &maps.elevation}})
        if (file->empty())
            return usage_error(std::string(option) +
                               " is missing; a globe of maps needs --colour and --elevation");
    return {};
}

Result<MakeOptions> read_words(const MakeWords& words) {
    TRY(check_name(words.options.out));
    if (words.options.storage.fragmented && !is_mp4_name(words.options.out))
        return usage_error(std::string("--fragmented is for ") + fragmented_names);
    TRY(refuse_idle_options(words));
    MakeOptions options = words.options;
    SceneOptions& generator = options.generator;
    if (without_shape(options.scene)) generator.width = generator.height = 128;
    if (words.is_typed("--size")) {
        TRY_ASSIGN(const auto size, read_pixel_size("--size", words.size, 2, 16384));
        generator.width = size.width;
        generator.height = size.height;
    }
    TRY_ASSIGN(options.frames, read_whole_number<std::int64_t>("--frames", words.frames, 1, most_frames));
    TRY_ASSIGN(generator.rate, read_frame_rate("--rate", words.rate));
    TRY_ASSIGN(generator.seed, read_whole_number<std::uint64_t>("--seed", words.seed, 0,
                                                                std::numeric_limits<std::uint64_t>::max()));
    generator.properties = options.scene == "globe" && !words.plain;
    if (options.maps.any()) {
        constexpr double tilt_of_the_earth = 23.4, himalaya = 80;
        generator.axial_tilt_degrees = generator.axial_tilt_degrees.value_or(tilt_of_the_earth);
        generator.first_longitude_degrees = generator.first_longitude_degrees.value_or(himalaya);
    }
    return options;
}

/// Writes the clip and reports it on standard output. The same options give the same file, byte for byte.
Result<void> run_make(const MakeOptions& options) {
    TRY(check_outputs(Outputs{{{"OUT", options.out}}, options.existing}, options.maps.files()));
    std::string remark;
    TRY_ASSIGN(const auto scene, make_source(options, remark));
    const AnalyticScene& source = *scene;
    SceneDescription described(source.scene());
    described.unstated.filters = all_unstated;  // to be chosen from its frames
    TRY_ASSIGN(auto writer, create_clip(options.out, described, options.storage, options.existing));
    TRY(write_frames(source, options.frames, *writer));
    TRY(writer->finish());

    const Scene& made = source.scene();
    std::cout << one_line(options.out.string()) << ": " << counted(options.frames, "frame") << " of "
              << options.scene << ", " << made.width << 'x' << made.height << ", " << made.depth_bits
              << " bits\n";
    if (!remark.empty()) std::cout << remark << '\n';
    return {};
}

}  // namespace

void add_make_command(CLI::App& app, Command& command) {
    auto* make = app.add_subcommand("make", "make a clip of a generated scene, such as a globe");
    auto words = std::make_shared<MakeWords>();
    words->command = make;
    SceneOptions& generator = words->options.generator;
    begin_topic(*make, "Clip");
    make->add_option("SCENE", words->options.scene, "what the clip shows")
        ->required()
        ->type_name(type_with_words("SCENE", scene_names()));
    add_file_option(*make, "OUT", words->options.out, "clip to write: .mkv, or .mp4 as the paper sends it")
        ->required();
    make->add_option("--size", words->size,
                     "size in pixels. By default 720x480; of noise, cliffs and grain 128x128")
        ->type_name("WxH");
    make->add_option("--frames", words->frames, "number of frames")->type_name("N")->capture_default_str();
    make->add_option("--rate", words->rate, "frames per second, exactly: 30, 29.97, 30000/1001")
        ->type_name("RATE")
        ->capture_default_str();
    add_whole_option(*make, "--bits", generator.bits, "bits of a stored depth, 8 to 16", 8, 16)
        ->capture_default_str();
    make->add_option("--seed", words->seed, "seed of noise, cliffs, grain and the planet of globe")
        ->type_name("N")
        ->capture_default_str();
    add_number_option(*make, "--tilt", generator.tilt_degrees, "slope of plane, 0 to 60", 0, 60)
        ->type_name("DEGREES")
        ->capture_default_str();
    add_number_option(*make, "--tilt-direction", generator.tilt_direction_degrees,
                      "direction in the picture in which plane slopes")
        ->type_name("DEGREES")
        ->capture_default_str();
    begin_topic(*make, files_topic);
    add_overwrite_option(*make, words->options.existing);
    add_storage_options(*make, words->options.storage);
    begin_topic(*make, "Globe");
    add_word_option(*make, "--preset", generator.preset, "camera of globe (default B)", {"A", "A'", "B"});
    auto* properties = make->add_flag("--properties")
                           ->description("let globe turn, and land and ocean differ to the touch (default)");
    make->add_flag("--plain", words->plain, "let globe rest, with depth alone")->excludes(properties);
    add_globe_options(*make, generator, words->options.maps);
    set_work(*make, command, [words]() -> Result<void> {
        TRY_ASSIGN(const auto options, read_words(*words));
        const SceneOptions& made = options.generator;
        return within_memory("frames of " + size_text(made.width, made.height) + " pixels" +
                                 (options.maps.any() ? " and their maps" : ""),
                             [&] { return run_make(options); });
    });
}

}  // namespace touchable
