#pragma once

#include <nlohmann/json_fwd.hpp>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/result.hpp"
#include "player/commands/option_types.hpp"

namespace touchable {

/// Measurements of a device, also to attach to a bug report. Contains no names of users or folders.
struct DeviceReport {
    std::string version;  ///< of this program
    std::string kernel;   ///< "Linux 6.1.0-18-amd64 x86_64"
    std::string words;    ///< the value of --device, files without their folders
    std::string name;
    int fingers = 0;
    DeviceLimits limits;
    DeviceCapabilities capabilities;
    std::vector<ConnectedDevice> connected;  ///< devices that these words drive
    std::string thread;                      ///< rights granted to the reading thread
    std::int64_t late_ticks = 0;             ///< of the reading thread, late by 1 ms or more
    WatchFigures watch;
    DrivenFacts facts;  ///< while it was watched
    std::optional<StiffnessFinding> stiffness;
    std::string no_stiffness;  ///< why it was not measured
};

/// "falcon:firmware=/home/ada/novint.bin" as "falcon:firmware=novint.bin"; nodes in /dev stay.
std::string without_folders(const std::string& device);

std::string to_text(const DeviceReport& report);
nlohmann::ordered_json to_json(const DeviceReport& report);

/// Options of a device's measurement, as on the command line.
struct DeviceCheckOptions {
    std::string device;      ///< NAME[:key=value,...]
    int seconds = 5;         ///< duration of watching its reports
    int wait = 30;           ///< seconds to wait for its first position
    bool hands_off = false;  ///< no hand is on it: try springs without asking
    JsonOutput json;
    std::optional<std::filesystem::path> out;  ///< the report in words
};

/// Opens the device and prints its measurements; the largest stiffness only if the user confirms that no hand
/// is on it. Leaves it without force. Fails (ErrorKind::device) if it cannot be opened, has no position in
/// time, or is lost.
Result<void> run_device_check(const DeviceCheckOptions& options);

}  // namespace touchable
