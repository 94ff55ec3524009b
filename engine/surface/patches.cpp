// SPDX-License-Identifier: Apache-2.0
// The parts of a frame that are built again, and the bounds of tiles.
#include "engine/surface/patches.hpp"

namespace touchable {
namespace {

/// Rows of blocks per patch: if filters reach far, a higher patch has less around it for its content.
int rows_of_patch(int reach) {
    return 1 + reach / 4;
}

/// A row of a patch costs this many pixels of a large picture, whatever its length, so two patches that are
/// no farther apart are better joined.
constexpr int pixels_per_row = 256;

/// The next patch of some rows of blocks.
BlockGrid::Run next_patch(const FrameChanges::StaleBlocks& blocks, int top, int bottom, int from) {
    BlockGrid::Run all = blocks.next_run(top, bottom, from);
    BlockGrid::Run next = all;
    while (!(next = blocks.next_run(top, bottom, next.last)).empty() &&
           (next.first - all.last) * BlockGrid::width <= pixels_per_row)
        all.last = next.last;
    return all;
}

/// Rows [first, last] of a frame, and how an invalid pixel, whose code is 0, counts as 65535 for the least
/// code: all codes become one less or, if 0 is a valid code, too, by its validity bit.
struct Rows {
    const SurfaceFrame& frame;
    int first, last;
    std::uint16_t one_less;
    bool masked;
};

/// Least and greatest valid code of each column in `Vectors` vectors from `x` on, within the picture.
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
        if constexpr (Masked) masks_of_bits(~frame.validity_row(y)[x / strip_pixels], masks);
        for (int k = 0; k < Vectors; ++k) {
            Lanes values = load_lanes<Lanes>(codes + k * lanes);
            high[k] = greater(high[k], values);
            if constexpr (Masked) values |= load_lanes<Lanes>(masks + k * lanes);
            low[k] = lesser<Lanes>(low[k], values - rows.one_less);
        }
    }
    for (int k = 0; k < Vectors; ++k) {
        // One more again, except if nothing is valid.
        store_lanes<Lanes>(low[k] + lesser<Lanes>(~low[k], Lanes{} + rows.one_less), least + x + k * lanes);
        store_lanes(high[k], greatest + x + k * lanes);
    }
}

/// From column `x` to `end`, the end of the last strip. A few vectors at a time, for the sake of the loop
/// over the rows; by strips with masks, and at the end.
template <class Lanes>
[[gnu::always_inline]] inline void bound_columns(const Rows& rows, int x, int end, std::uint16_t* least,
                                                 std::uint16_t* greatest) {
    constexpr int lanes = lane_count<Lanes>, vectors = 4;
    constexpr int of_strip = strip_pixels / lanes;
    if (rows.masked)
        for (; x < end; x += strip_pixels) bound_vectors<true, Lanes, of_strip>(rows, x, least, greatest);
    for (; x + vectors * lanes <= std::min(end, rows.frame.width); x += vectors * lanes)
        bound_vectors<false, Lanes, vectors>(rows, x, least, greatest);
    for (; x < end; x += strip_pixels) bound_vectors<false, Lanes, of_strip>(rows, x, least, greatest);
}

