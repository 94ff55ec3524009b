#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <iostream>

#include "engine/formats/open_clip.hpp"
#include "engine/formats/source_description.hpp"
#include "player/commands/setting_words.hpp"

namespace touchable {
namespace {

Result<void> print_formats() {
    std::cout << "What can be opened (docs/formats.md), and the command that opens it:\n";
    for (const ClipFormat& format : clip_formats())
        std::cout << "  " << format.what << "\n      " << format.command << typed_options(format.settings)
                  << '\n';
    std::cout << "Maps of touch that serve all frames of any of them (docs/scene_file.md):\n"
                 "  stiffness and friction: a picture, H3D's X3D (HapticTexturesSurface), glTF "
                 "(MPEG_haptic_material)\n      touchable play depth.webm --haptic surface.x3d\n"
                 "  heights: a picture in grey\n      touchable play depth.webm --height bumps.png\n";
    std::cout << "What is known of pictures by name (--preset NAME):\n";
    for (const SourceDescription::Preset& preset : all_presets())
        std::cout << "  " << preset.name
                  << std::string(18 - std::min<std::size_t>(17, std::string(preset.name).size()), ' ')
                  << preset.what << '\n';
    std::cout << "  hue               of a video without a scene file: its depth is hue\n"
                 "  mean              likewise: its depth is the mean of red, green and blue\n";
    return {};
}

}  // namespace

void add_formats_command(CLI::App& app, Command& command) {
    app.add_subcommand("formats", "what can be opened, and how")->callback([&command] {
        command = print_formats;
    });
}

}  // namespace touchable
