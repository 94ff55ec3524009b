#include <zstd.h>

#include "engine/clip/track_codecs.hpp"

namespace touchable {
namespace {

/// The head, if the packet states that it holds this many samples.
std::optional<RankHead> head_of(std::span<const std::uint8_t> packet, RankZstdDecoder::Version version,
                                std::size_t samples) {
    const auto head =
        version == RankZstdDecoder::Version::second ? rank_head(packet, samples) : std::optional(RankHead{});
    if (!head) return std::nullopt;
    const auto frame = packet.subspan(head->bytes);
    const bool is_so = ZSTD_getFrameContentSize(frame.data(), frame.size()) == head->content(samples);
    return is_so ? head : std::nullopt;
}

}  // namespace

std::size_t RankZstdEncoder::compressed(std::span<const std::uint8_t> from, std::span<std::uint8_t> to,
                                        int level) {
    if (!context_) context_.reset(ZSTD_createCCtx());
    if (!context_) return 0;
    const std::size_t size =
        ZSTD_compressCCtx(context_.get(), to.data(), to.size(), from.data(), from.size(), level);
    return ZSTD_isError(size) ? 0 : size;
}

bool RankZstdDecoder::promises(std::span<const std::uint8_t> packet, std::size_t samples) const {
    return head_of(packet, version_, samples).has_value();
}

bool RankZstdDecoder::decode(std::span<const std::uint8_t> packet, int width, int height,
                             std::uint16_t* samples, std::ptrdiff_t stride) {
    const std::size_t count = pixel_count(width, height);
    const auto head = head_of(packet, version_, count);
    if (!head) return false;
    if (!context_) context_.reset(ZSTD_createDCtx());
    if (!context_) return false;
    bytes_.resize(head->content(count));
    const auto frame = packet.subspan(head->bytes);
    return ZSTD_decompressDCtx(context_.get(), bytes_.data(), bytes_.size(), frame.data(), frame.size()) ==
               bytes_.size() &&
           take_rank_content(*head, bytes_, width, height, samples, stride);
}

}  // namespace touchable
