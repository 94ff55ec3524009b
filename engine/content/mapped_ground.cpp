// SPDX-License-Identifier: Apache-2.0
// A globe of maps: lakes, shape, colours and touch, from the maps' pixels.
#include "engine/content/mapped_ground.hpp"

#include "engine/base/try.hpp"

namespace touchable {
namespace {

/// The inverse of `evened`, 0 to 1, by Newton; `evened` rises everywhere there.
double tangent_of(double even) {
    using namespace cube_grid;
    double tangent = even;
    for (int round = 0; round < 30; ++round) {
        const double square = tangent * tangent;
        tangent -= (evened(tangent) - even) / (even_1 + square * (3 * even_3 + square * 5 * even_5));
    }
    return tangent;
}

/// The root of `gap` in [outside, inside], by false position; `gap` is above 0 outside and at most 0 inside.
/// The gap at an end that stays twice is halved (Illinois).
template <class Gap>
double crossing(double outside, double gap_outside, double inside, double gap_inside, Gap&& gap) {
    int stayed = 0;  // +: the inside, -: the outside
    for (int round = 0; round < 100 && gap_inside < 0 && inside - outside > 1e-15; ++round) {
        const double share = round < 30 ? gap_outside / (gap_outside - gap_inside) : 0.5;
        const double middle = outside + (inside - outside) * share;
        if (middle == outside || middle == inside) return middle;
        const double gap_middle = gap(middle);
        if (gap_middle > 0) {
            outside = middle;
            gap_outside = gap_middle;
            if (stayed > 0) gap_inside *= 0.5;
            stayed = 1;
        } else {
            inside = middle;
            gap_inside = gap_middle;
            if (stayed < 0) gap_outside *= 0.5;
            stayed = -1;
        }
    }
    return inside;
}

/// A row that a disc reaches, its half width there in cells (round a pole all of the row), and a cell's share
/// of the sphere's area there.
struct Reach {
    int row, half_width;
    double cell_area;
};

/// The rows of a disc around any cell of a row: the great circle from latitude a to b, c apart in longitude,
/// has the cosine sin a sin b + cos a cos b cos c.
std::vector<Reach> disc(const HeightGrid& grid, int row, double radius) {
    const double step = pi / grid.height;
    const auto latitude = [&](int r) { return 0.5 * pi - (r + 0.5) * step; };
    const int rows = static_cast<int>(radius / step);
    std::vector<Reach> reaches;
    for (int other = std::max(0, row - rows); other <= std::min(grid.height - 1, row + rows); ++other) {
        const double a = latitude(row), b = latitude(other);
        const double cosine_of_width = (cosine(radius) - sine(a) * sine(b)) / (cosine(a) * cosine(b));
        if (cosine_of_width > 1) continue;
        const double half = cosine_of_width < -1 ? pi : 0.5 * pi - arcsine(cosine_of_width);
        const int cells = static_cast<int>(half / (2 * pi) * grid.width);
        reaches.push_back({other, cells, cosine(b)});
    }
    return reaches;
}

/// Lowers `lowest` to the minimum within `half_width` of each cell of a row, round the globe: by running
/// minima, from both sides, of blocks as long as the window (van Herk), so that its length does not matter.
void lower_to_lowest_within(const float* row, int width, int half_width, float* lowest,
                            std::vector<float>& room) {
    const int window = 2 * half_width + 1, length = width + 2 * half_width;
    room.resize(2 * static_cast<std::size_t>(length));
    float *ahead = room.data(), *behind = room.data() + length;
    const auto at = [&](int k) { return row[(k - half_width + width) % width]; };
    for (int k = 0; k < length; ++k) ahead[k] = k % window == 0 ? at(k) : std::min(ahead[k - 1], at(k));
    for (int k = length - 1; k >= 0; --k)
        behind[k] = k == length - 1 || (k + 1) % window == 0 ? at(k) : std::min(behind[k + 1], at(k));
    for (int x = 0; x < width; ++x)
        lowest[x] = std::min(lowest[x], std::min(behind[x], ahead[x + window - 1]));
}

HeightGrid lowest_within(const HeightGrid& heights, double radius, RowBands& rows) {
    HeightGrid lowest = heights;
    const auto width = static_cast<std::size_t>(heights.width);
    rows.for_each_band(heights.height, 1, [&](const RowBand& band) {
        std::vector<float> room;
        for (int y = band.first; y < band.last; ++y)
            for (const Reach& reach : disc(heights, y, radius))
                lower_to_lowest_within(&heights.values[static_cast<std::size_t>(reach.row) * width],
                                       heights.width, reach.half_width,
                                       &lowest.values[static_cast<std::size_t>(y) * width], room);
    });
    return lowest;
}

/// A mean with weights that fall evenly from the middle: the mean of the means over discs of a third, two
/// thirds and all of the radius.
HeightGrid mean_within(const HeightGrid& heights, double radius, RowBands& rows) {
    HeightGrid mean = heights;
    const auto width = static_cast<std::size_t>(heights.width);
    constexpr int discs = 3;
    rows.for_each_band(heights.height, 1, [&](const RowBand& band) {
        std::vector<double> sums(3 * width + 1), total(width);
        for (int y = band.first; y < band.last; ++y) {
            std::vector<double> means(width);
            for (int k = 1; k <= discs; ++k) {
                std::fill(total.begin(), total.end(), 0.0);
                double area = 0;
                for (const Reach& reach : disc(heights, y, radius * k / discs)) {
                    const float* row = &heights.values[static_cast<std::size_t>(reach.row) * width];
                    for (std::size_t x = 0; x < 3 * width; ++x)
                        sums[x + 1] = sums[x] + double{row[x % width]};
                    const auto half = static_cast<std::size_t>(reach.half_width),
                               cells = std::min(2 * half + 1, width);  // each cell of the row once
                    for (std::size_t x = 0; x < width; ++x) {
                        const std::size_t first = width + x - half;
                        total[x] += reach.cell_area * (sums[first + cells] - sums[first]);
                    }
                    area += reach.cell_area * static_cast<double>(cells);
                }
                for (std::size_t x = 0; x < width; ++x) means[x] += total[x] / area;
            }
            float* out = &mean.values[static_cast<std::size_t>(y) * width];
            for (std::size_t x = 0; x < width; ++x) out[x] = static_cast<float>(means[x] / discs);
        }
    });
    return mean;
}

/// Adjacent water in a row; the root of connected water has its counts.
struct Run {
    int row, first, end;
    std::size_t parent;
    std::int64_t pixels, high;
};

std::size_t root_of(std::vector<Run>& runs, std::size_t run) {
    while (runs[run].parent != run) run = runs[run].parent = runs[runs[run].parent].parent;
    return run;
}

void join(std::vector<Run>& runs, std::size_t a, std::size_t b) {
    a = root_of(runs, a);
    b = root_of(runs, b);
    if (a == b) return;
    if (runs[a].pixels < runs[b].pixels) std::swap(a, b);
    runs[b].parent = a;
    runs[a].pixels += runs[b].pixels;
    runs[a].high += runs[b].high;
}

/// Adds the runs of one row; joins those that meet at the date line.
void add_runs(const GlobeMaps& maps, int y, std::vector<Run>& runs) {
    const GlobeMap &mask = maps.mask, &elevation = maps.elevation;
    const std::size_t first_of_row = runs.size();
    const auto elevation_y = static_cast<int>((y + 0.5) / mask.height * elevation.height);
    for (int x = 0; x < mask.width; ++x) {
        if (is_land(mask, maps.shore, x, y)) continue;
        if (runs.size() == first_of_row || runs.back().end < x) runs.push_back({y, x, x, runs.size(), 0, 0});
        Run& run = runs.back();
        run.end = x + 1;
        ++run.pixels;
        const auto elevation_x = static_cast<int>((x + 0.5) / mask.width * elevation.width);
        run.high += elevation.at(elevation_x, elevation_y, 0) > maps.shore.sea_level;
    }
    if (runs.size() > first_of_row && runs[first_of_row].first == 0 && runs.back().end == mask.width)
        join(runs, first_of_row, runs.size() - 1);
}

/// Returns the pixels of the mask that are lakes above the sea: connected water of which more than half is
/// above sea level. (At a coast mask and elevation differ by a pixel or two, so elevation alone does not
/// decide.) Row by row; empty if there is none.
std::vector<bool> lakes_above_sea(const GlobeMaps& maps) {
    std::vector<Run> runs;
    std::size_t above = 0;  // the first run of the row above that may touch
    for (int y = 0; y < maps.mask.height; ++y) {
        const std::size_t first = runs.size();
        add_runs(maps, y, runs);
        for (std::size_t here = first; here < runs.size(); ++here) {
            while (above < first && runs[above].end <= runs[here].first) ++above;
            for (std::size_t k = above; k < first && runs[k].first < runs[here].end; ++k) join(runs, k, here);
        }
        above = first;
    }
    std::vector<bool> lakes;
    const auto columns = static_cast<std::size_t>(maps.mask.width);
    for (std::size_t k = 0; k < runs.size(); ++k) {
        const Run &run = runs[k], &whole = runs[root_of(runs, k)];
        if (2 * whole.high <= whole.pixels) continue;
        lakes.resize(columns * static_cast<std::size_t>(maps.mask.height));
        const auto row = lakes.begin() + run.row * maps.mask.width;
        std::fill(row + run.first, row + run.end, true);
    }
    return lakes;
}

/// Reads all maps at a place.
class MapReader {
public:
    explicit MapReader(const GlobeMaps& maps)
        : maps_(maps), shore_(maps.shore), lakes_(lakes_above_sea(maps)) {}

