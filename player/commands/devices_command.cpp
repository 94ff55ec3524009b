#include "player/commands/commands.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "device/device_catalog.hpp"

namespace touchable {
namespace {

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

}  // namespace

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

}  // namespace touchable
