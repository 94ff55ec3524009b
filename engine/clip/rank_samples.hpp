#pragma once

// A lossless coding of grey pictures of two bytes a sample, each on its own, before it is compressed: by zstd
// in clips (track_codecs.hpp), by deflate in packed ones (packed_clip.cpp), which browsers inflate. A packet:
//
//   byte 0     its mode: 0 samples by gradient, 1 ranks by left, 2 ranks by gradient
//   bytes 1-2  only of ranks: how many distinct values the picture has, less 1; the low byte first
//   the rest   compressed content:
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
// values stretched to more bits.
//
// Threads: one at a time uses an encoder; the functions keep no state.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/result.hpp"
#include "engine/scene/frames.hpp"

namespace touchable {

/// The modes, by their numbers.
enum class RankMode : std::uint8_t { samples_by_gradient, ranks_by_left, ranks_by_gradient };

/// What stands in a packet before its compressed content.
struct RankHead {
    RankMode mode = RankMode::samples_by_gradient;
    std::size_t distinct = 0;  ///< distinct values; 0: the mode has none
    std::size_t bytes = 0;     ///< of this head

    /// Bytes of the content of a picture with so many samples.
    std::size_t content(std::size_t samples) const { return 2 * (distinct + samples); }
};
/// The head of a packet of a picture with so many samples; nullopt: it cannot be one.
std::optional<RankHead> rank_head(std::span<const std::uint8_t> packet, std::size_t samples);

/// Turns content, of the size that its head states, into rows of `width` samples, `stride` samples apart.
/// False if it holds no such picture (any bytes are safe); the samples are then undefined.
bool take_rank_content(const RankHead& head, std::span<const std::uint8_t> content, int width, int height,
                       std::uint16_t* samples, std::ptrdiff_t stride);

/// The same into the samples of a plane of this form, row by row; channels, whose pictures content has one
/// below the other, become interleaved.
bool take_rank_plane(const RankHead& head, std::span<const std::uint8_t> content, const PlaneView& form,
                     std::vector<std::uint8_t>& samples);

class RankEncoder : NonCopyable {
public:
    /// Compresses `from` into `to`, which has room, and returns its size; 0: memory ran out.
    using Compress =
        std::function<std::size_t(std::span<const std::uint8_t> from, std::span<std::uint8_t> to)>;
    explicit RankEncoder(Compress compress) : compress_(std::move(compress)) {}

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
    bool pack(RankMode mode);

    const Compress compress_;
    int width_ = 0;
    std::vector<std::uint16_t> samples_, distinct_, ranks_;
    std::vector<std::uint16_t> rank_of_;  // by sample
    std::vector<std::uint8_t> bytes_;     // to be compressed
    Packet newest_, chosen_;
    std::optional<RankMode> mode_;  // chosen when packets had `size_then_` bytes
    std::size_t size_then_ = 0;
};

}  // namespace touchable
