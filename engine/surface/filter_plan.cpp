#include "engine/surface/filter_plan.hpp"

#include <cassert>

namespace touchable {

FilterPlan::FilterPlan(const Scene& scene) : stored(scene.depth) {
    const FilterSettings& asked = scene.filter;
    assert(asked.median == 0 || asked.median == 3 || asked.median == 5);
    if (const auto filter = flying_pixels(scene)) filters.push_back({*filter, flying_reach, coding()});
    if (asked.fill_holes > 0) filters.push_back({HoleFilling{asked.fill_holes}, asked.fill_holes, coding()});
    if (asked.median > 0) filters.push_back({MedianWindow{asked.median}, asked.median / 2, coding()});
    if (const auto filter = temporal_filter(scene))
        filters.push_back({*filter, std::nullopt, filter->coding});
    if (const auto filter = terrace_filter(scene))
        filters.push_back({*filter, filter->reach, filter->coding});
}

std::optional<int> FilterPlan::reach() const {
    int sum = 0;
    for (const PlannedFilter& planned : filters) {
        if (!planned.reach) return std::nullopt;
        sum += *planned.reach;
    }
    return sum;
}

}  // namespace touchable
