#include "engine/authoring/relief_estimator.hpp"

#include <algorithm>
#include <cstdlib>
#include <numeric>

namespace touchable {
namespace {

constexpr std::int32_t counts_from = DifferenceOfGaussians::most_weight / 2;

/// The number that `share` of all are not above, in per mille; nothing of none.
std::optional<std::int32_t> quantile(const std::vector<std::int64_t>& histogram, int share) {
    const std::int64_t all = std::accumulate(histogram.begin(), histogram.end(), std::int64_t{0});
    if (all == 0) return std::nullopt;
    std::int64_t passed = 0;
    for (std::size_t number = 0; number < histogram.size(); ++number) {
        passed += histogram[number];
        if (passed * 1000 >= all * share) return static_cast<std::int32_t>(number);
    }
    return std::nullopt;
}

}  // namespace

void ReliefEstimator::add(const NumberField& relief, const NumberField& confidence, bool follows) {
    const auto count = [](std::vector<std::int64_t>& histogram, std::int32_t number) {
        ++histogram[std::min(static_cast<std::size_t>(std::abs(number)), most - 1)];
    };
    for (std::size_t k = 0; k < relief.numbers.size(); ++k) {
        if (confidence.numbers[k] < counts_from) continue;
        count(sizes_, relief.numbers[k]);
        if (follows) count(changes_, relief.numbers[k] - before_.numbers[k]);
    }
    before_ = relief;
}

ReliefRange ReliefEstimator::range() const {
    // Most of a picture stays where it is. The median of the changes there is 0.67 of sqrt(2) deviations.
    const std::optional<std::int32_t> change = quantile(changes_, 500), full = quantile(sizes_, 990);
    ReliefRange range{std::max(1, full.value_or(1))};
    if (change) range.noise = (*change * 105 + 99) / 100;
    return range;
}

}  // namespace touchable
