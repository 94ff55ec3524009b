// SPDX-License-Identifier: Apache-2.0
#include "engine/scene/frames.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "engine/base/same_bits.hpp"

namespace touchable {

namespace {

/// The bounds of no pixel: the first depth or tile replaces them.
constexpr TileDepths no_depths{std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity(), false};

void copy_codes(const PlaneView& plane, std::vector<std::uint16_t>& out) {
    const auto width = static_cast<std::size_t>(plane.width);
    out.resize(width * static_cast<std::size_t>(plane.height));
    for (int y = 0; y < plane.height; ++y) {
        const std::uint8_t* from = plane.row(y);
        std::uint16_t* to = out.data() + width * static_cast<std::size_t>(y);
        if (plane.bytes_per_sample == 2)
            std::memcpy(to, from, width * 2);
        else
            for (std::size_t x = 0; x < width; ++x) to[x] = from[x];
    }
}

}  // namespace

std::uint64_t new_content_number() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

bool same_form(const PlaneView& a, const PlaneView& b) {
    if (a.empty() || b.empty()) return a.empty() && b.empty();
    return a.width == b.width && a.height == b.height && a.bytes_per_sample == b.bytes_per_sample &&
           a.channels == b.channels;
}

bool same_samples(const PlaneView& a, const PlaneView& b) {
    if (!same_form(a, b)) return false;
    if (a.empty() || (a.data == b.data && a.stride == b.stride)) return true;
    for (int y = 0; y < a.height; ++y)
        if (std::memcmp(a.row(y), b.row(y), a.row_bytes()) != 0) return false;
    return true;
}

bool same_touch_planes(const RawFrame& a, const RawFrame& b) {
    return same_samples(a.depth, b.depth) && same_samples(a.haptic, b.haptic) &&
           same_samples(a.height, b.height);
}

TileDepths depths_of(const TileBounds& bounds, const DepthCoding& coding) {
    TileDepths depths = no_depths;
    depths.any_invalid = bounds.any_invalid;
    if (bounds.least > bounds.greatest) return depths;
    // Depth is monotone in the code, in floating point too, so the extreme codes enclose the rest.
    depths.nearest = coding.depth(bounds.least);
    depths.farthest = coding.depth(bounds.greatest);
    if (!coding.deeper_is_higher()) std::swap(depths.nearest, depths.farthest);
    return depths;
}

const ErrorSigns::Squares ErrorSigns::weights{{2.06, 26, 18.2, 0.42}, {0.0113, 5.7, 6.37, 0.88}};

std::vector<float> metres_of_codes(const DepthCoding& coding, double metres_per_unit) {
    std::vector<float> metres(std::size_t{1} << 16, std::numeric_limits<float>::quiet_NaN());
    for (std::size_t code = 0; code < metres.size(); ++code)
        if (const auto stored = static_cast<std::uint16_t>(code); coding.is_valid(stored))
            metres[code] = static_cast<float>(coding.depth(stored) * metres_per_unit);
    return metres;
}

const ErrorSigns::Block* ErrorSigns::block_at(double x, double y) const {
    if (blocks.empty() || std::isnan(x) || std::isnan(y)) return nullptr;
    const auto nearest = [](double place, int count) {
        return static_cast<int>(std::clamp((place + 0.5) / side, 0.0, count - 1.0));
    };
    const int rows = static_cast<int>(blocks.size()) / columns;
    return &blocks[pixel_place(nearest(x, columns), nearest(y, rows), columns)];
}

std::optional<ErrorSigns::Squares> ErrorSigns::squares(const Block& at) const {
    if (!(at.depth > 0)) return {};
    constexpr double degrees = 180 / pi, wide = 25;
    const double depth = at.depth, scatter = at.scatter, pixel = depth / focal_length;
    const double bent = degrees * bend * at.turn, bump = bend * wide, rough = side * pixel;
    const double drifts = drift * depth;
    return Squares{
        {degrees * degrees * scatter, degrees * at.lean * bent, bent * bent * std::sqrt(std::sqrt(bent)), 1},
        {pixel * pixel, drifts * drifts, bump * bump * std::sqrt(bump / pixel), scatter * rough * rough}};
}

ErrorBar ErrorSigns::bar(const Block& block) const {
    const auto there = squares(block);
    if (!there) return {};
    const auto root = [](const std::array<double, 4>& terms, const std::array<double, 4>& weight) {
        return std::sqrt(std::inner_product(terms.begin(), terms.end(), weight.begin(), 0.0));
    };
    // No direction errs by more than half a turn, no depth by more than all of it.
    return {std::min(root(there->angle, weights.angle), 180.0),
            std::min(root(there->depth, weights.depth), double{block.depth})};
}

ErrorBar ErrorSigns::bar_at(double x, double y) const {
    const Block* const block = block_at(x, y);
    return block ? bar(*block) : ErrorBar();
}

DepthSample FilteredVertices::at(int x, int y) const {
    return sample_of(frame_, x, y);
}

TileDepths FilteredVertices::tile(int tx, int ty) const {
    const TileGrid grid = TileGrid::of(frame_.width, frame_.height);
    const TileBounds& bounds = frame_.tiles[pixel_place(tx, ty, grid.tiles_x)];
    return depths_of(bounds, frame_.coding);
}

ExactVertices::ExactVertices(int width, int height, std::vector<double> depths)
    : width_(std::max(width, 0)), height_(std::max(height, 0)), depths_(std::move(depths)) {
    depths_.resize(pixel_count(width_, height_), std::numeric_limits<double>::quiet_NaN());
    const TileGrid grid = TileGrid::of(width_, height_);
    tiles_.reserve(grid.count());
    for (int ty = 0; ty < grid.tiles_y; ++ty)
        for (int tx = 0; tx < grid.tiles_x; ++tx) tiles_.push_back(bound(tx, ty));
}

TileDepths ExactVertices::bound(int tx, int ty) const {
    const int x0 = tx * TileGrid::cells, x1 = std::min(x0 + TileGrid::cells, width_ - 1);
    const int y0 = ty * TileGrid::cells, y1 = std::min(y0 + TileGrid::cells, height_ - 1);
    TileDepths depths = no_depths;
    for (int y = y0; y <= y1; ++y)
        for (int x = x0; x <= x1; ++x) {
            const DepthSample sample = at(x, y);
            if (!sample.valid) {
                depths.any_invalid = true;
                continue;
            }
            depths.nearest = std::min(depths.nearest, sample.depth);
            depths.farthest = std::max(depths.farthest, sample.depth);
        }
    return depths;
}

DepthSample ExactVertices::at(int x, int y) const {
    const double depth = depths_[pixel_place(x, y, width_)];
    return {depth, std::isfinite(depth)};
}

TileDepths ExactVertices::tile(int tx, int ty) const {
    const TileGrid grid = TileGrid::of(width_, height_);
    return tiles_[pixel_place(tx, ty, grid.tiles_x)];
}

bool has_size(const SurfaceFrame& frame, int width, int height) {
    if (frame.width != width || frame.height != height || !frame.vertices) return false;
    const std::size_t pixels = pixel_count(width, height);
    return (frame.haptic.empty() || frame.haptic.size() == 3 * pixels) &&
           (frame.heights.empty() || frame.heights.size() == pixels);
}

void copy_touch_planes(const RawFrame& raw, SurfaceFrame& out) {
    // Not cleared first: a resize to the same size fills nothing with zeros.
    if (raw.haptic.empty()) {
        out.haptic.clear();
    } else {
        assert(raw.haptic.channels == 3 && raw.haptic.bytes_per_sample == 1);
        out.haptic.resize(3 * pixel_count(raw.haptic.width, raw.haptic.height));
        raw.haptic.copy_rows(out.haptic.data(), raw.haptic.row_bytes());
    }
    if (raw.height.empty()) {
        out.heights.clear();
    } else {
        assert(raw.height.channels == 1);
        copy_codes(raw.height, out.heights);
    }
}

}  // namespace touchable
