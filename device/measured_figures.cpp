#include "device/measured_figures.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <glm/geometric.hpp>

namespace touchable {
namespace {

double seconds_between(std::int64_t from_ns, std::int64_t to_ns) {
    return static_cast<double>(to_ns - from_ns) * 1e-9;
}

/// Of sorted values.
double percentile(const std::vector<double>& values, double percent) {
    const auto rank = static_cast<std::size_t>(std::ceil(percent / 100 * static_cast<double>(values.size())));
    return values[std::max<std::size_t>(rank, 1) - 1];
}

}  // namespace

Percentiles percentiles_of(std::vector<double> values) {
    if (values.empty()) return {};
    std::sort(values.begin(), values.end());
    return {static_cast<std::int64_t>(values.size()), percentile(values, 50), percentile(values, 99),
            values.back()};
}

std::vector<double> intervals_between(std::span<const std::int64_t> times_ns) {
    std::vector<double> intervals;
    for (std::size_t k = 1; k < times_ns.size(); ++k)
        intervals.push_back(seconds_between(times_ns[k - 1], times_ns[k]));
    return intervals;
}

std::vector<double> until_the_next(std::span<const std::int64_t> times_ns,
                                   std::span<const std::int64_t> others_ns) {
    std::vector<double> waits;
    auto other = others_ns.begin();
    for (std::size_t k = 0; k < times_ns.size(); ++k) {
        other = std::lower_bound(other, others_ns.end(), times_ns[k]);
        if (other == others_ns.end()) break;
        if (k + 1 < times_ns.size() && *other >= times_ns[k + 1]) continue;
        waits.push_back(seconds_between(times_ns[k], *other));
    }
    return waits;
}

RestFigures rest_of(std::span<const glm::dvec3> metres) {
    RestFigures figures;
    figures.places = static_cast<std::int64_t>(metres.size());
    if (metres.empty()) return figures;
    const double count = static_cast<double>(metres.size());
    glm::dvec3 mean(0), square(0);
    for (const glm::dvec3& place : metres) mean += place / count;
    for (std::size_t k = 0; k < metres.size(); ++k) {
        const glm::dvec3 off = metres[k] - mean;
        square += off * off / count;
        figures.farthest_m = std::max(figures.farthest_m, glm::length(off));
        for (int axis = 0; k > 0 && axis < 3; ++axis) {
            const double step = std::abs(metres[k][axis] - metres[k - 1][axis]);
            double& smallest = figures.step_m[axis];
            if (step > 0 && (smallest == 0 || step < smallest)) smallest = step;
        }
    }
    figures.deviation_m = {std::sqrt(square.x), std::sqrt(square.y), std::sqrt(square.z)};
    return figures;
}

}  // namespace touchable