    /// 0 to 1.
    double land(const MapPlace& place) const {
        return between_pixels(maps_.mask, place,
                              [&](int x, int y) { return is_land(maps_.mask, shore_, x, y) ? 1.0 : 0.0; });
    }
    /// Above the sea, 1 being the highest place; 0 at sea, but not on lakes.
    double elevation(const MapPlace& place) const {
        const double inland = between_pixels(maps_.mask, place, [&](int x, int y) {
            return is_land(maps_.mask, shore_, x, y) || is_lake(x, y) ? 1.0 : 0.0;
        });
        if (inland == 0) return 0;
        return inland * between_pixels(maps_.elevation, place, [&](int x, int y) {
                   const double stored = maps_.elevation.at(x, y, 0);
                   if (!std::isfinite(stored)) return 0.0;
                   return std::clamp((stored - shore_.sea_level) / (shore_.top - shore_.sea_level), 0.0, 1.0);
               });
    }
    /// Linear light, with the gamma of 2 with which pictures are written.
    double light(const MapPlace& place, int channel) const {
        const GlobeMap& map = maps_.colour;
        return between_pixels(map, place, [&](int x, int y) {
            const double value = map.at(x, y, std::min(channel, map.channels - 1)) / map.largest;
            return value * value;
        });
    }
    double haptic_code(const MapPlace& place, int channel) const {
        const GlobeMap& map = maps_.haptic;
        return between_pixels(map, place, [&](int x, int y) { return map.at(x, y, channel) / map.largest; });
    }

private:
    bool is_lake(int x, int y) const {
        return !lakes_.empty() && lakes_[pixel_place(x, y, maps_.mask.width)];
    }

