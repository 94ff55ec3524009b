#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <vector>

#include "engine/clip/far_plane.hpp"

namespace touchable {

/// The largest of many values, of which one in 10 000 may be stray (FarPlaneEstimator's rule, for values that
/// are no codes yet). Takes memory for as many as may be stray in all telling frames.
class FarthestValues {
public:
    /// Values of one more picture follow, at most so many.
    void begin_picture(std::size_t pixels) {
        most_kept_ = std::max(most_kept_, (first_frames + spread_frames) * pixels / stray_of + 1);
    }
    void add(float value) {
        ++count_;
        if (kept_.size() >= most_kept_ && value <= least_kept_) return;
        kept_.push_back(value);
        if (kept_.size() < 2 * most_kept_) return;
        const auto last = kept_.begin() + static_cast<std::ptrdiff_t>(most_kept_) - 1;
        std::nth_element(kept_.begin(), last, kept_.end(), std::greater<>());
        least_kept_ = *last;
        kept_.resize(most_kept_);
    }
    /// What one value in 10 000 exceeds at most. Needs a value.
    double without_strays() {
        const auto at = kept_.begin() + static_cast<std::ptrdiff_t>(count_ / stray_of);
        std::nth_element(kept_.begin(), at, kept_.end(), std::greater<>());
        return *at;
    }
    /// Share of the values; of a bound that is no less than what is `without_strays`.
    double share_beyond(double bound) const {
        const auto beyond =
            std::count_if(kept_.begin(), kept_.end(), [&](float value) { return value > bound; });
        return static_cast<double>(beyond) / static_cast<double>(count_);
    }

private:
    static constexpr std::size_t stray_of = 10'000;
    std::vector<float> kept_;
    float least_kept_ = 0;  // once there are `most_kept_`
    std::size_t most_kept_ = 1, count_ = 0;
};

}  // namespace touchable
