// SPDX-License-Identifier: Apache-2.0
// The measurements of the first frames, put together, and the filters chosen by them.
#include "engine/surface/depth_estimator.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

/// Share of pixels from which on dropouts are not chance.
constexpr double some_dropouts = 5e-4;
/// Noise is averaged from a ten-thousandth of the picture's width on. The hand's 16 cm are as wide as the
/// picture, so that is 0.016 mm for the hand, and 10 mN at 600 N/m.
constexpr double noise_per_picture = 1e-4;
/// Pixels that hang between two surfaces count from this share on.
constexpr double some_flying = 1e-4;
/// With clean edges there are more of them than this many times the pixels that hang midway.
constexpr double clean_edges_per_midway = 4;
/// Pixels across and down, in the middle: the rest of a larger picture shows no more of a camera.
constexpr int largest_part = 4096;

PlaneView middle_part(PlaneView depth) {
    const int width = std::min(depth.width, largest_part), height = std::min(depth.height, largest_part);
    depth.data += depth.stride * ((depth.height - height) / 2) +
                  std::ptrdiff_t{depth.bytes_per_sample} * depth.channels * ((depth.width - width) / 2);
    depth.width = width;
    depth.height = height;
    return depth;
}

/// A camera's surfaces get a median if they are rougher than this share of a pixel's width, which tilts faces
/// by about ten degrees.
constexpr double roughness_per_pixel = 0.15;
/// Roughness that filters are tried on, as a share of a pixel's width: it tilts faces by about four degrees.
constexpr double noise_per_pixel = 0.05;
/// Rounding to levels alone leaves 0.29 of their distance.
constexpr double roughness_per_level = 0.4;
/// Of white noise 1, of noise that neighbours share 3, of relief with a shape 4 to 14.
constexpr double most_wide_roughness = 4.5;
constexpr double most_smooth = 0.3, least_changing = 0.05;
/// A small median is enough if levels are this much farther apart than noise moves a depth, and it keeps
/// steps sharper.
constexpr double levels_per_noise = 1.5;
/// Of depth that is not rough, the removal of terraces is tried from this kappa on, which tilts faces by
/// about three degrees. It is chosen below kappa_of_terraces if it leaves so much less, from there on unless
/// it leaves so much more.
constexpr double least_kappa = 0.1, clearly_less = 0.9, hardly_more = 1.02;
/// Force cannot be trusted where terraces are removed up to a height of so many pixels' widths, and relief
/// with them (docs/measurements.md), or where surfaces lean by so much, RMS: then 0.7 % of normally
/// distributed directions are off by 20 degrees, exp(-(20/9)^2).
constexpr double most_removed = 10, most_lean_deg = 9;
/// These close holes three pixels wide.
constexpr int passes = 2;

int median_of_cameras(const MeasuredDepth& measured) {
    const double noise = std::max(measured.noise_at_median(), measured.roughness);
    return measured.distance >= levels_per_noise * noise ? 3 : 5;
}

/// One surface is what lies within the share for judging flying pixels, or within three times the noise;
/// without noise, what leans by no more than 84 degrees, and two levels.
constexpr double flat_per_noise = 3, flat_per_pixel = 10, flat_per_level = 2;

/// About in proportion to depth, which a DepthLength can state around the median only; levels grow with its
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

/// Nothing: nothing was tried that may be chosen.
std::optional<TriedFilters> best_of_tried(const MeasuredDepth& measured, const UnstatedFilters& unstated,
                                          const FilterSettings& filter) {
    if (filter.levels != DepthLength{}) return {};
    if (unstated.detail) {
        std::vector<TriedFilters> open;  // with the median or removal that is stated
        for (const TriedFilters& one : measured.tried)
            if ((unstated.median || one.median == filter.median) &&
                (unstated.terraces || filter.terraces == TerraceRemoval::automatic ||
                 one.terraces == (filter.terraces == TerraceRemoval::on)))
                open.push_back(one);
        const bool temporal = filter.temporal && std::ranges::any_of(open, &TriedFilters::temporal);
        const auto points = frontier(open, temporal);
        const bool is_open = unstated.median && unstated.terraces;
        if (points.empty())
            return is_open && unstated.detail == 1 ? std::optional<TriedFilters>(std::in_place)
                                                   : std::nullopt;
        const auto steps = static_cast<double>(points.size() - 1);
        return *points[static_cast<std::size_t>((1 - *unstated.detail) * steps + 0.5)];
    }
    if (!unstated.median || !unstated.terraces || !measured.is_searched()) return {};
    const TriedFilters* const best = mildest_of_the_best(measured.tried, filter.temporal);
    return best ? std::optional(*best) : std::nullopt;
}

