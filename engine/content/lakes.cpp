#include "engine/content/lakes.hpp"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>

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

}  // namespace

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

}  // namespace touchable
