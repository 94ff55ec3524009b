#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "player/draw/light_picture.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// A ring of a solid of revolution: its height along the axis, its radius, and the outline's normal there
/// (along the axis, away from it).
struct Ring {
    double height, radius;
    double normal_along, normal_away;
};

/// What a solid is made of.
struct SolidMaterial {
    glm::vec3 light{1.0F};  ///< colour, as light
    float opacity = 1;  ///< below 1: seen through, and behind other things too, more faintly; leaves z alone
};

/// A ball, or the mantle of a frustum: what an outline of two rings sweeps round its axis. World, scene
/// units.
struct Solid {
    glm::dvec3 foot{0.0};           ///< of a ball: its centre
    glm::dvec3 along{0.0, 1, 0.0};  ///< the axis, a unit vector
    Ring from{}, to{};              ///< of a ball its radius stands in `from`, and no more
    bool is_ball = false;
    SolidMaterial material;
};

void add_ball(std::vector<Solid>& solids, const glm::dvec3& centre, double radius,
              const SolidMaterial& material);

/// From `from` to `to`, a radius at either end; nothing where they are one point.
void add_rod(std::vector<Solid>& solids, const glm::dvec3& from, const glm::dvec3& to, double radius_from,
             double radius_to, const SolidMaterial& material);

/// Shaft and head from `from` to `to`, a radius of the shaft at either end; the head is shorter where the
/// arrow is.
void add_arrow(std::vector<Solid>& solids, const glm::dvec3& from, const glm::dvec3& to, double radius_from,
               double radius_to, const SolidMaterial& material);

/// Smoothly lit; opaque solids hide and are hidden by z.
void draw_solid(const ViewCamera& camera, const Solid& solid, LightPicture& picture);

}  // namespace touchable
