#include "engine/scene/terraces.hpp"

#include <cmath>

namespace touchable {
namespace {

// Eight gates, which the sum of a pass may reach on its way (terrace_rows.cpp), at the largest factor and the
// most noise.
static_assert(8 * ((5 * TerraceFilter::most_level + 3 * most_terrace_noise * 126) / 4) <= 32767);

/// Of looked-up codes, whose steps differ: noise makes both lengths wider by three fifths of it, as it makes
/// the gate.
TerraceFilter looked_up_filter(const Scene& scene, const WorkingCodes& working) {
    const DepthLength step = code_step(scene.depth), &levels = scene.filter.levels;
    const double noise = 0.6 * scene.filter.terrace_noise;
    const auto wider = [&](const DepthLength& length) {
        return DepthLength{length.constant + noise * step.constant,
                           length.quadratic + noise * step.quadratic};
    };
    TerraceFilter filter;
    filter.working = working;
    filter.step = 1;
    // Their curves are differences, and a level may be two codes. The largest level has room for two digits.
    filter.fraction = 2;
    filter.steps = code_curve(working.coding, wider(step), 4.0);
    if (!(levels == DepthLength{})) filter.levels = code_curve(working.coding, wider(levels), 4.0);
    return filter;
}

TerraceFilter multiplied_filter(const Scene& scene, const WorkingCodes& working) {
    const FilterSettings& settings = scene.filter;
    TerraceFilter filter;
    filter.working = working;
    filter.step = working.factor;
    filter.noise = static_cast<int>(std::floor(settings.terrace_noise * working.factor + 0.5));
    if (!(settings.levels == DepthLength{})) filter.levels = code_curve(working.coding, settings.levels, 1.0);
    return filter;
}

}  // namespace

double level_distance(const Scene& scene, double depth) {
    const DepthCoding& coding = scene.depth;
    const DepthLength& levels = scene.filter.levels;
    return std::max(step_of_code(coding, coding.code(depth)), levels.at(depth));
}

double kappa_of_depth(const Scene& scene, double depth) {
    if (scene.depth.valid_min >= scene.depth.valid_max) return 0;
    return level_distance(scene, depth) / (depth / scene.camera.fx);
}

double kappa_of_scene(const Scene& scene) {
    const DepthCoding& coding = scene.depth;
    return kappa_of_depth(scene, 0.5 * (coding.depth(coding.valid_min) + coding.depth(coding.valid_max)));
}

bool terraces_advised(const Scene& scene) {
    return has_working_codes(scene) && kappa_of_scene(scene) >= kappa_of_terraces;
}

std::optional<TerraceFilter> terrace_filter(const Scene& scene) {
    const FilterSettings& settings = scene.filter;
    const bool wanted = settings.terraces == TerraceRemoval::on ||
                        (settings.terraces == TerraceRemoval::automatic && terraces_advised(scene));
    if (!wanted) return std::nullopt;
    const auto working = working_codes(scene);
    if (!working) return std::nullopt;
    TerraceFilter filter =
        working->table ? looked_up_filter(scene, *working) : multiplied_filter(scene, *working);
    filter.reach = settings.terrace_reach;
    filter.coding = finer(working->coding, 2);
    if (settings.temporal) filter.working = unchanged_codes(working->coding);
    return filter;
}

}  // namespace touchable
