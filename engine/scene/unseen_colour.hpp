#pragma once

#include <cstdint>

namespace touchable {

/// Red, green and blue of a pixel that the colour camera does not see, such as outside of its picture: it has
/// no colour of its own.
inline constexpr std::uint8_t unseen_colour = 128;

/// `rgb`: three samples.
inline bool is_unseen_colour(const std::uint8_t* rgb) {
    return rgb[0] == unseen_colour && rgb[1] == unseen_colour && rgb[2] == unseen_colour;
}

}  // namespace touchable
