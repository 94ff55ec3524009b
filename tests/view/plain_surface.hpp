#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "player/draw/drawn_surface.hpp"
#include "player/draw/view.hpp"
#include "shaders/cut_rule.h"

namespace touchable::test {

/// Which tiles of a lattice of these q are worth drawing, by asking for every triangle.
inline ViewSurface::Tiles classify_tiles(int width, int height, const std::vector<float>& q) {
    const TileGrid grid = TileGrid::of(width, height);
    ViewSurface::Tiles tiles;
    auto at = [&](int x, int y) {
        return q[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
    };
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) {
            bool any_cut = false, any_shown = false;
            const int end_x = std::min((tx + 1) * TileGrid::cells, width - 1);
            const int end_y = std::min((ty + 1) * TileGrid::cells, height - 1);
            for (int y = ty * TileGrid::cells; y < end_y; ++y)
                for (int x = tx * TileGrid::cells; x < end_x; ++x)
                    for (const auto& [a, b, c] : {std::array{at(x, y), at(x + 1, y), at(x + 1, y + 1)},
                                                  std::array{at(x, y), at(x + 1, y + 1), at(x, y + 1)}}) {
                        any_cut = any_cut || triangle_is_cut(a, b, c);
                        any_shown = any_shown || !triangle_has_hole(a, b, c);
                    }
            if (!any_shown) continue;
            (any_cut ? tiles.mixed : tiles.whole)
                .push_back(static_cast<std::uint32_t>(ty * grid.tiles_x + tx));
        }
    return tiles;
}

/// With q_of(field), and classify_tiles of that.
inline ViewSurface make_view_surface(const HeightField& field, const PlaneView& colour) {
    std::vector<float> q = q_of(field);
    ViewSurface::Tiles tiles = classify_tiles(field.width(), field.height(), q);
    return make_view_surface(field, std::move(q), std::move(tiles), colour);
}

}  // namespace touchable::test
