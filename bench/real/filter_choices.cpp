#include "bench/real/filter_choices.hpp"

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

Scene chosen_filters(const std::vector<RawFrame>& first, Scene scene) {
    scene.filter = {};
    choose_filters(measured_depth(first, scene), all_unstated, scene);
    return scene;
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
