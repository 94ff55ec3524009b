#include "engine/surface/tile_bounds.hpp"

#include <algorithm>
#include <cstring>

#include "engine/surface/median_network.hpp"
#include "engine/surface/validity_strip.hpp"
#include "engine/surface/vectors.hpp"

namespace touchable {
namespace {

/// Rows [first, last] of a frame.
struct Rows {
    const SurfaceFrame& frame;
    int first, last;
};

/// Least and greatest valid code of each column of strip `w`, and which columns have an invalid pixel. An
/// invalid pixel's code is 0, which cannot raise a greatest code; for the least one it counts as 65535.
template <class Lanes>
[[gnu::always_inline]] inline std::uint32_t bound_strip(const Rows& rows, int w, std::uint16_t* least,
                                                        std::uint16_t* greatest) {
    constexpr int lanes = lane_count<Lanes>, vectors = strip_pixels / lanes;
    const SurfaceFrame& frame = rows.frame;
    const int x = w * strip_pixels, count = std::min(strip_pixels, frame.width - x);
    const std::uint32_t inside = inside_bits(frame.width, w);
    const std::uint32_t* validity = frame.validity.data() + w;
    std::uint16_t padded[strip_pixels] = {}, masks[strip_pixels];
    Lanes low[vectors], high[vectors] = {};
    for (Lanes& values : low) values = ~Lanes{};
    std::uint32_t all_holes = 0;
    for (int y = rows.first; y <= rows.last; ++y) {
        const std::uint16_t* codes = frame.codes.data() + frame.index(x, y);
        if (count < strip_pixels)
            codes = static_cast<std::uint16_t*>(
                std::memcpy(padded, codes, static_cast<std::size_t>(count) * sizeof(std::uint16_t)));
        const std::uint32_t holes = ~validity[std::ptrdiff_t{y} * frame.validity_words_per_row()] & inside;
        all_holes |= holes;
        if (holes != 0) masks_of_bits(holes, masks);
        for (int k = 0; k < vectors; ++k) {
            Lanes values = load_lanes<Lanes>(codes + k * lanes);
            high[k] = greater(high[k], values);
            if (holes != 0) values |= load_lanes<Lanes>(masks + k * lanes);
            low[k] = lesser(low[k], values);
        }
    }
    for (int k = 0; k < vectors; ++k) {
        store_lanes(low[k], least + x + k * lanes);
        store_lanes(high[k], greatest + x + k * lanes);
    }
    return all_holes;
}

/// Each value becomes the lesser (or greater) of itself and the one `step` further on.
template <class Lanes>
[[gnu::always_inline]] inline void fold(int step, int strips, std::uint16_t* least, std::uint16_t* greatest) {
    for (int x = 0; x < strips * strip_pixels; x += lane_count<Lanes>) {
        store_lanes(lesser(load_lanes<Lanes>(least + x), load_lanes<Lanes>(least + x + step)), least + x);
        store_lanes(greater(load_lanes<Lanes>(greatest + x), load_lanes<Lanes>(greatest + x + step)),
                    greatest + x);
    }
}

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

void TileBounder::Columns::resize(int strips) {
    const auto pixels = static_cast<std::size_t>((strips + 1) * strip_pixels);
    least.resize(pixels);
    greatest.resize(pixels);
    holes.resize(static_cast<std::size_t>(strips));
}

// Afterwards `least` and `greatest` of a column are those of a tile that begins there.
void TileBounder::bound_columns(const SurfaceFrame& frame, int first, int last, Columns& columns) const {
    const int strips = frame.validity_words_per_row();
    std::uint16_t *least = columns.least.data(), *greatest = columns.greatest.data();
    run_vectors(
        unit_, [&](auto kind) __attribute__((always_inline)) {
            using Lanes = typename decltype(kind)::Lanes;
            for (int w = 0; w < strips; ++w)
                columns.holes[static_cast<std::size_t>(w)] =
                    bound_strip<Lanes>({frame, first, last}, w, least, greatest);
            std::fill(least + frame.width, least + columns.least.size(), std::uint16_t{65535});
            std::fill(greatest + frame.width, greatest + columns.greatest.size(), std::uint16_t{0});
            for (int step = 1; step < TileGrid::cells; step *= 2) fold<Lanes>(step, strips, least, greatest);
            fold<Lanes>(1, strips, least, greatest);
        });
}

void TileBounder::bound(RowBands& bands, SurfaceFrame& frame) {
    const TileGrid grid = TileGrid::of(frame.width, frame.height);
    frame.tiles.resize(static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y));
    columns_.resize(static_cast<std::size_t>(bands.threads()));
    for (Columns& columns : columns_) columns.resize(frame.validity_words_per_row());
    bands.for_each_band(grid.tiles_y, 1, [&](const RowBand& band) {
        Columns& columns = columns_[static_cast<std::size_t>(band.thread)];
        for (int ty = band.first; ty < band.last; ++ty) {
            const int top = ty * TileGrid::cells;
            bound_columns(frame, top, std::min(top + TileGrid::cells, frame.height - 1), columns);
            TileBounds* tile = frame.tiles.data() + std::ptrdiff_t{ty} * grid.tiles_x;
            for (int tx = 0; tx < grid.tiles_x; ++tx, ++tile) {
                const int left = tx * TileGrid::cells,
                          right = std::min(left + TileGrid::cells, frame.width - 1);
                tile->least = columns.least[static_cast<std::size_t>(left)];
                tile->greatest = columns.greatest[static_cast<std::size_t>(left)];
                tile->any_invalid = any_bit(columns.holes, left, right);
            }
        }
    });
}

}  // namespace touchable
