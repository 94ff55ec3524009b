// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <libheif/heif.h>

#include <string>

#include "engine/picture/image.hpp"

namespace touchable::test {

/// Depth representation of the codec, as phones state it; NaN: not stated.
struct DepthInfo {
    int type = 0;  ///< as libheif counts them
    double z_near, z_far, d_min, d_max;
};

/// A HEIC file as phones write portraits: libheif writes two pictures, lossless, and then one is made the
/// depth of the other in the file's boxes, which libheif's encoder cannot.
struct HeicFile {
    Image colour, depth;
    int depth_bits = 8;
    heif_orientation colour_turn = heif_orientation_normal, depth_turn = heif_orientation_normal;
    std::string depth_sei;  ///< of depth_info_sei; empty: none
    std::string depth_xmp;  ///< empty: none
    std::string exif;       ///< TIFF; empty: none
    bool has_depth = true;
    int tile_side = 0;  ///< of the square tiles of which colour is put together, as phones do; 0: none
    heif_compression_format format = heif_compression_HEVC;
    std::string bytes() const;
};

/// H.265's depth representation information, as auxC holds it.
std::string depth_info_sei(const DepthInfo& info);

}  // namespace touchable::test
