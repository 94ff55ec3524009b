#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine/frame/raw_frame.hpp"
#include "engine/surface/block_map.hpp"
#include "engine/surface/row_bands.hpp"
#include "engine/surface/vector_unit.hpp"

namespace touchable {

/// Which of a builder's frames a slot holds: a number that no other build in this program has had, 0 for
/// none. A builder keeps it beside the slot's vertices, which are its own, takes it off before it changes the
/// slot and puts it back, newer, when it has done.
using BuildNumber = std::uint64_t;

/// What has changed from frame to frame of one builder, so that it can build only that again, even in a slot
/// that holds a frame of some builds ago.
class FrameChanges {
public:
    /// `reach`: pixels as far from one another as this, along x and y, may depend on each other.
    FrameChanges(int width, int height, int reach, VectorUnit unit);

    /// The next frame, which is compared with the one before, if that keeps its planes alive (`storage`):
    /// after one that does not everything is new.
    BuildNumber advance(const RawFrame& raw, RowBands& bands);

    /// Of a slot that holds build `held`: the blocks with a pixel that may be another one in the newest
    /// build. No set: any may, since nothing is known of that build. Until the next call of either.
    const BlockMap* stale_blocks(BuildNumber held);
    /// To be told where a frame was built as a whole though its blocks were known: the next few are not
    /// compared.
    void comparing_was_in_vain();
    /// Whether build `held` had the newest one's haptic and height planes.
    bool same_touch_planes(BuildNumber held) const;

private:
    /// From the build before to this one.
    struct Step {
        BuildNumber build = 0;
        bool all = true, touch_planes = true;  ///< may have changed
        BlockMap stale;
    };
    /// Those that followed a build; nothing where that is forgotten.
    std::optional<std::span<const Step>> steps_since(BuildNumber held) const;
    void compare_depth(const PlaneView& after, RowBands& bands, Step& step);

    const int reach_;
    const VectorUnit unit_;
    int rest_ = 0;               // frames that will not be compared
    RawFrame newest_;            // nothing where it does not keep its planes
    std::array<Step, 8> steps_;  // the newest last; more than there are slots
    BlockMap stale_;
    std::vector<PixelBox> boxes_;                     // of each block
    std::vector<std::vector<std::uint8_t>> columns_;  // work space of each thread
};

}  // namespace touchable
