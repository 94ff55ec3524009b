#pragma once

#include <string>
#include <string_view>

#include "engine/base/result.hpp"
#include "engine/formats/ros_messages.hpp"
#include "engine/picture/stored_image.hpp"

namespace touchable {

/// What a message of pictures holds, as its encoding says.
enum class RosPictureKind { none, grey8, depth16, depth_floats, colour };
RosPictureKind ros_picture_kind(std::string_view encoding);
/// Of compressed pictures by their format ("16UC1; compressedDepth", "rgb8; jpeg compressed bgr8", "png");
/// what is depth, the name of a topic tells where the format does not.
RosPictureKind ros_compressed_kind(std::string_view format);

/// Grey of 8 or 16 bits, floats, or RGB of 8 bits: bytes in host order, without padding. Messages begin with
/// `where`.
Result<StoredImage> ros_picture(const RosImage& image, const std::string& where);
/// PNG and JPEG; depth that `compressed_depth_image_transport` packed as PNG or RVL, floats in metres.
Result<StoredImage> ros_picture(const RosCompressedImage& image, const std::string& where);

}  // namespace touchable