/// For terraces of many pixels, such as those of phones, whose few levels hide behind the codes of the ramps
/// between them.
void widen_reach(const MeasuredDepth& measured, Scene& scene) {
    if (scene.filter.terraces != TerraceRemoval::on || !measured.contours.are_wide()) return;
    scene.filter.terrace_reach = measured.contours.reach();
    if (scene.filter.levels != DepthLength{}) return;
    Scene with_levels = scene;
    with_levels.filter.levels = measured.contours.levels(scene.depth);
    if (has_working_codes(with_levels)) scene.filter.levels = with_levels.filter.levels;
}

/// The choice if nothing was tried.
void choose_smoothing_by_rule(const MeasuredDepth& measured, const UnstatedFilters& unstated, Scene& scene) {
    FilterSettings& filter = scene.filter;
    if (unstated.median)
        filter.median = measured.is_searched() && measured.roughness >= roughness_per_pixel * measured.pixel
                            ? median_of_cameras(measured)
                            : 0;
    if (unstated.terraces || filter.terraces == TerraceRemoval::automatic)
        filter.terraces = removal_advised(measured, scene) ? TerraceRemoval::on : TerraceRemoval::off;
    if (filter.terraces == TerraceRemoval::on) filter.levels = measured.levels;
    if (unstated.terrace_reach) widen_reach(measured, scene);
}

}  // namespace

bool MeasuredDepth::from_a_camera() const {
    return noise != DepthLength{} || levels.quadratic > 0 || dropouts >= some_dropouts ||
           tiny_holes >= some_tiny_holes;
}

bool MeasuredDepth::is_rough() const {
    const bool stands_still = frames >= 3 && changing < least_changing;
    return roughness >= noise_per_pixel * pixel && roughness > roughness_per_level * distance &&
           wide_roughness <= most_wide_roughness * roughness && smooth <= most_smooth && !stands_still;
}

bool MeasuredDepth::has_flying_pixels() const {
    if (from_a_camera()) return flying >= some_flying;
    return midway >= some_flying && clean_edges <= clean_edges_per_midway * midway;
}

std::optional<double> MeasuredDepth::detail_of(const FilterSettings& filter) const {
    const TriedFilters* const now = found_among(tried, filter);
    for (const bool temporal : {filter.temporal, true, false}) {
        const auto points = frontier(tried, temporal);
        const auto at = std::ranges::find(points, now);
        if (points.size() > 1 && at != points.end())
            return 1 - static_cast<double>(at - points.begin()) / static_cast<double>(points.size() - 1);
    }
    return {};
}

std::optional<double> MeasuredDepth::trusted_to(const FilterSettings& filter) const {
    const TriedFilters* const now = is_searched() ? found_among(tried, filter) : nullptr;
    if (!now) return {};
    const double width = pixel / median, here = patches->median_depth();  // a pixel is width depth wide
    double to = farthest;
    // Nowhere if the length is so many pixels wide at the median already, or up to the larger depth at which
    // constant + quadratic depth^2 = most width depth.
    const auto limit = [&](const DepthLength& length, double most) {
        if (length.at(median) >= most * width * median) {
            to = 0;
        } else if (length.quadratic > 0) {
            const double half = most * width / (2 * length.quadratic);
            to = std::min(to, half + std::sqrt(half * half - length.constant / length.quadratic));
        }
    };
    if (now->terraces) limit(now->levels, most_removed);
    // A lean grows like depths' scatter in pixels' widths. In one picture it may be relief as fine as pixels.
    const DepthLength scatter = patches->roughness();
    if (now->left_deg < most_lean_deg)
        limit(scatter, scatter.at(here) / (width * here) * most_lean_deg / now->left_deg);
    else if (from_a_camera())
        to = 0;
    return to < farthest ? std::optional(to) : std::nullopt;
}

bool MeasuredDepth::is_noisy(int width) const {
    return noise_at_median() >= noise_per_picture * pixel * width;
}

namespace {

/// Depths at every fourth pixel of every fourth row; 0: invalid.
std::vector<float> some_depths(const CodePicture& picture, const DepthCoding& coding) {
    constexpr int apart = 4;
    std::vector<float> depths;
    for (int y = 0; y < picture.height; y += apart)
        for (int x = 0; x < picture.width; x += apart) {
            const int code = picture.row(y)[x];
            const bool is_valid = code != CodePicture::invalid;
            depths.push_back(is_valid ? static_cast<float>(coding.depth(static_cast<std::uint16_t>(code)))
                                      : 0);
        }
    return depths;
}

/// The median over common pixels of the ratio of both depths, or its inverse, whichever is above 1; 1 without
/// common pixels.
double times_as_deep(const std::vector<float>& one, const std::vector<float>& other) {
    std::vector<float> ratios;
    for (std::size_t k = 0; k < std::min(one.size(), other.size()); ++k)
        if (one[k] > 0 && other[k] > 0) ratios.push_back(one[k] / other[k]);
    if (ratios.empty()) return 1;
    const double times = sorted_element(ratios, ratios.size() / 2);
    return std::max(times, 1 / times);
}

/// How two kinds of frames differ that alternate, such as infrared and depth; 1: none, or under four frames.
double alternation(const std::vector<std::vector<float>>& frames) {
    constexpr double differ_by = 1.5, agree_within = 1.1;
    if (frames.size() < 4) return 1;
    const auto factor = [&](std::size_t one, std::size_t other) {
        return times_as_deep(frames[one], frames[other]);
    };
    if (factor(0, 2) > agree_within || factor(1, 3) > agree_within) return 1;
    const double least = std::min({factor(0, 1), factor(1, 2), factor(2, 3)});
    return least > differ_by ? least : 1;
}

}  // namespace