/// Replaces each value from column `x` to `end` by the lesser (or greater) of itself and the one `step`
/// columns further on.
template <class Lanes>
[[gnu::always_inline]] inline void fold(int step, int x, int end, std::uint16_t* least,
                                        std::uint16_t* greatest) {
    for (; x < end; x += lane_count<Lanes>) {
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

void Patches::cover(const FrameChanges::StaleBlocks& blocks, int width, int height, int reach) {
    patches.clear();
    tile_runs.clear();
    cost = tiles = 0;
    const int rows = blocks.grid().rows, step = rows_of_patch(reach);
    for (int top = 0; top < rows; top += step) {
        const int bottom = std::min(top + step, rows);
        BlockGrid::Run run;
        while (!(run = next_patch(blocks, top, bottom, run.last)).empty()) {
            const PixelBox inner{run.first * BlockGrid::width, top * BlockGrid::height,
                                 std::min(run.last * BlockGrid::width, width),
                                 std::min(bottom * BlockGrid::height, height)};
            const PixelBox outer{std::max(inner.left - reach, 0), std::max(inner.top - reach, 0),
                                 std::min(inner.right + reach, width),
                                 std::min(inner.bottom + reach, height)};
            patches.push_back({inner, outer});
            cost += long{outer.right - outer.left + pixels_per_row} * (outer.bottom - outer.top);
        }
    }
    // A tile's last column and row of vertices are the first of the next tiles, so of the next blocks.
    static_assert(BlockGrid::width == 2 * TileGrid::cells && BlockGrid::height == TileGrid::cells);
    const TileGrid grid = TileGrid::of(width, height);
    for (int row = 0; row < grid.tiles_y; ++row) {
        BlockGrid::Run run;
        while (!(run = blocks.next_run(row, std::min(row + 2, rows), run.last)).empty()) {
            const BlockGrid::Run run_of_tiles{std::max(2 * run.first - 1, 0),
                                              std::min(2 * run.last, grid.tiles_x)};
            tile_runs.push_back({row, run_of_tiles});
            tiles += run_of_tiles.last - run_of_tiles.first;
        }
    }
}

void PatchFilter::filter(const RawFrame& raw, const Patch& patch, SurfaceFrame& out) {
    const PixelBox& outer = patch.outer;
    RawFrame part;
    part.number = raw.number;
    part.depth = raw.depth;
    part.depth.data = raw.depth.row(outer.top) +
                      std::ptrdiff_t{outer.left} * raw.depth.channels * raw.depth.bytes_per_sample;
    part.depth.width = outer.right - outer.left;
    part.depth.height = outer.bottom - outer.top;
    filters_->make_all(part, alone_, picture_);
    copy(patch, out);
}

void PatchFilter::copy(const Patch& patch, SurfaceFrame& out) const {
    const PixelBox& inner = patch.inner;
    const int left = inner.left - patch.outer.left, top = inner.top - patch.outer.top;
    const int words = (inner.right - inner.left + strip_pixels - 1) / strip_pixels,
              shift = left % strip_pixels;
    const int words_of_picture = picture_.validity_words_per_row();
    for (int y = inner.top; y < inner.bottom; ++y) {
        const int from = y - inner.top + top;
        std::memcpy(out.codes.data() + out.index(inner.left, y),
                    picture_.codes.data() + picture_.index(left, from),
                    static_cast<std::size_t>(inner.right - inner.left) * sizeof(std::uint16_t));
        const std::uint32_t* bits = picture_.validity_row(from);
        std::uint32_t* to = out.validity_row(y) + inner.left / strip_pixels;
        for (int word = 0; word < words; ++word) {
            const int first = left / strip_pixels + word;
            const std::uint64_t next = first + 1 < words_of_picture ? bits[first + 1] : 0;
            to[word] = static_cast<std::uint32_t>((next << strip_pixels | bits[first]) >> shift);
        }
    }
}

void TileBounder::Columns::resize(int strips) {
    const auto pixels = static_cast<std::size_t>((strips + 1) * strip_pixels);
    least.resize(pixels);
    greatest.resize(pixels);
    holes.resize(static_cast<std::size_t>(strips));
}

// Afterwards `least` and `greatest` of a column are those of a tile that begins there, if the box holds it.
void TileBounder::bound_columns_of(const SurfaceFrame& frame, const PixelBox& box, Columns& columns) const {
    const int first = box.left / strip_pixels, last = (box.right - 1) / strip_pixels + 1;
    std::fill(columns.holes.begin() + first, columns.holes.begin() + last, 0U);
    for (int y = box.top; y < box.bottom; ++y) {
        const std::uint32_t* validity = frame.validity_row(y);
        for (int w = first; w < last; ++w)
            columns.holes[static_cast<std::size_t>(w)] |= ~validity[w] & inside_bits(frame.width, w);
    }
    const bool holes = std::any_of(columns.holes.begin() + first, columns.holes.begin() + last,
                                   [](auto bits) { return bits != 0; });
    const bool masked = holes && frame.coding.is_valid(0);
    const Rows rows{frame, box.top, box.bottom - 1, static_cast<std::uint16_t>(holes && !masked ? 1 : 0),
                    masked};
    const int left = first * strip_pixels, right = last * strip_pixels;
    std::uint16_t *least = columns.least.data(), *greatest = columns.greatest.data();
    run_vectors(
        unit_, [&](auto kind) __attribute__((always_inline)) {
            using Lanes = typename decltype(kind)::type;
            bound_columns<Lanes>(rows, left, right, least, greatest);
            std::fill(least + frame.width, least + columns.least.size(), std::uint16_t{65535});
            std::fill(greatest + frame.width, greatest + columns.greatest.size(), std::uint16_t{0});
            for (int step = 1; step < TileGrid::cells; step *= 2)
                fold<Lanes>(step, left, right, least, greatest);
            fold<Lanes>(1, left, right, least, greatest);
        });
}

void TileBounder::bound(const TileRun& run, int thread, SurfaceFrame& frame) {
    Columns& columns = columns_[static_cast<std::size_t>(thread)];
    const TileGrid grid = TileGrid::of(frame.width, frame.height);
    const int top = run.row * TileGrid::cells;
    bound_columns_of(
        frame,
        {run.tiles.first * TileGrid::cells, top, std::min(run.tiles.last * TileGrid::cells + 1, frame.width),
         std::min(top + TileGrid::cells + 1, frame.height)},
        columns);
    TileBounds* tiles = frame.tiles.data() + std::ptrdiff_t{run.row} * grid.tiles_x;
    for (int tx = run.tiles.first; tx < run.tiles.last; ++tx) {
        const int left = tx * TileGrid::cells, right = std::min(left + TileGrid::cells, frame.width - 1);
        tiles[tx] = {columns.least[static_cast<std::size_t>(left)],
                     columns.greatest[static_cast<std::size_t>(left)], any_bit(columns.holes, left, right)};
    }
}

void TileBounder::bound_row(int ty, int thread, SurfaceFrame& frame) {
    bound({ty, {0, TileGrid::of(frame.width, frame.height).tiles_x}}, thread, frame);
    bounded_[static_cast<std::size_t>(ty)] = 1;
}

void TileBounder::begin(int threads, int width, int height, SurfaceFrame& frame) {
    const TileGrid grid = TileGrid::of(width, height);
    frame.tiles.resize(grid.count());
    columns_.resize(static_cast<std::size_t>(threads));
    for (Columns& columns : columns_) columns.resize(BlockGrid::of(width, height).columns);
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
