#include "engine/content/strokes.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "engine/base/trigonometry.hpp"
#include "engine/content/families.hpp"

namespace touchable {
namespace {

constexpr double tick_seconds = 0.001;

/// Outward normal at T seconds into the stroke.
glm::dvec3 stroke_normal(double seconds) {
    const double widest = 50 * pi / 180, limit = 0.72;
    double nx = sine(widest * sine(2 * pi * 0.37 * seconds));
    double ny = sine(widest * sine(2 * pi * 0.29 * seconds + 1));
    const double lateral = nx * nx + ny * ny;
    if (lateral > limit) {
        const double shrink = std::sqrt(limit / lateral);
        nx *= shrink;
        ny *= shrink;
    }
    return {nx, ny, std::sqrt(1 - nx * nx - ny * ny)};
}

/// Folds a position beyond +-limit back; true where it did.
bool reflect(double& position, double limit) {
    if (std::fabs(position) <= limit) return false;
    position = position > 0 ? 2 * limit - position : -2 * limit - position;
    return true;
}

/// A position folded back between two walls that it has passed by less than their distance.
double fold(double position, double low, double high) {
    if (position < low) return 2 * low - position;
    return position > high ? 2 * high - position : position;
}

}  // namespace

GlobeStroke::GlobeStroke(CameraPreset preset, int width, int height)
    : sphere_(globe_sphere(preset, width, height)), units_per_metre_(sphere_.radius / globe_device_radius) {}

GlobeStroke::Goal GlobeStroke::at(int tick) const {
    assert(tick >= 0 && tick < approach_ticks + stroke_ticks);
    const int stroke_tick = std::max(0, tick - approach_ticks);
    const glm::dvec3 normal = stroke_normal(stroke_tick * tick_seconds);
    const double approach = static_cast<double>(std::min(tick, approach_ticks)) / approach_ticks;
    const double outside = 0.010 + (-0.001 - 0.010) * approach;  // metres of device space
    const double lateral = std::sqrt(normal.x * normal.x + normal.y * normal.y);
    return {sphere_.centre + (sphere_.radius + outside * units_per_metre_) * normal, normal,
            arcsine(lateral)};
}

ReliefStroke::ReliefStroke(Relief relief, int width, int height, double speed) : relief_(relief) {
    const double margin = 12;
    limit_x_ = 0.5 * tabletop_width - margin;
    limit_y_ = 0.5 * tabletop_width * (height - 1) / (width - 1) - margin;
    step_ = speed * 1000 * tick_seconds;
    assert(limit_y_ > step_);
}

ReliefStroke::Goal ReliefStroke::next() {
    const double t = static_cast<double>(tick_) * tick_seconds, entry = 0.25, above = 50;
    double under = 3.5 + 1.5 * sine(2 * pi * 0.9 * t);
    if (t < entry) under = -above + (under + above) * (t / entry);
    const Goal goal{{x_, y_, relief_z(relief_, x_, y_, t) - under}, under};
    advance();
    return goal;
}

void ReliefStroke::advance() {
    const double t = static_cast<double>(tick_) * tick_seconds;
    x_ += step_ * cosine(heading_);
    y_ += step_ * sine(heading_);
    if (reflect(x_, limit_x_)) heading_ = pi - heading_;
    if (reflect(y_, limit_y_)) heading_ = -heading_;
    heading_ += (0.9 * sine(2 * pi * 0.37 * t) + 0.4) * tick_seconds;
    ++tick_;
}

RandomWalk::RandomWalk(const Scene& scene, std::uint64_t seed)
    : camera_(scene.camera),
      low_(-2, -2, 0.9 * scene.depth.near),
      high_(scene.width + 1, scene.height + 1, 1.05 * scene.depth.far),
      random_(seed),
      at_(0) {
    jump();
}

void RandomWalk::jump() {
    for (int axis = 0; axis < 3; ++axis) at_[axis] = random_.within(low_[axis], high_[axis]);
}

glm::dvec3 RandomWalk::next() {
    if (random_.next() % 50 == 0) {
        jump();
    } else {
        const glm::dvec3 reach{1, 1, 3};
        for (int axis = 0; axis < 3; ++axis)
            at_[axis] = fold(at_[axis] + random_.within(-reach[axis], reach[axis]), low_[axis], high_[axis]);
    }
    return unproject(camera_, at_.x, at_.y, at_.z);
}

}  // namespace touchable
