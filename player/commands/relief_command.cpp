#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "engine/content/relief/relief_clip.hpp"
#include "engine/surface/surface_builder.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/convert_command.hpp"
#include "player/options/clip_options.hpp"
#include "player/options/file_option.hpp"
#include "player/options/number_option.hpp"
#include "player/options/outputs.hpp"
#include "player/options/whole_option.hpp"
#include "player/run/clip_workspace.hpp"

namespace touchable {
namespace {

struct ReliefTyped {
    ClipTyped clip;
    ConvertOptions options;
    ReliefSettings relief;
    double height_mm = 0.5;
    bool is_of_world = false;
};

/// Metres of the hand for a scene unit, where no device of its own says otherwise.
Result<double> hand_scale(ClipReader& clip) {
    if (clip.scene().device_metres_per_unit) return *clip.scene().device_metres_per_unit;
    const auto first = clip.next();
    if (!first.ok()) return first.error();
    if (!*first) return input_error(clip.inputs().front().string() + ": has no frames");
    SurfaceFrame surface;
    if (auto built = make_cpu_builder(clip.scene())->build(**first, surface); !built.ok())
        return built.error();
    const double scale = clip_workspace(clip.scene(), surface).metres_per_scene_unit;
    if (auto back = clip.rewind(); !back.ok()) return back.error();
    return scale;
}

Result<void> run_relief(const ReliefTyped& typed) {
    ConvertOptions options = typed.options;
    if (options.out.extension() != ".mkv")
        return usage_error("OUT '" + options.out.string() +
                           "' does not end in .mkv, which a clip with relief is; touchable "
                           "convert makes anything else of it");
    const auto choice = read_clip(typed.clip);
    if (!choice.ok()) return choice.error();
    options.clip = *choice;
    if (options.clip.maps.height)
        return usage_error(
            "--height does nothing here: relief makes heights of its own; touchable convert lays a map under "
            "a clip");
    options.content = [&typed](std::unique_ptr<ClipReader> clip) -> Result<std::unique_ptr<ClipReader>> {
        double metres_per_unit = clip->scene().metres_per_unit;
        if (!typed.is_of_world) {
            const auto scale = hand_scale(*clip);
            if (!scale.ok()) return scale.error();
            metres_per_unit = *scale;
        }
        return with_relief(std::move(clip), typed.relief, typed.height_mm / 1000 / metres_per_unit);
    };
    return run_convert(options);
}

}  // namespace

void add_relief_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("relief", "write a clip with a relief to be felt, made of its colour");
    auto typed = std::make_shared<ReliefTyped>();
    ReliefSettings& relief = typed->relief;
    add_clip_options(*sub, typed->clip)->required();
    add_file_option(*sub, "OUT", typed->options.out, "the clip to write, NAME.mkv")->required();
    add_camera_options(*sub, typed->clip.camera);
    add_overwrite_option(*sub, typed->options.existing);
    const char* share = "per cent, -400 to 400";
    add_whole_option(*sub, "--fine", relief.bands[0], std::string("details of 2 to 4 pixels, ") + share, -400,
                     400)
        ->capture_default_str();
    add_whole_option(*sub, "--medium", relief.bands[1], std::string("details of 5 to 10 pixels, ") + share,
                     -400, 400)
        ->capture_default_str();
    add_whole_option(*sub, "--coarse", relief.bands[2], std::string("details of 11 to 25 pixels, ") + share,
                     -400, 400)
        ->capture_default_str();
    add_whole_option(*sub, "--amount", relief.amount, "of all of it, per cent, 0 to 400", 0, 400)
        ->capture_default_str();
    sub->add_flag("--invert", relief.invert, "what is dark stands out, not what is bright");
    add_number_option(*sub, "--max-height", typed->height_mm,
                      "from the deepest to the highest, mm of the hand, up to 20", 0.001, 20)
        ->capture_default_str();
    sub->add_flag("--of-world", typed->is_of_world,
                  "--max-height is mm of the world that was recorded, not of the hand");
    sub->callback([typed, &command] { command = [typed] { return run_relief(*typed); }; });
}

}  // namespace touchable
