#include "device/woodenhaptics_protocol.hpp"

#include <string>

namespace touchable {
namespace {

using Words = std::array<std::int16_t, 7>;

WoodenReport report_of(const Words& words) {
    WoodenReport report{};
    for (std::size_t word = 0; word < words.size(); ++word) {
        const auto bits = static_cast<std::uint16_t>(words[word]);
        report[1 + 2 * word] = static_cast<std::byte>(bits & 0xff);
        report[2 + 2 * word] = static_cast<std::byte>(bits >> 8);
    }
    return report;
}

}  // namespace

Result<WoodenReading> decode_wooden_reading(std::span<const std::byte> report) {
    if (report.size() != WoodenReading::bytes)
        return Error{ErrorKind::device, "a report of " + std::to_string(report.size()) +
                                            " bytes came; right would be the 14 of WoodenHaptics' firmware"};
    Words words;
    for (std::size_t word = 0; word < words.size(); ++word) {
        const auto low = std::to_integer<unsigned>(report[2 * word]);
        const auto high = std::to_integer<unsigned>(report[2 * word + 1]);
        words[word] = static_cast<std::int16_t>(static_cast<std::uint16_t>(low | high << 8));
    }
    return WoodenReading{{words[0], words[1], words[2], words[3], words[4], words[5]}, words[6]};
}

WoodenReport encode_wooden_currents(const std::array<std::int16_t, 3>& milliamperes) {
    return report_of({milliamperes[0], milliamperes[1], milliamperes[2], 0, 0, 0, 0});
}

WoodenReport encode_wooden_counters(const std::array<std::int16_t, 6>& counters) {
    // The last three travel where the currents would.
    return report_of({counters[3], counters[4], counters[5], 1, counters[0], counters[1], counters[2]});
}

}  // namespace touchable
