// SPDX-License-Identifier: Apache-2.0
// The paper's builder: filters a pixel when it is read.
#include <algorithm>
#include <array>
#include <atomic>
#include <cassert>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "engine/base/try.hpp"
#include "engine/scene/frames.hpp"
#include "engine/surface/flying_pixels.hpp"
#include "engine/surface/median.hpp"
#include "engine/surface/surface_builder.hpp"
#include "engine/surface/terrace_filter.hpp"

namespace touchable {
namespace {

constexpr int largest_radius = 2, most_passes = 16;
constexpr int largest_side = 2 * (largest_radius + most_passes) + 1;

/// The stored code of a pixel, pulled in if it flies; `flying` null: as stored.
std::uint16_t landed_code(const PlaneView& depth, const DepthCoding& coding, const FlyingPixels* flying,
                          int x, int y) {
    const std::uint16_t stored = stored_code(depth, coding, x, y);
    if (!flying || !coding.is_valid(stored)) return stored;
    const auto at = [&](int dx, int dy) {
        if (x + dx < 0 || x + dx >= depth.width || y + dy < 0 || y + dy >= depth.height) return -1;
        const std::uint16_t code = stored_code(depth, coding, x + dx, y + dy);
        return coding.is_valid(code) ? int{code} : -1;
    };
    return landed(at, flying->gate_at(stored));
}

/// The pixels around one, on which its filtered value depends; on the stack.
class Neighbourhood {
public:
    Neighbourhood(const SurfaceFrame& frame, const DepthCoding& coding, const FlyingPixels* flying, int x,
                  int y)
        : frame_(frame), coding_(coding), flying_(flying), x_(x), y_(y) {}

    /// Decodes the pixels at most `reach` away. False if one of them is invalid.
    bool load(int reach) {
        span(reach, left_, top_, right_, bottom_);
        bool all_valid = true;
        for (int y = top_; y <= bottom_; ++y)
            for (int x = left_; x <= right_; ++x) {
                const std::uint16_t code = landed_code(frame_.raw.depth, coding_, flying_, x, y);
                const bool valid = coding_.is_valid(code);
                codes_[index(x, y)] = code;
                valid_since_[index(x, y)] = valid ? 0 : never;
                all_valid &= valid;
            }
        return all_valid;
    }

    /// Passes of hole filling over loaded pixels; right up to `reach` away if reach + passes are loaded.
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

