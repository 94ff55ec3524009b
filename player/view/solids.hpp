#pragma once

#include <glm/vec3.hpp>
#include <span>

#include "player/view/light_picture.hpp"
#include "player/view/view_camera.hpp"

namespace touchable {

/// A ring of a solid of revolution: its height along the axis, its radius, and the outline's normal there
/// (along the axis, away from it).
struct Ring {
    double height, radius;
    double normal_along, normal_away;
};

/// What a solid is made of.
struct Material {
    glm::vec3 light{1.0F};  ///< colour, as light
    float opacity = 1;  ///< below 1: seen through, and behind other things too, more faintly; leaves z alone
};

/// Draws what the outline `rings` sweeps round the axis from `foot` towards `along` (a unit vector), world,
/// scene units. Smoothly lit; opaque solids hide and are hidden by z.
void draw_solid(const ViewCamera& camera, const glm::dvec3& foot, const glm::dvec3& along,
                std::span<const Ring> rings, const Material& material, LightPicture& picture);

void draw_sphere(const ViewCamera& camera, const glm::dvec3& centre, double radius, const Material& material,
                 LightPicture& picture);

/// From `from` to `to`, a radius at either end; nothing where they are one point.
void draw_rod(const ViewCamera& camera, const glm::dvec3& from, const glm::dvec3& to, double radius_from,
              double radius_to, const Material& material, LightPicture& picture);

/// Shaft and head from `from` to `to`; the head is shorter where the arrow is.
void draw_arrow(const ViewCamera& camera, const glm::dvec3& from, const glm::dvec3& to, double shaft_radius,
                const Material& material, LightPicture& picture);

}  // namespace touchable
