// SPDX-License-Identifier: Apache-2.0
#pragma once

// A tick of touch: goals in, forces out. The entry point for offline runs and for programs that have their
// own loop.
//
// TouchStep holds a solver and a guard for each finger. `run` takes the frames of the moment and the fingers'
// goals, solves each proxy (touch_solver.hpp), makes its force and guards it (force_guard.hpp), and returns a
// TouchTick with all results. A Workspace maps the device's metres to the scene. ForceHash is the hash by
// which two runs are compared; force_rules is the version of the rules by which forces are made: recordings
// name it.
//
// A force is a pure function of configuration, frames with timestamps, goals and the previous state.
// Threads: one at a time; a step neither waits nor allocates.

#include <functional>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "engine/base/same_bits.hpp"
#include "engine/scene/frames.hpp"
#include "haptics_cpu/force_guard.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// The similarity between device metres and scene units: scene = origin + device / metres_per_scene_unit.
/// Axes agree (x right, y up, z towards the person).
struct Workspace {
    double metres_per_scene_unit = 0.001;  ///< S: device metres per scene unit, > 0
    glm::dvec3 origin{0, 0, 0};            ///< scene point of the device's centre

    glm::dvec3 to_scene(const glm::dvec3& device_metres) const {
        return origin + device_metres / metres_per_scene_unit;
    }
    glm::dvec3 to_device(const glm::dvec3& scene) const { return (scene - origin) * metres_per_scene_unit; }
};

/// The default: a picture `width` pixels wide, seen with focal length `fx` (pixels) at `median_depth` (scene
/// units), spans 0.16 m of device space; the device's centre is at that depth on the optical axis.
Workspace default_workspace(int width, double fx, double median_depth);
/// The same for a scene, at its `device_metres_per_unit` if it has that.
Workspace default_workspace(const Scene& scene, double median_depth);

inline constexpr std::int64_t tick_ns = 1'000'000;  ///< duration of a tick

/// Results of one tick; spans hold one element per finger.
struct TouchTick {
    std::int64_t tick = 0, time_ns = 0;
    FramePair pair;    ///< in a log only its numbers, times and blend are valid: frames are recycled
    double blend = 0;  ///< of the surface: 0 if it holds the earlier frame
    std::span<const glm::dvec3> goals;  ///< as the hand gave them
    std::span<const Contact> contacts;
    std::span<const GuardedForce> forces;
    std::span<const double> shares{};  ///< share of each force that was sent to the hand, 0 to 1; empty: all
    double metres_per_scene_unit = 0;
    bool behind = false;  ///< a proxy was behind the surface by more than rounding explains
    double solve_us = 0;  ///< solver and guard of all fingers, wall time
    double late_us = 0;   ///< delay of its beginning; 0 in virtual time

    double share(std::size_t finger) const { return shares.empty() ? 1.0 : shares[finger]; }
    /// The force that was sent to a finger's hand, newtons, world axes.
    glm::dvec3 sent(std::size_t finger) const { return share(finger) * forces[finger].force; }
};

/// N fingers from tick to tick: solver, jump cancellation, guard, and their state. Ticks are made in this way
/// only, offline and live (docs/solver.md, A tick, file by file).
class TouchStep {
public:
    /// `solver` outlives this.
    TouchStep(const TouchSolver& solver, const GuardSettings& guard, int fingers);