    /// Median of the valid codes at most `radius` from the centre, which is valid.
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
    const DepthCoding& coding_;
    const FlyingPixels* flying_;
    int x_, y_;
    int left_ = 0, top_ = 0, right_ = 0, bottom_ = 0;  // the loaded area
    std::uint16_t codes_[largest_side * largest_side];
    std::uint8_t valid_since_[largest_side * largest_side];  // the pass that made it valid; 0: as stored
};

/// Extends the range by a row's samples from `x` on.
template <class Sample>
void bound_samples(const std::uint8_t* row, int x, int count, std::uint16_t& least, std::uint16_t& greatest) {
    for (int n = x; n < x + count; ++n) {
        Sample sample;
        std::memcpy(&sample, row + static_cast<std::size_t>(n) * sizeof(Sample), sizeof(Sample));
        least = std::min<std::uint16_t>(least, sample);
        greatest = std::max<std::uint16_t>(greatest, sample);
    }
}

/// Bounds of a rectangle, ends included, whose pixels are all valid; otherwise nothing. For stored values
/// that are codes.
std::optional<TileBounds> bounds_of_clean_area(const PlaneView& depth, const DepthCoding& coding, int left,
                                               int top, int right, int bottom) {
    TileBounds bounds;
    for (int y = top; y <= bottom; ++y)
        (depth.bytes_per_sample == 2 ? bound_samples<std::uint16_t>
                                     : bound_samples<std::uint8_t>)(depth.row(y), left, right - left + 1,
                                                                    bounds.least, bounds.greatest);
    if (!coding.all_valid(bounds.least, bounds.greatest)) return std::nullopt;
    return bounds;
}

/// Median of a window inside the picture whose pixels are all valid, the most frequent case; otherwise
/// nothing. For stored values that are codes.
template <int Side>
std::optional<std::uint16_t> median_of_clean_window(const PlaneView& depth, const DepthCoding& coding, int x,
                                                    int y) {
    const int left = x - Side / 2, top = y - Side / 2;
    if (left < 0 || top < 0 || left + Side > depth.width || top + Side > depth.height) return std::nullopt;
    std::uint16_t columns[Side][Side];
    std::uint16_t least = 65535, greatest = 0;
    for (int column = 0; column < Side; ++column) {
        std::uint16_t(&codes)[Side] = columns[column];
        for (int row = 0; row < Side; ++row) codes[row] = depth.sample(left + column, top + row);
        sort_column(codes);
        least = lesser(least, codes[0]);
        greatest = greater(greatest, codes[Side - 1]);
    }
    if (!coding.all_valid(least, greatest)) return std::nullopt;
    return median_of_columns(columns);
}

std::uint64_t packed(const TileBounds& bounds) {
    constexpr std::uint64_t computed = 1;
    return computed | std::uint64_t{bounds.any_invalid} << 1 | std::uint64_t{bounds.least} << 16 |
           std::uint64_t{bounds.greatest} << 32;
}

/// Makes `count` words of zero.
template <class T>
void restart_all(std::vector<std::atomic<T>>& words, std::size_t count) {
    if (words.size() != count) words = std::vector<std::atomic<T>>(count);
    for (auto& word : words) word.store(T{}, std::memory_order_relaxed);
}

/// Larger than every finer code.
constexpr std::uint16_t no_code = 0xFFFF;
static_assert(no_code > 2 * terrace_range);

TileBounds unpacked(std::uint64_t word) {
    return {static_cast<std::uint16_t>(word >> 16), static_cast<std::uint16_t>(word >> 32),
            ((word >> 1) & 1) != 0};
}

static_assert(std::atomic<std::uint64_t>::is_always_lock_free);
static_assert(std::atomic<std::uint16_t>::is_always_lock_free && std::atomic<bool>::is_always_lock_free);

static_assert(std::variant_size_v<FilterPlan::Filter> == 5,
              "a new filter has to be done here too, or refused");

/// Filters a pixel of `frame.raw.depth` when it is read: the same depth and validity as a filtered frame, at
/// the cost of the pixels that are touched. Terraces are removed from blocks of pixels (terrace_block), each
/// when one of it is first read. Any number of readers.
class LazyVertices final : public VertexSource {
public:
    /// `frame` must outlive it. No filter may depend on earlier frames.
    LazyVertices(const SurfaceFrame& frame, const FilterPlan& plan)
        : frame_(frame),
          plan_(plan),
          stored_(plan_.stored),
          flying_(plan_.find<FlyingPixels>()),
          passes_(plan_.find<FilterPlan::HoleFilling>() ? plan_.find<FilterPlan::HoleFilling>()->passes : 0),
          radius_(plan_.find<FilterPlan::MedianWindow>() ? plan_.find<FilterPlan::MedianWindow>()->side / 2
                                                         : 0),
          terraces_(plan_.find<TerraceFilter>()) {
        assert(!plan_.remembers() && passes_ <= most_passes && radius_ <= largest_radius);
        restart();
    }
    /// To be called when the frame has got another raw plane, before it is read.
    void restart() {
        const TileGrid grid = TileGrid::of(frame_.width, frame_.height);
        restart_all(tiles_, grid.count());
        for (auto& word : recent_) word.store(0, std::memory_order_relaxed);
        if (!terraces_) return;
        block_ = terrace_block(terraces_->reach);
        blocks_x_ = (frame_.width + block_ - 1) / block_;
        const int blocks_y = (frame_.height + block_ - 1) / block_;
        restart_all(blocks_, pixel_count(blocks_x_, blocks_y));
        const std::size_t pixels = frame_.index(0, frame_.height);
        if (finer_.size() != pixels) finer_ = std::vector<std::atomic<std::uint16_t>>(pixels);
    }

    /// Whether frames are filtered by this plan.
    bool serves(const FilterPlan& plan) const { return plan_ == plan; }

    DepthSample at(int x, int y) const override {
        const std::optional<std::uint16_t> code = terraces_ ? finer_code(x, y) : recent_code(x, y);
        if (!code) return {};
        return {frame_.coding.depth(*code), true};
    }

