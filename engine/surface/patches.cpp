#include "engine/surface/patches.hpp"

#include <algorithm>

namespace touchable {
namespace {

/// Rows of blocks that a patch goes over: where filters reach far, a higher one has less around it for what
/// it has within.
int rows_of_patch(int reach) {
    return 1 + reach / 4;
}

/// A patch's row costs this many pixels of a large picture, whatever its length; so two that are no farther
/// apart are better one.
constexpr int pixels_per_row = 256;

/// The next patch of some rows of blocks.
BlockRun next_patch(const StaleBlocks& blocks, int top, int bottom, int from) {
    BlockRun all = blocks.next_run(top, bottom, from);
    BlockRun next = all;
    while (!(next = blocks.next_run(top, bottom, next.last)).empty() &&
           (next.first - all.last) * BlockGrid::width <= pixels_per_row)
        all.last = next.last;
    return all;
}

}  // namespace

void Patches::cover(const StaleBlocks& blocks, int width, int height, int reach) {
    patches.clear();
    tile_runs.clear();
    cost = tiles = 0;
    const int rows = blocks.grid().rows, step = rows_of_patch(reach);
    for (int top = 0; top < rows; top += step) {
        const int bottom = std::min(top + step, rows);
        BlockRun run;
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
        BlockRun run;
        while (!(run = blocks.next_run(row, std::min(row + 2, rows), run.last)).empty()) {
            const BlockRun run_of_tiles{std::max(2 * run.first - 1, 0), std::min(2 * run.last, grid.tiles_x)};
            tile_runs.push_back({row, run_of_tiles});
            tiles += run_of_tiles.last - run_of_tiles.first;
        }
    }
}

}  // namespace touchable
