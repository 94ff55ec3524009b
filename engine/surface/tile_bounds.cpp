#include "engine/surface/tile_bounds.hpp"

#include <algorithm>
#include <cstring>

#include "engine/surface/validity_strip.hpp"
#include "engine/surface/vectors.hpp"

namespace touchable {
namespace {

/// Rows [first, last] of a frame, and how an invalid pixel, whose code is 0, comes to count as 65535 for the
/// least code: all codes become one less, or, where 0 is a valid code too, by its validity bit.
struct Rows {
    const SurfaceFrame& frame;
    int first, last;
    std::uint16_t one_less;
    bool masked;
};

/// Least and greatest valid code of each of so many vectors of columns from `x` on, as far as the picture
/// goes.
template <bool Masked, class Lanes, int Vectors>
[[gnu::always_inline]] inline void bound_vectors(const Rows& rows, int x, std::uint16_t* least,
                                                 std::uint16_t* greatest) {
    constexpr int lanes = lane_count<Lanes>, pixels = Vectors * lanes;
    const SurfaceFrame& frame = rows.frame;
    static_assert(!Masked || pixels == strip_pixels);
    const int count = std::min(pixels, frame.width - x);
    std::uint16_t padded[pixels] = {}, masks[pixels];
    Lanes low[Vectors], high[Vectors] = {};
    for (Lanes& values : low) values = ~Lanes{};
    for (int y = rows.first; y <= rows.last; ++y) {
        const std::uint16_t* codes = frame.codes.data() + frame.index(x, y);
        if (count < pixels)
            codes = static_cast<std::uint16_t*>(
                std::memcpy(padded, codes, static_cast<std::size_t>(count) * sizeof(std::uint16_t)));
        if constexpr (Masked)
            masks_of_bits(~frame.validity[static_cast<std::size_t>(y * frame.validity_words_per_row() +
                                                                   x / strip_pixels)],
                          masks);
        for (int k = 0; k < Vectors; ++k) {
            Lanes values = load_lanes<Lanes>(codes + k * lanes);
            high[k] = greater(high[k], values);
            if constexpr (Masked) values |= load_lanes<Lanes>(masks + k * lanes);
            low[k] = lesser<Lanes>(low[k], values - rows.one_less);
        }
    }
    for (int k = 0; k < Vectors; ++k) {
        // One more again, but where nothing is valid.
        store_lanes<Lanes>(low[k] + lesser<Lanes>(~low[k], Lanes{} + rows.one_less), least + x + k * lanes);
        store_lanes(high[k], greatest + x + k * lanes);
    }
}

/// A few vectors at a time, for the sake of the loop over the rows; by strips where there are masks, and at
/// the end.
template <class Lanes>
[[gnu::always_inline]] inline void bound_columns(const Rows& rows, std::uint16_t* least,
                                                 std::uint16_t* greatest) {
    constexpr int lanes = lane_count<Lanes>, vectors = 4;
    constexpr int of_strip = strip_pixels / lanes;
    const int width = rows.frame.width;
    int x = 0;
    if (rows.masked)
        for (; x < width; x += strip_pixels) bound_vectors<true, Lanes, of_strip>(rows, x, least, greatest);
    for (; x + vectors * lanes <= width; x += vectors * lanes)
        bound_vectors<false, Lanes, vectors>(rows, x, least, greatest);
    for (; x < width; x += strip_pixels) bound_vectors<false, Lanes, of_strip>(rows, x, least, greatest);
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
void TileBounder::bound_columns_of(const SurfaceFrame& frame, int first, int last, Columns& columns) const {
    const int strips = frame.validity_words_per_row();
    std::fill(columns.holes.begin(), columns.holes.end(), 0U);
    for (int y = first; y <= last; ++y) {
        const std::uint32_t* validity = frame.validity.data() + std::ptrdiff_t{y} * strips;
        for (int w = 0; w < strips; ++w)
            columns.holes[static_cast<std::size_t>(w)] |= ~validity[w] & inside_bits(frame.width, w);
    }
    const bool holes =
        std::any_of(columns.holes.begin(), columns.holes.end(), [](auto bits) { return bits != 0; });
    const bool masked = holes && frame.coding.is_valid(0);
    const Rows rows{frame, first, last, static_cast<std::uint16_t>(holes && !masked ? 1 : 0), masked};
    std::uint16_t *least = columns.least.data(), *greatest = columns.greatest.data();
    run_vectors(
        unit_, [&](auto kind) __attribute__((always_inline)) {
            using Lanes = typename decltype(kind)::Lanes;
            bound_columns<Lanes>(rows, least, greatest);
            std::fill(least + frame.width, least + columns.least.size(), std::uint16_t{65535});
            std::fill(greatest + frame.width, greatest + columns.greatest.size(), std::uint16_t{0});
            for (int step = 1; step < TileGrid::cells; step *= 2) fold<Lanes>(step, strips, least, greatest);
            fold<Lanes>(1, strips, least, greatest);
        });
}

void TileBounder::bound_row(int ty, int thread, SurfaceFrame& frame) {
    Columns& columns = columns_[static_cast<std::size_t>(thread)];
    const TileGrid grid = TileGrid::of(frame.width, frame.height);
    const int top = ty * TileGrid::cells;
    bound_columns_of(frame, top, std::min(top + TileGrid::cells, frame.height - 1), columns);
    TileBounds* tile = frame.tiles.data() + std::ptrdiff_t{ty} * grid.tiles_x;
    for (int tx = 0; tx < grid.tiles_x; ++tx, ++tile) {
        const int left = tx * TileGrid::cells, right = std::min(left + TileGrid::cells, frame.width - 1);
        tile->least = columns.least[static_cast<std::size_t>(left)];
        tile->greatest = columns.greatest[static_cast<std::size_t>(left)];
        tile->any_invalid = any_bit(columns.holes, left, right);
    }
    bounded_[static_cast<std::size_t>(ty)] = 1;
}

void TileBounder::begin(int threads, SurfaceFrame& frame) {
    const TileGrid grid = TileGrid::of(frame.width, frame.height);
    frame.tiles.resize(static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y));
    columns_.resize(static_cast<std::size_t>(threads));
    for (Columns& columns : columns_) columns.resize(frame.validity_words_per_row());
    bounded_.assign(static_cast<std::size_t>(grid.tiles_y), 0);
}

// A tile's last row of vertices is the first of the next tile.
void TileBounder::bound_inside(const RowBand& band, SurfaceFrame& frame) {
    const TileGrid grid = TileGrid::of(frame.width, frame.height);
    for (int ty = (band.first + TileGrid::cells - 1) / TileGrid::cells; ty < grid.tiles_y; ++ty) {
        if (std::min((ty + 1) * TileGrid::cells, frame.height - 1) >= band.last) return;
        bound_row(ty, band.thread, frame);
    }
}

void TileBounder::finish(RowBands& bands, SurfaceFrame& frame) {
    bands.for_each_band(static_cast<int>(bounded_.size()), 1, [&](const RowBand& band) {
        for (int ty = band.first; ty < band.last; ++ty)
            if (bounded_[static_cast<std::size_t>(ty)] == 0) bound_row(ty, band.thread, frame);
    });
}

}  // namespace touchable
