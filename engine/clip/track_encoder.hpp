#pragma once

#include <memory>
#include <span>
#include <string>

#include "engine/base/result.hpp"
#include "engine/clip/clip_reader.hpp"
#include "engine/clip/plane_role.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// How a track is encoded. All but the last two keep every sample (docs/codecs.md).
enum class TrackCoding {
    ffv1,          ///< every picture on its own: smallest where they are noisy, slow
    h264_quick,    ///< predicted from the picture before; quickest to encode and decode
    h264_thrifty,  ///< likewise, smaller
    rank_zstd,     ///< every picture on its own, by a codec of our own: grey of two bytes a sample only,
                   ///< quick whatever the pictures hold (rank_zstd.hpp)
    h264_visual,   ///< as good as the eye can tell; colour only
    h264_reduced,  ///< likewise, of about half the bytes
};

/// As pictures are seen, and not to the last bit.
constexpr bool is_visual(TrackCoding coding) {
    return coding == TrackCoding::h264_visual || coding == TrackCoding::h264_reduced;
}

/// Encodes one track of a clip, a packet for each picture.
class TrackEncoder {
public:
    /// `first`: a plane as all will be (size, sample size). An error of kind usage where this coding has no
    /// pictures of its size.
    static Result<std::unique_ptr<TrackEncoder>> open(PlaneRole role, TrackCoding coding,
                                                      const PlaneView& first, const Scene& scene);
    virtual ~TrackEncoder() = default;

    /// Says in a container how the track is encoded. An error where memory runs out.
    virtual Result<void> describe(AVCodecParameters& stored) const = 0;
    /// The packet of a plane like the first; without a time. Where `on_its_own`, decoding can begin with it.
    /// `messages`: what H.264 says in it beside the picture, each an unregistered SEI message (ISO/IEC
    /// 14496-10, D.1.7): a UUID of 16 bytes, and what follows it. No other coding has room for them.
    virtual Result<PacketPtr> encode(const PlaneView& plane, bool on_its_own,
                                     std::span<const std::string> messages = {}) = 0;
};

}  // namespace touchable
