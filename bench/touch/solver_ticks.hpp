// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "bench/tick_times.hpp"
#include "bench/touch/touch_surface.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// Moves the goals of one or more fingers over a surface at 1 kHz of its own time. A tick does the haptic
/// thread's work: the present field, then the solver for all fingers.
class SolverTicks : public TimedRun {
public:
    /// `goals`: all fingers of tick 0, of tick 1, ... The surface must outlive the run.
    static Result<std::unique_ptr<SolverTicks>> create(const TouchSurface& surface, const TouchCase& c,
                                                       const HapticProperties& properties,
                                                       std::vector<glm::dvec3> goals);
    /// Over the frames of any moment, ns.
    using PairAt = std::function<FramePair(std::int64_t)>;
    SolverTicks(PairAt pair_at, const Scene& scene, const TouchSolver& solver, int fingers,
                std::vector<glm::dvec3> goals);

    int ticks() const override { return static_cast<int>(goals_.size() / fingers_.size()); }
    void restart() override;
    void tick(int k) override;

    std::span<const Contact> contacts() const { return contacts_; }
    /// The first finger's state between ticks.
    const FingerState& finger() const { return fingers_[0]; }
    HeightField field(int k) const;
    /// The surface's, with this run's properties.
    const Scene& scene() const { return scene_; }
    TouchMetric metric() const { return solver_.settings().metric; }
    double metres_per_scene_unit() const { return solver_.settings().metres_per_scene_unit; }

private:
    PairAt pair_at_;
    Scene scene_;
    TouchSolver solver_;
    std::vector<glm::dvec3> goals_;
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
};

/// The frames around a time from 0 on, at an even rate; after the last of `frames` they begin anew.
FramePair frames_around(const FrameRate& rate, std::span<const SurfaceFrame> frames, std::int64_t time_ns);

/// Counts of the solver over a whole run.
struct RunCounts {
    double cells_per_tick = 0;  ///< lattice lines, faces and features visited, over all fingers
    double events_mean = 0;     ///< features passed per finger and tick in contact
    int events_max = 0;
    int capped_ticks = 0;  ///< ticks in which a finger reached the event limit
};

/// Appends cells_per_tick, ns_per_cell (for a tick of `mean_us`), events_mean, events_max, capped_ticks.
void add_figures(const RunCounts& counts, double mean_us, Figures& figures);

/// Largest distance of a proxy behind the world's surface, relative to its 1/depth. In the world metric only
/// rounding; the paper's triangles are flat in pixels and levels, so they are curved in the world.
double behind_tolerance(TouchMetric metric);

/// What is wrong with a contact; nullptr if its force is finite and obeys Hooke's law and its proxy is not
/// behind the surface.
const char* fault_of(const Contact& contact, const HeightField& field, double metres_per_scene_unit,
                     double tolerance);

/// Runs the ticks once, untimed, and checks each (fault_of); at least half of all ticks must be in contact.
Result<RunCounts> verify(SolverTicks& run);

}  // namespace touchable
