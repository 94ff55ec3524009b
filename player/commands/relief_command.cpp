// SPDX-License-Identifier: Apache-2.0
#include <CLI/CLI.hpp>
#include <memory>
#include <string>

#include "engine/base/try.hpp"
#include "player/commands/clip_options.hpp"
#include "player/commands/commands.hpp"
#include "player/commands/convert_command.hpp"
#include "player/commands/option_types.hpp"
#include "player/session/clip_choice.hpp"

namespace touchable {
namespace {

struct ReliefTyped {
    ClipTyped clip;
    ManyClips many;
    ConvertOptions options;
    ReliefChoice relief;
};

Result<void> run_relief(const ReliefTyped& typed, const std::filesystem::path& clip,
                        const std::filesystem::path& out) {
    ConvertOptions options = typed.options;
    options.out = out;
    if (options.out.extension() != ".mkv")
        return usage_error("OUT '" + options.out.string() +
                           "' does not end in .mkv, which a clip with relief is; touchable "
                           "convert makes anything else of it");
    TRY_ASSIGN(options.clip, read_clip(typed.clip));
    options.clip.file = clip;
    if (options.clip.maps.height)
        return usage_error(
            "--height does nothing here: relief makes heights of its own; touchable convert lays a map under "
            "a clip");
    options.made = {PlaneRole::height};
    options.content = [&typed](std::unique_ptr<ClipReader> reader) {
        return with_chosen_relief(std::move(reader), typed.relief);
    };
    return run_convert(options);
}

}  // namespace

void add_relief_command(CLI::App& app, Command& command) {
    auto* sub =
        app.add_subcommand("relief", "write a clip with a relief that can be felt, made from its colour");
    auto typed = std::make_shared<ReliefTyped>();
    ReliefSettings& relief = typed->relief.settings;
    add_clip_options(*sub, typed->clip)->required();
    typed->many.add_option(*sub, "clip to write, NAME.mkv")->required();
    add_camera_options(*sub, typed->clip.camera);
    add_overwrite_option(*sub, typed->options.existing);
    begin_topic(*sub, "Relief");
    const std::pair<const char*, const char*> bands[] = {
        {"--fine", "2 to 4"}, {"--medium", "5 to 10"}, {"--coarse", "11 to 25"}};
    for (std::size_t k = 0; const auto& [name, pixels] : bands)
        add_whole_option(*sub, name, relief.bands[k++],
                         std::string("details of ") + pixels + " pixels, per cent, -400 to 400", -400, 400)
            ->capture_default_str();
    add_whole_option(*sub, "--amount", relief.amount, "strength of the whole relief, per cent, 0 to 400", 0,
                     400)
        ->capture_default_str();
    sub->add_flag("--invert", relief.invert, "let dark parts stand out, not bright ones");
    add_number_option(*sub, "--max-height", typed->relief.height_mm,
                      "height from the lowest to the highest point, mm of the hand, up to 20", 0.001, 20)
        ->type_name("MM")
        ->capture_default_str();
    sub->add_flag("--of-world", typed->relief.is_of_world,
                  "measure --max-height in mm of the recorded world, not of the hand");
    set_work(*sub, command, [typed] {
        return typed->many.for_each(
            typed->clip.choice.file, typed->options.existing,
            [typed](const auto& clip, const auto& out) { return run_relief(*typed, clip, out); });
    });
}

}  // namespace touchable
