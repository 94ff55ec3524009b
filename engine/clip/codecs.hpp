#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "engine/clip/plane_role.hpp"
#include "engine/clip/rank_zstd.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// How a container names the codec that is our own: FFmpeg has no number for it.
inline constexpr std::uint32_t rank_zstd_tag = MKTAG('T', '3', 'D', '2');
/// Its version in a track; nothing where the codec is another.
std::optional<RankZstdDecoder::Version> rank_zstd_version(const AVCodecParameters& stored);

/// FFmpeg's name of a codec; of ours "t3dz" or "t3d2"; the FourCC of one that neither knows.
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
