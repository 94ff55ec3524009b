#include "engine/surface/filter_choice.hpp"

#include <algorithm>

#include "engine/scene/terraces.hpp"

namespace touchable {
namespace {

/// Cameras' surfaces have a median where they are rougher than this share of a pixel's width, which tilts
/// faces by about ten degrees.
constexpr double roughness_per_pixel = 0.15;
/// A small one is enough where levels are much farther apart than noise moves a depth, and it keeps steps
/// sharper.
constexpr double levels_per_noise = 1.5;
/// They close holes three pixels wide.
constexpr int passes = 2;

int median_of_cameras(const MeasuredDepth& measured) {
    const double noise = std::max(measured.noise_at_median(), measured.roughness);
    return measured.distance >= levels_per_noise * noise ? 3 : 5;
}

/// One surface is what flying pixels were judged by, or what is flat to three times the noise; without noise
/// what leans by no more than 84 degrees, and two levels.
constexpr double flat_per_noise = 3, flat_per_pixel = 10, flat_per_level = 2;

/// About in proportion to depth, which a DepthLength can say around the median only; levels grow with its
/// square.
DepthLength flat_within(const MeasuredDepth& measured) {
    const double m = measured.median, share = m / NoiseEstimator::flat_share;
    const double noise = flat_per_noise * measured.noise_at_median(),
                 levels = flat_per_level * measured.distance;
    const double length =
        measured.from_a_camera() ? std::max(share, noise) : std::min(share, flat_per_pixel * measured.pixel);
    const double beyond = measured.from_a_camera() ? 0 : std::max(0.0, levels - length);
    return {0.5 * length, 1 / (m * m) * (0.5 * length + beyond)};
}

/// Null: nothing was tried that may be chosen.
const TriedFilters* best_of_tried(const MeasuredDepth& measured, const UnstatedFilters& unstated,
                                  const FilterSettings& filter) {
    const bool is_open = unstated.median && unstated.terraces && filter.levels == DepthLength{};
    return is_open && measured.from_a_camera() ? mildest_of_the_best(measured.tried, filter.temporal)
                                               : nullptr;
}

/// Terraces of many pixels: those of phones, whose few levels hide behind the codes of the ramps between
/// them.
void widen_reach(const MeasuredDepth& measured, Scene& scene) {
    if (scene.filter.terraces != TerraceRemoval::on || !measured.contours.are_wide()) return;
    scene.filter.terrace_reach = measured.contours.reach();
    if (scene.filter.levels != DepthLength{}) return;
    Scene with_levels = scene;
    with_levels.filter.levels = measured.contours.levels(scene.depth);
    if (has_working_codes(with_levels)) scene.filter.levels = with_levels.filter.levels;
}

/// Where nothing was tried.
void choose_smoothing_by_rule(const MeasuredDepth& measured, const UnstatedFilters& unstated, Scene& scene) {
    FilterSettings& filter = scene.filter;
    if (unstated.median)
        filter.median = measured.from_a_camera() && measured.roughness >= roughness_per_pixel * measured.pixel
                            ? median_of_cameras(measured)
                            : 0;
    if (unstated.terraces || filter.terraces == TerraceRemoval::automatic)
        filter.terraces = removal_advised(measured, scene) ? TerraceRemoval::on : TerraceRemoval::off;
    if (filter.terraces == TerraceRemoval::on) filter.levels = measured.levels;
    if (unstated.terrace_reach) widen_reach(measured, scene);
}

}  // namespace

bool removal_advised(const MeasuredDepth& measured, const Scene& scene) {
    Scene with_levels = scene;
    with_levels.filter.levels = measured.levels;
    return has_working_codes(with_levels) && measured.kappa >= kappa_of_terraces;
}

void choose_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                    Scene& scene) {
    FilterSettings& filter = scene.filter;
    if (!measured) {
        if (filter.terraces == TerraceRemoval::automatic) filter.terraces = TerraceRemoval::off;
        return;
    }
    if (unstated.temporal) filter.temporal = measured->is_noisy(scene.width);
    if (const TriedFilters* const best = best_of_tried(*measured, unstated, filter)) {
        filter.median = best->median;
        filter.terraces = best->terraces ? TerraceRemoval::on : TerraceRemoval::off;
        filter.levels = best->levels;
    } else {
        choose_smoothing_by_rule(*measured, unstated, scene);
    }
    if (unstated.flying_pixels)
        filter.flying_pixels = measured->has_flying_pixels() ? flat_within(*measured) : DepthLength{};
    if (unstated.fill_holes)
        filter.fill_holes = measured->tiny_holes >= MeasuredDepth::some_tiny_holes ? passes : 0;
    if (filter.temporal && filter.temporal_noise == DepthLength{})
        filter.temporal_noise = stated_noise(measured->noise, filter.median);
}

bool needs_measuring(const UnstatedFilters& unstated, const Scene& scene) {
    const FilterSettings& filter = scene.filter;
    return unstated.any() || filter.terraces == TerraceRemoval::automatic ||
           (filter.terraces != TerraceRemoval::off &&
            (filter.levels == DepthLength{} || unstated.terrace_reach)) ||
           (filter.temporal && filter.temporal_noise == DepthLength{});
}

Result<void> settle_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                            Scene& scene) {
    choose_filters(measured, unstated, scene);
    if (scene.filter.temporal && scene.filter.temporal_noise == DepthLength{})
        return usage_error(
            "the temporal filter is to be on, but the scene does not say how noisy its depth is, and its "
            "first frames show no noise; right would be that noise in scene units",
            {{Setting::temporal, "1.5"}});
    if (auto valid = validate(scene); !valid) return usage_error(valid.error().message);
    return {};
}

}  // namespace touchable
