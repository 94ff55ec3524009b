// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "bench/touch/touch_surface.hpp"
#include "device/point_motion.hpp"
#include "haptics_cpu/touch_solver.hpp"
#include "haptics_cpu/touch_step.hpp"

namespace touchable {

/// A closed loop without its stiffness: surface and metric, handle and hand, delay of forces.
struct LoopCase {
    TouchCase touch;
    HandleDynamics handle;
    int delay_ticks = 0;  ///< from reading a position to exerting its force
};

/// A pixel of the surface, and the outward normal there (world and device axes agree).
struct PressedPlace {
    int x = 0, y = 0;
    glm::dvec3 normal{0, 0, 1};
};
/// The normal of the true surface; if unknown, the direction back along the pixel's ray.
PressedPlace pressed_place(const TouchSurface& surface, int x, int y);

/// One finger pressed on a surface through a device. In each tick the position is read, the solver computes
/// its force, that force is exerted `delay_ticks` later and held for a tick, and the handle moves. The hand's
/// goal is so deep under the surface that it presses with `press_n` at rest, or less if that would be deeper
/// than `deepest`; the goal follows a moving surface. There is no force guard, because the stability of the
/// solver's own force is measured.
class ClosedLoop {
public:
    static constexpr double period_s = 0.001;
    static constexpr double press_n = 3;
    static constexpr double deepest = 0.005;  ///< device metres

    /// Begins at rest for a flat wall, with a nudge (m/s) inward. The surface must outlive the loop.
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
    Scene scene_;  // the surface's scene with this loop's stiffness
    TouchSolver solver_;
    Workspace workspace_;
    PressedPlace place_;
    double press_, depth_, intended_depth_;  // N; device metres under the surface: at rest, and the goal
    HeldHandle handle_;
    std::int64_t tick_ = 0;
    FingerState finger_;
    Contact contact_;
    std::vector<glm::dvec3> forces_;  // ring of delayed forces: the oldest at tick modulo size
};

}  // namespace touchable
