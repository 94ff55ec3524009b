#include "engine/surface/depth_estimator.hpp"

#include <utility>

#include "engine/scene/terraces.hpp"

namespace touchable {
namespace {

/// Share of pixels from which on they are no chance.
constexpr double some_dropouts = 5e-4;

}  // namespace

bool MeasuredDepth::from_a_camera() const {
    return noise != DepthLength{} || levels.quadratic > 0 || dropouts >= some_dropouts ||
           tiny_holes >= some_tiny_holes;
}

DepthEstimator::DepthEstimator(const Scene& scene)
    : scene_(scene), levels_(scene.depth), noise_(scene.depth) {}

void DepthEstimator::add(const RawFrame& frame) {
    CodePicture picture = code_picture(frame.depth, scene_.depth);
    levels_.add(picture);
    noise_.add(std::move(picture));
    ++added_;
}

bool DepthEstimator::enough() const {
    if (added_ != first_few) return added_ >= frames;
    const auto so_far = measured();
    return so_far && !so_far->from_a_camera();
}

std::optional<MeasuredDepth> DepthEstimator::measured() const {
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
    measured.noise = noise_.noise(Place::flat);
    measured.noise_at_edges = noise_.noise(Place::edge).at(*median);
    measured.noise_at_rims = noise_.noise(Place::rim).at(*median);
    measured.roughness = noise_.roughness().at(*median);
    measured.dropouts = noise_.dropouts();
    measured.tiny_holes = noise_.tiny_holes();
    measured.flying = noise_.flying();
    return measured;
}

}  // namespace touchable
