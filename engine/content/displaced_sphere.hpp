#pragma once

#include <algorithm>
#include <cstddef>
#include <glm/vec3.hpp>
#include <optional>
#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/content/cube_grid.hpp"

namespace touchable {

/// A sphere of radius 1 around the origin that rises here and there: in direction d its surface is at 1 +
/// rise(d), the rise being bilinear between the points of a CubeGrid, at least 0.
class DisplacedSphere {
public:
    /// `rise`: of each point, at least 0. The grid has a multiple of 128 cells.
    DisplacedSphere(CubeGrid grid, std::vector<float> rise, RowBands& rows);

    double rise(const glm::dvec3& direction) const;  ///< of any length but 0
    double highest() const { return highest_; }

    /// The distance to where a ray first meets the surface, to double precision. `from` is outside of all of
    /// it, `ray` of length 1. (Of two crossings that lie within `least_step` the first may be missed.)
    std::optional<double> first_hit(const glm::dvec3& from, const glm::dvec3& ray) const;

    static constexpr double least_step = 1e-6;

private:
    /// What the rise, and its change per radian, are at most in a part of the surface.
    struct Bound {
        float highest, steepest;
    };
    /// Square tiles of cells, 0 to `count` - 1 along a face.
    struct Tiles {
        int side, count;
        double window;  ///< radians: a bound is that of a tile and of all that is so near to it
        std::vector<glm::dvec3> middles{};
        std::vector<double> radii{};  ///< radians from the middle, of the part of the sphere that it lies in
        std::vector<Bound> bounds{};

        std::size_t index(int face, int column, int row) const {
            return static_cast<std::size_t>((face * count + row) * count + column);
        }
        const Bound& at(const CubePlace& place) const {
            return bounds[index(place.face, std::min(static_cast<int>(place.x) / side, count - 1),
                                std::min(static_cast<int>(place.y) / side, count - 1))];
        }
    };
    Bound bound_of_cells(int face, int column, int row, int side) const;
    Tiles tiles_of(int side, RowBands& rows) const;
    void widen(Tiles& tiles, const Tiles& coarse, RowBands& rows) const;
    double rise_at(const CubePlace& place) const {
        return grid_.between(place, [this](std::size_t point) { return double{rise_[point]}; });
    }

    CubeGrid grid_;
    std::vector<float> rise_;
    double highest_ = 0;
    Tiles coarse_, fine_;
};

}  // namespace touchable
