#include "engine/gpu/block_list.hpp"

#include <algorithm>
#include <utility>

#include "engine/base/try.hpp"
#include "shaders/surface_codes.h"

namespace touchable {
namespace {

/// They are compared within about 50 us.
constexpr long pixels_compared_per_thread = 800'000;

}  // namespace

Result<BlockList> BlockList::create(const GpuDevice& device, int width, int height, std::optional<int> reach,
                                    double most, int run) {
    BlockList list;
    TRY_ASSIGN(auto buffer, GpuBuffer::create(device, "blocks to build",
                                              BlockGrid::of(width, height).count() * sizeof(ListedBlocks),
                                              GpuMemory::upload));
    list.buffer_ = buffer;
    list.height_ = static_cast<std::uint32_t>(height);
    list.most_ = most;
    list.run_ = run;
    // A tile's bounds are those of its own blocks and of the pixels after them, to the right and below.
    if (reach) {
        list.changes_ =
            std::make_unique<FrameChanges>(width, height, *reach + 1, usable_vector_units().front());
        list.bands_ =
            std::make_unique<RowBands>(threads_for(long{width} * height, pixels_compared_per_thread));
    }
    return list;
}

BuildNumber BlockList::advance(const RawFrame& raw, const BuildNumber& held) {
    const bool was_done = std::exchange(done_, false);
    share_ = 1;
    count_ = 0;
    rows_ = {0, height_};
    if (!changes_) return {};
    const BuildNumber newest = changes_->advance(raw, *bands_);
    const auto stale = was_done ? changes_->stale_blocks(held) : std::nullopt;
    if (!stale) return newest;
    const double share = static_cast<double>(stale->count()) / static_cast<double>(stale->grid().count());
    if (share > most_) {
        changes_->comparing_was_in_vain();
    } else {
        share_ = share;
        list(*stale);
    }
    return newest;
}

void BlockList::list(const StaleBlocks& stale) {
    const BlockGrid grid = stale.grid();
    const auto listed = buffer_.mapped<ListedBlocks>();
    int first = grid.rows, last = 0;
    for (int row = 0; row < grid.rows; ++row) {
        BlockRun run;
        while (!(run = stale.next_run(row, row + 1, run.last)).empty()) {
            run.last = std::min(run.last, run.first + run_);
            listed[count_++] = {static_cast<std::uint32_t>(grid.index(run.first, row)),
                                static_cast<std::uint32_t>(run.last - run.first)};
            first = std::min(first, row);
            last = row + 1;
        }
    }
    rows_ = {static_cast<std::uint32_t>(std::min(first, last) * BlockGrid::height),
             std::min(static_cast<std::uint32_t>(last * BlockGrid::height), height_)};
}

}  // namespace touchable
