#pragma once

#include <glm/vec3.hpp>

#include "haptics_cpu/energy_account.hpp"

namespace touchable {

/// A damper beside the spring (docs/solver.md, Guard): b times the rate at which the hand's own motion
/// stretches it. What the surface's motion stretches is left out, so that it takes energy from the hand and
/// passes none on from the clip.
class ContactDamping {
public:
    /// b in N s/m; 0: none.
    explicit ContactDamping(double b) : b_(b) {}

    /// The damper's force, newtons, beside a spring of `stiffness` (N/m; 0 out of contact). After
    /// `account.move`, `ticks` after the one before. Only ever against the hand's `velocity` (m/s), and never
    /// so strong that the surface holds the finger back.
    glm::dvec3 force(const EnergyAccount& account, double stiffness, const glm::dvec3& velocity, int ticks);
    void lift() { rate_ = glm::dvec3(0.0); }

private:
    double b_;
    glm::dvec3 rate_{0.0};  // m/s, filtered
};

}  // namespace touchable
