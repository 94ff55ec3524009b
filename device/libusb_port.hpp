#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "device/usb_port.hpp"

namespace touchable {

/// Where Linux describes USB devices, and where their nodes are.
struct UsbFolders {
    std::filesystem::path devices = "/sys/bus/usb/devices";
    std::filesystem::path nodes = "/dev/bus/usb";
};

/// The node in `nodes` of the first device of that vendor and product (four hexadecimal digits each), by bus
/// and number; empty: none is plugged in.
std::filesystem::path find_usb_device(const std::string& vendor, const std::string& product,
                                      const UsbFolders& folders);

/// A USB device with one interface, by its node, through libusb: endpoint 0x02 out, 0x81 in. A driver of
/// Linux's is put aside as long as it is held. `name` is the device's, for messages. Error
/// (ErrorKind::device): why it cannot be had, and what would change that.
Result<std::unique_ptr<UsbPort>> open_usb_port(const std::filesystem::path& node, const std::string& name);

/// The first Novint Falcon that is plugged in.
Result<std::unique_ptr<UsbPort>> open_falcon(const UsbFolders& folders = {});

}  // namespace touchable
