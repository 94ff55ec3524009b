#include "device/device_catalog.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "device/device_list.hpp"
#include "device/falcon_device.hpp"
#include "device/inverse3_device.hpp"
#include "device/known_devices.hpp"
#include "device/network_device.hpp"
#include "device/recorded_device.hpp"
#include "device/spacemouse_device.hpp"
#include "device/woodenhaptics_device.hpp"
#include "engine/base/nearest_word.hpp"
#include "engine/base/printable.hpp"

namespace touchable {
namespace {

constexpr DeviceKind kinds[] = {
    {"falcon", "a Novint Falcon (USB)", ":firmware=FILE", make_falcon_device},
    {"inverse3", "a Haply Inverse3, through the service of its makers", "", make_inverse3_device},
    {"woodenhaptics", "WoodenHaptics and Polhem, open hardware (HID); its build is described in a file",
     ":file=FILE", make_woodenhaptics_device},
    {"spacemouse", "a 3Dconnexion SpaceMouse (HID) moves the finger; it exerts no force", "",
     make_spacemouse_device},
    {"network", "any program that sends UDP datagrams (docs/network-hand.md)", "", make_network_device},
    {"recorded", "a log of any device, told again", ":FILE", make_recorded_device},
};

/// Whoever gives a file that will not do hears of missing hardware at once, not after that.
Error also_unplugged(Error error, std::string_view name) {
    const auto known = known_devices();
    const bool is_hardware =
        std::any_of(known.begin(), known.end(), [&](const KnownDevice& each) { return each.word == name; });
    if (error.kind != ErrorKind::input || !is_hardware) return error;
    const auto connected = connected_devices(ConnectedSystem());
    const bool is_there = std::any_of(connected.begin(), connected.end(), [&](const ConnectedDevice& each) {
        return std::string_view(each.driven).substr(0, each.driven.find(':')) == name;
    });
    if (!is_there) error.message += "; and no " + std::string(name) + " is connected";
    return error;
}

Error unknown_device(const std::string& name) {
    if (name == "mouse")
        return usage_error("device mouse is the window's, where no device is needed: touchable play CLIP",
                           {{Setting::device}});
    std::vector<std::string> words;
    for (const DeviceKind& each : kinds) words.emplace_back(each.name);
    words.emplace_back("simulated");
    std::string names;
    for (const std::string& word : words) names += (names.empty() ? "" : ", ") + word;
    const std::string nearest = nearest_word(name, words);
    return usage_error("unknown device '" + printable(name) + "'" +
                       (nearest.empty() ? "; there are " : "; did you mean " + nearest + "? There are ") +
                       names + "; and mouse, in the window alone (touchable play)");
}

}  // namespace

std::span<const DeviceKind> device_kinds() {
    return kinds;
}

Result<std::unique_ptr<HapticDevice>> make_device(const std::string& description,
                                                  const DrivenSettings& driven) {
    const std::size_t colon = description.find(':');
    const std::string name = description.substr(0, colon);
    const auto kind = std::find_if(std::begin(kinds), std::end(kinds),
                                   [&](const DeviceKind& each) { return each.name == name; });
    if (kind == std::end(kinds)) return unknown_device(name);
    auto device = kind->make(
        colon == std::string::npos ? std::string_view() : std::string_view(description).substr(colon + 1),
        driven);
    if (!device.ok()) return also_unplugged(device.error(), name);
    return device;
}

}  // namespace touchable
