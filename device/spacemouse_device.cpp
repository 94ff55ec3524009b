#include "device/spacemouse_device.hpp"

#include <array>

#include "device/hand_options.hpp"
#include "device/hid_node.hpp"
#include "device/hid_transport.hpp"
#include "device/spacemouse_driver.hpp"
#include "device/spacemouse_protocol.hpp"
#include "engine/base/try.hpp"

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
    TRY_ASSIGN(auto opened, HidTransport::open(at));
    return std::unique_ptr<ReportTransport>(std::move(opened));
}

}  // namespace

Result<SpaceMouseSettings> read_spacemouse_settings(std::string_view keys) {
    TRY_ASSIGN(const auto given, HandOptions::parse("device 'spacemouse'", keys, spacemouse_keys));
    return SpaceMouseSettings{given.words("node"), {given.number("speed"), given.number("reach")}};
}

Result<std::unique_ptr<HapticDevice>> make_spacemouse_device(std::string_view keys,
                                                             const DrivenSettings& driven) {
    TRY_ASSIGN(const auto settings, read_spacemouse_settings(keys));
    auto open = [node = settings.node] { return open_spacemouse(node); };
    return std::unique_ptr<HapticDevice>(std::make_unique<DrivenDevice>(
        std::make_unique<SpaceMouseDriver>(settings.pace, std::move(open)), driven));
}

}  // namespace touchable
