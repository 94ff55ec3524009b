#pragma once

#include <cstdint>
#include <vector>

#include "engine/scene/surface_frame.hpp"
#include "engine/surface/validity_strip.hpp"

namespace touchable {

/// Pixels [left, right) x [top, bottom).
struct PixelBox {
    int left = 0, top = 0, right = 0, bottom = 0;
};

/// Blocks of 32x16 pixels, a validity word wide and a tile high; those at the right and lower edge of a
/// picture may be smaller.
struct BlockGrid {
    static constexpr int width = strip_pixels, height = TileGrid::cells;
    int columns = 0, rows = 0;

    static BlockGrid of(int width, int height) {
        return {(width + BlockGrid::width - 1) / BlockGrid::width,
                (height + BlockGrid::height - 1) / BlockGrid::height};
    }
    std::size_t count() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
    std::size_t index(int column, int row) const {
        return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) +
               static_cast<std::size_t>(column);
    }
};

/// Neighbours in a row of blocks (or of tiles): [first, last).
struct BlockRun {
    int first = 0, last = 0;
    bool empty() const { return last <= first; }
};

/// Those of a picture's blocks that have changed since some frame.
class StaleBlocks {
public:
    /// `changed`: of each block the frame in which it last changed, which has to outlive this.
    StaleBlocks(const BlockGrid& grid, const std::vector<std::uint64_t>& changed, std::uint64_t since)
        : grid_(grid), changed_(&changed), since_(since) {}

    const BlockGrid& grid() const { return grid_; }
    bool contains(int column, int row) const { return (*changed_)[grid_.index(column, row)] > since_; }
    int count() const;
    /// The first run of blocks at or after column `from`, in any of the rows [first_row, last_row); empty
    /// where there is none.
    BlockRun next_run(int first_row, int last_row, int from) const;

private:
    BlockGrid grid_;
    const std::vector<std::uint64_t>* changed_;
    std::uint64_t since_;
};

}  // namespace touchable
