#include "engine/quality/pumping.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "engine/frame/stored_code.hpp"

namespace touchable {

void PumpingEstimator::add(const RawFrame& frame) {
    here_.clear();
    for (int y = every / 2; y < frame.depth.height; y += every)
        for (int x = every / 2; x < frame.depth.width; x += every) {
            const std::uint16_t code = stored_code(frame.depth, coding_, x, y);
            here_.push_back(coding_.is_valid(code) ? coding_.depth(code) : 0.0);
        }
    ratios_.clear();
    if (before_.size() == here_.size())
        for (std::size_t k = 0; k < here_.size(); ++k)
            if (before_[k] > 0 && here_[k] > 0) ratios_.push_back(here_[k] / before_[k] - 1);
    std::swap(before_, here_);
    if (ratios_.size() < 16) {
        last_change_.reset();
        return;
    }
    const auto middle = ratios_.begin() + static_cast<std::ptrdiff_t>(ratios_.size() / 2);
    std::nth_element(ratios_.begin(), middle, ratios_.end());
    if (last_change_) {
        products_ += *last_change_ * *middle;
        ++count_;
    }
    last_change_ = *middle;
}

std::optional<double> PumpingEstimator::share() const {
    if (count_ < 2) return std::nullopt;
    return std::sqrt(std::max(0.0, -products_ / static_cast<double>(count_)));
}

}  // namespace touchable
