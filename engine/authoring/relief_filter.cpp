#include "engine/authoring/relief_filter.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "engine/scene/unseen_colour.hpp"
#include "engine/surface/code_picture.hpp"

namespace touchable {
namespace {

constexpr int luma_per_level = 16;
/// Brightness of 255 at which shadow ends and highlight begins. From the first to the second, weights go
/// over.
constexpr int shadow_from = 6, shadow_to = 24, highlight_from = 238, highlight_to = 253;
/// Depths of neighbours that differ by more of them are two surfaces.
constexpr float step_share = 0.02F;
/// Colour bleeds over a step of depth by so many pixels on either side.
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

/// Cuts a row or a column, whose pixels are `step` apart in memory, into runs of one surface each.
/// `at_end(k)`: pixel k is the last of one, and k + 1 the first of another.
template <class AtEnd>
void cut_line(const float* depths, std::ptrdiff_t step, int length, SurfaceRuns::Run* runs, AtEnd&& at_end) {
    for (int first = 0, k = 0; k < length; ++k) {
        const bool is_last = k + 1 == length;
        if (!is_last && !are_apart(depths[k * step], depths[(k + 1) * step])) continue;
        const SurfaceRuns::Run run{static_cast<std::int16_t>(first), static_cast<std::int16_t>(k)};
        for (; first <= k; ++first) runs[first * step] = run;
        if (!is_last) at_end(k);
    }
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
            weight_row[x] =
                is_unseen_colour(rgb)
                    ? 0
                    : std::min(ramp(luma_row[x], shadow_from * luma_per_level, shadow_to * luma_per_level),
                               ramp(-luma_row[x], -highlight_to * luma_per_level,
                                    -highlight_from * luma_per_level));
        }
    }
}

/// Surfaces end at holes and steps of depth. What colour may have bled to over one counts for nothing.
void ReliefFilter::part_surfaces(const RawFrame& frame) {
    const CodePicture codes = code_picture(frame.depth, depth_);
    const int width = codes.width, height = codes.height;
    std::vector<float> depths(codes.codes.size());
    for (std::size_t k = 0; k < depths.size(); ++k) {
        const bool is_hole = codes.codes[k] == CodePicture::invalid;
        depths[k] =
            is_hole ? 0.0F : static_cast<float>(depth_.depth(static_cast<std::uint16_t>(codes.codes[k])));
        if (is_hole) weights_.numbers[k] = 0;
    }
    /// Of columns [x0, x1) and rows [y0, y1), as far as the picture goes.
    const auto forget = [&](int x0, int x1, int y0, int y1) {
        for (int y = std::max(0, y0); y < std::min(height, y1); ++y)
            std::fill(weights_.row(y) + std::max(0, x0), weights_.row(y) + std::min(width, x1), 0);
    };
    for (int y = 0; y < height; ++y) {
        const std::size_t row = static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
        cut_line(&depths[row], 1, width, &runs_.across[row],
                 [&](int x) { forget(x + 1 - bleeding, x + 1 + bleeding, y + 1 - bleeding, y + bleeding); });
    }
    for (int x = 0; x < width; ++x)
        cut_line(&depths[static_cast<std::size_t>(x)], width, height,
                 &runs_.down[static_cast<std::size_t>(x)],
                 [&](int y) { forget(x + 1 - bleeding, x + bleeding, y + 1 - bleeding, y + 1 + bleeding); });
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
