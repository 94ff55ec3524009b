#include "player/commands/clip_options.hpp"

#include <CLI/CLI.hpp>
#include <optional>

#include "engine/base/try.hpp"
#include "engine/scene/scene.hpp"
#include "player/commands/file_option.hpp"
#include "player/commands/filters_option.hpp"
#include "player/commands/number_option.hpp"
#include "player/commands/temporal_option.hpp"
#include "player/commands/whole_option.hpp"
#include "player/commands/word_option.hpp"

namespace touchable {
namespace {

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

}  // namespace

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
    TRY_ASSIGN(const auto camera, read_camera(typed.camera));
    choice.camera = camera;
    if (typed.filters) {
        TRY_ASSIGN(const auto filters, read_filters(*typed.filters));
        choice.filters = filters;
    }
    if (!typed.temporal) return choice;
    TRY_ASSIGN(const auto temporal, read_temporal(*typed.temporal));
    choice.temporal = temporal;
    return choice;
}

}  // namespace touchable
