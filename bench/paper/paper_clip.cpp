// SPDX-License-Identifier: Apache-2.0
#include "bench/paper/paper_clip.hpp"

#include <utility>

#include "bench/paper/chest_scene.hpp"
#include "bench/touch/solver_ticks.hpp"
#include "engine/base/try.hpp"

namespace touchable {
namespace {

constexpr std::size_t lazy_slots = 4;  // suffices for 64 ms at 30 frames/s

}  // namespace

glm::dvec3 PaperClip::surface_at(const glm::dvec2& place) const {
    const Camera& camera = scene.camera;
    const auto planar = [&](double x, double y) {
        return planar_depth(camera, scene.depth.semantics, x, y, depth(x, y));
    };
    const double per_metre = 1 / (scene.device_metres_per_unit.value() * planar(camera.cx, camera.cy));
    const double x = camera.cx + camera.fx * place.x * per_metre;
    const double y = camera.cy - camera.fy * place.y * per_metre;
    return unproject(camera, x, y, planar(x, y));
}

Result<std::shared_ptr<const PaperClip>> make_globe_clip(int width, int height, int turned_frames) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    options.bits = 8;
    options.properties = true;
    TRY_ASSIGN(const std::shared_ptr<const AnalyticScene> content, make_scene("globe", options));
    auto clip = std::make_shared<PaperClip>();
    clip->scene = content->scene();
    clip->depth = [content](double x, double y) { return content->depth(x, y, 0); };
    for (int n = 0; n <= turned_frames; ++n) clip->frames.push_back(content->frame(n));
    for (int n = turned_frames - 1; n > 0; --n)
        clip->frames.push_back(clip->frames[static_cast<std::size_t>(n)]);
    return std::shared_ptr<const PaperClip>(std::move(clip));
}

std::shared_ptr<const PaperClip> make_chest_clip(double noise_levels, int frames, std::int64_t first) {
    auto clip = std::make_shared<PaperClip>();
    clip->scene = chest_scene();
    clip->noise_levels = noise_levels;
    clip->depth = [camera = clip->scene.camera](double x, double y) { return chest_range(camera, x, y); };
    for (int n = 0; n < frames; ++n)
        clip->frames.push_back(noisy_chest_frame(clip->scene, noise_levels, first + n));
    return clip;
}

PlayedClip::PlayedClip(std::shared_ptr<const PaperClip> clip, const PaperFilter& filter)
    : clip_(std::move(clip)),
      scene_(clip_->scene),
      lazy_(filter.lazy),
      slots_(filter.lazy ? lazy_slots : clip_->frames.size()) {
    scene_.filter.median = filter.median;
    scene_.filter.terraces = filter.terraces ? TerraceRemoval::on : TerraceRemoval::off;
    scene_.filter.terrace_noise = clip_->noise_levels;
    scene_.filter.temporal = filter.temporal;
    scene_.filter.temporal_noise.constant = clip_->noise_levels * scene_.depth.level();
    builder_ = lazy_ ? make_lazy_builder(scene_) : make_cpu_builder(scene_);
}

Result<std::unique_ptr<PlayedClip>> PlayedClip::make(std::shared_ptr<const PaperClip> clip,
                                                     const PaperFilter& filter) {
    std::unique_ptr<PlayedClip> played(new PlayedClip(std::move(clip), filter));
    for (std::size_t n = 0; n < played->slots(); ++n) TRY(played->build(n));
    return played;
}

Result<void> PlayedClip::build(std::size_t n) {
    return builder_->build(raw(static_cast<std::int64_t>(n)), slots_[n]);
}

const RawFrame& PlayedClip::raw(std::int64_t number) const {
    return clip_->frames[static_cast<std::size_t>(number) % clip_->frames.size()];
}

std::size_t PlayedClip::slot(std::int64_t number) const {
    return static_cast<std::size_t>(number) % slots_.size();
}

void PlayedClip::play_to(std::int64_t time_ns) {
    // Cannot fail: `build` succeeded with frames of this form.
    for (; lazy_ && built_ <= scene_.rate.frame_at(time_ns) + 1; ++built_)
        static_cast<void>(builder_->build(raw(built_), slots_[slot(built_)]));
}

FramePair PlayedClip::pair_at(std::int64_t time_ns) const {
    return frames_around(scene_.rate, slots_, time_ns);
}

Result<TouchSolver> PlayedClip::solver(TouchMetric metric) const {
    TouchSettings settings;
    settings.metric = metric;
    settings.metres_per_scene_unit = scene_.device_metres_per_unit.value();
    return TouchSolver::create(scene_, settings);
}

}  // namespace touchable
