#include "device/catalog/device_catalog.hpp"

#include <algorithm>

#include "device/falcon/falcon_device.hpp"
#include "device/hid/spacemouse_device.hpp"
#include "device/hid/woodenhaptics_device.hpp"
#include "device/inverse3/inverse3_device.hpp"
#include "device/network/network_device.hpp"
#include "device/recorded/recorded_device.hpp"

namespace touchable {
namespace {

constexpr DeviceKind kinds[] = {
    {"falcon", "a Novint Falcon (USB)", make_falcon_device},
    {"inverse3", "a Haply Inverse3, through the service of its makers", make_inverse3_device},
    {"woodenhaptics", "WoodenHaptics and Polhem, open hardware (HID); its build is described in a file",
     make_woodenhaptics_device},
    {"spacemouse", "a 3Dconnexion SpaceMouse (HID) moves the finger; it exerts no force",
     make_spacemouse_device},
    {"network", "any program that sends UDP datagrams (docs/network-hand.md)", make_network_device},
    {"recorded", "a log of any device, told again: recorded:FILE", make_recorded_device},
};

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
    if (kind != std::end(kinds))
        return kind->make(
            colon == std::string::npos ? std::string_view() : std::string_view(description).substr(colon + 1),
            driven);
    if (name == "mouse") return usage_error("--device mouse is the window's: touchable play CLIP");
    std::string names = "simulated";
    for (const DeviceKind& each : kinds) names += ", " + std::string(each.name);
    return usage_error("unknown device '" + name + "'; there are " + names);
}

}  // namespace touchable
