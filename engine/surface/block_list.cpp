#include "engine/surface/block_list.hpp"

#include <algorithm>
#include <utility>

#include "shaders/surface_codes.h"

namespace touchable {
namespace {

/// They are compared within about 50 us.
constexpr long pixels_compared_per_thread = 800'000;

}  // namespace

Result<BlockList> BlockList::create(const GpuDevice& device, int width, int height, std::optional<int> reach,
                                    double most, int run) {
    BlockList list;
    const BlockGrid grid = BlockGrid::of(width, height);
    const auto blocks = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
    auto buffer =
        GpuBuffer::create(device, "blocks to build", blocks * sizeof(ListedBlocks), GpuMemory::upload);
    if (!buffer.ok()) return buffer.error();
    list.buffer_ = *buffer;
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

void BlockList::advance(const RawFrame& raw, BuildNumber held) {
    const bool was_done = std::exchange(done_, false);
    all_ = true;
    share_ = 1;
    count_ = 0;
    rows_ = {0, height_};
    if (!changes_) return;
    newest_ = changes_->advance(raw, *bands_);
    const BlockMap* stale = was_done ? changes_->stale_blocks(held) : nullptr;
    if (stale == nullptr) return;
    const BlockGrid& grid = stale->grid();
    const double share = static_cast<double>(stale->count()) / (grid.columns * grid.rows);
    if (share > most_) return changes_->comparing_was_in_vain();
    all_ = false;
    share_ = share;
    list(*stale);
}

void BlockList::list(const BlockMap& stale) {
    const BlockGrid& grid = stale.grid();
    const auto listed = buffer_.mapped<ListedBlocks>();
    int first = grid.rows, last = 0;
    for (int row = 0; row < grid.rows; ++row) {
        BlockRun run;
        while (!(run = stale.next_run(row, row + 1, run.last)).empty()) {
            run.last = std::min(run.last, run.first + run_);
            listed[count_++] = {static_cast<std::uint32_t>(row * grid.columns + run.first),
                                static_cast<std::uint32_t>(run.last - run.first)};
            first = std::min(first, row);
            last = row + 1;
        }
    }
    rows_ = {static_cast<std::uint32_t>(std::min(first, last) * BlockGrid::height),
             std::min(static_cast<std::uint32_t>(last * BlockGrid::height), height_)};
}

}  // namespace touchable