    /// Bounds of the raw codes of the tile and the filters' reach around it: wider than the filtered codes'.
    TileDepths tile(int tx, int ty) const override {
        const TileGrid grid = TileGrid::of(frame_.width, frame_.height);
        auto& kept = tiles_[pixel_place(tx, ty, grid.tiles_x)];
        // Relaxed: the word is the whole result, and two readers that compute it at once compute the same.
        std::uint64_t word = kept.load(std::memory_order_relaxed);
        if (word == 0) {
            const TileBounds bounds = raw_bounds(tx, ty);
            word = packed(terraces_ ? finer_bounds(bounds) : bounds);
            kept.store(word, std::memory_order_relaxed);
        }
        return depths_of(unpacked(word), frame_.coding);
    }

private:
    /// The code before terrace removal (finer_code: after it); nothing: invalid.
    std::optional<std::uint16_t> filtered_code(int x, int y) const {
        const std::uint16_t stored = landed_code(frame_.raw.depth, stored_, flying_, x, y);
        const bool stored_valid = stored_.is_valid(stored);
        if (!stored_valid && passes_ == 0) return std::nullopt;
        if (stored_valid && radius_ == 0) return stored;
        if (stored_valid && stored_.kind != DepthCodingKind::hue && !flying_) {
            const auto median = radius_ == 1 ? median_of_clean_window<3>(frame_.raw.depth, stored_, x, y)
                                             : median_of_clean_window<5>(frame_.raw.depth, stored_, x, y);
            if (median) return median;
        }
        Neighbourhood around(frame_, stored_, flying_, x, y);
        if (!around.load(radius_) && passes_ > 0) {
            around.load(radius_ + passes_);
            around.fill_holes(passes_, radius_);
        }
        if (!around.valid(x, y)) return std::nullopt;
        return around.median(radius_);
    }

    /// `filtered_code`, cached if it takes work.
    std::optional<std::uint16_t> recent_code(int x, int y) const {
        if (radius_ == 0 && passes_ == 0 && !flying_) return filtered_code(x, y);
        constexpr std::uint64_t is_valid = 1U << 16;
        const std::uint64_t place = (static_cast<std::uint64_t>(y) + 1) << 40 | static_cast<std::uint64_t>(x)
                                                                                    << 17;
        auto& kept = recent_[static_cast<std::size_t>(y % recent_side * recent_side + x % recent_side)];
        std::uint64_t word = kept.load(std::memory_order_relaxed);
        if (word >> 17 != place >> 17) {
            const auto code = filtered_code(x, y);
            word = place | (code ? is_valid | *code : 0);
            kept.store(word, std::memory_order_relaxed);
        }
        if ((word & is_valid) == 0) return std::nullopt;
        return static_cast<std::uint16_t>(word);
    }

    std::optional<std::uint16_t> finer_code(int x, int y) const {
        const int bx = x / block_, by = y / block_;
        auto& levelled = blocks_[pixel_place(bx, by, blocks_x_)];
        // Two readers that level a block at once write the same.
        if (!levelled.load(std::memory_order_acquire)) {
            level_block(bx, by);
            levelled.store(true, std::memory_order_release);
        }
        const std::uint16_t code = finer_[frame_.index(x, y)].load(std::memory_order_relaxed);
        if (code == no_code) return std::nullopt;
        return code;
    }

    void level_block(int bx, int by) const {
        switch (terraces_->reach) {
            case 128:
                return level_block_within<128>(bx, by);
            case 64:
                return level_block_within<64>(bx, by);
            case 32:
                return level_block_within<32>(bx, by);
            default:
                return level_block_within<16>(bx, by);
        }
    }

    /// Not inlined, so that the stack holds only a patch of this reach.
    template <int reach>
    [[gnu::noinline]] void level_block_within(int bx, int by) const {
        TerracePatch<reach> patch(frame_.width, frame_.height, bx, by);
        for (int y = patch.top(); y <= patch.bottom(); ++y)
            for (int x = patch.left(); x <= patch.right(); ++x)
                if (const auto code = filtered_code(x, y)) patch.set(x, y, *code, *terraces_);
        patch.level(*terraces_);
        const int right = std::min((bx + 1) * block_, frame_.width);
        const int bottom = std::min((by + 1) * block_, frame_.height);
        for (int y = by * block_; y < bottom; ++y)
            for (int x = bx * block_; x < right; ++x)
                finer_[frame_.index(x, y)].store(patch.is_set(x, y) ? patch.code(x, y) : no_code,
                                                 std::memory_order_relaxed);
    }

