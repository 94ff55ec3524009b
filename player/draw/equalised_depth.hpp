#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// Histogram equalisation: places of depths on a scale whose steps have equally many pixels each. However far
/// away a few pixels are, the others are told apart. The places follow the picture within parts of a second
/// of the clip's time, so that they do not flicker; another epoch begins anew.
class EqualisedDepth {
public:
    static constexpr double adapting_s = 0.5;

    /// `depths`: a sample of those that are seen, scene units, > 0. `field`: that they are of.
    void update(std::span<const float> depths, const HeightField& field);

    /// Depths of one bin have one place. A bin is up to 1/4096 of its depth wide.
    std::size_t bins() const { return shares_.size(); }
    /// Of each value of a row its bin; `bins()` of what is NaN.
    void find_bins(const float* depths, int width, std::uint32_t* bins) const;
    /// The share of the pixels that are nearer than those of bin k, and half of those; 0 to 1.
    double share_of_bin(std::size_t k) const { return shares_[k]; }
    /// The depth than which that share of the pixels is nearer, scene units. At least one is seen.
    double depth_at(double share) const;

private:
    std::uint32_t first_ = 0;     // key of the first bin
    std::vector<float> weights_;  // of each bin; all of them make 1
    std::vector<double> shares_;
    double moment_ns_ = 0;
    std::uint64_t epoch_ = 0;
};

}  // namespace touchable
