#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

/// PGM and PPM, binary (P5, P6) and text (P2, P3). Samples are as stored, however large the greatest may be.
Result<StoredImage> decode_netpbm(std::string_view bytes, const std::string& where);

/// PFM with one float a pixel ("Pf"), of either byte order. Its scale is not multiplied in.
Result<StoredImage> decode_pfm(std::string_view bytes, const std::string& where);

}  // namespace touchable