void DepthEstimator::add(const RawFrame& frame) {
    const CodePicture picture = code_picture(middle_part(frame.depth), scene_.depth);
    levels_.add(picture);
    contours_.add(picture);
    last_.push_back(SmoothPatches::cropped(picture));
    if (last_.size() > SmoothPatches::frames) last_.pop_front();
    noise_.add(picture);
    if (added_ < first_few) first_few_.push_back(some_depths(picture, scene_.depth));
    ++added_;
}

bool DepthEstimator::enough() const {
    if (added_ != first_few) return added_ >= frames;
    const auto so_far = measured_without_trying();
    return so_far && !so_far->is_searched();
}

std::optional<MeasuredDepth> DepthEstimator::measured() const {
    auto measured = measured_without_trying();
    if (!measured) return measured;
    if (!measured->is_searched() && measured->kappa < least_kappa) return measured;
    measured->patches =
        std::make_shared<const SmoothPatches>(scene_, last_, measured->noise, measured->levels);
    measured->tried = measured->is_searched()
                          ? tried_filters(*measured->patches, measured->levels,
                                          measured->is_noisy(scene_.width) ? measured->noise : DepthLength{})
                          : tried_removal(*measured->patches, measured->levels);
    return measured;
}

std::optional<MeasuredDepth> DepthEstimator::measured_without_trying() const {
    const auto median = levels_.depth_of_share(50);
    if (!median) return std::nullopt;
    Scene scene = scene_;
    if (scene.filter.levels == DepthLength{}) scene.filter.levels = levels_.levels();
    using Place = NoiseEstimator::Place;
    return MeasuredDepth{.frames = added_,
                         .median = *median,
                         .farthest = levels_.depth_of_share(99).value_or(*median),
                         .pixel = *median / scene.camera.fx,
                         .levels = scene.filter.levels,
                         .distance = level_distance(scene, *median),
                         .kappa = kappa_of_depth(scene, *median),
                         .contours = contours_.contours(),
                         .noise = noise_.noise(Place::flat),
                         .noise_at_edges = noise_.noise(Place::edge).at(*median),
                         .noise_at_rims = noise_.noise(Place::rim).at(*median),
                         .roughness = noise_.roughness().at(*median),
                         .wide_roughness = noise_.wide_roughness().at(*median),
                         .smooth = noise_.smooth(),
                         .changing = noise_.changing(),
                         .dropouts = noise_.dropouts(),
                         .tiny_holes = noise_.tiny_holes(),
                         .flying = noise_.flying(),
                         .midway = noise_.midway(),
                         .clean_edges = noise_.clean_edges(),
                         .alternates_by = alternation(first_few_),
                         .tried = {},
                         .patches = {}};
}

bool removal_advised(const MeasuredDepth& measured, const Scene& scene) {
    Scene with_levels = scene;
    with_levels.filter.levels = measured.levels;
    if (!has_working_codes(with_levels)) return false;
    const bool is_coarse = measured.kappa >= kappa_of_terraces;
    const bool is_judged = !measured.is_searched() && measured.tried.size() == 2;
    if (!is_judged || (is_coarse && measured.contours.are_wide())) return is_coarse;
    const double off = measured.tried[0].left_deg, on = measured.tried[1].left_deg;
    return on <= (is_coarse ? hardly_more : clearly_less) * off;
}

void choose_filters(const std::optional<MeasuredDepth>& measured, const UnstatedFilters& unstated,
                    Scene& scene) {
    FilterSettings& filter = scene.filter;
    if (!measured) {
        if (filter.terraces == TerraceRemoval::automatic) filter.terraces = TerraceRemoval::off;
        return;
    }
    if (unstated.temporal) filter.temporal = measured->is_noisy(scene.width);
    if (const auto best = best_of_tried(*measured, unstated, filter)) {
        const FilterSettings stated = filter;
        best->apply(measured->noise, filter);
        if (!unstated.temporal) filter.temporal = stated.temporal;
        filter.temporal_noise = stated.temporal_noise;
        if (unstated.terrace_reach && !measured->is_searched()) widen_reach(*measured, scene);
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
            "first frames show no noise; give that noise in scene units",
            {{Setting::temporal, "1.5"}});
    if (auto valid = validate(scene); !valid) return usage_error(valid.error().message);
    return {};
}

}  // namespace touchable
