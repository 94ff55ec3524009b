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

/// Whether tracks of this codec are read. FFmpeg knows hundreds, most of them seldom used, and seldom tested
/// for security.
bool is_read(const AVCodecParameters& stored);
/// The codecs that are read: "ffv1, png, ...".
std::string codecs_that_are_read();

/// Whether the coding is lossy, good enough to look at.
constexpr bool is_visual(TrackCoding coding) {
    return coding == TrackCoding::h264_visual || coding == TrackCoding::h264_reduced;
}
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

// A lossless coding of grey pictures of two bytes a sample, each on its own. A packet of the second version:
//
//   byte 0     its mode: 0 samples by gradient, 1 ranks by left, 2 ranks by gradient
//   bytes 1-2  only of ranks: how many distinct values the picture has, less 1; the low byte first
//   the rest   one frame of zstd that states its size, of
//                only of ranks: the distinct values from the smallest up, of each how much it is beyond the
//                next possible one (of the first: beyond 0), as bytes: first all low ones, then all high ones
//                of each sample a code, row after row, as bytes: all low ones, then all high ones
//
// A code is made of a value: of the sample itself, or of its rank, which is its place among the distinct
// values, from 0. The value is predicted, either by the one to its left, which before the first of a row is
// the one above, or by the gradient of its neighbours, left + above - above left. Those outside the picture
// are 0. The difference d from what is predicted, modulo 65536 within -32768..32767, becomes the code 2d, or
// -2d - 1 where it is negative.
//
// A camera that measures in millimetres has few distinct values in a picture, fewer with distance; so do
// values stretched to more bits. A packet of the first version is the frame of mode 0, with nothing before
// it.

/// The modes of the second version, by their numbers.
enum class RankZstdMode : std::uint8_t { samples_by_gradient, ranks_by_left, ranks_by_gradient };

/// Encodes the second version, at a level of zstd.
class RankZstdEncoder {
public:
    static constexpr int quick = 1, thrifty = 19;
    explicit RankZstdEncoder(int level = quick) : level_(level) {}

    /// The packet of a picture, valid until the next call; empty if memory runs out. With `choose` every mode
    /// is tried and the smallest packet taken, one of ranks, which takes longer to decode, only if it saves a
    /// 64th. Otherwise the last choice stands, unless packets have grown by a 16th since.
    std::span<const std::uint8_t> encode(const PlaneView& plane, bool choose);

private:
    struct Packet {
        std::vector<std::uint8_t> memory;
        std::size_t size = 0;
    };
    void take_samples(const PlaneView& plane);
    void find_ranks();
    bool pack(RankZstdMode mode);

    int level_;
    std::unique_ptr<ZSTD_CCtx, ReleasedBy<ZSTD_freeCCtx>> context_;
    int width_ = 0;
    std::vector<std::uint16_t> samples_, distinct_, ranks_;
    std::vector<std::uint16_t> rank_of_;  // by sample
    std::vector<std::uint8_t> bytes_;     // to be compressed
    Packet newest_, chosen_;
    std::optional<RankZstdMode> mode_;  // chosen when packets had `size_then_` bytes
    std::size_t size_then_ = 0;
};

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
    std::vector<std::uint16_t> distinct_;
};

}  // namespace touchable
