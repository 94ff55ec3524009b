#pragma once

#include <cstdint>

namespace touchable {

/// Linear light, as renderers compute it, as a sample of an sRGB picture (IEC 61966-2-1): the nearest of 256;
/// 1 and beyond are 255, what is negative or no number is 0. The same bits everywhere.
std::uint8_t srgb_sample(float light);
/// The same of a float of 16 bits, by its bits.
std::uint8_t srgb_sample(std::uint16_t half);

}  // namespace touchable
