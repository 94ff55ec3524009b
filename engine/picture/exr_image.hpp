#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

bool is_exr(std::string_view begin);

/// One channel: of the first part that has one Z or depth, else Y or R, or the only one (ExrLayers). R stands
/// for all three colours where they are the same. What the display window has beyond the data window is NaN,
/// of integers 0.
Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where);
/// The same with what is wanted beside it, as far as the file has it (StoredImage::beside), unpacked once.
Result<StoredImage> decode_exr(std::string_view bytes, const std::string& where,
                               const BesideDepth::Wanted& wanted);

/// Colour alone: linear light of R, G and B as sRGB of 8 bits, at exposure 1, without alpha; black beyond the
/// data window.
Result<StoredImage> decode_exr_colour(std::string_view bytes, const std::string& where);
/// Material indices alone, as numbers.
Result<StoredImage> decode_exr_materials(std::string_view bytes, const std::string& where);

}  // namespace touchable
