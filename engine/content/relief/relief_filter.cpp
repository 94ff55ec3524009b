#include "engine/content/relief/relief_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/surface/code_picture.hpp"

namespace touchable {
namespace {

constexpr int luma_per_level = 16;
/// Brightness of 255 at which shadow ends and highlight begins. From the first to the second, weights go
/// over.
constexpr int shadow_from = 6, shadow_to = 24, highlight_from = 238, highlight_to = 253;
/// Depths of neighbours that differ by more of them are two surfaces.
constexpr float step_share = 0.02F;
/// Colour bleeds so far over a step of depth, pixels.
constexpr int bleeding = 2;

/// BT.601, in sixteenths of a level.
std::int32_t luma(const std::uint8_t* rgb) {
    return (77 * rgb[0] + 150 * rgb[1] + 29 * rgb[2] + 8) / luma_per_level;
}

/// 0 up to `from`, 1 (most_weight) from `to` on, linear between.
std::int32_t ramp(std::int32_t value, std::int32_t from, std::int32_t to) {
    return std::clamp((value - from) * DifferenceOfGaussians::most_weight / (to - from), 0,
                      DifferenceOfGaussians::most_weight);
}

/// A hole is depth 0.
bool are_apart(float a, float b) {
    return std::fabs(a - b) > step_share * std::min(a, b);
}

}  // namespace

void ReliefFilter::read_luma(const PlaneView& colour) {
    if (luma_.width != colour.width || luma_.height != colour.height) {
        luma_ = NumberField(colour.width, colour.height);
        weights_ = relief_ = luma_;
        runs_ = SurfaceRuns(colour.width, colour.height);
    }
    for (int y = 0; y < colour.height; ++y) {
        const std::uint8_t* rgb = colour.row(y);
        std::int32_t *luma_row = luma_.row(y), *weight_row = weights_.row(y);
        for (int x = 0; x < colour.width; ++x, rgb += 3) {
            luma_row[x] = luma(rgb);
            weight_row[x] = std::min(
                ramp(luma_row[x], shadow_from * luma_per_level, shadow_to * luma_per_level),
                ramp(-luma_row[x], -highlight_to * luma_per_level, -highlight_from * luma_per_level));
        }
    }
}

/// Surfaces end at holes and steps of depth. What colour may have bled to over one counts for nothing.
void ReliefFilter::part_surfaces(const RawFrame& frame) {
    const CodePicture codes = code_picture(frame.depth, depth_);
    const int width = codes.width, height = codes.height;
    std::vector<float> depths(codes.codes.size());
    for (std::size_t k = 0; k < depths.size(); ++k)
        depths[k] = codes.codes[k] == CodePicture::invalid
                        ? 0.0F
                        : static_cast<float>(depth_.depth(static_cast<std::uint16_t>(codes.codes[k])));
    const auto place = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    };
    const auto forget = [&](int x, int y) {
        for (int row = std::max(0, y - bleeding); row <= std::min(height - 1, y + bleeding); ++row)
            std::fill(weights_.row(row) + std::max(0, x - bleeding),
                      weights_.row(row) + std::min(width - 1, x + bleeding) + 1, 0);
    };
    // A run goes on from pixel to pixel until one is of another surface; then it is known where it ends.
    const auto part = [&](std::vector<SurfaceRuns::Run>& runs, int lines, int length, auto&& at) {
        for (int line = 0; line < lines; ++line)
            for (int first = 0, k = 0; k < length; ++k) {
                const auto here = at(line, k);
                if (depths[place(here.first, here.second)] == 0) weights_.row(here.second)[here.first] = 0;
                const bool ends = k + 1 == length || [&] {
                    const auto next = at(line, k + 1);
                    return are_apart(depths[place(here.first, here.second)],
                                     depths[place(next.first, next.second)]);
                }();
                if (!ends) continue;
                if (k + 1 < length) forget(here.first, here.second);
                for (int each = first; each <= k; ++each) {
                    const auto of = at(line, each);
                    runs[place(of.first, of.second)] = {static_cast<std::int16_t>(first),
                                                        static_cast<std::int16_t>(k)};
                }
                first = k + 1;
            }
    };
    part(runs_.across, height, width, [](int line, int k) { return std::pair(k, line); });
    part(runs_.down, width, height, [](int line, int k) { return std::pair(line, k); });
}

const NumberField& ReliefFilter::apply(const RawFrame& frame) {
    read_luma(frame.colour);
    part_surfaces(frame);
    split_.split(luma_, weights_, runs_);
    const auto part = [&](int k) {
        return (settings_.invert ? -1 : 1) * settings_.bands[static_cast<std::size_t>(k)];
    };
    const std::array<std::int32_t, 3> shares{part(0), part(1), part(2)};
    const NumberField& confidence = split_.confidence();
    for (std::size_t k = 0; k < relief_.numbers.size(); ++k) {
        const std::int32_t sum = shares[0] * split_.band(0).numbers[k] +
                                 shares[1] * split_.band(1).numbers[k] +
                                 shares[2] * split_.band(2).numbers[k];
        relief_.numbers[k] = static_cast<std::int32_t>(std::int64_t{sum} * confidence.numbers[k] /
                                                       (100 * DifferenceOfGaussians::most_weight));
    }
    return relief_;
}

}  // namespace touchable