    int fingers() const { return static_cast<int>(goals_.size()); }
    /// Memory for the goals of the next `run`.
    std::span<glm::dvec3> goals() { return goals_; }
    /// Memory for what the hand says of them, not 0: it lifts the finger over broken or rough ground. It is
    /// passed on, and changes no force.
    std::span<std::uint8_t> hops() { return hops_; }
    /// State of the fingers for the next tick.
    std::span<const FingerState> states() const { return fingers_; }
    /// The surface of the next `run` is new to all fingers, like another clip's. The first one is. (Another
    /// moment of the same clip, a new epoch, is not: fingers stay where they are, and the surface jumps.)
    /// Each finger begins anew where its goal is; inside a surface it then waits to be free (GuardSettings),
    /// or feels it come on as after a jump. Time goes on.
    void meet_new_surface();
    /// A hand without a tick for longer than this was left alone.
    static constexpr int longest_gap_ticks = 50;
    /// The hand was left alone before the next `run`, so it may be anywhere and has no force any more, like a
    /// device that comes back after missing goals. A finger inside a surface then waits to be free
    /// (GuardSettings), or feels it ramp in. The forces of that tick have `guard_gap`. `run` calls it after
    /// `longest_gap_ticks`; a caller, if its ticks do not tell.
    void come_back();
    /// No allocation, lock or I/O. The spans are valid until the next call. `tick` counts time: if it is more
    /// than 1 after the last one, that long has passed. Missing frames, or frames without the scene's size,
    /// are a fault: forces ramp to zero. If the newest is older than the guard's settings allow, forces ramp
    /// to zero as well (StaleSurface), and a finger that comes back from that counts as left alone; `time_ns`
    /// is then of the same clock as the frames' times.
    TouchTick run(std::int64_t tick, std::int64_t time_ns, const Scene& scene, const FramePair& pair);

    /// All that a coming tick depends on, but settings, frames and goals.
    void each_state(StateBytes& bytes);

private:
    void let_go();
    void solve(const HeightField& field, int ticks);
    void meet_nothing();
    void meet_anew(std::size_t finger);
    int ticks_until(std::int64_t tick);

    const TouchSolver& solver_;
    bool waits_to_be_free_;
    bool came_back_ = false;  // before the next tick
    std::optional<std::int64_t> last_tick_;
    std::vector<glm::dvec3> goals_;
    std::vector<std::uint8_t> hops_;
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
    StaleSurface stale_;
    std::vector<FingerGuard> guards_;
    std::vector<GuardedForce> forces_;
};

/// What a loop does in a tick: of a TouchRun (engine/run), or a program's own. Called by the haptic thread
/// only; must not wait.
struct HapticTicks {
    std::span<glm::dvec3> goals;   ///< of the next `solve`, one per finger
    std::span<std::uint8_t> hops;  ///< TouchStep::hops
    /// The surface of a tick; `after_gap`: the hand was left alone before (TouchStep::come_back).
    std::function<HeightField(std::int64_t tick, bool after_gap)> meet;
    /// The results of the tick that was met; spans are valid until the next call.
    std::function<TouchTick()> solve;
};

/// XXH64 (seed 0) over guarded forces as little-endian doubles fx, fy, fz (newtons, world axes), -0 written
/// as +0, ticks outer, fingers inner (docs/conventions.md, Units): equal hashes mean equal forces to the last
/// bit.
class ForceHash {
public:
    void add(const glm::dvec3& force);
    std::uint64_t value() const { return hash_.value(); }
    std::string hex() const { return hash_.hex(); }  ///< 16 digits
    void each_state(StateBytes& bytes) { hash_.each_state(bytes); }

private:
    ByteHash hash_;
};

/// Version of the rules by which forces are made. A change that is meant to give other forces for the same
/// frames and goals gets a new number and is described here; forces made under different numbers are not
/// compared. (Between two releases the number is raised once.)
///
/// 1: before the development of 0.1, and recordings that name no number. Haptic properties of the frame
///    nearer in time, friction where a facet is entered, velocities over one tick whatever time had passed.
/// 2: properties blended in time as depth is, friction of the place where a slide ends, velocities over the
///    time that has passed, no force on a goal that is buried when its surface is new, ramps that resume,
///    normals made of the sides that meet at a face's nearest corner, what is sudden by the hand's own time,
///    a jump's fade that rests while a goal is missing.
/// 3: no force comes back in one step: what damper and controller took off the spring returns by a ramp;
///    after ticks that were left out a surface's motion is felt as a jump, and a stale surface returns, as
///    far as in one tick; more than 50 of them are a gap.
/// 4: while a jump's cancellation fades, a slip, a crest or a landing reaches the hand in the share in which
///    the force does; stiffness rises by 4 N/m a tick at most.
inline constexpr int force_rules = 4;

}  // namespace touchable
