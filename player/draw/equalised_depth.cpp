#include "player/draw/equalised_depth.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

// Compiled without errno and traps, as scalar_rows.cpp is.

namespace touchable {
namespace {

// The leading bits of a positive float, twelve of them of its fraction, grow with its value; so bins are as
// fine relative to any depth, and no logarithm is computed.
constexpr int fraction_bits_left = 23 - 12;

std::uint32_t key_of(float depth) {
    return std::bit_cast<std::uint32_t>(depth) >> fraction_bits_left;
}

}  // namespace

void EqualisedDepth::update(std::span<const float> depths, const HeightField& field) {
    const std::uint32_t first = key_of(static_cast<float>(field.nearest_depth_anywhere())),
                        last = key_of(static_cast<float>(field.scene().depth.far));
    const std::size_t bins = std::max(first, last) - first + 1;
    const double passed_s = 1e-9 * (field.moment_ns() - moment_ns_);
    const bool is_new = bins != weights_.size() || first != first_ || field.epoch() != epoch_ || passed_s < 0;
    if (is_new) weights_.assign(bins, 0);
    first_ = first;
    moment_ns_ = field.moment_ns();
    epoch_ = field.epoch();
    const double share = is_new ? 1 : std::clamp(passed_s / adapting_s, 0.0, 1.0);
    if (!depths.empty() && share > 0) {
        const auto kept = static_cast<float>(1 - share), each = static_cast<float>(share) / depths.size();
        for (float& weight : weights_) weight *= kept;
        for (const float depth : depths)
            weights_[std::clamp(key_of(depth), first, first + static_cast<std::uint32_t>(bins) - 1) -
                     first] += each;
    }
    shares_.resize(bins);
    double nearer = 0;
    for (std::size_t k = 0; k < bins; ++k) {
        const auto weight = static_cast<double>(weights_[k]);
        shares_[k] = std::min(nearer + weight / 2, 1.0);
        nearer += weight;
    }
}

void EqualisedDepth::find_bins(const float* depths, int width, std::uint32_t* bins) const {
    const std::uint32_t first = first_, last = static_cast<std::uint32_t>(shares_.size()) - 1;
    for (int x = 0; x < width; ++x) {
        const std::uint32_t key = key_of(depths[x]), offset = key > first ? key - first : 0;
        bins[x] = depths[x] == depths[x] ? (offset < last ? offset : last) : last + 1;
    }
}

double EqualisedDepth::depth_at(double share) const {
    const auto at = std::lower_bound(shares_.begin(), shares_.end(), share);
    const auto k =
        static_cast<std::uint32_t>(std::min<std::ptrdiff_t>(at - shares_.begin(), std::ssize(shares_) - 1));
    const auto begin_of = [this](std::uint32_t bin) {
        return static_cast<double>(std::bit_cast<float>((first_ + bin) << fraction_bits_left));
    };
    return 0.5 * (begin_of(k) + begin_of(k + 1));
}

}  // namespace touchable
