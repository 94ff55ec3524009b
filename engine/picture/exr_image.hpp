#pragma once

#include <string>
#include <string_view>

#include "engine/picture/stored_image.hpp"
#include "engine/result.hpp"

namespace touchable {

bool is_exr(std::string_view begin);

/// One channel of the first part that has one: Z, depth, Y or R, or the only one. R stands for all three
/// colours where they are the same. What the display window has beyond the data window is NaN, of integers 0.
Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where);

}  // namespace touchable
