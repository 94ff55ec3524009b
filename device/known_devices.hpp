#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "device/device_catalog.hpp"

namespace touchable {

/// A kind of hardware that is known by its ids or its name, driven or not.
struct KnownDevice {
    enum class Through {
        hidraw,   ///< its hidraw node
        usb,      ///< its usbfs node, by libusb
        service,  ///< a program of its vendor's, at a TCP port of this machine
        nothing   ///< it cannot be driven
    };
    std::string_view what;  ///< for people
    bool (*has_ids)(std::uint16_t vendor, std::uint16_t product) = nullptr;
    std::string_view
        in_name{};  ///< known by these words in its maker's or its own name instead; empty: by ids
    Through through = Through::nothing;
    std::string_view word{};     ///< of --device, which drives it; empty: it cannot be driven
    std::string_view driven{};   ///< what to write behind --device, where that is more than the word
    std::string_view why{};      ///< it cannot be driven
    std::string_view instead{};  ///< what to do then, or with a service that does not run
    std::string_view
        firmware{};          ///< what is known of its state without opening it; empty: its release counts
    std::uint16_t port = 0;  ///< of a service
    bool is_shared = false;  ///< several programs may read it
};

/// Ordered from specific to general; the first match wins.
std::span<const KnownDevice> known_devices();
/// Nothing: it is not known. `maker` and `name` are the device's own words.
const KnownDevice* known_device(std::uint16_t vendor, std::uint16_t product, std::string_view maker,
                                std::string_view name);

/// Whether a program listens at a TCP port of this machine.
bool somebody_listens(const ConnectedSystem& system, std::uint16_t port);

}  // namespace touchable
