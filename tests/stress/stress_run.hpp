#pragma once

#include <span>
#include <string>

#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_solver.hpp"

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

    /// What this run promises of a tick beyond the invariants of all; empty where it is kept.
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

}  // namespace touchable::stress
