// SPDX-License-Identifier: Apache-2.0
// Frames compared block by block.
#include "engine/surface/frame_changes.hpp"

#include <iterator>

namespace touchable {
namespace {

/// If a larger share of blocks has changed, the whole frame is built, and comparing ends.
constexpr double most_changed = 0.5;

/// Frames that are then not compared at all: a clip in which all is moving goes on for a while.
constexpr int frames_of_rest = 8;

/// Rows that are compared at a time.
constexpr int rows_at_once = 4;

/// A block's row without differences, of at most 3 channels or 2 bytes.
constexpr std::uint8_t nothing[3 * BlockGrid::width] = {};

/// Adds to `columns` the bits of every byte in which one of the rows differs.
template <class Lanes>
[[gnu::always_inline]] inline void add_bits(const std::uint8_t* const (&before)[rows_at_once],
                                            const std::uint8_t* const (&after)[rows_at_once], int bytes,
                                            std::uint8_t* columns) {
    constexpr int step = sizeof(Lanes);
    int n = 0;
    for (; n + step <= bytes; n += step) {
        Lanes sum;
        std::memcpy(&sum, columns + n, step);
        for (int k = 0; k < rows_at_once; ++k) {
            Lanes a, b;
            std::memcpy(&a, before[k] + n, step);
            std::memcpy(&b, after[k] + n, step);
            sum |= a ^ b;
        }
        std::memcpy(columns + n, &sum, step);
    }
    for (; n < bytes; ++n)
        for (int k = 0; k < rows_at_once; ++k)
            columns[n] = static_cast<std::uint8_t>(columns[n] | (before[k][n] ^ after[k][n]));
}

int bytes_of_pixel(const PlaneView& plane) {
    return plane.channels * plane.bytes_per_sample;
}

}  // namespace

int FrameChanges::StaleBlocks::count() const {
    return static_cast<int>(
        std::ranges::count_if(*changed_, [this](std::uint64_t frame) { return frame > since_; }));
}

BlockGrid::Run FrameChanges::StaleBlocks::next_run(int first_row, int last_row, int from) const {
    const auto any = [&](int x) {
        for (int y = first_row; y < last_row; ++y)
            if (contains(x, y)) return true;
        return false;
    };
    int first = from;
    while (first < grid_.columns && !any(first)) ++first;
    int last = first;
    while (last < grid_.columns && any(last)) ++last;
    return {first, last};
}

FrameChanges::FrameChanges(int width, int height, int reach, VectorUnit unit)
    : builder_(new_content_number()),
      reach_(reach),
      unit_(unit),
      grid_(BlockGrid::of(width, height)),
      changed_(grid_.count()) {}

BuildNumber FrameChanges::advance(const RawFrame& raw, RowBands& bands) {
    ++frame_;
    const bool knows = !newest_.depth.empty();
    const bool compares = rest_ == 0 && knows && same_form(newest_.depth, raw.depth);
    rest_ = std::max(rest_ - 1, 0);
    if (!compares || !compare_depth(raw.depth, bands)) {
        all_ = frame_;
        if (compares) comparing_was_in_vain();
    }
    if (!knows || !same_samples(newest_.haptic, raw.haptic) || !same_samples(newest_.height, raw.height))
        touch_planes_ = frame_;
    newest_ = raw.storage ? raw : RawFrame{};
    return {builder_, frame_};
}

void FrameChanges::comparing_was_in_vain() {
    rest_ = frames_of_rest;
}

/// False if too much has changed.
bool FrameChanges::compare_depth(const PlaneView& after, RowBands& bands) {
    const int most = static_cast<int>(most_changed * static_cast<double>(grid_.count()));
    std::atomic<int> changed = 0;
    columns_.resize(static_cast<std::size_t>(bands.threads()));
    bands.for_each_band(grid_.rows, 1, [&](const RowBand& band) {
        for (int row = band.first; row < band.last && changed <= most; ++row)
            changed += compare_row(after, row, columns_[static_cast<std::size_t>(band.thread)]);
    });
    return changed <= most;
}

/// Marks all blocks within reach of the changes in a row of blocks; returns how many of the row have changes.
int FrameChanges::compare_row(const PlaneView& after, int row, std::vector<std::uint8_t>& columns) {
    const int top = row * BlockGrid::height, bottom = std::min(top + BlockGrid::height, after.height);
    const int pixel_bytes = bytes_of_pixel(after);
    add_differences(after, top, bottom, columns);
    int changed = 0;
    for (int x = 0; x < after.width; x += BlockGrid::width) {
        const int offset = x * pixel_bytes, bytes = std::min(BlockGrid::width, after.width - x) * pixel_bytes;
        const std::uint8_t *begin = columns.data() + offset, *end = begin + bytes;
        if (std::memcmp(begin, nothing, static_cast<std::size_t>(bytes)) == 0) continue;
        const auto differs = [](std::uint8_t bits) { return bits != 0; };
        const auto same = [&](int y) {
            return std::memcmp(newest_.depth.row(y) + offset, after.row(y) + offset,
                               static_cast<std::size_t>(bytes)) == 0;
        };
        const auto first = std::find_if(begin, end, differs) - begin;
        const auto last =
            std::find_if(std::reverse_iterator(end), std::reverse_iterator(begin), differs).base() - begin;
        PixelBox box{x + static_cast<int>(first) / pixel_bytes, top,
                     x + static_cast<int>(last - 1) / pixel_bytes + 1, bottom};
        while (same(box.top)) ++box.top;
        while (same(box.bottom - 1)) --box.bottom;
        mark(box);
        ++changed;
    }
    return changed;
}

void FrameChanges::add_differences(const PlaneView& after, int top, int bottom,
                                   std::vector<std::uint8_t>& columns) const {
    const int bytes = after.width * bytes_of_pixel(after);
    columns.assign(static_cast<std::size_t>(bytes), 0);
    for (int y = top; y < bottom; y += rows_at_once) {
        const std::uint8_t *a[rows_at_once], *b[rows_at_once];
        for (int k = 0; k < rows_at_once; ++k) {
            a[k] = newest_.depth.row(std::min(y + k, bottom - 1));
            b[k] = after.row(std::min(y + k, bottom - 1));
        }
        run_vectors(
            unit_, [&](auto kind) __attribute__((always_inline)) {
                add_bits<typename decltype(kind)::type>(a, b, bytes, columns.data());
            });
    }
}

/// Marks every block within reach of the box; other threads may mark those of adjacent rows at the same time.
void FrameChanges::mark(const PixelBox& changed) {
    const int left = std::max(changed.left - reach_, 0) / BlockGrid::width;
    const int top = std::max(changed.top - reach_, 0) / BlockGrid::height;
    const int right = std::min((changed.right + reach_ - 1) / BlockGrid::width + 1, grid_.columns);
    const int bottom = std::min((changed.bottom + reach_ - 1) / BlockGrid::height + 1, grid_.rows);
    for (int y = top; y < bottom; ++y)
        for (int x = left; x < right; ++x)
            std::atomic_ref(changed_[grid_.index(x, y)]).store(frame_, std::memory_order_relaxed);
}

std::optional<FrameChanges::StaleBlocks> FrameChanges::stale_blocks(const BuildNumber& held) const {
    if (held.builder != builder_ || held.frame < all_) return std::nullopt;
    return StaleBlocks(grid_, changed_, held.frame);
}

}  // namespace touchable
