#include "engine/surface/lazy_vertices.hpp"

#include <algorithm>
#include <cassert>

#include "engine/frame/stored_code.hpp"
#include "engine/surface/hole_filling.hpp"
#include "engine/surface/lower_median.hpp"

namespace touchable {
namespace {

constexpr int largest_radius = 2, most_passes = 16;
constexpr int largest_side = 2 * (largest_radius + most_passes) + 1;

/// The pixels around one that its filtered value depends on, on the stack.
class Neighbourhood {
public:
    Neighbourhood(const SurfaceFrame& frame, int x, int y) : frame_(frame), x_(x), y_(y) {}

    /// Decodes the pixels at most `reach` away. False where one of them is invalid.
    bool load(int reach) {
        span(reach, left_, top_, right_, bottom_);
        bool all_valid = true;
        for (int y = top_; y <= bottom_; ++y)
            for (int x = left_; x <= right_; ++x) {
                const std::uint16_t code = stored_code(frame_.raw.depth, frame_.coding, x, y);
                const bool valid = frame_.coding.is_valid(code);
                codes_[index(x, y)] = code;
                valid_since_[index(x, y)] = valid ? 0 : never;
                all_valid &= valid;
            }
        return all_valid;
    }

    /// Passes of hole filling over loaded pixels; right up to `reach` away where reach + passes are loaded.
    void fill_holes(int passes, int reach) {
        for (int pass = 1; pass <= passes; ++pass) {
            int left, top, right, bottom;
            span(reach + passes - pass, left, top, right, bottom);
            for (int y = top; y <= bottom; ++y)
                for (int x = left; x <= right; ++x)
                    if (!valid_before(pass, x, y)) fill_pixel(pass, x, y);
        }
    }

    bool valid(int x, int y) const { return valid_since_[index(x, y)] != never; }
    std::uint16_t code(int x, int y) const { return codes_[index(x, y)]; }

    /// Of the valid codes at most `radius` from the centre, which is valid.
    std::uint16_t median(int radius) const {
        std::uint16_t window[(2 * largest_radius + 1) * (2 * largest_radius + 1)];
        int count = 0;
        for (int dy = -radius; dy <= radius; ++dy)
            for (int dx = -radius; dx <= radius; ++dx) {
                const int x = std::clamp(x_ + dx, 0, frame_.width - 1);
                const int y = std::clamp(y_ + dy, 0, frame_.height - 1);
                if (valid(x, y)) window[count++] = code(x, y);
            }
        return lower_median(window, count);
    }

private:
    static constexpr std::uint8_t never = 255;

    void span(int reach, int& left, int& top, int& right, int& bottom) const {
        left = std::max(x_ - reach, 0), right = std::min(x_ + reach, frame_.width - 1);
        top = std::max(y_ - reach, 0), bottom = std::min(y_ + reach, frame_.height - 1);
    }
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>((y - top_) * largest_side + (x - left_));
    }
    bool valid_before(int pass, int x, int y) const { return valid_since_[index(x, y)] < pass; }

    void fill_pixel(int pass, int x, int y) {
        std::uint16_t neighbours[8];
        int count = 0;
        for (int ny = std::max(y - 1, top_); ny <= std::min(y + 1, bottom_); ++ny)
            for (int nx = std::max(x - 1, left_); nx <= std::min(x + 1, right_); ++nx)
                if (valid_before(pass, nx, ny)) neighbours[count++] = codes_[index(nx, ny)];
        if (count < neighbours_to_fill) return;
        codes_[index(x, y)] = lower_median(neighbours, count);
        valid_since_[index(x, y)] = static_cast<std::uint8_t>(pass);
    }

