#pragma once

#include <cstdint>
#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/base/vector_unit.hpp"
#include "engine/scene/surface_frame.hpp"
#include "engine/surface/patches.hpp"

namespace touchable {

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
