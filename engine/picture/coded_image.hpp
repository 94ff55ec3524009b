#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

/// PNG and JPEG, by FFmpeg's decoders: grey of 2 to 16 bits, colour of 8. Colour of 16 bits only where it is
/// grey.
Result<StoredImage> decode_coded_image(std::string_view bytes, const std::string& where);

/// The indices of a PNG with a palette, whatever colours they stand for, or the values of a grey one, in 8
/// bits. Refused of others: a picture that counts something is not of colours.
Result<Image> decode_indices(std::string_view bytes, const std::string& where);

}  // namespace touchable
