// SPDX-License-Identifier: Apache-2.0
#pragma once

// Parts of a globe of maps: maps interpolated between their pixels, values on a sphere in the grids of a
// cube, a sphere with relief and its intersection with a ray, and the smooth ground under mountains.

#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "engine/base/same_bits.hpp"
#include "engine/base/threads.hpp"
#include "engine/content/globe_maps.hpp"

namespace touchable {

/// The sum of a pixel's channels.
double mask_brightness(const GlobeMap& mask, int x, int y);
/// Whether the mask marks a pixel as land.
bool is_land(const GlobeMap& mask, const GlobeMaps::Shore& shore, int x, int y);

/// A place on a globe, each from 0 to 1: from west to east, and from north to south.
struct MapPlace {
    double east, south;
};
/// The place of a direction in the globe's own frame, length not 0: +Y north, +Z longitude 0, +X 90 degrees
/// east.
MapPlace map_place(const glm::dvec3& direction);

/// Bilinear between the pixels of one channel, also across the date line and the poles. `value(x, y)` returns
/// the value of a pixel.
template <class Value>
double between_pixels(const GlobeMap& map, const MapPlace& place, Value&& value) {
    const double column = place.east * map.width - 0.5, row = place.south * map.height - 0.5;
    const double left = column < 0 ? -1 : static_cast<int>(column),
                 upper = row < 0 ? -1 : static_cast<int>(row);
    const double right_share = column - left, lower_share = row - upper;
    // Beyond a pole lies the same row, half a turn further.
    const auto pixel = [&](int x, int y) {
        if (y < 0 || y >= map.height) {
            y = y < 0 ? 0 : map.height - 1;
            x += map.width / 2;
        }
        if (x < 0) x += map.width;
        if (x >= map.width) x -= map.width;
        return static_cast<double>(value(x, y));
    };
    const int x = static_cast<int>(left), y = static_cast<int>(upper);
    const double above = (1 - right_share) * pixel(x, y) + right_share * pixel(x + 1, y);
    const double below = (1 - right_share) * pixel(x, y + 1) + right_share * pixel(x + 1, y + 1);
    return (1 - lower_share) * above + lower_share * below;
}

namespace cube_grid {

/// Nearly 4/pi times the arctangent of a tangent from -1 to 1, without an arctangent: even steps of it are
/// even angles to a hundredth.
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

/// Points all over a sphere: a square grid on each face of the cube around it, whose cells have nearly equal
/// angles. It has no special places like the poles of a map. A point on an edge of the cube belongs to each
/// face there, with the same direction to the bit, so bilinear interpolation has no seam.
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
    /// The place of a direction of any length but 0.
    CubePlace place(const glm::dvec3& direction) const;

    /// The mean angle from a point to the next one, radians.
    double spacing() const { return pi / (2 * cells_); }
    /// Lower bound of the angle between two points per cell of their distance, radians.
    double least_spacing() const { return 1.0 / cells_; }

