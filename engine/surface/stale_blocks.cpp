#include "engine/surface/stale_blocks.hpp"

#include <algorithm>

namespace touchable {

int StaleBlocks::count() const {
    return static_cast<int>(std::count_if(changed_->begin(), changed_->end(),
                                          [this](std::uint64_t frame) { return frame > since_; }));
}

BlockRun StaleBlocks::next_run(int first_row, int last_row, int from) const {
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
