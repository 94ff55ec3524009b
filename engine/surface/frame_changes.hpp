// SPDX-License-Identifier: Apache-2.0
#pragma once

// Which blocks of a frame differ from the frame before, so that the rest is not built again
// (docs/architecture.md, Frames that change in part).
//
// FrameChanges compares depth in blocks and widens the changes by the filters' reach; StaleBlocks are the
// blocks that one slot of the ring lacks.
// Threads: the building one.

#include "engine/base/threads.hpp"
#include "engine/base/vectors.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/code_rows.hpp"

namespace touchable {

/// Blocks of 32x16 pixels, a validity word wide and a tile high; those at the right and lower edge of a
/// picture may be smaller.
struct BlockGrid {
    static constexpr int width = strip_pixels, height = TileGrid::cells;
    /// Adjacent blocks (or tiles) of a row: [first, last).
    struct Run {
        int first = 0, last = 0;
        bool empty() const { return last <= first; }
    };

    int columns = 0, rows = 0;

    static BlockGrid of(int width, int height) {
        return {(width + BlockGrid::width - 1) / BlockGrid::width,
                (height + BlockGrid::height - 1) / BlockGrid::height};
    }
    std::size_t count() const { return pixel_count(columns, rows); }
    std::size_t index(int column, int row) const { return pixel_place(column, row, columns); }
};

/// Which frame of which builder a slot holds; by default none. A builder keeps it beside its own vertices in
/// the slot, removes it before it changes the slot and stores the new one when it is done.
struct BuildNumber {
    std::uint64_t builder = 0, frame = 0;

    /// Whether it is of the same builder, and of that frame or a later one.
    bool is_since(const BuildNumber& other) const { return builder == other.builder && frame >= other.frame; }
};

/// Changes from frame to frame of one builder, so that it can build only these again, even in a slot that
/// holds an older frame: for each block, the frame in which it last changed is known.
class FrameChanges {
public:
    /// The blocks of a picture that have changed since some frame.
    class StaleBlocks {
    public:
        /// `changed`: for each block the frame of its last change; has to outlive this.
        StaleBlocks(const BlockGrid& grid, const std::vector<std::uint64_t>& changed, std::uint64_t since)
            : grid_(grid), changed_(&changed), since_(since) {}

        const BlockGrid& grid() const { return grid_; }
        bool contains(int column, int row) const { return (*changed_)[grid_.index(column, row)] > since_; }
        int count() const;
        /// The first run of blocks at or after column `from`, in any of the rows [first_row, last_row); empty
        /// if there is none.
        BlockGrid::Run next_run(int first_row, int last_row, int from) const;

    private:
        BlockGrid grid_;
        const std::vector<std::uint64_t>* changed_;
        std::uint64_t since_;
    };

    /// `reach`: largest distance of pixels, along x and y, that may depend on each other.
    FrameChanges(int width, int height, int reach, VectorUnit unit);

    /// Compares the next frame with the one before, if that keeps its planes alive (`storage`); otherwise
    /// everything is new.
    BuildNumber advance(const RawFrame& raw, RowBands& bands);

    /// For a slot that holds `held`: the blocks with a pixel that may differ in the newest frame; valid until
    /// the next frame. Nothing: any block may.
    std::optional<StaleBlocks> stale_blocks(const BuildNumber& held) const;
    /// Called if a frame was built as a whole though its blocks were known: the next few are not compared.
    void comparing_was_in_vain();
    /// The first frame since which haptic and height planes are those of the newest.
    BuildNumber touch_planes() const { return {builder_, touch_planes_}; }

private:
    bool compare_depth(const PlaneView& after, RowBands& bands);
    int compare_row(const PlaneView& after, int row, std::vector<std::uint8_t>& columns);
    void add_differences(const PlaneView& after, int top, int bottom,
                         std::vector<std::uint8_t>& columns) const;
    void mark(const PixelBox& changed);

    const std::uint64_t builder_;
    const int reach_;
    const VectorUnit unit_;
    const BlockGrid grid_;
    int rest_ = 0;                                    // frames that will not be compared
    RawFrame newest_;                                 // empty if it does not keep its planes
    std::uint64_t frame_ = 0;                         // its number
    std::uint64_t all_ = 0, touch_planes_ = 0;        // frame in which all, and those, last changed
    std::vector<std::uint64_t> changed_;              // the same for each block
    std::vector<std::vector<std::uint8_t>> columns_;  // work space per thread
};

}  // namespace touchable
