#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "engine/base/result.hpp"

namespace touchable {

/// What the board of a WoodenHaptics or a Polhem tells: a report of 14 bytes without a number, seven integers
/// of 16 bits, low byte first. It sends one for each that it is sent.
struct WoodenReading {
    static constexpr std::size_t bytes = 14;

    std::array<std::int16_t, 6> encoders{};  ///< counters, quadrupled counts; the first three move the handle
    std::int16_t info = 0;                   ///< 1: its button was pressed, to have the counters set
};

/// Refuses (ErrorKind::device) any other number of bytes.
Result<WoodenReading> decode_wooden_reading(std::span<const std::byte> report);

/// What it is told, as HID takes it: a 0 where other devices have the report's number, then seven integers
/// of 16 bits. It acts on a report for half a second at most.
using WoodenReport = std::array<std::byte, 1 + 14>;
/// Command 0: currents of the three motors, mA.
WoodenReport encode_wooden_currents(const std::array<std::int16_t, 3>& milliamperes);
/// Command 1: no currents, and its six counters are these from now on; its button counts as not pressed.
WoodenReport encode_wooden_counters(const std::array<std::int16_t, 6>& counters);

}  // namespace touchable
