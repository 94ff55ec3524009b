#include "engine/authoring/pumping.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <utility>

#include "engine/scene/stored_code.hpp"

namespace touchable {

bool PumpingEstimator::is_cut() const {
    constexpr int another = 24;  // levels
    if (colours_.empty() || colours_.size() != colours_before_.size()) return false;
    std::size_t changed = 0;
    for (std::size_t k = 0; k < colours_.size(); ++k)
        changed += std::abs(colours_[k] - colours_before_[k]) > another ? 1 : 0;
    return 2 * changed > colours_.size();
}

void PumpingEstimator::add(const RawFrame& frame) {
    here_.clear();
    colours_.clear();
    for (int y = every / 2; y < frame.depth.height; y += every)
        for (int x = every / 2; x < frame.depth.width; x += every) {
            const std::uint16_t code = stored_code(frame.depth, coding_, x, y);
            here_.push_back(coding_.is_valid(code) ? coding_.depth(code) : 0.0);
            if (!frame.colour.empty())
                colours_.push_back(static_cast<std::uint8_t>(frame.colour.sample(x, y, 1)));
        }
    ratios_.clear();
    if (before_.size() == here_.size() && !is_cut())
        for (std::size_t k = 0; k < here_.size(); ++k)
            if (before_[k] > 0 && here_[k] > 0) ratios_.push_back(here_[k] / before_[k] - 1);
    std::swap(before_, here_);
    std::swap(colours_before_, colours_);
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
