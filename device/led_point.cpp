#include "device/led_point.hpp"

#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

namespace touchable {

LedPoint::LedPoint(const LeadTimes& times, double period_s)
    : period_s_(period_s),
      across_(response(times.across_s, period_s)),
      along_(response(times.along_s, period_s)) {
    assert(period_s > 0 && times.across_s >= period_s && times.along_s >= period_s);
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

void LedPoint::put(const glm::dvec3& place) {
    place_ = place;
    velocity_ = glm::dvec3(0);
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

}  // namespace touchable
