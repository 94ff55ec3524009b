#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine/scene/surface_frame.hpp"
#include "engine/surface/filter_plan.hpp"

namespace touchable {

/// Filters a pixel of `frame.raw.depth` when it is asked for: the same depth and validity as a filtered
/// frame, at the cost of the pixels that are touched. Terraces are removed from blocks of pixels
/// (terrace_block), each when one of it is asked for first. Any number of readers.
class LazyVertices final : public VertexSource {
public:
    /// `frame` must outlive it. None of the filters may remember frames before.
    LazyVertices(const SurfaceFrame& frame, const FilterPlan& plan);
    /// To be called once the frame holds another raw plane, before anyone reads it.
    void restart();
    /// Whether frames are filtered so.
    bool serves(const FilterPlan& plan) const { return plan_ == plan; }

    DepthSample at(int x, int y) const override;
    /// Over the raw codes of the tile and the filter's reach around it: wider than of the filtered codes.
    TileDepths tile(int tx, int ty) const override;

private:
    /// Before terrace removal, and after; nothing: invalid.
    std::optional<std::uint16_t> filtered_code(int x, int y) const;
    std::optional<std::uint16_t> recent_code(int x, int y) const;
    std::optional<std::uint16_t> finer_code(int x, int y) const;
    void level_block(int bx, int by) const;
    template <int reach>
    void level_block_within(int bx, int by) const;
    TileBounds raw_bounds(int tx, int ty) const;
    TileBounds finer_bounds(const TileBounds& stored) const;

    const SurfaceFrame& frame_;
    const FilterPlan plan_;
    const DepthCoding& stored_;
    const FlyingPixels* flying_;     // null: no filter
    const int passes_, radius_;      // of hole filling; of the median
    const TerraceFilter* terraces_;  // null: no filter
    // Bounds of a tile, packed into one word so that readers never see half of them; 0: not yet computed.
    mutable std::vector<std::atomic<std::uint64_t>> tiles_;
    // Of a pixel in every place of a square that repeats over the picture the filtered code, packed likewise
    // with where that pixel is: a finger asks for the same few again and again.
    static constexpr int recent_side = 32;
    mutable std::array<std::atomic<std::uint64_t>, recent_side * recent_side> recent_{};
    // With terrace removal: which blocks are done, and the codes of those.
    int block_ = 0, blocks_x_ = 0;
    mutable std::vector<std::atomic<bool>> blocks_;
    mutable std::vector<std::atomic<std::uint16_t>> finer_;
};

}  // namespace touchable