    /// Bilinear interpolation of `at(index)` of the four points around a place.
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

/// Two unit vectors perpendicular to a unit vector and to each other, defined everywhere, without a pole
/// (Duff et al., Building an Orthonormal Basis, Revisited).
inline std::pair<glm::dvec3, glm::dvec3> tangents(const glm::dvec3& n) {
    const double sign = n.z < 0 ? -1.0 : 1.0, a = -1 / (sign + n.z), b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

/// Values on a globe, 0 to 1, in several channels, and at ever coarser levels: a distant view shows means, so
/// that it does not shimmer. Directions are in the globe's own frame, of any length but 0.
template <std::size_t channels>
class CubePyramid {
public:
    using Values = std::array<double, channels>;

    /// `values(direction)` returns the mean within about a cell around a unit vector; threads that share the
    /// rows call it.
    template <class Of>
    CubePyramid(int cells, RowBands& rows, Of&& values) {
        levels_.push_back(filled(cells, rows, values));
        while (static_cast<int>(levels_.size()) < most_levels && levels_.back().grid.cells() % 4 == 0) {
            const Level& finer = levels_.back();
            const double step = finer.grid.spacing();
            Level coarser = filled(finer.grid.cells() / 2, rows,
                                   [&](const glm::dvec3& at) { return mean_around(finer, at, step); });
            levels_.push_back(std::move(coarser));
        }
    }

    /// The mean over about `width` radians.
    Values mean(const glm::dvec3& direction, double width) const {
        const Detail detail = detail_of(width);
        Values values = between(levels_[detail.finer], direction);
        if (detail.coarser_share > 0) {
            const Values coarse = between(levels_[detail.finer + 1], direction);
            for (std::size_t c = 0; c < channels; ++c)
                values[c] += detail.coarser_share * (coarse[c] - values[c]);
        }
        return values;
    }

private:
    static constexpr int most_levels = 5;
    static constexpr double unit = 65535;
    using Stored = std::array<std::uint16_t, channels>;
    struct Level {
        CubeGrid grid;
        std::vector<Stored> points;
    };
    struct Detail {
        std::size_t finer;
        double coarser_share;  ///< 0 to 1; weight of the next level
    };

    template <class Of>
    static Level filled(int cells, RowBands& rows, Of&& values) {
        Level level{CubeGrid(cells), {}};
        level.points.resize(level.grid.points());
        rows.for_each_band(6 * (cells + 1), 1, [&](const RowBand& band) {
            for (int row = band.first; row < band.last; ++row)
                for (int i = 0; i <= cells; ++i) {
                    const int face = row / (cells + 1), j = row % (cells + 1);
                    const Values at = values(level.grid.direction(face, i, j));
                    Stored& stored = level.points[level.grid.index(face, i, j)];
                    for (std::size_t c = 0; c < channels; ++c)
                        stored[c] = static_cast<std::uint16_t>(unit * std::clamp(at[c], 0.0, 1.0) + 0.5);
                }
        });
        return level;
    }

    static Values between(const Level& level, const glm::dvec3& direction) {
        const CubePlace place = level.grid.place(direction);
        Values values;
        for (std::size_t c = 0; c < channels; ++c)
            values[c] = level.grid.between(place, [&](std::size_t n) {
                return static_cast<double>(level.points[n][c]);
            }) / unit;
        return values;
    }
    /// Weights 1 2 1, across and down.
    static Values mean_around(const Level& finer, const glm::dvec3& at, double step) {
        const auto [across, down] = tangents(at);
        Values sum{};
        for (int j = -1; j <= 1; ++j)
            for (int i = -1; i <= 1; ++i) {
                const double weight = (2 - std::abs(i)) * (2 - std::abs(j)) / 16.0;
                const Values values = between(finer, at + (step * i) * across + (step * j) * down);
                for (std::size_t c = 0; c < channels; ++c) sum[c] += weight * values[c];
            }
        return sum;
    }

    /// Level n is the mean over 2^n cells of level 0; between two levels the mean is linear in the width.
    Detail detail_of(double width) const {
        double cells = width / levels_.front().grid.spacing();
        std::size_t finer = 0;
        for (; cells >= 2 && finer + 1 < levels_.size(); ++finer) cells *= 0.5;
        if (finer + 1 == levels_.size()) return {finer, 0};
        return {finer, std::clamp(cells - 1, 0.0, 1.0)};
    }

    std::vector<Level> levels_;
};

/// A sphere of radius 1 around the origin with a raised surface: in direction d it is at 1 + rise(d). The
/// rise is bilinear between the points of a CubeGrid, and at least 0.
class DisplacedSphere {
public:
    /// `rise`: of each point, at least 0. The grid must have a multiple of 128 cells.
    DisplacedSphere(CubeGrid grid, std::vector<float> rise, RowBands& rows);

    /// `direction`: of any length but 0.
    double rise(const glm::dvec3& direction) const { return rise_at(grid_.place(direction)); }
    double highest() const { return highest_; }

    /// The distance at which a ray first meets the surface, to double precision. `from` must be outside the
    /// whole surface, `ray` of length 1. (The first of two crossings within `least_step` may be missed.)
    std::optional<double> first_hit(const glm::dvec3& from, const glm::dvec3& ray) const;

    static constexpr double least_step = 1e-6;

private:
    /// Upper bounds of the rise, and of its change per radian, in a part of the surface.
    struct Bound {
        float highest, steepest;
    };
    /// Square tiles of cells, 0 to `count` - 1 along a face.
    struct Tiles {
        int side, count;
        double window;  ///< radians: a bound covers a tile and all that is this near to it
        std::vector<glm::dvec3> middles{};
        std::vector<double> radii{};  ///< radians from the middle that enclose the tile
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

/// Maps of a globe, prepared for its pictures. Lengths are in radii, directions in the globe's own frame.
struct MappedGround {
    /// Channels of `look`: linear light; share of land; height above the sea as a share of the relief.
    enum Channel : std::size_t { red, green, blue, land, elevation };

    double relief;  ///< height of elevation 1
    DisplacedSphere shape;
    CubePyramid<5> look;
    std::optional<CubePyramid<3>> touch;  ///< haptic codes as shares of 255
    double largest_height;                ///< of the relief over the shape; 0: all relief is in the shape
};

/// `finest`: the angle of the smallest pixel, radians; finer detail of a map is dropped. Refuses maps that
/// make no globe (check_globe_maps). Takes seconds for large pictures, and checks stop_requested.
Result<std::unique_ptr<const MappedGround>> map_ground(const GlobeMaps& maps, double finest, RowBands& rows);

/// Heights all over a globe, in rows from north to south, each from west to east; at the middles of their
/// cells.
struct HeightGrid {
    int width = 0, height = 0;
    std::vector<float> values{};
};

/// The smooth ground under mountains: nowhere above the heights, not even between the middles of cells, level
/// with the sea at sea, and without anything narrower than `radius` (radians, on the sphere). Each place
/// takes the lowest height within a little more than `radius`, then the mean of these within `radius`: each
/// of them is at most the height here, so their mean is, too.
HeightGrid valley_floor(const HeightGrid& heights, double radius, RowBands& rows);

}  // namespace touchable
