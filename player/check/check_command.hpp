#pragma once

#include <optional>

#include "engine/result.hpp"
#include "player/check/device_check.hpp"
#include "player/check/touch_trial.hpp"
#include "player/options/command.hpp"

namespace CLI {
class App;
}

namespace touchable {

struct CheckOptions {
    bool json = false;
    std::optional<TouchDemand> demand;
    std::optional<DeviceCheckOptions> device;
};

/// Prints what this machine is and whether it can do the work: CPU, timers, codecs, Vulkan, and the builders
/// compared bit for bit. Fails (ErrorKind::check) where a clip could not be read or written, where a Vulkan
/// device does not do as it says (none at all is no fault), or where builders differ. With a demand instead
/// whether this machine is fast enough for that, from a short trial, and fails where it is not. With a device
/// what that one does (device_check.hpp).
Result<void> run_check(const CheckOptions& options);

void add_check_command(CLI::App& app, Command& command);

}  // namespace touchable
