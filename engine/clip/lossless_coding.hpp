#pragma once

#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// Whether a track of H.264 or HEVC keeps every value, as its own parameters say: its coding may leave out
/// the transform, for which encoders ask only where they are to be lossless. False where it does not say.
bool is_coded_without_loss(const AVCodecParameters& stored);

}  // namespace touchable
