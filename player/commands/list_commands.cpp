// Commands that list plugged-in cameras and haptic devices.
#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/try.hpp"
#include "engine/camera/camera.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {
namespace {

std::string how_to_touch(const std::string& camera, const std::string& with_colour) {
    std::string lines = "    touch it:  touchable touch --live --camera " + camera + '\n';
    if (!with_colour.empty())
        lines += "    see it in its colour, and touch it:  touchable play --camera " + with_colour + '\n';
    return lines;
}

Result<void> run_cameras(const JsonOutput& json) {
    TRY(json.check());
    const auto system = system_video();
    if (!json.replaces_words()) std::cout << on_terminal(cameras_in_words(*system, how_to_touch));
    return json.write(nlohmann::ordered_json::parse(cameras_in_json(*system)));
}

struct DevicesOptions {
    JsonOutput json;
    bool rules = false;
};

Result<void> run_devices(const DevicesOptions& options) {
    if (options.rules) {
        std::cout << udev_rules();
        return {};
    }
    TRY(options.json.check());
    const auto devices = connected_devices();
    if (!options.json.replaces_words())
        std::cout << on_terminal(
            devices_in_words(devices, "--device ", has_udev_rules()) +
            "\nWhat --device takes (docs/devices.md has each one's keys):\n" +
            device_words_in_words("touchable touch CLIP --live --device simulated --hand stroke") +
            "See whether it works:  touchable check --device NAME\n"
            "Touch with it:         touchable touch CLIP --live --device NAME\n");
    return options.json.write(nlohmann::ordered_json::parse(devices_in_json(devices)));
}

}  // namespace

void add_cameras_command(CLI::App& app, Command& command) {
    auto* sub = app.add_subcommand("cameras", "list the cameras that are plugged in, and how to touch them");
    auto json = std::make_shared<JsonOutput>();
    add_json_option(*sub, *json, "print the same as JSON");
    set_work(*sub, command, [json] { return run_cameras(*json); });
}

void add_devices_command(CLI::App& app, Command& command) {
    auto* sub =
        app.add_subcommand("devices", "list the haptic devices that are plugged in, ready or not, and why");
    auto options = std::make_shared<DevicesOptions>();
    auto* json = add_json_option(*sub, options->json, "print the same as JSON");
    sub->add_flag("--udev-rules", options->rules,
                  "print the file for /etc/udev/rules.d that permits them to the person at the machine")
        ->excludes(json);
    set_work(*sub, command, [options] { return run_devices(*options); });
}

}  // namespace touchable
