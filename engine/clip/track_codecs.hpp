// SPDX-License-Identifier: Apache-2.0
#pragma once

// The codecs under TrackEncoder and TrackDecoder: one of our own, and FFmpeg's as our clips set them.

#include <zstd.h>

#include <cstdint>
#include <memory>
#include <span>

#include "engine/base/result.hpp"
#include "engine/clip/tracks.hpp"
#include "engine/picture/ffmpeg.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// The version of our own codec (docs/codecs.md), 1 or 2, in a track; nullopt for another codec.
std::optional<int> rank_zstd_version(const AVCodecParameters& stored);
/// Refuses tracks of a codec that is not read. FFmpeg knows hundreds, most of them seldom used, and seldom
/// tested for security.
Result<void> check_is_read(const AVCodecParameters& stored, const std::string& where);

/// Whether the coding is lossy, good enough to look at.
constexpr bool is_visual(TrackCoding coding) {
    return coding == TrackCoding::h264_visual || coding == TrackCoding::h264_reduced;
}
/// Whether FFmpeg has x264, which is under the GPL: without it colour is H.264 by OpenH264, and other planes,
/// or colour of odd sizes, are FFV1.
bool has_x264();
/// An encoder for pictures of `width` x `height` samples in an FFmpeg pixel format. An error of kind usage if
/// the coding does not support that size.
Result<CodecPtr> open_encoder(TrackCoding coding, AVPixelFormat format, int width, int height,
                              const FrameRate& rate);

/// A scaler from RGB of one size to an encoder's pictures of another, in BT.709 and narrow range; null if
/// unsupported. `flags`: swscale's.
ScalerPtr scaler_from_rgb(int from_width, int from_height, AVPixelFormat format, int width, int height,
                          int flags);

/// The error for pictures of a size that cannot be stored.
Error unstorable_size(int width, int height, const std::string& why);

/// Whether a track of H.264 or HEVC keeps every value: its own parameters allow transform bypass, which
/// encoders ask for only in lossless coding. False if they do not state it.
bool is_coded_without_loss(const AVCodecParameters& stored);

/// The FourCC of our own codec in containers: FFmpeg has no number for it.
inline constexpr std::uint32_t rank_zstd_tag = MKTAG('T', '3', 'D', '2');

/// Compresses a RankEncoder's content by zstd, in one frame that states its size. A packet of the codec's
/// first version is the frame of mode 0, with no head before it.
RankEncoder::Compress zstd_at(int level);

class RankZstdDecoder {
public:
    enum class Version { first = 1, second = 2 };
    explicit RankZstdDecoder(Version version) : version_(version) {}

    /// Whether a packet states that it holds a picture of this many samples. Costs nothing.
    bool promises(std::span<const std::uint8_t> packet, std::size_t samples) const;
    /// Decodes a packet into rows of `width` samples, `stride` samples apart. False if it does not hold such
    /// a picture (any bytes are safe), or memory runs out; the samples are then undefined.
    bool decode(std::span<const std::uint8_t> packet, int width, int height, std::uint16_t* samples,
                std::ptrdiff_t stride);

private:
    Version version_;
    std::unique_ptr<ZSTD_DCtx, ReleasedBy<ZSTD_freeDCtx>> context_;
    std::vector<std::uint8_t> bytes_;
};

}  // namespace touchable
