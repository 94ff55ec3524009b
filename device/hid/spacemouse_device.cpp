#include "device/hid/spacemouse_device.hpp"

#include <array>

#include "device/hand_options.hpp"
#include "device/hid/hid_node.hpp"
#include "device/hid/hid_transport.hpp"
#include "device/hid/spacemouse_driver.hpp"
#include "device/hid/spacemouse_protocol.hpp"

namespace touchable {
namespace {

constexpr SpaceMousePace standard_pace;
constexpr std::array<HandKey, 3> spacemouse_keys{{
    {"node", "a node such as /dev/hidraw0", 0, 0, 0, HandKey::Kind::words},
    {"speed", "m/s", 0.001, 1, standard_pace.speed},
    {"reach", "m", 0.01, 1, standard_pace.reach},
}};

/// Looked for anew each time: one that is plugged in again may have another number.
Result<std::unique_ptr<ReportTransport>> open_spacemouse(const std::string& node) {
    std::string at = node;
    if (at.empty()) {
        const auto found = find_hid_node(is_spacemouse);
        if (!found)
            return Error{ErrorKind::device,
                         "no SpaceMouse is connected (USB 046d:c6xx or 256f): plug one in, or name its node",
                         {{Setting::device, "spacemouse:node=/dev/hidraw0"}}};
        at = found->node;
    }
    auto opened = HidTransport::open(at);
    if (!opened.ok()) return opened.error();
    return std::unique_ptr<ReportTransport>(std::move(*opened));
}

}  // namespace

Result<SpaceMouseSettings> read_spacemouse_settings(std::string_view keys) {
    const auto given = HandOptions::parse("device 'spacemouse'", keys, spacemouse_keys);
    if (!given.ok()) return given.error();
    return SpaceMouseSettings{given->words("node"), {given->number("speed"), given->number("reach")}};
}

Result<std::unique_ptr<HapticDevice>> make_spacemouse_device(std::string_view keys,
                                                             const DrivenSettings& driven) {
    const auto settings = read_spacemouse_settings(keys);
    if (!settings.ok()) return settings.error();
    auto open = [node = settings->node] { return open_spacemouse(node); };
    return std::unique_ptr<HapticDevice>(std::make_unique<DrivenDevice>(
        std::make_unique<SpaceMouseDriver>(settings->pace, std::move(open)), driven));
}

}  // namespace touchable
