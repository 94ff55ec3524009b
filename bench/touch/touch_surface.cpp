// SPDX-License-Identifier: Apache-2.0
#include "bench/touch/touch_surface.hpp"

#include <utility>

#include "bench/touch/solver_ticks.hpp"
#include "engine/surface/surface_builder.hpp"

namespace touchable {
namespace {

constexpr std::size_t frames_of_moving = 60;

SceneOptions options_of(const TouchCase& c) {
    SceneOptions options;
    options.width = c.width;
    options.height = c.height;
    if (c.bits != TouchCase::exact) options.bits = c.bits;
    options.preset = c.preset;
    return options;
}

bool same_surface(const TouchCase& a, const TouchCase& b) {
    return a.scene == b.scene && a.width == b.width && a.height == b.height && a.bits == b.bits &&
           a.preset == b.preset && a.median == b.median && a.terraces == b.terraces && a.lazy == b.lazy;
}

}  // namespace

TouchSurface::TouchSurface(std::unique_ptr<AnalyticScene> content, const TouchCase& c)
    : content_(std::move(content)),
      exact_(c.scene, options_of(c)),
      scene_(content_->scene()),
      frames_(c.scene == "moving" ? frames_of_moving : 1) {
    scene_.filter.median = c.median;
    if (c.terraces) scene_.filter.terraces = TerraceRemoval::on;
}

Result<std::unique_ptr<const TouchSurface>> TouchSurface::make(const TouchCase& c) {
    auto content = make_scene(c.scene, options_of(c));
    if (!content) return content.error();
    std::unique_ptr<TouchSurface> surface(new TouchSurface(std::move(content).value(), c));
    if (auto built = surface->build(c); !built) return built.error();
    return std::unique_ptr<const TouchSurface>(std::move(surface));
}

Result<void> TouchSurface::build(const TouchCase& c) {
    const auto builder = c.lazy ? make_lazy_builder(scene_) : make_cpu_builder(scene_);
    for (std::size_t n = 0; n < frames_.size(); ++n) {
        const auto number = static_cast<std::int64_t>(n);
        if (c.bits == TouchCase::exact) {
            exact_frame(*content_, number, frames_[n]);
        } else if (auto built = builder->build(content_->frame(number), frames_[n]); !built) {
            return built;
        }
    }
    return {};
}

FramePair TouchSurface::pair_at(std::int64_t time_ns) const {
    if (frames_.size() > 1) return frames_around(scene_.rate, frames_, time_ns);
    const TimedFrame only{0, 0, &frames_[0]};
    return {only, only};
}

Result<const TouchSurface*> SurfaceShelf::take(const TouchCase& c) {
    if (!surface_ || !same_surface(c, made_for_)) {
        surface_.reset();  // memory does not suffice for two of the largest
        auto made = TouchSurface::make(c);
        if (!made) return made.error();
        surface_ = std::move(made).value();
        made_for_ = c;
    }
    return surface_.get();
}

}  // namespace touchable
