// SPDX-License-Identifier: Apache-2.0
#include "device/point_motion.hpp"

#include <cassert>

#include "engine/base/same_bits.hpp"

namespace touchable {
namespace {

// Friction may change within a period; all else is integrated exactly over any step.
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

void HeldHandle::step(const glm::dvec3& force) {
    glm::dvec3 pull = force + dynamics_.hand_stiffness * (intended_ - place_) - dynamics_.damping * velocity_;
    if (dynamics_.friction > 0) {
        // The friction that brings the body to rest, but at most Coulomb's.
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

LedPoint::Response LedPoint::response(double time_constant, double period_s) {
    const double x = period_s / time_constant;
    double term = 1, power = 1;  // exp(x), by its series: no library's exp is the same bits everywhere
    for (int k = 1; k < 30; ++k) {
        term *= x / k;
        power += term;
    }
    return {(1 + x) / power, period_s / power, -x / time_constant / power, (1 - x) / power};
}

void LedPoint::follow(const glm::dvec3& goal, const glm::dvec3& along, double max_speed) {
    const glm::dvec3 offset = place_ - goal;
    const glm::dvec3 offset_along = glm::dot(offset, along) * along, offset_across = offset - offset_along;
    const glm::dvec3 speed_along = glm::dot(velocity_, along) * along, speed_across = velocity_ - speed_along;
    const glm::dvec3 left = across_.place_per_place * offset_across +
                            across_.place_per_velocity * speed_across +
                            along_.place_per_place * offset_along + along_.place_per_velocity * speed_along;
    velocity_ = across_.velocity_per_place * offset_across + across_.velocity_per_velocity * speed_across +
                along_.velocity_per_place * offset_along + along_.velocity_per_velocity * speed_along;
    glm::dvec3 step = goal + left - place_;
    const double length = std::sqrt(glm::dot(step, step)), farthest = max_speed * period_s_;
    if (length > farthest) step *= farthest / length;
    const double speed = std::sqrt(glm::dot(velocity_, velocity_));
    if (speed > max_speed) velocity_ *= max_speed / speed;
    place_ += step;
}

std::optional<glm::dvec3> PlausibleMotion::believe(const glm::dvec3& place, std::int64_t time_ns) {
    if (!(glm::length(place) <= farthest)) return std::nullopt;  // refuses NaN, too
    if (!last_ || reaches(*last_, place, time_ns)) {
        last_ = Seen{place, time_ns};
        elsewhere_.reset();
        return place;
    }
    if (!elsewhere_ || !reaches(*elsewhere_, place, time_ns)) leapt_ns_ = time_ns;
    elsewhere_ = Seen{place, time_ns};
    if (time_ns - leapt_ns_ < lost_ns) return std::nullopt;
    last_ = elsewhere_;
    elsewhere_.reset();
    return place;
}

glm::dvec2 finger_offset(int finger, int fingers, double spread) {
    if (fingers == 1) return {0, 0};
    const double angle = 2 * pi * finger / fingers;
    return {spread * cosine(angle), spread * sine(angle)};
}

}  // namespace touchable
