#pragma once

#include <cstdint>
#include <optional>

#include "engine/base/result.hpp"
#include "engine/clip/picture_label.hpp"
#include "engine/picture/ffmpeg.hpp"

namespace touchable {

/// What a clip says of each stored picture, in its block's BlockAdditions (docs/codecs.md): for how many
/// frames the picture stays, and a checksum, since not every codec has one of its own.
struct BlockAddition {
    std::int64_t frames = 1;  ///< from 1 to the distance of access points
    bool sound =
        true;  ///< the checksum is that of the packet, of `frames`, which are so many, and of the label
    std::optional<PictureLabel> label{};  ///< in a stream (docs/streaming.md)
};

/// Adds it to a packet on its way into a Matroska file. An error where memory runs out.
Result<void> add_block_addition(AVPacket& packet, AVCodecID codec, std::int64_t frames,
                                const std::optional<PictureLabel>& label = {});
/// That of a packet; nothing where it has none.
std::optional<BlockAddition> block_addition_of(const AVPacket& packet);

}  // namespace touchable
