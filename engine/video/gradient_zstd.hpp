#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "engine/frame/plane_view.hpp"

struct ZSTD_CCtx_s;
struct ZSTD_DCtx_s;

namespace touchable {

// A lossless coding of grey pictures of two bytes a sample, each on its own (docs/codecs.md). A sample is
// predicted by the gradient of its neighbours, left + above - above left, where those outside the picture
// are 0. What it differs by, modulo 65536 and with the sign in the lowest bit, is stored as bytes, first the
// low ones of all samples, then the high ones, compressed into one frame of zstd.

struct ZstdDeleter {
    void operator()(ZSTD_CCtx_s* context) const;
    void operator()(ZSTD_DCtx_s* context) const;
};

class GradientZstdEncoder {
public:
    /// The packet of a picture; until the next call. Empty where memory runs out.
    std::span<const std::uint8_t> encode(const PlaneView& plane);

private:
    std::unique_ptr<ZSTD_CCtx_s, ZstdDeleter> context_;
    std::vector<std::uint8_t> bytes_, packet_;
};

class GradientZstdDecoder {
public:
    /// Whether a packet says of itself that it holds a picture of so many samples. Costs nothing.
    static bool promises(std::span<const std::uint8_t> packet, std::size_t samples);
    /// Decodes a packet into rows of `width` samples, `stride` samples apart. False where it does not hold
    /// such a picture, whatever its bytes, or memory runs out.
    bool decode(std::span<const std::uint8_t> packet, int width, int height, std::uint16_t* samples,
                std::ptrdiff_t stride);

private:
    std::unique_ptr<ZSTD_DCtx_s, ZstdDeleter> context_;
    std::vector<std::uint8_t> bytes_;
};

}  // namespace touchable
