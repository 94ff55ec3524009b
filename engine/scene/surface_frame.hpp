#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/scene/frame_array.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/scene/scene.hpp"
#include "engine/scene/vertex_source.hpp"

namespace touchable {

/// Tiles of 16x16 cells, so of 17x17 vertices. Cell (i, j) lies between pixels (i, j) and (i+1, j+1); the
/// cells of the ring around the picture, and everything beyond, belong to the nearest tile.
struct TileGrid {
    static constexpr int cells = 16;
    int tiles_x = 1, tiles_y = 1;

    static TileGrid of(int width, int height) {
        auto count = [](int pixels) { return pixels <= 1 ? 1 : (pixels - 1 + cells - 1) / cells; };
        return {count(width), count(height)};
    }
    int column_of_cell(int i) const { return i < 0 ? 0 : (i / cells < tiles_x ? i / cells : tiles_x - 1); }
    int row_of_cell(int j) const { return j < 0 ? 0 : (j / cells < tiles_y ? j / cells : tiles_y - 1); }
};

/// Over the valid codes of a tile's vertices inside the picture; least > greatest (65535, 0): none is valid.
/// Eight bytes, as kernels write them.
struct alignas(8) TileBounds {
    std::uint16_t least = 65535, greatest = 0;
    bool any_invalid = false;
    bool operator==(const TileBounds&) const = default;
};

/// One filtered frame. Filled by a SurfaceBuilder, then immutable until its slot is recycled; its timestamp
/// lives in the SurfaceTimeline, because an unchanged frame is published again at a later one. It stays where
/// it is: its vertices read it.
struct SurfaceFrame {
    SurfaceFrame() = default;
    SurfaceFrame(const SurfaceFrame&) = delete;
    SurfaceFrame& operator=(const SurfaceFrame&) = delete;

    int width = 0, height = 0;
    DepthCoding coding;               ///< of `codes`; a filter that adds precision has its own
    FrameArray<std::uint16_t> codes;  ///< width x height, row-major; empty where nobody asked (lazy, exact)
    FrameArray<std::uint32_t> validity;  ///< one bit per pixel, rows padded to whole words, low bit first
    FrameArray<TileBounds> tiles;        ///< tiles_x x tiles_y of TileGrid::of(width, height), row-major
    std::vector<std::uint8_t> haptic;    ///< width x height x 3, never filtered; empty: the scene's defaults
    std::vector<std::uint16_t> heights;  ///< width x height codes, never filtered; empty: no height
    RawFrame raw;                        ///< what it was built from, where the vertices still read it (lazy)
    /// RawFrame::filled of what it was built from
    std::shared_ptr<const std::vector<std::uint32_t>> filled;
    std::unique_ptr<VertexSource> vertices;  ///< how the solver reads this frame; set by the builder

    int validity_words_per_row() const { return (width + 31) / 32; }
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    }
    std::uint32_t* validity_row(int y) {
        return validity.data() + std::ptrdiff_t{y} * validity_words_per_row();
    }
    const std::uint32_t* validity_row(int y) const {
        return validity.data() + std::ptrdiff_t{y} * validity_words_per_row();
    }
    bool is_valid(int x, int y) const { return (validity_row(y)[x >> 5] >> (x & 31)) & 1U; }
};

/// Depth of a pixel of a frame that has codes, and whether it is valid.
inline DepthSample sample_of(const SurfaceFrame& frame, int x, int y) {
    if (!frame.is_valid(x, y)) return {};
    return {frame.coding.depth(frame.codes[frame.index(x, y)]), true};
}

/// True for a frame of this size with vertices, whose planes are of that size or empty.
bool has_size(const SurfaceFrame& frame, int width, int height);

/// Copies the haptic and height planes of a raw frame, or empties them where it has none.
void copy_touch_planes(const RawFrame& raw, SurfaceFrame& out);

}  // namespace touchable
