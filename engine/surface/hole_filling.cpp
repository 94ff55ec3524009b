#include "engine/surface/hole_filling.hpp"

#include <atomic>
#include <bit>

#include "engine/surface/lower_median.hpp"
#include "engine/surface/validity_strip.hpp"

namespace touchable {
namespace {

/// A picture's validity bits; rows and words outside it hold no valid pixel.
struct ValidityBits {
    const std::vector<std::uint32_t>& words;
    int words_per_row, height;

    std::uint32_t word(int w, int y) const {
        if (w < 0 || w >= words_per_row || y < 0 || y >= height) return 0;
        return words[static_cast<std::size_t>(y) * static_cast<std::size_t>(words_per_row) +
                     static_cast<std::size_t>(w)];
    }
    bool valid(int x, int y) const { return x >= 0 && (word(x >> 5, y) >> (x & 31)) & 1U; }
    /// The pixels of a word that have a valid one to their left or right, or are valid themselves.
    std::uint32_t spread(int w, int y) const {
        const std::uint32_t here = word(w, y);
        return here | here << 1 | here >> 1 | word(w - 1, y) >> 31 | word(w + 1, y) << 31;
    }
};

int valid_neighbours(const SurfaceFrame& frame, const ValidityBits& before, int x, int y,
                     std::uint16_t (&neighbours)[8]) {
    int count = 0;
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if ((dx != 0 || dy != 0) && before.valid(x + dx, y + dy))
                neighbours[count++] = frame.codes[frame.index(x + dx, y + dy)];
    return count;
}

}  // namespace

void HoleFiller::begin(const RawFrame& raw, RowBands& bands) {
    before_filling_.make_all(raw, bands, picture_);
    for (int pass = 0; pass < passes_; ++pass)
        if (!fill_once(bands)) return;  // nor would any later pass
}

bool HoleFiller::fill_once(RowBands& bands) {
    before_.assign(picture_.validity.begin(), picture_.validity.end());
    std::atomic<bool> filled_any = false;
    bands.for_each_band(picture_.height, TileGrid::cells, [&](const RowBand& band) {
        if (fill_rows(band)) filled_any.store(true, std::memory_order_relaxed);
    });
    return filled_any.load(std::memory_order_relaxed);
}

// Codes change in place: a pixel filled in this pass is not valid in `before_`, so nobody reads it yet.
bool HoleFiller::fill_rows(const RowBand& band) {
    const int words = picture_.validity_words_per_row();
    const ValidityBits before{before_, words, picture_.height};
    bool filled_any = false;
    for (int y = band.first; y < band.last; ++y)
        for (int w = 0; w < words; ++w) {
            std::uint32_t holes = ~before.word(w, y) & inside_bits(picture_.width, w);
            if (holes == 0) continue;
            holes &= before.spread(w, y - 1) | before.spread(w, y) | before.spread(w, y + 1);
            std::uint32_t filled = 0;
            for (; holes != 0; holes &= holes - 1) {
                const int bit = std::countr_zero(holes), x = w * strip_pixels + bit;
                std::uint16_t neighbours[8];
                const int count = valid_neighbours(picture_, before, x, y, neighbours);
                if (count < neighbours_to_fill) continue;
                picture_.codes[picture_.index(x, y)] = lower_median(neighbours, count);
                filled |= std::uint32_t{1} << bit;
            }
            picture_.validity_row(y)[w] |= filled;
            filled_any |= filled != 0;
        }
    return filled_any;
}

}  // namespace touchable
