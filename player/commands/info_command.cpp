#include "player/commands/info_command.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <utility>

#include "player/commands/clip_report.hpp"
#include "player/options/camera_options.hpp"
#include "player/options/clip_options.hpp"
#include "player/run/memory.hpp"

namespace touchable {

namespace {

Result<void> print_facts(const InfoOptions& options) {
    const auto facts = clip_facts(options.clip);
    if (!facts.ok()) return facts.error();
    if (options.json)  // names of files need not be UTF-8
        std::cout << to_json(*facts).dump(2, ' ', false, nlohmann::json::error_handler_t::replace) << '\n';
    else
        std::cout << to_text(*facts);
    return {};
}

}  // namespace

Result<void> run_info(const InfoOptions& options) {
    return within_memory("the frames of " + options.clip.file.string(), [&] { return print_facts(options); });
}

void add_info_command(CLI::App& app, Command& command) {
    auto* info = app.add_subcommand("info", "say what a clip is: size, rate, camera, depth coding, touch");
    auto json = std::make_shared<bool>(false);
    auto clip = std::make_shared<ClipTyped>();
    add_clip_options(*info, *clip)->required();
    info->add_flag("--json", *json, "the same facts as JSON");
    add_camera_options(*info, clip->camera);
    add_filter_options(*info, *clip);
    info->callback([json, clip, &command] {
        command = [json, clip]() -> Result<void> {
            auto choice = read_clip(*clip);
            if (!choice.ok()) return choice.error();
            return run_info({std::move(*choice), *json});
        };
    });
}

}  // namespace touchable
