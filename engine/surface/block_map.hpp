#pragma once

#include <cstdint>
#include <vector>

#include "engine/frame/surface_frame.hpp"
#include "engine/surface/validity_strip.hpp"

namespace touchable {

/// Pixels [left, right) x [top, bottom).
struct PixelBox {
    int left = 0, top = 0, right = 0, bottom = 0;
    bool empty() const { return right <= left || bottom <= top; }
    bool operator==(const PixelBox&) const = default;
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
    bool operator==(const BlockGrid&) const = default;
};

/// Neighbours in a row of blocks (or of tiles): [first, last).
struct BlockRun {
    int first = 0, last = 0;
    bool empty() const { return last <= first; }
};

/// A set of a picture's blocks.
class BlockMap {
public:
    BlockMap() = default;
    BlockMap(int width, int height)
        : grid_(BlockGrid::of(width, height)),
          blocks_(static_cast<std::size_t>(grid_.columns) * static_cast<std::size_t>(grid_.rows)) {}

    const BlockGrid& grid() const { return grid_; }
    void clear();
    /// Every block with a pixel in the box, which may reach beyond the picture.
    void add(const PixelBox& box);
    /// Every block of a set of the same picture.
    void add(const BlockMap& other);
    bool contains(int column, int row) const { return this->row(row)[column] != 0; }
    int count() const;
    /// The first run of blocks at or after column `from`, in any of the rows [first_row, last_row); empty
    /// where there is none.
    BlockRun next_run(int first_row, int last_row, int from) const;

private:
    const std::uint8_t* row(int y) const { return blocks_.data() + std::ptrdiff_t{grid_.columns} * y; }

    BlockGrid grid_;
    std::vector<std::uint8_t> blocks_;  // 1: in the set
};

}  // namespace touchable
