#pragma once

#include <span>
#include <vector>

#include "engine/frame/plane_view.hpp"
#include "engine/surface/block_map.hpp"
#include "engine/surface/vector_unit.hpp"

namespace touchable {

/// Looks at two planes of the same form for what differs, by blocks (BlockGrid).
class PlaneComparison {
public:
    PlaneComparison(const PlaneView& before, const PlaneView& after, VectorUnit unit)
        : before_(before), after_(after), unit_(unit) {}

    /// How many blocks of a row differ in their uppermost row of pixels. A plane that has changed all over is
    /// found out by this at a sixteenth of the cost.
    int changed_at_top(int block_row) const;
    /// Of each block of a row a box around the pixels that differ, empty where none does: the columns that
    /// do, over all rows. `boxes`: one per column. `columns` is work space, to be kept for the next call.
    void find(int block_row, std::span<PixelBox> boxes, std::vector<std::uint8_t>& columns) const;
    /// Makes such a box, not empty, the smallest one.
    void narrow(PixelBox& box) const;

private:
    /// One block.
    struct Piece {
        int x, pixels, offset, bytes;
    };
    Piece piece(int column) const;
    bool same(const Piece& piece, int y) const;
    void add_rows(int first, int last, std::vector<std::uint8_t>& columns) const;

    const PlaneView &before_, &after_;
    VectorUnit unit_;
};

}  // namespace touchable
