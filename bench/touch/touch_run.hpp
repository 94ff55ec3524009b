#pragma once

#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <vector>

#include "bench/tick_times.hpp"
#include "bench/touch/touch_surface.hpp"
#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// Goals for one or more fingers, driven over a surface at 1 kHz of its own time. A tick is what the haptic
/// thread does in one: the field of the moment, then the solver for all fingers.
class TouchRun final : public TimedRun {
public:
    /// `goals`: tick by tick, in each the case's fingers. The surface must outlive the run.
    static Result<std::unique_ptr<TouchRun>> create(const TouchSurface& surface, const TouchCase& c,
                                                    const HapticProperties& properties,
                                                    std::vector<glm::dvec3> goals);

    int ticks() const override { return static_cast<int>(goals_.size() / fingers_.size()); }
    void restart() override;
    void tick(int k) override;

    std::span<const Contact> contacts() const { return contacts_; }
    /// What the first finger carries to the next tick.
    const FingerState& finger() const { return fingers_[0]; }
    HeightField field(int k) const;
    /// The surface's, with this run's properties.
    const Scene& scene() const { return scene_; }
    TouchMetric metric() const { return solver_.settings().metric; }
    double metres_per_scene_unit() const { return solver_.settings().metres_per_scene_unit; }

private:
    TouchRun(const TouchSurface& surface, const TouchCase& c, const HapticProperties& properties,
             const TouchSolver& solver, std::vector<glm::dvec3> goals);

    const TouchSurface& surface_;
    Scene scene_;  // of the surface, with this run's properties
    TouchSolver solver_;
    std::vector<glm::dvec3> goals_;
    std::vector<FingerState> fingers_;
    std::vector<Contact> contacts_;
};

/// What the solver did in a whole run.
struct RunCounts {
    double cells_per_tick = 0;  ///< lattice lines, faces and features looked at, over all fingers
    double events_mean = 0;     ///< features passed per finger and tick in contact
    int events_max = 0;
    int capped_ticks = 0;  ///< in which a finger ended at the event limit
};

/// cells_per_tick, ns_per_cell (of a tick of `mean_us`), events_mean, events_max, capped_ticks.
void add_figures(const RunCounts& counts, double mean_us, Figures& figures);

/// How far a proxy may lie behind the world's surface, relative to its 1/depth. In the world's metric only
/// roundings; the paper's triangles are flat in pixels and levels, which bends them in the world.
double behind_tolerance(TouchMetric metric);

/// What is wrong with a contact: its force is finite and as Hooke has it, its proxy not behind the surface.
/// nullptr if it is sound.
const char* fault_of(const Contact& contact, const HeightField& field, double metres_per_scene_unit,
                     double tolerance);

/// Runs it once, untimed, and looks at every tick: finite, force as Hooke has it, no proxy behind the
/// surface, and at least half of all ticks in contact.
Result<RunCounts> verify(TouchRun& run);

}  // namespace touchable
