#include "engine/scene/vertex_source.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "engine/scene/surface_frame.hpp"

namespace touchable {

namespace {

/// Nothing seen yet: any depth narrows it, and so does the union with another tile.
constexpr TileDepths no_depths{std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity(), false};

}  // namespace

TileDepths depths_of(const TileBounds& bounds, const DepthCoding& coding) {
    TileDepths depths = no_depths;
    depths.any_invalid = bounds.any_invalid;
    if (bounds.least > bounds.greatest) return depths;
    // Depth is monotone in the code, in floating point too, so the extreme codes enclose the rest.
    depths.nearest = coding.depth(bounds.least);
    depths.farthest = coding.depth(bounds.greatest);
    if (!coding.deeper_is_higher()) std::swap(depths.nearest, depths.farthest);
    return depths;
}

DepthSample FilteredVertices::at(int x, int y) const {
    return sample_of(frame_, x, y);
}

TileDepths FilteredVertices::tile(int tx, int ty) const {
    const TileGrid grid = TileGrid::of(frame_.width, frame_.height);
    const TileBounds& bounds =
        frame_.tiles[static_cast<std::size_t>(ty) * static_cast<std::size_t>(grid.tiles_x) +
                     static_cast<std::size_t>(tx)];
    return depths_of(bounds, frame_.coding);
}

ExactVertices::ExactVertices(int width, int height, std::vector<double> depths)
    : width_(std::max(width, 0)), height_(std::max(height, 0)), depths_(std::move(depths)) {
    depths_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_),
                   std::numeric_limits<double>::quiet_NaN());
    const TileGrid grid = TileGrid::of(width_, height_);
    tiles_.reserve(static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y));
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) tiles_.push_back(bound(tx, ty));
}

TileDepths ExactVertices::bound(int tx, int ty) const {
    const int x0 = tx * TileGrid::cells, x1 = std::min(x0 + TileGrid::cells, width_ - 1);
    const int y0 = ty * TileGrid::cells, y1 = std::min(y0 + TileGrid::cells, height_ - 1);
    TileDepths depths = no_depths;
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const DepthSample sample = at(x, y);
            if (!sample.valid) {
                depths.any_invalid = true;
                continue;
            }
            depths.nearest = std::min(depths.nearest, sample.depth);
            depths.farthest = std::max(depths.farthest, sample.depth);
        }
    return depths;
}

DepthSample ExactVertices::at(int x, int y) const {
    const double depth =
        depths_[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x)];
    return {depth, std::isfinite(depth)};
}

TileDepths ExactVertices::tile(int tx, int ty) const {
    const TileGrid grid = TileGrid::of(width_, height_);
    return tiles_[static_cast<std::size_t>(ty) * static_cast<std::size_t>(grid.tiles_x) +
                  static_cast<std::size_t>(tx)];
}

}  // namespace touchable
