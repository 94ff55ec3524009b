#pragma once

#include <glm/vec3.hpp>

namespace touchable {

/// The similarity between device metres and scene units: scene = origin + device / metres_per_scene_unit.
/// Axes agree (x right, y up, z towards the person).
struct Workspace {
    double metres_per_scene_unit = 0.001;  ///< S: device metres per scene unit, > 0
    glm::dvec3 origin{0, 0, 0};            ///< scene point of the device's centre

    glm::dvec3 to_scene(const glm::dvec3& device_metres) const {
        return origin + device_metres / metres_per_scene_unit;
    }
    glm::dvec3 to_device(const glm::dvec3& scene) const { return (scene - origin) * metres_per_scene_unit; }
};

/// The default: a picture `width` pixels wide, seen with focal length `fx` (pixels) at `median_depth` (scene
/// units), spans 0.16 m of device space; the device's centre is at that depth on the optical axis.
Workspace default_workspace(int width, double fx, double median_depth);

}  // namespace touchable
