#pragma once

#include <cstdint>
#include <vector>

#include "engine/frame/surface_frame.hpp"

namespace touchable {

/// Least and greatest valid code, and whether any pixel is invalid, over the vertices of every tile of 16x16
/// cells (see TileBounds).
class TileBounder {
public:
    /// Codes and validity of `frame` -> its tiles. No allocation once it has seen the size.
    void bound(SurfaceFrame& frame);

private:
    void gather_rows(const SurfaceFrame& frame, int first, int last);

    // Over the rows of one row of tiles, by column.
    std::vector<std::uint16_t> least_, greatest_;
    std::vector<std::uint32_t> holes_;
};

}  // namespace touchable
