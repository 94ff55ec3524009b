#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace touchable {

/// A HID device as Linux's hidraw shows it.
struct HidNode {
    std::string node;       ///< "/dev/hidraw0"
    std::uint16_t bus = 0;  ///< 3: USB, 5: Bluetooth
    std::uint16_t vendor = 0, product = 0;
    std::string name;  ///< the device's own words
};

/// Of the text of a device's `uevent` ("HID_ID=0003:0000046D:0000C626" and others); nothing: it names none.
std::optional<HidNode> read_hid_uevent(std::string_view text);

/// All that are there, by their numbers. `root` is the folder that stands for "/".
std::vector<HidNode> hid_nodes(const std::filesystem::path& root = "/");
/// The first of these ids; nothing: none is there.
std::optional<HidNode> find_hid_node(
    const std::function<bool(std::uint16_t vendor, std::uint16_t product)>& is_one,
    const std::filesystem::path& root = "/");

}  // namespace touchable
