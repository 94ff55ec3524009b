#pragma once

#include <array>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>
#include <span>
#include <string>

#include "engine/base/result.hpp"
#include "engine/scene/scene.hpp"

namespace touchable {

/// Where nobody says from where to look.
inline constexpr const char* usual_viewpoint = "orbit:az=20,el=15";

/// From where a surface is looked at, as a person says it: "own", the clip's camera, or like
/// `usual_viewpoint`, round the middle of what is seen.
struct Viewpoint {
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
};

/// (x, y, z, 1) of the screen -> clip space.
glm::dmat4 clip_from_pixel(const ViewCamera& camera);

/// Pixels, x and y: from there to before there.
struct PixelBounds {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// Those that a ball (world, scene units) may cover; nothing where its middle is not in sight.
std::optional<PixelBounds> bounds_of_ball(const ViewCamera& camera, const glm::dvec3& centre, double radius);
/// Their corners in clip space: least x and y, greatest x and y; all 0 for nothing.
glm::vec4 clip_bounds(const std::optional<PixelBounds>& bounds, const ViewCamera& camera);

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

}  // namespace touchable
