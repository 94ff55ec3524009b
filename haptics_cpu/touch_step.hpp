#pragma once

#include <optional>
#include <vector>

#include "haptics_cpu/finger_guard.hpp"
#include "haptics_cpu/stale_surface.hpp"
#include "haptics_cpu/touch_tick.hpp"

namespace touchable {

/// N fingers from tick to tick: solver, jump cancellation, guard, and what they carry over. The one way a
/// tick is made, offline and live (docs/solver.md, A tick, file by file).
class TouchStep {
public:
    /// `solver` outlives this.
    TouchStep(const TouchSolver& solver, const GuardSettings& guard, int fingers);

    int fingers() const { return static_cast<int>(goals_.size()); }
    /// Where to put the goals of the next `run`.
    std::span<glm::dvec3> goals() { return goals_; }
    /// What the fingers carry over to the next tick.
    std::span<const FingerState> states() const { return fingers_; }
    /// What the next `run` touches is new to all fingers, as another clip is. The first one is. (Another
    /// moment of the same clip, a new epoch, is not: fingers stay where they are, and the surface jumps.)
    /// Each begins anew where its goal is; what is inside a surface then waits to be free (GuardSettings), or
    /// feels it come on as after a jump. Time goes on.
    void meet_new_surface();
    /// The hand was left alone before the next `run`, for so long that it may be anywhere and has no force
    /// any more (HapticLoop): as where a device comes back whose goals were missing. What is inside a surface
    /// then waits to be free (GuardSettings), or feels it ramp in. The forces of that tick have `guard_gap`.
    void come_back();
    /// No allocation, lock or I/O. The spans stay as they are until the next call. `tick` counts time: where
    /// it is more than 1 after the last one, that long has passed. Frames that are missing, or have not the
    /// scene's size, are a fault: forces ramp to zero. Where the newest is older than the guard's settings
    /// allow, forces ramp to zero as well (StaleSurface), and who comes back from there is one who was left
    /// alone; `time_ns` is of the same clock as the frames' times then.
    TouchTick run(std::int64_t tick, std::int64_t time_ns, const Scene& scene, const FramePair& pair);

private:
    void look_at_age(std::int64_t age_ns, int ticks);
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
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
    StaleSurface stale_;
    std::vector<FingerGuard> guards_;
    std::vector<GuardedForce> forces_;
};

}  // namespace touchable
