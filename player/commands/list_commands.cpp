// Commands that list what there is: cameras, haptic devices, and what can be opened.
#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <string>

#include "device/drivers/device_catalog.hpp"
#include "engine/camera/camera.hpp"
#include "engine/formats/open_clip.hpp"
#include "engine/formats/source_description.hpp"
#include "player/commands/setting_words.hpp"

namespace touchable {
namespace {

std::string how_to_touch(const std::string& camera, const std::string& with_colour) {
    std::string lines = "    touch it:  touchable touch --live --camera " + camera + '\n';
    if (!with_colour.empty())
        lines += "    see it in its colour, and touch it:  touchable play --camera " + with_colour + '\n';
    return lines;
}

struct DevicesOptions {
    bool json = false, rules = false;
};

Result<void> run_devices(const DevicesOptions& options) {
    if (options.rules) {
        std::cout << udev_rules();
        return {};
    }
    const auto devices = connected_devices();
    if (options.json)
        std::cout << devices_in_json(devices);
    else
        std::cout << devices_in_words(devices, "--device ")
                  << "\nWhat --device takes (docs/devices.md has each one's keys):\n"
                  << device_words_in_words("touchable touch CLIP --live --device simulated --hand stroke")
                  << "See whether it works:  touchable check --device NAME\n"
                     "Touch with it:         touchable touch CLIP --live --device NAME\n";
    return {};
}

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

void add_cameras_command(CLI::App& app, Command& command) {
    app.add_subcommand("cameras", "which cameras are plugged in, and how they are touched")
        ->callback([&command] {
            command = []() -> Result<void> {
                std::cout << cameras_in_words(*system_video(), how_to_touch);
                return {};
            };
        });
}

void add_devices_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("devices", "which haptic devices are plugged in, ready or not, and why");
    auto options = std::make_shared<DevicesOptions>();
    auto* json = sub->add_flag("--json", options->json, "the same as JSON");
    sub->add_flag("--udev-rules", options->rules,
                  "the file for /etc/udev/rules.d that lets whoever sits at the machine use them")
        ->excludes(json);
    sub->callback(
        [options, &command] { command = [options]() -> Result<void> { return run_devices(*options); }; });
}

void add_formats_command(CLI::App& app, Command& command) {
    app.add_subcommand("formats", "what can be opened, and how")->callback([&command] {
        command = print_formats;
    });
}

}  // namespace touchable
