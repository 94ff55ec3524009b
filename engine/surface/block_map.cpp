#include "engine/surface/block_map.hpp"

#include <algorithm>
#include <cassert>

namespace touchable {

void BlockMap::clear() {
    std::fill(blocks_.begin(), blocks_.end(), std::uint8_t{0});
}

void BlockMap::add(const PixelBox& box) {
    if (box.empty() || box.right <= 0 || box.bottom <= 0) return;
    const int first = std::max(box.left, 0) / BlockGrid::width,
              top = std::max(box.top, 0) / BlockGrid::height;
    const int last = std::min((box.right - 1) / BlockGrid::width + 1, grid_.columns);
    const int bottom = std::min((box.bottom - 1) / BlockGrid::height + 1, grid_.rows);
    for (int y = top; y < bottom; ++y)
        for (int x = first; x < last; ++x) blocks_[static_cast<std::size_t>(y * grid_.columns + x)] = 1;
}

void BlockMap::add(const BlockMap& other) {
    assert(grid_ == other.grid_);
    for (std::size_t n = 0; n < blocks_.size(); ++n) blocks_[n] |= other.blocks_[n];
}

int BlockMap::count() const {
    return static_cast<int>(std::count(blocks_.begin(), blocks_.end(), std::uint8_t{1}));
}

BlockRun BlockMap::next_run(int first_row, int last_row, int from) const {
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

}  // namespace touchable
