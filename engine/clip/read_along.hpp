#pragma once

#include <memory>

#include "engine/clip/plane_role.hpp"
#include "engine/clip/track_decoder.hpp"
#include "engine/clip/track_encoder.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// What a track's readers will be given, while it is written: its packets, decoded.
class ReadAlong {
public:
    static Result<std::unique_ptr<ReadAlong>> open(const TrackEncoder& encoder, PlaneRole role);
    /// The next packet that the encoder gave.
    Result<void> add(const AVPacket& packet);
    /// The picture in it; empty before the first. Until the next one.
    PlaneView picture() const { return newest_.view; }

private:
    explicit ReadAlong(TrackDecoder decoder) : decoder_(std::move(decoder)) {}

    TrackDecoder decoder_;
    Plane newest_;
};

}  // namespace touchable
