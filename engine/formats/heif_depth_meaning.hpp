#pragma once

#include <libheif/heif.h>

#include <string>

#include "engine/formats/depth_photo.hpp"

namespace touchable {

/// What a HEIF file's depth stands for, into `photo`'s coding, camera (of pictures as stored) and notes.
/// `depth` of the photo is there. `info` of the codec's: may be null. `xmp` of the depth picture, where Apple
/// writes range and camera: may be empty, or of anything.
void describe_heif_depth(const heif_depth_representation_info* info, const std::string& xmp,
                         DepthPhoto& photo);

}  // namespace touchable
