#pragma once

#include <glm/vec3.hpp>

#include "engine/content/scenes.hpp"

namespace touchable {

/// Camera and range coding of a preset (docs/scenes.md) at a size: the pixel width scales by 720/W, so the
/// horizontal field of view stays.
void apply_preset(CameraPreset preset, Scene& scene);

/// The globe's sphere: on the optical axis, filling 80 % of the picture's height. Scene units.
struct GlobeSphere {
    glm::dvec3 centre;
    double radius;
};
GlobeSphere globe_sphere(CameraPreset preset, int width, int height);

/// The device radius of the globe, in metres: S = globe_device_radius / radius.
inline constexpr double globe_device_radius = 0.032;

}  // namespace touchable
