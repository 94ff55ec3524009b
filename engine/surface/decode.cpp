#include "engine/surface/decode.hpp"

#include <algorithm>

#include "engine/frame/stored_code.hpp"
#include "engine/surface/validity_strip.hpp"

namespace touchable {
namespace {

/// The codes of `count` pixels, as `stored_code`; the rest of the strip is left alone.
void load_strip(const PlaneView& depth, const DepthCoding& coding, int x, int y, int count,
                std::uint16_t* stored) {
    if (coding.kind == DepthCodingKind::hue) {
        for (int k = 0; k < count; ++k) stored[k] = stored_code(depth, coding, x + k, y);
        return;
    }
    const std::uint8_t* from = depth.row(y) + static_cast<std::ptrdiff_t>(x) * depth.bytes_per_sample;
    if (depth.bytes_per_sample == 2) {
        std::memcpy(stored, from, static_cast<std::size_t>(count) * 2);
        return;
    }
    for (int k = 0; k < count; ++k) stored[k] = from[k];
}

/// All ones where DepthCoding::is_valid.
void valid_masks(const DepthCoding& coding, const std::uint16_t* stored, std::uint16_t* masks) {
    for (int k = 0; k < strip_pixels; ++k)
        masks[k] = stored[k] >= coding.valid_min && stored[k] <= coding.valid_max ? 0xFFFF : 0;
    for (int n = 0; n < coding.invalid_code_count; ++n) {
        const std::uint16_t invalid = coding.invalid_codes[static_cast<std::size_t>(n)];
        for (int k = 0; k < strip_pixels; ++k)
            masks[k] = static_cast<std::uint16_t>(masks[k] & (stored[k] != invalid ? 0xFFFF : 0));
    }
}

}  // namespace

void decode(const PlaneView& depth, SurfaceFrame& frame) {
    frame.width = depth.width;
    frame.height = depth.height;
    const int words = frame.validity_words_per_row();
    frame.codes.resize(frame.index(0, frame.height));
    frame.validity.resize(static_cast<std::size_t>(words) * static_cast<std::size_t>(frame.height));
    const DepthCoding coding = frame.coding;
    std::uint16_t stored[strip_pixels] = {}, masks[strip_pixels];
    for (int y = 0; y < frame.height; ++y) {
        std::uint16_t* codes = frame.codes.data() + frame.index(0, y);
        std::uint32_t* validity = frame.validity.data() + static_cast<std::ptrdiff_t>(y) * words;
        for (int word = 0; word < words; ++word) {
            const int x = word * strip_pixels, count = std::min(strip_pixels, frame.width - x);
            load_strip(depth, coding, x, y, count, stored);
            valid_masks(coding, stored, masks);
            validity[word] = bits_of_masks(masks) & inside_bits(frame.width, word);
            for (int k = 0; k < strip_pixels; ++k)
                stored[k] = static_cast<std::uint16_t>(stored[k] & masks[k]);
            std::memcpy(codes + x, stored, static_cast<std::size_t>(count) * 2);
        }
    }
}

}  // namespace touchable
