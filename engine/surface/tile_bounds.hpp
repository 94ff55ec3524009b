#pragma once

#include <cstdint>
#include <vector>

#include "engine/frame/surface_frame.hpp"
#include "engine/surface/row_bands.hpp"
#include "engine/surface/vector_unit.hpp"

namespace touchable {

/// Least and greatest valid code, and whether any pixel is invalid, over the vertices of every tile of 16x16
/// cells (see TileBounds).
class TileBounder {
public:
    explicit TileBounder(VectorUnit unit) : unit_(unit) {}

    /// Codes and validity of `frame` -> its tiles. No allocation once it has seen the size.
    void bound(RowBands& bands, SurfaceFrame& frame);

private:
    /// Over the rows of one row of tiles, by column, a strip beyond the picture.
    struct Columns {
        std::vector<std::uint16_t> least, greatest;
        std::vector<std::uint32_t> holes;

        void resize(int strips);
    };
    void bound_columns(const SurfaceFrame& frame, int first, int last, Columns& columns) const;

    VectorUnit unit_;
    std::vector<Columns> columns_;  // of each thread
};

}  // namespace touchable
