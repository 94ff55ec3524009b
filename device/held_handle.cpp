#include "device/held_handle.hpp"

#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {

namespace {

// Friction changes within a period; all else is integrated exactly over any step.
constexpr int steps_with_friction = 20;

}  // namespace

HeldHandle::HeldHandle(const HandleDynamics& dynamics, double period_s)
    : dynamics_(dynamics), steps_(dynamics.friction > 0 ? steps_with_friction : 1) {
    assert(dynamics.mass > 0 && period_s > 0 && dynamics.damping * period_s <= dynamics.mass);
    const double h = period_s / steps_;
    const double spring = dynamics.hand_stiffness / dynamics.mass, loss = dynamics.damping / dynamics.mass;
    // h (1 + A h / 2! + (A h)^2 / 3! + ...), A = [0 1; -spring -loss], row by row.
    double xx = h, xv = 0, vx = 0, vv = h;          // the term
    double sxx = xx, sxv = xv, svx = vx, svv = vv;  // and the sum
    for (int k = 2; k < 40; ++k) {
        const double f = h / k;
        const double nxx = f * vx, nxv = f * vv;
        vx = f * (-spring * xx - loss * vx);
        vv = f * (-spring * xv - loss * vv);
        xx = nxx;
        xv = nxv;
        sxx += xx;
        sxv += xv;
        svx += vx;
        svv += vv;
    }
    place_per_velocity_ = sxx;
    place_per_acceleration_ = sxv;
    velocity_per_velocity_ = svx;
    velocity_per_acceleration_ = svv;
}

void HeldHandle::put(const glm::dvec3& place, const glm::dvec3& velocity) {
    place_ = place;
    velocity_ = velocity;
}

void HeldHandle::advance(const glm::dvec3& force) {
    for (int k = 0; k < steps_; ++k) step(force);
}

void HeldHandle::step(const glm::dvec3& force) {
    glm::dvec3 pull = force + dynamics_.hand_stiffness * (intended_ - place_) - dynamics_.damping * velocity_;
    if (dynamics_.friction > 0) {
        // The friction that leaves it at rest; where that is more than Coulomb's, as much as there is.
        const double gain = velocity_per_acceleration_ / dynamics_.mass;
        glm::dvec3 friction = -pull - velocity_ * ((1.0 + velocity_per_velocity_) / gain);
        const double length = std::sqrt(glm::dot(friction, friction));
        if (length > dynamics_.friction) friction *= dynamics_.friction / length;
        pull += friction;
    }
    const glm::dvec3 acceleration = pull / dynamics_.mass;
    const glm::dvec3 before = velocity_;
    place_ += place_per_velocity_ * before + place_per_acceleration_ * acceleration;
    velocity_ += velocity_per_velocity_ * before + velocity_per_acceleration_ * acceleration;
}

glm::dvec3 HeldHandle::reading() const {
    const double q = dynamics_.quantum;
    if (!(q > 0)) return place_;
    return q * glm::dvec3(std::floor(place_.x / q + 0.5), std::floor(place_.y / q + 0.5),
                          std::floor(place_.z / q + 0.5));
}

}  // namespace touchable
