#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace touchable {

/// The file share/udev/70-touchable.rules as it was when the program was built.
const char* udev_rules();
/// Those of its rules that are for devices of a vendor.
std::vector<std::string> udev_rules_of(std::uint16_t vendor);
/// The line that permits devices to whoever sits at the machine, with nothing but this program.
inline constexpr const char* udev_rules_command =
    "touchable devices --udev-rules | sudo tee /etc/udev/rules.d/70-touchable.rules && sudo udevadm control "
    "--reload";

}  // namespace touchable
