// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>

#include <algorithm>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "engine/scene/frames.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "tests/stress/drawn_scene.hpp"

/// What the stress suites touch, and what has to come of it.
namespace touchable::stress {

inline constexpr std::int64_t tick_ns = 1'000'000;

/// Something to touch and the hand that does: frames and goals tick by tick, the same from the same seed.
class StressRun {
public:
    explicit StressRun(Scene scene) : scene_(std::move(scene)) {
        touch_.metres_per_scene_unit = scene_.device_metres_per_unit.value_or(0.001);
    }
    virtual ~StressRun() = default;
    StressRun(const StressRun&) = delete;
    StressRun& operator=(const StressRun&) = delete;

    const Scene& scene() const { return scene_; }
    const TouchSettings& touch() const { return touch_; }
    const GuardSettings& guard() const { return guard_; }
    virtual std::size_t fingers() const { return 1; }

    /// Frames and goals of the next tick; ticks come as 0, 1, 2, ... The frames stay until the next call.
    virtual void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) = 0;

    /// The promise of this run beyond the invariants of all runs that a tick breaks; empty where it is kept.
    virtual std::string broken_promise(std::int64_t /*tick*/, std::span<const Contact> /*contacts*/,
                                       std::span<const GuardedForce> /*forces*/) {
        return {};
    }
    /// Impossible input that was given and refused so far.
    virtual int refusals() const { return 0; }

protected:
    Scene scene_;
    TouchSettings touch_;
    GuardSettings guard_;
};

/// One picture that stands still, and a hand that is up to the suite. All fingers have the same goal.
class StillRun : public StressRun {
public:
    StillRun(const Scene& scene, const DrawnPlanes& planes) : StillRun(scene) { show(planes); }
    void next(std::int64_t tick, FramePair& pair, std::span<glm::dvec3> goals) final {
        pair.prev = pair.next = {0, 0, &frame_};
        pair.blend = 0;
        std::fill(goals.begin(), goals.end(), goal(tick));
    }

protected:
    /// Without a picture yet.
    explicit StillRun(const Scene& scene) : StressRun(scene) {}
    void show(const DrawnPlanes& planes) { FrameMaker(scene_).build(planes, frame_); }
    virtual glm::dvec3 goal(std::int64_t tick) = 0;

    SurfaceFrame frame_;
};

/// Coverage that a suite needs to be a test at all; share of all finger-ticks, or whether there has to be
/// any.
struct Needs {
    double contact = 0.1;
    bool frame_changes = false, refusals = false, held_goals = false;
};

/// A family of runs that is out to break the solver in one way; docs/paper.md lists them.
struct Suite {
    std::string_view name, what;
    std::unique_ptr<StressRun> (*make)(std::uint64_t seed);
    Needs needs;

    /// The suite's run of a seed; other suites draw other scenes from the same.
    std::unique_ptr<StressRun> run(std::uint64_t seed) const;
};

std::span<const Suite> suites();
/// nullptr for a name that is none.
const Suite* find_suite(std::string_view name);

// The makers, by what they stress.
std::unique_ptr<StressRun> make_uniform_noise(std::uint64_t seed);
std::unique_ptr<StressRun> make_checkerboard(std::uint64_t seed);
std::unique_ptr<StressRun> make_staircase(std::uint64_t seed);
std::unique_ptr<StressRun> make_spike_and_pit(std::uint64_t seed);
std::unique_ptr<StressRun> make_far_million(std::uint64_t seed);
std::unique_ptr<StressRun> make_wide_planes(std::uint64_t seed);
std::unique_ptr<StressRun> make_plateau(std::uint64_t seed);
std::unique_ptr<StressRun> make_tiny_pictures(std::uint64_t seed);

std::unique_ptr<StressRun> make_lattice_lines(std::uint64_t seed);
std::unique_ptr<StressRun> make_camera_axis(std::uint64_t seed);
std::unique_ptr<StressRun> make_far_goals(std::uint64_t seed);
std::unique_ptr<StressRun> make_corner_jumps(std::uint64_t seed);
std::unique_ptr<StressRun> make_five_fingers(std::uint64_t seed);
std::unique_ptr<StressRun> make_camera_plane(std::uint64_t seed);

std::unique_ptr<StressRun> make_height_limit(std::uint64_t seed);
std::unique_ptr<StressRun> make_impossible_planes(std::uint64_t seed);
std::unique_ptr<StressRun> make_not_finite(std::uint64_t seed);

std::unique_ptr<StressRun> make_rising(std::uint64_t seed);
std::unique_ptr<StressRun> make_cut_every_frame(std::uint64_t seed);
std::unique_ptr<StressRun> make_late_frames(std::uint64_t seed);
std::unique_ptr<StressRun> make_stopped_producer(std::uint64_t seed);
std::unique_ptr<StressRun> make_jumping_walls(std::uint64_t seed);

std::unique_ptr<StressRun> make_press_slide_retract(std::uint64_t seed);
std::unique_ptr<StressRun> make_stiffness_boundary(std::uint64_t seed);
std::unique_ptr<StressRun> make_encoder_dither(std::uint64_t seed);

}  // namespace touchable::stress
