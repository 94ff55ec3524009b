#pragma once

#include <glm/vec3.hpp>

namespace touchable {

/// Takes back energy that a contact has created, as a damper of the hand's motion for as long as there is any
/// (Hannaford and Ryu 2002; docs/solver.md, Guard): alpha = excess / (T |v|^2), F -= alpha v.
class PassivityController {
public:
    /// `most`: the largest alpha, N s/m; 0: never.
    explicit PassivityController(double most) : most_(most) {}

    /// What to add to the force, newtons; `excess` in joules (EnergyAccount), velocity in m/s.
    glm::dvec3 force(double excess, const glm::dvec3& velocity) const;

private:
    double most_;
};

}  // namespace touchable
