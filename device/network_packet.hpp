#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <string>
#include <vector>

#include "engine/base/result.hpp"

namespace touchable {

/// One datagram of a network hand (docs/network-hand.md): where fingers are, or what they feel.
struct NetworkPacket {
    enum class Kind : std::uint8_t {
        places = 1,  ///< to touchable: metres
        forces = 2   ///< from touchable: newtons
    };
    static constexpr std::uint8_t version = 1;
    static constexpr std::size_t most_fingers = 10;
    static constexpr std::size_t most_bytes = 24 + most_fingers * 24 + 4;

    Kind kind = Kind::places;
    std::uint32_t sequence =
        0;  ///< of places: counts up by whoever sends; of forces: that of the places answered
    std::uint32_t buttons = 0;  ///< of places: one bit each
    std::uint64_t time_ns = 0;  ///< of places: the sender's own clock; of forces: that of the places answered
    bool last = false;          ///< nothing more will come: forces are to be zero
    bool stands_still = false;  ///< of forces: zero, because nobody computes any now; answers nothing
    int fingers = 1;            ///< 1 to `most_fingers`
    std::array<glm::dvec3, most_fingers> vectors{};
};

/// 28 + 24 x fingers bytes, little-endian, with a CRC-32.
std::vector<std::byte> encode(const NetworkPacket& packet);
/// Error (ErrorKind::input): what is wrong with the bytes, and what would be right.
Result<NetworkPacket> decode_network_packet(std::span<const std::byte> bytes);

}  // namespace touchable
