#include "engine/video/gradient_zstd.hpp"

#include <zstd.h>

#include <cstring>

namespace touchable {
namespace {

std::size_t samples_of(int width, int height) {
    return static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
}

std::uint16_t sample_at(const std::uint8_t* row, int x) {
    std::uint16_t sample;
    std::memcpy(&sample, row + 2 * std::ptrdiff_t{x}, 2);
    return sample;
}

/// Small numbers of either sign become small ones: 0, -1, 1, -2, ...
std::uint16_t folded(std::uint16_t difference) {
    const bool negative = (difference & 0x8000) != 0;
    return static_cast<std::uint16_t>(difference << 1 ^ (negative ? 0xFFFF : 0));
}

std::uint32_t unfolded(std::uint32_t code) {
    return code >> 1 ^ (0U - (code & 1));  // its lower 16 bits count
}

}  // namespace

void ZstdDeleter::operator()(ZSTD_CCtx_s* context) const {
    ZSTD_freeCCtx(context);
}

void ZstdDeleter::operator()(ZSTD_DCtx_s* context) const {
    ZSTD_freeDCtx(context);
}

std::span<const std::uint8_t> GradientZstdEncoder::encode(const PlaneView& plane) {
    const std::size_t samples = samples_of(plane.width, plane.height);
    bytes_.resize(2 * samples);
    std::uint8_t *low = bytes_.data(), *high = low + samples;
    const std::vector<std::uint8_t> nothing(2 * static_cast<std::size_t>(plane.width));
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t *row = plane.row(y), *above = y > 0 ? plane.row(y - 1) : nothing.data();
        int left = 0;  // less the one above it
        for (int x = 0; x < plane.width; ++x) {
            const int step = sample_at(row, x) - sample_at(above, x);
            const std::uint16_t code = folded(static_cast<std::uint16_t>(step - left));
            *low++ = static_cast<std::uint8_t>(code);
            *high++ = static_cast<std::uint8_t>(code >> 8);
            left = step;
        }
    }
    if (!context_) context_.reset(ZSTD_createCCtx());
    if (!context_) return {};
    packet_.resize(ZSTD_compressBound(bytes_.size()));
    constexpr int level = 1;
    const std::size_t size = ZSTD_compressCCtx(context_.get(), packet_.data(), packet_.size(), bytes_.data(),
                                               bytes_.size(), level);
    if (ZSTD_isError(size)) return {};
    return std::span(packet_).first(size);
}

bool GradientZstdDecoder::promises(std::span<const std::uint8_t> packet, std::size_t samples) {
    return ZSTD_getFrameContentSize(packet.data(), packet.size()) == 2 * samples;
}

bool GradientZstdDecoder::decode(std::span<const std::uint8_t> packet, int width, int height,
                                 std::uint16_t* samples, std::ptrdiff_t stride) {
    const std::size_t count = samples_of(width, height);
    if (!promises(packet, count)) return false;
    if (!context_) context_.reset(ZSTD_createDCtx());
    if (!context_) return false;
    bytes_.resize(2 * count);
    if (ZSTD_decompressDCtx(context_.get(), bytes_.data(), bytes_.size(), packet.data(), packet.size()) !=
        bytes_.size())
        return false;
    const std::uint8_t *low = bytes_.data(), *high = low + count;
    const std::vector<std::uint16_t> nothing(static_cast<std::size_t>(width));
    const std::uint16_t* above = nothing.data();
    for (int y = 0; y < height; ++y, low += width, high += width, above = samples, samples += stride) {
        std::uint32_t left = 0;  // less the one above it
        for (int x = 0; x < width; ++x) {
            left += unfolded(low[x] | static_cast<std::uint32_t>(high[x]) << 8);
            samples[x] = static_cast<std::uint16_t>(left + above[x]);
        }
    }
    return true;
}

}  // namespace touchable
