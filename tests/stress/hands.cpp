#include "tests/stress/suites.hpp"

#include <algorithm>
#include <cmath>

#include "engine/base/same_bits.hpp"
#include "tests/stress/drawn_scene.hpp"

namespace touchable::stress {

namespace {

/// A position folded back between two walls that it has passed by less than their distance.
double fold(double position, double low, double high) {
    if (position < low) position = 2 * low - position;
    if (position > high) position = 2 * high - position;
    return std::clamp(position, low, high);
}

}  // namespace

Walk::Walk(const Scene& scene, std::uint64_t seed, const Reach& reach)
    : camera_(scene.camera),
      low_(-2, -2, 0.9 * nearest_depth(scene)),
      high_(scene.width + 1, scene.height + 1, 1.05 * scene.depth.far),
      reach_(reach.pixels, reach.pixels, reach.depth * (high_.z - low_.z)),
      jumps_(reach.jumps),
      random_(seed) {
    jump();
}

void Walk::jump() {
    for (int axis = 0; axis < 3; ++axis) at_[axis] = random_.within(low_[axis], high_[axis]);
}

glm::dvec3 Walk::next() {
    if (random_.unit() < jumps_)
        jump();
    else
        for (int axis = 0; axis < 3; ++axis)
            at_[axis] =
                fold(at_[axis] + random_.within(-reach_[axis], reach_[axis]), low_[axis], high_[axis]);
    return unproject(camera_, at_.x, at_.y, at_.z);
}

Skim::Skim(const Scene& scene, std::uint64_t seed, const Pace& pace)
    : scene_(scene), pace_(pace), random_(seed), depth_(scene.depth.far) {
    x_ = random_.within(0, scene.width - 1);
    y_ = random_.within(0, scene.height - 1);
    heading_ = random_.within(0, 2 * pi);
}

glm::dvec3 Skim::next(const SurfaceFrame& frame) {
    const double w = scene_.width - 1, h = scene_.height - 1;
    heading_ += random_.within(-0.1, 0.1);
    const double dx = pace_.pixels * cosine(heading_), dy = pace_.pixels * sine(heading_);
    if (x_ + dx < 0 || x_ + dx > w) heading_ = pi - heading_;
    if (y_ + dy < 0 || y_ + dy > h) heading_ = -heading_;
    x_ = fold(x_ + dx, 0, w);
    y_ = fold(y_ + dy, 0, h);

    const DepthSample under =
        frame.vertices->at(static_cast<int>(std::floor(x_ + 0.5)), static_cast<int>(std::floor(y_ + 0.5)));
    if (under.valid) depth_ = under.depth;
    const double phase = 2 * pi * (static_cast<double>(tick_++) / pace_.period);
    const double pressed = pace_.under * (scene_.depth.far - scene_.depth.near) * (0.7 + sine(phase));
    const double depth = std::max(0.01 * depth_, depth_ + pressed);
    return unproject(scene_.camera, x_, y_,
                     planar_depth(scene_.camera, scene_.depth.semantics, x_, y_, depth));
}

}  // namespace touchable::stress
