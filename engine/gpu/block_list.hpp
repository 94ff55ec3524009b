#pragma once

#include <memory>
#include <optional>

#include "engine/gpu/gpu_commands.hpp"
#include "engine/surface/frame_changes.hpp"

namespace touchable {

/// Rows [first, last).
struct RowRange {
    std::uint32_t first = 0, last = 0;
    std::uint32_t count() const { return last - first; }
};

/// What the kernels of one builder have to build of its next frame: all of it, or a list of blocks. What they
/// leave in memory that is not a slot's holds the newest frame.
class BlockList {
public:
    /// `reach`: of the filters; nothing: each frame is built as a whole, as it is where more than the share
    /// `most` of all blocks would be listed. At most `run` neighbours are listed as one.
    static Result<BlockList> create(const GpuDevice& device, int width, int height, std::optional<int> reach,
                                    double most, int run);

    /// To be called first of each frame, with what its slot holds; gives what it is going to hold.
    BuildNumber advance(const RawFrame& raw, const BuildNumber& held);
    /// To be called when the frame is built. Without that the next one is built as a whole.
    void done() { done_ = true; }

    std::uint32_t count() const { return count_; }  ///< of runs; 0 too where all are to be built
    bool same_touch_planes(const BuildNumber& held) const {
        return changes_ && changes_->same_touch_planes(held);
    }
    /// Of pixels, that the blocks lie in; none where nothing has changed.
    const RowRange& rows() const { return rows_; }
    double share() const { return share_; }  ///< of all blocks that are to be built
    /// The runs, as ListedBlocks.
    const GpuBuffer& buffer() const { return buffer_; }

private:
    void list(const StaleBlocks& stale);

    std::uint32_t height_ = 0;
    double most_ = 0, share_ = 1;
    int run_ = 1;
    std::unique_ptr<FrameChanges> changes_;
    std::unique_ptr<RowBands> bands_;
    GpuBuffer buffer_;
    bool done_ = false;
    std::uint32_t count_ = 0;
    RowRange rows_;
};

}  // namespace touchable
