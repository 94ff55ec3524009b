#include "engine/surface/filter_search.hpp"

#include <algorithm>

#include "engine/base/stop_request.hpp"
#include "engine/scene/working_codes.hpp"
#include "engine/surface/code_filters.hpp"
#include "engine/surface/filter_plan.hpp"

namespace touchable {
namespace {

/// How far apart removal may take levels to be, over the least step of the sensor, and how far at most after
/// which median: so that a step of four of these stays sharp, and a pen as high is kept (docs/real-depth.md).
constexpr double per_least_step[] = {0.2, 0.3, 0.45, 0.7, 1, 1.2, 1.4};
constexpr double most_after_median[] = {1.4, 0, 0, 1, 0, 0.7};
/// The least step is a level, or what would be as rough as depths are: levels l apart are l/sqrt(12) rough.
/// Levels count, even in noise that is somewhat rougher, where they are seen; codes where little else is
/// rough.
constexpr double level_per_roughness = 3.4641, seen_levels_from = 0.4, codes_from = 0.75;
/// What the temporal filter is told, over the noise that was measured, by the median before it.
constexpr double stated_per_measured[] = {0.9, 0, 0, 1.4, 0, 1.5};
/// What leaves this much more than the best, or so few degrees, is as good.
constexpr double as_good = 1.10, good_deg = 0.7;
/// What a median costs of a low pen's relief, in levels that are a least step wider (docs/real-depth.md, Low
/// relief).
constexpr double harshness_of_median[] = {0, 0, 0, 0.17, 0, 0.37};

DepthLength least_step(const DepthLength& levels, const DepthLength& codes, const DepthLength& roughness,
                       double depth) {
    const DepthLength rough = roughness.times(level_per_roughness);
    const auto counts = [&](const DepthLength& of, double from) {
        return !(of == DepthLength{}) && of.at(depth) >= from * rough.at(depth);
    };
    if (counts(levels, seen_levels_from)) return levels;
    return counts(codes, codes_from) ? codes : rough;
}

/// Of the last mosaic.
double left_by(const Scene& scene, const SmoothPatches& patches) {
    const FilterPlan plan(scene);
    const auto filters = make_code_filters(plan, usable_vector_units().front());
    RowBands alone(1);
    SurfaceFrame built;
    const std::vector<RawFrame>& mosaics = patches.mosaics();
    if (plan.remembers())
        for (std::size_t n = 0; n + 1 < mosaics.size(); ++n) filters->remember(mosaics[n], alone, built);
    filters->make_all(mosaics.back(), alone, built);
    built.coding = plan.coding();
    return patches.faces_off_deg(built);
}

}  // namespace

DepthLength stated_noise(const DepthLength& measured, int median) {
    return measured.times(stated_per_measured[median]);
}

std::vector<TriedFilters> tried_filters(const SmoothPatches& patches, const DepthLength& levels,
                                        const DepthLength& noise) {
    std::vector<TriedFilters> tried;
    if (!patches.enough()) return tried;
    const double depth = patches.median_depth();
    const DepthLength codes = code_step(patches.mosaic_scene().depth),
                      least = least_step(levels, codes, patches.roughness(), depth);
    const auto with = [&](Scene scene, double harshness) {
        if (stop_requested()) return;
        const auto keep = [&] {
            const FilterSettings& filter = scene.filter;
            tried.push_back({filter.temporal, filter.median, filter.terraces == TerraceRemoval::on,
                             filter.levels, harshness, left_by(scene, patches)});
        };
        keep();
        if (noise == DepthLength{}) return;
        scene.filter.temporal = true;
        scene.filter.temporal_noise = stated_noise(noise, scene.filter.median);
        keep();
    };
    for (const int median : {0, 3, 5}) {
        Scene scene = patches.mosaic_scene();
        scene.filter.median = median;
        const double harshness = harshness_of_median[median];
        with(scene, harshness);
        scene.filter.terraces = TerraceRemoval::on;
        for (const double factor : per_least_step) {
            scene.filter.levels = least.times(factor);
            if (factor > most_after_median[median] || !has_working_codes(scene) ||
                scene.filter.levels.at(depth) < std::max(levels.at(depth), codes.at(depth)))
                continue;
            with(scene, harshness + factor);
        }
    }
    std::stable_sort(tried.begin(), tried.end(),
                     [](const TriedFilters& a, const TriedFilters& b) { return a.harshness < b.harshness; });
    return tried;
}

std::vector<TriedFilters> tried_removal(const SmoothPatches& patches, const DepthLength& levels) {
    Scene scene = patches.mosaic_scene();
    if (!patches.enough()) return {};
    std::vector<TriedFilters> tried(1);
    tried[0].left_deg = left_by(scene, patches);
    scene.filter.terraces = TerraceRemoval::on;
    scene.filter.levels = levels;
    if (has_working_codes(scene)) tried.push_back({false, 0, true, levels, 1, left_by(scene, patches)});
    return tried;
}

const TriedFilters* found_among(const std::vector<TriedFilters>& tried, const FilterSettings& filter) {
    const bool removed = filter.terraces == TerraceRemoval::on;
    if (removed && filter.terrace_reach != least_terrace_reach) return nullptr;
    for (const TriedFilters& one : tried)
        if (one.temporal == filter.temporal && one.median == filter.median && one.terraces == removed &&
            (!removed || one.levels == filter.levels))
            return &one;
    return nullptr;
}

const TriedFilters* mildest_of_the_best(const std::vector<TriedFilters>& tried, bool temporal) {
    double best = 180;
    for (const TriedFilters& one : tried)
        if (one.temporal == temporal) best = std::min(best, one.left_deg);
    const double enough = std::max(good_deg, as_good * best);
    for (const TriedFilters& one : tried)
        if (one.temporal == temporal && one.left_deg <= enough) return &one;
    return nullptr;
}

}  // namespace touchable
