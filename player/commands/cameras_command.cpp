#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <string>

#include "engine/camera/camera.hpp"

namespace touchable {
namespace {

std::string how_to_touch(const std::string& camera, const std::string& with_colour) {
    std::string lines = "    touch it:  touchable touch --live --camera " + camera + '\n';
    if (!with_colour.empty())
        lines += "    see it in its colour, and touch it:  touchable play --camera " + with_colour + '\n';
    return lines;
}

}  // namespace

void add_cameras_command(CLI::App& app, Command& command) {
    app.add_subcommand("cameras", "which cameras are plugged in, and how they are touched")
        ->callback([&command] {
            command = []() -> Result<void> {
                std::cout << cameras_in_words(*system_video(), how_to_touch);
                return {};
            };
        });
}

}  // namespace touchable
