#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "engine/base/new_file.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// What is to be measured of a device, as on the command line.
struct DeviceCheckOptions {
    std::string device;      ///< NAME[:key=value,...]
    int seconds = 5;         ///< its reports are watched
    int wait = 30;           ///< seconds, for its first position
    bool hands_off = false;  ///< nobody holds it: springs may be tried without asking
    bool json = false;
    std::optional<std::filesystem::path> out;  ///< the report in words
    Existing existing = Existing::keep;
};

/// Opens the device and prints what it does; the largest stiffness only where somebody says that no hand is
/// on it. Leaves it without force. Fails (ErrorKind::device) where it cannot be opened, has no position in
/// time, or is lost.
Result<void> run_device_check(const DeviceCheckOptions& options);

}  // namespace touchable
