#pragma once

// The rules of udev that permit devices to this machine's user: share/udev/70-touchable.rules. They are part
// of the program, so that `touchable devices --udev-rules` prints them where nothing else of it is installed,
// and a message about a device that may not be opened can say what permits it. `connected_devices`
// (device_catalog.hpp) says of each device which of them it lacks.
//
// A header of its own because it has the only literal outside player/commands that names an option, which
// tests/modules allows here alone. Any thread: nothing of it changes.

#include <cstdint>
#include <string>
#include <vector>

namespace touchable {

/// The file share/udev/70-touchable.rules as it was when the program was built.
const char* udev_rules();
/// Those of its rules that are for devices of a vendor.
std::vector<std::string> udev_rules_of(std::uint16_t vendor);
/// The line that permits devices to this machine's user, with nothing but this program.
inline constexpr const char* udev_rules_command =
    "touchable devices --udev-rules | sudo tee /etc/udev/rules.d/70-touchable.rules && sudo udevadm control "
    "--reload";

}  // namespace touchable
