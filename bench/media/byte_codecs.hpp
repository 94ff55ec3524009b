#pragma once

#include <memory>

#include "bench/media/plane_codec.hpp"

namespace touchable {

/// Concatenated rows: the least work of any codec.
std::unique_ptr<PlaneCodec> make_raw_codec(const PlaneView& form);

/// RVL of one channel (A. D. Wilson, Fast Lossless Depth Image Compression, ISS 2017): alternating runs of
/// zeros and of other values; the latter as differences from the previous value, all in groups of 3 bits.
std::unique_ptr<PlaneCodec> make_rvl_codec(const PlaneView& form);

/// Concatenated rows, compressed by zstd at level 1.
std::unique_ptr<PlaneCodec> make_plain_zstd_codec(const PlaneView& form);

/// Each sample's difference from its left neighbour, sign in the lowest bit, bytes of equal weight and
/// channel grouped, compressed by zstd at level 1.
std::unique_ptr<PlaneCodec> make_zstd_codec(const PlaneView& form);
/// The same with the gradient predictor left + above - above left. For two-byte samples this was the first
/// codec of clips (t3dz).
std::unique_ptr<PlaneCodec> make_zstd_gradient_codec(const PlaneView& form);
/// The codec of clips (engine/clip/track_codecs.hpp), for two-byte samples.
std::unique_ptr<PlaneCodec> make_rank_zstd_codec(const PlaneView& form);

}  // namespace touchable