    const SurfaceFrame& frame_;
    int x_, y_;
    int left_ = 0, top_ = 0, right_ = 0, bottom_ = 0;  // what is loaded
    std::uint16_t codes_[largest_side * largest_side];
    std::uint8_t valid_since_[largest_side * largest_side];  // the pass that made it valid; 0: as stored
};

std::uint64_t packed(const TileBounds& bounds) {
    constexpr std::uint64_t computed = 1;
    return computed | std::uint64_t{bounds.any_invalid} << 1 | std::uint64_t{bounds.least} << 16 |
           std::uint64_t{bounds.greatest} << 32;
}

TileBounds unpacked(std::uint64_t word) {
    return {static_cast<std::uint16_t>(word >> 16), static_cast<std::uint16_t>(word >> 32),
            ((word >> 1) & 1) != 0};
}

}  // namespace

static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

LazyVertices::LazyVertices(const SurfaceFrame& frame, const FilterSettings& filter)
    : frame_(frame), filter_(filter) {
    assert(filter.median == 0 || filter.median == 3 || filter.median == 5);
    assert(filter.fill_holes >= 0 && filter.fill_holes <= most_passes);
    restart();
}

void LazyVertices::restart() {
    const TileGrid grid = TileGrid::of(frame_.width, frame_.height);
    const auto count = static_cast<std::size_t>(grid.tiles_x) * static_cast<std::size_t>(grid.tiles_y);
    if (tiles_.size() != count) {
        tiles_ = std::vector<std::atomic<std::uint64_t>>(count);
        return;
    }
    for (auto& tile : tiles_) tile.store(0, std::memory_order_relaxed);
}

DepthSample LazyVertices::at(int x, int y) const {
    const int radius = filter_.median / 2;
    const std::uint16_t stored = stored_code(frame_.raw.depth, frame_.coding, x, y);
    const bool stored_valid = frame_.coding.is_valid(stored);
    if (!stored_valid && filter_.fill_holes == 0) return {};
    if (stored_valid && radius == 0) return {frame_.coding.depth(stored), true};

    Neighbourhood around(frame_, x, y);
    if (!around.load(radius) && filter_.fill_holes > 0) {
        around.load(radius + filter_.fill_holes);
        around.fill_holes(filter_.fill_holes, radius);
    }
    if (!around.valid(x, y)) return {};
    return {frame_.coding.depth(around.median(radius)), true};
}

TileDepths LazyVertices::tile(int tx, int ty) const {
    const TileGrid grid = TileGrid::of(frame_.width, frame_.height);
    auto& kept = tiles_[static_cast<std::size_t>(ty) * static_cast<std::size_t>(grid.tiles_x) +
                        static_cast<std::size_t>(tx)];
    // Relaxed: the word is the whole answer, and two readers who compute it at once compute the same.
    std::uint64_t word = kept.load(std::memory_order_relaxed);
    if (word == 0) {
        word = packed(raw_bounds(tx, ty));
        kept.store(word, std::memory_order_relaxed);
    }
    return depths_of(unpacked(word), frame_.coding);
}

// A median and a filled hole are codes of pixels within reach, so no filtered code of the tile is missed.
// Filling may leave fewer invalid pixels than are stored, never more.
TileBounds LazyVertices::raw_bounds(int tx, int ty) const {
    const int reach = filter_.median / 2 + filter_.fill_holes;
    const int left = tx * TileGrid::cells, right = std::min(left + TileGrid::cells, frame_.width - 1);
    const int top = ty * TileGrid::cells, bottom = std::min(top + TileGrid::cells, frame_.height - 1);
    TileBounds bounds;
    for (int y = std::max(top - reach, 0); y <= std::min(bottom + reach, frame_.height - 1); ++y)
        for (int x = std::max(left - reach, 0); x <= std::min(right + reach, frame_.width - 1); ++x) {
            const std::uint16_t code = stored_code(frame_.raw.depth, frame_.coding, x, y);
            if (frame_.coding.is_valid(code)) {
                bounds.least = std::min(bounds.least, code);
                bounds.greatest = std::max(bounds.greatest, code);
            } else if (x >= left && x <= right && y >= top && y <= bottom) {
                bounds.any_invalid = true;
            }
        }
    return bounds;
}

}  // namespace touchable
