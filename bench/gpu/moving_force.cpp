// SPDX-License-Identifier: Apache-2.0
#include "bench/gpu/gpu_cases.hpp"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <string>

#include "engine/base/try.hpp"
#include "engine/surface/surface_builder.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "tests/content/exact_touch.hpp"

namespace touchable {
namespace {

constexpr int most_rate = 120, moving_ticks = 1000, first_counted_tick = 100;
constexpr double hand_x = 25, hand_y = 11, hand_circle = 0.5, hand_under = 3;  // mm
constexpr double reach_mm = 3;     // from the hand's middle: region on which a force depends
constexpr int filter_margin = 32;  // pixels: additional region that a filter reads
constexpr HapticProperties without_friction{600, 0, 0};

/// The hand's goal: on a small circle, under the present true surface.
glm::dvec3 hand_at(double t) {
    const double angle = 2 * std::numbers::pi * t;
    const double x = hand_x + hand_circle * std::cos(angle), y = hand_y + hand_circle * std::sin(angle);
    return {x, y, surface_at(Relief::moving, x, y, t).z - hand_under};
}

/// A still pair of one frame, at its exposure.
FramePair alone(const SurfaceFrame& frame, int n) {
    const std::int64_t time_ns = std::int64_t{1'000'000'000} * n / most_rate;
    return {{n, time_ns, &frame}, {n, time_ns, &frame}, 0};
}

/// When a frame is ready: frame number `frame`, counted from 0 at the rate, at time ready_s.
struct Arrival {
    double ready_s;
    int frame;
};
/// A free builder takes the newest frame.
std::vector<Arrival> arrivals_of(const MovingForce::Frames& frames) {
    std::vector<Arrival> arrivals;
    const double period = 1 / frames.rate, interval = std::max(1e-3 * frames.interval_ms, 1e-9);
    double begin = 0;
    for (int n = 0; n < static_cast<int>(frames.rate);) {
        arrivals.push_back({begin + 1e-3 * frames.latency_ms, n});
        const double free = begin + interval;
        const int newest = static_cast<int>(free / period);
        begin = newest > n ? free : (n + 1) * period;
        n = std::max(n + 1, newest);
    }
    return arrivals;
}

Result<TouchSolver> solver_of(const Scene& scene) {
    TouchSettings settings;
    settings.metres_per_scene_unit = scene.device_metres_per_unit.value();
    return TouchSolver::create(scene, settings);
}

}  // namespace

Result<MovingForce> MovingForce::make(int width, int height) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    MovingForce moving;
    TRY_ASSIGN(moving.content_, make_scene("moving", options));
    moving.crop(moving.content_->scene());
    TRY(moving.take_moments());
    moving.take_frames();
    return moving;
}

void MovingForce::crop(const Scene& whole) {
    scene_ = whole;
    scene_.default_properties = without_friction;
    double least_x = whole.width, least_y = whole.height, most_x = 0, most_y = 0;
    for (const double depth : {tabletop_distance - 25, tabletop_distance + 25})
        for (const double side : {-reach_mm, reach_mm}) {
            const double x = whole.camera.cx + whole.camera.fx * (hand_x + side) / depth;
            const double y = whole.camera.cy - whole.camera.fy * (hand_y + side) / depth;
            least_x = std::min(least_x, x);
            most_x = std::max(most_x, x);
            least_y = std::min(least_y, y);
            most_y = std::max(most_y, y);
        }
    left_ = std::max(0, static_cast<int>(least_x) - filter_margin);
    top_ = std::max(0, static_cast<int>(least_y) - filter_margin);
    scene_.width = std::min(whole.width, static_cast<int>(most_x) + filter_margin) - left_;
    scene_.height = std::min(whole.height, static_cast<int>(most_y) + filter_margin) - top_;
    scene_.camera.cx -= left_;
    scene_.camera.cy -= top_;
}

Result<void> MovingForce::take_moments() {
    const ExactSurface exact("moving");
    std::optional<glm::dvec3> nearest;  // tracked from tick to tick
    double squared = 0;
    const double n_per_unit = without_friction.stiffness * scene_.device_metres_per_unit.value();
    for (int k = 0; k < moving_ticks; ++k) {
        const double t = 0.001 * k;
        const glm::dvec3 goal = hand_at(t);
        const auto truth = exact.closest(goal, nearest.value_or(goal), t);
        if (!truth) return Error{ErrorKind::internal, "the moving surface knows no nearest point"};
        nearest = truth->point;
        ticks_.push_back({goal, n_per_unit * (truth->point - goal)});
        squared += glm::dot(ticks_.back().force, ticks_.back().force);
    }
    true_n_ = std::sqrt(squared / moving_ticks);
    return {};
}

void MovingForce::take_frames() {
    for (int n = 0; n < most_rate; ++n) {
        std::vector<std::uint16_t>& plane = planes_.emplace_back();
        for (int y = 0; y < scene_.height; ++y)
            for (int x = 0; x < scene_.width; ++x)
                plane.push_back(scene_.depth.code(
                    content_->depth(left_ + x, top_ + y, static_cast<double>(n) / most_rate)));
    }
}

/// Every `stride`th frame, filtered; with a temporal filter each depends on earlier frames.
Result<std::vector<std::unique_ptr<SurfaceFrame>>> MovingForce::built(const TimedFilter& filter,
                                                                      int stride) const {
    const auto builder = make_cpu_builder(with_filter(scene_, filter), {1});
    std::vector<std::unique_ptr<SurfaceFrame>> frames;
    for (int n = 0; n < most_rate; n += stride) {
        RawFrame raw;
        raw.number = n / stride;
        raw.depth = plane_of_codes(planes_[static_cast<std::size_t>(n)].data(), scene_.width, scene_.height);
        frames.push_back(std::make_unique<SurfaceFrame>());
        TRY(builder->build(raw, *frames.back()));
    }
    return frames;
}

Result<std::optional<MovingForce::Off>> MovingForce::off(const TimedFilter& filter, const Frames& how) const {
    const int stride = most_rate / static_cast<int>(how.rate);
    const Scene scene = with_filter(scene_, filter);
    TRY_ASSIGN(const auto frames, built(filter, stride));
    TRY_ASSIGN(const auto solver, solver_of(scene));
    const std::vector<Arrival> arrivals = arrivals_of(how);
    std::size_t arrived = 0;
    FingerState finger;
    Contact contact;
    double squared = 0, age = 0;
    int counted = 0;
    for (int k = 0; k < moving_ticks; ++k) {
        const double now = 0.001 * k;
        while (arrived < arrivals.size() && arrivals[arrived].ready_s <= now) ++arrived;
        if (arrived == 0) continue;
        const int n = arrivals[arrived - 1].frame;
        const Moment& moment = ticks_[static_cast<std::size_t>(k)];
        const SurfaceFrame& frame = *frames[static_cast<std::size_t>(n)];
        solver.tick(HeightField(scene, alone(frame, n * stride)), {&moment.goal, 1}, {&finger, 1},
                    {&contact, 1});
        if (k < first_counted_tick) continue;
        const glm::dvec3 off = contact.force - moment.force;
        squared += glm::dot(off, off);
        age += 1000 * (now - n / how.rate);
        ++counted;
    }
    if (counted == 0) return std::optional<Off>();
    Off off;
    off.n = std::sqrt(squared / counted);
    off.pct = 100 * off.n / true_n_;
    off.age_ms = age / counted;
    return std::optional(off);
}

Result<double> MovingForce::off_by_filter(const TimedFilter& filter) const {
    TRY_ASSIGN(const auto frames, built(filter, 1));
    const Scene scene = with_filter(scene_, filter);
    TRY_ASSIGN(const auto solver, solver_of(scene));
    double squared = 0;
    int counted = 0;
    // Only frames taken at the time of a tick.
    for (int n = 0; n < most_rate; n += most_rate / 40) {
        const Moment& moment = ticks_[static_cast<std::size_t>(n * moving_ticks / most_rate)];
        FingerState finger;
        Contact contact;
        for (const double above : {20.0, 0.0, 0.0, 0.0}) {
            const glm::dvec3 goal = moment.goal + glm::dvec3(0, 0, above);
            solver.tick(HeightField(scene, alone(*frames[static_cast<std::size_t>(n)], n)), {&goal, 1},
                        {&finger, 1}, {&contact, 1});
        }
        const glm::dvec3 off = contact.force - moment.force;
        squared += glm::dot(off, off);
        ++counted;
    }
    return std::sqrt(squared / counted);
}

}  // namespace touchable
