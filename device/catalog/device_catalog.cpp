#include "device/catalog/device_catalog.hpp"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "device/catalog/device_list.hpp"
#include "device/catalog/known_devices.hpp"
#include "device/falcon/falcon_device.hpp"
#include "device/hid/spacemouse_device.hpp"
#include "device/hid/woodenhaptics_device.hpp"
#include "device/inverse3/inverse3_device.hpp"
#include "device/network/network_device.hpp"
#include "device/recorded/recorded_device.hpp"
#include "engine/printable.hpp"

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

/// Of two words, as Levenshtein counts: letters that are to be put in, left out or changed.
std::size_t letters_between(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t corner = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t changed = corner + (a[i] == b[j] ? 0 : 1);
            corner = row[j + 1];
            row[j + 1] = std::min({changed, corner + 1, row[j] + 1});
        }
    }
    return row.back();
}

Error unknown_device(const std::string& name) {
    constexpr std::size_t most_letters = 3;
    if (name == "mouse")
        return usage_error("--device mouse is the window's, where no device is needed: touchable play CLIP");
    std::string names, nearest;
    std::size_t least = std::min(most_letters, name.size() / 2) + 1;
    const auto list = [&](std::string_view word) {
        names += (names.empty() ? "" : ", ") + std::string(word);
        if (const std::size_t letters = letters_between(name.substr(0, 64), word); letters < least) {
            least = letters;
            nearest = word;
        }
    };
    for (const DeviceKind& each : kinds) list(each.name);
    list("simulated");
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
