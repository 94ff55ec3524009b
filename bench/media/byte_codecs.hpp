#pragma once

#include <memory>

#include "bench/media/plane_codec.hpp"

namespace touchable {

/// The rows one behind the other: what the least that any codec can do costs.
std::unique_ptr<PlaneCodec> make_raw_codec(const PlaneView& form);

/// RVL of one channel (A. D. Wilson, Fast Lossless Depth Image Compression, ISS 2017): runs of zeros and of
/// others in turn, of these the differences from the one before, all as groups of 3 bits.
std::unique_ptr<PlaneCodec> make_rvl_codec(const PlaneView& form);

/// The rows one behind the other, compressed by zstd at its level 1.
std::unique_ptr<PlaneCodec> make_plain_zstd_codec(const PlaneView& form);

/// Of each sample the difference from the one to its left, signs in the lowest bit, bytes of the same weight
/// and channel together, compressed by zstd at its level 1.
std::unique_ptr<PlaneCodec> make_zstd_codec(const PlaneView& form);
/// The same of what is left of a sample less the one above it: left + above - above left is predicted. Of
/// two bytes a sample it is what the codec of clips was first (t3dz).
std::unique_ptr<PlaneCodec> make_zstd_gradient_codec(const PlaneView& form);
/// The codec of clips (engine/clip/track_codecs.hpp): of two bytes a sample.
std::unique_ptr<PlaneCodec> make_rank_zstd_codec(const PlaneView& form);

}  // namespace touchable
