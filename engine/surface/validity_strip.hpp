#pragma once

#include <cstdint>
#include <cstring>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

namespace touchable {

/// The fast path works in strips of 32 pixels of one row: the pixels of one validity word. Within a strip
/// validity is a mask of 16 bits per pixel (all ones or none), as wide as a code, so that loops over both
/// vectorise.
inline constexpr int strip_pixels = 32;

/// The bits of word `word` that lie inside a row of `width` pixels.
inline std::uint32_t inside_bits(int width, int word) {
    const int left = width - word * strip_pixels;
    return left >= strip_pixels ? ~std::uint32_t{0} : (std::uint32_t{1} << left) - 1;
}

inline std::uint32_t bits_of_masks(const std::uint16_t* masks) {
#ifdef __SSE2__
    __m128i values[4];
    std::memcpy(values, masks, sizeof(values));
    const auto low = static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(values[0], values[1])));
    const auto high = static_cast<std::uint32_t>(_mm_movemask_epi8(_mm_packs_epi16(values[2], values[3])));
    return low | high << 16;
#else
    static constexpr std::uint16_t bit[16] = {1,      2,      4,      8,      0x10,   0x20,   0x40,   0x80,
                                              0x0100, 0x0200, 0x0400, 0x0800, 0x1000, 0x2000, 0x4000, 0x8000};
    std::uint16_t low = 0, high = 0;
    for (int k = 0; k < 16; ++k) low = static_cast<std::uint16_t>(low | (masks[k] & bit[k]));
    for (int k = 0; k < 16; ++k) high = static_cast<std::uint16_t>(high | (masks[16 + k] & bit[k]));
    return low | std::uint32_t{high} << 16;
#endif
}

inline void masks_of_bits(std::uint32_t bits, std::uint16_t* masks) {
    static constexpr std::uint16_t bit[16] = {1,      2,      4,      8,      0x10,   0x20,   0x40,   0x80,
                                              0x0100, 0x0200, 0x0400, 0x0800, 0x1000, 0x2000, 0x4000, 0x8000};
    const auto low = static_cast<std::uint16_t>(bits), high = static_cast<std::uint16_t>(bits >> 16);
    for (int k = 0; k < 16; ++k) masks[k] = (low & bit[k]) ? 0xFFFF : 0;
    for (int k = 0; k < 16; ++k) masks[16 + k] = (high & bit[k]) ? 0xFFFF : 0;
}

}  // namespace touchable
