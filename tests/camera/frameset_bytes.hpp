#pragma once

#include <cstdint>
#include <string>

namespace touchable::test {

/// A frameset as docs/camera.md has it, written once more.
struct FramesetBytes {
    std::uint64_t number = 0;
    std::int64_t time_ns = 0;
    std::uint32_t version = 1, width = 8, height = 6;
    double unit = 0.001, fx = 7, fy = 7.5, cx = 3.5, cy = 2.5;
    std::uint32_t colour_width = 0, colour_height = 0, flags = 1;

    /// Depth at a pixel, mm; every frameset has another.
    std::uint16_t depth(std::uint32_t x, std::uint32_t y) const {
        return static_cast<std::uint16_t>(500 + 7 * number % 400 + 3 * x + y);
    }
    std::string payload() const;
    /// With the right checksums.
    std::string bytes() const;
};

/// Bit by bit, as the standard has it (IEEE 802.3).
std::uint32_t plain_crc32(const std::string& bytes);

}  // namespace touchable::test
