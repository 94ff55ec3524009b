#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

#include "engine/scene/surface_timeline.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// What happened in one tick; spans hold one element per finger.
struct TouchTick {
    std::int64_t tick = 0, time_ns = 0;
    FramePair pair;    ///< in a log only its numbers, times and blend mean anything: frames are recycled
    double blend = 0;  ///< that the surface had: 0 where it holds the earlier frame
    std::span<const glm::dvec3> goals;  ///< as the hand gave them
    std::span<const Contact> contacts;
    std::span<const GuardedForce> forces;
    std::span<const double> shares{};  ///< of these, how much was sent to the hand, 0 to 1; empty: all
    double metres_per_scene_unit = 0;
    bool behind = false;  ///< a proxy was behind the surface by more than rounding explains
    double solve_us = 0;  ///< solver and guard of all fingers, wall time
    double late_us = 0;   ///< how long after its time it began; 0 in virtual time

    double share(std::size_t finger) const { return shares.empty() ? 1.0 : shares[finger]; }
    /// The force that was sent to a finger's hand, newtons, world axes.
    glm::dvec3 sent(std::size_t finger) const { return share(finger) * forces[finger].force; }
};

}  // namespace touchable
