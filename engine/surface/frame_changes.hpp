#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/base/vector_unit.hpp"
#include "engine/scene/raw_frame.hpp"
#include "engine/surface/stale_blocks.hpp"

namespace touchable {

/// Which frame of which builder a slot holds; by default none. A builder keeps it beside the slot's vertices,
/// which are its own, takes it off before it changes the slot and puts it back, newer, when it has done.
struct BuildNumber {
    std::uint64_t builder = 0, frame = 0;
};

/// What has changed from frame to frame of one builder, so that it can build only that again, even in a slot
/// that holds an older frame: of each block it is known in which frame it last changed.
class FrameChanges {
public:
    /// `reach`: pixels as far from one another as this, along x and y, may depend on each other.
    FrameChanges(int width, int height, int reach, VectorUnit unit);

    /// The next frame, which is compared with the one before, if that keeps its planes alive (`storage`):
    /// after one that does not everything is new.
    BuildNumber advance(const RawFrame& raw, RowBands& bands);

    /// Of a slot that holds `held`: the blocks with a pixel that may be another one in the newest frame,
    /// until that is another. Nothing: any may.
    std::optional<StaleBlocks> stale_blocks(const BuildNumber& held) const;
    /// To be told where a frame was built as a whole though its blocks were known: the next few are not
    /// compared.
    void comparing_was_in_vain();
    /// Whether `held` had the newest frame's haptic and height planes.
    bool same_touch_planes(const BuildNumber& held) const;

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
    RawFrame newest_;                                 // nothing where it does not keep its planes
    std::uint64_t frame_ = 0;                         // its number
    std::uint64_t all_ = 0, touch_planes_ = 0;        // in which frame all, and those, last changed
    std::vector<std::uint64_t> changed_;              // of each block, likewise
    std::vector<std::vector<std::uint8_t>> columns_;  // work space of each thread
};

}  // namespace touchable
