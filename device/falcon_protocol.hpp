#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

namespace touchable {

/// The packets of the Novint Falcon, as its owners have described them (libnifalcon's documentation): 16
/// bytes in each direction, '<', 14 that carry four bits each as 'A' + bits, '>'. The device answers each
/// packet with one; packets have no number, time or checksum.
inline constexpr std::size_t falcon_packet_bytes = 16;
using FalconPacket = std::array<std::byte, falcon_packet_bytes>;

/// Lamps in the Falcon's ring.
enum class FalconLamp : std::uint8_t { none = 0, green = 2, blue = 4, red = 8 };

struct FalconCommand {
    std::array<std::int16_t, 3> motors{};  ///< of the top, right and left arm
    FalconLamp lamp = FalconLamp::none;
};
/// It also asks for the state of homing, always: without that the Falcon does not follow its encoders.
FalconPacket encode(const FalconCommand& command);

struct FalconReport {
    std::array<std::int16_t, 3> counts{};  ///< of the top, right and left encoder
    std::uint8_t buttons = 0;              ///< bits 0 to 3: right, forward, middle, left one of the grip
    bool homed = false;  ///< all three encoders have met their marks, so that counts mean places
};

/// Finds reports among bytes that may be cut, damaged or repeated: one begins at each '<', and none is
/// believed of which a byte cannot be what it stands for.
class FalconReader {
public:
    /// A report that this byte completes.
    std::optional<FalconReport> take(std::byte byte);
    void forget() { filled_ = 0; }  ///< of a report that has begun
    std::int64_t damaged() const { return damaged_; }

private:
    FalconPacket packet_{};
    std::size_t filled_ = 0;
    std::int64_t damaged_ = 0;
};

}  // namespace touchable
