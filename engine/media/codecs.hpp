#pragma once

#include <optional>
#include <string>

#include "engine/media/ffmpeg.hpp"
#include "engine/media/plane_role.hpp"

namespace touchable {

/// Whether tracks of this codec are read. FFmpeg knows hundreds, most of them seldom used and seldom attacked
/// by anyone who would say so.
bool is_read(AVCodecID codec);
/// "ffv1, png, ...": those that are.
std::string codecs_that_are_read();

/// What a person should know where a plane of touch was stored by a codec (FFmpeg's name) that changes
/// values.
std::optional<std::string> lossy_note(PlaneRole role, const std::string& codec);

}  // namespace touchable
