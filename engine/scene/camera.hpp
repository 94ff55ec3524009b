#pragma once

#include <cmath>
#include <glm/vec3.hpp>
#include <optional>

namespace touchable {

/// What a depth measures: the distance along the pixel's ray (Eq. 3), or along -Z.
enum class DepthSemantics { range, planar };

/// Pinhole camera at the world's origin looking along -Z (X right, Y up), in the image's pixel frame: column
/// x to the right, row y down, pixel (i, j) at integer coordinates. Focal lengths and centre in pixels.
struct Camera {
    double fx = 0, fy = 0, cx = 0, cy = 0;

    /// The ray of pixel (x, y) is (u, v, -1).
    double u(double x) const { return (x - cx) / fx; }
    double v(double y) const { return -((y - cy) / fy); }
    /// L = |(u, v, -1)|: range divided by planar depth.
    double ray_length(double x, double y) const {
        const double a = u(x), b = v(y);
        return std::sqrt(a * a + b * b + 1.0);
    }
    bool operator==(const Camera&) const = default;
};

/// The paper's camera (Eq. 3): square pixels of `pixel_width`, same unit as `focal_length`; its lower-left
/// origin with W/2, H/2 becomes cx = W/2, cy = H/2 - 1 once rows are flipped.
Camera camera_from_focal_length(double focal_length, double pixel_width, int width, int height);

/// Planar depth (along -Z) of a depth of either meaning at pixel (x, y). Scene units.
double planar_depth(const Camera& camera, DepthSemantics semantics, double x, double y, double depth);

/// World point of pixel (x, y) at a planar depth. Scene units.
glm::dvec3 unproject(const Camera& camera, double x, double y, double planar_depth);

struct ImagePoint {
    double x, y;          ///< pixel frame
    double planar_depth;  ///< scene units, > 0
};
/// Where a world point is seen; nothing for a point that is not in front of the camera (Z >= 0).
std::optional<ImagePoint> project(const Camera& camera, const glm::dvec3& point);

}  // namespace touchable
