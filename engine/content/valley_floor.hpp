#pragma once

#include <vector>

#include "engine/base/row_bands.hpp"

namespace touchable {

/// Heights all over a globe, in rows from north to south, each from west to east; at the middles of their
/// cells.
struct HeightGrid {
    int width = 0, height = 0;
    std::vector<float> values{};
};

/// The smooth ground under mountains: nowhere above the heights, also between the middles of cells, level
/// with the sea wherever that is, and without anything narrower than `radius` (radians, on the sphere). At
/// each place the lowest height within a little more than that, then a mean of these within it: as each of
/// those is at most the height here, so is their mean.
HeightGrid valley_floor(const HeightGrid& heights, double radius, RowBands& rows);

}  // namespace touchable