    const GlobeMaps& maps_;
    const GlobeMaps::Shore& shore_;
    const std::vector<bool> lakes_;
};

/// The mean of `at(place)` over taps that stand for a cell of `cell` radians around a direction, of a map
/// whose pixels at the equator are `pixel` radians wide.
template <class At>
auto mean_over_cell(const glm::dvec3& direction, double cell, double pixel, At&& at) {
    constexpr int most = 8;
    const int taps = std::clamp(static_cast<int>(cell / pixel + 0.5), 1, most);
    if (taps == 1) return at(map_place(direction));
    const auto [across, down] = tangents(direction);
    decltype(at(MapPlace{})) sum{};
    for (int j = 0; j < taps; ++j)
        for (int i = 0; i < taps; ++i) {
            const double x = cell * ((i + 0.5) / taps - 0.5), y = cell * ((j + 0.5) / taps - 0.5);
            const auto values = at(map_place(direction + x * across + y * down));
            for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += values[c];
        }
    for (double& value : sum) value /= taps * taps;
    return sum;
}

/// Resolution of the shape: pixels around the equator, a quarter of a degree wide except for coarse maps.
int shape_pixels(const GlobeMaps& maps) {
    return std::clamp(2 * std::max(maps.elevation.width, maps.mask.width), 180, 1440);
}

/// Elevations on an even grid of the globe; for a map with finer pixels the lowest of several, so that no
/// strait is lost.
HeightGrid lowest_elevations(const GlobeMaps& maps, const MapReader& reader, RowBands& rows) {
    const int finest = std::max(maps.elevation.width, maps.mask.width);
    HeightGrid grid{shape_pixels(maps), shape_pixels(maps) / 2, {}};
    grid.values.resize(pixel_count(grid.width, grid.height));
    const int taps = std::clamp((finest + grid.width - 1) / grid.width, 1, 4);
    rows.for_each_band(grid.height, 1, [&](const RowBand& band) {
        for (int y = band.first; y < band.last; ++y)
            for (int x = 0; x < grid.width; ++x) {
                double lowest = 1;
                for (int tap = 0; tap < taps * taps; ++tap) {
                    const MapPlace place{(x + (tap % taps + 0.5) / taps) / grid.width,
                                         (y + (tap / taps + 0.5) / taps) / grid.height};
                    lowest = std::min(lowest, reader.elevation(place));
                }
                grid.values[pixel_place(x, y, grid.width)] = static_cast<float>(lowest);
            }
    });
    return grid;
}

/// The part of the relief that is in the shape.
DisplacedSphere shape_of(const GlobeMaps& maps, const MapReader& reader, RowBands& rows) {
    CubeGrid grid(128 * ((shape_pixels(maps) / 4 + 127) / 128));
    std::vector<float> rise(grid.points());
    HeightGrid floor;
    if (maps.smoothing_degrees > 0)
        floor = valley_floor(lowest_elevations(maps, reader, rows), maps.smoothing_degrees * pi / 180, rows);
    const GlobeMap smooth{{}, floor.values, floor.width, floor.height, 1};
    const int row_points = grid.cells() + 1;
    rows.for_each_band(6 * row_points, 1, [&](const RowBand& band) {
        for (int row = band.first; row < band.last; ++row)
            for (int i = 0; i < row_points; ++i) {
                const int face = row / row_points, j = row % row_points;
                const MapPlace place = map_place(grid.direction(face, i, j));
                const double elevation =
                    smooth.empty()
                        ? reader.elevation(place)
                        : between_pixels(smooth, place, [&](int x, int y) { return smooth.at(x, y, 0); });
                rise[grid.index(face, i, j)] = static_cast<float>(maps.relief * elevation);
            }
    });
    return {std::move(grid), std::move(rise), rows};
}

/// Cells along a face of the cube: as fine as the picture, but not finer than the finest map.
int cells_for(double finest_pixel, int widest_map) {
    constexpr double most = 4096;
    const double wanted = std::min({0.5 * pi / finest_pixel, widest_map / 4.0, most});
    return 16 * std::max(1, static_cast<int>(std::ceil(wanted / 16)));
}

std::optional<CubePyramid<3>> haptic_pyramid(const GlobeMaps& maps, const MapReader& reader, double finest,
                                             RowBands& rows) {
    if (maps.haptic.empty()) return std::nullopt;
    const int cells = cells_for(finest, maps.haptic.width);
    return CubePyramid<3>(cells, rows, [&, cell = CubeGrid(cells).spacing()](const glm::dvec3& direction) {
        return mean_over_cell(direction, cell, 2 * pi / maps.haptic.width, [&](const MapPlace& place) {
            return std::array{reader.haptic_code(place, 0), reader.haptic_code(place, 1),
                              reader.haptic_code(place, 2)};
        });
    });
}

/// Largest height of the relief over the shape.
double largest_over(const DisplacedSphere& shape, const CubePyramid<5>& look, int cells, double relief,
                    RowBands& rows) {
    const CubeGrid grid(cells);
    std::vector<double> largest(static_cast<std::size_t>(6 * cells));
    rows.for_each_band(6 * cells, 1, [&](const RowBand& band) {
        for (int row = band.first; row < band.last; ++row)
            for (int i = 0; i <= cells; ++i) {
                const glm::dvec3 direction = grid.direction(row / cells, i, row % cells);
                double& most = largest[static_cast<std::size_t>(row)];
                most = std::max(
                    most, relief * look.mean(direction, 0)[MappedGround::elevation] - shape.rise(direction));
            }
    });
    return *std::ranges::max_element(largest);
}

}  // namespace

MapPlace map_place(const glm::dvec3& direction) {
    const double length = std::sqrt(glm::dot(direction, direction));
    return {0.5 + arctangent2(direction.x, direction.z) / (2 * pi), 0.5 - arcsine(direction.y / length) / pi};
}

CubeGrid::CubeGrid(int cells)
    : cells_(cells),
      row_(static_cast<std::size_t>(cells) + 1),
      tangent_(static_cast<std::size_t>(cells) + 1) {
    const int half = cells / 2;
    for (int k = 0; k <= half; ++k) {
        const double tangent = k == half ? 1.0 : tangent_of(static_cast<double>(k) / half);
        tangent_[static_cast<std::size_t>(half + k)] = tangent;
        tangent_[static_cast<std::size_t>(half - k)] = -tangent;
    }
}

glm::dvec3 CubeGrid::direction(int face, int i, int j) const {
    const int axis = face / 2;
    glm::dvec3 at;
    at[axis] = face % 2 == 0 ? 1 : -1;
    at[(axis + 1) % 3] = tangent_[static_cast<std::size_t>(i)];
    at[(axis + 2) % 3] = tangent_[static_cast<std::size_t>(j)];
    return at / std::sqrt(glm::dot(at, at));
}

DisplacedSphere::DisplacedSphere(CubeGrid grid, std::vector<float> rise, RowBands& rows)
    : grid_(std::move(grid)), rise_(std::move(rise)) {
    for (const float value : rise_) highest_ = std::max<double>(highest_, value);
    const int coarse_side = grid_.cells() / 16;
    coarse_ = tiles_of(coarse_side, rows);
    fine_ = tiles_of(coarse_side / 8, rows);
    const Tiles unwidened = coarse_;
    widen(fine_, unwidened, rows);
    widen(coarse_, unwidened, rows);
}

DisplacedSphere::Bound DisplacedSphere::bound_of_cells(int face, int column, int row, int side) const {
    const auto at = [&](int i, int j) { return rise_[grid_.index(face, i, j)]; };
    Bound bound{};
    for (int j = row * side; j < (row + 1) * side; ++j)
        for (int i = column * side; i < (column + 1) * side; ++i) {
            const float a = at(i, j), b = at(i + 1, j), c = at(i, j + 1), d = at(i + 1, j + 1);
            const double across = std::max(std::fabs(b - a), std::fabs(d - c)),
                         down = std::max(std::fabs(c - a), std::fabs(d - b));
            const double steepness = std::sqrt(across * across + down * down) / grid_.least_spacing();
            bound.highest = std::max({bound.highest, a, b, c, d});
            bound.steepest = std::max(bound.steepest, static_cast<float>(1.000001 * steepness));
        }
    return bound;
}

DisplacedSphere::Tiles DisplacedSphere::tiles_of(int side, RowBands& rows) const {
    const int count = grid_.cells() / side;
    Tiles tiles{side, count, side * grid_.least_spacing()};
    const std::size_t all = tiles.index(6, 0, 0);
    tiles.middles.resize(all);
    tiles.radii.resize(all);
    tiles.bounds.resize(all);
    rows.for_each_band(6 * count, 1, [&](const RowBand& band) {
        for (int line = band.first; line < band.last; ++line)
            for (int column = 0; column < count; ++column) {
                const int face = line / count, row = line % count;
                const std::size_t tile = tiles.index(face, column, row);
                tiles.bounds[tile] = bound_of_cells(face, column, row, side);
                const int left = column * side, top = row * side;
                const glm::dvec3 middle = grid_.direction(face, left + side / 2, top + side / 2);
                double least = 1;
                for (const int i : {left, left + side})
                    for (const int j : {top, top + side})
                        least = std::min(least, glm::dot(middle, grid_.direction(face, i, j)));
                tiles.middles[tile] = middle;
                tiles.radii[tile] = 0.5 * pi - arcsine(least);
            }
    });
    return tiles;
}

/// Widens each bound to all tiles that a point within the window of its tile may lie in. Checks only tiles in
/// coarse tiles that are near enough.
void DisplacedSphere::widen(Tiles& tiles, const Tiles& coarse, RowBands& rows) const {
    const std::vector<Bound> own = tiles.bounds;
    const double widest = *std::ranges::max_element(tiles.radii),
                 widest_coarse = *std::ranges::max_element(coarse.radii);
    const auto cosine_within = [](double angle) { return angle < pi ? cosine(1.01 * angle) : -1.0; };
    const int inside = coarse.side / tiles.side;  // tiles along a coarse tile
    const auto each_in = [&](std::size_t coarse_tile, auto&& visit) {
        const int n = static_cast<int>(coarse_tile), face = n / (coarse.count * coarse.count),
                  row = n / coarse.count % coarse.count, column = n % coarse.count;
        for (int j = 0; j < inside; ++j)
            for (int i = 0; i < inside; ++i) visit(tiles.index(face, column * inside + i, row * inside + j));
    };
    rows.for_each_band(static_cast<int>(coarse.middles.size()), 1, [&](const RowBand& band) {
        for (int n = band.first; n < band.last; ++n) {
            const auto here = static_cast<std::size_t>(n);
            const double near = cosine_within(coarse.radii[here] + tiles.window + widest_coarse);
            for (std::size_t there = 0; there < coarse.middles.size(); ++there) {
                if (glm::dot(coarse.middles[here], coarse.middles[there]) < near) continue;
                each_in(here, [&](std::size_t tile) {
                    const double nearest = cosine_within(tiles.radii[tile] + tiles.window + widest);
                    each_in(there, [&](std::size_t other) {
                        if (glm::dot(tiles.middles[tile], tiles.middles[other]) < nearest) return;
                        Bound& bound = tiles.bounds[tile];
                        bound.highest = std::max(bound.highest, own[other].highest);
                        bound.steepest = std::max(bound.steepest, own[other].steepest);
                    });
                });
            }
        }
    });
}

/// s is measured along the ray from its point nearest to the middle, at distance q: the ray's distance from
/// the middle is sqrt(q^2 + s^2), which is convex, and outside the unit sphere it turns by an angle of at
/// most q ds. So the bounds say how far the ray can go without passing the surface.
std::optional<double> DisplacedSphere::first_hit(const glm::dvec3& from, const glm::dvec3& ray) const {
    const double to_nearest = -glm::dot(from, ray);
    const glm::dvec3 nearest = from + to_nearest * ray;
    const double q_square = glm::dot(nearest, nearest), q = std::sqrt(q_square);
    const double outermost = 1 + highest_;
    if (q >= outermost) return std::nullopt;
    // Where the ray enters a sphere of this radius, which it must meet.
    const auto entry = [&](double radius) { return -std::sqrt(radius * radius - q_square); };
    const auto distance_at = [&](double s) { return std::sqrt(q_square + s * s); };
    const auto gap_at = [&](double s) { return distance_at(s) - 1 - rise(nearest + s * ray); };
    const bool meets_inner = q < 1;
    const double end = meets_inner ? entry(1) : -entry(outermost);

    constexpr double unknown = -1;
    double s = entry(outermost), before = s, gap_before = unknown;
    const auto root_up_to = [&](double inside, double gap) {
        if (gap_before == unknown) gap_before = gap_at(before);
        return to_nearest + (gap_before > 0 ? crossing(before, gap_before, inside, gap, gap_at) : before);
    };
    while (s < end) {
        const double distance = distance_at(s);
        const CubePlace place = grid_.place(nearest + s * ray);
        const Bound& far_bound = coarse_.at(place);
        const bool is_far = distance > 1.0 + far_bound.highest;
        const Bound& bound = is_far ? far_bound : fine_.at(place);
        const double top = 1.0 + bound.highest;
        double next = s + (is_far ? coarse_ : fine_).window / std::max(q, 1e-9);
        double gap = unknown;
        if (const double enters = s < 0 && q < top ? entry(top) : end; distance > top && enters > s) {
            next = std::min(next, enters);
        } else {
            gap = distance - 1 - rise_at(place);
            if (gap <= 0) return s == before ? to_nearest + s : root_up_to(s, gap);
            const double climbing = bound.steepest * q, falling = -s / distance;
            // Over level ground the ray would meet the surface there; a little beyond may be inside.
            const double beyond = falling > 0 ? s + 1.25 * gap / falling : end;
            if (beyond < std::min(next, end) && -beyond / distance_at(beyond) > climbing)
                if (const double inside = gap_at(beyond); inside <= 0)  // there is one crossing at most
                    return to_nearest + crossing(s, gap, beyond, inside, gap_at);
            if (climbing + falling > 0) next = std::min(next, s + gap / (climbing + falling));
        }
        before = s;
        gap_before = gap;
        s = std::max(next, s + least_step);
    }
    if (!meets_inner) return std::nullopt;
    const double inside = -rise(nearest + end * ray);
    return inside == 0 ? to_nearest + end : root_up_to(end, inside);
}

HeightGrid valley_floor(const HeightGrid& heights, double radius, RowBands& rows) {
    // A little more than the mean's reach, so that the floor stays below the heights between cells, too.
    const double margin = 1.5 * pi / heights.height;
    HeightGrid floor = mean_within(lowest_within(heights, radius + margin, rows), radius, rows);
    // Removes what rounding and the last cell of a disc leave above the heights.
    for (std::size_t n = 0; n < floor.values.size(); ++n)
        floor.values[n] = std::clamp(floor.values[n], 0.0F, heights.values[n]);
    return floor;
}

Result<std::unique_ptr<const MappedGround>> map_ground(const GlobeMaps& maps, double finest, RowBands& rows) {
    TRY(check_globe_maps(maps));
    const MapReader reader(maps);
    DisplacedSphere shape = shape_of(maps, reader, rows);
    if (stop_requested()) return interrupted_error();

    const int widest = std::max({maps.colour.width, maps.elevation.width, maps.mask.width});
    const int cells = cells_for(finest, widest);
    CubePyramid<5> look(cells, rows, [&, cell = CubeGrid(cells).spacing()](const glm::dvec3& direction) {
        return mean_over_cell(direction, cell, 2 * pi / widest, [&](const MapPlace& place) {
            return std::array{reader.light(place, 0), reader.light(place, 1), reader.light(place, 2),
                              reader.land(place), reader.elevation(place)};
        });
    });
    if (stop_requested()) return interrupted_error();
    const double largest =
        maps.smoothing_degrees > 0 ? largest_over(shape, look, cells, maps.relief, rows) : 0;
    return std::make_unique<const MappedGround>(MappedGround{
        maps.relief, std::move(shape), std::move(look), haptic_pyramid(maps, reader, finest, rows), largest});
}

}  // namespace touchable
