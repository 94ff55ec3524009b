#pragma once

#include <glm/vec3.hpp>

namespace touchable {

/// Time constants of a point that is led.
struct LeadTimes {
    double across_s = 0.025;  ///< across the direction of view, s, at least a period
    double along_s = 0.09;    ///< along it, likewise
};

/// A point that follows a goal as a critically damped spring would draw it: without overshoot, smooth in
/// speed, and exact for a goal that stays where it is for a period. It is slower along one direction, in
/// which the goal may jump about, than across. The same bits everywhere.
class LedPoint {
public:
    LedPoint(const LeadTimes& times, double period_s);

    /// At rest.
    void put(const glm::dvec3& place);
    /// One period towards `goal`, no farther than `max_speed` (> 0) goes. `along`: a unit vector, or zero
    /// where no direction is slower than the others.
    void follow(const glm::dvec3& goal, const glm::dvec3& along, double max_speed);

    /// As it goes on, but from somewhere else.
    void shift(const glm::dvec3& way) { place_ += way; }

    const glm::dvec3& place() const { return place_; }
    const glm::dvec3& velocity() const { return velocity_; }

private:
    /// What is left of an offset from the goal and of a velocity after a period, per each of the two.
    struct Response {
        double place_per_place, place_per_velocity, velocity_per_place, velocity_per_velocity;
    };
    static Response response(double time_constant, double period_s);

    double period_s_;
    Response across_, along_;
    glm::dvec3 place_{0.0}, velocity_{0.0};
};

}  // namespace touchable
