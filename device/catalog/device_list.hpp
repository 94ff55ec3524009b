#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "device/catalog/connected_system.hpp"

namespace touchable {

/// A device that is connected and known.
struct ConnectedDevice {
    std::string place;  ///< "usb 1-2.3", "bluetooth", "other" (HID of no bus that is known)
    std::uint16_t vendor = 0, product = 0;
    std::string name;                  ///< the device's own words, from outside
    std::string what;                  ///< for people
    std::string driven;                ///< what to write behind --device; empty: it cannot be driven
    std::string why_not;               ///< it cannot be driven; empty: it can
    std::string firmware;              ///< what shows of it; empty: nothing
    std::vector<std::string> nodes{};  ///< its nodes in /dev
    std::string node;                  ///< the one that it would be driven by; empty: none, or there is none
    bool may_use = false;              ///< that node, by this user
    std::vector<std::string>
        rules{};  ///< of udev, that would let whoever sits at the machine use it; empty: it may be
    std::vector<std::string> held_by{};  ///< programs that have one of its nodes open, as far as it shows
    bool ready = false;
    std::string next;  ///< the one line that makes it ready, or helps where it cannot be driven; empty: ready
};

/// All that are connected and known, by USB and Bluetooth; opens none of them.
std::vector<ConnectedDevice> connected_devices(const ConnectedSystem& system);

/// For a person: lines; with none connected one, which says what to do.
std::string devices_in_words(const std::vector<ConnectedDevice>& devices);
/// Every word that --device takes, a line each, and how to begin.
std::string device_words_in_words();
/// The same as JSON, with members named as above, ids as "046d:c626", and `words`.
std::string devices_in_json(const std::vector<ConnectedDevice>& devices);

}  // namespace touchable
