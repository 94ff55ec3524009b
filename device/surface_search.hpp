#pragma once

#include <glm/vec2.hpp>
#include <optional>

#include "device/surface_probe.hpp"
#include "haptics_cpu/workspace.hpp"

namespace touchable {

/// A rectangle of the picture, pixels, edges included.
struct PixelBox {
    glm::dvec2 least;
    glm::dvec2 greatest;

    bool contains(const glm::dvec2& p) const {
        return p.x >= least.x && p.x <= greatest.x && p.y >= least.y && p.y <= greatest.y;
    }
};

/// The middle of a picture, `fraction` (0..1] of its width and height.
PixelBox middle_of(const SurfaceProbe& probe, double fraction);

struct SurfacePoint {
    glm::dvec2 pixel;
    double depth;  ///< planar, scene units, > 0
};

/// The surface at `pixel`, or, walking outward in square rings of whole pixels inside `box`, at the nearest
/// pixel of the first ring that has any. Nothing where the box shows no surface at all.
std::optional<SurfacePoint> nearest_surface(const SurfaceProbe& probe, const glm::dvec2& pixel,
                                            const PixelBox& box);

/// Planar depth of the device's centre, scene units: where a hand works while no surface has been seen. For a
/// centre that is not in front of the camera, 0.16 m of device space.
double device_depth(const Workspace& workspace);

}  // namespace touchable
