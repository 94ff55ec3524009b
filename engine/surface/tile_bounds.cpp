#include "engine/surface/tile_bounds.hpp"

#include <algorithm>

#include "engine/surface/validity_strip.hpp"

namespace touchable {
namespace {

bool any_bit(const std::vector<std::uint32_t>& words, int first, int last) {
    for (int w = first / strip_pixels; w <= last / strip_pixels; ++w) {
        std::uint32_t bits = words[static_cast<std::size_t>(w)];
        if (w == first / strip_pixels) bits &= ~std::uint32_t{0} << (first % strip_pixels);
        bits &= inside_bits(last + 1, w);
        if (bits != 0) return true;
    }
    return false;
}

}  // namespace

// An invalid pixel's code is 0, which cannot raise a greatest code; for the least one it counts as 65535.
void TileBounder::gather_rows(const SurfaceFrame& frame, int first, int last) {
    const int words = frame.validity_words_per_row();
    const auto columns = static_cast<std::size_t>(words * strip_pixels);
    least_.assign(columns, 65535);
    greatest_.assign(columns, 0);
    holes_.assign(static_cast<std::size_t>(words), 0);
    for (int y = first; y <= last; ++y) {
        const std::uint16_t* row = frame.codes.data() + frame.index(0, y);
        const std::uint32_t* validity = frame.validity.data() + static_cast<std::ptrdiff_t>(y) * words;
        for (int w = 0; w < words; ++w) {
            const int x = w * strip_pixels, count = std::min(strip_pixels, frame.width - x);
            const std::uint32_t holes = ~validity[w] & inside_bits(frame.width, w);
            const std::uint16_t* codes = row + x;
            std::uint16_t* least = least_.data() + x;
            std::uint16_t* greatest = greatest_.data() + x;
            holes_[static_cast<std::size_t>(w)] |= holes;
            for (int k = 0; k < count; ++k) greatest[k] = std::max(greatest[k], codes[k]);
            if (holes == 0) {
                for (int k = 0; k < count; ++k) least[k] = std::min(least[k], codes[k]);
            } else {
                std::uint16_t masks[strip_pixels];
                masks_of_bits(holes, masks);
                for (int k = 0; k < count; ++k)
                    least[k] = std::min(least[k], static_cast<std::uint16_t>(codes[k] | masks[k]));
            }
        }
    }
}

void TileBounder::bound(SurfaceFrame& frame) {
    const TileGrid grid = TileGrid::of(frame.width, frame.height);
    frame.tiles.resize(static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y));
    TileBounds* tile = frame.tiles.data();
    for (int ty = 0; ty < grid.tiles_y; ++ty) {
        const int top = ty * TileGrid::cells;
        gather_rows(frame, top, std::min(top + TileGrid::cells, frame.height - 1));
        for (int tx = 0; tx < grid.tiles_x; ++tx, ++tile) {
            const int left = tx * TileGrid::cells, right = std::min(left + TileGrid::cells, frame.width - 1);
            tile->least = *std::min_element(least_.begin() + left, least_.begin() + right + 1);
            tile->greatest = *std::max_element(greatest_.begin() + left, greatest_.begin() + right + 1);
            tile->any_invalid = any_bit(holes_, left, right);
        }
    }
}

}  // namespace touchable
