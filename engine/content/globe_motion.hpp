#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "engine/base/trigonometry.hpp"
#include "engine/content/scenes.hpp"

namespace touchable {

/// Axes of a turning globe in the world: the pole leans to the right and a little toward the camera, and what
/// faces the camera moves to the right.
class GlobeAxes {
public:
    GlobeAxes(const glm::dvec3& pole, double angle)
        : pole_(pole), east_(glm::normalize(glm::cross(pole_, glm::dvec3(0, 0, 1)))) {
        const glm::dvec3 toward = glm::cross(east_, pole_);
        const double c = cosine(angle), s = sine(angle);
        x_ = c * east_ - s * toward;
        z_ = s * east_ + c * toward;
    }
    /// A world direction in the globe's own frame: +Y its north pole, +Z longitude 0.
    glm::dvec3 place(const glm::dvec3& direction) const {
        return {glm::dot(direction, x_), glm::dot(direction, pole_), glm::dot(direction, z_)};
    }
    /// Back again.
    glm::dvec3 world(const glm::dvec3& place) const { return place.x * x_ + place.y * pole_ + place.z * z_; }

private:
    glm::dvec3 pole_, east_, x_, z_;
};

/// How a globe leans and turns. Whatever was not asked for is as of the procedural planet.
class GlobeMotion {
public:
    explicit GlobeMotion(const SceneOptions& options)
        : seconds_per_turn_(options.seconds_per_turn),
          first_turn_(options.first_longitude_degrees ? -*options.first_longitude_degrees / 360 : 0.2) {
        if (!options.axial_tilt_degrees) return;
        // In the direction in which the planet's pole leans, 0.36 to the right and 0.25 toward the camera.
        const double lean = *options.axial_tilt_degrees * pi / 180;
        const glm::dvec3 way = glm::normalize(glm::dvec3(0.36, 0, 0.25));
        pole_ = sine(lean) * way + glm::dvec3(0, cosine(lean), 0);
    }
    GlobeAxes axes(double t) const {
        const double turns = first_turn_ + t / seconds_per_turn_;
        return {pole_, 2 * pi * (turns - std::floor(turns))};
    }

private:
    glm::dvec3 pole_ = glm::normalize(glm::dvec3(0.36, 0.90, 0.25));
    double seconds_per_turn_, first_turn_;
};

}  // namespace touchable
