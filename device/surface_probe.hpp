#pragma once

#include <glm/vec3.hpp>
#include <optional>

namespace touchable {

/// What a scripted hand may know of the surface it moves over, at the moment of the tick.
class SurfaceProbe {
public:
    virtual ~SurfaceProbe() = default;
    virtual int width() const = 0;   ///< pixels
    virtual int height() const = 0;  ///< pixels
    /// Planar depth of the surface under pixel (x, y), height taken off, scene units; nothing where a vertex
    /// of its cell is invalid or lies outside the picture.
    virtual std::optional<double> depth_under(double x, double y) const = 0;
    /// World point of pixel (x, y) at a planar depth, scene units.
    virtual glm::dvec3 unproject(double x, double y, double planar_depth) const = 0;
    /// Pixel of a world point in front of the camera (z < 0): (x, y, planar depth).
    virtual glm::dvec3 project(const glm::dvec3& point) const = 0;
};

}  // namespace touchable
