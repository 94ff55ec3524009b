#include "player/make_command.hpp"

#include <CLI/CLI.hpp>
#include <charconv>
#include <iostream>
#include <memory>
#include <optional>
#include <string_view>
#include <system_error>

#include "engine/media/clip.hpp"
#include "player/interrupt.hpp"
#include "player/progress.hpp"

namespace touchable {
namespace {

constexpr std::int64_t most_frames = 1'000'000;

/// Options as typed; what was not typed stays with the scene's own default.
struct MakeWords {
    MakeOptions options;
    std::string size, preset;
    bool properties = false, plain = false;
    bool seed = false, tilt = false, tilt_direction = false;
};

std::optional<int> whole_number(std::string_view text) {
    int value = 0;
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

Result<void> read_size(const std::string& text, SceneOptions& out) {
    const std::size_t cross = text.find('x');
    const auto width = whole_number(std::string_view(text).substr(0, cross));
    const auto height =
        cross == std::string::npos ? std::nullopt : whole_number(std::string_view(text).substr(cross + 1));
    if (!width || !height)
        return usage_error("--size " + text +
                           " is not a size; right would be WxH in pixels, such as 720x480");
    out.width = *width;
    out.height = *height;
    return {};
}

Result<void> read_preset(const std::string& text, SceneOptions& out) {
    if (text == "A")
        out.preset = CameraPreset::a;
    else if (text == "A'")
        out.preset = CameraPreset::a_prime;
    else if (text == "B")
        out.preset = CameraPreset::b;
    else
        return usage_error("--preset " + text + " is not known; there are A, A' and B");
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
    const bool globe = scene == "globe", plane = scene == "plane", random = without_shape(scene);
    for (const Result<void>& checked :
         {only(!words.preset.empty(), "--preset", globe, "globe"),
          only(words.properties, "--properties", globe, "globe"),
          only(words.plain, "--plain", globe, "globe"), only(words.tilt, "--tilt", plane, "plane"),
          only(words.tilt_direction, "--tilt-direction", plane, "plane"),
          only(words.seed, "--seed", random || (globe && !words.plain),
               "noise, cliffs, grain and the planet of globe")})
        if (!checked.ok()) return checked;
    return {};
}

Result<MakeOptions> read_words(const MakeWords& words) {
    if (auto fits = refuse_idle_options(words); !fits.ok()) return fits.error();
    MakeOptions options = words.options;
    if (without_shape(options.scene)) options.generator.width = options.generator.height = 128;
    if (!words.size.empty())
        if (auto size = read_size(words.size, options.generator); !size.ok()) return size.error();
    if (!words.preset.empty())
        if (auto preset = read_preset(words.preset, options.generator); !preset.ok()) return preset.error();
    options.generator.properties = options.scene == "globe" && !words.plain;
    return options;
}

std::string known_scenes() {
    std::string names;
    for (const std::string_view name : scene_names())
        names += (names.empty() ? "" : ", ") + std::string(name);
    return names;
}

}  // namespace

Result<void> run_make(const MakeOptions& options) {
    if (options.frames < 1 || options.frames > most_frames)
        return usage_error("--frames " + std::to_string(options.frames) +
                           " is out of range; right would be 1 to " + std::to_string(most_frames));
    const auto scene = make_scene(options.scene, options.generator);
    if (!scene.ok()) return scene.error();
    const AnalyticScene& source = **scene;
    auto writer = create_clip(options.out, source.scene());
    if (!writer.ok()) return writer.error();

    Progress progress("making frame", options.frames);
    for (std::int64_t n = 0; n < options.frames; ++n) {
        if (interrupted()) return interrupted_error();
        progress.at(n + 1);
        if (auto written = (*writer)->write(source.frame(n)); !written.ok()) return written.error();
    }
    return (*writer)->finish();
}

void add_make_command(CLI::App& app, Command& command) {
    auto* make = app.add_subcommand("make", "make a clip of a generated scene: " + known_scenes());
    auto words = std::make_shared<MakeWords>();
    SceneOptions& generator = words->options.generator;
    make->add_option("SCENE", words->options.scene, "one of " + known_scenes())->required();
    make->add_option("OUT", words->options.out, "the clip to write (.mkv)")->required();
    make->add_option("--size", words->size,
                     "WxH in pixels (default 720x480; noise, cliffs and grain 128x128)");
    make->add_option("--frames", words->options.frames, "how many, at 30/s")->capture_default_str();
    make->add_option("--bits", generator.bits, "of a stored depth, 8 to 16")->capture_default_str();
    make->add_option("--preset", words->preset, "globe: camera A, A' or B (default B)");
    auto* properties = make->add_flag("--properties", words->properties,
                                      "globe: turning planet; land and ocean differ to the touch (default)");
    make->add_flag("--plain", words->plain, "globe: at rest, depth alone")->excludes(properties);
    auto* seed = make->add_option("--seed", generator.seed, "noise, cliffs, grain, and the planet of globe")
                     ->capture_default_str();
    auto* tilt =
        make->add_option("--tilt", generator.tilt_degrees, "plane: degrees, 0 to 60")->capture_default_str();
    auto* direction = make->add_option("--tilt-direction", generator.tilt_direction_degrees,
                                       "plane: degrees in the picture")
                          ->capture_default_str();
    make->callback([words, seed, tilt, direction, &command] {
        words->seed = seed->count() > 0;
        words->tilt = tilt->count() > 0;
        words->tilt_direction = direction->count() > 0;
        command = [words]() -> Result<void> {
            const auto options = read_words(*words);
            if (!options.ok()) return options.error();
            if (auto made = run_make(*options); !made.ok()) return made;
            std::cout << options->out.string() << ": " << options->frames << " frames of " << options->scene
                      << ", " << options->generator.width << "x" << options->generator.height << ", "
                      << options->generator.bits << " bits\n";
            return {};
        };
    });
}

}  // namespace touchable
