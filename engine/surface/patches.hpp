#pragma once

#include <vector>

#include "engine/surface/stale_blocks.hpp"

namespace touchable {

/// A part of a picture, and around it what it depends on: filtered as a picture of its own, the part comes
/// out as it does of the whole one.
struct Patch {
    PixelBox inner, outer;
};

/// Tiles [first, last) of a row of tiles.
struct TileRun {
    int row = 0;
    BlockRun tiles;
};

/// What has to be done so that a set of blocks is built again.
struct Patches {
    std::vector<Patch> patches;      ///< no two inner boxes overlap; all together hold those blocks
    std::vector<TileRun> tile_runs;  ///< every tile with a vertex in those blocks
    long cost = 0;                   ///< of the patches, as so many pixels of a whole picture
    long tiles = 0;                  ///< of all runs

    /// Of a picture of that size, in which pixels up to `reach` away may depend on each other. No allocation
    /// where it has had as many.
    void cover(const StaleBlocks& blocks, int width, int height, int reach);
};

}  // namespace touchable
