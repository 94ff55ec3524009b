#include "engine/surface/depth_estimator.hpp"

#include <algorithm>
#include <cstddef>

#include "engine/scene/terraces.hpp"

namespace touchable {
namespace {

/// Share of pixels from which on they are no chance.
constexpr double some_dropouts = 5e-4;
/// Noise is averaged from a ten-thousandth of the picture's width on. The hand's 16 cm are as wide as the
/// picture, so that is 0.016 mm for the hand, and 10 mN at 600 N/m.
constexpr double noise_per_picture = 1e-4;
/// Pixels that hang between two surfaces count from this share on.
constexpr double some_flying = 1e-4;
/// Where edges are clean there are more of these than so many times the pixels that hang midway.
constexpr double clean_edges_per_midway = 4;
/// Pixels across and down, in the middle: of larger pictures the rest tells no more of a camera.
constexpr int largest_part = 4096;

PlaneView middle_part(PlaneView depth) {
    const int width = std::min(depth.width, largest_part), height = std::min(depth.height, largest_part);
    depth.data += depth.stride * ((depth.height - height) / 2) +
                  std::ptrdiff_t{depth.bytes_per_sample} * depth.channels * ((depth.width - width) / 2);
    depth.width = width;
    depth.height = height;
    return depth;
}

}  // namespace

bool MeasuredDepth::from_a_camera() const {
    return noise != DepthLength{} || levels.quadratic > 0 || dropouts >= some_dropouts ||
           tiny_holes >= some_tiny_holes;
}

bool MeasuredDepth::has_flying_pixels() const {
    if (from_a_camera()) return flying >= some_flying;
    return midway >= some_flying && clean_edges <= clean_edges_per_midway * midway;
}

bool MeasuredDepth::is_noisy(int width) const {
    return noise_at_median() >= noise_per_picture * pixel * width;
}

DepthEstimator::DepthEstimator(const Scene& scene)
    : scene_(scene), levels_(scene.depth), noise_(scene.depth) {}

void DepthEstimator::add(const RawFrame& frame) {
    const CodePicture picture = code_picture(middle_part(frame.depth), scene_.depth);
    levels_.add(picture);
    contours_.add(picture);
    last_.push_back(SmoothPatches::cropped(picture));
    if (last_.size() > SmoothPatches::frames) last_.pop_front();
    noise_.add(picture);
    ++added_;
}

bool DepthEstimator::enough() const {
    if (added_ != first_few) return added_ >= frames;
    const auto so_far = measured_without_trying();
    return so_far && !so_far->from_a_camera();
}

std::optional<MeasuredDepth> DepthEstimator::measured() const {
    auto measured = measured_without_trying();
    if (!measured) return measured;
    if (measured->from_a_camera())
        measured->tried = tried_filters(SmoothPatches(scene_, last_), measured->levels,
                                        measured->is_noisy(scene_.width) ? measured->noise : DepthLength{});
    else if (measured->kappa >= kappa_of_terraces)
        measured->tried = tried_removal(SmoothPatches(scene_, last_), measured->levels);
    return measured;
}

std::optional<MeasuredDepth> DepthEstimator::measured_without_trying() const {
    const auto median = levels_.median_depth();
    if (!median) return std::nullopt;
    Scene scene = scene_;
    if (scene.filter.levels == DepthLength{}) scene.filter.levels = levels_.levels();
    using Place = NoiseEstimator::Place;
    MeasuredDepth measured;
    measured.frames = added_;
    measured.median = *median;
    measured.pixel = *median / scene.camera.fx;
    measured.levels = scene.filter.levels;
    measured.distance = level_distance(scene, *median);
    measured.kappa = kappa_of_depth(scene, *median);
    measured.contours = contours_.contours();
    measured.noise = noise_.noise(Place::flat);
    measured.noise_at_edges = noise_.noise(Place::edge).at(*median);
    measured.noise_at_rims = noise_.noise(Place::rim).at(*median);
    measured.roughness = noise_.roughness().at(*median);
    measured.dropouts = noise_.dropouts();
    measured.tiny_holes = noise_.tiny_holes();
    measured.flying = noise_.flying();
    measured.midway = noise_.midway();
    measured.clean_edges = noise_.clean_edges();
    return measured;
}

}  // namespace touchable
