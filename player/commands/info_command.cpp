#include "player/commands/info_command.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "player/commands/camera_options.hpp"
#include "player/commands/clip_report.hpp"
#include "player/commands/file_option.hpp"
#include "player/session/memory.hpp"

namespace touchable {

namespace {

Result<void> print_facts(const InfoOptions& options) {
    const auto facts = clip_facts(options.clip, options.scene, options.camera);
    if (!facts.ok()) return facts.error();
    if (options.json)  // names of files need not be UTF-8
        std::cout << to_json(*facts).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
    else
        std::cout << to_text(*facts);
    return {};
}

}  // namespace

Result<void> run_info(const InfoOptions& options) {
    return within_memory("the frames of " + options.clip.string(), [&] { return print_facts(options); });
}

void add_info_command(CLI::App& app, Command& command) {
    auto* info = app.add_subcommand("info", "say what a clip is: size, rate, camera, depth coding, touch");
    auto options = std::make_shared<InfoOptions>();
    auto typed = std::make_shared<CameraTyped>();
    add_file_option(*info, "CLIP", options->clip,
                    "a clip, a folder of images, a depth picture, or a scene file")
        ->required();
    add_file_option(*info, "--scene", options->scene,
                    "scene file that describes the clip instead of its own");
    info->add_flag("--json", options->json, "the same facts as JSON");
    add_camera_options(*info, *typed);
    info->callback([options, typed, &command] {
        command = [options, typed]() -> Result<void> {
            const auto camera = read_camera(*typed);
            if (!camera.ok()) return camera.error();
            InfoOptions chosen = *options;
            chosen.camera = *camera;
            return run_info(chosen);
        };
    });
}

}  // namespace touchable
