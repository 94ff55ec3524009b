// SPDX-License-Identifier: Apache-2.0
#pragma once

// Tables of devices: the kinds that can be driven, each with the function that makes its driver; the hardware
// that is recognised; and Linux's view of what is connected. `make_device` and `connected_devices`
// (device_catalog.hpp) use them. The tables are constant, for any thread; a ConnectedSystem is used by one
// thread.

#include <unistd.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "device/drivers/device_catalog.hpp"
#include "engine/base/result.hpp"

namespace touchable {

/// A kind of device that a person can hold, by its name on the command line.
struct DeviceKind {
    std::string_view name;
    std::string_view words;  ///< what it is, for people
    std::string_view keys;   ///< required keys, such as ":file=FILE"; empty: none
    Result<std::unique_ptr<DeviceDriver>> (*make_driver)(std::string_view keys);
};

/// Every kind that a person can hold: neither the simulated device, which a scripted hand holds, nor the
/// window's pointer.
std::span<const DeviceKind> device_kinds();

/// A kind of hardware that is recognised by ids or name, driven or not.
struct KnownDevice {
    enum class Through {
        hidraw,   ///< its hidraw node
        usb,      ///< its usbfs node, by libusb
        service,  ///< a program of its vendor's, at a TCP port of this machine
        nothing   ///< it cannot be driven
    };
    std::string_view what;  ///< for people
    bool (*has_ids)(std::uint16_t vendor, std::uint16_t product) = nullptr;
    std::string_view in_name{};  ///< found in its maker's or its own name; empty: by ids
    Through through = Through::nothing;
    std::string_view word{};      ///< name in --device; empty: it cannot be driven
    std::string_view driven{};    ///< argument of --device, if more than `word`
    std::string_view why{};       ///< why it cannot be driven
    std::string_view instead{};   ///< what to do if it cannot be driven, or its service does not run
    std::string_view firmware{};  ///< state known without opening it; empty: its release
    std::uint16_t port = 0;       ///< TCP port of the service
    bool is_shared = false;       ///< several programs may read it
};

/// Ordered from specific to general; the first match wins.
std::span<const KnownDevice> known_devices();
/// Finds a device by ids, or by `maker` and `name` as the device reports them. Null: not known.
const KnownDevice* known_device(std::uint16_t vendor, std::uint16_t product, std::string_view maker,
                                std::string_view name);

/// Linux's view of devices and processes, /sys, /proc and /dev, below a folder that stands for "/". Paths
/// begin with "/". A file that cannot be read counts as missing.
class ConnectedSystem : NonCopyable {
public:
    explicit ConnectedSystem(std::filesystem::path root = "/") : root_(std::move(root)) {}
    virtual ~ConnectedSystem() = default;

    /// Where a path is in fact, for opening it.
    std::filesystem::path below(const std::string& path) const {
        return root_ / std::filesystem::path(path).relative_path();
    }
    /// Names in a folder, sorted.
    std::vector<std::string> names(const std::string& folder) const;
    bool has(const std::string& path) const;
    /// Text of a file, at most `most` bytes, without trailing line ends; empty: missing.
    std::string text(const std::string& path, std::size_t most = 4096) const;
    /// Target of a link; empty: no link.
    std::string link(const std::string& path) const;
    /// A path with all its links followed, from the root; empty: missing.
    std::string resolved(const std::string& path) const;

    /// Whether this user may read and write a node.
    virtual bool may_use(const std::string& node) const {
        return access(below(node).c_str(), R_OK | W_OK) == 0;
    }

private:
    const std::filesystem::path root_;
};

/// `connected_devices` of another system.
std::vector<ConnectedDevice> connected_devices(const ConnectedSystem& system);
/// The usbfs node, such as "/dev/bus/usb/001/004", of a device at its path in /sys; empty: it states none.
std::string usbfs_node(const ConnectedSystem& system, const std::string& at);
/// Whether a program listens at a TCP port of this machine.
bool has_listener(const ConnectedSystem& system, std::uint16_t port);
/// Lines of `udev_rules` for devices of a vendor.
std::vector<std::string> udev_rules_of(std::uint16_t vendor);
/// The file of `udev_rules` where udev reads it; empty: neither the package nor a person has installed it.
std::string installed_udev_rules(const ConnectedSystem& system);
/// This user may not open a device's node; the message says what permits it.
Error not_permitted(const std::string& node, const ConnectedSystem& system = ConnectedSystem());

}  // namespace touchable
