#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

bool is_tiff(std::string_view begin);

/// The first page: grey of integers or floats of 8 to 64 bits, colour of 8 (of 16 where it is grey). Other
/// samples of a pixel, such as alpha, are dropped.
Result<StoredImage> decode_tiff(std::string_view bytes, const std::string& where);

}  // namespace touchable
