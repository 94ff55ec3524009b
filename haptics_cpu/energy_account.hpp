#pragma once

#include <glm/vec3.hpp>
#include <optional>

#include "haptics_cpu/touch_solver.hpp"

namespace touchable {

/// The spring between proxy and goal as a device renders it: F = min(k |x|, max_force) along x = S (P - G), k
/// at most max_stiffness. F is the negative gradient of its energy, which is k x^2 / 2 and, where the force
/// is cut off, linear.
struct DeviceSpring {
    double max_stiffness;  ///< N/m
    double max_force;      ///< N

    /// Joules at stiffness k and a stretch of x2 = |x|^2, square metres.
    double energy(double k, double x2) const;
    /// Newtons per metre of x.
    double pull(double k, double x2) const;
    /// The stiffness at which a stretch of x2 > 0 stores `joules`; infinite where none stores so much.
    double stiffness(double joules, double x2) const;
};

/// Joules since the start, of one finger.
struct EnergyFigures {
    double work = 0;     ///< done on the hand by the forces that were held
    double surface = 0;  ///< put in by what was not the hand: a moving surface, a ramp, a jump's cancellation
    double stored = 0;   ///< in the spring now
    double created = 0;  ///< the most that work - surface + stored ever was
    double bound = 0;    ///< the most that holding each force for a tick can have created at a constant k

    /// Energy that nothing put in: positive where some was created; negative where friction, or the proxy's
    /// drop to a lower minimum, took some.
    double balance() const { return work - surface + stored; }
};

/// The books of one finger's energy, exact per tick (docs/solver.md, Energy). A tick: the surface moves under
/// the old goal, the goal moves against the force that is held, a new force is made and held.
class EnergyAccount {
public:
    EnergyAccount(const DeviceSpring& spring, double metres_per_scene_unit)
        : spring_(spring), metres_per_unit_(metres_per_scene_unit) {}

    /// What happened before this tick's force. `carried_stiffness`: k (N/m) in effect at the place to which
    /// the moving surface carried the proxy, nothing where there was no contact; `ramp`: the share of the
    /// spring that the guard lets through.
    void move(const Contact& contact, const std::optional<double>& carried_stiffness, double ramp);
    /// The spring's new energy, at the stiffness in effect (0 out of contact).
    void store(double stiffness);
    /// The force that is held until the next tick, newtons. `blended`: the part of it that is not the
    /// spring's, because the surface jumped (BlendedForce::difference); its work counts as the surface's.
    void hold(const glm::dvec3& force, const glm::dvec3& blended = glm::dvec3(0.0)) {
        held_ = force;
        blended_ = blended;
    }
    /// The spring's force at the stiffness in effect, as the device renders it.
    const glm::dvec3& spring_force() const { return spring_force_; }
    /// The hand's place is not known: the spring is let go, and the work of this tick is not booked.
    void lose_goal();

    // After `move`.
    /// What the spring may store without creating energy, joules.
    double allowed() const { return energy_before_ - work_of_tick_; }
    /// What it stores at a stiffness, and the stiffness (of a spring that stores any) for an energy.
    double energy(double stiffness) const { return ramp_ * spring_.energy(stiffness, x2_); }
    double stiffness(double joules) const { return spring_.stiffness(joules / ramp_, x2_); }
    /// S (P - G), and how the hand's motion in this tick changed it; metres.
    const glm::dvec3& stretch() const { return x_; }
    const glm::dvec3& stretched() const { return stretched_; }
    /// The hand's motion in this tick, metres.
    const glm::dvec3& step() const { return step_; }

    const EnergyFigures& figures() const { return figures_; }
    /// Joules created in this contact beyond what holding forces explains.
    double excess() const { return excess_; }

private:
    DeviceSpring spring_;
    double metres_per_unit_;
    bool started_ = false;
    glm::dvec3 goal_{0.0};          // scene units, of the last tick
    glm::dvec3 held_{0.0};          // N
    glm::dvec3 blended_{0.0};       // the part of it that is a jump's cancellation
    glm::dvec3 spring_force_{0.0};  // the part of it that was the spring's
    glm::dvec3 step_{0.0}, x_{0.0}, stretched_{0.0};
    double ramp_ = 1, x2_ = 0;
    std::optional<double> stiffness_before_;
    double energy_before_ = 0, work_of_tick_ = 0;
    double excess_ = 0;  // summed for itself: in the sums of a long run its joules would be roundings
    EnergyFigures figures_;
};

}  // namespace touchable
