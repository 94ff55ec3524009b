#pragma once

// From where a surface is looked at, and what is seen at a place of a picture.
//
// A `Viewpoint` is what a person says: the clip's own view, or an orbit round the middle of what there is to
// see (`subject_of`). `parse_viewpoint` reads it; `make_view` makes of it the `ViewCamera` of a picture of
// some size, `own_view` that of the clip's camera. A picture and what asks what is seen in it share one
// camera:
//
//     const auto subject = subject_of(field);
//     const ViewCamera camera = make_view(viewpoint, scene, subject.middle, width, height);
//     const auto seen = pick(field, camera, x, y);  // of the picture's pixel (x, y)
//
// `pick` finds the surface as painters draw it, edges and walls included; `surface_on_way` the surface as it
// is felt; `values_at` everything that is known of a pixel. World coordinates and depths are in scene units.
// All are functions of their arguments alone: any thread may call them, several at once, as long as the
// field's frames stay. Only `parse_viewpoint` fails (ErrorKind::usage).

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

/// The viewpoint where none is given.
inline constexpr const char* usual_viewpoint = "orbit:az=20,el=15";

/// From where a surface is looked at, as a person says it: "own", the clip's camera, or like
/// `usual_viewpoint`, round the middle of what is seen.
struct Viewpoint {
    /// What there is to look at, world: a hundred thousand points at most of the valid pixels that are not at
    /// the far plane, where backgrounds are, and the lower medians of their X, Y and Z. Without any, the
    /// middle is the point at the far plane on the optical axis.
    struct Subject {
        glm::dvec3 middle{0.0};
        std::vector<glm::dvec3> points;
    };

    bool own = false;
    double azimuth = 0;    ///< degrees to the right of the clip's camera, -180 to 180
    double elevation = 0;  ///< degrees above it, -89 to 89
    /// 0.1 to 20; 1 is as far away as the clip's camera, 2 half as far. Nothing: `whole_zoom`.
    std::optional<double> zoom;
    std::optional<double> fov;  ///< vertical, degrees, 5 to 120; nothing: the clip's
    /// What an orbit goes round is seen where the clip's camera has its axis, not in the picture's centre: so
    /// an orbit that is not turned shows the clip's own view.
    bool keeps_axis = false;
};
Result<Viewpoint> parse_viewpoint(const std::string& words);

/// A pinhole view of a clip's lattice. Screen: x to the right, y down, picture from (0, 0) to (width, height)
/// pixels, pixel (i, j) has its centre at (i + 0.5, j + 0.5).
///
/// With z = near / distance along the viewing direction, what is drawn has 0 < z <= 1, nearer is more, and 0
/// is empty: in floating point equally precise relative to any distance, and linear on the screen.
struct ViewCamera {
    /// What is under a place of a picture.
    struct Pick {
        glm::dvec3 point;      ///< of the surface, world
        double x, y;           ///< the point's pixel, 0 to width - 1 and height - 1
        double depth;          ///< planar, scene units
        glm::dvec3 direction;  ///< of sight, unit length
        /// Seen from the side that a finger comes from. False: through the back, as from behind the clip's
        /// scene.
        bool from_front;
        /// False: a hole, or in a turned view a wall (shaders/cut_rule.h), where nothing that is drawn lies
        /// behind.
        bool drawn;
    };

    glm::dmat4 clip_from_world{1.0};    ///< (X, Y, Z, 1) -> clip space, where 0 < z <= w is seen
    glm::dmat4 clip_from_lattice{1.0};  ///< (x, y, 1, q) -> clip space; q = 1 / planar depth
    glm::dvec3 eye{0.0};                ///< world
    int width = 0, height = 0;          ///< pixels
    double near = 0;                    ///< scene units
    double focal = 0;                   ///< pixels: how large a thing of its own distance's size is at most

    /// Screen position and z of a world point; nothing where it is not in front of the near plane.
    std::optional<glm::dvec3> project(const glm::dvec3& world) const;
    /// The world point at a screen position and z > 0.
    glm::dvec3 unproject(double x, double y, double z) const;
    /// The direction of sight at a screen position: unit length, world.
    glm::dvec3 direction(double x, double y) const;
};

/// The clip's own view, as large as fits into the picture. Nothing nearer than `nearest` (scene units, along
/// -Z) is seen.
ViewCamera own_view(const Scene& scene, int width, int height, double nearest);

/// The largest zoom, at most 1, at which an orbit round `centre` shows `points` (world), a few outliers
/// aside.
double whole_zoom(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre,
                  std::span<const glm::dvec3> points, int width, int height);

/// The viewpoint's view. `centre`: what an orbit goes round, world. Without a zoom: 1.
ViewCamera make_view(const Viewpoint& viewpoint, const Scene& scene, const glm::dvec3& centre, int width,
                     int height);

Viewpoint::Subject subject_of(const HeightField& field);

/// The first triangle of `field` on the line of sight that painters draw, from either side; where there is
/// none, the first that they do not. Nothing where no triangle is met. It looks at every lattice line between
/// the eye and there (the solver's cast would stop at walls, and does not see backs): microseconds for the
/// clip's own view, fractions of a millisecond from the side. Nothing is looked for beyond `farthest` from
/// the eye, scene units.
std::optional<ViewCamera::Pick> pick(const HeightField& field, const ViewCamera& camera, double x, double y,
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
    double height_mm;             ///< the same, as the scene says what its unit is
    HapticProperties properties;  ///< stiffness N/m
};
/// The values of pixel (x, y), 0 <= x < width, 0 <= y < height. `pair` is what `field` was made of.
PixelValues values_at(const HeightField& field, const FramePair& pair, int x, int y);

}  // namespace touchable
