#pragma once

#include <atomic>
#include <cstdint>
#include <vector>

#include "engine/frame/surface_frame.hpp"

namespace touchable {

/// Filters a pixel of `frame.raw.depth` when it is asked for, by `frame.coding`: the same depth and validity
/// as a filtered frame, at the cost of the pixels that are touched. Any number of readers.
class LazyVertices final : public VertexSource {
public:
    /// `frame` must outlive it; `filter` as in Scene.
    LazyVertices(const SurfaceFrame& frame, const FilterSettings& filter);
    /// To be called once the frame holds another raw plane, before anyone reads it.
    void restart();
    const FilterSettings& filter() const { return filter_; }

    DepthSample at(int x, int y) const override;
    /// Over the raw codes of the tile and the filter's reach around it: wider than of the filtered codes.
    TileDepths tile(int tx, int ty) const override;

private:
    TileBounds raw_bounds(int tx, int ty) const;

    const SurfaceFrame& frame_;
    FilterSettings filter_;
    // Bounds of a tile, packed into one word so that readers never see half of them; 0: not yet computed.
    mutable std::vector<std::atomic<std::uint64_t>> tiles_;
};

}  // namespace touchable
