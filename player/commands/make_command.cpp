#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <string_view>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"
#include "engine/base/try.hpp"
#include "engine/clip/mp4_writer.hpp"
#include "engine/content/scenes.hpp"
#include "player/commands/file_option.hpp"
#include "player/commands/fragmented_option.hpp"
#include "player/commands/make_run.hpp"
#include "player/commands/number_option.hpp"
#include "player/commands/outputs.hpp"
#include "player/commands/typed_numbers.hpp"
#include "player/commands/whole_option.hpp"
#include "player/run/memory.hpp"

namespace touchable {
namespace {

constexpr std::int64_t most_frames = 1'000'000;

/// Options as typed; what was not typed stays with the scene's own default.
struct MakeWords {
    MakeOptions options;
    GlobeWords globe;
    std::string size, preset, frames = "90", rate = "30", seed = "1", archive = "fast";
    bool properties = false, plain = false;
    const CLI::Option *size_typed = nullptr, *preset_typed = nullptr, *seed_typed = nullptr,
                      *tilt_typed = nullptr, *tilt_direction_typed = nullptr;
};

/// Under another name other programs would take a clip for what it is not.
Result<void> check_name(const std::filesystem::path& out) {
    std::string ending = out.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
    if (ending == ".mkv" || is_mp4_name(out)) return {};
    return usage_error("OUT '" + out.string() +
                       "' does not end in .mkv (Matroska) or .mp4 (MPEG-4), which a clip is");
}

Result<void> read_preset(const std::string& text, SceneOptions& out) {
    if (text == "A")
        out.preset = CameraPreset::a;
    else if (text == "A'")
        out.preset = CameraPreset::a_prime;
    else if (text == "B")
        out.preset = CameraPreset::b;
    else
        return usage_error("--preset '" + text + "' is not known; there are A, A' and B");
    return {};
}

/// Scenes whose pixels know nothing of each other; published at 128x128.
bool without_shape(std::string_view scene) {
    return scene == "noise" || scene == "cliffs" || scene == "grain";
}

/// An option that the scene would ignore is refused rather than ignored.
Result<void> refuse_idle_options(const MakeWords& words) {
    const std::string& scene = words.options.scene;
    const auto only = [&](bool given, const char* option, bool fits, const char* scenes) -> Result<void> {
        if (!given || fits) return {};
        return usage_error(std::string(option) + " does nothing for '" + scene + "'; it belongs to " +
                           scenes);
    };
    const auto typed = [](const CLI::Option* option) { return option->count() > 0; };
    const bool globe = scene == "globe", plane = scene == "plane", random = without_shape(scene);
    for (const Result<void>& checked :
         {only(typed(words.preset_typed), "--preset", globe, "globe"),
          only(words.properties, "--properties", globe, "globe"),
          only(words.plain, "--plain", globe, "globe"),
          only(words.options.storage.exact_colour, "--exact-colour", globe && !words.plain,
               "a globe that turns"),
          only(typed(words.tilt_typed), "--tilt", plane, "plane"),
          only(typed(words.tilt_direction_typed), "--tilt-direction", plane, "plane"),
          only(typed(words.seed_typed), "--seed",
               random || (globe && !words.plain && !words.globe.maps.any()),
               "noise, cliffs, grain and the planet of globe")})
        if (!checked.ok()) return checked;
    return check_globe_words(words.globe, scene, words.plain);
}

Result<Archive> read_archive(const std::string& text) {
    if (text == "fast") return Archive::fast;
    if (text == "small") return Archive::small;
    return usage_error("--archive '" + text + "' is not known; there are fast and small");
}

Result<MakeOptions> read_words(const MakeWords& words) {
    TRY(check_name(words.options.out));
    if (words.options.storage.fragmented && !is_mp4_name(words.options.out))
        return usage_error(std::string("--fragmented is for ") + fragmented_names);
    TRY(refuse_idle_options(words));
    MakeOptions options = words.options;
    SceneOptions& generator = options.generator;
    if (without_shape(options.scene)) generator.width = generator.height = 128;
    if (words.size_typed->count() > 0) {
        TRY_ASSIGN(const auto size, read_pixel_size("--size", words.size, 2, 16384));
        generator.width = size.width;
        generator.height = size.height;
    }
    if (words.preset_typed->count() > 0) TRY(read_preset(words.preset, generator));
    TRY_ASSIGN(const auto frames, read_whole_number<std::int64_t>("--frames", words.frames, 1, most_frames));
    options.frames = frames;
    TRY_ASSIGN(const auto rate, read_frame_rate("--rate", words.rate));
    generator.rate = rate;
    TRY_ASSIGN(const auto archive, read_archive(words.archive));
    options.storage.archive = archive;
    TRY_ASSIGN(const auto seed, read_whole_number<std::uint64_t>("--seed", words.seed, 0,
                                                                 std::numeric_limits<std::uint64_t>::max()));
    generator.seed = seed;
    generator.properties = options.scene == "globe" && !words.plain;
    take_motion(words.globe, generator);
    options.maps = words.globe.maps;
    return options;
}

std::string known_scenes() {
    std::string names;
    for (const std::string_view name : scene_names())
        names += (names.empty() ? "" : ", ") + std::string(name);
    return names;
}

}  // namespace

void add_make_command(CLI::App& app, Command& command) {
    auto* make = app.add_subcommand("make", "make a clip of a generated scene: " + known_scenes());
    auto words = std::make_shared<MakeWords>();
    SceneOptions& generator = words->options.generator;
    make->add_option("SCENE", words->options.scene, "one of " + known_scenes())->required();
    add_file_option(*make, "OUT", words->options.out,
                    "the clip to write: .mkv, or .mp4 as the paper sends it")
        ->required();
    add_overwrite_option(*make, words->options.existing);
    words->size_typed = make->add_option("--size", words->size,
                                         "WxH in pixels (default 720x480; noise, cliffs and grain 128x128)");
    make->add_option("--frames", words->frames, "how many")->capture_default_str();
    make->add_option("--rate", words->rate, "frames per second, exactly: 30, 29.97, 30000/1001")
        ->capture_default_str();
    add_whole_option(*make, "--bits", generator.bits, "of a stored depth, 8 to 16", 8, 16)
        ->capture_default_str();
    make->add_option(
            "--archive", words->archive,
            "fast: decodes quickest; small: fewest bytes. Both keep every value of depth, haptic and "
            "height (docs/codecs.md)")
        ->capture_default_str();
    make->add_flag("--exact-colour", words->options.storage.exact_colour,
                   "colour keeps every value too; otherwise it is as good as the eye can tell");
    add_fragmented_option(*make, words->options.storage);
    words->preset_typed = make->add_option("--preset", words->preset, "globe: camera A, A' or B (default B)");
    auto* properties = make->add_flag("--properties", words->properties,
                                      "globe: turning planet; land and ocean differ to the touch (default)");
    make->add_flag("--plain", words->plain, "globe: at rest, depth alone")->excludes(properties);
    words->seed_typed =
        make->add_option("--seed", words->seed, "noise, cliffs, grain, and the planet of globe")
            ->capture_default_str();
    words->tilt_typed =
        add_number_option(*make, "--tilt", generator.tilt_degrees, "plane: degrees, 0 to 60", 0, 60)
            ->capture_default_str();
    words->tilt_direction_typed =
        add_number_option(*make, "--tilt-direction", generator.tilt_direction_degrees,
                          "plane: degrees in the picture")
            ->capture_default_str();
    add_globe_options(*make, words->globe);
    make->callback([words, &command] {
        command = [words]() -> Result<void> {
            TRY_ASSIGN(const auto options, read_words(*words));
            const SceneOptions& made = options.generator;
            return within_memory("frames of " + std::to_string(made.width) + 'x' +
                                     std::to_string(made.height) + " pixels" +
                                     (options.maps.any() ? " and their maps" : ""),
                                 [&] { return run_make(options); });
        };
    });
}

}  // namespace touchable
