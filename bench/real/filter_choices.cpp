// SPDX-License-Identifier: Apache-2.0
#include "bench/real/filter_choices.hpp"

#include <algorithm>
#include <limits>
#include <string>

#include "engine/surface/depth_estimator.hpp"

namespace touchable {
namespace {

template <int median, bool temporal, bool terraces>
Scene with_filters(const std::vector<RawFrame>& first, Scene scene) {
    const DepthLength noise = scene.filter.temporal_noise;
    scene.filter = {};
    scene.filter.median = median;
    scene.filter.temporal = temporal;
    scene.filter.temporal_noise = noise;
    if (terraces) {
        scene.filter.terraces = TerraceRemoval::on;
        if (const auto depth = measured_depth(first, scene)) scene.filter.levels = depth->levels;
    }
    return scene;
}

/// The gate is 1.5 times that for the noise, so that two adjacent levels are within it.
Scene with_wide_gate(const std::vector<RawFrame>& first, Scene scene) {
    scene = with_filters<5, true, true>(first, scene);
    scene.filter.temporal_noise = scene.filter.temporal_noise.times(1.5);
    return scene;
}

}  // namespace

std::optional<MeasuredDepth> measured_depth(const std::vector<RawFrame>& first, const Scene& scene) {
    DepthEstimator estimator(scene);
    for (std::size_t n = 0; n < first.size() && !estimator.enough(); ++n) estimator.add(first[n]);
    return estimator.measured();
}

double trusted_to(const FilterSettings& filter, const std::optional<MeasuredDepth>& measured) {
    const auto to = measured ? measured->trusted_to(filter) : std::nullopt;
    return to.value_or(std::numeric_limits<double>::infinity());
}

Scene chosen_filters(const std::optional<MeasuredDepth>& measured, Scene scene) {
    scene.filter = {};
    choose_filters(measured, all_unstated, scene);
    return scene;
}

Scene chosen_filters(const std::vector<RawFrame>& first, Scene scene) {
    scene.filter = {};
    return chosen_filters(measured_depth(first, scene), scene);
}

void add_details(const std::vector<RawFrame>& first, const Scene& scene, Figures& figures) {
    const auto measured = measured_depth(first, scene);
    if (!measured || !measured->patches) return;
    const bool temporal = measured->is_noisy(scene.width);
    const auto points = frontier(measured->tried, temporal);
    const auto chosen = std::ranges::find(points, mildest_of_the_best(measured->tried, temporal));
    figures.push_back({"points", static_cast<double>(points.size()), ""});
    figures.push_back({"chosen_detail", static_cast<double>(chosen - points.begin()), ""});
    double pen = 0;
    for (std::size_t k = 0; k < points.size(); ++k) {
        const std::string name = "detail_" + std::to_string(k);
        pen = std::max(pen, least_relief(*measured->patches, *points[k], measured->noise));
        figures.push_back({name + "_leans_deg", points[k]->left_deg, "deg", false});
        const double finite = std::min(pen, measured->median);  // no report has infinity
        figures.push_back({name + "_pen_mm", 1000 * finite * scene.metres_per_unit, "mm", false});
    }
}

const std::vector<FilterChoice>& filter_choices() {
    static const std::vector<FilterChoice> choices{{"none", with_filters<0, false, false>},
                                                   {"m5", with_filters<5, false, false>},
                                                   {"t", with_filters<0, false, true>},
                                                   {"m3-t", with_filters<3, false, true>},
                                                   {"m5-t", with_filters<5, false, true>},
                                                   {"temporal-t", with_filters<0, true, true>},
                                                   {"m3-temporal-t", with_filters<3, true, true>},
                                                   {"m5-temporal-t", with_filters<5, true, true>},
                                                   {"m5-temporal-wide-t", with_wide_gate},
                                                   {"chosen", chosen_filters}};
    return choices;
}

}  // namespace touchable
