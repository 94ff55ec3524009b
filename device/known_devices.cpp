#include "device/known_devices.hpp"

#include <algorithm>
#include <array>

#include "device/spacemouse_protocol.hpp"
#include "device/woodenhaptics_device.hpp"

namespace touchable {
namespace {

using Through = KnownDevice::Through;

template <std::uint16_t vendor_id, std::uint16_t product_id>
bool is_exactly(std::uint16_t vendor, std::uint16_t product) {
    return vendor == vendor_id && product == product_id;
}

template <std::uint16_t vendor_id>
bool is_of(std::uint16_t vendor, std::uint16_t) {
    return vendor == vendor_id;
}

/// Its ids stand in either order, depending on the model.
bool is_touch(std::uint16_t vendor, std::uint16_t product) {
    return vendor == 0x2988 || (vendor == 0x0301 && product == 0x2988);
}

const std::array<KnownDevice, 9> devices{{
    {.what = "Novint Falcon",
     .has_ids = is_exactly<0x0403, 0xcb48>,
     .through = Through::usb,
     .word = "falcon",
     .driven = "falcon:firmware=FILE",
     .firmware = "is loaded into it after each power-up; whether it is there shows when it is opened"},
    {.what = "3Dconnexion SpaceMouse: moves a finger, exerts no force",
     .has_ids = is_spacemouse,
     .through = Through::hidraw,
     .word = "spacemouse",
     .is_shared = true},
    {.what = "3Dconnexion CadMouse",
     .has_ids = is_of<0x256f>,
     .why = "it is an ordinary mouse",
     .instead = "use it as the window's mouse"},
    {.what = "WoodenHaptics or Polhem (or another board with the ids of its example)",
     .has_ids = is_woodenhaptics,
     .through = Through::hidraw,
     .word = "woodenhaptics",
     .driven = "woodenhaptics:file=FILE"},
    {.what = "a Teensy with RawHID, perhaps a later Polhem",
     .has_ids = is_exactly<0x16c0, 0x0486>,
     .why = "its reports of 64 bytes are not those of WoodenHaptics' firmware",
     .instead = "let a program of yours speak with it, and pass its places on to the device network"},
    {.what = "3D Systems Touch",
     .has_ids = is_touch,
     .why = "its protocol is closed: only its vendor's driver and OpenHaptics speak it",
     .instead = "install both, and let a program of yours pass its places on to the device network"},
    {.what = "a device of Force Dimension (omega, delta, sigma, lambda)",
     .has_ids = is_of<0x1451>,
     .why = "its protocol is closed: only its vendor's SDK speaks it",
     .instead = "install it, and let a program of yours pass its places on to the device network"},
    {.what = "Leap Motion Controller: sees hands, exerts no force",
     .has_ids = is_exactly<0xf182, 0x0003>,
     .why = "only its vendor's service reads it",
     .instead = "let a program of yours pass its places on to the device network"},
    {.what = "Haply Inverse3",
     .in_name = "Inverse3",
     .through = Through::service,
     .word = "inverse3",
     .instead = "start Haply's Inverse Service, which listens at TCP port 10001",
     .port = 10001},
}};

}  // namespace

std::span<const KnownDevice> known_devices() {
    return devices;
}

const KnownDevice* known_device(std::uint16_t vendor, std::uint16_t product, std::string_view maker,
                                std::string_view name) {
    const auto fits = [&](const KnownDevice& each) {
        if (each.has_ids) return each.has_ids(vendor, product);
        return name.find(each.in_name) != std::string_view::npos ||
               maker.find(each.in_name) != std::string_view::npos;
    };
    const auto found = std::find_if(devices.begin(), devices.end(), fits);
    return found == devices.end() ? nullptr : &*found;
}

}  // namespace touchable
