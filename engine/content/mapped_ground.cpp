#include "engine/content/mapped_ground.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "engine/base/stop_request.hpp"
#include "engine/base/trigonometry.hpp"
#include "engine/base/try.hpp"
#include "engine/content/valley_floor.hpp"

namespace touchable {
namespace {

/// Water side by side in a row, and what of connected water is counted at its root.
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

/// Of one row; across the date line they are one.
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

/// Which pixels of the mask are lakes above the sea: connected water of which more than half is above sea
/// level. (At a coast mask and elevation differ by a pixel or two, so elevation alone does not tell.) Row by
/// row; empty where there is none.
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

/// What the maps say of a place, together.
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
    /// Linear light, by the same gamma of 2 by which pictures are written.
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
        return !lakes_.empty() &&
               lakes_[static_cast<std::size_t>(y) * static_cast<std::size_t>(maps_.mask.width) +
                      static_cast<std::size_t>(x)];
    }

    const GlobeMaps& maps_;
    const Shore& shore_;
    const std::vector<bool> lakes_;
};

/// The mean of `sum(place)` over taps that stand for a cell of `cell` radians around a direction, of a map
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

/// How fine the shape is: its pixels around the equator, a quarter of a degree wide for all but coarse maps.
int shape_pixels(const GlobeMaps& maps) {
    return std::clamp(2 * std::max(maps.elevation.width, maps.mask.width), 180, 1440);
}

/// Elevations at even places of the globe, of a map with finer pixels the lowest of several, so that no
/// strait is lost.
HeightGrid lowest_elevations(const GlobeMaps& maps, const MapReader& reader, RowBands& rows) {
    const int finest = std::max(maps.elevation.width, maps.mask.width);
    HeightGrid grid{shape_pixels(maps), shape_pixels(maps) / 2, {}};
    grid.values.resize(static_cast<std::size_t>(grid.width) * static_cast<std::size_t>(grid.height));
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
                grid.values[static_cast<std::size_t>(y) * static_cast<std::size_t>(grid.width) +
                            static_cast<std::size_t>(x)] = static_cast<float>(lowest);
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

/// How far the relief is over the shape at most.
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
                    most, relief * look.mean(direction, 0, MappedGround::elevation) - shape.rise(direction));
            }
    });
    return *std::max_element(largest.begin(), largest.end());
}

}  // namespace

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
