#pragma once

#include <string>

#include "engine/base/result.hpp"
#include "engine/picture/image_file.hpp"

namespace touchable {

/// A PNG file's bytes: grey of 8 or 16 bits, or RGB of 8. Every value is kept.
Result<std::string> png_bytes(const PlaneView& image, PngEffort effort, PngColours colours = PngColours::rgb);

}  // namespace touchable
