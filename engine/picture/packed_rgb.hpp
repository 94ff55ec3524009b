#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "engine/base/vector_unit.hpp"

// Packed RGB: 8 bits, three bytes a pixel, made by the CPU's vectors.

namespace touchable {

/// A row whose red, green and blue lie apart, as H.264 has them.
void join_channels(VectorUnit unit, const std::array<const std::uint8_t*, 3>& channels, int width,
                   std::uint8_t* rgb);

/// A row of four bytes a pixel; `places`: which of them are red, green and blue, from 0.
void take_channels(VectorUnit unit, const std::uint8_t* pixels, const std::array<int, 3>& places, int width,
                   std::uint8_t* rgb);

/// What YUV of 8 bits counts for in red, green and blue, in 8192ths.
struct YuvFactors {
    int black = 0;  ///< the y of black
    int y = 0, red_of_v = 0, green_of_u = 0, green_of_v = 0, blue_of_u = 0;
};
/// Of a table as swscale has it for each colour space: in 65536ths, v in red, u in blue, u and v taken from
/// green, where y goes from 16 to 235. `full`: it goes from 0 to 255.
YuvFactors yuv_factors(const int* table, bool full);

/// Whose u and v have a sample for each four pixels.
struct Yuv420Picture {
    std::array<const std::uint8_t*, 3> planes{};  ///< y, u, v
    std::array<std::ptrdiff_t, 3> strides{};      ///< bytes from one row to the next
    int width = 0, height = 0;
};
/// Pictures of other sizes swscale enlarges by other filters.
constexpr bool is_converted(int width, int height) {
    return width % 2 == 0 && height % 2 == 0 && width >= 10 && height >= 10;
}
/// As RGB, the same bits as swscale's plain C for RGB24 with bilinear, accurate, bit-exact and full chroma:
/// they are in relief that recordings were made with. That takes its u and v from left to right between their
/// samples, but of every second row as they are. The picture's size is_converted.
void convert_yuv420(VectorUnit unit, const Yuv420Picture& picture, const YuvFactors& factors,
                    std::uint8_t* rgb, std::ptrdiff_t stride);

}  // namespace touchable
