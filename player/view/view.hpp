// SPDX-License-Identifier: Apache-2.0
#pragma once

// The camera from which a surface is viewed, and picking: what a pixel shows.
//
// A `Viewpoint` is the user's choice: the clip's own view, or an orbit round the middle of the visible scene
// (`subject_of`). `parse_viewpoint` parses it; `make_view` turns it into the `ViewCamera` of a picture of a
// given size, `own_view` gives that of the clip's camera. A picture and the picks in it share one camera:
//
//     const auto subject = subject_of(field);
//     const ViewCamera camera = make_view(viewpoint, scene, subject.middle, width, height);
//     const auto seen = pick(field, camera, x, y);  // of the picture's pixel (x, y)
//
// `pick` finds the surface as painters draw it, edges and walls included; `surface_on_way` finds the surface
// as it is felt; `values_at` returns all values of a pixel. World coordinates and depths are in scene units.
// Only `parse_viewpoint` fails (ErrorKind::usage).
// Threads: any may call all functions, several at once, while the field's frames live: they depend only on
// their arguments.

#include <cmath>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <limits>
#include <span>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"
#include "haptics_cpu/height_field.hpp"

namespace touchable {

/// A colour of 8 bits a channel: red in the lowest byte, then green and blue; the highest is 255.
using PackedColour = std::uint32_t;
constexpr PackedColour pack_colour(std::uint32_t r, std::uint32_t g, std::uint32_t b) {
    return r | g << 8 | b << 16 | 255U << 24;
}

/// The default viewpoint.
inline constexpr const char* usual_viewpoint = "orbit:az=20,el=15";

/// The viewpoint as the user gives it: "own" is the clip's camera; otherwise an orbit round the middle of the
/// visible scene, such as `usual_viewpoint`.
struct Viewpoint {
    /// The visible scene, world: valid pixels nearer than the far plane (where backgrounds are), at most 512
    /// a side, and the lower medians of their X, Y and Z. Without such pixels, the middle is the point at the
    /// far plane on the optical axis.
    struct Subject {
        glm::dvec3 middle{0.0};
        std::vector<glm::dvec3> points;
    };

    bool own = false;
    double azimuth = 0;    ///< degrees to the right of the clip's camera, -180 to 180
    double elevation = 0;  ///< degrees above it, -89 to 89
    /// 0.1 to 20; 1 is as far away as the clip's camera, 2 half as far; nullopt: `whole_zoom`.
    std::optional<double> zoom;
    std::optional<double> fov;  ///< vertical, degrees, 5 to 120; nullopt: the clip's
    /// Shows the orbit's centre at the clip camera's principal point, not in the picture's centre: an orbit
    /// without rotation then shows the clip's own view.
    bool keeps_axis = false;
};
Result<Viewpoint> parse_viewpoint(const std::string& words);

/// A pinhole view of a clip's lattice. Screen: x to the right, y down, picture from (0, 0) to (width, height)
/// pixels, pixel (i, j) has its centre at (i + 0.5, j + 0.5).
///
/// With z = near / distance along the viewing direction, 0 < z <= 1 for every surface; larger is nearer, 0 is
/// empty. (Filled gaps and holes have a smaller z, which is no distance: shaders/gap_fill.h.) Floats have the
/// same relative precision at every distance, and z is linear on the screen.
struct ViewCamera {
    /// The surface under a pixel of a picture.
    struct Pick {
        glm::dvec3 point;      ///< of the surface, world
        double x, y;           ///< the point's pixel, 0 to width - 1 and height - 1
        double depth;          ///< planar, scene units
        glm::dvec3 direction;  ///< of sight, unit length
        /// The line of sight hits the side that fingers come from. False: the back, as seen from behind the
        /// clip's scene.
        bool from_front;
        /// False: a hole, or in a turned view a wall (shaders/cut_rule.h), with nothing drawn behind it.
        bool drawn;

        glm::ivec2 pixel() const { return {std::lround(x), std::lround(y)}; }  ///< the nearest one
    };

    glm::dmat4 clip_from_world{1.0};    ///< (X, Y, Z, 1) -> clip space; 0 < z <= w is visible
    glm::dmat4 clip_from_lattice{1.0};  ///< (x, y, 1, q) -> clip space; q = 1 / planar depth
    glm::dvec3 eye{0.0};                ///< world
    int width = 0, height = 0;          ///< pixels
    double near = 0;                    ///< scene units
    double focal = 0;                   ///< pixels; screen size of an object as large as its distance, the
                                        ///< larger of x and y

    /// Screen position and z of a world point; nullopt if it is not in front of the near plane.
    std::optional<glm::dvec3> project(const glm::dvec3& world) const;
    /// The world point at a screen position and z > 0.
    glm::dvec3 unproject(double x, double y, double z) const;
    /// The direction of sight at a screen position: unit length, world.
    glm::dvec3 direction(double x, double y) const;
};

/// The clip's own view, as large as fits into the picture. `nearest`: the near plane, scene units along -Z.
ViewCamera own_view(const Scene& scene, int width, int height, double nearest);

/// The largest zoom, at most 1, at which an orbit round `centre` shows all `points` (world) except a few
/// outliers.
double whole_zoom(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre,
                  std::span<const glm::dvec3> points, int width, int height);

/// The viewpoint's view. `centre`: the orbit's centre, world. A missing zoom counts as 1.
ViewCamera make_view(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre, int width,
                     int height);

Viewpoint::Subject subject_of(const HeightField& field);

/// The first drawn triangle of `field` on the line of sight, from either side; without one, the first
/// triangle that is not drawn; nullopt if the line meets no triangle. Visits every lattice line from the eye
/// to the hit (the solver's cast would stop at walls, and ignores back faces): microseconds for the clip's
/// own view, fractions of a millisecond from the side. The search ends `farthest` scene units from the eye.
std::optional<ViewCamera::Pick> pick(const HeightField& field, const ViewCamera& camera, double x, double y,
                                     double farthest = std::numeric_limits<double>::infinity());

/// The felt surface along a straight path, projected along the clip camera's rays, so that no part of it is
/// hidden. Depths are planar, scene units.
struct SurfaceOnWay {
    double behind;   ///< the largest distance of the path behind the surface; below 0: all of it is in front
    double nearest;  ///< the surface's least depth along the path
};
/// The path runs between two world points in front of the clip's camera (z < 0). nullopt if it is beside the
/// picture.
std::optional<SurfaceOnWay> surface_on_way(const HeightField& field, const glm::dvec3& from,
                                           const glm::dvec3& to);

/// Values of a surface pixel: depth and height as drawn, properties as a finger feels them.
struct PixelValues {
    bool valid;                   ///< false: a hole; all values but the properties are the far plane's
    double depth;                 ///< in the coding's semantics (range or planar), height subtracted, scene
                                  ///< units
    double z;                     ///< planar depth: along the camera's axis, scene units
    double height;                ///< subtracted from the depth, scene units
    double height_mm;             ///< the same in millimetres, by the scene's unit
    HapticProperties properties;  ///< stiffness N/m
};
/// The values of pixel (x, y), 0 <= x < width, 0 <= y < height. `field` was made from `pair`.
PixelValues values_at(const HeightField& field, const FramePair& pair, int x, int y);

}  // namespace touchable
