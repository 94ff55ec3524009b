// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "engine/base/threads.hpp"
#include "engine/base/vectors.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/code_rows.hpp"
#include "engine/surface/frame_changes.hpp"

namespace touchable {

/// A part of a picture, and the box around it on which it depends: filtered as a picture of its own, the part
/// comes out as in the whole one.
struct Patch {
    PixelBox inner, outer;
};

/// Tiles [first, last) of a row of tiles.
struct TileRun {
    int row = 0;
    BlockGrid::Run tiles;
};

/// The work for building a set of blocks again.
struct Patches {
    std::vector<Patch> patches;      ///< inner boxes do not overlap; together they hold the blocks
    std::vector<TileRun> tile_runs;  ///< every tile with a vertex in those blocks
    long cost = 0;                   ///< of the patches, in pixels of a whole picture
    long tiles = 0;                  ///< of all runs

    /// For a picture of that size, in which pixels up to `reach` apart may depend on each other. No
    /// allocation if it has had as many.
    void cover(const FrameChanges::StaleBlocks& blocks, int width, int height, int reach);
};

/// Filters patches of frames, if no filter depends on earlier frames; one per thread.
class PatchFilter {
public:
    PatchFilter(const FilterPlan& plan, VectorUnit unit) : filters_(make_code_filters(plan, unit)) {}

    /// Writes codes and validity of the patch's inner box into a frame that holds all else. The box begins on
    /// a whole word of validity, and ends on one or with the picture.
    void filter(const RawFrame& raw, const Patch& patch, SurfaceFrame& out);

private:
    void copy(const Patch& patch, SurfaceFrame& out) const;

    const std::unique_ptr<BandSource> filters_;
    RowBands alone_{1};
    SurfaceFrame picture_;  // the patch, as a picture of its own
};

/// Least and greatest valid code, and whether any pixel is invalid, over the vertices of every tile of 16x16
/// cells (see TileBounds).
class TileBounder {
public:
    explicit TileBounder(VectorUnit unit) : unit_(unit) {}

    /// To be called first for each frame that is built as a whole. `threads`: number of threads that will
    /// call. No allocation after the first frame of a size.
    void begin(int threads, int width, int height, SurfaceFrame& frame);
    /// Bounds the tiles whose rows all lie in a band, while it is still in the cache.
    void bound_inside(const RowBand& band, SurfaceFrame& frame);
    /// Bounds the remaining tiles.
    void finish(RowBands& bands, SurfaceFrame& frame);

    /// Bounds some tiles of a frame that has all others, of the size given to `begin`.
    void bound(const TileRun& run, int thread, SurfaceFrame& frame);

private:
    /// By column, over the rows of one row of tiles, with a strip beyond the picture.
    struct Columns {
        std::vector<std::uint16_t> least, greatest;
        std::vector<std::uint32_t> holes;

        void resize(int strips);
    };
    void bound_row(int ty, int thread, SurfaceFrame& frame);
    void bound_columns_of(const SurfaceFrame& frame, const PixelBox& box, Columns& columns) const;

    VectorUnit unit_;
    std::vector<Columns> columns_;  // one per thread
    /// For each row of tiles, whether it is done; no bits, because several threads write at once.
    std::vector<std::uint8_t> bounded_;
};

}  // namespace touchable
