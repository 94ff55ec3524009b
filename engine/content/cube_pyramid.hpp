#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <utility>
#include <vector>

#include "engine/base/row_bands.hpp"
#include "engine/content/cube_grid.hpp"

namespace touchable {

/// Two unit vectors that are square to a unit vector and to each other, without a pole where they are not
/// there (Duff et al., Building an Orthonormal Basis, Revisited).
inline std::pair<glm::dvec3, glm::dvec3> tangents(const glm::dvec3& n) {
    const double sign = n.z < 0 ? -1.0 : 1.0, a = -1 / (sign + n.z), b = n.x * n.y * a;
    return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

/// Values on a globe, 0 to 1, in several channels, and the same ever coarser: what is seen from afar is a
/// mean, so that it does not shimmer. Directions are in the globe's own frame, of any length but 0.
template <std::size_t channels>
class CubePyramid {
public:
    using Values = std::array<double, channels>;

    /// `values(direction)` for unit vectors is the mean of what lies within about a cell, by threads that
    /// share the rows.
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
    /// The same of one channel.
    double mean(const glm::dvec3& direction, double width, std::size_t channel) const {
        const Detail detail = detail_of(width);
        const double fine = between(levels_[detail.finer], direction, channel);
        if (detail.coarser_share == 0) return fine;
        const double coarse = between(levels_[detail.finer + 1], direction, channel);
        return fine + detail.coarser_share * (coarse - fine);
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
        double coarser_share;  ///< 0 to 1 of the next level
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
    static double between(const Level& level, const glm::dvec3& direction, std::size_t channel) {
        return level.grid.between(level.grid.place(direction), [&](std::size_t n) {
            return static_cast<double>(level.points[n][channel]);
        }) / unit;
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

    /// Level n is the mean over 2^n cells of level 0; between them linear in the width.
    Detail detail_of(double width) const {
        double cells = width / levels_.front().grid.spacing();
        std::size_t finer = 0;
        for (; cells >= 2 && finer + 1 < levels_.size(); ++finer) cells *= 0.5;
        if (finer + 1 == levels_.size()) return {finer, 0};
        return {finer, std::clamp(cells - 1, 0.0, 1.0)};
    }

    std::vector<Level> levels_;
};

}  // namespace touchable
