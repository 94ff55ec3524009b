#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace touchable {

/// The colour that stands for a material of the palette, RGB; grey for any other name.
std::array<std::uint8_t, 3> material_colour(std::string_view name);

}  // namespace touchable
