#pragma once

#include <cstdint>

#include "engine/media/ffmpeg.hpp"
#include "engine/media/plane_role.hpp"
#include "engine/result.hpp"

namespace touchable {

/// Encodes one track of a clip without loss: FFV1, every frame on its own, every slice with a checksum.
class TrackEncoder {
public:
    /// `first`: a plane as all will be (size, sample size).
    static Result<TrackEncoder> open(PlaneRole role, const PlaneView& first, const Scene& scene);

    PlaneRole role() const { return role_; }
    const AVCodecContext& codec() const { return *codec_; }
    /// The packet of a plane like the first; without a time.
    Result<PacketPtr> encode(const PlaneView& plane);

private:
    TrackEncoder() = default;

    PlaneRole role_ = PlaneRole::depth;
    CodecPtr codec_;
    FramePtr frame_;
};

}  // namespace touchable