    // A landed pixel, a median and a filled hole are codes of pixels within reach, so no filtered code of the
    // tile is missed. Filling may leave fewer invalid pixels than are stored, never more.
    TileBounds raw_bounds(int tx, int ty) const {
        const int reach = radius_ + passes_ + (flying_ ? flying_reach : 0);
        const int left = tx * TileGrid::cells, right = std::min(left + TileGrid::cells, frame_.width - 1);
        const int top = ty * TileGrid::cells, bottom = std::min(top + TileGrid::cells, frame_.height - 1);
        const int from_x = std::max(left - reach, 0), to_x = std::min(right + reach, frame_.width - 1);
        const int from_y = std::max(top - reach, 0), to_y = std::min(bottom + reach, frame_.height - 1);
        if (stored_.kind != DepthCodingKind::hue)
            if (const auto clean =
                    bounds_of_clean_area(frame_.raw.depth, stored_, from_x, from_y, to_x, to_y))
                return *clean;
        TileBounds bounds;
        for (int y = from_y; y <= to_y; ++y)
            for (int x = from_x; x <= to_x; ++x) {
                const std::uint16_t code = stored_code(frame_.raw.depth, stored_, x, y);
                if (stored_.is_valid(code)) {
                    bounds.least = std::min(bounds.least, code);
                    bounds.greatest = std::max(bounds.greatest, code);
                } else if (x >= left && x <= right && y >= top && y <= bottom) {
                    bounds.any_invalid = true;
                }
            }
        return bounds;
    }

    // No finer code is farther than `most` from its stored one, nor beyond the finer ones of valid codes.
    TileBounds finer_bounds(const TileBounds& stored) const {
        if (stored.least > stored.greatest) return stored;
        const WorkingCodes& working = terraces_->working;
        // Levels grow towards one end or the other.
        const int most = std::max(terraces_->most_at(working.of(stored.least)),
                                  terraces_->most_at(working.of(stored.greatest)));
        const int least = 2 * (working.of(stored.least) - most);
        const int greatest = 2 * (working.of(stored.greatest) + most);
        return {static_cast<std::uint16_t>(std::max<int>(least, terraces_->coding.valid_min)),
                static_cast<std::uint16_t>(std::min<int>(greatest, terraces_->coding.valid_max)),
                stored.any_invalid};
    }

    const SurfaceFrame& frame_;
    const FilterPlan plan_;
    const DepthCoding& stored_;
    const FlyingPixels* flying_;     // null: no filter
    const int passes_, radius_;      // of hole filling; of the median
    const TerraceFilter* terraces_;  // null: no filter
    // Bounds of a tile, packed into one word so that readers never see half of them; 0: not yet computed.
    mutable std::vector<std::atomic<std::uint64_t>> tiles_;
    // A cache of filtered codes, one for each place of a square that repeats over the picture, packed in the
    // same way with the pixel's position: a finger reads the same few again and again.
    static constexpr int recent_side = 32;
    mutable std::array<std::atomic<std::uint64_t>, recent_side * recent_side> recent_{};
    // With terrace removal: which blocks are done, and their codes.
    int block_ = 0, blocks_x_ = 0;
    mutable std::vector<std::atomic<bool>> blocks_;
    mutable std::vector<std::atomic<std::uint16_t>> finer_;
};

class LazyBuilder final : public SurfaceBuilder {
public:
    explicit LazyBuilder(const Scene& scene) : scene_(scene), plan_(scene) {}
    std::string_view name() const override { return "lazy"; }
    double built_share() const override { return 0; }

    Result<void> build(const RawFrame& raw, SurfaceFrame& out) override {
        if (plan_.remembers())
            return input_error(
                "the lazy builder cannot filter in time (filter.temporal is on), because it has no history "
                "of pixels that were not touched; must be another builder");
        TRY(check_raw_frame(raw, scene_));
        out.width = scene_.width;
        out.height = scene_.height;
        out.coding = plan_.coding();
        out.codes.clear();
        out.validity.clear();
        out.tiles.clear();
        copy_touch_planes(raw, out);
        out.filled = raw.filled;
        out.raw = raw;
        auto* vertices = dynamic_cast<LazyVertices*>(out.vertices.get());
        if (vertices != nullptr && vertices->serves(plan_))
            vertices->restart();
        else
            out.vertices = std::make_unique<LazyVertices>(out, plan_);
        return {};
    }

private:
    const Scene scene_;
    const FilterPlan plan_;
};

}  // namespace

std::unique_ptr<SurfaceBuilder> make_lazy_builder(const Scene& scene) {
    return std::make_unique<LazyBuilder>(scene);
}

}  // namespace touchable
