#pragma once

#include "engine/base/threads.hpp"
#include "engine/base/vectors.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/code_rows.hpp"
#include "engine/surface/frame_changes.hpp"

namespace touchable {

/// A part of a picture, and around it what it depends on: filtered as a picture of its own, the part comes
/// out as it does of the whole one.
struct Patch {
    PixelBox inner, outer;
};

/// Tiles [first, last) of a row of tiles.
struct TileRun {
    int row = 0;
    BlockGrid::Run tiles;
};

/// What has to be done so that a set of blocks is built again.
struct Patches {
    std::vector<Patch> patches;      ///< no two inner boxes overlap; all together hold those blocks
    std::vector<TileRun> tile_runs;  ///< every tile with a vertex in those blocks
    long cost = 0;                   ///< of the patches, as so many pixels of a whole picture
    long tiles = 0;                  ///< of all runs

    /// Of a picture of that size, in which pixels up to `reach` away may depend on each other. No allocation
    /// where it has had as many.
    void cover(const FrameChanges::StaleBlocks& blocks, int width, int height, int reach);
};

/// Filters patches of frames, where no filter remembers frames before; one for each thread that does.
class PatchFilter {
public:
    PatchFilter(const FilterPlan& plan, VectorUnit unit) : filters_(make_code_filters(plan, unit)) {}

    /// Codes and validity of the patch's inner box, into a frame that holds all else. The box begins on a
    /// whole word of validity, and ends on one or with the picture.
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

    /// To be called before the others, of each frame that is built as a whole. `threads`: those that will
    /// call. No allocation once it has seen the size.
    void begin(int threads, int width, int height, SurfaceFrame& frame);
    /// The tiles whose rows are all of a band, while it is still in the cache.
    void bound_inside(const RowBand& band, SurfaceFrame& frame);
    /// All tiles that are left.
    void finish(RowBands& bands, SurfaceFrame& frame);

    /// Some tiles of a frame that has all others, of the size begun with.
    void bound(const TileRun& run, int thread, SurfaceFrame& frame);

private:
    /// Over the rows of one row of tiles, by column, a strip beyond the picture.
    struct Columns {
        std::vector<std::uint16_t> least, greatest;
        std::vector<std::uint32_t> holes;

        void resize(int strips);
    };
    void bound_row(int ty, int thread, SurfaceFrame& frame);
    void bound_columns_of(const SurfaceFrame& frame, const PixelBox& box, Columns& columns) const;

    VectorUnit unit_;
    std::vector<Columns> columns_;  // of each thread
    /// Of each row of tiles, whether it is done; no bits, because several threads write at once.
    std::vector<std::uint8_t> bounded_;
};

}  // namespace touchable
