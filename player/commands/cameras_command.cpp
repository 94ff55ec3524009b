#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "engine/camera/camera_list.hpp"

namespace touchable {

void add_cameras_command(CLI::App& app, Command& command) {
    app.add_subcommand("cameras", "which cameras are plugged in, and how they are touched")
        ->callback([&command] {
            command = []() -> Result<void> {
                std::cout << cameras_in_words(*system_video());
                return {};
            };
        });
}

}  // namespace touchable
