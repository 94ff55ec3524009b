#include "device/spacemouse_protocol.hpp"

#include <algorithm>
#include <iterator>
#include <string>

namespace touchable {
namespace {

constexpr std::size_t three_axes = 6;
constexpr std::size_t most_button_bytes = 4;

int axis_at(std::span<const std::byte> bytes, std::size_t at) {
    const auto low = std::to_integer<unsigned>(bytes[at]);
    const auto high = std::to_integer<unsigned>(bytes[at + 1]);
    return static_cast<std::int16_t>(static_cast<std::uint16_t>(low | high << 8));
}

Error too_short(std::span<const std::byte> bytes, std::size_t right) {
    return {ErrorKind::device, "a SpaceMouse's report " + std::to_string(std::to_integer<int>(bytes[0])) +
                                   " has " + std::to_string(bytes.size()) + " bytes; right would be " +
                                   std::to_string(right) + " or more"};
}

}  // namespace

bool is_spacemouse(std::uint16_t vendor, std::uint16_t product) {
    constexpr std::uint16_t ordinary_mice[] = {0xc650, 0xc651, 0xc654, 0xc655, 0xc656, 0xc657, 0xc658};
    if (vendor == 0x046d) return product >= 0xc603 && product <= 0xc63f;
    return vendor == 0x256f &&
           std::find(std::begin(ordinary_mice), std::end(ordinary_mice), product) == std::end(ordinary_mice);
}

Result<SpaceMouseReport> decode_spacemouse_report(std::span<const std::byte> bytes) {
    if (bytes.empty()) return Error{ErrorKind::device, "a SpaceMouse's report has no bytes"};
    SpaceMouseReport report;
    switch (std::to_integer<int>(bytes[0])) {
        case 1:
            if (bytes.size() < 1 + three_axes) return too_short(bytes, 1 + three_axes);
            report.translation = glm::ivec3(axis_at(bytes, 1), axis_at(bytes, 3), axis_at(bytes, 5));
            return report;
        case 2:
            if (bytes.size() < 1 + three_axes) return too_short(bytes, 1 + three_axes);
            return report;
        case 3: {
            if (bytes.size() < 2) return too_short(bytes, 2);
            std::uint32_t buttons = 0;
            for (std::size_t byte = 0; byte < std::min(bytes.size() - 1, most_button_bytes); ++byte)
                buttons |= std::to_integer<std::uint32_t>(bytes[1 + byte]) << (8 * byte);
            report.buttons = buttons;
            return report;
        }
        default:
            return report;
    }
}

}  // namespace touchable
