#pragma once

#include <cmath>
#include <cstddef>
#include <glm/vec3.hpp>
#include <vector>

#include "engine/base/trigonometry.hpp"

namespace touchable {

namespace cube_grid {

/// Nearly 4/pi times the arctangent of a tangent from -1 to 1, so that even steps of it are even angles to a
/// hundredth, without an arctangent.
inline constexpr double even_1 = 1.2732, even_3 = -0.3647, even_5 = 1 - even_1 - even_3;
inline double evened(double tangent) {
    const double square = tangent * tangent;
    return tangent * (even_1 + square * (even_3 + square * even_5));
}

}  // namespace cube_grid

/// A place on a face of a cube, in cells of its grid: 0 to `cells()` each way.
struct CubePlace {
    int face;
    double x, y;
};

/// Points all over a sphere: a square grid on each face of the cube around it, whose cells are nearly equal
/// as seen from the middle. No place is special, as the poles are of a map. A point on an edge of the cube is
/// a point of each face there, with the same direction to the bit, so what is bilinear between the points has
/// no seam.
class CubeGrid {
public:
    explicit CubeGrid(int cells);  ///< along each side of a face; even

    int cells() const { return cells_; }
    std::size_t points() const { return 6 * row_ * row_; }
    std::size_t index(int face, int i, int j) const {
        return (static_cast<std::size_t>(face) * row_ + static_cast<std::size_t>(j)) * row_ +
               static_cast<std::size_t>(i);
    }
    /// Unit vector to a point; i and j from 0 to `cells()`.
    glm::dvec3 direction(int face, int i, int j) const;
    /// Of a direction of any length but 0.
    CubePlace place(const glm::dvec3& direction) const;

    /// The mean angle from a point to the next one, radians.
    double spacing() const { return pi / (2 * cells_); }
    /// No two points are nearer to each other in angle than this many times their distance in cells.
    double least_spacing() const { return 1.0 / cells_; }

    /// Bilinear: `at(index)` of the four points around a place.
    template <class At>
    double between(const CubePlace& place, At&& at) const {
        const int i = column(place.x), j = column(place.y);
        const double right = place.x - i, below = place.y - j;
        const std::size_t first = index(place.face, i, j), next = first + row_;
        return (1 - below) * ((1 - right) * at(first) + right * at(first + 1)) +
               below * ((1 - right) * at(next) + right * at(next + 1));
    }

private:
    int column(double x) const { return x >= cells_ ? cells_ - 1 : static_cast<int>(x); }

    int cells_;
    std::size_t row_;              // points in a row
    std::vector<double> tangent_;  // of each column, -1 to 1 on the cube
};

inline CubePlace CubeGrid::place(const glm::dvec3& direction) const {
    const double x = std::fabs(direction.x), y = std::fabs(direction.y), z = std::fabs(direction.z);
    const double half = 0.5 * cells_;
    const auto on = [half](int axis, double major, double a, double b) {
        const double inverse = 1 / std::fabs(major);
        return CubePlace{2 * axis + (major < 0), half * (1 + cube_grid::evened(a * inverse)),
                         half * (1 + cube_grid::evened(b * inverse))};
    };
    if (x >= y && x >= z) return on(0, direction.x, direction.y, direction.z);
    if (y >= z) return on(1, direction.y, direction.z, direction.x);
    return on(2, direction.z, direction.x, direction.y);
}

}  // namespace touchable
