#pragma once

#include <nlohmann/json_fwd.hpp>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/files.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// What was found out of a device: to read, and to attach to a fault. It names no person and no folder.
struct DeviceReport {
    std::string version;  ///< of this program
    std::string kernel;   ///< "Linux 6.1.0-18-amd64 x86_64"
    std::string words;    ///< as behind --device, files without their folders
    std::string name;
    int fingers = 0;
    DeviceLimits limits;
    DeviceCapabilities capabilities;
    std::vector<ConnectedDevice> connected;  ///< those that these words drive
    std::string thread;                      ///< what the reading thread was granted
    std::int64_t late_ticks = 0;             ///< of the reading thread, by a millisecond and more
    WatchFigures watch;
    DrivenFacts facts;  ///< while it was watched
    std::optional<StiffnessFinding> stiffness;
    std::string no_stiffness;  ///< why there is none
};

/// "falcon:firmware=/home/ada/novint.bin" as "falcon:firmware=novint.bin"; nodes in /dev stay.
std::string without_folders(const std::string& device);

std::string to_text(const DeviceReport& report);
nlohmann::ordered_json to_json(const DeviceReport& report);

/// What is to be measured of a device, as on the command line.
struct DeviceCheckOptions {
    std::string device;      ///< NAME[:key=value,...]
    int seconds = 5;         ///< its reports are watched
    int wait = 30;           ///< seconds, for its first position
    bool hands_off = false;  ///< no hand is on it: springs may be tried without asking
    bool json = false;
    std::optional<std::filesystem::path> out;  ///< the report in words
    Existing existing = Existing::keep;
};

/// Opens the device and prints what it does; the largest stiffness only where a person says that no hand is
/// on it. Leaves it without force. Fails (ErrorKind::device) where it cannot be opened, has no position in
/// time, or is lost.
Result<void> run_device_check(const DeviceCheckOptions& options);

}  // namespace touchable
