#pragma once

#include "engine/base/result.hpp"
#include "engine/clip/track_encoder.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// An encoder for pictures of `width` x `height` samples in an FFmpeg pixel format. An error of kind usage
/// where it cannot have that size.
Result<CodecPtr> open_encoder(TrackCoding coding, AVPixelFormat format, int width, int height,
                              const FrameRate& rate);

/// Why pictures of this size cannot be stored.
Error unstorable_size(int width, int height, const std::string& why);

}  // namespace touchable
