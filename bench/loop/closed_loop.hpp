#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "bench/touch/touch_surface.hpp"
#include "device/point_motion.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {

/// A closed loop, but for its stiffness: what is touched in which metric, who holds what, how late forces
/// come.
struct LoopCase {
    TouchCase touch;
    HandleDynamics handle;
    int delay_ticks = 0;  ///< between reading a place and exerting the force it led to
};

/// A pixel of the surface, and the outward normal there (world and device axes agree).
struct PressedPlace {
    int x = 0, y = 0;
    glm::dvec3 normal{0, 0, 1};
};
/// The normal of the true surface; where none is known, back along the pixel's ray.
PressedPlace pressed_place(const TouchSurface& surface, int x, int y);

/// One finger that a person presses on a surface through a device, tick after tick: the place is read, the
/// solver finds its force, that force is exerted `delay_ticks` later and held for a tick, and the handle
/// moves. The hand means to be so deep under the surface that it presses with `press_n` once everything
/// rests, or less where that would be deeper than `deepest`; on a surface that moves it goes along. No force
/// guard takes part: what is asked is when the solver's own force is stable.
class ClosedLoop {
public:
    static constexpr double period_s = 0.001;
    static constexpr double press_n = 3;
    static constexpr double deepest = 0.005;  ///< device metres

    /// Begins where a flat wall would rest, at a nudge (m/s) inward. The surface must outlive the loop.
    static Result<ClosedLoop> create(const TouchSurface& surface, const LoopCase& c,
                                     const PressedPlace& place, double stiffness, double nudge);
    void tick();

    const HeldHandle& handle() const { return handle_; }
    bool touching() const { return contact_.touching; }

private:
    ClosedLoop(const TouchSurface& surface, const LoopCase& c, const PressedPlace& place, double stiffness,
               const TouchSolver& solver);
    glm::dvec3 surface_now() const;

    const TouchSurface& surface_;
    Scene scene_;  // of the surface, with this loop's stiffness
    TouchSolver solver_;
    Workspace workspace_;
    PressedPlace place_;
    double press_, depth_, intended_depth_;  // N; device metres under the surface, at rest and meant
    HeldHandle handle_;
    std::int64_t tick_ = 0;
    FingerState finger_;
    Contact contact_;
    std::vector<glm::dvec3> forces_;  // on their way, a ring: the oldest at tick modulo size
};

}  // namespace touchable
