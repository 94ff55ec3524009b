#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/clip/plane_role.hpp"
#include "engine/ffmpeg/ffmpeg.hpp"

namespace touchable {

/// How a container names the codec that is our own (gradient_zstd.hpp): FFmpeg has no number for it.
inline constexpr std::uint32_t gradient_zstd_tag = MKTAG('T', '3', 'D', 'Z');
bool is_gradient_zstd(const AVCodecParameters& stored);

/// FFmpeg's name of a codec, or "t3dz".
std::string codec_name(const AVCodecParameters& stored);
/// Whether tracks of this codec are read. FFmpeg knows hundreds, most of them seldom used and seldom attacked
/// by anyone who would say so.
bool is_read(const AVCodecParameters& stored);
/// "ffv1, png, ...": those that are.
std::string codecs_that_are_read();

/// What a person should know where a plane of touch was stored by a codec (its `codec_name`) that changes
/// values.
std::optional<std::string> lossy_note(PlaneRole role, const std::string& codec);

}  // namespace touchable
