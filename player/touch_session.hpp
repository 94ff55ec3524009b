#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "device/hand.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "player/surface_feed.hpp"

namespace touchable {

/// What happened in one tick; spans hold one element per finger.
struct TouchTick {
    std::int64_t tick = 0, time_ns = 0;
    const HeightField& field;
    const FramePair& pair;
    std::span<const glm::dvec3> goals;  ///< as the hand gave them
    std::span<const Contact> contacts;
    std::span<const GuardedForce> forces;
    double metres_per_scene_unit;
    double solve_us;  ///< field, solver and guard of all fingers, wall time
};

/// Somebody who wants to know of every tick: figures, a file of forces, a recording, a comparison.
class TouchSink {
public:
    virtual ~TouchSink() = default;
    virtual Result<void> take(const TouchTick& tick) = 0;
};

/// Everything about a run but the clip and the hand.
struct TouchSessionSettings {
    int fingers = 1;
    TouchSettings touch;
    GuardSettings guard;
    /// Nothing: as long as the hand's motion, or where that has no end as the clip, but 3 s at least.
    std::optional<std::int64_t> ticks;
    /// Time of a tick on the clip's clock; k ms by default. Must not go backward.
    std::function<std::int64_t(std::int64_t)> time_of_tick;
};

/// Offline touch: hand -> solver -> guard at 1 kHz of virtual time over a clip. When the clip has ended its
/// last surface stands still. The same inputs give the same forces, however fast or slow the machine is.
class TouchSession {
public:
    /// All references outlive the session.
    TouchSession(const Scene& scene, SurfaceFeed& feed, Hand& hand, const TouchSolver& solver,
                 const TouchSessionSettings& settings);

    /// To the end, or until the person asks to stop (an error then).
    Result<void> run(std::span<TouchSink* const> sinks);

private:
    bool is_over(std::int64_t tick) const;
    Result<void> tick(std::int64_t tick, std::span<TouchSink* const> sinks);

    const Scene& scene_;
    SurfaceFeed& feed_;
    Hand& hand_;
    const TouchSolver& solver_;
    TouchSessionSettings settings_;
    std::vector<glm::dvec3> goals_;
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
    std::vector<ForceGuard> guards_;
    std::vector<GuardedForce> forces_;
};

}  // namespace touchable
