#pragma once

#include <glm/vec3.hpp>
#include <limits>
#include <optional>

#include "haptics_cpu/height_field.hpp"
#include "player/draw/view_camera.hpp"

namespace touchable {

/// A line of sight: what is seen at a place of a picture lies on it.
struct ViewRay {
    glm::dvec3 eye;        ///< world
    glm::dvec3 direction;  ///< unit length
};
/// Of the screen position (x, y) of a view (ViewCamera).
ViewRay ray_of(const ViewCamera& camera, double x, double y);

/// What is under a place of a picture.
struct SurfacePick {
    glm::dvec3 point;      ///< of the surface, world
    double x, y;           ///< the point's pixel, 0 to width - 1 and height - 1
    double depth;          ///< planar, scene units
    glm::dvec3 direction;  ///< of sight, unit length
    /// Seen from the side that a finger comes from. False: through the back, as from behind the clip's scene.
    bool from_front;
    /// False: a hole, or in a turned view a wall (shaders/cut_rule.h), where nothing that is drawn lies
    /// behind.
    bool drawn;
};

/// The first triangle of `field` on the line of sight that painters draw, from either side; where there is
/// none, the first that they do not. Nothing where no triangle is met. It looks at every lattice line between
/// the eye and there (the solver's cast would stop at walls, and does not see backs): microseconds for the
/// clip's own view, fractions of a millisecond from the side. Nothing is looked for beyond `farthest` from
/// the eye, scene units.
std::optional<SurfacePick> pick(const HeightField& field, const ViewCamera& camera, double x, double y,
                                double farthest = std::numeric_limits<double>::infinity());

/// The surface that is felt along a straight way, as the clip's camera sees it: from there nothing of it is
/// hidden. Depths are planar, scene units.
struct SurfaceOnWay {
    double behind;   ///< how far the way is behind the surface where it is farthest; below 0: it is before it
    double nearest;  ///< of the surface
};
/// On the way between two places of the world before the clip's camera (z < 0). Nothing where that is beside
/// the picture.
std::optional<SurfaceOnWay> surface_on_way(const HeightField& field, const glm::dvec3& from,
                                           const glm::dvec3& to);

/// What a pixel of the surface is: depth and height as they are drawn, properties as a finger meets them.
struct PixelValues {
    bool valid;                   ///< false: a hole; all but the properties are those of the far plane
    double depth;                 ///< as the coding has it (range or planar), height taken off, scene units
    double depth_mm;              ///< the same, as the scene says what its unit is
    double z;                     ///< planar depth: along the camera's axis, scene units
    double height;                ///< taken off the depth, scene units
    double height_mm;             ///< likewise
    HapticProperties properties;  ///< stiffness N/m
};
/// Of pixel (x, y), 0 <= x < width, 0 <= y < height. `pair` is what `field` was made of.
PixelValues values_at(const HeightField& field, const FramePair& pair, int x, int y);

}  // namespace touchable
