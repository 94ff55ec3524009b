#include "device/network_device.hpp"

#include <array>

#include "device/hand_options.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

const NetworkSettings standard_hand;
const std::array<HandKey, 6> network_keys{{
    {"listen", "an address in figures, such as 0.0.0.0", 0, 0, 0, HandKey::Kind::words},
    {"from", "an address in figures, such as 192.168.1.7", 0, 0, 0, HandKey::Kind::words},
    {"port", "", 1, 65535, static_cast<double>(standard_hand.port), HandKey::Kind::whole},
    {"fingers", "", 1, NetworkPacket::most_fingers, static_cast<double>(standard_hand.fingers),
     HandKey::Kind::whole},
    {"force", "N", 0.1, 1000, standard_hand.limits.max_force},
    {"stiffness", "N/mm", 0.01, 1000, standard_hand.limits.max_stiffness / 1000},
}};

}  // namespace

Result<NetworkSettings> read_network_settings(std::string_view keys) {
    const auto given = HandOptions::parse("device 'network'", keys, network_keys);
    if (!given.ok()) return given.error();
    NetworkSettings settings;
    if (given->given("listen")) settings.listen = given->words("listen");
    if (given->given("from")) settings.from = given->words("from");
    if (!settings.from.empty() && !read_udp_address(settings.from))
        return usage_error("device 'network': from=" + settings.from +
                           " is no address in figures; right would be such as 192.168.1.7");
    settings.port = static_cast<std::uint16_t>(given->number("port"));
    settings.fingers = static_cast<int>(given->number("fingers"));
    settings.limits = {given->number("force"), given->number("stiffness") * 1000};
    return settings;
}

Result<std::unique_ptr<HapticDevice>> make_network_device(std::string_view keys,
                                                          const DrivenSettings& driven) {
    TRY_ASSIGN(const auto settings, read_network_settings(keys));
    return std::unique_ptr<HapticDevice>(
        std::make_unique<DrivenDevice>(std::make_unique<NetworkDriver>(settings), driven));
}

}  // namespace touchable
